// The ruler and the protractor on the stage: dragged, moved by keys, typed; they read what the pendulum is, take a joint's place
// near one, and are in the scene.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const number = (text) => parseFloat(text.replace("−", "-"));
const read = async (page, id) => number(await page.textContent(`[data-read=${id}]`));
const view = (page) => page.evaluate(() => pendulumd.store.get().view);
const tip = (page, arm) => page.evaluate((k) => {
  const { left, top } = document.querySelector("#stage").getBoundingClientRect();
  const { x, y } = pendulumd.stage.tip(k);
  return { x: x + left, y: y + top };
}, arm);

/** A pendulum of two arms that stands, with the drawer open: 1 m at 30 degrees, 0.5 m at 90. */
async function standing(rig, more = {}) {
  const page = await rig.open({ path: "/?length=1,0.5&theta=30,90", height: 1000, ...more });
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await openDrawer(page, "measure");
  await drawn(page);
  return page;
}

async function wanted(page, gauge) {
  await page.check(`[data-measure=${gauge}]`);
  await page.waitForSelector(gauge === "ruler" ? "[data-gauge=a]" : "[data-gauge=corner]");
  await drawn(page);
}

/** Drags a handle near a place; the last pixels are missed. */
async function drag(page, name, { x, y }) {
  const box = await page.locator(`[data-gauge=${name}]`).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 40);
  await page.mouse.move(x + 4, y - 3);
  await page.mouse.up();
  await drawn(page);
}

export async function a_ruler_that_is_dragged_to_joints_reads_their_distance(rig) {
  const page = await standing(rig);
  const asked = page.asked.length;
  await wanted(page, "ruler");
  const files = page.asked.slice(asked).filter((one) => one.url().includes("/v1/"));
  await drag(page, "a", await tip(page, 0));
  await drag(page, "b", await tip(page, 2));
  const [x, y] = [0.5 + 0.5, -Math.sqrt(3) / 2];
  assert.equal(await read(page, "length"), Number(Math.hypot(x, y).toFixed(3)));
  assert.deepEqual([await read(page, "across"), await read(page, "up")], [1, -0.866]);
  const { ruler } = await view(page);
  assert.ok([0, 0, x, y].every((want, k) => Math.abs(ruler[k] - want) < 1e-12), `a joint's own place: ${ruler}`);
  assert.deepEqual(files, [], "no server is asked");
  const picture = await page.evaluate(() => document.querySelector(".canvas").toDataURL());
  await page.uncheck("[data-measure=ruler]");
  await drawn(page);
  assert.equal(await page.locator("[data-gauge]").count(), 0);
  assert.notEqual(await page.evaluate(() => document.querySelector(".canvas").toDataURL()), picture, "its strokes are gone");
  await close(page);
}

export async function a_protractor_reads_an_arm_s_angle_and_another_arm_s_from_it(rig) {
  const page = await standing(rig);
  await wanted(page, "protractor");
  assert.deepEqual((await view(page)).protractor, [0, 0, 0, 45], "at the pivot, from hanging");
  const [pivot, one] = [await tip(page, 0), await tip(page, 1)];
  await drag(page, "to", one);
  assert.equal(await read(page, "between"), 30);
  // to the joint, from the line of the first arm to the second
  await drag(page, "corner", one);
  await drag(page, "to", await tip(page, 2));
  await drag(page, "from", pivot);
  const between = 90 - (30 - 180) - 360;
  assert.equal(await read(page, "between"), between, "counterclockwise from the first leg to the second");
  await rig.shot(page, "gauges");
  await close(page);
}

export async function gauges_are_moved_and_read_by_keys_and_typed(rig) {
  const page = await standing(rig);
  const said = () => page.textContent("#live");
  await page.focus("[data-measure=ruler]");
  for (const key of ["Tab", "Shift+Tab", " "]) await page.keyboard.press(key); // who comes by keys ticks
  await page.waitForSelector("[data-gauge=a]");
  const [ax, ay] = (await view(page)).ruler;
  await page.focus("[data-gauge=a]");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowUp");
  const { ruler } = await view(page);
  const step = ruler[0] - ax;
  assert.ok(step > 0 && Math.abs(ruler[1] - ay - step / 10) < 1e-9, `${step} to the right, a tenth of it up`);
  assert.equal(number(await said()), await read(page, "length"), "what it reads is said");
  assert.match(await page.getAttribute("[data-gauge=a]", "aria-label"), /^Ruler, end A: /);
  for (const [name, value] of [["ax", "0"], ["ay", "0"], ["bx", "0.3"], ["by", "-0,4"]]) {
    await page.fill(`[data-number=${name}]`, value);
    await page.press(`[data-number=${name}]`, "Enter");
  }
  assert.equal(await read(page, "length"), 0.5);
  await page.fill("[data-number=ax]", "none");
  await page.press("[data-number=ax]", "Enter");
  assert.equal(await page.getAttribute("[data-number=ax]", "aria-invalid"), "true");
  assert.equal(await read(page, "length"), 0.5, "what is no number changes nothing");
  await page.fill("[data-number=ax]", "2e6");
  await page.press("[data-number=ax]", "Enter");
  assert.equal(await page.getAttribute("[data-number=ax]", "aria-invalid"), "true");
  assert.match(await said(), /1000000/, "farther than a link would keep it");
  assert.equal(await read(page, "length"), 0.5, "what is too far changes nothing");
  await wanted(page, "protractor");
  await page.focus("[data-gauge=to]");
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Shift+ArrowLeft");
  assert.equal(await read(page, "between"), 45.9);
  assert.deepEqual(await violations(page), []);
  await close(page);
}

export async function gauges_are_in_the_scene_and_stay_in_sight(rig) {
  const page = await standing(rig);
  await wanted(page, "ruler");
  await drag(page, "b", await tip(page, 1));
  const { ruler } = await view(page);
  // what is kept is written when the hands rest
  await page.waitForFunction((kept) => JSON.stringify(history.state ?? {}).includes(kept), JSON.stringify(ruler));
  await page.reload();
  await page.waitForSelector("[data-gauge=b]");
  assert.deepEqual((await view(page)).ruler, ruler);
  const link = await page.evaluate(async () => {
    const { linkOf } = await import("/page/sources/link.js");
    return linkOf(pendulumd.store.get());
  });
  const other = await rig.open({ path: `/${link}`, width: 390, height: 844, touch: true });
  await other.waitForSelector("[data-gauge=b]");
  assert.deepEqual((await view(other)).ruler, ruler, "a link has it");
  // what lies far off keeps its handles where they can be taken
  await other.evaluate(() => pendulumd.store.set({ view: { ruler: [-50, 0, 50, 9] } }));
  await drawn(other);
  const [stage, ...boxes] = [await other.locator("#stage").boundingBox(), await other.locator("[data-gauge=a]").boundingBox(), await other.locator("[data-gauge=b]").boundingBox()];
  for (const box of boxes) assert.ok(box.x >= 0 && box.x + box.width <= stage.width && box.y >= stage.y && box.y + box.height <= stage.y + stage.height, JSON.stringify(box));
  await other.evaluate(() => pendulumd.store.set({ view: { ruler: null } }));
  await close(other);
  await close(page);
}
