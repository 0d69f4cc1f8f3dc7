// The modes: cards with the server's numbers, starts in one and in sums, the linear motion beside, the identity.

import assert from "node:assert/strict";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const HANGING = -Math.PI / 2;
const DEGREE = Math.PI / 180;

async function opened(rig) {
  const page = await rig.open();
  await openDrawer(page, "modes");
  await page.waitForSelector("[data-mode='4']");
  const modes = await page.evaluate(() => window.pendulumd.client.modes({ pendulum: window.pendulumd.store.get().pendulum, normalize: "max" }));
  return { page, modes };
}

const slide = (page, mode, degrees) => page.locator(`[data-amplitude='${mode}']`).fill(String(degrees));
const theta = (page) => page.evaluate((hanging) => window.pendulumd.store.get().initial.phi.map((phi) => phi - hanging), HANGING);
const near = (list, wanted) => list.forEach((value, k) => assert.ok(Math.abs(value - wanted[k]) < 1e-12, `${list} is not ${wanted}`));

export async function modes_show_the_server_s_numbers_and_their_identity(rig) {
  const { page, modes } = await opened(rig);
  for (const [k, mode] of modes.mode.entries()) {
    const card = await page.innerText(`[data-mode='${mode}']`);
    for (const value of [modes.omega[k], modes.frequency[k], modes.period[k]]) assert.ok(card.includes(value.toFixed(3)), `${value} is not in ${card}`);
  }
  const words = await page.innerText(".identity");
  assert.ok(words.includes("0.56065240") || words.includes("0.5606524"), words);
  assert.ok(words.includes("5.5 m"), words);
  await close(page);
}

export async function a_mode_s_picture_swings_with_the_clock(rig) {
  const { page, modes } = await opened(rig);
  await page.evaluate(() => window.pendulumd.clock.pause());
  const picture = async (time) => {
    await page.evaluate((at) => window.pendulumd.clock.seek(at), time);
    await drawn(page);
    return page.evaluate(() => document.querySelector("[data-mode='1'] canvas").toDataURL());
  };
  const start = await picture(0);
  assert.notEqual(start, await picture(modes.period[0] / 4));
  assert.notEqual(start, await picture(modes.period[0] / 2));
  assert.equal(start, await picture(0));
  await close(page);
}

export async function a_start_in_a_mode_and_in_a_sum_is_its_shape_times_its_amplitude(rig) {
  const { page, modes } = await opened(rig);
  await slide(page, 2, 30);
  await page.click("[data-start='2']");
  near(await theta(page), modes.vectors[1].map((value) => 30 * DEGREE * value));
  await page.uncheck("[data-part='1']");
  await page.check("[data-part='3']");
  await slide(page, 3, 7);
  await page.click("[data-start=sum]");
  near(await theta(page), modes.vectors[1].map((value, k) => DEGREE * (30 * value + 7 * modes.vectors[2][k])));
  await page.keyboard.press("Control+z");
  near(await theta(page), modes.vectors[1].map((value) => 30 * DEGREE * value));
  await close(page);
}

export async function linear_and_full_motion_part_when_the_amplitude_is_large(rig) {
  const { page } = await opened(rig);
  await page.check("[data-linear]");
  const apart = async (degrees) => {
    await slide(page, 1, degrees);
    await page.click("[data-start='1']");
    await settledMotion(page);
    return page.evaluate(() => {
      const { motion } = window.pendulumd;
      const ghost = motion.ghosts[0].columns.phi;
      return motion.columns.phi.reduce((most, phi, i) => Math.max(most, Math.abs(phi - ghost[i])), 0);
    });
  };
  const small = await apart(1);
  const large = await apart(50);
  assert.ok(small < 0.001 && small > 0, `1 degree: ${small} rad`);
  assert.ok(large > 0.5, `50 degrees: ${large} rad`);
  await page.waitForSelector("[data-drawer=modes] .u-over");
  await page.locator("[data-drawer=modes] .u-over").scrollIntoViewIfNeeded();
  await drawn(page);
  await rig.shot(page, "modes-linear");
  await page.uncheck("[data-linear]");
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().ghosts.length), 0);
  await close(page);
}
