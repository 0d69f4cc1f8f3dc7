// Fits: a table of measurements as people have it is read, fitted, told with its errors, and set in motion.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const SHOWN = "[data-fit=answer] .fit-verdict";
const LONG = 0.62; // m
const DAMPED = 0.01; // N m s

/** Noise that is the same in every run: of about 1. */
function noise(seed) {
  let state = seed;
  const one = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648 - 0.5;
  return () => Math.sqrt(12 / 6) * (one() + one() + one() + one() + one() + one());
}

/** What the server's own motion looks like to a camera or a protractor: rows of numbers. */
async function measured(page, values) {
  const { t, phi } = await page.evaluate(([length, damping]) => pendulumd.client.trajectory({ pendulum: { length: [length], mass: [1], parent: [0], damping: [damping] },
    initial: { theta: [40], unit: "deg" }, times: { start: 0, stop: 4, step: 0.05 }, output: ["phi"] }), [LONG, DAMPED]);
  return t.map((time, i) => [time, ...values(phi[i][0])]);
}

async function opened(rig, options) {
  const page = await rig.open({ path: "/?length=0.8&theta=20", height: 1000, ...options });
  await page.evaluate(() => pendulumd.clock.pause());
  await openDrawer(page, "measure");
  return page;
}

const found = (page, id) => page.evaluate((name) => [...document.querySelectorAll(`[data-found="${name}"] td`)].slice(0, 2)
  .map((cell) => Number(cell.dataset.value)), id);

export async function a_table_of_angles_in_german_decimals_gives_length_and_friction_with_errors(rig) {
  const page = await opened(rig, { language: "de" });
  const random = noise(7);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90 + 0.2 * random()]);
  const lines = rows.map((row) => row.map((value) => value.toFixed(4).replace(".", ",")).join(";"));
  await page.click("[data-part=fits] summary");
  await page.fill(".fit-text", ["Zeit in s;Winkel θ1 in °", ...lines].join("\r\n"));
  assert.deepEqual(await page.locator("[data-column]").evaluateAll((list) => list.map(({ value }) => value)), ["t", "theta 1"]);
  await page.click("[data-fit=run]");
  await page.waitForSelector(SHOWN);
  assert.equal(await page.getAttribute(SHOWN, "data-status"), "converged");
  for (const [id, truth] of [["length 1", LONG], ["damping 1", DAMPED]]) {
    const [value, error] = await found(page, id);
    assert.ok(error > 0 && Math.abs(value - truth) < 4 * error && error < 0.1 * truth, `${id}: ${value} ± ${error}, not ${truth}`);
  }
  await page.waitForSelector("[data-fit=answer] .plot svg");
  assert.equal(await page.locator("[data-fit=answer] .plot svg").count(), 2);
  const before = await page.evaluate(() => pendulumd.store.get().pendulum);
  await page.click("[data-fit=instead]");
  await settledMotion(page);
  const [long] = await found(page, "length 1");
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().pendulum.length), [long], "the pendulum of the stage is the fitted one");
  await page.evaluate(() => pendulumd.undo());
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().pendulum), before, "undo leads back");
  await page.click("[data-fit=beside]");
  await settledMotion(page);
  const ghost = await page.evaluate(() => pendulumd.motion.ghosts[0].doc.pendulum.length);
  assert.deepEqual([ghost, await page.evaluate(() => pendulumd.store.get().pendulum.length)], [[long], before.length], "beside it swings with its own length");
  await close(page);
}

export async function tracker_s_pixels_that_another_part_hands_over_give_length_scale_and_pivot(rig) {
  for (const [name, options] of Object.entries({ light: {}, dark: { dark: true }, phone: { width: 390, height: 844, touch: true } })) {
    const page = await opened(rig, options);
    const random = noise(3);
    const rows = await measured(page, (phi) => [310 + 230 * LONG * Math.cos(phi) + random(), 95 - 230 * LONG * Math.sin(phi) + random()]);
    const csv = ["mass_A,,", "t,x,y", ...rows.map((row) => row.map((value) => value.toFixed(3)).join(","))].join("\n");
    await page.evaluate(async (text) => {
      pendulumd.store.set({ view: { drawer: null } });
      const { openMeasurements } = await import("/page/sources/drawers/fits/measurements.js");
      openMeasurements(pendulumd, text);
    }, csv);
    await page.waitForSelector("[data-fit=down]");
    assert.equal(await page.inputValue("select[data-fit=place]"), "px", "hundreds of units are no metres");
    await page.check("[data-fit=down]");
    await page.click("[data-fit=run]");
    await page.waitForSelector(SHOWN);
    assert.equal(await page.getAttribute(SHOWN, "data-status"), "converged");
    for (const [id, truth] of [["length 1", LONG], ["scale", 230], ["origin_x", 310], ["origin_y", -95]]) {
      const [value, error] = await found(page, id);
      assert.ok(error > 0 && Math.abs(value - truth) < 4 * error && error < 0.1 * Math.abs(truth), `${id}: ${value} ± ${error}, not ${truth}`);
    }
    await page.waitForSelector("[data-fit=answer] .plot svg");
    await page.evaluate(() => document.querySelector("[data-part=fits]").scrollIntoView({ block: "start" }));
    await drawn(page);
    await rig.shot(page, `fits-${name}`);
    await page.evaluate(() => document.querySelector("[data-fit=answer]").scrollIntoView({ block: "start" }));
    await drawn(page);
    await rig.shot(page, `fits-answer-${name}`);
    assert.deepEqual(await violations(page, { context: { include: ["[data-part=fits]"] } }), [], name);
    const wide = await page.evaluate(() => document.querySelector('[data-drawer="measure"]').scrollWidth - document.querySelector('[data-drawer="measure"]').clientWidth);
    assert.ok(wide <= 0, `${name}: ${wide} pixels too wide`);
    await close(page);
  }
}

export async function what_is_wrong_with_a_table_is_said_with_its_line_and_what_cannot_be_known_in_words(rig) {
  const page = await opened(rig);
  await page.click("[data-part=fits] summary");
  const said = async (words) => {
    await page.fill(".fit-text", words);
    if (await page.isVisible("[data-fit=run]")) await page.click("[data-fit=run]");
    return page.textContent("p[data-fit=status]");
  };
  await page.waitForSelector(".fit-text");
  assert.match(await said("nothing but words"), /no table/);
  assert.match(await said("t,theta_1\n0,20\n0.1,NaN\n0.2,10"), /^Line 3: “NaN”/);
  assert.match(await said("t,theta_1\n0,20\n0.2,19\n0.1,10"), /^Line 4: this time/);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90]);
  await page.fill(".fit-text", ["t\ttheta_1", ...rows.map((row) => row.join("\t"))].join("\n"));
  await page.check('[data-unknown="gravity"]');
  await page.click("[data-fit=run]");
  await page.waitForSelector(".fit-said");
  assert.match(await page.textContent(".fit-said"), /cannot tell these apart: .*Length of arm 1.*Gravity/);
  assert.match(await page.textContent('[data-found="gravity"]'), /cannot be known/);
  // what is no pendulum is said to be none, with the worst row, and the server's own words are there
  const wrong = rows.map(([t], i) => [t, ((i * 37) % 80) - 40].join("\t"));
  await page.fill(".fit-text", ["t\ttheta_1", ...wrong].join("\n"));
  await page.click("[data-fit=run]");
  await page.waitForSelector("[data-fit=message]");
  assert.match(await page.textContent("[data-fit=farthest]"), /angle θ of arm 1.*at t = [\d.]+ s/);
  assert.match(await page.textContent("[data-fit=message]"), /^In the server’s words: .*(minimum|model does not follow)/);
  // in another language all of it is still there
  await page.check('[data-unknown="gravity"]');
  await page.evaluate(() => pendulumd.speak("de"));
  await page.waitForSelector("html[lang=de]");
  await openDrawer(page, "measure");
  if (!(await page.isVisible(".fit-text"))) await page.click("[data-part=fits] summary");
  await page.waitForSelector("[data-fit=farthest]");
  assert.match(await page.textContent("[data-fit=farthest]"), /^Am weitesten daneben: .* s\.$/);
  assert.equal((await page.inputValue(".fit-text")).split("\n").length, rows.length + 1);
  assert.ok(await page.isChecked('[data-unknown="gravity"]'), "what was to be found is still ticked");
  await close(page);
}
