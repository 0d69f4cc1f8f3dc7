// Every drawer, for everybody: light, dark and on a phone; in English and German.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const DRAWERS = ["plots", "modes", "control", "compare", "method", "equations", "share", "worksheet"];

const SMALL = { pendulum: { length: [1, 1], mass: [1, 1], parent: [0, 1], gravity: 9.81 }, initial: { phi: [0, 0], phid: [0, 0] }, ghosts: [], preset: null,
  view: { trails: [2], selected: 0 } };

// what is to be there before it is looked at
const READY = {
  plots: ".plot[aria-label]",
  modes: "[data-mode='1'] canvas",
  control: "[data-map=compute]",
  compare: "[data-map=compute]",
  method: "[data-fact=atEnd]",
  equations: "[data-part=bbb] .katex",
  share: "svg.qr",
  worksheet: "[data-sheet=begin]",
};

async function look(rig, name, options) {
  const page = await rig.open(options);
  const bad = [];
  await page.evaluate(() => window.pendulumd.clock.pause());
  for (const id of DRAWERS) {
    // few formulas are like many, and looked through faster
    if (id === "equations") await page.evaluate((small) => window.pendulumd.store.set(small), SMALL);
    const selector = await openDrawer(page, id);
    await page.waitForSelector(`${selector} ${READY[id]}`, { state: "attached" });
    await page.evaluate((at) => document.querySelector(at).scrollIntoView({ block: "start" }), selector);
    if (id === "compare") {
      await page.selectOption("[data-drawer=compare] [data-map=count]", "60");
      await page.click("[data-add=off]");
      await page.click("[data-drawer=compare] [data-map=compute]");
      await page.waitForSelector("[data-drawer=compare] [data-map=png]:not([hidden])");
    }
    if (id === "worksheet") {
      await page.click("[data-sheet=begin]");
      await page.waitForSelector("[data-step='5']");
    }
    if (id === "method") await page.waitForSelector(".verdict");
    await drawn(page);
    await rig.shot(page, `drawer-${id}-${name}`);
    bad.push(...(await violations(page, { context: { include: [selector], exclude: [".katex"] }, colours: options.dark, shapes: options.touch })).map((words) => `${id}, ${name}: ${words}`));
    const wide = await page.evaluate((at) => document.querySelector(at).scrollWidth - document.querySelector(at).clientWidth, selector);
    const scrolled = await page.evaluate(() => (innerWidth > 860 ? document.documentElement.scrollHeight - innerHeight : 0));
    if (scrolled > 0) bad.push(`${id}, ${name}: the page is ${scrolled} pixels longer than the window`);
    if (wide > 0) bad.push(`${id}, ${name}: it is ${wide} pixels too wide`);
  }
  await close(page);
  return bad;
}

export async function drawers_are_accessible_in_light_dark_and_on_a_phone(rig) {
  const bad = [
    ...await look(rig, "light", { height: 1000 }),
    ...await look(rig, "dark", { height: 1000, dark: true, language: "de" }),
    ...await look(rig, "phone", { width: 390, height: 844, touch: true }),
  ];
  assert.deepEqual(bad, []);
}

export async function libraries_are_not_loaded_before_their_drawer_is_opened(rig) {
  const page = await rig.open();
  const loaded = () => page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name).filter((name) => name.includes("/lib/")));
  assert.deepEqual(await loaded(), []);
  await openDrawer(page, "share");
  const names = (await loaded()).map((name) => name.replace(/.*\/lib\//, ""));
  assert.ok(names.includes("qrcode.js"));
  assert.ok(!names.includes("katex.js"), "a drawer brings what is another's");
  await close(page);
}
