// The keyboard alone: a pendulum is walked through, turned, changed, built and played without a hand on the stage.

import assert from "node:assert/strict";
import { close, doc, drawn, moving } from "./rig.mjs";

const said = (page) => page.textContent("#live");

/** Tab until the element is focused; throws where it is never reached. */
async function tabTo(page, selector) {
  for (let i = 0; i < 60; i++) {
    await page.keyboard.press("Tab");
    if (await page.evaluate((wanted) => document.activeElement?.matches(wanted), selector)) return;
  }
  throw new Error(`the tab key does not lead to ${selector}`);
}

/** A key that is held: presses between which no time passes. */
const held = (page, key, times) => page.evaluate(([name, count]) => {
  for (let i = 0; i < count; i++) {
    document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key: name, repeat: i > 0, bubbles: true, cancelable: true }));
  }
}, [key, times]);

export async function arms_are_turned_stretched_weighed_added_and_deleted_by_keys(rig) {
  const page = await rig.open();
  await tabTo(page, '[data-arm="1"]');
  await page.keyboard.press("Tab");
  assert.equal((await doc(page)).view.selected, 2, "the tab key walks the arms");
  await page.keyboard.press(" ");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await page.focus('[data-arm="2"]');
  await held(page, "ArrowRight", 2); // one step of history; pressed at leisure they would be two
  assert.ok(Math.abs((await doc(page)).initial.phi[1] + Math.PI / 18) < 1e-12, "two times five degrees");
  assert.match(await said(page), /Arm 2 on arm 1.* 80° from the vertical/);
  await page.waitForFunction(() => pendulumd.clock.playing);
  await page.keyboard.press("Shift+ArrowUp");
  assert.equal((await doc(page)).pendulum.length[1], 1.55);
  await page.keyboard.press("+");
  assert.equal((await doc(page)).pendulum.mass[1], 1.1);
  await page.keyboard.press("a");
  const grown = await doc(page);
  assert.deepEqual(grown.pendulum.parent, [0, 1, 2, 2, 2]);
  assert.equal(grown.view.selected, 5);
  assert.equal(await page.evaluate(() => document.activeElement.dataset.arm), "5", "the focus goes to the new arm");
  await page.keyboard.press("t");
  assert.ok((await doc(page)).view.trails.includes(5));
  await rig.shot(page, "keyboard");
  await page.keyboard.press("Delete");
  assert.deepEqual((await doc(page)).pendulum.parent, [0, 1, 2, 2]);
  assert.match(await said(page), /Arm 5 deleted/);
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement.dataset.field), "length");
  await page.keyboard.type("1.7");
  await page.keyboard.press("Enter");
  assert.equal((await doc(page)).pendulum.length[1], 1.7);
  await page.keyboard.press("Escape");
  assert.equal(await page.evaluate(() => document.activeElement.dataset.arm), "2", "back to the arm");
  await page.keyboard.press("Escape");
  assert.equal((await doc(page)).view.selected, 0);
  for (let i = 0; i < 6; i++) await page.keyboard.press("Control+z");
  const { pendulum, initial } = await doc(page);
  assert.deepEqual(pendulum.length, [2, 1.5, 0.75, 1.25]);
  assert.deepEqual(initial.phi, [0, 0, 0, 0]);
  assert.match(await said(page), /Undone/);
  await moving(page);
  await close(page);
}

export async function an_example_is_chosen_and_played_by_keys(rig) {
  const page = await rig.open();
  await page.waitForSelector('[data-preset="thor"]:not([disabled])');
  await tabTo(page, '[data-tab="presets"]');
  await page.keyboard.press("ArrowDown");
  assert.equal(await page.evaluate(() => document.activeElement.dataset.tab), "physics");
  await page.keyboard.press("ArrowUp");
  await tabTo(page, '[data-preset="thor"]');
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => pendulumd.motion.n === 3 && pendulumd.motion.complete && pendulumd.clock.playing);
  await page.focus('[data-act="play"]');
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => pendulumd.clock.playing), false);
  await page.focus(".scrub");
  const before = await page.evaluate(() => { pendulumd.clock.seek(5); return pendulumd.clock.time; });
  await page.keyboard.press("ArrowRight");
  const after = await page.evaluate(() => pendulumd.clock.time);
  assert.ok(Math.abs(after - before - 0.02) < 1e-9);
  await page.keyboard.press("Home");
  assert.equal(await page.evaluate(() => pendulumd.clock.time), 0);
  await close(page);
}

export async function the_help_opens_and_closes_by_keys(rig) {
  const page = await rig.open();
  await tabTo(page, '[data-act="help"]');
  await page.keyboard.press("Enter");
  assert.ok(await page.isVisible("dialog.help"));
  await drawn(page);
  await rig.shot(page, "help");
  await page.keyboard.press("Escape");
  await page.waitForSelector("dialog.help", { state: "hidden" });
  await close(page);
}
