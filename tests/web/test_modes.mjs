// The modes: cards with the server's numbers, starts in one and in sums, the linear motion beside, the identity.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { bodiesOf } from "./bidi.mjs";
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

export async function modes_show_the_server_s_numbers_and_their_identity_and_swing_with_the_clock(rig) {
  const { page, modes } = await opened(rig);
  for (const [k, mode] of modes.mode.entries()) {
    const card = await page.innerText(`[data-mode='${mode}']`);
    for (const value of [modes.omega[k], modes.frequency[k], modes.period[k]]) assert.ok(card.includes(value.toFixed(3)), `${value} is not in ${card}`);
  }
  const words = await page.innerText(".identity");
  assert.ok(words.includes("0.56065240") || words.includes("0.5606524"), words);
  assert.ok(words.includes("5.5 m"), words);
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

/** How far the motion on the stage is from its start after so many seconds, rad. */
const missed = (page, period) => page.evaluate((time) => {
  const { motion, store } = pendulumd;
  const { phi } = motion.at(time);
  return Math.max(...store.get().initial.phi.map((angle, k) => Math.abs(phi[k] - angle)));
}, period);

export async function branches_are_drawn_with_their_stability_and_an_orbit_that_is_clicked_or_chosen_swings(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=20,10", height: 1000 });
  await openDrawer(page, "modes");
  await page.click("[data-part=branches] summary");
  await page.waitForFunction(() => /Click/.test(document.querySelector("p[data-branches=status]")?.textContent));
  const truth = await page.evaluate(async () => {
    const ask = async (mode) => (await pendulumd.client.post("/v1/orbits", { pendulum: { length: [1, 1], mass: [1, 1], parent: [0, 1] }, mode, amplitude: 120, unit: "deg", branch: true })).json();
    return [await ask(1), await ask(2)];
  });
  const lines = await page.locator("[data-part=branches] path[stroke-linejoin]").evaluateAll((list) => list.map((path) => [path.getAttribute("stroke-dasharray"), (path.getAttribute("d").match(/[ML]/g) ?? []).length]));
  const stable = truth.map((answer) => answer.stable.filter(Boolean).length);
  assert.ok(stable[1] < truth[1].stable.length, "the fast mode loses its stability");
  assert.deepEqual([lines[0], lines[2]], stable.map((count) => ["none", count]), "whole where it is stable");
  assert.ok(lines[3][0] === "5 4" && lines[3][1] > truth[1].stable.length - stable[1]);
  assert.equal(await page.locator("[data-part=branches] .fit-said li").count(), truth.reduce((sum, { bifurcations }) => sum + bifurcations.length, 0));
  // a click on the slow mode's branch: two steps from its end
  const d = await page.locator("[data-part=branches] path[stroke-linejoin]").first().getAttribute("d");
  const points = [...d.matchAll(/[ML]([\d.]+) ([\d.]+)/g)].map(([, x, y]) => [Number(x), Number(y)]);
  const at = points.length - 3;
  await page.locator("[data-part=branches] .plot").scrollIntoViewIfNeeded();
  const box = await page.locator("[data-part=branches] .plot svg").boundingBox();
  await page.mouse.click(box.x + points[at][0] + 1, box.y + points[at][1] + 1);
  await settledMotion(page);
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().initial.phi), truth[0].phi[at]);
  assert.ok(await missed(page, truth[0].period[at]) < 1e-4, "it comes back after its period");
  await page.selectOption("[data-branches=mode]", "2");
  await page.focus("input[data-branches=orbit]");
  await page.keyboard.press("Home");
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowRight");
  const words = await page.textContent("p[data-branches=orbit]");
  assert.ok(words.includes(`${(1 / truth[1].period[4]).toPrecision(5)} Hz`) && words.includes("; stable"), words);
  await page.focus("[data-branches=begin]");
  await page.keyboard.press("Enter");
  await settledMotion(page);
  assert.ok(await missed(page, truth[1].period[4]) < 1e-4);
  await page.selectOption("[data-branches=over]", "energy");
  await drawn(page);
  await page.locator("[data-part=branches]").scrollIntoViewIfNeeded();
  await rig.shot(page, "branches");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=branches]"] } }), []);
  await close(page);
}

export async function the_branch_of_a_driven_pendulum_folds_and_a_clicked_orbit_keeps_step_with_its_drive(rig) {
  const page = await rig.open({ path: "/?length=1&theta=0", height: 1000 });
  const pendulum = { length: [1], mass: [1], parent: [0], gravity: 1, damping: [0.05], torque: [{ harmonics: [{ amplitude: 0.06, omega: 0.7 }] }] };
  await page.evaluate((given) => pendulumd.store.set({ pendulum: given, initial: { phi: [-Math.PI / 2], phid: [0] } }), pendulum);
  await openDrawer(page, "modes");
  await page.click("[data-part=branches] summary");
  await page.waitForFunction(() => /Click/.test(document.querySelector("p[data-branches=status]")?.textContent));
  const truth = await page.evaluate(async (given) => {
    const ask = async (to) => (await pendulumd.client.post("/v1/orbits", { pendulum: given, settle: 50, branch: { vary: "omega", to } })).json();
    return [await ask(0.35), await ask(1.4)];
  }, pendulum);
  const folds = truth.flatMap(({ bifurcations }) => bifurcations).filter(({ kind }) => kind === "fold");
  assert.equal(folds.length, 2, "the resonance folds");
  const said = await page.locator("[data-part=branches] .fit-said li").allTextContents();
  assert.equal(said.filter((line) => line.includes("turns back")).length, 2);
  for (const { omega } of folds) {
    const shown = said.map((line) => 2 * Math.PI * Number.parseFloat(line));
    assert.ok(shown.some((value) => Math.abs(value - omega) < 0.1), `${said} tells nothing near ${omega}`);
  }
  const rows = [...truth[0].stable.slice(1).reverse(), ...truth[1].stable];
  const lines = await page.locator("[data-part=branches] path[stroke-linejoin]").evaluateAll((list) => list.map((path) => [...path.getAttribute("d").matchAll(/[ML]([\d.]+) ([\d.]+)/g)].map(([, x, y]) => [Number(x), Number(y)])));
  assert.equal(lines[0].length, rows.filter(Boolean).length, "whole where it is stable");
  assert.ok(lines[1].length > rows.length - lines[0].length && rows.includes(0), "broken between the folds");
  assert.ok(lines[1].some(([x], i) => i && x < lines[1][i - 1][0]), "and goes back there");
  assert.equal(await page.locator("[data-branches=mode], [data-branches=over]").count(), 0);
  await page.locator("[data-part=branches] .plot").scrollIntoViewIfNeeded();
  const box = await page.locator("[data-part=branches] .plot svg").boundingBox();
  const [x, y] = lines[0][3];
  await page.mouse.click(box.x + x + 1, box.y + y + 1);
  await settledMotion(page);
  const omega = await page.evaluate(() => pendulumd.store.get().pendulum.torque[0].harmonics[0].omega);
  const all = [...truth[0].omega.slice(1).reverse(), ...truth[1].omega];
  assert.ok(Math.abs(omega - all[3]) < 1e-12 * omega, `${omega} is not ${all[3]}`);
  assert.ok(await missed(page, (2 * Math.PI) / omega) < 1e-4, "it comes back after a period of its drive");
  assert.equal(await page.locator("[data-part=branches] .fit-said li").count(), said.length, "the branch stays");
  await drawn(page);
  await rig.shot(page, "branches-driven");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=branches]"] } }), []);
  await close(page);
}

export async function a_start_in_a_mode_and_in_a_sum_is_its_shape_times_its_amplitude(rig) {
  const { page, modes } = await opened(rig);
  await slide(page, 2, 30);
  await page.evaluate(() => pendulumd.clock.pause());
  await page.click("[data-start='2']");
  assert.equal(await page.evaluate(() => pendulumd.clock.playing), true, "who starts a mode sees it");
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
  await page.waitForSelector("[data-drawer=modes] .chart-area");
  await page.locator("[data-drawer=modes] .chart-area").scrollIntoViewIfNeeded();
  await drawn(page);
  await rig.shot(page, "modes-linear");
  await page.uncheck("[data-linear]");
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().ghosts.length), 0);
  await close(page);
}

export async function the_resonance_curve_is_the_server_s_and_follows_drive_and_arm(rig) {
  const page = await rig.open({ path: "/?length=1,0.5&theta=10,10", height: 1000 });
  await page.evaluate(() => {
    pendulumd.clock.pause();
    pendulumd.store.set({ pendulum: { ...pendulumd.store.get().pendulum, damping: [0.8, 0.2] } });
  });
  await openDrawer(page, "modes");
  const asked = bodiesOf(page, (one) => one.url().endsWith("/v1/response"));
  await page.click("[data-part=resonance] summary");
  await page.waitForFunction(() => document.querySelectorAll("[data-part=resonance] .plot svg").length === 2);
  assert.deepEqual(asked.map(({ drive }) => drive), [{ pivot: { x: 0.01 } }, { pivot: { x: 0.01 } }]);
  // the highest point of the curve is at the frequency at which the server's amplitude is largest
  const share = () => page.evaluate(() => {
    const plot = document.querySelector("[data-part=resonance] .plot");
    const points = [...plot.querySelector("path[stroke-linejoin]").getAttribute("d").matchAll(/([\d.]+) ([\d.]+)/g)].map(([, x, y]) => [Number(x), Number(y)]);
    const top = points.reduce((best, point) => (point[1] < best[1] ? point : best));
    return (top[0] - points[0][0]) / (points.at(-1)[0] - points[0][0]);
  });
  const truth = (body, arm) => page.evaluate(async ([request, k]) => {
    const { phi } = await (await pendulumd.client.post("/v1/response", request)).json();
    const list = phi.amplitude.map((row) => row[k]);
    return list.indexOf(Math.max(...list)) / (list.length - 1);
  }, [body, arm - 1]);
  const [seen, told] = [await share(), await truth(asked[1], 1)];
  assert.ok(Math.abs(seen - told) < 2e-3, `${seen}, not ${told}`);
  await page.locator("[data-part=resonance]").scrollIntoViewIfNeeded();
  await drawn(page);
  await rig.shot(page, "resonance");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=resonance]"] } }), []);
  await page.selectOption("select[data-resonance=drive]", "joint 2");
  await page.waitForFunction(() => /N·m/.test(document.querySelector("[data-part=resonance] .plot").textContent));
  assert.deepEqual(asked.at(-1).drive, { torque: { arm: 2, amplitude: 1 } });
  const [now, then] = [await share(), await truth(asked.at(-1), 1)];
  assert.ok(Math.abs(now - then) < 0.01, `a flat top, drawn to a tenth of a pixel: ${now}, not ${then}`);
  await close(page);
}
