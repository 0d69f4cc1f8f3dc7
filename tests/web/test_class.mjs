// A class: thirty students at one server, all at once; first each with a start of its own, then all with the same example; and
// thirty behind one address, with nginx as it is shipped before the server, a few of them in browsers.
// Leaves to others: how long that takes (bench_page.mjs).

import assert from "node:assert/strict";
import { randomBytes } from "node:crypto";
import { STUDENTS, agents, forces, motion, repeat, requestsOf, start, visit } from "./class.mjs";
import { close, startNginx } from "./rig.mjs";

export const rig = { sources: false };

const BROWSERS = 4; // of the thirty; the others ask for what those ask for
const DRAGGING = 25; // forces that a page asks for in a second while an arm is dragged

export async function thirty_students_at_once_all_get_their_motions(rig) {
  const pools = agents(STUDENTS);
  await Promise.all(pools.map((agent, i) => visit(agent, rig.url, start(i))));
  await Promise.all(pools.map((agent, i) => motion(agent, rig.url, start(100 + i))));
  await Promise.all(pools.map((agent) => motion(agent, rig.url, [0.5, 0.5, 0.5, 0.5])));
  for (const agent of pools) agent.destroy();
}

/** Waits until the motion is there. */
const alive = (page) => page.waitForFunction(() => window.pendulumd?.motion.complete, null, { polling: 200 });

/** Lets the pendulum swing, then rest: several that are drawn at once are the work of several machines. */
async function swings(page) {
  await page.evaluate(() => pendulumd.clock.play());
  await page.waitForFunction(() => pendulumd.clock.time > 0, null, { polling: 50 });
  await page.evaluate(() => pendulumd.clock.pause());
}

/** Asks for forces as dragging does, none after the other; how many answers were good. */
const drag = (page) => page.evaluate(async (count) => {
  const { length, mass, parent, gravity } = pendulumd.store.get().pendulum;
  const ask = (i) => fetch("/v1/forces", { method: "POST", headers: { "Content-Type": "application/json", Authorization: `Bearer ${localStorage.getItem("pendulumd.token")}` },
    body: JSON.stringify({ pendulum: { length, mass, parent, gravity }, state: { phi: [i / 100, 0, 0, 0], phid: [0, 0, 0, 0] } }) });
  const replies = await Promise.all(Array.from({ length: count }, (_, i) => ask(i)));
  return replies.filter(({ ok }) => ok).length;
}, DRAGGING);

/** The others of the class: each has connections and a name of its own, asks for all that a browser has asked for, and drags. */
async function others(url, requests) {
  const pools = agents(STUDENTS - BROWSERS);
  const tokens = pools.map(() => randomBytes(32).toString("base64url"));
  await Promise.all(pools.map((agent, i) => repeat(agent, url, requests, tokens[i])));
  // a request that is refused throws
  await Promise.all(pools.flatMap((agent, i) => Array.from({ length: DRAGGING }, (_, k) => forces(agent, url, tokens[i], start(k)))));
  for (const agent of pools) agent.destroy();
}

export async function thirty_browsers_behind_one_address_are_all_alive(rig) {
  const front = await startNginx(rig.daemon);
  if (!front) return "skipped: nginx is not installed";
  try {
    // each with a cache and a storage of its own, so that each is a first visit; the pendulum waits to be let go
    const size = { width: 480, height: 320, cold: true, wait: false, still: true };
    const first = await rig.openAt(front.url, size);
    await alive(first);
    await first.waitForFunction(() => pendulumd.client.engine.ready || !("engine" in document.documentElement.dataset));
    const requests = await requestsOf(first);
    assert.ok(requests.length >= 4 && requests.some(({ path }) => path === "/v1/trajectories"), `${requests.length} requests of a first visit`);
    const rest = others(front.url, requests);
    const pages = [first, ...await Promise.all(Array.from({ length: BROWSERS - 1 }, () => rig.openAt(front.url, size)))];
    await Promise.all(pages.map(alive));
    for (const page of pages) await swings(page);
    const [good] = await Promise.all([Promise.all(pages.map(drag)), rest]);
    assert.deepEqual(good, pages.map(() => DRAGGING), "who drags is never refused");
    const tokens = await Promise.all(pages.map((page) => page.evaluate(() => localStorage.getItem("pendulumd.token"))));
    assert.equal(new Set(tokens).size, BROWSERS, "each browser is somebody");
    for (const page of pages) await close(page);
    return `${BROWSERS} in browsers, ${STUDENTS - BROWSERS} asking what those ask, ${requests.length} requests each`;
  } finally {
    await front.stop();
  }
}
