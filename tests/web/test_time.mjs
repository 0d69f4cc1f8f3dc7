// Time: play, pause, steps, speed, loop and the scrubber move one clock; frames come in time; stillness where it is wanted.

import assert from "node:assert/strict";
import { close, moving } from "./rig.mjs";

const clock = (page) => page.evaluate(() => ({ ...pendulumd.clock }));

export async function the_time_bar_moves_the_clock(rig) {
  const page = await rig.open();
  await page.click('[data-act="play"]');
  assert.equal((await clock(page)).playing, false);
  const { time } = await clock(page);
  await page.click('[data-act="forward"]');
  assert.ok(Math.abs((await clock(page)).time - time - 0.02) < 1e-9);
  await page.click('[data-act="back"]');
  assert.ok(Math.abs((await clock(page)).time - time) < 1e-9);
  await page.selectOption(".speed", "0.25");
  assert.equal((await clock(page)).speed, 0.25);
  const bar = await page.locator(".scrub").boundingBox();
  await page.mouse.click(bar.x + bar.width / 2, bar.y + bar.height / 2);
  assert.ok(Math.abs((await clock(page)).time - 10) < 0.3, "half of 20 s");
  await page.click('[data-act="start"]');
  assert.equal((await clock(page)).time, 0);
  await close(page);
}

export async function the_clock_loops_or_stops_at_the_end(rig) {
  const page = await rig.open();
  await page.fill(".until", "0.5");
  await page.press(".until", "Enter");
  await page.waitForFunction(() => pendulumd.motion.complete && pendulumd.clock.duration === 0.5);
  await page.evaluate(() => { pendulumd.clock.seek(0.45); pendulumd.clock.play(); });
  await page.waitForFunction(() => pendulumd.clock.time < 0.3);
  assert.equal((await clock(page)).playing, true);
  await page.click('[data-act="loop"]');
  await page.waitForFunction(() => !pendulumd.clock.playing);
  assert.equal((await clock(page)).time, 0.5);
  await page.click('[data-act="play"]');
  await page.waitForFunction(() => pendulumd.clock.time > 0 && pendulumd.clock.time < 0.4);
  await close(page);
}

export async function the_time_bar_tells_slack_moments_and_the_end_of_trust(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => pendulumd.motion.stats?.trust_until);
  const until = await page.evaluate(() => pendulumd.motion.stats.trust_until);
  assert.ok(until > 8 && until < 20, `trusted until ${until}`);
  assert.match(await page.textContent(".caption"), /ticks.*hatched/);
  // a pendulum of one arm on a small swing is never slack, and trusted for ever
  await page.evaluate(() => pendulumd.edits.begin());
  await page.evaluate(() => pendulumd.edits.setStart(1, "phi", -1.4));
  await page.waitForFunction(() => pendulumd.motion.stats?.trust_until === 20);
  assert.equal(await page.textContent(".caption"), "");
  await close(page);
}

export async function colours_follow_the_palette_and_arrows_appear(rig) {
  const page = await rig.open();
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(3.3); });
  await page.waitForTimeout(700);
  const count = (colour) => page.evaluate((wanted) => {
    const canvas = document.querySelector(".canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let found = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      if (data[i + 3] > 200 && (wanted === "blue" ? b > r + 40 && b > g + 20 : r > b + 40 && r > g + 20)) found++;
    }
    return found;
  }, colour);
  const blue = await count("blue");
  assert.ok(blue > 500, `${blue} pixels of tension`);
  await page.click('[data-act="arrows"]');
  await page.waitForTimeout(150);
  assert.ok(await count("blue") > blue, "arrows add to it");
  await page.click('[data-act="palette"]');
  await page.waitForTimeout(150);
  await rig.shot(page, "forces");
  await close(page);
}

/** A comb of 50 arms: a chain of 25 with an arm hung on each. */
const COMB = `(() => {
  const parent = [], length = [], mass = [], phi = [];
  for (let k = 0; k < 25; k++) {
    parent.push(k ? 2 * k - 1 : 0, 2 * k + 1);
    length.push(0.2, 0.3);
    mass.push(1, 0.3);
    phi.push(-0.4, -1.2);
  }
  pendulumd.store.set({ pendulum: { length, mass, parent, gravity: 9.81 }, initial: { phi, phid: phi.map(() => 0) }, preset: null,
    view: { trails: [49, 50], arrows: true, selected: 49 } });
})()`;

export async function fifty_arms_are_drawn_in_time(rig) {
  const page = await rig.open();
  await page.evaluate(COMB);
  await page.waitForFunction(() => pendulumd.motion.n === 50 && pendulumd.motion.complete && pendulumd.motion.stats);
  const session = await page.context().newCDPSession(page);
  // what the page's own thread uses of a processor, which a busy machine does not change
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const busy = async () => (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
  await page.evaluate(() => { pendulumd.clock.seek(2); pendulumd.clock.play(); });
  await page.waitForTimeout(600);
  const before = await busy();
  const gaps = await page.evaluate(() => new Promise((resolve) => {
    const times = [];
    const look = (now) => {
      times.push(now);
      times.length > 150 ? resolve(times.slice(1).map((time, i) => time - times[i])) : requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  }));
  const used = ((await busy()) - before) * 1000 / gaps.length;
  gaps.sort((a, b) => a - b);
  const median = gaps[gaps.length >> 1];
  await rig.shot(page, "fifty");
  assert.ok(used < 12, `a frame takes ${used.toFixed(1)} ms of the page's thread`);
  assert.ok(median < 17.5 || used < 8, `the median frame takes ${median.toFixed(1)} ms, ${used.toFixed(1)} ms of them computing`);
  await close(page);
  return `median frame ${median.toFixed(1)} ms, of which ${used.toFixed(1)} ms are the page's thread`;
}

export async function nothing_moves_by_itself_where_motion_is_unwanted(rig) {
  const page = await rig.open({ still: true });
  await page.waitForTimeout(300);
  assert.deepEqual(await page.evaluate(() => [pendulumd.clock.playing, pendulumd.clock.time]), [false, 0]);
  await page.click('[data-act="forward"]');
  assert.equal((await clock(page)).time, 0.02);
  await rig.shot(page, "still");
  await close(page);
}

export async function a_long_run_moves_before_it_is_whole(rig) {
  const page = await rig.open();
  let release = null;
  const held = new Promise((resolve) => { release = resolve; });
  rig.front.fault = (asked, reply) => {
    if (asked.url !== "/v1/trajectories") return false;
    // the first part of the answer at once, the rest when it is asked for
    let first = true;
    const { write } = reply;
    reply.write = (piece, ...rest) => {
      if (!first) return held.then(() => write.call(reply, piece, ...rest)), true;
      first = false;
      return write.call(reply, piece, ...rest);
    };
    const { end } = reply;
    reply.end = (...rest) => { held.then(() => end.call(reply, ...rest)); };
    return false;
  };
  await page.evaluate(() => {
    pendulumd.clock.seek(0);
    pendulumd.store.set({ span: { stop: 200, step: 0.01 } });
  });
  await page.evaluate(() => pendulumd.clock.play());
  await page.waitForFunction(() => pendulumd.motion.count > 0 && pendulumd.clock.time > 0.1);
  const seen = await page.evaluate(() => ({ complete: pendulumd.motion.complete, count: pendulumd.motion.count, total: pendulumd.motion.total }));
  assert.equal(seen.complete, false);
  assert.ok(seen.count < seen.total && seen.total === 20001);
  await page.waitForSelector(".notice:not([hidden])");
  assert.match(await page.textContent(".notice"), /Computing: \d+ %/);
  rig.front.fault = null;
  release();
  await moving(page);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}
