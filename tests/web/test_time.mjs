// Time: play, pause, steps, speed, loop and the scrubber move one clock; many arms are drawn; stillness where it is wanted.

import assert from "node:assert/strict";
import { COMB } from "./comb.mjs";
import { close, drawn, moving } from "./rig.mjs";

const clock = (page) => page.evaluate(() => ({ ...pendulumd.clock }));

export async function the_time_bar_moves_the_clock(rig) {
  const page = await rig.open();
  await page.click('[data-act="play"]');
  assert.equal((await clock(page)).playing, false);
  await page.evaluate(() => pendulumd.clock.seek(5)); // it may have stopped at the end, where nothing is ahead
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
  // from the start, and to the end once more: who looks late sees it stand there already
  await page.evaluate(() => {
    window.times = [];
    pendulumd.clock.subscribe(({ time }) => window.times.push(time));
  });
  await page.click('[data-act="play"]');
  await page.waitForFunction(() => !pendulumd.clock.playing && pendulumd.clock.time === 0.5);
  assert.ok(await page.evaluate(() => window.times.some((time) => time > 0 && time < 0.4)));
  await close(page);
}

export async function the_time_bar_tells_slack_moments_and_the_end_of_trust(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => pendulumd.motion.stats?.horizon);
  const until = await page.evaluate(() => pendulumd.motion.stats.horizon);
  assert.ok(until > 8 && until < 20, `trusted until ${until}`);
  const digits = String(Number(until.toPrecision(3))); // of the double: 11.95 is below the half
  await drawn(page);
  assert.doesNotMatch(await page.textContent(".caption"), /marks/, "marks are for those who look at forces");
  await page.click('[data-act="arrows"]');
  await page.waitForFunction(() => /marks/.test(document.querySelector(".caption").textContent));
  assert.match(await page.textContent(".caption"), /marks.*shaded: not predictable after/);
  assert.ok((await page.textContent(".caption")).includes(`after ${digits} s`), await page.textContent(".caption"));
  // a pendulum of one arm on a small swing is never slack, and trusted for ever
  await page.evaluate(() => pendulumd.edits.begin());
  await page.evaluate(() => pendulumd.edits.setStart(1, "phi", -1.4));
  await page.waitForFunction(() => pendulumd.motion.stats?.horizon === 20);
  assert.equal(await page.textContent(".caption"), "");
  await close(page);
}

export async function a_long_motion_and_a_large_tree_are_hatched_too(rig) {
  const page = await rig.open();
  for (const change of [() => pendulumd.store.set({ span: { stop: 300, step: 0.01 } }),
    () => pendulumd.store.set({ pendulum: { length: Array(24).fill(0.2), mass: Array(24).fill(1), parent: Array.from({ length: 24 }, (_, k) => k), gravity: 9.81 },
      initial: { phi: Array(24).fill(0), phid: Array(24).fill(0) }, span: { stop: 20, step: 0.01 } })]) {
    await page.evaluate(change);
    await page.waitForFunction(() => pendulumd.motion.stats && pendulumd.motion.doc.span === pendulumd.store.get().span);
    const { horizon, stop } = await page.evaluate(() => ({ horizon: pendulumd.motion.stats.horizon, stop: pendulumd.motion.doc.span.stop }));
    assert.ok(horizon > 0.5 && horizon < stop / 1.2, `${horizon} of ${stop}`);
    assert.match(await page.textContent(".caption"), /shaded: not predictable after/);
  }
  await close(page);
}

export async function colours_follow_the_palette_and_arrows_appear(rig) {
  const page = await rig.open();
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(3.3); });
  await drawn(page);
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
  await drawn(page);
  assert.ok(await count("blue") > blue, "arrows add to it");
  await page.click('[data-act="palette"]');
  await drawn(page);
  await rig.shot(page, "forces");
  await close(page);
}

export async function fifty_arms_are_drawn_and_move(rig) {
  const page = await rig.open();
  await page.evaluate(COMB);
  await page.waitForFunction(() => pendulumd.motion.n === 50 && pendulumd.motion.complete && pendulumd.motion.stats);
  const picture = async (time) => {
    await page.evaluate((at) => { pendulumd.clock.pause(); pendulumd.clock.seek(at); }, time);
    await drawn(page);
    return page.evaluate(() => document.querySelector(".canvas").toDataURL());
  };
  assert.notEqual(await picture(2), await picture(2.1));
  await rig.shot(page, "fifty");
  await close(page);
}

export async function nothing_moves_by_itself_where_motion_is_unwanted(rig) {
  const page = await rig.open({ still: true });
  await drawn(page);
  assert.deepEqual(await page.evaluate(() => [pendulumd.clock.playing, pendulumd.clock.time]), [false, 0]);
  await page.click('[data-act="forward"]');
  assert.equal((await clock(page)).time, 0.02);
  await rig.shot(page, "still");
  await close(page);
}

export async function a_long_run_moves_before_it_is_whole(rig) {
  const page = await rig.open();
  // answers to the examples' pictures that are held would take all of the browser's connections
  await page.waitForFunction(() => document.querySelectorAll(".preset").length > 10 && !document.querySelector(".preset:disabled"));
  let release = null;
  const held = new Promise((resolve) => { release = resolve; });
  rig.front.fault = (asked, reply) => {
    if (asked.url !== "/v1/trajectories") return false;
    // some seconds' worth of the answer at once, the rest when it is asked for: pieces are as large as they happen to be
    let bytes = 0;
    const { write } = reply;
    reply.write = (piece, ...rest) => {
      if (bytes > 100000) return held.then(() => write.call(reply, piece, ...rest)), true;
      bytes += piece.length;
      return write.call(reply, piece, ...rest);
    };
    const { end } = reply;
    reply.end = (...rest) => { bytes > 100000 ? held.then(() => end.call(reply, ...rest)) : end.call(reply, ...rest); };
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

export async function a_page_that_is_hidden_asks_for_no_frame_and_goes_on_from_where_it_was(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => pendulumd.motion.stats && pendulumd.clock.time > 0 && document.querySelectorAll(".preset").length > 10);
  await drawn(page);
  await page.evaluate(() => {
    window.counts = { frames: 0, pictures: 0 };
    const native = window.requestAnimationFrame;
    window.requestAnimationFrame = (fn) => { window.counts.frames++; return native(fn); };
    const { clearRect } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.clearRect = function (...box) { window.counts.pictures++; return clearRect.apply(this, box); };
    window.turn = (hidden) => {
      Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
      document.dispatchEvent(new Event("visibilitychange"));
      return pendulumd.clock.time;
    };
  });
  const left = await page.evaluate(() => {
    const at = window.turn(true);
    Object.assign(window.counts, { frames: 0, pictures: 0 });
    pendulumd.clock.pause();
    pendulumd.clock.play();
    return at;
  });
  await page.waitForTimeout(500);
  assert.deepEqual(await page.evaluate(() => [window.counts, pendulumd.clock.time, pendulumd.clock.playing]), [{ frames: 1, pictures: 1 }, left, true],
    "the stage's picture of a clock that was stopped, which a browser keeps until it is seen");
  await page.evaluate(() => window.turn(false));
  await page.waitForFunction((time) => pendulumd.clock.time > time, left);
  await close(page);
}
