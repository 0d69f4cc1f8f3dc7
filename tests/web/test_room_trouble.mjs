// A class when things go wrong: a server that is away, two tabs of one teacher, two pupils of one name, one who comes late, a room
// that ends while somebody writes; and a language from right to left.
// Leaves to others: what a class does when all goes well (test_room.mjs), thirty pages (lesson.mjs).

import assert from "node:assert/strict";
import { ARABIC, arabic } from "./arabic.mjs";
import { openDrawer } from "./drawers.mjs";
import { close } from "./rig.mjs";
import { cell, hasArms, join, says, setChain, teach } from "./room.mjs";

export const rig = { store: true };

/** A server that ends every connection to a room until it is told to be back. */
function away(rig) {
  rig.front.fault = (asked, reply) => asked.url.startsWith("/v1/classes") && Boolean(reply.destroy());
  return () => { rig.front.fault = null; };
}
const forgive = (...pages) => pages.forEach((page) => page.forgiven.push(/Failed to load|net::ERR/));
const waits = (page, where = "") => page.waitForSelector(`${where} .away:not([hidden]) >> text=/does not answer/`);

export async function who_waits_for_a_server_that_is_away_is_told_so(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await rig.open({ path: `/?room=${code}`, still: true });
  forgive(teacher, pupil);
  let back = away(rig);
  await pupil.fill("[data-class=nickname]", "Ada");
  await pupil.press("[data-class=nickname]", "Enter");
  await waits(pupil);
  await rig.shot(pupil, "room-away-join");
  back();
  await pupil.click(".away:not([hidden]) button");
  await says(pupil, /your own pendulum/);
  back = away(rig);
  await pupil.reload();
  await waits(pupil);
  assert.match(await pupil.innerText(".class-body"), /Joining the room/);
  back();
  await pupil.click(".away:not([hidden]) button");
  await says(pupil, /your own pendulum/);

  await teacher.selectOption("[data-class=ours]", "period");
  await teacher.click("[data-class=takeSheet]");
  await teacher.click("[data-give=period]");
  await pupil.waitForSelector(".given-sheet [data-answer]");
  back = away(rig);
  await pupil.fill(".given-sheet [data-answer]", "2.0");
  await pupil.click("[data-sheet=answer]");
  await pupil.waitForSelector(".sheet .mark >> text=Sending");
  back();
  await pupil.waitForSelector(".sheet .mark >> text=/Correct/");
  await teacher.waitForSelector("text=1 working, 0 handed in");
  for (const page of [teacher, pupil]) await close(page);
}

export async function a_teachers_room_is_forgotten_with_its_tab_and_many_pupils_go_at_once(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupils = [await join(rig, code, "Anna"), await join(rig, code, "\u0410nna"), await join(rig, code, "Bo")];
  await cell(teacher, "\u0410nna (2)").waitFor();
  assert.deepEqual(await teacher.evaluate(() => JSON.parse(localStorage.getItem("pendulumd.rooms") ?? "[]")), []);
  // the next one at this computer is no teacher, and the tab's own reload is
  const next = await teacher.context().newPage();
  await next.goto(`${rig.url}/${code}`);
  await next.waitForSelector("[data-class=nickname]");
  await next.close();
  await teacher.reload();
  await teacher.waitForSelector(".room-code");
  await teacher.click("[data-class=removeMany]");
  for (const number of [1, 2]) await teacher.check(`[data-remove='${number}']`);
  await teacher.click("[data-class=removeManyGo]");
  for (const pupil of pupils.slice(0, 2)) await pupil.waitForSelector("text=This room has ended");
  await cell(teacher, "Bo").waitFor();
  assert.equal(await teacher.locator(".cell").count(), 1);
  await teacher.fill("[data-class=share]", "120");
  await teacher.press("[data-class=share]", "Tab");
  await teacher.waitForFunction(() => document.querySelector("[data-class=share]").defaultValue === "120");
  for (const page of [teacher, ...pupils]) await close(page);
}

export async function two_tabs_of_one_teacher_show_the_same_and_act_one_after_the_other(rig) {
  const { page: teacher, code } = await teach(rig, { remembered: true });
  const pupil = await join(rig, code, "Ada");
  const tab = await teacher.context().newPage();
  await tab.goto(`${rig.url}/${code}`);
  await tab.waitForSelector(".room-code");
  await setChain(teacher, [1, 1], [60, 60]);
  await teacher.click("[data-class=push]");
  await tab.waitForSelector("text=Everybody has your pendulum.");
  await tab.click("[data-class=freeze]");
  await says(pupil, /frozen all stages/);
  await hasArms(pupil, 2);
  await teacher.waitForSelector("text=Everybody has your pendulum, frozen.");
  assert.equal(await teacher.getAttribute("[data-class=freeze]", "aria-pressed"), "true");
  // the same moment: what holds is one of both, everywhere
  await setChain(tab, [1, 1, 1], [10, 10, 10]);
  await Promise.all([tab.click("[data-class=push]"), teacher.click("[data-class=own]")]);
  const stage = async (page) => page.textContent(".show-part .class-now");
  const rest = async () => new Set([await stage(teacher), await stage(tab)]).size === 1;
  for (let i = 0; i < 400 && !(await rest()); i++) await teacher.waitForTimeout(50);
  assert.ok(await rest(), `${await stage(teacher)} ${await stage(tab)}`);
  await says(pupil, /^Everybody works/.test(await stage(teacher)) ? /your own pendulum/ : /Everybody has the same|frozen/);
  // a room that one tab forgets stays in the other; one that it ends is over in both
  tab.on("dialog", (dialog) => dialog.accept());
  await tab.click("[data-class=erase]");
  for (const page of [teacher, pupil]) await page.waitForSelector("text=This room has ended");
  await tab.close();
  for (const page of [teacher, pupil]) await close(page);
}

export async function two_pupils_of_one_name_and_one_who_comes_late(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupils = [await join(rig, code, "Ada"), await join(rig, code, "Ada")];
  await teacher.waitForFunction(() => document.querySelectorAll(".cell canvas").length === 2);
  await setChain(pupils[1], [1], [45]);
  await pupils[1].click("[data-state=stuck]");
  await cell(teacher, "Ada").and(teacher.locator("[data-state=stuck]")).waitFor();
  assert.equal(await cell(teacher, "Ada").and(teacher.locator("[data-state=stuck]")).count(), 1, "each is a pupil of its own");
  await setChain(teacher, [1, 1], [60, 60]);
  await teacher.click("[data-class=push]");
  await teacher.click("[data-class=freeze]");
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "What do you see?");
  await teacher.selectOption("[data-question=kind]", "text");
  await teacher.click("[data-class=ask]");
  const late = await join(rig, code, "Late");
  await says(late, /frozen all stages/);
  await hasArms(late, 2);
  await late.waitForSelector("text=What do you see?");
  for (const page of [...pupils, late]) {
    await page.fill("[data-answer]", "a swing");
    await page.click("[data-class=answer]");
    await page.waitForSelector("text=/^Sent/");
  }
  await teacher.waitForFunction(() => document.querySelector(".asked .counts")?.textContent === "3 answers");
  await teacher.click("[data-class=shut]");
  await teacher.waitForSelector("[data-class=shut][aria-pressed=true]");
  const shut = await rig.open({ path: `/?room=${code}`, still: true });
  shut.forgiven.push(/403/);
  await shut.fill("[data-class=nickname]", "Too late");
  await shut.press("[data-class=nickname]", "Enter");
  await shut.waitForSelector(`text=Room ${code} is closed`);
  for (const page of [teacher, ...pupils, late, shut]) await close(page);
}

export async function a_question_that_is_taken_back_and_a_room_that_ends_while_one_answers_are_told(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "Ada");
  for (const page of [teacher, pupil]) page.forgiven.push(/404|409/); // who asks while the room goes
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "How long?");
  await teacher.click("[data-class=ask]");
  await pupil.waitForSelector("[data-answer]");
  await pupil.fill("[data-answer]", "1");
  await Promise.all([teacher.click("[data-class=closeQuestion]"), pupil.press("[data-answer]", "Enter")]);
  await pupil.waitForSelector("text=This question is closed.");
  await teacher.click("[data-class=closeQuestion]");
  await pupil.waitForSelector("[data-answer]");
  await pupil.fill("[data-answer]", "2");
  teacher.on("dialog", (dialog) => dialog.accept());
  await Promise.all([teacher.click("[data-class=erase]"), pupil.press("[data-answer]", "Enter")]);
  await pupil.waitForSelector("text=This room has ended");
  assert.equal(await pupil.evaluate(() => JSON.parse(localStorage.getItem("pendulumd.rooms")).length), 0);
  await openDrawer(pupil, "plots");
  await pupil.waitForFunction(() => pendulumd.motion.complete);
  for (const page of [teacher, pupil]) await close(page);
}

export async function a_class_works_from_right_to_left(rig) {
  const english = {};
  for (const part of ["page", "drawers", "class"]) english[part] = (await import(`../../server/web/text/en/${part}.js`)).default;
  arabic(rig, english);
  const { page: teacher, code } = await teach(rig, { path: "/?lang=ar", cold: true });
  const pupil = await join(rig, code, "ليلى", { path: `/?lang=ar&room=${code}`, cold: true, width: 390, height: 844 });
  await cell(teacher, "ليلى").waitFor();
  assert.equal((await teacher.textContent(".counts")).split(" \u00b7 ")[0], ARABIC["class.pupils.one"]);
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "كم تدوم أرجحة واحدة؟");
  await teacher.click("[data-class=ask]");
  await pupil.waitForSelector("[data-answer]");
  const box = (page, selector) => page.evaluate((what) => document.querySelector(what).getBoundingClientRect().toJSON(), selector);
  const [push, freeze] = [await box(teacher, "[data-class=push]"), await box(teacher, "[data-class=freeze]")];
  assert.ok(push.right > freeze.right, "a row begins at the right");
  for (const [page, name] of [[teacher, "teacher"], [pupil, "pupil"]]) {
    assert.equal(await page.evaluate(() => document.documentElement.dir), "rtl");
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: too wide`);
    await rig.shot(page, `room-rtl-${name}`);
  }
  assert.match(await teacher.innerText(".room-code"), /^[A-Z2-9]{6}$/);
  for (const page of [teacher, pupil]) await close(page);
}

export async function a_page_that_gives_no_sign_is_not_at_work(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "Ada");
  const at = (state) => cell(teacher, "Ada").and(teacher.locator(`[data-state=${state}]`)).waitFor();
  await at("working");
  // the page says that it is awake though nobody touches it
  await teacher.evaluate(() => {
    const parse = JSON.parse; // of each event
    JSON.parse = (...given) => {
      const told = parse(...given);
      if (told?.name === "stages/1" && told.value?.idle > 10) window.awake = true;
      return told;
    };
  });
  await teacher.waitForFunction(() => window.awake);
  assert.match(await teacher.innerText(".counts"), /1 working/);
  await pupil.session.send("Page.setWebLifecycleState", { state: "frozen" });
  // a minute and a half later
  await teacher.evaluate(() => {
    const native = performance.now.bind(performance);
    performance.now = () => native() + 95000;
  });
  await at("silent");
  await teacher.waitForSelector(".counts >> text=1 not connected");
  assert.match(await cell(teacher, "Ada").innerText(), /no connection for \d+ min/);
  await rig.shot(teacher, "room-silent");
  await teacher.evaluate(() => { delete performance.now; });
  await pupil.session.send("Page.setWebLifecycleState", { state: "active" });
  await at("working");
  for (const page of [teacher, pupil]) await close(page);
}
