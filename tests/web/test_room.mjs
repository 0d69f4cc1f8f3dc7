// A room of a class in real browsers: a teacher and pupils, what one does and the others see.
// Leaves to others: the server's side of it (tests/wire/test_classes.c), thirty pages (lesson.mjs).

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, refuseStorage } from "./rig.mjs";
import { arms, cell, hasArms, join, says, setChain, teach } from "./room.mjs";

export const rig = { store: true, sources: false };

export async function what_the_teacher_shows_everybody_sees_and_then_has_its_own_again(rig) {
  const { page: teacher, code } = await teach(rig);
  const ada = await join(rig, code, "Ada");
  const ben = await join(rig, code, "Ben");
  await setChain(ada, [1, 2, 3], [10, 20, 30]);
  await says(ada, /your own pendulum/);
  await teacher.waitForFunction(() => document.querySelectorAll(".cell canvas").length === 2);
  assert.match(await teacher.textContent(".counts"), /2 pupils/);

  await setChain(teacher, [1, 1], [90, 90]);
  await teacher.click("[data-class=push]");
  for (const page of [ada, ben]) await hasArms(page, 2);
  await says(ben, /Everybody has the same pendulum/);
  await teacher.click("[data-class=freeze]");
  for (const page of [ada, ben]) await says(page, /frozen all stages/);
  await ben.evaluate(() => pendulumd.edits.setMass(1, 5));
  assert.equal(await ben.evaluate(() => pendulumd.store.get().pendulum.mass[0]), 1, "a frozen stage does not change");
  assert.equal(await ben.evaluate(() => document.querySelector("#stage").inert), true);
  assert.match(await ben.textContent("[data-room]"), /frozen/, "the page's head says so");
  await rig.shot(ben, "room-frozen");
  await teacher.click("[data-class=freeze]");
  await says(ada, /Everybody has the same/);
  await ben.evaluate(() => pendulumd.edits.setMass(1, 5));
  assert.equal(await ben.evaluate(() => pendulumd.store.get().pendulum.mass[0]), 5);

  await teacher.click("[data-class=own]");
  await hasArms(ada, 3);
  await hasArms(ben, 1);
  await says(ada, /your own pendulum/);
  await rig.shot(teacher, "room-teacher");
  for (const page of [teacher, ada, ben]) await close(page);
}

export async function who_needs_help_is_seen_at_once_and_a_name_is_text(rig) {
  const { page: teacher, code } = await teach(rig);
  const name = "<img src=x onerror=alert(1)>";
  const pupil = await join(rig, code, name);
  await pupil.click("[data-state=stuck]");
  await cell(teacher, name).and(teacher.locator("[data-state=stuck]")).waitFor();
  assert.equal(await teacher.locator(".cell-name").textContent(), name);
  assert.equal(await teacher.locator(".wall img").count() + await pupil.locator(".class-body img").count(), 0);
  await setChain(pupil, [1], [45]);
  await pupil.waitForTimeout(1500); // until the stage is sent, at its pace
  await teacher.click("[data-pupil='1']");
  await teacher.waitForSelector("dialog.pupil canvas");
  await rig.shot(teacher, "room-enlarged");
  await teacher.click("[data-class=take]");
  await hasArms(teacher, 1);
  for (const page of [teacher, pupil]) await close(page);
}

export async function a_reload_and_a_dead_line_cost_nothing(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "Ada");
  pupil.forgiven.push(/net::ERR|Failed to load/);
  await setChain(pupil, [1, 2, 3], [10, 20, 30]);
  await teacher.waitForSelector(".cell canvas");
  await pupil.waitForTimeout(1500); // until the stage is sent, at its pace
  await pupil.reload();
  await hasArms(pupil, 3);
  await says(pupil, /your own pendulum/);
  assert.match(await pupil.textContent("[data-room]"), new RegExp(code));
  await pupil.context().setOffline(true);
  await says(pupil, /No connection/);
  await setChain(teacher, [1, 1], [90, 90]);
  await teacher.click("[data-class=push]");
  await pupil.context().setOffline(false);
  await hasArms(pupil, 2);
  await pupil.reload();
  await says(pupil, /Everybody has the same/);
  await teacher.reload();
  await teacher.waitForSelector(".room-code");
  assert.equal(await teacher.textContent(".room-code"), code);
  await teacher.click("[data-class=own]");
  await hasArms(pupil, 3);
  for (const page of [teacher, pupil]) await close(page);
}

export async function the_end_of_a_room_is_told_and_wrong_codes_are_refused_in_words(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "Ada");
  teacher.on("dialog", (dialog) => dialog.accept());
  await teacher.click("[data-class=erase]");
  await pupil.waitForSelector("text=This room has ended");
  assert.equal(await pupil.evaluate(() => JSON.parse(localStorage.getItem("pendulumd.rooms")).length), 0, "nothing of it stays in the browser");
  pupil.forgiven.push(/404/);
  await pupil.fill("[data-class=nickname]", "Ada");
  await pupil.click("[data-class=join]");
  await pupil.waitForSelector(`text=There is no room ${code}`);
  await pupil.fill("[data-class=code]", "0");
  await pupil.click("[data-class=join]");
  await pupil.waitForSelector("text=six letters and digits");
  for (const page of [teacher, pupil]) await close(page);
}

export async function the_room_works_where_the_browser_keeps_nothing(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await rig.open({ cold: true, still: true, wait: false });
  await refuseStorage(pupil);
  await pupil.goto(`${rig.url}/?room=${code}`);
  await pupil.fill("[data-class=nickname]", "Ada");
  await pupil.press("[data-class=nickname]", "Enter");
  await says(pupil, /your own pendulum/);
  await pupil.reload();
  await says(pupil, /your own pendulum/);
  assert.match(await teacher.textContent(".counts"), /^1 pupil\b/, "the same pupil");
  for (const page of [teacher, pupil]) await close(page);
}

export async function a_room_is_accessible_dark_and_on_a_phone(rig) {
  const bad = [];
  const { page: teacher, code } = await teach(rig, { dark: true, language: "de" });
  const phone = await join(rig, code, "Ada", { width: 390, height: 844, touch: true });
  await teacher.waitForSelector(".cell canvas");
  for (const [page, name] of [[teacher, "teacher"], [phone, "phone"]]) {
    await rig.shot(page, `room-${name}`);
    bad.push(...await violations(page, { context: { include: ["[data-drawer=class]", "#header"] }, colours: true }));
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    if (wide > 0) bad.push(`${name}: ${wide} pixels too wide`);
  }
  await teacher.click("[data-class=showCode]");
  await teacher.waitForSelector("dialog.code svg");
  await rig.shot(teacher, "room-code");
  const { default: shares } = await import("../../server/web/text/de/drawers.js");
  assert.ok((await teacher.innerText("dialog.code")).includes(shares["share.local"]), "a class cannot come to this machine's own address");
  await teacher.click("dialog.code .icon-button");
  await teacher.click("[data-class=large]");
  await rig.shot(teacher, "room-board");
  await teacher.keyboard.press("Escape");
  await teacher.click("[data-class=kept]");
  await rig.shot(teacher, "room-kept");
  const points = await teacher.locator("dialog.kept dt").allTextContents();
  const { default: german } = await import("../../server/web/text/de/class.js");
  const keys = Object.keys(german).filter((key) => /^class\.kept\.\w+\.name$/.test(key));
  assert.deepEqual([...points].sort(), keys.map((key) => german[key]).sort(), "every point that there are words for is told");
  assert.deepEqual((await teacher.locator("dialog.kept dd").allTextContents()).filter((words) => words.length < 40), [], "each in a sentence");
  assert.ok(points.includes(german["class.kept.passed.name"]), "who else gets it");
  assert.deepEqual(bad, []);
  for (const page of [teacher, phone]) await close(page);
}

export async function nothing_of_a_class_is_loaded_without_one(rig) {
  const page = await rig.open();
  const loaded = () => page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name).filter((name) => name.includes("class")));
  assert.deepEqual(await loaded(), []);
  await openDrawer(page, "class");
  await page.waitForSelector("[data-class=join]");
  const there = await loaded();
  assert.ok(there.some((name) => name.endsWith("drawers/class.js")) && !there.some((name) => /teach.js|learn.js/.test(name)), there.join(" "));
  assert.equal(await arms(page), 4);
  await close(page);
}

const answer = async (page, value) => {
  await page.fill("[data-answer]", value);
  await page.press("[data-answer]", "Enter");
  await page.waitForSelector("text=/^Sent/");
};

export async function what_is_asked_is_answered_and_counted_at_once(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupils = [await join(rig, code, "Ada"), await join(rig, code, "Ben")];
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "How long does <b>one</b> swing take?");
  await teacher.fill("[data-question=unit]", "s");
  await teacher.fill("[data-question=right]", "2");
  await teacher.fill("[data-question=tolerance]", "0.1");
  await teacher.click("[data-class=ask]");
  for (const page of pupils) await page.waitForSelector("text=How long does <b>one</b> swing take?");
  await answer(pupils[0], "2.05");
  await answer(pupils[1], "3");
  await teacher.waitForFunction(() => document.querySelectorAll(".histogram li").length === 2);
  assert.match(await teacher.textContent(".asked .counts"), /2 answers/);
  await rig.shot(teacher, "room-asked");
  await rig.shot(pupils[0], "room-answered");
  assert.equal(await teacher.locator(".histogram .right").count(), 0);
  assert.doesNotMatch(await teacher.innerText(".asked"), /answer: 2/, "a beamer shows what is right only when pupils see it");
  await teacher.click("[data-class=showSolution]");
  await teacher.waitForFunction(() => document.querySelectorAll(".histogram .right").length === 1 && /answer: 2/.test(document.querySelector(".asked").innerText));
  await pupils[0].waitForSelector("text=Correct. The answer: 2 s.");
  await pupils[1].waitForSelector("text=Not quite. The answer: 2 s.");
  await teacher.click("[data-class=closeQuestion]");
  await pupils[1].waitForSelector("text=This question is closed.");

  await teacher.click("[data-class=askForm] summary");
  await teacher.selectOption("[data-question=kind]", "choice");
  await teacher.fill("[data-question=choices]", "shorter\nas long\nlonger");
  await teacher.fill("[data-question=right]", "3");
  await teacher.click("[data-class=ask]");
  await pupils[0].click("[data-choice='3']");
  await pupils[0].click("[data-class=answer]");
  await teacher.waitForFunction(() => [...document.querySelectorAll(".histogram .bar-words")].some(({ textContent }) => textContent === "longer"));
  await teacher.click("[data-class=showSolution]");
  await teacher.waitForFunction(() => document.querySelector(".histogram .right .bar-words")?.textContent === "longer" && document.querySelector(".histogram .right .bar-count").textContent === "1");
  assert.match(await (await teacher.context().request.get(`${rig.url}/v1/classes/${code}/table`, { headers: { "Class-Token":
    await teacher.evaluate(() => JSON.parse(sessionStorage.getItem("pendulumd.rooms.tab"))[0].token) } })).text(), /answers,q1,,1,"Ada",2.05/);
  for (const page of [teacher, ...pupils]) await close(page);
}

export async function all_let_go_together_and_their_starts_lie_in_one_picture(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupils = [await join(rig, code, "Ada"), await join(rig, code, "Ben"), await join(rig, code, "Cem")];
  await setChain(teacher, [1, 1], [120, 120]);
  await teacher.selectOption("[data-class=spread]", "0.001");
  await teacher.click("[data-class=release]");
  for (const page of pupils) await hasArms(page, 2);
  const starts = await Promise.all(pupils.map((page) => page.evaluate(() => pendulumd.store.get().initial.phi[0])));
  assert.ok(Math.abs(Math.max(...starts) - Math.min(...starts) - 0.001) < 1e-9, `${starts}`);
  await teacher.click("[data-class=together]");
  await teacher.waitForSelector("text=/3 starting positions.*They begin 0.001 rad apart.*exponent:/");
  await rig.shot(teacher, "room-together");
  await teacher.keyboard.press("Escape");
  // by hand: the pendulum hangs, and is let go when its pupil says so
  await teacher.selectOption("[data-class=spread]", "hand");
  await teacher.click("[data-class=release]");
  await pupils[0].waitForSelector("[data-class=letGo]");
  assert.equal(await pupils[0].evaluate(() => pendulumd.store.get().initial.phi[0]), -Math.PI / 2);
  await rig.shot(pupils[0], "room-by-hand");
  await setChain(pupils[0], [1, 1], [118, 121]);
  await pupils[0].click("[data-class=letGo]");
  await teacher.click("[data-class=together]");
  await teacher.waitForSelector("text=/1 starting position\\./");
  for (const page of [teacher, ...pupils]) await close(page);
}
