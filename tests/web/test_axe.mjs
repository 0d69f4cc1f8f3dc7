// axe-core finds no violation in any view, light and dark, wide and on a phone.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
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
const help = (page) => page.click('[data-act="help"]');

const VIEWS = [["stage", plain], ["arm", arm], ["help", help]];

export async function axe_finds_nothing_in_the_light(rig) { await check(rig, {}, VIEWS); }
export async function axe_finds_nothing_in_the_dark(rig) { await check(rig, { dark: true }, VIEWS); }
export async function axe_finds_nothing_on_a_phone(rig) {
  await check(rig, { width: 390, height: 844, touch: true, isMobile: true }, VIEWS);
}
