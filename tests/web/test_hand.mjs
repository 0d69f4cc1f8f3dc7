// Hands: tips are dragged, arms are added and changed by clicks, everything is undone and done again.

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, doc, drawn, moving } from "./rig.mjs";


/** Where an arm's tip is on the screen; the stage stands still for it. */
async function tip(page, arm) {
  await drawn(page);
  return page.evaluate((k) => {
    const place = document.querySelector(".canvas").getBoundingClientRect();
    const spot = pendulumd.stage.tip(k);
    return { x: place.left + spot.x, y: place.top + spot.y };
  }, arm);
}

async function pause(page, time = 0) {
  await page.evaluate((t) => { pendulumd.clock.pause(); pendulumd.clock.seek(t); }, time);
  await drawn(page);
}

async function type(page, field, value) {
  await page.fill(`[data-field="${field}"]`, value);
  await page.press(`[data-field="${field}"]`, "Enter");
}

export async function a_tip_that_is_dragged_sets_the_start_and_moves_when_it_is_let_go(rig) {
  const page = await rig.open();
  await page.evaluate(() => pendulumd.edits.setStart(1, "phi", -1.2));
  await moving(page);
  await pause(page);
  const from = await tip(page, 4);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x - 30, from.y + 40, { steps: 4 });
  const during = await page.evaluate(() => ({ playing: pendulumd.clock.playing, held: pendulumd.motion.held }));
  assert.deepEqual(during, { playing: false, held: true });
  await page.waitForFunction(() => pendulumd.motion.track.preview?.some((force) => force !== 0));
  await rig.shot(page, "drag");
  await page.mouse.up();
  await moving(page);
  await page.waitForFunction(() => pendulumd.clock.time > 0.1);
  const after = await doc(page);
  assert.ok(after.initial.phi[3] < -0.3 && after.initial.phi[3] > -2.5, `arm 4 starts at ${after.initial.phi[3]}`);
  assert.deepEqual(after.initial.phi.slice(0, 3), [-1.2, 0, 0]);
  await page.keyboard.press("Control+z");
  assert.deepEqual((await doc(page)).initial.phi, [-1.2, 0, 0, 0], "one drag is one step");
  await page.keyboard.press("Control+Shift+z");
  assert.deepEqual((await doc(page)).initial.phi, after.initial.phi);
  await close(page);
}

export async function a_drag_in_the_midst_of_the_motion_starts_from_what_is_seen(rig) {
  const page = await rig.open();
  await pause(page, 2);
  const seen = await page.evaluate(() => [...pendulumd.motion.at(2).phi]);
  const from = await tip(page, 1);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + 25, from.y, { steps: 3 });
  await page.mouse.up();
  const { initial } = await doc(page);
  assert.deepEqual(initial.phi.slice(1), seen.slice(1));
  assert.notEqual(initial.phi[0], seen[0]);
  assert.deepEqual(initial.phid, [0, 0, 0, 0]);
  await close(page);
}

export async function the_paper_s_pendulum_is_built_by_clicks(rig) {
  const page = await rig.open({ path: "/" });
  await page.click('[data-act="new"]');
  await pause(page);
  const arms = [["2", "1"], ["1.5", "1"], ["0.75", "1"], ["1.25", "0.1"]];
  const carriers = [0, 1, 2, 2];
  for (let k = 0; k < 4; k++) {
    if (k) {
      const joint = await tip(page, carriers[k]);
      await page.mouse.click(joint.x, joint.y);
      assert.equal((await doc(page)).view.selected, carriers[k], "the click has chosen the joint");
      await page.click('[data-act="add"]');
    }
    await type(page, "length", arms[k][0]);
    await type(page, "mass", arms[k][1]);
    await type(page, "angle", "90");
    await pause(page);
  }
  const { pendulum, initial } = await doc(page);
  assert.deepEqual(pendulum, { length: [2, 1.5, 0.75, 1.25], mass: [1, 1, 1, 0.1], parent: [0, 1, 2, 2], gravity: 9.81 });
  assert.deepEqual(initial, { phi: [0, 0, 0, 0], phid: [0, 0, 0, 0] });
  await page.click('[data-act="play"]');
  await moving(page);
  await page.waitForFunction(() => pendulumd.clock.time > 0.3);
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1.2); });
  await drawn(page);
  await rig.shot(page, "built");
  // all the way back, and all the way forth
  let steps = 0;
  while (await page.isEnabled('[data-act="undo"]')) {
    await page.click('[data-act="undo"]');
    steps++;
  }
  assert.deepEqual([(await doc(page)).preset, (await doc(page)).pendulum.parent], ["single", [0]]);
  assert.equal(steps, 13, "new, three arms, and the nine numbers that were other ones");
  while (await page.isEnabled('[data-act="redo"]')) await page.click('[data-act="redo"]');
  assert.deepEqual((await doc(page)).pendulum, pendulum);
  await close(page);
}

export async function what_is_wrong_with_a_number_is_seen_until_one_goes_on(rig) {
  const page = await rig.open();
  await openDrawer(page, "physics");
  for (const [at, words] of [["[data-number=damping]", /Viscous friction.*number/], [".until", /Duration: a number from 0.1/]]) {
    await page.fill(at, "abc");
    await page.press(at, "Enter");
    const said = page.locator("#live.objection");
    await said.waitFor();
    assert.match(await said.innerText(), words);
    const box = await said.boundingBox();
    assert.ok(box.width > 80 && box.height > 20, "it is seen");
    await page.fill(at, "1");
    await page.locator("#live.unseen").waitFor({ state: "attached" });
  }
  await close(page);
}

export async function numbers_are_edited_in_place_and_wrong_ones_are_refused(rig) {
  const page = await rig.open();
  await pause(page, 3.3);
  const spot = await tip(page, 2);
  await page.mouse.move(spot.x, spot.y);
  await drawn(page);
  await rig.shot(page, "hover");
  await page.mouse.click(spot.x, spot.y);
  await drawn(page);
  await rig.shot(page, "arm");
  await type(page, "length", "-1");
  assert.equal(await page.getAttribute('[data-field="length"]', "aria-invalid"), "true");
  assert.equal((await doc(page)).pendulum.length[1], 1.5);
  await type(page, "length", "1,25");
  assert.equal((await doc(page)).pendulum.length[1], 1.25, "a comma is a point");
  await type(page, "rate", "-2");
  assert.equal((await doc(page)).initial.phid[1], -2);
  await moving(page);
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  assert.equal((await doc(page)).pendulum.length[1], 1.5);
  assert.equal(await page.inputValue('[data-field="length"]'), "1.5");
  await close(page);
}

export async function a_branch_is_deleted_and_comes_back(rig) {
  const page = await rig.open();
  await pause(page);
  await page.evaluate(() => pendulumd.edits.select(2));
  await page.click('[data-act="remove"]');
  await moving(page);
  const { pendulum, view } = await doc(page);
  assert.deepEqual(pendulum, { length: [2], mass: [1], parent: [0], gravity: 9.81 });
  assert.deepEqual(view.trails, [1]);
  assert.ok(await page.isDisabled('[data-act="remove"]'), "the last arm stays");
  await page.click('[data-act="undo"]');
  assert.deepEqual((await doc(page)).pendulum.parent, [0, 1, 2, 2]);
  await moving(page);
  await close(page);
}

export async function escape_takes_a_drag_back(rig) {
  const page = await rig.open();
  await pause(page, 1);
  const before = await doc(page);
  const from = await tip(page, 2);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + 60, from.y - 30, { steps: 4 });
  assert.notDeepEqual((await doc(page)).initial, before.initial);
  await page.keyboard.press("Escape");
  await page.mouse.move(from.x + 80, from.y);
  await page.mouse.up();
  assert.deepEqual((await doc(page)).initial, before.initial);
  assert.equal(await page.evaluate(() => pendulumd.motion.held), false);
  await moving(page);
  await close(page);
}

export async function gravity_is_edited_where_the_pendulum_hangs(rig) {
  const page = await rig.open();
  await page.evaluate(() => pendulumd.edits.select(2));
  assert.equal(await page.isVisible('[data-field="gravity"]'), false);
  await page.evaluate(() => pendulumd.edits.select(1));
  await type(page, "gravity", "1.62");
  assert.equal((await doc(page)).pendulum.gravity, 1.62);
  await moving(page);
  const energy = await page.evaluate(() => Math.min(...pendulumd.motion.columns.energy_potential));
  assert.ok(energy < -1 && energy > -1.62 * 10.3, `on the moon: ${energy} J`);
  await page.evaluate(() => pendulumd.clock.pause());
  await drawn(page);
  await rig.shot(page, "gravity");
  await close(page);
}

export async function shift_while_dragging_changes_the_length(rig) {
  const page = await rig.open();
  await pause(page);
  const from = await tip(page, 1);
  const base = await page.evaluate(() => pendulumd.stage.tip(0));
  const place = await page.evaluate(() => document.querySelector(".canvas").getBoundingClientRect().left);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.keyboard.down("Shift");
  await page.mouse.move((from.x + place + base.x) / 2, from.y, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const { length } = (await doc(page)).pendulum;
  assert.ok(Math.abs(length[0] - 1) < 0.05, `half of 2 m is ${length[0]}`);
  await close(page);
}

export async function a_finger_drags_on_a_phone(rig) {
  const page = await rig.open({ width: 390, height: 844, touch: true, isMobile: true });
  await pause(page);
  const from = await tip(page, 4);
  const session = await page.context().newCDPSession(page);
  const touch = (type, x, y) => session.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y }] });
  await touch("touchStart", from.x, from.y);
  for (let i = 1; i <= 4; i++) await touch("touchMove", from.x, from.y + 15 * i);
  await touch("touchEnd");
  const { initial } = await doc(page);
  assert.ok(initial.phi[3] < -0.3, `arm 4 starts at ${initial.phi[3]}`);
  await moving(page);
  await close(page);
}
