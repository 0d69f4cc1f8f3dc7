// The worksheet, by keyboard: each step sets the stage, and sees when it is done.

import assert from "node:assert/strict";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { close } from "./rig.mjs";

async function press(page, selector) {
  await page.focus(selector);
  await page.keyboard.press("Enter");
}

const isDone = (page, step) => page.waitForSelector(`[data-step='${step}'].done`, { state: "attached" });
const arms = (page) => page.evaluate(() => window.pendulumd.store.get().pendulum.length.length);

export async function the_worksheet_is_gone_through_by_keyboard(rig) {
  const page = await rig.open({ height: 1000 });
  await openDrawer(page, "worksheet");
  await press(page, "[data-worksheet=stage]");
  assert.equal(await arms(page), 1);
  assert.equal(await page.locator(".step-key.done").count(), 0);
  await page.evaluate(() => {
    const { store } = window.pendulumd;
    store.set({ pendulum: { ...store.get().pendulum, length: [4] } });
  });
  await isDone(page, 1);

  await press(page, "[data-worksheet=next]");
  assert.equal(await arms(page), 2);
  await page.evaluate(() => {
    const { store } = window.pendulumd;
    store.set({ pendulum: { ...store.get().pendulum, mass: [1, 0.1] } });
  });
  await isDone(page, 2);

  await press(page, "[data-worksheet=next]");
  await press(page, "[data-worksheet=open]");
  await page.waitForSelector("[data-add=off]");
  await press(page, "[data-add=off]");
  await press(page, "[data-tab=worksheet]");
  await isDone(page, 3);

  await press(page, "[data-worksheet=next]");
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().ghosts.length), 0);
  await press(page, "[data-worksheet=open]");
  await page.waitForSelector("[data-mode='2']");
  await press(page, "[data-start='2']");
  await press(page, "[data-tab=worksheet]");
  await isDone(page, 4);

  // by the arrows of the list of steps
  await page.focus("[data-step='4']");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  assert.equal(await arms(page), 4);
  await settledMotion(page);
  const pushing = await page.evaluate(() => {
    const { motion, clock } = window.pendulumd;
    const row = motion.columns.lambda.findIndex((force) => force > 0.5);
    clock.pause();
    clock.seek(motion.t[Math.floor(row / motion.n)]);
    return row;
  });
  assert.ok(pushing > 0);
  await isDone(page, 5);
  await rig.shot(page, "worksheet-done");
  // what was done stays done
  await page.reload();
  await openDrawer(page, "worksheet");
  assert.equal(await page.locator(".step-key.done").count(), 5);
  await close(page);
}

export async function a_step_is_not_done_by_setting_the_stage(rig) {
  const page = await rig.open();
  await openDrawer(page, "worksheet");
  for (const step of [1, 2, 3, 4, 5]) {
    await page.click(`[data-step='${step}']`);
    await settledMotion(page);
  }
  assert.equal(await page.locator(".step-key.done").count(), 0);
  await close(page);
}
