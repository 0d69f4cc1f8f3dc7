// A film of one's own pendulum: chosen or dropped, its scale and pivot marked, its tips marked by
// hand or by their colour; the marks as a table and as a fit; the film behind the motion.
// Leaves to others: pictures (film_frames.js), marks (film_marks.js), tracking (film_pattern.js),
// marking (film_layer.js), the film behind the stage (film_behind.js), fits (fits.js).
// Invariant: the film stays in this browser; each mark is kept at once, and found again when the
// same film is chosen.

import { createBag, h } from "../../dom.js";
import { createBehind } from "./film_behind.js";
import { dropping, openFilm, pictureOf, seek, step } from "./film_frames.js";
import { TRACKERS } from "./film_pattern.js";
import { createLayer } from "./film_layer.js";
import * as marking from "./film_marks.js";
import { button, choice, save } from "../kit/kit.js";
import { openMeasurements } from "../fits/measurements.js";
import { MARKS, ownMarks } from "../kit/table_file.js";

const LOST = 12; // pictures in a row without it end the search
const TOLERANCE = 40; // of colours, of 255

/** @typedef {import("./film_marks.js").Marks} Marks */

/**
 * The part while it is there. wanted: the file chosen last, shown: seen; tool: what the next mark
 * is, "one", "two", "pivot", "below" or an arm's number; camera: of the fit to the table `told`,
 * which the fits were `handed`.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, film: import("./film_frames.js").Film | null, marks: Marks | null, tool: string,
 *   layer: ReturnType<typeof createLayer> | null, back: ReturnType<typeof createBehind> | null,
 *   wanted: File | null, shown: File | null, tolerance: number, search: AbortController | null,
 *   told: string, handed: string, camera: FitCamera | null, form: string, track: string,
 * }} View
 */

/** @param {Text} text */
function partsOf(text) {
  const names = { class: "quiet", role: "status" };
  return {
    status: h("p", { ...names, "data-film": "status" }),
    settings: h("div", { class: "fit-options" }),
    result: h("div", {}),
    keys: h("div", { class: "row" }),
    place: h("output", { class: "film-time" }),
    pick: h("select", { "aria-label": text("film.tool"), "data-film": "tool" }),
  };
}

/** @param {View} view @param {string} words */
function say({ app, status, layer }, words) {
  status.textContent = words;
  // what is told beside the film is not read by who marks in it
  if (layer) app.announce(words);
}

/** What can be marked, in its order. @param {View} view */
const toolsOf = ({ app }) => [
  ...["one", "two", "pivot"],
  ...app.store.get().pendulum.length.map((_, k) => String(k + 1)),
  "below", // where the camera is not upright
];

/** @param {Text} text @param {string} tool */
const toolName = (text, tool) =>
  Number(tool) ? text("film.tip", { arm: tool }) : text(`film.${tool}`);

/** The choice of what is marked next. @param {View} view */
function showTools(view) {
  const { app, pick, tool } = view;
  const options = toolsOf(view).map((value) =>
    h("option", { value, selected: value === tool }, toolName(app.text, value)),
  );
  pick.replaceChildren(...options);
}

/** @param {View} view @param {string} tool */
function choose(view, tool) {
  view.tool = tool;
  showTools(view);
}

/** Where a film's places are on the stage: after a fit as it says. @param {View} view */
function placingOf({ marks, camera, told }) {
  if (!marks) return null;
  const how = marking.placing(marks);
  if (!camera || told !== marking.tableOf(marks, "point")) return how.unit === "m" ? how : null;
  const { scale, rotation, origin } = camera;
  /** @type {import("./film_marks.js").Complex} */
  const turn = [Math.cos(rotation) / scale, -Math.sin(rotation) / scale];
  const a = marking.times([how.a[0] - origin[0], how.a[1] - origin[1]], turn);
  return { a, b: marking.times(how.b, turn) };
}

/** The film behind the stage, where it is known how large it is. @param {View} view */
function showBehind(view) {
  const { back, marks, film } = view;
  if (!back || !marks || !film) return;
  const how = placingOf(view);
  if (how && !view.layer) back.show(how, marks.slow);
  else back.hide();
}

/** What has been marked, and what can be done with it. @param {View} view */
function showResult(view) {
  const { app, marks, result } = view;
  const { text } = app;
  result.hidden = !marks;
  if (!marks) return;
  const arms = marking.markedArms(marks);
  const counts = arms.map((arm) =>
    h(
      "li",
      { "data-marked": arm },
      text("film.marked", { arm, count: text.number(marks.tips[arm].length, 0) }),
    ),
  );
  const scale = marking.scaleOf(marks);
  const words = scale ? text("film.scaled", { scale: text.short(scale) }) : text("film.unscaled");
  const options = Object.keys(MARKS).map((value) => ({
    value,
    words: text(`table.marks.${value}`),
  }));
  const form = choice(text("table.marks"), options, view.form, (value) => (view.form = value));
  const off = { disabled: !arms.length };
  result.replaceChildren(
    h("p", { class: "quiet" }, words),
    h("ul", { class: "film-counts" }, ...counts),
    h("div", { class: "row" }, form.element),
    h(
      "div",
      { class: "row" },
      button(text("film.fit"), () => toFit(view), {
        class: "button main",
        "data-film": "fit",
        ...off,
      }),
      button(text("film.save"), () => toFile(view), { "data-film": "save", ...off }),
      button(text("film.clear"), () => clear(view), { "data-film": "clear", ...off }),
    ),
  );
}

/** The marks have changed. @param {View} view */
function changed(view) {
  const { marks } = view;
  if (marks) marking.keepMarks(marks);
  showResult(view);
  showBehind(view);
  view.layer?.draw();
}

/** @param {View} view */
function toFile({ app, marks, form, status }) {
  if (!marks) return;
  const name = "pendulum-film.csv";
  const blob = new Blob([`\ufeff${marking.tableOf(marks, form)}`], {
    type: "text/csv;charset=utf-8",
  });
  save(blob, name);
  status.textContent = app.text("plots.saved", { name });
}

/** A table as a text field gives it back. @param {string} table */
const plain = (table) => table.replaceAll("\r\n", "\n");

/** @param {View} view */
function toFit(view) {
  const { app, marks } = view;
  if (!marks) return;
  endMarking(view);
  view.told = marking.tableOf(marks, "point");
  view.camera = null;
  const table = marking.tableOf(marks, view.form);
  view.handed = plain(table);
  openMeasurements(app, table);
}

/** Takes the marks of all tips away. @param {View} view */
function clear(view) {
  if (!view.marks) return;
  view.marks.tips = {};
  changed(view);
}

/** Which picture is seen. @param {View} view */
function showTime({ app, film, marks, place }) {
  if (!film || !marks) return;
  place.textContent = app.text("seconds", {
    time: app.text.number(film.time / marks.slow, 3),
  });
}

/** @param {View} view @param {1 | -1} way */
async function go(view, way) {
  const { film, marks } = view;
  if (!film || !marks) return false;
  const moved = await step(film, way, marks.rate);
  // what has been marked in this picture for another time is its place at this one
  if (film.twin >= 0)
    for (const arm of marking.markedArms(marks)) marking.setTip(marks, arm, film.twin, null);
  showTime(view);
  view.layer?.draw();
  return moved;
}

/**
 * Tracks what is at a spot to the end of the film.
 * @param {View} view @param {number} arm @param {number[]} spot
 */
async function followFrom(view, arm, [x, y]) {
  const { app, film, marks } = view;
  if (!film || !marks) return;
  const { text } = app;
  const { pick, follow } = TRACKERS[view.track];
  const begun = pick(pictureOf(film), x, y, view.tolerance);
  if (!begun) return say(view, text("film.none"));
  const stop = new AbortController();
  view.search = stop;
  let { found } = begun;
  let [vx, vy, lost, count] = [0, 0, 0, 1];
  marking.setTip(marks, arm, film.time, [found.x, found.y]);
  say(view, text("film.following"));
  try {
    while (!stop.signal.aborted && (await go(view, 1)) && lost < LOST) {
      // the same picture once more: it was a picture too early there, after two pictures' way
      const twin = film.twin >= 0;
      if (twin) [vx, vy, count] = [vx / 2, vy / 2, count - 1];
      const near = twin ? found : { x: found.x + vx, y: found.y + vy };
      const next = follow(pictureOf(film), begun.wanted, near);
      if (next) {
        if (!twin) [vx, vy] = lost ? [0, 0] : [next.x - found.x, next.y - found.y];
        found = next;
        marking.setTip(marks, arm, film.time, [next.x, next.y]);
        count++;
      }
      lost = next ? 0 : lost + 1;
    }
  } finally {
    view.search = null;
  }
  changed(view);
  say(view, text(lost ? "film.lost" : "film.followed", { count: text.number(count, 0), arm }));
}

/** What is marked after a tool. @param {View} view */
function nextTool(view) {
  const tools = toolsOf(view).slice(0, -1);
  return view.tool === "below" ? "1" : tools[tools.indexOf(view.tool) + 1];
}

/** A mark, where the cross is. @param {View} view @param {number[]} spot */
async function place(view, spot) {
  const { app, film, marks, tool } = view;
  if (!film || !marks || view.search) return;
  const arm = Number(tool);
  if (arm && view.track) return followFrom(view, arm, spot);
  if (arm) marking.setTip(marks, arm, film.time, spot);
  else marks.fixed[/** @type {"one"} */ (tool)] = [...spot];
  changed(view);
  const [x, y] = marking.placeOf(marking.placing(marks), spot);
  const { unit } = marking.placing(marks);
  const words = {
    what: toolName(app.text, tool),
    x: app.text.short(x),
    y: app.text.short(y),
    unit,
  };
  say(view, app.text("film.placed", words));
  const next = nextTool(view);
  if (next) return choose(view, next);
  // the last tip of this picture: on to the next picture
  choose(view, "1");
  if (!(await go(view, 1))) say(view, app.text("film.end"));
}

/** Takes the mark away that would be set. @param {View} view */
function remove(view) {
  const { film, marks, tool } = view;
  if (!film || !marks || view.search) return;
  if (Number(tool)) marking.setTip(marks, Number(tool), film.time, null);
  else delete marks.fixed[/** @type {"one"} */ (tool)];
  changed(view);
}

/** Lays the film over the stage. @param {View} view */
async function beginMarking(view) {
  const { app, film, marks } = view;
  if (!film || !marks || view.layer) return;
  const { text, clock } = app;
  clock.pause();
  view.back?.hide();
  choose(view, ["one", "two", "pivot"].find((tool) => !(tool in marks.fixed)) ?? "1");
  const hooks = {
    place: (/** @type {number[]} */ spot) => place(view, spot),
    step: (/** @type {1 | -1} */ way) => view.search || go(view, way),
    remove: () => remove(view),
    done: () => (view.search ? view.search.abort() : endMarking(view)),
  };
  const ways = ["", ...Object.keys(TRACKERS)].map((value) => ({
    value,
    words: text(`film.track.${value || "hand"}`),
  }));
  const track = choice(text("film.track"), ways, view.track, (value) => (view.track = value));
  track.select.dataset.film = "track";
  const away = button(text("film.remove"), hooks.remove, { "data-film": "remove" });
  const next = h("label", {}, text("film.tool"), " ", view.pick);
  const tools = [view.place, next, track.element, away];
  view.layer = createLayer(text, film, marks, hooks, tools);
  showTime(view);
  showKeys(view);
  view.layer.focus();
  // the picture that was seen behind the motion has another time
  if (placingOf(view)) await seek(film, film.video.currentTime);
  showTime(view);
  view.layer?.draw();
}

/** @param {View} view */
function endMarking(view) {
  view.search?.abort();
  if (!view.layer) return;
  view.layer.destroy();
  view.layer = null;
  showKeys(view);
  showBehind(view);
  /** @type {HTMLElement | null} */ (view.keys.querySelector("[data-film=mark]"))?.focus();
}

/** @param {View} view */
function showKeys(view) {
  const { app, film, keys, layer } = view;
  const { text } = app;
  const open = view.keys.querySelector("[data-film=open]");
  const mark = layer
    ? button(text("film.done"), () => endMarking(view), { "data-film": "mark" })
    : button(text("film.mark"), () => beginMarking(view), {
        "data-film": "mark",
        class: "button main",
      });
  keys.replaceChildren(...(open ? [open] : []), ...(film ? [mark] : []));
}

/** A number of the film. @param {View} view @param {"metres" | "slow" | "rate"} name
 * @param {string} unit */
function numberOf(view, name, unit) {
  const { app, marks } = view;
  const { text } = app;
  const label = text(`film.${name}`);
  const value = marks ? text.short(marks[name], 6) : "";
  const change = () => {
    const typed = text.read(input.value);
    if (!view.marks) return;
    if (typed > 0 && Number.isFinite(typed)) view.marks[name] = typed;
    input.value = text.short(view.marks[name], 6);
    changed(view);
    showTime(view);
  };
  const more = { type: "text", inputmode: "decimal", "aria-label": label, "data-film": name };
  const input = h("input", { ...more, value, on: { change } });
  const field = h("span", { class: "with-unit" }, input, h("span", { class: "unit" }, unit));
  return h("label", { class: "choice" }, h("span", {}, label), field);
}

/** @param {View} view */
function showSettings(view) {
  const { app, film, settings } = view;
  const { text } = app;
  const input = () => (view.tolerance = Number(range.value));
  const range = h("input", {
    ...{ type: "range", min: 10, max: 100, step: 1, value: view.tolerance, on: { input } },
    "data-film": "tolerance",
  });
  const tolerance = h("label", { class: "choice" }, h("span", {}, text("film.tolerance")), range);
  settings.replaceChildren(
    numberOf(view, "metres", "m"),
    numberOf(view, "slow", "\u00d7"),
    ...(film && !film.tells ? [numberOf(view, "rate", "1/s")] : []),
    tolerance,
  );
  settings.hidden = !view.marks;
}

/** @param {View} view */
function showAll(view) {
  showKeys(view);
  showSettings(view);
  showResult(view);
  showBehind(view);
}

/** A film that is chosen or dropped, with the marks that are kept of it. @param {View} view
 * @param {File | undefined} file */
async function take(view, file) {
  if (!file) return;
  const { app } = view;
  const { text } = app;
  endMarking(view);
  say(view, text("film.opening"));
  view.wanted = file;
  try {
    const film = await openFilm(file);
    // another one was chosen meanwhile, or the part is gone
    if (view.wanted !== file) return film.close();
    view.back?.destroy();
    view.film?.close();
    Object.assign(view, { film, shown: file });
    const { name, size } = file;
    const kept = marking.keptMarks().find((one) => marking.sameFilm(one, { name, size }));
    view.marks = kept ?? marking.noMarks({ name, size }, film);
    Object.assign(view, { told: "", handed: "", camera: null, back: createBehind(app, film) });
    showAll(view);
    const time = text.number(film.duration, 1);
    say(view, text(kept ? "film.again" : "film.opened", { name, time }));
    if (!kept && film.tells) await beginMarking(view);
  } catch {
    if (view.wanted !== file) return;
    view.wanted = view.shown;
    say(view, text("film.refused", { name: file.name }));
  }
}

/** Leaves the film to this part in another language. @param {View} view */
function leave(view) {
  const { app, wanted: file, told, handed, camera, film } = view;
  app.shot = file && { file, told, handed, camera, time: film?.video.currentTime ?? 0 };
  view.wanted = null;
}

/** @param {View} view @param {Shot} shot that was left */
async function resume(view, { file, time, ...rest }) {
  view.app.shot = null;
  await take(view, file);
  if (view.wanted !== file || !view.film) return;
  Object.assign(view, rest);
  showAll(view);
  await seek(view.film, time);
}

/** What a fit to the marks has found; until when the film goes on, s of the pendulum.
 * @param {View} view @param {string} table @param {FitCamera} camera */
function fitted(view, table, camera) {
  const { marks, film, handed } = view;
  if (!marks || !film || plain(table) !== handed) return null;
  view.camera = camera;
  showBehind(view);
  return film.duration / marks.slow;
}

/** @param {App} app @returns {View} */
function createView(app) {
  const { text } = app;
  const first = { film: null, marks: null, tool: "one", layer: null, back: null, search: null };
  const view = {
    ...{ ...partsOf(text), ...first, app, wanted: null, shown: null },
    ...{ tolerance: TOLERANCE, told: "", handed: "" },
    ...{ form: ownMarks(), camera: null, track: "colour" },
  };
  const input = h("input", {
    ...{ type: "file", accept: "video/*", class: "unseen", tabindex: -1, "aria-hidden": "true" },
    "data-film": "file",
  });
  input.addEventListener("change", () => take(view, input.files?.[0]));
  view.keys.append(
    h(
      "span",
      { "data-film": "open" },
      button(text("film.open"), () => input.click()),
      input,
    ),
  );
  view.pick.addEventListener("change", () => (view.tool = view.pick.value));
  return view;
}

/** The part of the drawer Measure, which is loaded when it is opened. @param {App} app */
export default async function mountFilm(app) {
  const { text, files, store } = app;
  const words = ["film", "drawers"].map((name) => text.part(name));
  await Promise.all([...words, files.style("drawers/kit/curves.css")]);
  const bag = createBag();
  const view = createView(app);
  const element = h("div", { class: "film" });
  const intro = h("p", { class: "quiet" }, text("film.intro"));
  element.append(intro, view.keys, view.status, view.settings, view.result);
  dropping(element, (file) => take(view, file));
  // marks of the last film are there before it is chosen again
  const [last = null] = marking.keptMarks();
  view.marks = last;
  showAll(view);
  if (app.shot) resume(view, app.shot);
  else if (last) say(view, text("film.kept", { name: last.name }));
  bag(store.subscribe((doc, before) => doc.pendulum !== before.pendulum && showTools(view)));
  const own = { fitted: fitted.bind(null, view) };
  app.film = own;
  bag(() => app.film === own && (app.film = null));
  bag(() => endMarking(view));
  bag(() => leave(view));
  bag(() => view.back?.destroy());
  bag(() => view.film?.close());
  return { element, hide: () => endMarking(view), destroy: bag.end };
}
