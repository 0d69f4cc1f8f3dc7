// Compare: ghosts and their distance; the map of flips, whose points are starts that do what their colour says.

import assert from "node:assert/strict";
import { openDrawer, saved, settledMotion } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const HANGING = -Math.PI / 2;
const TURN = 2 * Math.PI;

const OFF = 1e-4 * Math.PI / 180; // what the drawer offers, rad

export async function a_start_off_by_a_ten_thousandth_of_a_degree_parts_and_follows_the_start(rig) {
  const page = await rig.open();
  await openDrawer(page, "compare");
  await page.click("[data-add=off]");
  await settledMotion(page);
  const distance = () => page.evaluate(() => {
    const { motion } = window.pendulumd;
    const at = (time) => {
      const row = Math.round(time / 0.01) * motion.n;
      return Math.max(...Array.from({ length: motion.n }, (_, k) => Math.abs(motion.columns.phi[row + k] - motion.ghosts[0].columns.phi[row + k])));
    };
    return [at(0), at(1), at(15)];
  });
  const [start, soon, late] = await distance();
  assert.ok(Math.abs(start - OFF) < 1e-15, `${start} rad apart at the start`);
  assert.ok(soon < 1e-4 && late > 0.1, `${soon} after a second, ${late} after fifteen`);
  await page.waitForFunction(() => /More than 5° apart after \d+\.\d\d s/.test(document.querySelector("[data-drawer=compare]").innerText));
  // another start: the ghost goes with it, as far away as before
  await page.evaluate(() => window.pendulumd.store.set({ initial: { phi: [1, 1, 1, 1], phid: [0, 0, 0, 0] } }));
  await settledMotion(page);
  assert.ok(Math.abs((await distance())[0] - OFF) < 1e-15);
  await close(page);
}

export async function ghosts_have_on_the_stage_the_colours_of_their_marks(rig) {
  const page = await rig.open();
  await openDrawer(page, "compare");
  await page.evaluate(() => {
    const { store, clock } = window.pendulumd;
    const { initial } = store.get();
    clock.pause();
    store.set({ ghosts: [0.4, -0.9].map((turn) => ({ phi: initial.phi.map((phi) => phi + turn), phid: initial.phid })) });
    clock.seek(0);
  });
  await settledMotion(page);
  await drawn(page);
  const found = await page.evaluate(() => {
    const canvas = document.querySelector(".canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return [...document.querySelectorAll(".ghosts .stroke")].map((mark) => {
      const wanted = getComputedStyle(mark).borderTopColor.match(/\d+/g).map(Number);
      let count = 0;
      for (let i = 0; i < data.length; i += 4) {
        // pale: half seen through, of its own colour nevertheless
        if (data[i + 3] > 140 && data[i + 3] < 200 && wanted.every((value, c) => Math.abs(data[i + c] - value) < 4)) count++;
      }
      return { colour: wanted.join(), count };
    });
  });
  assert.ok(found.length === 2 && found[0].colour !== found[1].colour && found.every(({ count }) => count > 200), JSON.stringify(found));
  await close(page);
}

export async function a_kept_start_stays_and_is_taken_away_by_keyboard(rig) {
  const page = await rig.open();
  await openDrawer(page, "compare");
  await page.click("[data-add=keep]");
  await page.evaluate(() => window.pendulumd.store.set({ initial: { phi: [1, 1, 1, 1], phid: [0, 0, 0, 0] } }));
  await settledMotion(page);
  assert.deepEqual(await page.evaluate(() => [...window.pendulumd.motion.ghosts[0].columns.phi.slice(0, 4)]), [0, 0, 0, 0]);
  await page.focus(".ghosts button");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().ghosts.length), 0);
  assert.match(await page.innerText(".ghosts"), /None yet/);
  await close(page);
}

/** When an arm of the present motion first turns over, by its samples; null if none does. */
const firstFlip = (page) => page.evaluate(({ hanging, turn }) => {
  const { motion } = window.pendulumd;
  const round = (phi) => Math.floor((phi - hanging - Math.PI) / turn);
  for (let i = 1; i < motion.count; i++) {
    for (let k = 0; k < motion.n; k++) if (round(motion.columns.phi[i * motion.n + k]) !== round(motion.columns.phi[(i - 1) * motion.n + k])) return { time: motion.t[i], arm: k + 1 };
  }
  return null;
}, { hanging: HANGING, turn: TURN });

export async function a_point_of_the_flip_map_starts_the_motion_that_its_colour_tells(rig) {
  const page = await rig.open({ height: 1400 });
  await openDrawer(page, "compare");
  await page.selectOption("[data-map=across]", "theta3");
  await page.selectOption("[data-map=up]", "theta1");
  await page.selectOption("[data-map=count]", "60");
  await page.click("[data-map=compute]");
  await page.waitForSelector("[data-map=png]:not([hidden])");
  assert.match(await page.innerText("[data-drawer=compare]"), /3600 motions computed/);
  const map = page.locator(".map");
  for (const [across, up] of [[0.2, 0.3], [0.7, 0.85]]) {
    await drawn(page); // the map fits its place in the frame after
    await map.scrollIntoViewIfNeeded();
    const box = await map.boundingBox();
    const side = box.width - 58;
    await page.mouse.click(box.x + 48 + across * side, box.y + 8 + (1 - up) * side);
    await settledMotion(page);
    const words = await page.innerText("#map-point-flip");
    const [, arm, time] = /arm (\d+) turns over after ([\d.]+) s/.exec(words) ?? assert.fail(words);
    const flip = await firstFlip(page);
    assert.equal(flip.arm, Number(arm));
    assert.ok(Math.abs(flip.time - Number(time)) < 0.02, `${words}, but it does at ${flip.time} s`);
    const { phi } = await page.evaluate(() => window.pendulumd.store.get().initial);
    assert.equal(phi[1], 0, "an arm that is on no axis has moved");
    const angle = Math.round(Math.floor(across * 60) * 360 / 59 - 180);
    assert.ok(Math.abs((phi[2] - HANGING) * 180 / Math.PI - angle) < 6.2, words);
  }
  // the cross moves by keys, and Enter starts there
  const before = await page.evaluate(() => window.pendulumd.store.get().initial.phi);
  await map.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  const after = await page.evaluate(() => window.pendulumd.store.get().initial.phi);
  assert.ok(Math.abs(after[2] - before[2] - TURN / 59) < 1e-12 && after[0] === before[0]);
  await settledMotion(page);
  await rig.shot(page, "compare-map");
  const png = await saved(page, "[data-map=png]");
  assert.equal(png.bytes.subarray(1, 4).toString(), "PNG");
  assert.equal(png.bytes.readUInt32BE(16), 60);
  await close(page);
}

export async function a_map_can_be_stopped(rig) {
  const page = await rig.open();
  let strips = 0;
  rig.front.fault = (asked) => asked.url === "/v1/ensembles" && ++strips > 1; // the map waits for its second strip
  await openDrawer(page, "compare");
  await page.selectOption("[data-map=count]", "240");
  await page.selectOption("[data-map=duration]", "20");
  await page.click("[data-map=compute]");
  await page.waitForFunction(() => document.querySelector("[data-drawer=compare] progress").value > 0);
  await page.click("[data-map=compute]");
  await page.waitForFunction(() => document.querySelector("[data-drawer=compare]").innerText.includes("Stopped"));
  rig.front.fault = null;
  await close(page);
}
