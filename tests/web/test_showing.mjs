// The stage before a class and on small screens: projector, phones held across, pages enlarged four times, forced colours.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

/** Where an element lies, and whether another one covers any of it. */
const covered = (page, below, above) => page.evaluate(([a, b]) => {
  const [one, other] = [a, b].map((selector) => document.querySelector(selector).getBoundingClientRect());
  return one.bottom > other.top + 1 && other.bottom > one.top + 1;
}, [below, above]);

export async function the_time_bar_covers_nothing_on_low_and_narrow_stages(rig) {
  for (const [name, width, height] of [["across", 844, 390], ["small-across", 568, 320], ["enlarged", 320, 256], ["narrow", 320, 640]]) {
    const page = await rig.open({ width, height });
    await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1.1); });
    await drawn(page);
    assert.equal(await covered(page, "#stage", "#timebar"), false, `${name}: the time bar lies over the stage`);
    const tips = await page.evaluate(() => {
      const place = document.querySelector("#stage").getBoundingClientRect();
      return [0, 1, 2, 3, 4].map((arm) => pendulumd.stage.tip(arm)).every(({ x, y }) => x > 0 && y > 0 && x < place.width && y < place.height);
    });
    assert.ok(tips, `${name}: the whole pendulum is seen`);
    await rig.shot(page, `stage-${name}`);
    for (const id of ["measure", "plots", "share"]) {
      await openDrawer(page, id);
      // a browser's own scroll bar may take some of it
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0, `${name}: ${id} lies beside the screen`);
    }
    await close(page);
  }
}

export async function the_card_is_whole_on_low_and_narrow_stages(rig) {
  for (const [name, width, height, scrolls] of [["across", 844, 390], ["twice", 683, 384], ["small", 320, 568], ["enlarged", 320, 256, true]]) {
    const page = await rig.open({ width, height, path: "/?length=1,1&theta=90,45" });
    await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1.1); pendulumd.edits.select(1); });
    await drawn(page);
    const places = await page.evaluate(() => {
      const [card, stage] = [".card", "#stage"].map((at) => document.querySelector(at));
      const lies = ({ left, right, top, bottom }, { left: l, right: r, top: t, bottom: b }) => left >= l && right <= r && top >= t && bottom <= b;
      const cut = (one) => one.scrollWidth > one.clientWidth + 1;
      const around = card.getBoundingClientRect();
      return { card: lies(around, stage.getBoundingClientRect()), buttons: [...card.querySelectorAll("button")].map((one) => lies(one.getBoundingClientRect(), around)),
        cut: [...card.querySelectorAll("input, .field > span:first-child")].filter((one) => one.getClientRects().length && cut(one)).map((one) => one.outerHTML), wide: cut(card) };
    });
    assert.ok(places.card && !places.wide, `${name}: the card lies on the stage`);
    assert.ok(scrolls || places.buttons.every(Boolean), `${name}: ${places.buttons}`);
    assert.deepEqual(places.cut, [], name);
    await rig.shot(page, `card-${name}`);
    await page.fill('[data-field="length"]', "50 cm");
    await page.press('[data-field="length"]', "Enter");
    assert.match(await page.innerText(".card"), /Length: this must be a number greater than 0/, "what is wrong is seen");
    await close(page);
  }
}

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
