// A class: thirty students at one server, all at once; first each with a start of its own, then all with the same example; and
// thirty browsers behind one address, with nginx as it is shipped before the server.
// Leaves to others: how long that takes (bench_page.mjs).

import assert from "node:assert/strict";
import { STUDENTS, agents, motion, start, visit } from "./class.mjs";
import { close, startNginx } from "./rig.mjs";

export const rig = { sources: false };

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

/** Lets the pendulum swing, then rest: thirty that are drawn at once are the work of thirty machines. */
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

export async function thirty_browsers_behind_one_address_are_all_alive(rig) {
  const front = await startNginx(rig.daemon);
  if (!front) return "skipped: nginx is not installed";
  try {
    // each with a cache and a storage of its own, so that each is a first visit; the pendulum waits to be let go
    const size = { width: 480, height: 320, cold: true, wait: false, still: true };
    const pages = await Promise.all(Array.from({ length: STUDENTS }, () => rig.openAt(front.url, size)));
    await Promise.all(pages.map(alive));
    for (const page of pages) await swings(page);
    const good = await Promise.all(pages.map(drag));
    assert.deepEqual(good, pages.map(() => DRAGGING), "who drags is never refused");
    const tokens = await Promise.all(pages.map((page) => page.evaluate(() => localStorage.getItem("pendulumd.token"))));
    assert.equal(new Set(tokens).size, STUDENTS, "each browser is somebody");
    for (const page of pages) await close(page);
  } finally {
    await front.stop();
  }
}
