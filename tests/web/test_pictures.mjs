// How the page looks in twenty states, compared with small grey pictures of them (states.json: 40 x 30 means of brightness each).
// Leaves to others: where each field lies (test_sizes.mjs), what is said to those who only listen (test_words.mjs).
// Invariant: tolerant of fonts, not of parts: a state whose stage is hidden is refused, and each state is nearest to its own
// picture. `PICTURES=write tests/rules/web.sh build/release test_pictures` writes the pictures anew, to be looked at first.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { IN_FIREFOX } from "./bidi.mjs";
import { openDrawer } from "./drawers.mjs";
import { PAPER, close, drawn, moving } from "./rig.mjs";

export const rig = { store: true, sources: false };

const FILE = new URL("states.json", import.meta.url);
const [ACROSS, DOWN] = [40, 30];
const MOST = 4; // mean difference of brightness, of 255
const [WIDE, PHONE, paper] = [{ width: 1366, height: 768 }, { width: 390, height: 664, touch: true, isMobile: true }, { path: PAPER }];
const drawer = (id) => (page) => openDrawer(page, id);
const examples = (page) => page.waitForSelector("[data-preset=mobile]");

/** Each state: the options of its page, and how it is come to. */
const STATES = {
  first: [WIDE, examples],
  dark: [{ ...WIDE, dark: true }, examples],
  "side by side": [{ ...WIDE, path: "/?example=side-by-side" }, examples],
  arm: [{ ...WIDE, ...paper }, async (page) => { await examples(page); await page.evaluate(() => pendulumd.edits.select(2)); }],
  help: [WIDE, async (page) => { await examples(page); await page.click("[data-act=help]"); }],
  physics: [{ ...WIDE, ...paper }, drawer("physics")],
  measure: [{ ...WIDE, ...paper }, drawer("measure")],
  plots: [{ ...WIDE, ...paper }, drawer("plots")],
  modes: [{ ...WIDE, ...paper }, drawer("modes")],
  equations: [{ ...WIDE, ...paper }, async (page) => { await openDrawer(page, "equations"); await page.waitForSelector(".katex"); }],
  worksheet: [WIDE, drawer("worksheet")],
  class: [WIDE, drawer("class")],
  "large screen": [{ width: 1920, height: 1080, ...paper }, examples],
  phone: [PHONE],
  "phone, menu": [PHONE, (page) => page.click(".menu-key")],
  "phone, physics": [{ ...PHONE, ...paper }, async (page) => { await page.click(".menu-key"); await openDrawer(page, "physics"); }],
  "phone, across": [{ ...PHONE, width: 844, height: 390 }, drawer("measure")],
  tablet: [{ ...PHONE, width: 820, height: 1180 }, drawer("modes")],
  frame: [{ width: 720, height: 480, path: "/?embed=1" }],
  "small frame": [{ width: 300, height: 200, path: "/?embed=1&length=1,1&theta=120,-90" }],
};

/** The mean brightness of each cell of a screenshot, as bytes. */
async function greyOf(page) {
  const png = (await page.screenshot()).toString("base64");
  const cells = await page.evaluate(async ([letters, across, down]) => {
    const bytes = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const { width, height } = image;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const [sums, counts] = [new Float64Array(across * down), new Float64Array(across * down)];
    for (let y = 0, at = 0; y < height; y++) for (let x = 0; x < width; x++, at += 4) {
      const cell = Math.floor(y * down / height) * across + Math.floor(x * across / width);
      sums[cell] += 0.3 * data[at] + 0.59 * data[at + 1] + 0.11 * data[at + 2];
      counts[cell]++;
    }
    return [...sums].map((sum, cell) => Math.round(sum / counts[cell]));
  }, [png, ACROSS, DOWN]);
  return Buffer.from(cells);
}

const distance = (a, b) => a.reduce((sum, grey, cell) => sum + Math.abs(grey - b[cell]), 0) / a.length;

export async function twenty_states_look_as_they_did(rig) {
  if (IN_FIREFOX) return "compared in Chromium";
  const now = {};
  let hidden = null;
  for (const [name, [options, go = () => {}]] of Object.entries(STATES)) {
    const page = await rig.open({ path: "/", still: true, ...options });
    await moving(page);
    await go(page);
    await page.mouse.move(1, 1);
    await drawn(page);
    now[name] = await greyOf(page);
    if (name === "first") {
      await page.evaluate(() => { document.querySelector(".canvas").style.visibility = "hidden"; });
      hidden = await greyOf(page);
    }
    await close(page);
  }
  if (process.env.PICTURES === "write") writeFileSync(FILE, `${JSON.stringify(Object.fromEntries(Object.entries(now).map(([name, grey]) => [name, grey.toString("base64")])), null, 1)}\n`);
  const kept = Object.fromEntries(Object.entries(JSON.parse(readFileSync(FILE, "utf8"))).map(([name, letters]) => [name, Buffer.from(letters, "base64")]));
  const off = Object.entries(now).map(([name, grey]) => [name, distance(grey, kept[name])]);
  const [farthest, most] = off.reduce((a, b) => (b[1] > a[1] ? b : a));
  const bad = off.filter(([, far]) => !(far < MOST)).map(([name, far]) => `${name} is ${far.toFixed(1)} from its picture`);
  const confused = Object.entries(now).flatMap(([name, grey]) => Object.entries(kept)
    .filter(([other, picture]) => other !== name && distance(grey, picture) <= distance(grey, kept[name])).map(([other]) => `${name} looks like ${other}`));
  assert.deepEqual([...bad, ...confused], []);
  assert.ok(distance(hidden, kept.first) > 2 * most, "a pendulum that is missing is seen");
  return `the farthest, ${farthest}, is ${most.toFixed(2)} from its picture`;
}
