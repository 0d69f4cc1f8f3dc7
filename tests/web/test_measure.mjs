// Measure: the true period in two actions and beside the formula's, a stopwatch,
// arrows that are seen, a motion without end, a film.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer, saved, settledMotion } from "./drawers.mjs";
import { close, drawn, moving } from "./rig.mjs";

/** 2 K(sin(a/2)) / pi by the arithmetic-geometric mean: how much longer a swing of amplitude a is than a small one. */
function longer(a) {
  let [x, y] = [1, Math.cos(a / 2)];
  for (let turn = 0; turn < 8; turn++) [x, y] = [(x + y) / 2, Math.sqrt(x * y)];
  return 1 / x;
}
const read = async (page, id) => parseFloat((await page.textContent(`[data-read=${id}]`)).replace("−", "-"));

export async function a_period_is_read_in_two_actions(rig) {
  const page = await rig.open({ path: "/?length=1&theta=90", height: 1200 });
  let actions = 0;
  actions++;
  await page.click('[data-tab="measure"]');
  await page.waitForSelector("[data-read=longer]");
  actions++; // reading it
  const small = 2 * Math.PI * Math.sqrt(1 / 9.81);
  assert.ok(Math.abs(await read(page, "formula") - small) < 6e-5);
  const exact = small * longer(Math.PI / 2);
  assert.ok(Math.abs(await read(page, "period") - exact) < 6e-5, `${await read(page, "period")}, not ${exact}`);
  assert.ok(Math.abs(await read(page, "longer") - 18.03) < 0.011);
  assert.equal(await read(page, "amplitude"), 90);
  assert.match(await page.textContent("[data-read=swings]"), /mean of \d equal swings/);
  assert.deepEqual(await violations(page), []);
  await rig.shot(page, "measure");
  await close(page);
  return `${actions} actions; T = ${exact.toFixed(4)} s`;
}

export async function swings_that_differ_have_no_period(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=120,120" });
  await openDrawer(page, "measure");
  await page.waitForFunction(() => /^not periodic: \d+ swings of \d\.\d\d to \d\.\d\d s$/.test(document.querySelector("[data-read=period]")?.textContent ?? ""));
  assert.match(await page.textContent("[data-read=modes]"), /see Modes/);
  for (const id of ["formula", "longer", "swings"]) assert.equal(await page.$(`[data-read=${id}]`), null, `${id} of what has no period`);
  await page.evaluate(() => pendulumd.edits.setGravity(0));
  await page.waitForFunction(() => /does not pass/.test(document.querySelector("[data-read=period]")?.textContent ?? ""));
  assert.equal(await page.$("[data-read=formula]"), null);
  await close(page);
}

export async function an_arm_at_rest_has_no_period_and_one_that_turns_over_has_the_time_of_a_turn(rig) {
  const page = await rig.open({ path: "/?length=1&theta=0", height: 1200 });
  await openDrawer(page, "measure");
  assert.match(await page.textContent("[data-read=period]"), /does not pass/, "what rounding makes of an arm at rest is no swing");
  // a turn takes 4 K(k) / omega, k^2 = 4 g / (l omega^2) < 1 where it turns over
  const turn = (2 * Math.PI / 10) * longer(2 * Math.asin(Math.sqrt(4 * 9.81 / 100)));
  for (const omega of [10, -10]) {
    await page.evaluate((phid) => pendulumd.store.set({ initial: { phi: [-Math.PI / 2], phid: [phid] } }), omega);
    await moving(page);
    await page.waitForFunction(() => document.querySelector("[data-read=amplitude]")?.textContent === "goes over the top");
    assert.ok(Math.abs(await read(page, "period") - turn) < 6e-5, `${await read(page, "period")} at ${omega} rad/s, not ${turn}`);
    assert.equal(await page.locator("[data-read=longer]").count(), 0, "the formula is of small swings");
  }
  await close(page);
}

export async function a_stopwatch_runs_with_the_motion_and_over_its_loop(rig) {
  const page = await rig.open({ path: "/?length=1&theta=30&time=2" });
  await openDrawer(page, "measure");
  await page.click("[data-watch=start]");
  await page.waitForFunction(() => parseFloat(document.querySelector(".stopwatch").textContent) > 2.5);
  await page.click("[data-watch=lap]");
  await page.evaluate(() => pendulumd.clock.pause());
  const stood = await page.textContent(".stopwatch");
  await page.evaluate(() => pendulumd.clock.seek(1));
  assert.equal(await page.textContent(".stopwatch"), stood, "what is moved by hand takes no time");
  assert.ok(parseFloat(await page.textContent(".laps li")) > 2.5);
  await page.click("[data-watch=reset]");
  assert.equal(await page.textContent(".stopwatch"), "0.00 s");
  await close(page);
}

/** How many pixels of the stage have nearly the colour of a property. */
const coloured = (page, property) => page.evaluate((name) => {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const want = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const canvas = document.querySelector("#stage canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) if (want.every((value, k) => Math.abs(data[i + k] - value) < 8)) count++;
  return count;
}, property);

export async function arrows_are_seen_and_have_the_length_that_is_chosen(rig) {
  const page = await rig.open({ path: "/?length=1&theta=60" });
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0.35); });
  await openDrawer(page, "measure");
  const colours = { velocity: "--arm-3", acceleration: "--arm-4", weight: "--arm-5" };
  for (const [name, property] of Object.entries(colours)) {
    const before = await coloured(page, property);
    await page.check(`[data-vector=${name}]`);
    await drawn(page);
    const after = await coloured(page, property);
    assert.ok(after > before + 80, `${name}: ${before} pixels before, ${after} after`);
  }
  await page.check("[data-vector=force]");
  await drawn(page);
  await rig.shot(page, "vectors");
  const short = await coloured(page, "--arm-3");
  await page.locator("[data-vector=scale]").fill("1");
  await drawn(page);
  assert.ok(await coloured(page, "--arm-3") > 1.4 * short, "twice as long");
  // a scene has them
  const scene = await page.evaluate(() => pendulumd.store.get().view);
  assert.deepEqual([scene.vectors, scene.vectorScale], [["velocity", "acceleration", "weight", "force"], 2]);
  await close(page);
}

export async function an_endless_motion_goes_on_as_one(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=60,30&time=2" });
  await openDrawer(page, "measure");
  await page.check("[data-measure=endless]");
  await page.waitForFunction(() => (pendulumd.store.get().span.start ?? 0) >= 4 && pendulumd.motion.complete);
  await page.evaluate(() => pendulumd.clock.pause());
  const far = await page.evaluate(async () => {
    const { span, initial } = pendulumd.store.get();
    const body = { pendulum: pendulumd.store.get().pendulum, initial: { phi: [-Math.PI / 6, -Math.PI / 3], phid: [0, 0] }, times: [0, span.start], method: "taylor" };
    const { phi } = await pendulumd.client.trajectory(body);
    return Math.max(...phi.at(-1).map((angle, k) => Math.abs(angle - initial.phi[k])));
  });
  assert.ok(far < 1e-6, `where it has gone on it is ${far} rad from the motion in one`);
  await close(page);
}

export async function a_film_is_recorded(rig) {
  const page = await rig.open({ path: "/?length=1&theta=60" });
  await openDrawer(page, "measure");
  await page.click("[data-film=record]");
  await page.waitForTimeout(1200);
  const { name, bytes } = await saved(page, "[data-film=record]");
  assert.match(name, /^pendulum\.(webm|mp4)$/);
  const kind = name.endsWith("webm") ? bytes.subarray(0, 4).toString("hex") === "1a45dfa3" : bytes.subarray(4, 8).toString() === "ftyp";
  assert.ok(kind && bytes.length > 2000, `${bytes.length} bytes are no film`);
  await close(page);
}

export async function the_space_bar_plays_after_every_click_and_presses_what_keys_have_come_to(rig) {
  const page = await rig.open();
  await page.evaluate(() => pendulumd.edits.select(1));
  await page.click('[data-act="add"]');
  await moving(page);
  const arms = () => page.evaluate(() => pendulumd.store.get().pendulum.length.length);
  assert.equal(await arms(), 5);
  const playing = () => page.evaluate(() => pendulumd.clock.playing);
  const before = await playing();
  await page.keyboard.press(" ");
  assert.deepEqual([await arms(), await playing()], [5, !before], "it plays, and adds no arm");
  await openDrawer(page, "measure");
  await page.click("[data-measure=ruler]");
  await page.keyboard.press(" ");
  assert.deepEqual([await page.isChecked("[data-measure=ruler]"), await playing()], [true, before], "what was ticked stays ticked");
  await page.click("[data-measure=arm]");
  await page.keyboard.press("Escape");
  await page.keyboard.press(" ");
  assert.equal(await playing(), !before, "a list that was opened is left");
  await page.focus('[data-act="add"]');
  await page.keyboard.press("Tab");
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press(" ");
  assert.equal(await arms(), 6, "who has come by keys presses it");
  await close(page);
}

export async function a_period_too_short_for_the_samples_is_not_told_as_another(rig) {
  // periods of 2 ms and of 6 ms, seen every 10 ms: as others of 0.19 s and of 0.025 s
  for (const start of ["length=1e-6&theta=20", "length=1&theta=90&omega=1000"]) {
    const page = await rig.open({ path: `/?${start}` });
    await openDrawer(page, "measure");
    await page.waitForFunction(() => /too far between samples \(0\.01 s\)/.test(document.querySelector("[data-read=period]")?.textContent ?? ""));
    await close(page);
  }
}

export async function trials_by_a_button_give_gravity_and_the_exponent_of_the_length(rig) {
  const page = await rig.open({ path: "/?length=0.5&theta=50", height: 1000 });
  await openDrawer(page, "measure");
  await page.click("[data-part=trials] summary");
  await page.waitForSelector("[data-trials=add]");
  for (const [length, theta] of [[0.5, 50], [0.8, 10], [1.3, 30]]) {
    await page.evaluate(([long, angle]) => {
      pendulumd.edits.setLength(1, long);
      pendulumd.edits.setStart(1, "phi", (angle - 90) * Math.PI / 180);
    }, [length, theta]);
    await settledMotion(page);
    await page.click("[data-trials=add]");
  }
  await page.waitForSelector("[data-found=gravity]");
  const value = (name) => page.evaluate((one) => Number(document.querySelector(`[data-found=${one}]`).dataset.value), name);
  const gravity = await value("gravity");
  assert.ok(Math.abs(gravity / 9.81 - 1) < 1e-4, `the amplitude is allowed for: ${gravity}`);
  assert.equal(await page.locator("[data-part=trials] .plot svg").count(), 1);
  await page.selectOption("[data-trials=law]", "power");
  await page.waitForSelector("[data-found=exponent]");
  assert.ok(Math.abs(await value("exponent") - 0.5) < 0.03, "the power law knows nothing of amplitudes");
  // a typed number counts, an empty cell takes the row out, and what is said of too few is said
  await page.fill('[data-trial="period-1"]', "2,5");
  await page.press('[data-trial="period-1"]', "Tab");
  await page.waitForFunction(() => Number(document.querySelector("[data-found=exponent]")?.dataset.value) < 0);
  for (const row of [1, 2]) {
    await page.fill(`[data-trial="period-${row}"]`, "");
    await page.press(`[data-trial="period-${row}"]`, "Tab");
  }
  await page.waitForFunction(() => /two different/.test(document.querySelector("[data-trials=status]").textContent));
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=trials]"] } }), []);
  const wide = await page.evaluate(() => document.querySelector('[data-drawer="measure"]').scrollWidth - document.querySelector('[data-drawer="measure"]').clientWidth);
  assert.ok(wide <= 0, `${wide} pixels too wide`);
  await close(page);
}
