// The plots follow the clock and lead it; they zoom, hide curves, and can be taken away as pictures and numbers.

import assert from "node:assert/strict";
import { openDrawer, saved } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const clockTime = (page) => page.evaluate(() => window.pendulumd.clock.time);

export async function plots_lead_the_clock_when_it_stands_and_zoom_together(rig) {
  const page = await rig.open({ height: 1200 });
  await openDrawer(page, "plots");
  await page.waitForSelector("[data-chart=angles] .chart-area");
  await page.evaluate(() => window.pendulumd.clock.pause());
  const box = await page.locator("[data-chart=angles] .chart-area").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 30);
  assert.ok(Math.abs(await clockTime(page) - 10) < 0.2, `hovering the middle goes to ${await clockTime(page)} s`);
  await page.mouse.move(box.x + box.width / 4, box.y + 30);
  assert.ok(Math.abs(await clockTime(page) - 5) < 0.2);
  // a drag is a zoom of all charts
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + 30, { steps: 4 });
  await page.mouse.up();
  await drawn(page);
  await page.mouse.move(box.x + 1, box.y + 30);
  assert.ok(Math.abs(await clockTime(page) - 5) < 0.2, `the zoom begins at ${await clockTime(page)} s`);
  const lowest = await page.locator("[data-chart=drift] .chart-area").boundingBox();
  await page.mouse.move(lowest.x + lowest.width - 1, lowest.y + 30);
  assert.ok(Math.abs(await clockTime(page) - 10) < 0.2, "the other charts are not zoomed");
  await page.click("text=Whole time");
  // a click stops the clock where it is
  await page.evaluate(() => window.pendulumd.clock.play());
  await page.mouse.click(box.x + box.width * 0.75, box.y + 30);
  const { time, playing } = await page.evaluate(() => ({ time: window.pendulumd.clock.time, playing: window.pendulumd.clock.playing }));
  assert.ok(!playing && Math.abs(time - 15) < 0.2);
  await close(page);
}

const ARM = "[data-drawer=plots] [data-arm='3']";

/** The curves of a chart, each as its colour and dash. */
const curvesOf = (page, id) => page.evaluate((chart) => [...document.querySelectorAll(`[data-chart=${chart}] path[fill=none]`)]
  .map((path) => `${path.getAttribute("stroke")} ${path.getAttribute("stroke-dasharray")}`), id);

export async function plots_hide_an_arm_s_curves_by_keyboard(rig) {
  const page = await rig.open({ height: 1200 });
  await openDrawer(page, "plots");
  await page.waitForSelector(ARM);
  await drawn(page);
  const before = await curvesOf(page, "angles");
  assert.equal(new Set(before).size, 4);
  await page.focus(ARM);
  await page.keyboard.press("Enter");
  assert.equal(await page.getAttribute(ARM, "aria-pressed"), "false");
  await drawn(page);
  assert.deepEqual(await curvesOf(page, "angles"), before.filter((_, k) => k !== 2));
  await close(page);
}

/** Where a chart's first curve is: the highest and the lowest point of every pixel across. */
const waysOf = (page, id) => page.evaluate((chart) => {
  const path = document.querySelector(`[data-chart=${chart}] path[fill=none]`);
  return [...path.getAttribute("d").matchAll(/([\d.-]+) ([\d.-]+)/g)].map(([, x, y]) => [Number(x), Number(y)]);
}, id);

export async function plots_draw_the_lowest_and_the_highest_sample_of_every_pixel(rig) {
  const page = await rig.open({ height: 1200 });
  await openDrawer(page, "plots");
  await page.waitForSelector("[data-chart=angles] path[fill=none]");
  await page.evaluate(() => window.pendulumd.clock.pause());
  const area = await page.locator("[data-chart=angles] .chart-area").boundingBox();
  const samples = await page.evaluate(() => {
    const { motion } = window.pendulumd;
    return Array.from({ length: motion.count }, (_, i) => motion.columns.phi[i * motion.n]);
  });
  const ways = await waysOf(page, "angles");
  assert.ok(ways.length < samples.length && ways.length >= 2 * area.width * 0.9, `${ways.length} points for ${area.width} pixels`);
  // the extremes of all samples are drawn: upwards on the screen is towards smaller numbers
  const place = (i) => Math.min(...ways.filter(([x]) => Math.abs(x - 58 - (i / (samples.length - 1)) * area.width) <= 1).map(([, y]) => y));
  assert.equal(place(samples.indexOf(Math.max(...samples))), Math.min(...ways.map(([, y]) => y)));
  // a zoom draws every sample
  await page.mouse.move(area.x + area.width / 2, area.y + 30);
  await page.mouse.down();
  await page.mouse.move(area.x + area.width * 0.55, area.y + 30, { steps: 4 });
  await page.mouse.up();
  const near = await waysOf(page, "angles");
  assert.ok(Math.abs(near.length - samples.length * 0.05) < 4, `${near.length} of ${samples.length * 0.05} samples`);
  // a double click shows all of it again
  await page.mouse.dblclick(area.x + 40, area.y + 30);
  assert.deepEqual(await waysOf(page, "angles"), ways);
  await close(page);
}

const lines = (text) => text.trimEnd().split("\n");
// without the words that may follow the numbers
const numbers = (text) => lines(text).filter((line) => !line.startsWith("# "));

export async function plots_are_saved_as_pictures_and_numbers_that_can_be_read(rig) {
  const page = await rig.open({ height: 1200 });
  await openDrawer(page, "plots");
  await page.waitForSelector("[data-save=svg]");
  const svg = await saved(page, "[data-save=svg]");
  const parsed = await page.evaluate((text) => {
    const picture = new DOMParser().parseFromString(text, "image/svg+xml");
    const curves = [...picture.querySelectorAll("path[fill=none]")].map((path) => path.getAttribute("d").split("L").length);
    return { broken: picture.querySelectorAll("parsererror").length, curves };
  }, svg.bytes.toString());
  assert.equal(parsed.broken, 0);
  // three times four arms, three energies, their drift and the phase portrait, each of all samples
  assert.deepEqual(parsed.curves, Array(17).fill(2001));
  const png = await saved(page, "[data-save=png]");
  assert.equal(png.bytes.subarray(1, 4).toString(), "PNG");
  assert.equal(png.bytes.readUInt32BE(16), 1800);
  assert.ok(png.bytes.length > 100000, `${png.bytes.length} bytes are no picture of curves`);

  const csv = await saved(page, "[data-save=csv]");
  const rows = numbers(csv.bytes.toString()).map((line) => line.split(","));
  assert.equal(rows.length, 2002);
  assert.deepEqual(rows[0].slice(0, 5), ["t", "phi_1", "phi_2", "phi_3", "phi_4"]);
  const shown = await page.evaluate(() => ({ t: window.pendulumd.motion.t[777], phi: window.pendulumd.motion.columns.phi[777 * 4 + 2] }));
  assert.equal(Number(rows[778][0]), shown.t);
  assert.equal(Number(rows[778][3]), shown.phi, "the file has other numbers than the stage");
  const npz = await saved(page, "[data-save=npz]");
  assert.equal(npz.bytes.subarray(0, 4).toString("latin1"), "PK\x03\x04");
  for (const name of ["t.npy", "phi.npy", "lambda.npy", "z.npy"]) assert.ok(npz.bytes.includes(name), `${name} is missing`);
  const mat = await saved(page, "[data-save=mat]");
  assert.equal(mat.bytes.subarray(0, 10).toString(), "MATLAB 5.0");
  await close(page);
}
