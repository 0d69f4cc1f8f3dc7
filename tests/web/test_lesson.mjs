// What a teacher does in a lesson beside showing and asking: leading the class, another device, questions before the class,
// worksheets at the class's pace, names that are not seen.
// Leaves to others: the room itself (test_room.mjs), a whole lesson (lesson.mjs).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { openDrawer } from "./drawers.mjs";
import { close } from "./rig.mjs";
import { arms, hasArms, join, says, setChain, teach } from "./room.mjs";

export const rig = { store: true, sources: false };

/** Pupils without a browser, who do the same by the interface: a token each. */
async function pupils({ url }, code, names) {
  const tokens = [];
  for (const [i, nickname] of names.entries()) {
    const token = `pupil-${i}-${code}-0123456789abcdef0123`;
    await put(url, `${code}/pupils`, token, { nickname }, "POST");
    tokens.push(token);
  }
  return tokens;
}
async function put(url, path, token, value, method = "PUT") {
  const reply = await fetch(`${url}/v1/classes/${path}`, { method, headers: { "Content-Type": "application/json", "Class-Token": token }, body: JSON.stringify(value) });
  assert.ok(reply.ok, `${path}: ${reply.status} ${await reply.text()}`);
}

const time = (page) => page.evaluate(() => pendulumd.clock.time);
const until = (page, work, value) => page.waitForFunction(work, value, { polling: 50 });

export async function the_class_follows_the_teacher_s_stage_clock_and_drawer(rig) {
  const { page: teacher, code } = await teach(rig);
  const ada = await join(rig, code, "Ada");
  const phone = await join(rig, code, "Ben", { width: 390, height: 664, touch: true });
  const both = [ada, phone];
  await setChain(ada, [1, 2, 3], [10, 20, 30]);
  await teacher.evaluate(() => pendulumd.clock.pause());
  await teacher.click("[data-class=follow]");
  await says(ada, /what your teacher does/);
  await setChain(teacher, [1, 1], [60, 90]);
  for (const page of both) await hasArms(page, 2);
  await teacher.evaluate(() => pendulumd.clock.seek(3.21));
  for (const page of both) await until(page, () => Math.abs(pendulumd.clock.time - 3.21) < 0.01 && !pendulumd.clock.playing);
  await teacher.evaluate(() => pendulumd.clock.play());
  for (const page of both) await until(page, () => pendulumd.clock.playing);
  const [before, there, after] = [await time(teacher), await time(ada), await time(teacher)];
  assert.ok(there > before - 0.6 && there < after + 0.6, `${there} s where the teacher is at ${before} to ${after} s`);
  await openDrawer(teacher, "plots");
  for (const page of both) await page.waitForSelector("[data-drawer=plots]:not([hidden]) [data-chart=energy]");
  await ada.evaluate(() => pendulumd.edits.setMass(1, 5));
  assert.equal(await ada.evaluate(() => pendulumd.store.get().pendulum.mass[0]), 1, "the stage is the teacher's");
  await openDrawer(teacher, "class");
  // who comes later is there at once
  const late = await join(rig, code, "Cem");
  await hasArms(late, 2);
  await ada.reload();
  await says(ada, /what your teacher does/);
  await hasArms(ada, 2);
  await teacher.click("[data-class=own]");
  await hasArms(ada, 3);
  await ada.evaluate(() => pendulumd.edits.setMass(1, 5));
  assert.equal(await ada.evaluate(() => pendulumd.store.get().pendulum.mass[0]), 5, "it is her own again");
  for (const page of [teacher, late, ...both]) await close(page);
}

export async function a_teacher_s_link_leads_the_room_from_another_device(rig) {
  const { page: teacher, code } = await teach(rig);
  await teacher.click("[data-class=lead]");
  await teacher.waitForSelector("dialog.lead svg");
  const token = await teacher.evaluate(() => JSON.parse(sessionStorage.getItem("pendulumd.rooms.tab"))[0].token);
  const other = await rig.open({ path: `/${code}#teach=${token}`, wait: false });
  await other.waitForSelector(".room-code");
  assert.ok(!other.url().includes(token), "the class does not see it in the address");
  await other.click("[data-class=freeze]");
  await teacher.keyboard.press("Escape");
  await teacher.waitForSelector("[data-class=freeze][aria-pressed=true]");
  // one of both presents; the other one ends that
  await other.click("[data-class=freeze]");
  await teacher.click("[data-class=follow]");
  await other.waitForSelector("[data-class=follow][aria-pressed=true]");
  await other.click("[data-class=follow]");
  await teacher.waitForSelector("[data-class=follow][aria-pressed=false]");
  await other.reload();
  await other.waitForSelector(".room-code");
  const stranger = await rig.open({ path: `/${code}#teach=${"x".repeat(43)}`, wait: false });
  stranger.forgiven.push(/40[134]/);
  await stranger.waitForSelector(".notice:not([hidden])");
  assert.equal(await stranger.locator(".room-code").count(), 0, "another token leads nothing");
  for (const page of [teacher, other, stranger]) await close(page);
}

export async function answers_lie_in_round_bins_before_the_class_and_the_right_one_is_marked(rig) {
  const { page: teacher, code } = await teach(rig);
  await teacher.click("[data-class=askForm] summary");
  await teacher.fill("[data-question=text]", "How long does one swing take?");
  await teacher.fill("[data-question=unit]", "s");
  await teacher.fill("[data-question=right]", "2.006");
  await teacher.fill("[data-question=tolerance]", "0.03");
  await teacher.click("[data-class=ask]");
  await teacher.waitForSelector(".asked .question-text");
  const values = [1.832, 1.9, 1.95, 1.98, 1.99, 2, 2.005, 2.006, 2.01, 2.02, 2.1, 2.3];
  const tokens = await pupils(rig, code, values.map((_, i) => `P${i}`));
  for (const [i, token] of tokens.entries()) await put(rig.url, `${code}/answers/q1`, token, { value: values[i] });
  await teacher.waitForSelector("text=12 answers");
  await until(teacher, () => document.querySelector(".histogram li:last-child .bar-words")?.textContent.endsWith("2.3 – 2.35 s"));
  const bars = () => teacher.locator(".histogram li").evaluateAll((rows) => rows.map((row) => [row.querySelector(".bar-words").textContent, Number(row.lastChild.textContent), row.className]));
  const before = await bars();
  assert.ok(before.length >= 5 && before.length <= 12, `${before.length} bins`);
  assert.equal(before.reduce((sum, [, count]) => sum + count, 0), 12, "every answer lies in one");
  for (const [words] of before) assert.match(words, /^[12](\.\d?[05]?)? – [12](\.\d?[05]?)? s$/, "round edges");
  assert.ok(before.every(([, , right]) => !right), "nothing is marked before it is shown");
  await teacher.click("[data-class=largeQuestion]");
  await teacher.click("dialog.bars [data-class=showSolution]");
  await teacher.waitForSelector("dialog.bars .histogram .right");
  const marked = (await bars()).filter(([, , right]) => right);
  assert.deepEqual(marked.map(([words]) => words), ["2 – 2.05 s"]);
  const size = await teacher.evaluate(() => parseFloat(getComputedStyle(document.querySelector("dialog.bars .bar-words")).fontSize));
  assert.ok(size >= 26, `${size} pixels`);
  const end = await teacher.locator("dialog.bars [data-class=closeQuestion]").boundingBox();
  assert.ok(end.y + end.height <= 900, "all of it is on the screen, its buttons too");
  await teacher.keyboard.press("Escape");
  await teacher.waitForSelector(".asked .histogram"); // it hangs in the drawer again
  await close(teacher);
}

export async function a_worksheet_goes_at_the_class_s_pace_and_tells_what_is_right_at_its_end(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "=Ada");
  await setChain(pupil, [1, 2, 3], [10, 20, 30]);
  await teacher.selectOption("[data-class=ours]", "period");
  await teacher.click("[data-class=takeSheet]");
  await teacher.click("[data-edit=period]");
  await teacher.selectOption("[data-sheet=feedback]", "at_end");
  await teacher.click("[data-sheet=save]");
  await teacher.click("[data-give=period]");
  await teacher.selectOption("[data-class=pace]", "1");
  await pupil.waitForSelector(".given-sheet h3");
  assert.equal(await pupil.locator("[data-tab=worksheet]").count(), 0, "a pupil's worksheet has one place");
  const answer = async (value) => {
    await pupil.fill(".given-sheet [data-answer]", value);
    await pupil.click("[data-sheet=answer]");
  };
  await answer("3");
  await pupil.waitForSelector("text=/saved.*opens the next step/");
  await teacher.waitForSelector(".cell-note >> text=1 of 5 answered");
  await answer("2.01");
  await pupil.waitForSelector("text=/earlier: 3 s/");
  assert.equal(await pupil.locator("text=/Correct|Not correct/").count(), 0, "nothing is told before the end");
  assert.ok(await pupil.isDisabled("[data-step='2']"));
  await teacher.selectOption("[data-class=pace]", "0");
  await pupil.waitForSelector("[data-step='2']:not(:disabled)");
  await pupil.click("[data-step='2']");
  await answer("5");
  for (const choice of [2, 1]) {
    await pupil.click(`.given-sheet [data-choice='${choice}']`);
    await pupil.click("[data-sheet=answer]");
  }
  await answer("2");
  await pupil.waitForSelector("text=Handed in: 3 of 5 correct.");
  assert.deepEqual(await pupil.locator(".step-number").allTextContents(), ["✓", "✗", "✓", "✓", "✗"]);
  await pupil.click("[data-sheet=mine]");
  await hasArms(pupil, 3);

  await teacher.click("[data-answers=period]");
  await teacher.waitForSelector(".answers tbody tr");
  const table = await teacher.innerText(".answers");
  assert.match(table, /Measure, s\s+How long does it take there and back/, "the question and its unit");
  assert.match(table, /✓ 2\.01 s\s+\(earlier: 3 s\)/);
  assert.match(table, /✗ 2 s/);
  assert.match(await teacher.innerText(".answers tfoot"), /1 \/ 1\s+0 \/ 1/);
  await teacher.keyboard.press("Escape");
  const [saved] = await Promise.all([teacher.waitForEvent("download"), teacher.click("[data-class=table]")]);
  const rows = readFileSync(await saved.path(), "utf8").trim().split("\r\n");
  assert.equal(rows.length, 6);
  assert.match(rows[1], /^"Period and length","Measure","How long .*","s","'=Ada",2\.01,1,"3 s",/);
  assert.match(rows[3], /"it stays the same",1,"",/, "a choice in words");
  assert.match(rows[5], /"s","'=Ada",2,0,/);
  for (const page of [teacher, pupil]) await close(page);
}

export async function the_wall_fills_its_screen_and_names_can_be_hidden(rig) {
  const { page: teacher, code } = await teach(rig);
  const tokens = await pupils(rig, code, ["Ada", "Ben", "Ada"]);
  const request = { pendulum: { length: [1], mass: [1], parent: [0], gravity: 9.81 }, initial: { phi: [-1], phid: [0] }, times: { stop: 5, step: 0.05 } };
  for (const token of tokens) await put(rig.url, `${code}/stages/own`, token, { scene: { request } });
  await teacher.waitForFunction(() => document.querySelectorAll(".cell canvas").length === 3);
  assert.deepEqual(await teacher.locator(".cell-name").allTextContents(), ["Ada", "Ada (2)", "Ben"], "two of one name are told apart");
  await teacher.click("[data-class=large]");
  const picture = await teacher.locator(".cell canvas").first().boundingBox();
  assert.ok(picture.width > 330, `${picture.width} pixels of 1280 for one of three`);
  const font = await teacher.evaluate(() => parseFloat(getComputedStyle(document.querySelector(".cell-name")).fontSize));
  assert.ok(font >= 24, `${font} pixels`);
  await teacher.click("[data-class=anonymous]");
  assert.deepEqual(await teacher.locator(".cell-name").allTextContents(), ["Pupil 1", "Pupil 2", "Pupil 3"]);
  await teacher.keyboard.press("Escape");
  assert.ok((await teacher.locator(".cell").first().boundingBox()).width < 250);
  await close(teacher);
}

export async function a_look_at_worksheets_leaves_the_stage_and_one_s_own_comes_back(rig) {
  const page = await rig.open({ path: "/?length=3,1&theta=20,30" });
  await openDrawer(page, "worksheet");
  await page.waitForSelector("[data-sheet=begin]");
  assert.equal(await arms(page), 2, "looking changes nothing");
  await page.click("[data-sheet=begin]");
  await hasArms(page, 1);
  await page.click("[data-sheet=mine]");
  await hasArms(page, 2);
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().pendulum.length), [3, 1]);
  await close(page);
}
