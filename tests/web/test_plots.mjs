// The plots follow the clock and lead it; they zoom, hide curves, and can be taken away as pictures and numbers.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { openDrawer, saved } from "./drawers.mjs";
import { ROOT, close, drawn } from "./rig.mjs";

const clockTime = (page) => page.evaluate(() => window.pendulumd.clock.time);

export async function plots_lead_the_clock_when_it_stands_and_zoom_together(rig) {
  const page = await rig.open({ height: 1800 });
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
  await page.click("text=Show all");
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
  await page.click("[data-plots=fold]");
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
  await page.click("[data-plots=fold]");
  const svg = await saved(page, "[data-save=svg]");
  const parsed = await page.evaluate((text) => {
    const picture = new DOMParser().parseFromString(text, "image/svg+xml");
    const curves = [...picture.querySelectorAll("path[fill=none]")].map((path) => path.getAttribute("d").split("L").length);
    return { broken: picture.querySelectorAll("parsererror").length, curves };
  }, svg.bytes.toString());
  assert.equal(parsed.broken, 0);
  // three energies, three times four arms, their drift and the phase portrait, each of all samples
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

/** What is seen of a linear colour without one kind of cone (Machado, Oliveira, Fernandes 2009), or with all. */
const VISION = {
  all: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  protanopia: [0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998],
  deuteranopia: [0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.01182, 0.04294, 0.968881],
  tritanopia: [1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.3039],
};
const linear = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
const times = (m, v) => [0, 3, 6].map((row) => v.reduce((sum, one, i) => sum + m[row + i] * one, 0));
/** CIE Lab of a linear colour. */
function lab(rgb) {
  const white = [0.9505, 1, 1.089];
  const xyz = times([0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505], rgb.map((v) => Math.min(1, Math.max(0, v))));
  const [x, y, z] = xyz.map((v, i) => v / white[i]).map((v) => (v > 0.008856 ? Math.cbrt(v) : 7.787 * v + 16 / 116));
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

export function arms_have_colours_that_every_kind_of_sight_tells_apart() {
  const themes = readFileSync(`${ROOT}server/web/style.css`, "utf8").split('[data-theme="dark"]').slice(0, 2);
  for (const [i, css] of themes.entries()) {
    const colours = [1, 2, 3, 4, 5, 6, 7, 8].map((arm) => new RegExp(`--arm-${arm}: (#[0-9a-f]{6})`).exec(css)[1]);
    const light = (hex) => times([0, 0, 0, 0.2126, 0.7152, 0.0722, 0, 0, 0], linear(hex))[1] + 0.05;
    const paper = light(/--paper: (#[0-9a-f]{6})/.exec(css)[1]);
    for (const hex of colours) assert.ok(Math.max(paper, light(hex)) / Math.min(paper, light(hex)) >= 3, `${hex} on the paper`);
    for (const [sight, matrix] of Object.entries(VISION)) {
      const seen = colours.map((hex) => lab(times(matrix, linear(hex))));
      seen.forEach((one, k) => seen.slice(0, k).forEach((other, j) => {
        const far = Math.hypot(...one.map((v, n) => v - other[n]));
        assert.ok(far >= (k < 4 ? 22 : 10), `theme ${i}, ${sight}: arms ${j + 1} and ${k + 1} are ${far.toFixed(1)} apart`);
      }));
    }
  }
}

/** Words of a chart's axes: numbers on the left, below, and names on the right. */
const wordsOf = (page, id) => page.evaluate((chart) => {
  const host = document.querySelector(`[data-chart=${chart}]`);
  const all = [...host.querySelectorAll("text")].map((one) => ({ words: one.textContent.replace("\u2212", "-"), end: one.closest(".curve-names") !== null,
    left: one.getAttribute("text-anchor") === "end", size: parseFloat(getComputedStyle(one).fontSize), y: Number(one.getAttribute("y")) }));
  return { left: all.filter(({ left }) => left).map(({ words }) => words), names: all.filter(({ end }) => end),
    below: all.filter(({ left, end }) => !left && !end).map(({ words }) => words), size: all[0].size, wide: host.clientWidth };
}, id);

export async function each_plot_has_its_times_round_numbers_and_names_at_the_lines_ends(rig) {
  // an arm that turns over many times beside one that swings
  const page = await rig.open({ path: "/?length=1,0.2&theta=170,100&omega=0,40", height: 1200 });
  await openDrawer(page, "plots");
  await page.waitForSelector("[data-chart=angles] .curve-names text");
  const charts = await page.locator("[data-chart]").evaluateAll((all) => all.map((one) => one.dataset.chart));
  assert.equal(charts[0], "energy", "the energies come first");
  for (const chart of charts) {
    const { left, below } = await wordsOf(page, chart);
    assert.ok(left.length >= 3, `${chart}: ${left}`);
    assert.ok(below.length >= 3 && below.at(-1).endsWith(" s"), `${chart}: ${below}`);
  }
  const angles = await wordsOf(page, "angles");
  assert.ok(angles.left.every((words) => Number(words) % 15 === 0 && Math.abs(Number(words)) <= 180), `${angles.left}`);
  assert.deepEqual(angles.names.map(({ words }) => words).sort(), ["1", "2"]);
  assert.ok(Math.abs(angles.names[0].y - angles.names[1].y) >= 10, "no name lies over another");
  await page.click("[data-plots=fold]");
  assert.ok((await wordsOf(page, "angles")).left.some((words) => Math.abs(Number(words)) >= 720), "full turns are counted where they are wanted");
  await page.click("[data-plots=large]");
  await page.waitForFunction((wide) => document.querySelector("[data-chart=energy]").clientWidth > 1.2 * wide, angles.wide);
  await drawn(page);
  const large = await wordsOf(page, "energy");
  assert.ok(large.size >= 20 && large.left.length >= 3, `${large.size} pixels`);
  assert.ok(await page.evaluate(() => document.querySelector("[data-drawer=plots]").getBoundingClientRect().right <= document.querySelector(".panels").getBoundingClientRect().right), "nothing is cut off");
  await close(page);
}

export async function two_quantities_stand_beside_the_stage_and_below_the_energies(rig) {
  const page = await rig.open({ path: "/?length=1&theta=30", width: 1366, height: 768 });
  await openDrawer(page, "plots");
  await page.waitForSelector("[data-part=any] path[fill=none]");
  assert.deepEqual(await page.locator("[data-axis]").evaluateAll((all) => all.map((one) => one.value)), ["omega_1", "theta_1"], "the phase portrait");
  const box = await page.locator("[data-part=any] .plot").boundingBox();
  assert.ok(box.y + box.height <= 768, `it ends at ${box.y + box.height}`);
  await page.selectOption("[data-axis=x]", "x_1");
  await page.selectOption("[data-axis=y]", "kinetic");
  assert.match(await page.getAttribute("[data-part=any] .plot", "aria-label"), /kinetic.* against .*x1/);
  await close(page);
}

export async function two_cursors_tell_differences_of_any_two_quantities(rig) {
  const page = await rig.open({ path: "/?length=1&theta=30", height: 1300 });
  await page.evaluate(() => pendulumd.clock.pause());
  await openDrawer(page, "plots");
  await page.click("[data-part=any] summary");
  await page.selectOption("[data-axis=x]", { label: "angle θ1 in °" });
  await page.selectOption("[data-axis=y]", { label: "angular velocity ω1 in rad/s" });
  for (const [name, time] of [["A", 0], ["B", 0.5]]) {
    await page.evaluate((at) => pendulumd.clock.seek(at), time);
    await page.click(`[data-cursor=${name}]`);
  }
  const rows = await page.locator("[data-any=values] tbody tr").evaluateAll((list) => list.map((row) => [...row.cells].map((cell) => cell.textContent.replace("−", "-"))));
  assert.deepEqual(rows.map(([name]) => name), ["now", "A", "B", "B - A"]);
  assert.deepEqual(rows[1].slice(1).map(Number), [0, 30, 0]);
  const truth = await page.evaluate(() => [pendulumd.motion.columns.phi[50] * 180 / Math.PI + 90 - 30, pendulumd.motion.columns.phid[50]]);
  rows[3].slice(2).forEach((cell, k) => assert.ok(Math.abs(Number(cell) - truth[k]) < 1e-4, `${cell}, not ${truth[k]}`));
  const box = await page.locator("[data-part=any] .plot").boundingBox();
  await page.mouse.move(box.x + 60, box.y + box.height / 2);
  const theta = await page.evaluate(() => pendulumd.motion.at(pendulumd.clock.time).phi[0] * 180 / Math.PI + 90);
  assert.ok(theta < -25, `the pointer leads the motion to ${theta}°`);
  await close(page);
}
