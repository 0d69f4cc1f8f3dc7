// A lesson in real browser pages behind one address, with nginx as it is shipped before the daemon: join, show, freeze, follow the
// teacher, let go together, ask, a worksheet; pages that sleep, dead Wi-Fi, restarts of the server and of PostgreSQL; and the end.
// Every second pupil has a phone, whose screen must show what is asked.
// usage: node tests/web/lesson.mjs [PUPILS [sqlite|postgres]]      (make pages: 4 pages and each store, a minute or two each;
// thirty take minutes of a quiet machine; MINUTES=45 spreads its steps over a real lesson)
// Leaves to others: single trouble of two or three pages (test_room*.mjs), scripted pupils by the hundred (tests/load/classes.py,
// tests/drill/lesson.py).
// Invariant: each step ends when every page shows it; nothing that was given is lost: the table, the room and the pages agree in the
// end; pictures of each step lie in build/check/web, times are printed.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { loadavg, tmpdir } from "node:os";
import { join as path } from "node:path";
import { close, createRig, endShared, startDaemon, startNginx, startPostgres } from "./rig.mjs";
import { openDrawer } from "./drawers.mjs";
import { hasArms, join, says, setChain, teach } from "./room.mjs";

const PUPILS = Number(process.argv[2] ?? 30);
const STORE = process.argv[3] ?? "sqlite";
const MANY = PUPILS > 10;
const NAP_MS = MANY ? 20000 : 3000; // from 17 s on a page that comes back asks for its stream again
const DOWN_MS = 2000; // that the server is not there when it is restarted
const CHANGES = 4; // of each pupil, whose way to the board is timed
const CHANGE_MS = MANY ? 2500 : 1200; // between two of them, at least
const PICTURES = `lesson-${STORE}-${PUPILS}`;
const SEEN_MS = 2000; // in which everybody is to see a step
const STEPS = 18; // over which a real lesson is spread
const REST_MS = (Number(process.env.MINUTES ?? 0) * 60000) / STEPS;
const PHONE = { width: 390, height: 664, touch: true };
const LAPTOP = { width: 480, height: 640 };

const home = mkdtempSync(path(tmpdir(), "pendulumd-lesson-"));
const postgres = STORE === "postgres" ? await startPostgres() : null;
if (STORE === "postgres" && !postgres) {
  console.log("skip: PostgreSQL is not installed");
  process.exit(0);
}
const options = ["--store", postgres?.url ?? `sqlite:${path(home, "store")}`];
let daemon = await startDaemon(options);
const front = await startNginx(daemon);
if (!front) console.log("without nginx, which is not installed");
const rig = await createRig();
const { url } = front ?? daemon;
const here = { ...rig, url, open: (more) => rig.openAt(url, more) };

const load = () => `load ${loadavg()[0].toFixed(1)}`;
console.log(`${PUPILS} pages, ${STORE}, ${load()}`);
const BY_TIME = { polling: 100 }; // ms: of thirty windows on one machine some get no frames for a long while
async function timed(what, work) {
  const begun = performance.now();
  const answer = await work();
  console.log(`${what}: ${Math.round(performance.now() - begun)} ms`);
  return answer;
}
const all = (pages, work) => Promise.all(pages.map(work));
const seen = []; // what the teacher did, and after how many ms every page showed it
/** What the teacher does, until every pupil's page shows it. */
async function step(what, act, work) {
  await pause(REST_MS);
  const begun = performance.now();
  await act();
  await all(pupils, work);
  seen.push([what, Math.round(performance.now() - begun)]);
  console.log(`${what}: ${seen.at(-1)[1]} ms`);
}
/** Waits until a part is on the screen, whole, with nothing over it. */
const inView = (page, selector) => page.waitForFunction((part) => {
  const element = document.querySelector(part);
  const box = element?.getBoundingClientRect();
  if (!box?.width || box.top < 0 || box.bottom > innerHeight || box.left < 0 || box.right > innerWidth) return false;
  const top = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
  return element.contains(top) || element.labels?.[0]?.contains(top);
}, selector, BY_TIME);
/** What a page shows, in words and as a picture. */
async function tell(page, name) {
  console.log(`${name}: ${await page.innerText(".class-body", { timeout: 20000 }).catch(String)}`);
  await rig.shot(page, `${PICTURES}-failed-${name}`, { timeout: 20000 }).catch(() => {});
}
/** Ends what was started. */
async function end() {
  rig.close();
  await endShared();
  await front?.stop();
  await daemon.stop();
  await postgres?.stop();
  rmSync(home, { recursive: true, force: true });
}
process.on("uncaughtException", async (error) => {
  console.log(error);
  await all([teacher, ...pupils], (page, i) => tell(page, `page-${i}`));
  await end();
  process.exit(1);
});
const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });
let pictures = 0;
const shot = (page, name) => rig.shot(page, `${PICTURES}-${String(++pictures).padStart(2, "0")}-${name}`);
const names = Array.from({ length: PUPILS }, (_, i) => (i ? `Pupil ${String(i + 1).padStart(2, "0")}` : "<img src=x onerror=alert(1)>"));
const frozen = /frozen all stages/;
const same = /Everybody has the same/;
const own = /your own pendulum/;

const { page: teacher, code } = await teach(here, { wait: false });
const pupils = await timed(`${PUPILS} pages opened and joined`, async () => {
  const pages = [];
  for (let i = 0; i < PUPILS; i += 6) pages.push(...await all(names.slice(i, i + 6), (name) => join(here, code, name, { ...(names.indexOf(name) % 2 ? PHONE : LAPTOP), wait: false })));
  return pages;
});
const token = (page) => page.evaluate(() => [sessionStorage.getItem("pendulumd.rooms.tab"), localStorage.getItem("pendulumd.rooms")].flatMap((rooms) => JSON.parse(rooms ?? "[]"))[0]);
for (const page of [teacher, ...pupils]) page.forgiven.push(/Failed to load|net::ERR|50[234]/);

// --- a lesson

await timed("the board has all of them", () => teacher.waitForFunction((n) => document.querySelectorAll(".cell canvas").length === n, PUPILS, BY_TIME));
await teacher.click("[data-class=large]");
await teacher.waitForTimeout(MANY ? 4000 : 500);
await shot(teacher, "board");
await teacher.keyboard.press("Escape");

/** Changes of every pupil and when the teacher's board shows them; ms. A state is sent at once, a stage at most every 900 ms. */
async function latency() {
  await teacher.evaluate(() => {
    window.shown = [];
    const cellOf = (node) => (node.nodeType === 1 ? node : node.parentElement).closest("[data-pupil]")?.dataset.pupil;
    new MutationObserver((changes) => {
      for (const { type, target, addedNodes } of changes) {
        const picture = [...addedNodes].some(({ localName }) => localName === "canvas");
        if (type === "attributes") window.shown.push({ kind: "state", pupil: cellOf(target), at: Date.now(), value: target.dataset.state });
        else if (picture) window.shown.push({ kind: "stage", pupil: cellOf(target), at: Date.now() });
      }
    }).observe(document.querySelector(".wall"), { subtree: true, childList: true, attributes: true, attributeFilter: ["data-state"] });
  });
  const sent = (await all(pupils, async (page) => {
    const { pupil } = await token(page);
    const times = [];
    for (let i = 0; i < CHANGES; i++) {
      await pause(CHANGE_MS * (1 + Math.random()));
      times.push({ kind: i % 2 ? "stage" : "state", pupil: String(pupil), at: await page.evaluate((stage) => {
        const at = Date.now();
        const { pendulum } = pendulumd.store.get();
        if (stage) pendulumd.store.set({ pendulum: { ...pendulum, length: pendulum.length.map((l) => l * 0.99) } });
        else document.querySelector("[data-state=stuck]").click();
        return at;
      }, i % 2) });
    }
    return times;
  })).flat();
  const wayOf = (shown) => ({ kind, pupil, at }) => shown.find((one) => one.kind === kind && one.pupil === pupil && one.at >= at)?.at - at;
  let ways = [];
  for (let tries = 0; tries < 200; tries++) {
    const shown = await teacher.evaluate(() => window.shown);
    ways = sent.map((one) => ({ ...one, way: wayOf(shown)(one) }));
    if (ways.every(({ way }) => way >= 0)) break;
    await pause(100);
  }
  for (const kind of ["state", "stage"]) {
    const times = ways.filter((one) => one.kind === kind).map(({ way }) => way).sort((a, b) => a - b);
    assert.ok(times.every((way) => way >= 0), `a ${kind} did not come to the board`);
    const part = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))];
    console.log(`a pupil's ${kind} to the board: ${times.length} times, p50 ${part(0.5)} ms, p99 ${part(0.99)} ms, most ${times.at(-1)} ms`);
  }
  await all(pupils, (page) => page.evaluate(() => document.querySelector("[data-state=stuck][aria-pressed=true]")?.click()));
}
await latency();
await shot(teacher, "latency");

const click = (selector) => () => teacher.click(selector);
const until = (page, work, value) => page.waitForFunction(work, value, BY_TIME);
await setChain(teacher, [1, 1], [60, 90]);
await step("everybody has the teacher's pendulum", click("[data-class=push]"), (page) => hasArms(page, 2));
await shot(teacher, "push");
await step("everybody reads a message", async () => {
  await teacher.fill("[data-class=words]", "Look at the longer arm");
  await teacher.press("[data-class=words]", "Enter");
}, async (page) => {
  await until(page, () => /longer arm/.test(document.querySelector(".class-banner").textContent));
  await inView(page, ".class-banner");
});
await shot(pupils[1], "message-phone");
await step("everybody is frozen", click("[data-class=freeze]"), (page) => says(page, frozen));
await shot(teacher, "frozen");
await shot(pupils[1], "frozen-pupil");
await step("everybody is free", click("[data-class=freeze]"), (page) => says(page, same));

await teacher.evaluate(() => pendulumd.clock.pause());
await step("everybody follows", click("[data-class=follow]"), (page) => says(page, /what your teacher does/));
await step("everybody has what the teacher builds", () => setChain(teacher, [1, 1, 1], [40, 40, 40]), (page) => hasArms(page, 3));
await step("everybody is at the teacher's time", () => teacher.evaluate(() => pendulumd.clock.seek(2.5)),
  (page) => until(page, () => Math.abs(pendulumd.clock.time - 2.5) < 0.02 && !pendulumd.clock.playing));
await step("everybody's clock runs", () => teacher.evaluate(() => pendulumd.clock.play()), (page) => until(page, () => pendulumd.clock.playing));
const clocks = await all([teacher, ...pupils], (page) => page.evaluate(() => pendulumd.clock.time));
console.log(`  clocks: the teacher's ${clocks[0].toFixed(2)} s, the others ${clocks.slice(1).map((time) => time.toFixed(2)).join(", ")}`);
await step("everybody has the teacher's drawer", () => openDrawer(teacher, "plots"),
  (page) => page.waitForSelector("[data-drawer=plots]:not([hidden]) [data-chart=energy] path[fill=none]"));
await shot(pupils[1], "follow-phone");
await openDrawer(teacher, "class");
await step("everybody is back", click("[data-class=own]"), (page) => hasArms(page, 1));

await setChain(teacher, [1, 1], [120, 120]);
await teacher.selectOption("[data-class=spread]", "0.001");
await step("all have let go", click("[data-class=release]"), (page) => hasArms(page, 2));
await teacher.click("[data-class=together]");
await timed("all starts lie in one picture", () => teacher.waitForSelector(`text=/${PUPILS} starting positions.*exponent:/`));
await teacher.waitForTimeout(MANY ? 7000 : 500);
await shot(teacher, "together");
await teacher.keyboard.press("Escape");

await teacher.click("[data-class=askForm] summary");
await teacher.fill("[data-question=text]", "For how long do they stay together?");
await teacher.fill("[data-question=unit]", "s");
await teacher.fill("[data-question=right]", "5");
await step("everybody is asked, and sees field and button", click("[data-class=ask]"), async (page) => {
  await inView(page, "[data-answer]");
  await inView(page, "[data-class=answer]");
});
await shot(pupils[1], "asked-phone");
await timed("all answers are counted", async () => {
  await all(pupils, async (page) => {
    await page.fill("[data-answer]", String(2 + pupils.indexOf(page) % 7));
    await page.press("[data-answer]", "Enter");
  });
  await until(teacher, (n) => document.querySelector(".asked .counts")?.textContent === `${n} answers`, PUPILS);
});
await teacher.locator(".asked").scrollIntoViewIfNeeded();
await shot(teacher, "asked");
await step("everybody knows what is right", click("[data-class=showSolution]"), (page) => page.waitForSelector("text=/The answer: 5 s/"));
await teacher.click("[data-class=largeQuestion]");
await shot(teacher, "bars");
await teacher.keyboard.press("Escape");
await step("the question is gone", click("[data-class=endQuestion]"), (page) => until(page, () => document.querySelector(".question").hidden));
await step("everybody has its own", click("[data-class=own]"), (page) => hasArms(page, 1));
await timed("a reload of every page", () => all(pupils, async (page) => { await page.reload(); await says(page, own); }));
await shot(teacher, "reloaded");

// --- pages that sleep, and dead Wi-Fi: a third of the class each

const third = Math.ceil(PUPILS / 3);
const [sleepers, offline] = [pupils.slice(0, third), pupils.slice(third, 2 * third)];
const lifecycle = (page, state) => page.session.send("Page.setWebLifecycleState", { state });
await all(sleepers, (page) => lifecycle(page, "frozen"));
await all(offline, async (page, i) => {
  await page.context().setOffline(true);
  await says(page, /No connection/);
  await setChain(page, [1, 1, 1], [5, 5, 5]); // works on meanwhile
});
await setChain(teacher, [1, 1], [30, 30]);
await teacher.click("[data-class=push]");
await all(pupils.slice(2 * third), (page) => hasArms(page, 2));
await pause(NAP_MS);
await shot(teacher, "sleep-and-no-wifi");
await shot(offline[0], "no-wifi-pupil");
await timed(`${sleepers.length} pages that slept for ${NAP_MS / 1000} s have what was shown`, () => all(sleepers, async (page) => {
  await lifecycle(page, "active");
  await hasArms(page, 2);
  await says(page, same);
}));
await timed(`${offline.length} pages whose Wi-Fi is back have what was shown`, () => all(offline, async (page) => {
  await page.context().setOffline(false);
  await hasArms(page, 2);
  await says(page, same);
}));
await teacher.click("[data-class=own]");
await timed("who worked on without Wi-Fi has that again", () => all(offline, async (page) => { await hasArms(page, 3); await says(page, own); }));
await shot(teacher, "all-back");

// --- restarts, while a worksheet is answered

await teacher.selectOption("[data-class=ours]", "period");
await teacher.click("[data-class=takeSheet]");
await step("everybody has the worksheet, and sees field and button", click("[data-give=period]"), async (page) => {
  await inView(page, ".given-sheet [data-answer]");
  await inView(page, "[data-sheet=answer]");
});
await shot(pupils[1], "sheet-phone");
await step("everybody stays at the first step", () => teacher.selectOption("[data-class=pace]", "1"), (page) => page.waitForSelector("[data-step='2']:disabled"));
await step("everybody may go on", () => teacher.selectOption("[data-class=pace]", "0"), (page) => until(page, () => !/opens the next step/.test(document.querySelector(".given-sheet").textContent)));

/** Answers the step that is shown, and waits until the next one is, however long the room is away. */
async function answerStep(page, [value, choice]) {
  await page.waitForSelector(value ? ".given-sheet [data-answer]" : ".given-sheet [data-choice]");
  const step = await page.textContent(".step h3");
  if (value) await page.fill(".given-sheet [data-answer]", value);
  else await page.click(`.given-sheet [data-choice='${choice}']`);
  await page.click("[data-sheet=answer]");
  await page.waitForFunction((title) => document.querySelector(".step h3").textContent !== title || /Handed in/.test(document.querySelector(".sheet .mark").textContent), step, BY_TIME);
}

/** What happens while everybody answers; from when it is over: until all answers are in, and all have what is shown next. */
async function trouble(what, happens, answer, count) {
  const answering = all(pupils, (page) => answerStep(page, answer));
  await pause(300);
  const begun = performance.now();
  const midst = await happens();
  console.log(`${what}: ${midst ?? ""} ${Math.round(performance.now() - begun)} ms`);
  await timed("  all answers are in after", () => answering);
  await setChain(teacher, Array.from({ length: count }, () => 1), Array.from({ length: count }, () => 20));
  await timed("  everybody has what is shown next after", async () => {
    await teacher.click("[data-class=push]");
    await all(pupils, (page) => hasArms(page, count));
  });
  await shot(teacher, what.replaceAll(" ", "-"));
}
const port = new URL(daemon.url).port;
const restart = (signal) => async () => {
  await daemon.stop(signal);
  await pause(DOWN_MS / 2);
  await shot(teacher, `away-${signal}`);
  await pause(DOWN_MS / 2);
  daemon = await startDaemon(options, port);
};
await trouble("the server restarted", restart("SIGTERM"), ["2.0"], 2);
await trouble("the server killed", restart("SIGKILL"), ["4"], 3);
if (postgres) await trouble("PostgreSQL restarted", postgres.restart, [null, 2], 4);
else await all(pupils, (page) => answerStep(page, [null, 2]));
if (postgres) await trouble("PostgreSQL crashed", postgres.crash, [null, 1], 5);
else await all(pupils, (page) => answerStep(page, [null, 1]));
await timed("all have handed in", async () => {
  await all(pupils, (page) => answerStep(page, ["4.95"]));
  await teacher.waitForSelector(`text=${PUPILS} working, ${PUPILS} handed in`);
});
await shot(pupils[1], "sheet");
await teacher.click("[data-answers=period]");
await shot(teacher, "answers");
await teacher.keyboard.press("Escape");

// --- the account

/** What the room has of a pupil's stage, once that is what is on its page. */
async function agrees(page) {
  const { code: room, token: secret, pupil } = await token(page);
  for (let tries = 0; tries < 100; tries++) {
    const reply = await fetch(`${url}/v1/classes/${room}`, { headers: { "Class-Token": secret } });
    const { items } = await reply.json();
    const { pendulum, initial } = items.find(({ name }) => name === `stages/${pupil}`).value.scene.request;
    const here = await page.evaluate(() => { const { pendulum: tree, initial: start } = pendulumd.store.get(); return [tree.length, start.phi]; });
    if (JSON.stringify([pendulum.length, initial.phi]) === JSON.stringify(here)) return true;
    await pause(100);
  }
  return false;
}
assert.ok((await all(pupils, agrees)).every(Boolean), "every page's stage is in the room");
const [saved] = await Promise.all([teacher.waitForEvent("download"), teacher.click("[data-class=table]")]);
const rows = (await readFile(await saved.path(), "utf8")).trim().split("\r\n").slice(1);
assert.equal(rows.filter((row) => row.startsWith('"",')).length, PUPILS, "an answer of each");
const sheet = rows.filter((row) => row.startsWith('"Period and length",'));
assert.equal(sheet.length, 5 * PUPILS, "five steps of each");
assert.ok(sheet.every((row) => /,1,"",/.test(row)), "all right at the first try");
await teacher.locator("[data-class=table]").scrollIntoViewIfNeeded();
await shot(teacher, "before-the-end");
// who writes while the room goes is told that it is gone
for (const page of [teacher, ...pupils]) page.forgiven.push(/404/);
teacher.on("dialog", (dialog) => dialog.accept());
await teacher.click("[data-class=erase]");
await timed("everybody knows that the room is over", () => all(pupils, (page) => page.waitForSelector("text=This room has ended")));
await shot(teacher, "over");
const slow = seen.filter(([, ms]) => ms > SEEN_MS);
console.log(`${seen.length} steps, the slowest seen by everybody after ${Math.max(...seen.map(([, ms]) => ms))} ms; above ${SEEN_MS} ms: ${slow.map(([what]) => what).join(", ") || "none"}`);
console.log(load());
for (const page of [teacher, ...pupils]) await close(page);
await end();
console.log("the lesson is over: everything was there");
