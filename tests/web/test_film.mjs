// A film of a pendulum: marked by pointer, key and colour beside the truth, as a table, fitted, and in time behind the motion.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { IN_FIREFOX } from "./bidi.mjs";
import { openDrawer, saved, settledMotion } from "./drawers.mjs";
import { FILM, giveFilm } from "./film.mjs";
import { close, drawn } from "./rig.mjs";

const FILE = "[data-film=file]";
const said = (page, pattern) => page.waitForFunction((words) => new RegExp(words).test(document.querySelector("[data-film=status]")?.textContent), pattern.source);
const marks = (page) => page.evaluate(() => JSON.parse(localStorage.getItem("pendulumd.films"))[0]);
const tool = (page) => page.inputValue("[data-film=tool]");

async function openFilmPart(page) {
  await openDrawer(page, "measure");
  await page.click("[data-part=film] summary");
  await page.waitForSelector(FILE, { state: "attached" });
}

/** Clicks at a place of the film, in its pixels, wherever it lies on the stage. */
async function clickAt(page, [across, down]) {
  const box = await page.locator(".film-canvas").boundingBox();
  const scale = Math.min((box.width - 20) / FILM.width, (box.height - 20) / FILM.height);
  const [x, y] = [box.x + (box.width - scale * FILM.width) / 2 + scale * across, box.y + (box.height - scale * FILM.height) / 2 + scale * down];
  await page.mouse.click(x, y);
}

/** Marking begins by itself, unless the browser does not tell when a picture is (Firefox) and asks for the rate. */
async function begin(page) {
  if (await page.isVisible("[data-film=rate]")) {
    await page.fill("[data-film=rate]", "25");
    await page.click("[data-film=mark]");
  }
  await page.waitForFunction(() => document.activeElement.className === "film-canvas");
}

export async function a_film_that_is_marked_by_colour_gives_length_and_friction_and_runs_behind_the_fitted_pendulum(rig) {
  const page = await rig.open({ path: "/?length=0.8&theta=20", height: 1000, language: "de" });
  const sent = [];
  page.on("request", (request) => request.method() !== "GET" && sent.push(request.postData()?.length ?? 0));
  await openFilmPart(page);
  const truth = await giveFilm(page, FILE);
  await said(page, /3,0 s lang/);
  await begin(page);
  // two marks of a metre, the pivot; then the keys: straight below it, with the cross one picture's pixel at a time
  for (const spot of [[40, 341], [440, 341], FILM.pivot]) await clickAt(page, spot);
  assert.equal(await tool(page), "1");
  await page.selectOption("[data-film=tool]", "below");
  await page.focus(".film-canvas");
  await page.keyboard.press("Shift+ArrowDown");
  await page.keyboard.press("Enter");
  const { fixed } = await marks(page);
  assert.ok(Math.abs(fixed.below[0] - fixed.pivot[0]) < 1e-9 && fixed.below[1] > fixed.pivot[1] + 5);
  assert.ok(Math.hypot(fixed.pivot[0] - FILM.pivot[0], fixed.pivot[1] - FILM.pivot[1]) < 0.5, "within a pixel");
  assert.equal(await tool(page), "1");
  await clickAt(page, truth[0].slice(1));
  await said(page, /in \d+ Bildern markiert/);
  const { tips } = await marks(page);
  // Firefox has no way to the last picture before one that is kept whole, every 25th
  const there = IN_FIREFOX ? truth.filter((_, i) => i % 25 !== 24) : truth;
  assert.equal(tips[1].length, there.length, "every picture is marked, at its own time");
  const errors = tips[1].map(([time, across, down], i) => [Math.abs(time - there[i][0]), Math.hypot(across - there[i][1], down - there[i][2])]);
  const [late, far] = [0, 1].map((k) => Math.max(...errors.map((row) => row[k])));
  const mean = Math.sqrt(errors.reduce((sum, [, error]) => sum + error * error, 0) / errors.length);
  assert.ok(late < 6e-4 && far < 1 && mean > 1e-4 && mean < 0.3, `${mean} pixels in the mean, ${far} at most, ${late} s`);
  await drawn(page);
  await rig.shot(page, "film-marking");
  assert.deepEqual(await violations(page, { context: { include: [".film-layer"] } }), []);
  await page.click(".film-tools [data-film=done]");
  await page.locator("[data-part=film] select").selectOption("comma");
  const { name, bytes } = await saved(page, "[data-film=save]");
  const lines = bytes.toString().split("\r\n");
  assert.deepEqual([name, lines[0], lines.length], ["pendulum-film.csv", "\ufefft in s;x_1 in m;y_1 in m", there.length + 2]);
  assert.match(lines[2], /^0,04;0,\d+;-0,\d+$/);
  await page.click("[data-film=fit]");
  await page.waitForSelector("[data-fit=run]:not([hidden])");
  await page.click("[data-fit=run]");
  await page.waitForSelector("[data-fit=answer] .fit-verdict");
  assert.equal(await page.getAttribute(".fit-verdict", "data-status"), "converged");
  const told = [];
  const askew = askewOf(fixed);
  for (const [id, value] of [["length 1", FILM.length], ["damping 1", FILM.damping]]) {
    const [found, error] = await page.locator(`[data-found="${id}"] td`).evaluateAll((cells) => cells.map((cell) => Number(cell.dataset.value)));
    assert.ok(error > 0 && error < 0.1 * value && Math.abs(found - value) < 4 * error + askew * value, `${id}: ${found} ± ${error}, not ${value}`);
    told.push(`${id} ${found.toFixed(5)} ± ${error.toFixed(5)}`);
  }
  await page.click("[data-fit=instead]");
  await settledMotion(page);
  await inTime(page, truth);
  await rig.shot(page, "film-behind");
  await spoken(page);
  assert.ok(Math.max(...sent) < 40000, "nothing of the film is sent");
  await close(page);
  return `colour: ${mean.toFixed(3)} pixels in the mean, ${far.toFixed(3)} at most; ${told.join(", ")}`;
}

/** By how much the metre is marked amiss, where a pointer goes by whole pixels of the screen (Firefox). */
function askewOf({ one, two }) {
  const askew = Math.abs(Math.hypot(two[0] - one[0], two[1] - one[1]) / FILM.scale - 1);
  assert.ok(askew < 3e-3);
  return askew;
}

/** In another language the film is still there. */
async function spoken(page) {
  const film = ".film-behind video";
  const where = () => page.evaluate((at) => getComputedStyle(document.querySelector(at)).transform, film);
  const before = await where();
  // a file that is no film does not take the place of the one that is seen
  await page.evaluate((at) => {
    const input = document.querySelector(at);
    const chosen = new DataTransfer();
    chosen.items.add(new File(["no film"], "notes.txt", { type: "text/plain" }));
    input.files = chosen.files;
    input.dispatchEvent(new Event("change"));
  }, FILE);
  await said(page, /notes\.txt/);
  await page.evaluate(() => pendulumd.speak("en"));
  await page.waitForFunction(() => document.documentElement.lang === "en");
  await page.waitForFunction((at) => !document.querySelector(at), ".film-behind:not(.seen)");
  await openDrawer(page, "measure");
  if (!(await page.isVisible("[data-film=open]"))) await page.click("[data-part=film] summary");
  await said(page, /3\.0 s long/);
  await page.waitForSelector(".film-behind.seen");
  await drawn(page);
  assert.equal(await where(), before, "in another language the film is where the fit has put it");
}

/** The film behind the motion: at the clock's time, its tip where the pendulum's is. */
async function inTime(page, truth) {
  await page.waitForSelector(".film-behind.seen");
  await page.waitForFunction(() => pendulumd.clock.playing && pendulumd.clock.time > 0.8);
  // it comes into time, however slow the machine is: of twelve frames more than half are
  await page.evaluate(() => new Promise((resolve) => {
    const list = [];
    const watch = () => {
      const video = document.querySelector(".film-behind video");
      list.push(Math.abs(video.currentTime - pendulumd.clock.time - (pendulumd.store.get().span.start ?? 0)));
      if (list.length >= 12 && list.slice(-12).sort((a, b) => a - b)[6] < 0.12) resolve();
      else requestAnimationFrame(watch);
    };
    watch();
  }));
  const at = 41;
  await page.evaluate((time) => { pendulumd.clock.pause(); pendulumd.clock.seek(time); }, truth[at][0] + 0.001);
  await page.waitForFunction((time) => { const video = document.querySelector(".film-behind video"); return !video.seeking && Math.abs(video.currentTime - time) < 0.002; }, truth[at][0] + 0.001);
  await drawn(page);
  const away = await page.evaluate(([across, down]) => {
    const { x, y } = new DOMPoint(across, down).matrixTransform(new DOMMatrix(getComputedStyle(document.querySelector(".film-behind video")).transform));
    const tip = pendulumd.stage.tip(1);
    return Math.hypot(x - tip.x, y - tip.y);
  }, truth[at].slice(1));
  assert.ok(away < 4, `the film's tip is ${away} pixels of the stage away from the pendulum's`);
}

export async function marks_by_key_alone_are_kept_and_found_again_with_the_film(rig) {
  const page = await rig.open({ path: "/?length=0.6&theta=20", width: 390, height: 844, touch: true });
  await openFilmPart(page);
  assert.equal(await page.isVisible("[data-film=mark]"), false, "no film, no marks");
  const truth = await giveFilm(page, ".film");
  await said(page, /3\.0 s long/);
  await begin(page);
  await page.selectOption("[data-film=track]", "");
  assert.equal(await page.isVisible("#timebar"), false, "one clock at a time");
  await page.selectOption("[data-film=tool]", "1");
  await page.focus(".film-canvas");
  for (let i = 0; i < 3; i++) {
    const before = await page.textContent(".film-time");
    await page.keyboard.press("Enter"); // marks, and goes on to the next picture
    await page.waitForFunction((words) => document.querySelector(".film-time").textContent !== words, before);
  }
  await page.keyboard.press("PageUp");
  await page.waitForFunction(() => document.querySelector(".film-time").textContent === "0.080 s");
  await page.keyboard.press("Delete");
  const { tips } = await marks(page);
  assert.deepEqual(tips[1].map(([time]) => Math.round(time * 1000)), [0, 40]);
  assert.deepEqual(tips[1][0].slice(1), [FILM.width / 2, FILM.height / 2], "the cross begins in the middle");
  assert.equal(await page.evaluate(() => pendulumd.clock.playing), false);
  await page.evaluate(() => document.getElementById("stage").scrollIntoView());
  await rig.shot(page, "film-phone");
  await page.focus(".film-canvas");
  await page.keyboard.press("Escape");
  assert.equal(await page.locator(".film-layer, #stage > [inert]").count(), 0, "the stage is there again");
  await page.locator("[data-part=film]").scrollIntoViewIfNeeded();
  await rig.shot(page, "film-part-phone");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=film]"] } }), []);
  // no callback for pictures: by the rate that is given
  await page.addInitScript(() => { delete HTMLVideoElement.prototype.requestVideoFrameCallback; });
  await page.reload();
  await openFilmPart(page);
  await said(page, /The marks of swing\.webm are still here/);
  assert.match(await page.textContent("[data-marked='1']"), /: 2$/);
  await giveFilm(page, FILE);
  await said(page, /with its earlier marks/);
  await page.fill("[data-film=rate]", "25");
  await page.press("[data-film=rate]", "Tab");
  await page.click("[data-film=mark]");
  await page.waitForSelector(".film-canvas");
  await page.click("[data-film=on]");
  await page.waitForFunction(() => document.querySelector(".film-time").textContent === "0.040 s");
  await page.selectOption("[data-film=tool]", "1");
  await page.selectOption("[data-film=track]", "");
  await clickAt(page, truth[1].slice(1));
  await page.waitForFunction(() => document.querySelector(".film-time").textContent === "0.080 s");
  const again = await marks(page);
  assert.ok(Math.hypot(again.tips[1][1][1] - truth[1][1], again.tips[1][1][2] - truth[1][2]) < 1, "the mark has been moved");
  await page.click(".film-tools [data-film=done]");
  await page.setInputFiles(FILE, { name: "not.mp4", mimeType: "video/mp4", buffer: Buffer.from("no film") });
  await said(page, /cannot play not\.mp4/);
  await close(page);
}

export async function a_tip_without_a_colour_is_tracked_by_the_pattern_around_it(rig) {
  const page = await rig.open({ path: "/?length=0.6&theta=20" });
  await openFilmPart(page);
  const truth = await giveFilm(page, FILE, { film: { ...FILM, tone: "#4a4a4a" } });
  await said(page, /3\.0 s long/);
  await begin(page);
  await page.selectOption("[data-film=tool]", "1");
  await page.selectOption("[data-film=track]", "pattern");
  await clickAt(page, [21, 313]); // all red
  await said(page, /too little here to track/);
  await clickAt(page, truth[0].slice(1));
  await said(page, /marked in \d+ frames/);
  const { tips } = await marks(page);
  const errors = tips[1].map(([time, across, down]) => { const [, x, y] = truth[Math.round(1000 * time / FILM.gap)]; return Math.hypot(across - x, down - y); });
  const [far, mean] = [Math.max(...errors), errors.reduce((sum, error) => sum + error, 0) / errors.length];
  assert.ok(errors.length >= truth.length - 3 && far < 2 && mean < 1, `${errors.length} frames, ${mean} pixels in the mean, ${far} at most`);
  await close(page);
  return `${errors.length} frames, ${mean.toFixed(2)} pixels in the mean, ${far.toFixed(2)} at most`;
}

/** As in Firefox: a browser that tells what was asked, and instead of one picture shows the next. */
function asInFirefox([from, to]) {
  const native = HTMLVideoElement.prototype.requestVideoFrameCallback;
  HTMLVideoElement.prototype.requestVideoFrameCallback = function (tell) {
    return native.call(this, (now, data) => tell(now, { ...data, mediaTime: this.currentTime }));
  };
  const own = Object.getOwnPropertyDescriptor(HTMLMediaElement.prototype, "currentTime");
  const set = function (time) { own.set.call(this, time >= from && time < to ? time + to - from : time); };
  Object.defineProperty(HTMLMediaElement.prototype, "currentTime", { ...own, set });
}

export async function a_picture_that_a_browser_does_not_show_is_not_marked_with_the_next_one_s_place(rig) {
  const page = await rig.open({ path: "/?length=0.6&theta=20" });
  if (!IN_FIREFOX) await page.addInitScript(asInFirefox, [24, 25].map((i) => i * FILM.gap / 1000));
  await page.reload();
  await openFilmPart(page);
  const truth = await giveFilm(page, FILE);
  await said(page, /3\.0 s long/);
  await page.waitForSelector("[data-film=rate]", { state: "visible" });
  await begin(page);
  await page.selectOption("[data-film=tool]", "1");
  for (let i = 1; i <= 23; i++) {
    await page.click("[data-film=on]");
    await page.waitForFunction((time) => document.querySelector(".film-time").textContent === `${time} s`, (i * FILM.gap / 1000).toFixed(3));
  }
  await clickAt(page, truth[23].slice(1));
  await said(page, /marked in \d+ frames/);
  const { tips } = await marks(page);
  const times = tips[1].map(([time]) => Math.round(1000 * time / FILM.gap));
  assert.deepEqual(times.slice(0, 3), [23, 25, 26]);
  for (const [i, at] of times.entries()) assert.ok(Math.hypot(tips[1][i][1] - truth[at][1], tips[1][i][2] - truth[at][2]) < 1.5, `picture ${at}`);
  await close(page);
}
