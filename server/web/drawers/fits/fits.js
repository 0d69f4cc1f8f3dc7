// Fits: a table of measurements, what its columns are, which numbers of the pendulum they are to
// tell; the fit, and the fitted pendulum on the stage.
// Leaves to others: reading the table (fit_table.js), the request (fit_request.js), the answer
// (fit_answer.js), a long computation (job.js).
// Invariant: the numbers of the request are those of the table; what a column is taken for is seen
// and can be changed.

import { said } from "../../client.js";
import { h } from "../../dom.js";
import { fromRequest } from "../../state.js";
import { reach } from "../../tree.js";
import { motionOf, nameOf, scrolled, showFit } from "./fit_answer.js";
import { candidatesOf, fitBody, foundOf, measuredOf, usual } from "./fit_request.js";
import { guessAngle, guessPlace, guessRoles, readTable } from "./fit_table.js";
import { computed } from "../kit/job.js";
import { aborted, button, choice, figure, tick } from "../kit/kit.js";

const SHOWN = 4; // rows of the table
const STEP = 0.01; // s between the samples of the fitted motion

/** @typedef {import("./fit_request.js").Choices} Choices */

/**
 * The part while it is there; tree: of which `choices.unknown` are numbers.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, table: import("./fit_table.js").FitTable | null, choices: Choices, tree: Tree,
 *   stop: AbortController | null, endPlots: () => void, run: HTMLButtonElement,
 *   fitted: import("./fit_answer.js").Fitted | null,
 * }} View
 */

/** @param {Text} text */
function partsOf(text) {
  const field = { class: "fit-text", spellcheck: "false", "aria-label": text("fits.paste") };
  return {
    field: h("textarea", { ...field, placeholder: "t;x;y\n0,00;0,31;-0,95\n0,04;0,30;-0,96" }),
    status: h("p", { role: "status", "data-fit": "status" }),
    columns: h("div", { class: "fit-columns" }),
    options: h("div", { class: "fit-options" }),
    unknowns: h("div", {}),
    bar: h("progress", { max: 1, hidden: true, "aria-label": text("fits.running") }),
    answer: h("div", { "data-fit": "answer" }),
  };
}

/** @param {Tree} tree @returns {Choices} */
const firstChoices = (tree) => ({
  roles: [],
  angle: "deg",
  place: "m",
  down: false,
  origin: false,
  turned: false,
  sigmaAngle: NaN,
  sigmaPlace: NaN,
  unknown: new Set(usual(tree)),
});

/** @param {View} view @param {string} words @param {boolean} bad */
function say({ status }, words, bad = false) {
  status.textContent = words;
  status.classList.toggle("fault", bad);
}

/** Reads what stands in the field. @param {View} view */
function read(view) {
  const { app, field, choices } = view;
  const { text, store } = app;
  const { pendulum } = store.get();
  view.table = readTable(field.value);
  const { table } = view;
  if (table) {
    choices.roles = guessRoles(table, pendulum.length.length);
    choices.angle = guessAngle(table, choices.roles);
    choices.place = guessPlace(table, choices.roles, reach(pendulum));
    choices.origin = choices.place === "px";
    choices.unknown = new Set(usual(pendulum));
  }
  view.tree = pendulum;
  view.fitted = null;
  build(view);
  if (!table) say(view, field.value.trim() ? text("fits.noTable") : "", true);
  else if (table.faults.length) {
    const faults = table.faults.map((fault) => text("fits.fault", fault));
    say(view, faults.join(" "), true);
  } else say(view, text("fits.rows", { count: table.lines.length }));
}

/** The table's first rows, each column with what it is. @param {View} view */
function columnsOf({ app, table, choices, options, unknowns, answer }) {
  const { text, store } = app;
  if (!table) return [];
  const arms = store.get().pendulum.length.map((_, k) => k + 1);
  const kinds = ["theta", "x", "y", "phi"];
  const roles = arms.flatMap((arm) =>
    kinds.map((kind) => ({ value: `${kind} ${arm}`, words: text(`fits.role.${kind}`, { arm }) })),
  );
  const none = { value: "", words: text("fits.role.none") };
  const list = [none, { value: "t", words: text("fits.time") }, ...roles];
  const heads = table.columns.map(({ name }, k) => {
    const pick = choice(name || String(k + 1), list, choices.roles[k], (value) => {
      choices.roles[k] = value;
      showOptions(app, choices, options);
    });
    pick.select.dataset.column = String(k);
    return h("th", { scope: "col" }, pick.element);
  });
  const rows = table.lines.slice(0, SHOWN).map((_, i) =>
    h(
      "tr",
      {},
      ...table.columns.map(({ values }) => {
        const value = values[i];
        return h("td", {}, value === null ? "" : figure(text, value, 5));
      }),
    ),
  );
  answer.replaceChildren();
  unknowns.hidden = false;
  return [scrolled(text("fits.columns"), h("tr", {}, ...heads), ...rows)];
}

/** A number that may be left out. @param {Text} text @param {string} label @param {string} unit
 * @param {(value: number) => void} change @param {string} id */
function numberField(text, label, unit, change, id) {
  const input = h("input", {
    type: "text",
    inputmode: "decimal",
    "data-fit": id,
    "aria-label": label,
  });
  input.addEventListener("change", () => change(text.read(input.value)));
  const field = h("span", { class: "with-unit" }, input, h("span", { class: "unit" }, unit));
  return h("label", { class: "choice" }, h("span", {}, label), field);
}

/** Units, the camera and errors, as far as the columns need them. @param {App} app
 * @param {Choices} choices @param {HTMLElement} place */
function showOptions(app, choices, place) {
  const { text } = app;
  const turning = choices.roles.some((role) => /^(theta|phi)/.test(role));
  const places = choices.roles.some((role) => /^[xy]/.test(role));
  const again = () => showOptions(app, choices, place);
  const units = (/** @type {"angle" | "place"} */ name, /** @type {string[]} */ list) => {
    const all = list.map((value) => ({ value, words: text(`fits.in.${value}`) }));
    const pick = choice(text(`fits.${name}`), all, choices[name], (value) => {
      choices[name] = value;
      again();
    });
    pick.select.dataset.fit = name;
    return pick.element;
  };
  const box = (/** @type {"down" | "origin" | "turned"} */ name) => {
    const one = tick(text(`fits.${name}`), choices[name], (on) => {
      choices[name] = on;
    });
    one.box.dataset.fit = name;
    return one.element;
  };
  const sigma = (/** @type {"sigmaAngle" | "sigmaPlace"} */ name, /** @type {string} */ unit) =>
    numberField(text, text(`fits.${name}`), unit, (value) => (choices[name] = value), name);
  const angle = choices.angle === "deg" ? "\u00b0" : "rad";
  place.replaceChildren(
    ...(turning ? [units("angle", ["deg", "rad"]), sigma("sigmaAngle", angle)] : []),
    ...(places ? [units("place", ["m", "cm", "mm", "px"])] : []),
    ...(places ? [box("down"), box("origin"), box("turned")] : []),
    ...(places ? [sigma("sigmaPlace", choices.place)] : []),
  );
}

/** Which numbers are to be found: a row each, a column an arm. @param {View} view */
function unknownsOf({ app, choices }) {
  const { text, store } = app;
  const { pendulum } = store.get();
  const boxes = candidatesOf(pendulum).map((one) => {
    const part = tick(nameOf(text, one), choices.unknown.has(one.id), (on) => {
      if (on) choices.unknown.add(one.id);
      else choices.unknown.delete(one.id);
    });
    part.box.dataset.unknown = one.id;
    return part.element;
  });
  const legend = h("legend", {}, text("fits.unknowns"));
  return h(
    "fieldset",
    { class: "fit-unknown" },
    legend,
    h("div", { class: "vector-ticks" }, ...boxes),
  );
}

/** @param {View} view */
function build(view) {
  const { app, table, choices, columns, options, unknowns, run } = view;
  columns.replaceChildren(...columnsOf(view));
  if (table) showOptions(app, choices, options);
  unknowns.replaceChildren(...(table ? [unknownsOf(view)] : []));
  if (!table) options.replaceChildren();
  run.hidden = !table;
}

/** What keeps the fit from being asked for, in words; "" if nothing does. @param {View} view */
function missing({ app, table, choices }) {
  const { text } = app;
  if (!table) return text("fits.noTable");
  if (table.faults.length) return text("fits.fault", table.faults[0]);
  if (!choices.roles.includes("t")) return text("fits.noTime");
  const used = choices.roles.filter(Boolean);
  const twice = used.some((role, i) => used.indexOf(role) !== i);
  if (twice) return text("fits.twice");
  if (used.length < 2) return text("fits.nothing");
  const times = table.columns[choices.roles.indexOf("t")].values;
  const back = times.findIndex(
    (time, i) => i > 0 && time !== null && time <= (times[i - 1] ?? -Infinity),
  );
  return back < 0 ? "" : text("fits.unsorted", { line: table.lines[back] });
}

/** Puts the fitted pendulum on the stage. @param {View} view
 * @param {import("./fit_answer.js").Fitted} fitted @param {boolean} beside */
function setOff({ app, field }, fitted, beside) {
  const { store, clock, text, announce } = app;
  const { pendulum, initial, times } = motionOf(fitted);
  if (beside) {
    const ghosts = [...store.get().ghosts, { ...initial, pendulum }];
    store.set({ ghosts }, { label: "ghosts" });
  } else {
    // over its film it moves as long as that does
    const film = app.film?.fitted(field.value, fitted.answer.camera);
    const long = Math.max(times.stop - times.start, film ? film - times.start : 10);
    const span = { start: times.start, stop: times.start + long };
    const patch = fromRequest({ pendulum, initial, times: { ...span, step: STEP } });
    store.set(patch, { label: "change" });
  }
  clock.seek(0);
  clock.play();
  announce(text("fits.moving"));
}

/** Shows what a fit has found. @param {View} view @param {import("./fit_answer.js").Fitted} fitted
 * @param {AbortSignal} signal */
async function show(view, fitted, signal) {
  view.fitted = fitted;
  view.endPlots();
  say(view, "");
  const acts = {
    instead: () => setOff(view, fitted, false),
    beside: () => setOff(view, fitted, true),
  };
  view.endPlots = await showFit(view.app, view.answer, fitted, signal, acts);
}

/** Where the page was in another language. @param {View} view @param {Fitting} left */
function resume(view, { words, choices, fitted }) {
  const { app, field } = view;
  const arms = app.store.get().pendulum.length.length;
  app.fitting = null;
  field.value = words;
  read(view);
  if (!view.table || choices.roles.length !== view.table.columns.length) return;
  if (choices.roles.some((role) => Number(role.split(" ")[1]) > arms)) return;
  const known = new Set(candidatesOf(app.store.get().pendulum).map(({ id }) => id));
  Object.assign(view.choices, choices, {
    unknown: new Set([...choices.unknown].filter((id) => known.has(id))),
  });
  build(view);
  if (!fitted) return;
  view.stop = new AbortController();
  show(view, fitted, view.stop.signal)
    .catch(() => {})
    .finally(() => (view.stop = null));
}

/** @param {View} view */
async function fit(view) {
  const { app, choices, table, bar, run } = view;
  const { client, store, text } = app;
  if (view.stop) return view.stop.abort();
  const fault = missing(view);
  if (fault || !table) return say(view, fault, true);
  const stop = new AbortController();
  const doc = store.get();
  const measured = measuredOf(table, choices);
  const body = fitBody(doc, measured, choices);
  const unit = choices.place;
  const found = foundOf(body, unit);
  view.stop = stop;
  bar.hidden = false;
  bar.removeAttribute("value");
  run.textContent = text("fits.stop");
  say(view, text("fits.running"));
  try {
    const told = await computed(client, "/v1/fits", body, stop.signal, (share) => {
      bar.value = share;
    });
    const fitted = {
      body,
      answer: told,
      found,
      measured,
      unit,
      angle: choices.angle,
    };
    await show(view, fitted, stop.signal);
  } catch (error) {
    say(view, aborted(error) ? text("fits.stopped") : said(error, text), !aborted(error));
  } finally {
    view.stop = null;
    bar.hidden = true;
    run.textContent = text("fits.run");
  }
}

/** A file that is chosen or dropped. @param {View} view @param {File | undefined} file */
async function take(view, file) {
  if (!file) return;
  view.field.value = await file.text();
  read(view);
}

/** @param {View} view @param {HTMLElement} element */
function dropping(view, element) {
  const mark = (/** @type {boolean} */ on) => (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    element.classList.toggle("dropping", on);
  };
  element.addEventListener("dragover", mark(true));
  element.addEventListener("dragleave", mark(false));
  element.addEventListener("drop", (event) => {
    mark(false)(event);
    const words = event.dataTransfer?.getData("text/plain");
    if (event.dataTransfer?.files.length) take(view, event.dataTransfer.files[0]);
    else if (words) {
      view.field.value = words;
      read(view);
    }
  });
}

/**
 * The part, and what reads a table that another part of the page hands over.
 * @param {App} app
 */
export default async function mountFits(app) {
  const { store, text, files } = app;
  await Promise.all([text.part("fits"), files.style("drawers/kit/curves.css")]);
  const { pendulum } = store.get();
  /** @type {View} */
  const view = {
    ...partsOf(text),
    app,
    table: null,
    choices: firstChoices(pendulum),
    tree: pendulum,
    stop: null,
    endPlots: () => {},
    fitted: null,
    run: button(text("fits.run"), () => fit(view), { class: "button main", hidden: true }),
  };
  view.run.dataset.fit = "run";
  view.field.addEventListener("input", () => read(view));
  const accept = ".csv,.txt,.tsv,text/csv,text/plain";
  const input = h("input", {
    type: "file",
    accept,
    class: "unseen",
    tabindex: -1,
    "aria-hidden": "true",
  });
  input.addEventListener("change", () => take(view, input.files?.[0]));
  const open = button(text("fits.open"), () => input.click());
  const element = h("div", { class: "fit" });
  const intro = h("p", { class: "quiet" }, text("fits.intro"));
  const keys = h("div", { class: "row" }, open, input);
  element.append(intro, view.field, keys, view.status, view.columns, view.options, view.unknowns);
  element.append(h("div", { class: "row" }, view.run), view.bar, view.answer);
  dropping(view, element);
  if (app.fitting) resume(view, app.fitting);
  const end = store.subscribe((doc) => {
    const same = doc.pendulum.parent.length === view.tree.parent.length;
    if (!same && view.table) read(view);
  });
  return {
    element,
    /** @param {string} words */
    read(words) {
      view.field.value = words;
      read(view);
    },
    destroy() {
      const { field, choices, fitted } = view;
      app.fitting = field.value ? { words: field.value, choices, fitted } : null;
      end();
      view.stop?.abort();
      view.endPlots();
    },
  };
}
