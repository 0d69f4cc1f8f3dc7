// The twelve tasks of a lesson, each by counted actions: once with the pointer, once by keyboard alone.
// Leaves to others: that what is shown is right (the tests of each drawer).
// Invariant: an action is a click, a choice, or a field that is filled; a task that needs more than its number fails.

import assert from "node:assert/strict";
import { IN_FIREFOX } from "./bidi.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, doc, drawn, moving, pause } from "./rig.mjs";

const FARTHEST = 150; // presses of the tab key to anywhere

/** Hands that point: {click, fill, choose, arm, count()}. */
function pointer(page) {
  let count = 0;
  const act = (does) => { count++; return does(); };
  return {
    count: () => count,
    keys: () => 0,
    click: (at) => act(() => page.click(at)),
    fill: (at, value) => act(async () => { await page.fill(at, value); await page.press(at, "Enter"); }),
    choose: (at, value) => act(() => page.selectOption(at, value)),
    tab: (id) => act(() => openDrawer(page, id)),
    arm: (k) => act(async () => {
      const { left, top } = await page.evaluate(() => document.querySelector("#stage").getBoundingClientRect().toJSON());
      const { x, y } = await page.evaluate((one) => pendulumd.stage.tip(one), k);
      await page.mouse.click(left + x, top + y);
    }),
    point: (at) => act(() => page.click(at, { position: { x: 120, y: 120 } })),
  };
}

/** Hands on the keyboard: no pointer is used; the same, and how many keys were pressed on the way. */
function keyboard(page) {
  let [count, keys] = [0, 0];
  const press = (key) => { keys++; return page.keyboard.press(key); };
  const is = (at) => page.evaluate((wanted) => document.activeElement?.matches(wanted), at);
  const go = async (at) => {
    await page.waitForSelector(at, { state: "attached" });
    // the way that is shorter, as one who knows the page takes it
    let back = await page.evaluate(([wanted, firefox]) => {
      const all = [...document.querySelectorAll("button, select, input, a[href], summary, textarea, [tabindex='0']")].filter((one) => one.tabIndex >= 0 && !one.disabled && one.getClientRects().length);
      if (firefox && !all.includes(document.activeElement)) all[0].focus();
      const [from, to] = [all.indexOf(document.activeElement), all.indexOf(document.querySelector(wanted))];
      // a Firefox without a window does not come back from beyond the document's end: no button heeds a key then
      return firefox ? to < from : (to - from + all.length) % all.length > all.length / 2;
    }, [at, IN_FIREFOX]);
    for (let i = 0; i < FARTHEST; i++) {
      if (await is(at)) return;
      await press(back ? "Shift+Tab" : "Tab");
      // at the document's end Firefox may go on past some of it: the other way then
      if (await is("body")) back = !back;
    }
    throw new Error(`the tab key does not lead to ${at}, but to ${await page.evaluate(() => document.activeElement.outerHTML.slice(0, 90))}`);
  };
  const act = async (at, does) => { count++; await go(at); await does(); };
  return {
    count: () => count,
    keys: () => keys,
    click: (at) => act(at, () => press("Enter")),
    fill: (at, value) => act(at, async () => { await press("Control+a"); await page.keyboard.type(value); await press("Enter"); }),
    choose: (at, value) => act(at, async () => {
      const way = await page.evaluate(([one, wanted]) => {
        const field = document.querySelector(one);
        return [...field.options].findIndex((option) => option.value === wanted) - field.selectedIndex;
      }, [at, value]);
      for (let i = 0; i < Math.abs(way); i++) await press(way > 0 ? "ArrowDown" : "ArrowUp");
    }),
    tab: (id) => act('[role="tab"]', async () => {
      for (let i = 0; i < 12 && !await is(`[data-tab="${id}"]`); i++) await press("ArrowDown");
      if (await page.getAttribute(`[data-tab="${id}"]`, "aria-selected") !== "true") await press("Enter");
      await openDrawer(page, id);
    }),
    arm: (k) => act(`[data-arm="${k}"]`, () => press("Enter")), // to its numbers
    point: (at) => act(at, async () => { await press("ArrowRight"); await press("Enter"); }),
  };
}

const words = (page, id, pattern) => page.waitForFunction(([at, source]) => new RegExp(source).test(document.querySelector(`[data-drawer="${at}"]`)?.innerText ?? ""), [id, pattern.source]);

/** What a click or key saves, by its name. */
const saves = async (page, does) => (await Promise.all([page.waitForEvent("download"), does()]))[0].suggestedFilename();

/** Each task: how many actions it took before this page's rework, how many it may take, what is done and seen. */
const TASKS = {
  "a triple of given lengths": { before: 9, most: 5, async go(page, hands) {
    await hands.tab("physics");
    await hands.fill("[data-arms=count]", "3");
    for (const [k, length] of ["1", "0.8", "0.5"].entries()) await hands.fill(`[data-cell=length-${k + 1}]`, length);
    assert.deepEqual((await doc(page)).pendulum.length, [1, 0.8, 0.5]);
  } },
  "release from 90 degrees": { before: 2, most: 2, async go(page, hands) {
    await pause(page); // on a slow machine a hand would come to where the arm was
    await drawn(page);
    await hands.arm(1);
    await hands.fill("[data-field=angle]", "90");
    assert.equal((await doc(page)).initial.phi[0], 0);
    await moving(page);
  } },
  "slow motion": { before: 1, most: 1, async go(page, hands) {
    await hands.choose(".speed", "0.25");
    assert.equal(await page.evaluate(() => pendulumd.clock.speed), 0.25);
    await page.evaluate(() => pendulumd.store.set({ view: { speed: 1 } }));
  } },
  "the period": { before: 8, most: 1, async go(page, hands) {
    await hands.tab("measure");
    await page.waitForFunction(() => /\d s$/.test(document.querySelector("[data-read=period]")?.textContent ?? ""));
  } },
  "energy": { before: 2, most: 1, async go(page, hands) {
    await hands.tab("plots");
    await words(page, "plots", /Energ/);
  } },
  "butterfly": { before: 2, most: 2, async go(page, hands) {
    await hands.tab("compare");
    await hands.click("[data-add=off]");
    await page.waitForFunction(() => pendulumd.motion.ghosts.length === 1);
    await words(page, "compare", /apart/);
    await page.evaluate(() => pendulumd.store.set({ ghosts: [] }));
  } },
  "a map and a point of it": { before: 3, most: 3, async go(page, hands) {
    await hands.tab("compare");
    await page.selectOption("[data-drawer=compare] [data-map=count]", "60");
    const before = (await doc(page)).initial.phi;
    await hands.click("[data-drawer=compare] [data-map=compute]");
    await page.waitForSelector("[data-drawer=compare] [data-map=png]:not([hidden])");
    await hands.point("[data-drawer=compare] canvas.map");
    assert.notDeepEqual((await doc(page)).initial.phi, before);
  } },
  "start in a mode": { before: 2, most: 2, async go(page, hands) {
    await hands.tab("modes");
    await hands.click("[data-start='2']");
    await moving(page);
  } },
  "the force of an arm and where it is slack": { before: 1, most: 1, async go(page, hands) {
    await pause(page);
    await drawn(page);
    await hands.arm(1);
    assert.match(await page.textContent(".force"), /\d N/);
  } },
  "a table for a spreadsheet of another country": { before: 2, most: 3, async go(page, hands) {
    await hands.tab("plots");
    assert.match(await saves(page, () => hands.click("[data-save=table]")), /\.csv$/);
    await hands.choose("[data-drawer=plots] .number-files select", "comma");
  } },
  "link and code": { before: 2, most: 2, async go(page, hands) {
    await hands.tab("share");
    await page.waitForSelector("[data-drawer=share] svg.qr");
    await hands.click("[data-drawer=share] .link:not([hidden]) button");
  } },
  "print": { before: 1, most: 2, async go(page, hands) {
    await page.evaluate(() => { window.print = () => { window.printed = true; }; });
    await hands.tab("share");
    await hands.click("[data-share=report]");
    await page.waitForFunction(() => window.printed);
    await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  } },
};

async function lesson(rig, handsOf) {
  const page = await rig.open({ height: 1200, permissions: ["clipboard-read", "clipboard-write"] });
  const said = [];
  for (const [name, { before, most, go }] of Object.entries(TASKS)) {
    await page.evaluate(() => { pendulumd.store.set({ view: { drawer: null } }); document.activeElement?.blur(); });
    const hands = handsOf(page);
    await go(page, hands).catch((error) => { throw new Error(`${name}: ${error.stack}`); });
    assert.ok(hands.count() <= most, `${name} took ${hands.count()} actions`);
    said.push(`${name} ${before} -> ${hands.count()}${hands.keys() ? ` (${hands.keys()} keys)` : ""}`);
  }
  await close(page);
  return said.join("; ");
}

export const the_twelve_tasks_of_a_lesson_take_few_actions_with_the_pointer = (rig) => lesson(rig, pointer);
export const the_twelve_tasks_of_a_lesson_are_done_by_keyboard_alone = (rig) => lesson(rig, keyboard);
