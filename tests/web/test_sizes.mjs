// What a person must see lies in the window: the pendulum, the field that is asked for and its button, in seven sizes.
// Leaves to others: what these do (test_room.mjs, test_embed.mjs, test_worksheet.mjs).
// Invariant: places are measured, not only looked for; each state is looked at in every size that it is for.

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, drawn, refuseStorage } from "./rig.mjs";
import { join, teach } from "./room.mjs";

export const rig = { store: true, sources: false };

/** Phones upright and across, a tablet, two frames of other pages, a laptop, a large screen. */
const SIZES = [[390, 664], [844, 390], [820, 1180], [720, 480], [360, 300], [1366, 768], [1920, 1080]];
const FRAMES = [[300, 200], [400, 600], [600, 600], [720, 520], [800, 600], [860, 600], ...SIZES];
const PHONES = [[390, 664], [844, 390], [820, 1180]];
const PHONE = { width: 390, height: 664, touch: true, isMobile: true };

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
  const element = document.querySelector(selector);
  if (!element) return [`${selector} is not there`];
  const { left, right, top, bottom } = element.getBoundingClientRect();
  if (right <= left) return [`${selector} is not there`];
  if (Math.min(left, top) < -1 || right > innerWidth + 1 || bottom > innerHeight + 1) return [`${selector} lies at ${[left, top, right, bottom].map(Math.round)}`];
  const seen = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  return element.contains(seen) || element.closest("label")?.contains(seen) ? [] : [`${selector} is covered by ${seen?.outerHTML.slice(0, 60)}`];
}), selectors);

/** What is wider than the window, and buttons of the bars that are cut off where the page does not scroll. */
const cutFaults = (page) => page.evaluate(() => {
  const { scrollWidth, clientWidth, scrollHeight, dataset } = document.documentElement;
  const found = scrollWidth > clientWidth ? [`${scrollWidth - clientWidth} pixels too wide`] : [];
  if (scrollHeight > innerHeight + 2) return found;
  const bars = document.querySelectorAll("embed" in dataset ? "#timebar button, .embed-link" : "#timebar button, #header button, .rail-row > button");
  const cut = [...bars].filter((one) => {
    const { left, right, top, bottom } = one.getBoundingClientRect();
    return right > left && (left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1);
  });
  return [...found, ...cut.map((one) => `cut off: ${one.outerHTML.slice(0, 70)}`)];
});

/** Looks at a page in these sizes. */
async function look(page, name, sizes, asked = [], staged = true) {
  const bad = [];
  for (const [width, height] of sizes) {
    await page.setViewportSize({ width, height });
    await drawn(page);
    const faults = [...(staged ? await stageFaults(page) : []), ...await askedFaults(page, asked), ...await cutFaults(page)];
    bad.push(...faults.map((words) => `${name} ${width}x${height}: ${words}`));
  }
  return bad;
}

export async function a_pendulum_is_seen_in_every_frame_of_another_page(rig) {
  const bad = [];
  for (const path of ["/?embed=1", "/?embed=1&length=1,1&theta=120,-90"]) {
    const page = await rig.open({ path });
    await page.waitForSelector(".embed-link");
    bad.push(...await look(page, path, FRAMES, ["[data-act=play]", ".embed-link"]));
    await page.setViewportSize({ width: 300, height: 200 });
    await drawn(page);
    await rig.shot(page, "embed-300x200");
    await close(page);
  }
  const sheet = await rig.open({ path: "/?embed=1&sheet=period" });
  await sheet.waitForSelector("#embed-sheet [data-answer]");
  bad.push(...await look(sheet, "sheet", FRAMES.filter(([, height]) => height >= 300), ["[data-act=play]", "#embed-sheet h3"]));
  await sheet.setViewportSize({ width: 640, height: 360 });
  const { height } = await sheet.evaluate(() => new Promise((resolve) => {
    addEventListener("message", ({ data }) => data.height && resolve(data));
    window.postMessage({ pendulumd: "size" }, "*");
  }));
  await sheet.setViewportSize({ width: 640, height });
  const over = await sheet.evaluate(() => { const { scrollHeight, clientHeight } = document.getElementById("embed-sheet"); return scrollHeight - clientHeight; });
  assert.ok(height > 360 && over <= 1, `a frame of the asked ${height} pixels lacks ${over}`);
  await close(sheet);
  assert.deepEqual(bad, []);
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

export async function the_page_is_whole_in_every_size_with_every_drawer(rig) {
  const bad = [];
  const page = await rig.open();
  bad.push(...await look(page, "closed", SIZES, ["[data-act=play]"]));
  for (const id of ["presets", "physics", "measure", "plots", "modes", "control", "compare", "method", "equations", "share", "worksheet", "class"]) {
    await page.setViewportSize({ width: 1366, height: 768 });
    await openDrawer(page, id);
    bad.push(...await look(page, id, SIZES, []));
    bad.push(...await look(page, id, [[390, 664], [820, 1180]], [".menu-key", ".close-key"]));
  }
  await page.setViewportSize({ width: 390, height: 664 });
  await page.click(".menu-key");
  const tabs = await page.evaluate(() => [...document.querySelectorAll(".tabs button")].map((one) => one.getBoundingClientRect()).filter(({ left, right, top, bottom, height }) => left >= 0 && right <= 390 && top >= 0 && bottom <= 664 && height >= 44).length);
  assert.equal(tabs, 12, "all names are seen at once, each large enough for a finger");
  await rig.shot(page, "phone-menu");
  await page.click("[data-tab=share]");
  assert.equal(await page.getAttribute(".menu-key", "aria-expanded"), "false");
  await page.click(".close-key");
  assert.equal(await page.evaluate(() => pendulumd.store.get().view.drawer), null);
  assert.deepEqual(bad, []);
  await close(page);
}

export async function a_finger_finds_every_button_of_a_phone(rig) {
  const page = await rig.open(PHONE);
  await openDrawer(page, "physics");
  const small = await page.evaluate(() => [...document.querySelectorAll(".rail-row button, #timebar button, [data-drawer=physics] .button, [data-drawer=physics] select")].filter((one) => {
    const { width, height } = one.getBoundingClientRect();
    return width && Math.min(width, height) < 44;
  }).map((one) => one.outerHTML.slice(0, 80)));
  assert.deepEqual(small, []);
  await close(page);
}

export async function a_class_is_worked_through_on_a_phone_without_scrolling(rig) {
  const bad = [];
  const { page: teacher, code } = await teach(rig);
  const phone = await rig.open({ ...PHONE, path: `/${code}`, still: true });
  await phone.waitForSelector(".join-card [data-class=nickname]");
  bad.push(...await look(phone, "join", PHONES, ["[data-class=code]", "[data-class=nickname]", "[data-class=join]"], false));
  await phone.fill("[data-class=nickname]", "Ada");
  await phone.click("[data-class=join]");
  await phone.waitForSelector(".class-now");
  assert.deepEqual(await phone.evaluate(() => [...document.querySelectorAll(".tabs button")].slice(0, 2).map(({ dataset }) => dataset.tab)), ["class", "worksheet"], "what a pupil needs comes first");

  await phone.click(".close-key");
  await teacher.fill("[data-class=words]", "Stop and look here");
  await teacher.press("[data-class=words]", "Enter");
  await phone.waitForSelector(".class-banner:not([hidden])");
  assert.match(await phone.textContent(".class-banner"), /Stop and look here/);
  bad.push(...await look(phone, "words", PHONES, [".class-banner"]));
  await rig.shot(phone, "phone-words");

  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "How long does one swing take?");
  await teacher.fill("[data-question=right]", "2");
  await teacher.click("[data-class=ask]");
  await phone.waitForSelector(".question [data-answer]");
  bad.push(...await look(phone, "question", PHONES, [".question [data-answer]", "[data-class=answer]"]));
  await rig.shot(phone, "phone-question");
  await phone.fill(".question [data-answer]", "2.0");
  await phone.click("[data-class=answer]");
  await teacher.waitForSelector("text=1 answer");
  assert.deepEqual(bad, []);
  for (const page of [teacher, phone]) await close(page);
}

export async function a_finger_scrolls_the_page_around_a_frame_where_no_arm_is(rig) {
  const page = await rig.open({ ...PHONE, path: "/?embed=1&length=1&theta=20" });
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
