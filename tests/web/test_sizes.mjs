// What a person must see lies in the window, in seven sizes and some forty states: the pendulum, the field that is asked for and
// its button; nothing is cut off, and on a touch screen every target is large enough for a finger.
// Leaves to others: what these do (test_room.mjs, test_embed.mjs, test_worksheet.mjs), how it looks (test_pictures.mjs).
// Invariant: places are measured, not only looked for; each state is looked at in every size that it is for.

import assert from "node:assert/strict";
import { DRAWERS } from "../../server/web/state.js";
import { COMB } from "./comb.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn, moving, refuseStorage } from "./rig.mjs";
import { teach } from "./room.mjs";

export const rig = { store: true, sources: false };

/** Phones upright and across, an upright tablet; a laptop, a large screen; frames of other pages. */
const PHONES = [[390, 664], [844, 390], [820, 1180]];
const SCREENS = [[1366, 768], [1920, 1080]];
const FRAMES = [[300, 200], [360, 300], [720, 480], [400, 600], [800, 600], [860, 600]];
/** Small windows and pages enlarged four times, of which all scrolls. */
const ENLARGED = [[360, 300], [320, 640], [568, 320], [683, 384]];
const TOUCH = { width: 390, height: 664, touch: true, isMobile: true, still: true };
const FINGER = 44; // pixels

/** Fails with all that is bad, a line each. */
const none = (bad) => assert.ok(!bad.length, `\n+   ${bad.join("\n+   ")}`);

/** What is wrong with the stage: too low, or arms out of sight. */
const stageFaults = (page) => page.evaluate(() => {
  const found = [];
  const { top, bottom, width, height } = document.querySelector("#stage").getBoundingClientRect();
  if (height < innerHeight / 3 || top < 0 || bottom > innerHeight + 1) found.push(`the stage has ${Math.round(height)} of ${innerHeight} from ${Math.round(top)}`);
  const lost = [0, ...pendulumd.motion.doc.pendulum.length.map((_, k) => k + 1)].filter((arm) => {
    const { x, y } = pendulumd.stage.tip(arm);
    return x < 0 || y < 0 || x > width || y > height;
  });
  return lost.length ? [...found, `arms ${lost} are out of sight`] : found;
});

/** Which of these are not there, out of the window, or covered by something else. */
const askedFaults = (page, selectors) => page.evaluate((all) => all.flatMap((selector) => {
  const element = [...document.querySelectorAll(selector)].find((one) => one.getClientRects().length);
  if (!element) return [`${selector} is not there`];
  const { left, right, top, bottom } = element.getBoundingClientRect();
  if (Math.min(left, top) < -1 || right > innerWidth + 1 || bottom > innerHeight + 1) return [`${selector} lies at ${[left, top, right, bottom].map(Math.round)}`];
  const seen = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  return element.contains(seen) || element.closest("label")?.contains(seen) ? [] : [`${selector} is covered by ${seen?.outerHTML.slice(0, 60)}`];
}), selectors);

/** Controls in sight that something else covers, at their middle or near the middle of an edge; those of another part may reach over none. */
const coveredFaults = (page) => page.evaluate(() => {
  const seenOf = (one) => {
    let { left, right, top, bottom } = one.getBoundingClientRect();
    const within = (box) => { [left, right, top, bottom] = [Math.max(left, box.left), Math.min(right, box.right), Math.max(top, box.top), Math.min(bottom, box.bottom)]; };
    for (let at = one.parentElement; at; at = at.parentElement) if (getComputedStyle(at).overflow !== "visible") within(at.getBoundingClientRect());
    within({ left: 0, right: innerWidth, top: 0, bottom: innerHeight });
    return { left, right, top, bottom };
  };
  const all = [...document.querySelectorAll("button, select, summary, a[href], input:not([type=file])")];
  return all.filter((one) => one.checkVisibility({ visibilityProperty: true }) && !one.closest(".unseen, [inert]")).flatMap((one) => {
    const { left, right, top, bottom } = seenOf(one);
    if (right - left < 8 || bottom - top < 8) return [];
    const [x, y] = [(left + right) / 2, (top + bottom) / 2];
    const over = [[x, y], [left + 2, y], [right - 2, y], [x, top + 2], [x, bottom - 2]].map(([a, b]) => document.elementFromPoint(a, b)).find((hit) => hit && !one.contains(hit) && !hit.contains(one));
    return over ? [`${one.outerHTML.slice(0, 80)} is covered by ${over.outerHTML.slice(0, 60)}`] : [];
  });
});

/** What is wider than the window or its panel, and buttons of the bars that are cut off where the page does not scroll. */
const cutFaults = (page) => page.evaluate(() => {
  const found = [document.documentElement, ...document.querySelectorAll(".panels, #embed-sheet, .card, dialog[open]")].flatMap((one) => {
    const over = one.scrollWidth - one.clientWidth;
    return over > 1 ? [`${one.className || one.localName} is ${over} pixels too narrow`] : [];
  });
  if (document.documentElement.scrollHeight > innerHeight + 2) return found;
  const bars = document.querySelectorAll("#timebar :is(button, select, input), .embed-link, #header :is(button, select), .rail-row > button, .notice:not([hidden]), .legend button");
  const cut = [...bars].filter((one) => {
    const { left, right, top, bottom } = one.getBoundingClientRect();
    return right > left && (left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1);
  });
  return [...found, ...cut.map((one) => `cut off: ${one.outerHTML.slice(0, 70)}`)];
});

/** Targets that a finger misses. Words of a sentence and the marks of a slider are no targets of their own. */
const smallFaults = (page) => page.evaluate((least) => {
  if (!matchMedia("(pointer: coarse)").matches) return [];
  const all = document.querySelectorAll("button, select, summary, a[href], label:has(> :is([type=checkbox], [type=radio])), input:not([type=checkbox], [type=radio], [type=range], [type=file])");
  const small = [...all].filter((one) => {
    const { width, height } = one.getBoundingClientRect();
    const style = getComputedStyle(one);
    const within = one.localName === "a" && one.parentElement.textContent.trim() !== one.textContent.trim();
    const unseen = one.closest(".unseen, [inert]") || style.visibility === "hidden" || !one.getClientRects().length;
    return !unseen && !within && !one.disabled && Math.min(width, height) < least - 0.5;
  });
  return [...new Set(small.map((one) => { const { width, height } = one.getBoundingClientRect(); return `small, ${Math.round(width)} x ${Math.round(height)}: ${one.outerHTML.slice(0, 80)}`; }))];
}, FINGER);

/** Looks at a page in these sizes. staged: the stage is to be seen too. */
async function look(page, name, sizes, { asked = [], staged = true } = {}) {
  const bad = [];
  for (const [width, height] of sizes) {
    await page.setViewportSize({ width, height });
    await drawn(page);
    const faults = [...(staged ? await stageFaults(page) : []), ...await askedFaults(page, asked), ...await cutFaults(page), ...await smallFaults(page)];
    bad.push(...faults.map((words) => `${name} ${width}x${height}: ${words}`));
  }
  return bad;
}
const show = (page, patch) => page.evaluate((one) => pendulumd.store.set(one), patch);
const drawer = (id) => (page) => openDrawer(page, id);
/** A chain on the stage, and no drawer open. */
const chain = (length, degrees) => ({ pendulum: { length, mass: length.map(() => 1), parent: length.map((_, k) => k), gravity: 9.81 },
  initial: { phi: degrees.map((angle) => (angle - 90) * Math.PI / 180), phid: degrees.map(() => 0) }, preset: null, ghosts: [], view: { selected: 0, trails: [1], drawer: null } });
const example = async (page, name) => {
  await page.evaluate(async (id) => {
    const { pendulum, initial, times } = await pendulumd.client.preset(id);
    pendulumd.store.set({ pendulum: { ...pendulum, mass: pendulum.mass }, initial, span: { stop: 4, step: times.step }, preset: null, ghosts: [], view: { selected: 0, trails: [1] } });
  }, name);
  await moving(page);
};

/** States of the whole page, one after the other, by their names: how each is come to, and what must be seen then. */
const STATES = {
  first: [() => {}, ["[data-act=play]"]],
  examples: [async (page) => { await openDrawer(page, "presets"); await page.waitForSelector("[data-preset=kapitza]"); }, ["[data-preset=single]"]],
  "three arms": [(page) => show(page, chain([1, 1, 1], [90, 60, 30])), ["[data-act=play]"]],
  equilibrium: [(page) => show(page, chain([1, 1], [180, 0])), ["[data-act=play]"]],
  "fifty arms": [(page) => page.evaluate(COMB), ["[data-act=play]"]],
  cart: [(page) => example(page, "metronome-cart"), ["[data-act=play]"]],
  "side by side": [async (page) => { await show(page, chain([1], [20])); await page.evaluate(() => pendulumd.edits.addBeside()); }, ["[data-act=swap]"]],
  "four arms": [(page) => example(page, "paper-four-arms"), ["[data-act=play]"]],
  "an arm's card": [async (page) => { await page.evaluate(() => pendulumd.edits.select(2)); }, [".card [data-field=length]", ".card [data-act=add]"]],
  "the card while it moves": [async (page) => { await page.evaluate(() => { pendulumd.clock.seek(1); pendulumd.clock.play(); }); }, [".card [data-field=length]"]],
  "a notice": [async (page) => { await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.edits.select(0); pendulumd.complain("This link cannot be read."); }); }, [".notice button"]],
  "arrows, trails, ruler": [(page) => page.evaluate(() => { pendulumd.motion.note(null); pendulumd.store.set({ view: { arrows: true, vectors: ["velocity", "weight"], trails: [1, 2, 3, 4], ruler: [], protractor: [] } }); })],
  "a wrong duration": [async (page) => { await show(page, { view: { arrows: false, vectors: [], ruler: null, protractor: null } }); await page.fill(".until", "x"); await page.press(".until", "Enter"); }],
  help: [async (page) => { await page.evaluate(() => document.querySelector("[data-act=help]").click()); }, [".help [aria-label=Close]"]],
  physics: [async (page) => { await page.evaluate(() => document.querySelector(".help").close()); await openDrawer(page, "physics"); }],
  measure: [drawer("measure")],
  plots: [drawer("plots")],
  modes: [drawer("modes")],
  control: [drawer("control")],
  compare: [drawer("compare")],
  "compare with a ghost": [(page) => page.click("[data-add=off]")],
  method: [drawer("method")],
  equations: [drawer("equations")],
  "equations, large": [(page) => page.click("[data-large=open]"), ["[data-large=close]"]],
  share: [async (page) => { await page.click("[data-large=close]"); await openDrawer(page, "share"); await page.waitForSelector("[data-drawer=share] svg.qr"); }],
  worksheets: [drawer("worksheet")],
  class: [drawer("class"), ["[data-drawer=class] [data-class=code]", "[data-drawer=class] [data-class=nickname]"]],
  German: [async (page) => { await page.evaluate(() => pendulumd.speak("de")); await openDrawer(page, "physics"); }],
};

async function everyState(rig, options, sizes, scrolled = []) {
  const page = await rig.open({ path: "/", ...options });
  const bad = [];
  for (const [name, [go, asked = []]] of Object.entries(STATES)) {
    // where all tools are seen
    await page.setViewportSize({ width: 1366, height: 768 });
    await go(page);
    const staged = !/help|large/.test(name);
    bad.push(...await look(page, name, sizes, { asked, staged }), ...await look(page, name, scrolled, { staged }));
  }
  none(bad);
  await close(page);
  return `${Object.keys(STATES).length} states in ${sizes.length + scrolled.length} sizes`;
}
export const every_state_of_the_page_is_whole_on_phones_and_tablets = (rig) => everyState(rig, TOUCH, PHONES);
export const every_state_of_the_page_is_whole_on_a_laptop_a_projector_and_enlarged = (rig) => everyState(rig, { still: true }, SCREENS, ENLARGED);

export async function no_part_lies_over_another_s_controls_at_any_width_with_any_drawer_open(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=60,30", still: true });
  await page.evaluate(() => pendulumd.edits.select(2));
  const bad = new Map();
  for (const id of [null, ...DRAWERS]) {
    if (id) await openDrawer(page, id);
    else await show(page, { view: { drawer: null } });
    await drawn(page);
    for (let width = 300; width <= 1600; width += 50) for (const height of id === "physics" ? [768, 480] : [768]) {
      await page.setViewportSize({ width, height });
      await page.evaluate(() => new Promise((resolve) => { requestAnimationFrame(resolve); }));
      for (const words of [...await coveredFaults(page), ...await cutFaults(page)]) bad.set(words, [...bad.get(words) ?? [], `${id} ${width}x${height}`]);
    }
  }
  none([...bad].map(([words, where]) => `${words} at ${where.join(", ")}`));
  await close(page);
}

export async function a_pendulum_is_seen_in_every_frame_of_another_page(rig) {
  const bad = [];
  for (const [path, go = () => {}] of [["/?embed=1"], ["/?embed=1&length=1,1&theta=120,-90"], ["/?embed=1&example=kapitza"],
    ["/?embed=1&length=1&theta=x", (page) => page.waitForSelector(".notice")], ["/?embed=1&length=1,2&lang=de", (page) => page.evaluate(COMB)]]) {
    const page = await rig.open({ path, still: true });
    await page.waitForSelector(".embed-link");
    await go(page);
    bad.push(...await look(page, path, FRAMES, { asked: ["[data-act=play]", ".embed-link"] }));
    await close(page);
  }
  const sheet = await rig.open({ path: "/?embed=1&sheet=period", still: true });
  await sheet.waitForSelector("#embed-sheet [data-answer]");
  bad.push(...await look(sheet, "sheet", FRAMES.filter(([, height]) => height >= 300), { asked: ["[data-act=play]", "#embed-sheet h3"] }));
  await sheet.setViewportSize({ width: 640, height: 360 });
  const { height } = await sheet.evaluate(() => new Promise((resolve) => {
    addEventListener("message", ({ data }) => data.height && resolve(data));
    window.postMessage({ pendulumd: "size" }, "*");
  }));
  await sheet.setViewportSize({ width: 640, height });
  const over = await sheet.evaluate(() => { const { scrollHeight, clientHeight } = document.getElementById("embed-sheet"); return scrollHeight - clientHeight; });
  assert.ok(height > 360 && over <= 1, `a frame of the asked ${height} pixels lacks ${over}`);
  await close(sheet);
  none(bad);
}

export async function a_frame_that_may_keep_nothing_says_nothing_over_the_pendulum(rig) {
  const page = await rig.open({ path: "/docs", cold: true, wait: false });
  await refuseStorage(page);
  await page.goto(`${rig.url}/?embed=1`);
  await page.waitForSelector(".embed-link");
  await page.waitForFunction(() => pendulumd.motion.complete && pendulumd.clock.time > 0);
  assert.equal(await page.locator(".notice:not([hidden])").count(), 0);
  await close(page);
}

export async function the_tools_of_a_phone_are_a_menu_that_fits(rig) {
  const page = await rig.open(TOUCH);
  await page.click(".menu-key");
  const tabs = await page.evaluate(() => [...document.querySelectorAll(".tabs button")].map((one) => one.getBoundingClientRect()).filter(({ left, right, top, bottom, height }) => left >= 0 && right <= 390 && top >= 0 && bottom <= 664 && height >= 44).length);
  assert.equal(tabs, 12, "all names are seen at once, each large enough for a finger");
  await page.click("[data-tab=share]");
  assert.equal(await page.getAttribute(".menu-key", "aria-expanded"), "false");
  none(await look(page, "share", PHONES.filter(([width]) => width < 844), { asked: [".menu-key", ".close-key"] }));
  await page.click(".close-key");
  // what the head has no room for lies behind a key
  await page.setViewportSize({ width: 320, height: 640 });
  await page.click("[data-act=more]");
  none(await look(page, "more", [[320, 640], [390, 664]], { asked: ["[data-act=theme]", "[data-act=redo]", ".tongue"] }));
  await page.click("[data-act=theme]");
  assert.equal(await page.isVisible("[data-act=theme]"), false, "it closes when it has been used");
  await close(page);
}

export async function a_class_is_worked_through_on_a_phone_without_scrolling(rig) {
  const bad = [];
  const { page: teacher, code } = await teach(rig);
  const phone = await rig.open({ ...TOUCH, path: `/${code}` });
  const see = async (name, asked, staged = true) => bad.push(...await look(phone, name, PHONES, { asked, staged }));
  await phone.waitForSelector(".join-card [data-class=nickname]");
  await see("join", ["[data-class=code]", "[data-class=nickname]", "[data-class=join]"], false);
  await phone.fill("[data-class=nickname]", "Ada");
  await phone.press("[data-class=nickname]", "Enter");
  await phone.waitForSelector(".class-now");
  assert.equal(await phone.evaluate(() => document.querySelector(".tabs button").dataset.tab), "class", "what a pupil needs comes first");
  await see("joined", [".class-now"]);
  await phone.click(".close-key");
  await teacher.fill("[data-class=words]", "Stop and look here");
  await teacher.press("[data-class=words]", "Enter");
  await phone.waitForSelector(".class-banner:not([hidden])");
  assert.match(await phone.textContent(".class-banner"), /Stop and look here/);
  await see("words", [".class-banner"]);
  await teacher.click("[data-class=freeze]");
  await phone.waitForSelector("[data-room][data-state=frozen]");
  await see("frozen", [".class-banner"]);
  await teacher.click("[data-class=freeze]");
  await phone.waitForSelector("[data-room][data-state=live]");
  await teacher.selectOption("[data-class=spread]", "hand");
  await teacher.click("[data-class=release]");
  await phone.waitForSelector("[data-class=letGo]");
  await see("a start by hand", ["[data-class=letGo]"]);
  await phone.click("[data-class=letGo]");
  await teacher.click("[data-class=own]");
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "How long does one swing take?");
  await teacher.fill("[data-question=right]", "2");
  await teacher.click("[data-class=ask]");
  await phone.waitForSelector(".question [data-answer]");
  await see("question", [".question [data-answer]", "[data-class=answer]"]);
  await phone.fill(".question [data-answer]", "2.0");
  await phone.click("[data-class=answer]");
  await teacher.waitForSelector("text=1 answer");
  await teacher.click("[data-class=endQuestion]");
  await phone.waitForSelector(".question", { state: "hidden" });
  await teacher.selectOption("[data-class=ours]", "period");
  await teacher.click("[data-class=takeSheet]");
  await teacher.click("[data-give=period]");
  await phone.waitForSelector(".given-sheet [data-answer]");
  await see("a worksheet", [".given-sheet [data-answer], .given-sheet [data-sheet=begin]"]);
  bad.push(...await look(teacher, "teacher", SCREENS));
  for (const page of [teacher, phone]) await close(page);
  none(bad);
}

export async function a_finger_scrolls_the_page_around_a_frame_where_no_arm_is(rig) {
  const page = await rig.open({ ...TOUCH, path: "/?embed=1&length=1&theta=20" });
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await drawn(page);
  const held = (arm) => page.evaluate((k) => {
    const canvas = document.querySelector(".canvas");
    const { left, top } = canvas.getBoundingClientRect();
    const { x, y } = k ? pendulumd.stage.tip(k) : { x: 20, y: 20 };
    const touch = new Touch({ identifier: 1, target: canvas, clientX: left + x, clientY: top + y });
    const event = new TouchEvent("touchstart", { touches: [touch], cancelable: true, bubbles: true });
    canvas.dispatchEvent(event);
    return event.defaultPrevented;
  }, arm);
  assert.deepEqual([await held(1), await held(0)], [true, false]);
  assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector(".canvas")).touchAction), "pan-y pinch-zoom");
  await close(page);
}
