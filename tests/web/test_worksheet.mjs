// Worksheets in real browsers: alone, by keyboard and in few actions; in a room, written, handed out, answered, handed in.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { ROOT, close } from "./rig.mjs";
import { SHIPPED, translated } from "../../server/web/class/shipped.js";
import { LANGUAGES } from "../../server/web/text/languages.js";
import { arms, hasArms, join, teach } from "./room.mjs";
import { checkStatement } from "./xapi.mjs";

export const rig = { store: true, sources: false };

const step = (page, title) => page.waitForFunction((words) => document.querySelector(".step h3")?.textContent === words, title);

export async function the_five_experiments_take_twelve_actions(rig) {
  const page = await rig.open({ height: 1000 });
  let actions = 0;
  const click = async (selector) => { actions++; await page.click(selector); };
  await click('[data-tab="worksheet"]');
  await click("[data-sheet=begin]");
  await step(page, "One arm");
  assert.equal(await arms(page), 1, "a step sets the stage");
  assert.ok(await page.isDisabled("[data-step='2']"), "one goes on with the right answer only");
  actions++;
  await page.fill("[data-answer]", "4");
  await click("[data-sheet=answer]");
  for (const [title, choice] of [["Two arms", 2], ["Two starts, nearly the same", 3], ["The swings that repeat", 2], ["Pulling and pushing", 2]]) {
    await step(page, title);
    await click(`[data-choice='${choice}']`);
    await click("[data-sheet=answer]");
  }
  await page.waitForSelector("text=Handed in: 5 of 5 correct.");
  assert.equal(await page.locator(".step-key.done").count(), 5);
  assert.ok(actions <= 12, `${actions} actions`);
  await rig.shot(page, "worksheet-done");
  await page.reload();
  await openDrawer(page, "worksheet");
  await page.click("[data-sheet=begin]");
  await page.waitForSelector("[data-step='5']");
  assert.equal(await page.locator(".step-key.done").count(), 5, "what was answered stays answered");
  await close(page);
  return `${actions} actions`;
}

export async function a_wrong_answer_shows_the_hint_and_keys_suffice(rig) {
  const page = await rig.open({ height: 1000 });
  await openDrawer(page, "worksheet");
  await page.focus("[data-sheet=which]");
  await page.selectOption("[data-sheet=which]", "tension");
  await page.press("[data-sheet=begin]", "Enter");
  await step(page, "At the lowest point");
  await page.focus("[data-answer]");
  await page.keyboard.type("12");
  await page.keyboard.press("Enter");
  await page.waitForSelector("text=Not yet.");
  assert.ok(await page.isVisible(".step details p"), "the hint is open");
  await page.fill("[data-answer]", "29.4");
  await page.keyboard.press("Enter");
  await step(page, "Pushing");
  await page.evaluate(() => pendulumd.edits.grab());
  await page.evaluate(() => { pendulumd.edits.turn(1, -Math.PI / 2 + 91 * Math.PI / 180); pendulumd.clock.pause(); });
  await page.click("[data-class=angle]");
  assert.equal(await page.inputValue("[data-answer]"), "91", "an angle is taken from the stage, from hanging");
  await page.evaluate(() => pendulumd.edits.release());
  await page.click("[data-sheet=answer]");
  await step(page, "Of strings?");
  await page.focus("[data-step='3']");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("Enter");
  await step(page, "Pushing");
  const [printed] = await Promise.all([page.evaluate(() => new Promise((resolve) => {
    window.print = () => { resolve(document.querySelector(".print-sheet").textContent); window.dispatchEvent(new Event("afterprint")); };
    document.querySelector("[data-sheet=print]").click();
  }))]);
  assert.match(printed, /Your answer: 29\.4 N.*Your answer: 91°/s);
  assert.deepEqual(await violations(page, { context: { include: ["[data-drawer=worksheet]"] }, colours: false }), []);
  await close(page);
}

export async function every_worksheet_of_ours_is_one_that_a_room_takes(rig) {
  const { page, code } = await teach(rig);
  const token = await page.evaluate(() => JSON.parse(sessionStorage.getItem("pendulumd.rooms.tab"))[0].token);
  const folder = `${ROOT}server/web/sheets/`;
  assert.deepEqual(readdirSync(folder).sort(), SHIPPED.map((id) => `${id}.json`).sort());
  const read = (file) => JSON.parse(readFileSync(`${ROOT}server/web/${file}`, "utf8"));
  for (const name of SHIPPED) {
    const sheet = read(`sheets/${name}.json`);
    for (const language of Object.keys(LANGUAGES)) {
      const said = translated(sheet, language === "en" ? {} : read(`text/${language}/sheets.json`), language);
      assert.ok(said.language === language && (language === "en") === (JSON.stringify(said.steps) === JSON.stringify(sheet.steps)), `${name} in ${language}`);
      const reply = await fetch(`${rig.url}/v1/classes/${code}/worksheets/${name}-${language}`,
        { method: "PUT", headers: { "Content-Type": "application/json", "Class-Token": token }, body: JSON.stringify(said) });
      assert.equal(reply.status, 200, `${name}: ${await reply.text()}`);
    }
    for (const { scene } of sheet.steps) {
      if (!scene) continue;
      const motion = await fetch(`${rig.url}/v1/trajectories`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(scene.request) });
      assert.equal(motion.status, 200, `${name}: ${await motion.text()}`);
    }
  }
  await close(page);
}

export async function a_worksheet_is_written_handed_out_answered_and_handed_in(rig) {
  const { page: teacher, code } = await teach(rig);
  const pupil = await join(rig, code, "Ada");
  await teacher.click("[data-class=newSheet]");
  await teacher.fill("[data-sheet=title]", "<i>Mine</i>");
  const field = (n, name) => teacher.locator(".edit-step").nth(n).locator(`[data-step-field=${name}], [data-question=${name}]`).first();
  await field(0, "title").fill("Last");
  await field(0, "asks").check();
  await teacher.locator(".edit-step").nth(0).locator("[data-question=text]").fill("How long?");
  await teacher.locator(".edit-step").nth(0).locator("[data-question=right]").fill("2");
  await field(0, "needs").selectOption("right");
  await field(0, "hidden").check();
  await teacher.click("[data-sheet=add]");
  await field(1, "title").fill("First");
  await field(1, "scene").click();
  await field(1, "asks").check();
  await teacher.locator(".edit-step").nth(1).locator("[data-question=text]").fill("What do you see?");
  await teacher.locator(".edit-step").nth(1).locator("[data-question=kind]").selectOption("text");
  await field(1, "up").click();
  assert.equal(await field(0, "title").inputValue(), "First", "a button changes the order");
  await rig.shot(teacher, "sheet-editor");
  await teacher.click("[data-sheet=save]");
  await teacher.click("[data-give=sheet]");

  await pupil.waitForSelector("text=<i>Mine</i>");
  await step(pupil, "First");
  await hasArms(pupil, 4);
  assert.equal(await pupil.locator(".step-key").count(), 1, "the second step is hidden");
  await pupil.fill(".given-sheet [data-answer]", "<script>alert(1)</script>");
  await pupil.click("[data-sheet=answer]");
  await step(pupil, "Last");
  await pupil.reload();
  await step(pupil, "Last");
  await pupil.fill(".given-sheet [data-answer]", "2");
  await pupil.click("[data-sheet=answer]");
  await pupil.waitForSelector("text=Handed in: 1 of 1 correct.");
  await rig.shot(pupil, "sheet-pupil");
  await teacher.waitForSelector("text=1 working, 1 handed in");
  await teacher.click("[data-answers=sheet]");
  await teacher.waitForSelector(".answers tbody tr");
  assert.match(await teacher.textContent(".answers tbody"), /Ada.*handed in.*<script>alert\(1\)<\/script>.*✓ 2/s);
  await rig.shot(teacher, "sheet-answers");
  await teacher.keyboard.press("Escape");
  const [saved] = await Promise.all([teacher.waitForEvent("download"), teacher.click("[data-class=statements]")]);
  const told = JSON.parse(readFileSync(await saved.path(), "utf8"));
  told.forEach(checkStatement);
  assert.deepEqual(told.map(({ verb, actor, result }) => [verb.id.split("/").pop(), actor.account.name, result.response ?? result.score.raw]),
    [["answered", "1", "<script>alert(1)</script>"], ["answered", "1", "2"], ["completed", "1", 1]]);
  assert.ok(!JSON.stringify(told).includes("Ada"), "nobody is named");
  for (const page of [teacher, pupil]) await close(page);
}

// a person at the keys (Card, Moran and Newell, CACM 23, 1980): s for a letter typed slowly, for pointing and clicking, for thinking
const KEY = 0.5, POINT = 1.2, THINK = 1.35, MINUTES = 3;

/** Writes a worksheet of three steps and hands it out; the actions, letters, and seconds that the browser took. */
async function writeThree(teacher, pause) {
  const done = { actions: 0, letters: 0 };
  const act = async (letters, what) => {
    done.actions++;
    done.letters += letters.length;
    if (pause) await teacher.waitForTimeout(1000 * (THINK + POINT + KEY * letters.length));
    await what();
  };
  const part = (n) => teacher.locator(".edit-step").nth(n);
  const click = (where) => act("", () => where.click());
  const type = (where, words) => act(words, () => where.fill(words));
  const begun = performance.now();
  await click(teacher.locator("[data-class=newSheet]"));
  await type(teacher.locator("[data-sheet=title]"), "The period of a pendulum");
  const asked = [["One arm", "How long does one swing take?", "2"], ["Four times as long", "How long does it take now?", "4"], ["On the Moon", "And with a sixth of the weight?", "4.9"]];
  for (const [n, [title, question, right]] of asked.entries()) {
    if (n) await click(teacher.locator("[data-sheet=add]"));
    await type(part(n).locator("[data-step-field=title]"), title);
    if (!n) await click(part(n).locator("[data-step-field=asks]"));
    await type(part(n).locator("[data-question=text]"), question);
    await type(part(n).locator("[data-question=right]"), right);
    if (!n) await act("", () => part(n).locator("[data-step-field=needs]").selectOption("right"));
  }
  await click(teacher.locator("[data-sheet=save]"));
  await click(teacher.locator("[data-give=sheet]"));
  await teacher.waitForSelector(".sheet-row.given");
  return { ...done, seconds: (performance.now() - begun) / 1000 };
}

export async function a_worksheet_of_three_steps_is_written_in_seventeen_actions_and_three_minutes(rig) {
  const { page: teacher, code } = await teach(rig);
  const { actions, letters, seconds } = await writeThree(teacher, Boolean(process.env.PACE));
  assert.ok(actions <= 17, `${actions} actions`);
  const paced = actions * (THINK + POINT) + letters * KEY;
  assert.ok(paced < 60 * MINUTES, `${paced} s`);
  const pupil = await join(rig, code, "Ada");
  await step(pupil, "One arm");
  assert.ok(await pupil.isDisabled("[data-step='2']"), "the right answer is needed");
  await pupil.fill(".given-sheet [data-answer]", "2");
  await pupil.click("[data-sheet=answer]");
  await step(pupil, "Four times as long");
  assert.ok(await pupil.isDisabled("[data-step='3']"), "a new step needs what the one before it does");
  for (const page of [teacher, pupil]) await close(page);
  return `${actions} actions, ${letters} letters: ${Math.round(paced)} s of a person at the keys; the browser took ${seconds.toFixed(1)} s`;
}

export async function a_link_holds_a_worksheet(rig) {
  const { page } = await teach(rig);
  const link = await page.evaluate(async (origin) => {
    const bytes = new TextEncoder().encode(JSON.stringify({ title: "By link", steps: [{ id: "a", title: "Look", text: "<b>Look</b>." }] }));
    const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate-raw"));
    const packed = new Uint8Array(await new Response(stream).arrayBuffer());
    return `${origin}/#w=${btoa(String.fromCharCode(...packed)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
  }, rig.url);
  const reader = await rig.open({ cold: true, path: link.slice(rig.url.length) });
  await step(reader, "Look");
  assert.equal(await reader.textContent(".sheet-text"), "<b>Look</b>.");
  for (const one of [page, reader]) await close(one);
}
