// A server that is away, slow or refuses: the page says so in words, and goes on when it is over.

import assert from "node:assert/strict";
import { close, moving } from "./rig.mjs";

const FORGIVEN = /Failed to load resource|net::ERR/;

/**
 * A page whose next requests for motions end so, answer(reply, asked, times); over() ends the trouble.
 * It is narrow, so that nobody but the stage asks: on a wide one the examples' pictures do.
 */
async function troubled(rig, answer) {
  const page = await rig.open({ width: 800 });
  await page.waitForFunction(() => pendulumd.motion.stats);
  page.forgiven.push(FORGIVEN);
  let times = 0;
  rig.front.fault = (asked, reply) => {
    if (!asked.url.startsWith("/v1/traj")) return false;
    answer(reply, asked, ++times);
    return true;
  };
  return { page, over: () => { rig.front.fault = null; }, times: () => times };
}

const problem = (status, retry) => (reply) => {
  reply.writeHead(status, { "Content-Type": "application/problem+json", "Retry-After": String(retry) });
  reply.end(JSON.stringify({ type: "about:blank", title: "Busy", status, detail: "no room" }));
};

// while it asks again, the page says that; so the words are waited for
const told = (page, words, kind = ".bad") => page.waitForFunction(
  ([where, source]) => new RegExp(source).test(document.querySelector(where)?.textContent ?? ""),
  [`.notice${kind}:not([hidden]) span`, words.source]);
const change = (page) => page.evaluate(() => pendulumd.edits.setMass(2, 3));

async function refusesAndRecovers(rig, status) {
  const refuse = problem(status, 1);
  let [first, waited, second] = [0, 0, null];
  // refused at once; the second time when the page has been looked at
  const { page, over, times } = await troubled(rig, (reply, _, time) => {
    if (time === 1) {
      first = performance.now();
      refuse(reply);
    } else {
      waited = performance.now() - first;
      second = reply;
    }
  });
  await change(page);
  await told(page, /busy and asks to wait.*[12] s/);
  while (!second) await page.waitForTimeout(20);
  await told(page, /busy and asks to wait.*[12] s/);
  await rig.shot(page, `refused_${status}`);
  assert.ok(times() === 2 && waited > 990, `it waits a second as it was told: ${times()} requests, ${waited} ms apart`);
  over();
  refuse(second);
  await moving(page);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function a_server_over_quota_is_waited_for(rig) { await refusesAndRecovers(rig, 429); }
export async function a_server_without_room_is_waited_for(rig) { await refusesAndRecovers(rig, 503); }

export async function a_server_that_is_away_is_missed_and_found_again(rig) {
  const { page, over, times } = await troubled(rig, (reply) => reply.destroy());
  await change(page);
  await told(page, /does not answer/);
  await rig.shot(page, "away");
  const before = times();
  await page.click(".notice button");
  while (times() === before) await page.waitForTimeout(20);
  over();
  await page.evaluate(() => pendulumd.client.hurry());
  await moving(page);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function an_answer_that_breaks_off_is_told_and_asked_for_again(rig) {
  const { page, over } = await troubled(rig, (reply, asked) => asked.resume().on("end", () => {
    reply.writeHead(200, { "Content-Type": "application/octet-stream", "X-Columns": "t,phi[4],phid[4],lambda[4],energy_kinetic,energy_potential,energy_total" });
    reply.write(Buffer.alloc(1600), () => reply.socket.end());
  }));
  await change(page);
  await told(page, /broke off/);
  over();
  await page.click(".notice button");
  await moving(page);
  await close(page);
}

export async function a_refusal_is_told_in_the_server_s_words_and_undone(rig) {
  const page = await rig.open();
  page.forgiven.push(FORGIVEN);
  await page.evaluate(() => pendulumd.store.set({ rtol: 5 }));
  await told(page, /rtol/);
  await rig.shot(page, "refused_422");
  await page.click(".notice button");
  await moving(page);
  assert.equal(await page.evaluate(() => pendulumd.store.get().rtol), null);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function a_slow_server_is_told_and_waited_for(rig) {
  const { page, over } = await troubled(rig, () => {});
  await change(page);
  await told(page, /Computing: 0 %/, "");
  over();
  // who changes something else does not wait for what was asked before
  await page.evaluate(() => pendulumd.edits.setMass(2, 2));
  await moving(page);
  await close(page);
}

export async function the_page_opens_although_the_server_is_busy_at_first(rig) {
  let times = 0;
  rig.front.fault = (asked, reply) => {
    if (asked.url !== "/v1/trajectories" || ++times > 2) return false;
    problem(503, 1)(reply);
    return true;
  };
  const page = await rig.open({ wait: false });
  page.forgiven.push(FORGIVEN);
  await moving(page);
  await page.waitForFunction(() => pendulumd.clock.time > 0);
  rig.front.fault = null;
  await close(page);
}
