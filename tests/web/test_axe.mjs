// axe-core finds no violation in any view, light and dark, wide and on a phone, with the system's own colours, in another page's
// frame.
// Leaves to others: the drawers in light, dark and on a phone (test_drawers.mjs, test_physics.mjs), a room (test_room.mjs).

import assert from "node:assert/strict";
import { DRAWERS } from "../../server/web/state.js";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

async function check(rig, options, views) {
  const page = await rig.open(options);
  for (const [name, go] of views) {
    await go(page);
    await drawn(page);
    assert.deepEqual(await violations(page, { colours: options.dark }), [], `${name} ${JSON.stringify(options)}`);
  }
  await close(page);
}

const plain = async (page) => {
  if (page.viewportSize().width > 860) await page.waitForSelector('[data-preset="mobile"]:not([disabled])');
  await page.evaluate(() => pendulumd.clock.pause());
};
const arm = (page) => page.evaluate(() => pendulumd.edits.select(3));
const help = async (page) => {
  if (page.viewportSize().width < 560) await page.click("[data-act=more]");
  await page.click("[data-act=help]");
};

const VIEWS = [["stage", plain], ["arm", arm], ["help", help]];

export async function axe_finds_nothing_in_the_light(rig) { await check(rig, {}, VIEWS); }
export async function axe_finds_nothing_in_the_dark(rig) { await check(rig, { dark: true }, VIEWS); }
export async function axe_finds_nothing_on_a_phone(rig) {
  await check(rig, { width: 390, height: 844, touch: true, isMobile: true }, VIEWS);
}

export async function axe_finds_nothing_in_any_drawer_in_forced_colours(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=60,30", height: 1000 });
  await page.emulateMedia({ forcedColors: "active" });
  await page.evaluate(() => pendulumd.clock.pause());
  const bad = [];
  for (const id of DRAWERS) {
    const selector = await openDrawer(page, id);
    await drawn(page);
    bad.push(...(await violations(page, { context: { include: [selector], exclude: [".katex"] } })).map((words) => `${id}: ${words}`));
  }
  assert.deepEqual(bad, []);
  await page.emulateMedia({ forcedColors: "none" });
  await close(page);
  return `${DRAWERS.length} drawers`;
}

export async function axe_finds_nothing_in_the_embed_view(rig) {
  for (const path of ["/?embed=1&length=1&theta=60", "/?embed=1&sheet=period"]) {
    const page = await rig.open({ path, width: 900, height: 600 });
    await page.evaluate(() => pendulumd.clock.pause());
    if (path.includes("sheet")) await page.waitForSelector("#embed-sheet :is(h2, h3):visible");
    await drawn(page);
    assert.deepEqual(await violations(page), [], path);
    await close(page);
  }
}
