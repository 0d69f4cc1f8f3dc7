// The stage before a class and on small screens: projector, phones held across, pages enlarged four times, forced colours.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

export async function a_projector_gets_a_large_code_and_a_warning_of_this_machine_s_own_address(rig) {
  const page = await rig.open({ width: 1280, height: 800, path: "/?length=1,1&theta=90,45" });
  await openDrawer(page, "share");
  assert.match(await page.innerText("[data-drawer=share]"), /cannot reach this address/, "a link that nobody else can follow says so");
  await page.click("[data-projector=begin]");
  await page.waitForSelector(".projector .qr");
  await drawn(page);
  const qr = await page.locator(".projector .qr").boundingBox();
  // the screen's height, which is not that of the window
  assert.ok(qr.width > 0.34 * await page.evaluate(() => innerHeight), `${qr.width} pixels`);
  const stage = await page.locator("#stage").boundingBox();
  const panel = await page.locator(".projector").boundingBox();
  assert.ok(stage.x + stage.width <= panel.x, "the code lies beside the stage, not over the pendulum");
  assert.match(await page.innerText(".projector"), /length=1,1&theta=90,45[\s\S]*cannot reach this address/);
  assert.ok(await page.evaluate(() => parseFloat(getComputedStyle(document.body).fontSize)) >= 24);
  assert.equal(await page.isVisible("#drawers"), false);
  assert.deepEqual(await violations(page), []);
  await rig.shot(page, "projector-mode");
  await page.keyboard.press("Enter");
  assert.equal(await page.locator(".projector").count(), 0);
  assert.ok(await page.isVisible("#drawers"));
  await close(page);
}

export async function forced_colours_show_what_is_chosen(rig) {
  const page = await rig.open();
  await page.emulateMedia({ forcedColors: "active" });
  await openDrawer(page, "measure");
  const look = (selector) => page.evaluate((at) => { const { backgroundColor, borderTopWidth } = getComputedStyle(document.querySelector(at)); return [backgroundColor, borderTopWidth].join(); }, selector);
  assert.notEqual(await look('[data-tab="measure"]'), await look('[data-tab="plots"]'));
  assert.deepEqual(await violations(page, { shapes: true }), []);
  await rig.shot(page, "forced-colours");
  await page.emulateMedia({ forcedColors: "none" });
  await close(page);
}
