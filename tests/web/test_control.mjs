// The drawer Control: a feedback catches and lets go, its gains are the server's, a push by hand is brought back, the map of
// starts; and stops, friction that sticks and a torque table in Physics.

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const pendulum = (page) => page.evaluate(() => pendulumd.store.get().pendulum);
/** How far from upright the arms are at the end of the motion, rad. */
const off = (page) => page.evaluate(() => {
  const { columns, count, n } = pendulumd.motion.track;
  const last = [...columns.phi.subarray((count - 1) * n, count * n)];
  return Math.max(...last.map((phi) => Math.abs(Math.atan2(Math.sin(phi - Math.PI / 2), Math.cos(phi - Math.PI / 2)))));
});
const complete = (page) => page.waitForFunction(() => {
  const { motion, live, store } = pendulumd;
  return !live.waiting() && !motion.loading && motion.track.complete && motion.track.doc.pendulum === store.get().pendulum;
});

async function example(rig, name) {
  const page = await rig.open({ height: 1000 });
  await openDrawer(page, "control");
  await page.click(`[data-example=${name}]`);
  await page.waitForFunction(() => pendulumd.store.get().pendulum.control);
  await complete(page);
  return page;
}

export async function a_controller_catches_and_lets_go(rig) {
  const page = await example(rig, "two");
  assert.ok(await off(page) < 1e-3, "two arms are held upright");
  const { control } = await pendulum(page);
  const shown = await page.$$eval("[data-gain]", (cells) => cells.map((cell) => parseFloat(cell.textContent.replace("−", "-"))));
  const { gains } = control[0].law.feedback;
  assert.ok(shown.length === 6 && shown.every((gain, i) => Math.abs(gain - gains[i]) < 1e-3 * Math.abs(gains[i])), `${shown}: ${gains}`);
  await page.click("[data-control=act]");
  await page.waitForFunction(() => !pendulumd.store.get().pendulum.control);
  await complete(page);
  assert.ok(await off(page) > 0.5, "without it they fall");
  await close(page);
}

export async function other_weights_give_other_gains_that_act(rig) {
  const page = await example(rig, "one");
  const [before] = (await pendulum(page)).control;
  await page.fill("[data-weight=effort]", "2");
  await page.waitForFunction((old) => pendulumd.store.get().pendulum.control[0].law.feedback.gains[0] !== old, before.law.feedback.gains[0]);
  const [after] = (await pendulum(page)).control;
  assert.ok(Math.abs(after.law.feedback.gains[2]) < Math.abs(before.law.feedback.gains[2]) / 3, "a dear force is used less");
  await complete(page);
  assert.ok(await off(page) < 0.05);
  await close(page);
}

export async function a_push_by_hand_is_brought_back(rig) {
  const page = await example(rig, "one");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(5); });
  await drawn(page);
  const { x, y } = await page.evaluate(() => {
    const { left, top } = document.querySelector("#stage").getBoundingClientRect();
    const at = pendulumd.stage.tip(1);
    return { x: at.x + left, y: at.y + top };
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 10, y);
  await page.mouse.move(x + 25, y + 2);
  await page.mouse.up();
  await complete(page);
  const pushed = await page.evaluate(() => pendulumd.store.get().initial.phi[0] - Math.PI / 2);
  assert.ok(Math.abs(pushed) > 0.03, `pushed by ${pushed}`);
  assert.ok(await off(page) < 1e-3, "and brought back");
  await close(page);
}

export async function the_map_shows_which_starts_are_caught(rig) {
  const page = await example(rig, "one");
  const drawer = "[data-drawer=control]";
  await page.click(`${drawer} [data-map=compute]`);
  await page.waitForSelector(`${drawer} [data-map=png]:not([hidden])`);
  const words = async (keys) => {
    for (const key of keys) await page.press(`${drawer} canvas.map`, key);
    return page.textContent(`${drawer} .map-point`);
  };
  assert.match(await words(Array(9).fill("Shift+ArrowRight")), /caught after/, "upright is held");
  assert.match(await words([...Array(2).fill("Shift+ArrowLeft"), ...Array(3).fill("Shift+ArrowUp")]), /not caught within/);
  await close(page);
}

export async function an_arm_swings_up_and_is_caught(rig) {
  const page = await example(rig, "swing");
  assert.ok(await off(page) < 0.02);
  const { control } = await pendulum(page);
  assert.ok(control[0].law.swing_up && control[0].limit[1] === 5);
  await close(page);
  for (const [name, motor] of [["pendubot", 1], ["acrobot", 2]]) {
    const two = await example(rig, name);
    assert.ok(await off(two) < 0.02, `a motor brings the ${name} up`);
    assert.equal((await pendulum(two)).control[0].joint, motor);
    await close(two);
  }
}

export async function stops_sticking_friction_and_torque_tables_are_physics(rig) {
  const page = await rig.open({ path: "/?length=0.5&theta=60", height: 1000 });
  await openDrawer(page, "physics");
  const number = async (name, value) => {
    await page.fill(`[data-number=${name}]`, value);
    await page.press(`[data-number=${name}]`, "Enter");
    await complete(page);
  };
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await number("stopRange", "90");
  await number("restitution", "0.5");
  await number("coulomb", "0.3");
  await page.click("[data-group=motor] summary");
  await page.fill("[data-table=table]", "0 0\n1 0.5\n2 -0.5");
  await page.click("[data-use=table]");
  await page.waitForFunction(() => pendulumd.store.get().pendulum.torque);
  await complete(page);
  const { stop, friction, torque } = await pendulum(page);
  assert.ok(Math.abs(stop[0].max - Math.PI / 2) < 1e-12 && stop[0].restitution === 0.5);
  assert.deepEqual(friction, [{ torque: 0.3 }]);
  assert.deepEqual(torque[0].table, { t: [0, 1, 2], value: [0, 0.5, -0.5], hold: "linear", outside: "zero" });
  const rates = await page.evaluate(() => [...pendulumd.motion.track.columns.phid.slice(-3)]);
  assert.deepEqual(rates, [0, 0, 0], "it has come to rest");
  await openDrawer(page, "method");
  await page.waitForFunction(() => document.querySelector("[data-fact=trust]")?.textContent.includes("not estimated"));
  await close(page);
}

/** An example of the list, whole and played. */
async function chosen(page, name) {
  await openDrawer(page, "presets");
  await page.click(`[data-preset=${name}]`);
  await page.waitForFunction((which) => pendulumd.store.get().preset === which, name);
  await complete(page);
  return page.evaluate(() => ({ phi: [...pendulumd.motion.track.columns.phi], count: pendulumd.motion.track.count }));
}

export async function a_bar_comes_to_rest_on_its_stop_and_a_clock_keeps_its_swing(rig) {
  const page = await rig.open({ height: 1000 });
  const bar = await chosen(page, "bar-on-stop");
  const least = Math.min(...bar.phi.slice(0, bar.count));
  assert.ok(least > -1e-12 && Math.abs(bar.phi[bar.count - 1]) < 1e-12, `on the stop: ${least}`);
  const clock = await chosen(page, "clock");
  const swing = Math.max(...clock.phi.slice(clock.count - 400, clock.count).map((phi) => Math.abs(phi + Math.PI / 2) * 180 / Math.PI));
  assert.ok(swing > 11 && swing < 12.1, `swings by ${swing} degrees`);
  await close(page);
}

export async function a_pivot_follows_the_places_of_a_table(rig) {
  const page = await rig.open({ path: "/?length=0.5&theta=20", height: 1000 });
  await openDrawer(page, "physics");
  await page.click("[data-group=shaking] summary");
  await page.fill("[data-table=track]", "2 0 0\n3 0.1 0.2\n4 0 0");
  await page.click("[data-use=track]");
  await page.waitForFunction(() => pendulumd.store.get().pendulum.pivot);
  await complete(page);
  const { pivot } = await pendulum(page);
  assert.deepEqual(pivot.y.table, { t: [0, 1, 2], value: [0, 0.2, 0] });
  const places = [];
  for (const time of [0, 0.5, 1, 2]) {
    await page.evaluate((at) => { pendulumd.clock.pause(); pendulumd.clock.seek(at); }, time);
    await drawn(page);
    places.push(await page.evaluate(() => pendulumd.stage.tip(0).y));
  }
  // the natural spline through 0, 1, 0 is 11/16 halfway
  assert.ok(Math.abs((places[0] - places[1]) / (places[0] - places[2]) - 11 / 16) < 1e-3, `${places}`);
  assert.ok(places[0] - places[2] > 10 && Math.abs(places[3] - places[0]) < 0.1, `${places}`);
  await close(page);
}
