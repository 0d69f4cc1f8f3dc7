// A lesson in thirty real browser pages behind one address, with nginx as it is shipped before the daemon: join, show, freeze,
// let go together, ask, a worksheet, the end.  `node tests/web/lesson.mjs [pupils]` after `tests/rules/web.sh build/release
// nothing`; STORE=postgresql://... takes that store instead of SQLite's. It takes some minutes and is no part of `make check`.
// Leaves to others: two or three pages (test_room.mjs), scripted pupils by the hundred (tests/load/classes.py).
// Invariant: each step ends when every page shows it; pictures of each lie in build/check/web, times are printed.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join as path } from "node:path";
import { close, createRig, endShared, startDaemon, startNginx } from "./rig.mjs";
import { hasArms, join, says, setChain, teach } from "./room.mjs";

const PUPILS = Number(process.argv[2] ?? 30);
const home = mkdtempSync(path(tmpdir(), "pendulumd-lesson-"));
const daemon = await startDaemon(["--store", process.env.STORE ?? `sqlite:${path(home, "store")}`]);
const front = await startNginx(daemon);
if (!front) console.log("without nginx, which is not installed");
const rig = await createRig();
const here = { ...rig, url: (front ?? daemon).url, open: (options) => rig.openAt((front ?? daemon).url, options) };

async function timed(what, work) {
  const begun = performance.now();
  const answer = await work();
  console.log(`${what}: ${Math.round(performance.now() - begun)} ms`);
  return answer;
}
const all = (pages, work) => Promise.all(pages.map(work));
const names = Array.from({ length: PUPILS }, (_, i) => (i ? `Pupil ${String(i + 1).padStart(2, "0")}` : "<img src=x onerror=alert(1)>"));

const { page: teacher, code } = await teach(here, { wait: false });
const pupils = await timed(`${PUPILS} pages opened and joined`, async () => {
  const pages = [];
  for (let i = 0; i < PUPILS; i += 6) pages.push(...await all(names.slice(i, i + 6), (name) => join(here, code, name, { width: 480, height: 640, wait: false })));
  return pages;
});
await timed("the board has all of them", () => teacher.waitForFunction((n) => document.querySelectorAll(".cell canvas").length === n, PUPILS));
await teacher.click("[data-class=large]");
await teacher.waitForTimeout(4000);
await rig.shot(teacher, "lesson-1-board");
await teacher.keyboard.press("Escape");

await setChain(teacher, [1, 1], [60, 90]);
await teacher.click("[data-class=push]");
await timed("everybody has the teacher's pendulum", () => all(pupils, (page) => hasArms(page, 2)));
await teacher.click("[data-class=freeze]");
await timed("everybody is frozen", () => all(pupils, (page) => says(page, /frozen all stages/)));
await rig.shot(pupils[1], "lesson-2-frozen");
await teacher.click("[data-class=freeze]");
await timed("everybody is free", () => all(pupils, (page) => says(page, /Everybody has the same/)));

await setChain(teacher, [1, 1], [120, 120]);
await teacher.selectOption("[data-class=spread]", "0.001");
await teacher.click("[data-class=release]");
await timed("all have let go", () => all(pupils, (page) => says(page, /nearly the same start/)));
await teacher.click("[data-class=together]");
await timed("all starts lie in one picture", () => teacher.waitForSelector(`text=/${PUPILS} starts.*exponent is/`));
await teacher.waitForTimeout(7000);
await rig.shot(teacher, "lesson-3-together");
await teacher.keyboard.press("Escape");

await teacher.click("[data-class=askForm] summary");
await teacher.fill("[data-question=text]", "For how long do they stay together?");
await teacher.fill("[data-question=unit]", "s");
await teacher.click("[data-class=ask]");
await timed("everybody is asked", () => all(pupils, (page) => page.waitForSelector("[data-answer]")));
await timed("all answers are counted", async () => {
  await all(pupils, async (page) => {
    await page.fill("[data-answer]", String(2 + pupils.indexOf(page) % 7));
    await page.press("[data-answer]", "Enter");
  });
  await teacher.waitForFunction((n) => document.querySelector(".asked .counts")?.textContent === `${n} answers`, PUPILS);
});
await teacher.locator(".asked").scrollIntoViewIfNeeded();
await rig.shot(teacher, "lesson-4-asked");
await teacher.click("[data-class=endQuestion]");
await teacher.click("[data-class=own]");
await timed("everybody is back", () => all(pupils, (page) => hasArms(page, 4)));

await timed("a reload of every page", () => all(pupils, async (page) => { await page.reload(); await says(page, /your own pendulum/); }));
await teacher.selectOption("[data-class=ours]", "period");
await teacher.click("[data-class=takeSheet]");
await teacher.click("[data-give=period]");
await timed("everybody has the worksheet", () => all(pupils, (page) => page.waitForSelector(".given-sheet h3")));
await timed("all have handed in", async () => {
  await all(pupils, async (page) => {
    for (const [value, choice] of [["2.0"], ["4"], [null, 2], [null, 1], ["4.95"]]) {
      await page.waitForSelector(value ? ".given-sheet [data-answer]" : ".given-sheet [data-choice]");
      const step = await page.textContent(".step h3");
      if (value) await page.fill(".given-sheet [data-answer]", value);
      else await page.click(`.given-sheet [data-choice='${choice}']`);
      await page.click("[data-sheet=answer]");
      await page.waitForFunction((title) => document.querySelector(".step h3").textContent !== title || /Handed in/.test(document.querySelector(".sheet .mark").textContent), step);
    }
  });
  await teacher.waitForSelector(`text=${PUPILS} at work, ${PUPILS} handed in`);
});
await rig.shot(pupils[1], "lesson-5-sheet");
await teacher.click("[data-answers=period]");
await rig.shot(teacher, "lesson-6-answers");
await teacher.keyboard.press("Escape");

const [saved] = await Promise.all([teacher.waitForEvent("download"), teacher.click("[data-class=table]")]);
const rows = (await (await import("node:fs/promises")).readFile(await saved.path(), "utf8")).split("\r\n");
const count = (start) => rows.filter((row) => row.startsWith(start)).length;
assert.equal(count("answers,"), PUPILS, "an answer of each");
assert.equal(count("handins,"), 5 * PUPILS, "five steps of each");
// who writes while the room goes is told that it is gone
for (const page of [teacher, ...pupils]) page.forgiven.push(/404/);
teacher.on("dialog", (dialog) => dialog.accept());
await teacher.click("[data-class=erase]");
await timed("everybody knows that the room is over", () => all(pupils, (page) => page.waitForSelector("text=This room is over")));
for (const page of [teacher, ...pupils]) await close(page);
rig.close();
await endShared();
await front?.stop();
await daemon.stop();
rmSync(home, { recursive: true, force: true });
console.log("the lesson is over: everything was there");
