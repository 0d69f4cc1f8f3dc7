// Fits: a table of measurements, what its columns are, which numbers of the pendulum they are to
// tell; the fit, and the fitted pendulum on the stage.
// Leaves to others: the table (fit_table.js), the request (fit_request.js), the answer
// (fit_answer.js), a long computation (job.js).
// Invariant: the numbers of the request are those that the engine read.

import { said } from "../../client.js";
import { h } from "../../dom.js";
import { fromRequest } from "../../state.js";
import { reach } from "../../tree.js";
import { motionOf, nameOf, scrolled, showFit } from "./fit_answer.js";
import { wordsOf } from "./fit_files.js";
import { paperOf } from "./fit_report.js";
import { candidatesOf, fitBody, foundOf, measuredOf, plainTree, usual } from "./fit_request.js";
import * as tables from "./fit_table.js";
import { computed } from "../kit/job.js";
import { aborted, button, choice, settled, tick } from "../kit/kit.js";

const STEP = 0.01; // s between the samples of the fitted motion

/** @typedef {import("./fit_request.js").Choices} Choices */

/**
 * The part while it is there; tree: that is fitted, of which `choices.unknown` are numbers; arms:
 * of the table.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, table: import("./fit_table.js").FitTable | null, choices: Choices, tree: Tree,
 *   arms: number,
 *   looking: AbortController | null, stop: AbortController | null, endPlots: () => void,
 *   run: HTMLButtonElement,
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
  columns: [],
  angle: "deg",
  place: "m",
  down: false,
  origin: false,
  turned: false,
  tilt: false,
  distortion: false,
  stage: false,
  sigmaAngle: NaN,
  sigmaPlace: NaN,
  unknown: new Set(usual(tree)),
});

/** @param {View} view @param {string} words @param {boolean} bad */
function say({ status }, words, bad = false) {
  status.textContent = words;
  status.classList.toggle("fault", bad);
}

/** What follows from a table that is new. @param {View} view */
function chooseFirst({ choices, table }, /** @type {Tree} */ tree) {
  if (!table) return;
  choices.place = tables.placeOf(table, reach(tree));
  choices.origin = choices.place === "px";
  choices.down = table.suggestions.some((words) => words.includes('"down": true'));
  choices.unknown = new Set(usual(tree));
  // a zero that is elsewhere is found with the rest
  for (const words of table.suggestions) {
    const arm = /"zero" of arm (\d+)/.exec(words)?.[1];
    if (arm) choices.unknown.add(`zero ${arm}`);
  }
}

/**
 * The pendulum to be fitted, and the table as the engine reads it for this one: that of the stage,
 * or a plain one where the table measures another number of arms.
 * @param {View} view @param {string} words @param {import("./fit_table.js").Given} given
 * @param {AbortSignal} signal
 */
async function fitted(view, words, given, signal) {
  const { client, store } = view.app;
  const { pendulum } = store.get();
  const table = await tables.tableOf(client, pendulum, words, given, signal);
  view.arms = await tables.armsOf(client, table, words, signal);
  const same = !view.arms || view.arms === pendulum.length.length || view.choices.stage;
  if (same) return { tree: pendulum, table };
  const tree = plainTree(view.arms, pendulum.gravity, table);
  return { tree, table: await tables.tableOf(client, tree, words, given, signal) };
}

/** What the engine says of a text that is no table. @param {any} error @param {Text} text */
function faultOf(error, text) {
  const fault = error.problem?.errors?.find(
    (/** @type {any} */ one) => one.pointer === "/data/csv",
  );
  if (!fault) return said(error, text);
  return [text("fits.noTable"), text("fits.words"), fault.detail].join(" ");
}

/**
 * Lets the engine read what stands in the field; answers whether it could.
 * @param {View} view @param {import("./fit_table.js").Given} given for the columns; [] = a new
 * table
 */
async function read(view, given = []) {
  const { app, field, choices } = view;
  const { text } = app;
  const words = field.value;
  view.looking?.abort();
  const looking = new AbortController();
  Object.assign(view, { looking, fitted: null });
  if (!given.length) view.table = null;
  let fault = "";
  try {
    if (words.trim()) Object.assign(view, await fitted(view, words, given, looking.signal));
    choices.columns = given;
  } catch (error) {
    if (aborted(error)) return false;
    fault = faultOf(error, text);
  }
  if (!given.length) chooseFirst(view, view.tree);
  if (view.table) choices.angle = tables.angleOf(view.table);
  build(view);
  say(view, fault || (view.table ? text("fits.rows", { count: view.table.rows }) : ""), !!fault);
  return !fault;
}

/** @param {View} view */
function columnsOf(view) {
  const { app, table, choices, unknowns, answer, tree } = view;
  const { text } = app;
  if (!table) return [];
  const arms = tree.length.length;
  const rows = tables.columnsShown(text, table, arms, (k, value) =>
    read(view, tables.givenWith(table, choices.columns, k, value)),
  );
  const doubts = tables.doubtsShown(text, table);
  answer.replaceChildren();
  unknowns.hidden = false;
  return [scrolled(text("fits.columns"), ...rows), ...(doubts ? [doubts] : []), ...otherOf(view)];
}

/** That the pendulum to be fitted is not that of the stage, with the other choice.
 * @param {View} view */
function otherOf(view) {
  const { app, arms, choices } = view;
  const { text, store } = app;
  const has = store.get().pendulum.length.length;
  if (!arms || arms === has) return [];
  const change = () => {
    choices.stage = !choices.stage;
    read(view);
  };
  const words = text("fits.arms", { arms, has });
  const key = text(choices.stage ? "fits.plain" : "fits.stage");
  return [h("p", { "data-fit": "arms" }, words, " ", button(key, change, { class: "link" }))];
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

/** Units, the camera and errors, as far as the columns need them. @param {View} view */
function showOptions(view) {
  const { app, choices, options, table } = view;
  const { text } = app;
  if (!table) return options.replaceChildren();
  const turning = tables.columnsLike(table, /^(theta|phi|joint)/).length > 0;
  const places = tables.columnsLike(table, /^[xy]/).length > 0;
  const units = (
    /** @type {"angle" | "place"} */ name,
    /** @type {string[]} */ list,
    /** @type {(value: string) => unknown} */ change,
  ) => {
    const all = list.map((value) => ({ value, words: text(`fits.in.${value}`) }));
    const pick = choice(text(`fits.${name}`), all, choices[name], change);
    pick.select.dataset.fit = name;
    return pick.element;
  };
  const box = (/** @type {"down" | "origin" | "turned" | "tilt" | "distortion"} */ name) => {
    const one = tick(text(`fits.${name}`), choices[name], (on) => {
      choices[name] = on;
    });
    one.box.dataset.fit = name;
    return one.element;
  };
  const sigma = (/** @type {"sigmaAngle" | "sigmaPlace"} */ name, /** @type {string} */ unit) =>
    numberField(text, text(`fits.${name}`), unit, (value) => (choices[name] = value), name);
  const angle = () =>
    units("angle", ["deg", "rad"], (value) =>
      read(view, tables.givenIn(table, choices.columns, value)),
    );
  const place = () =>
    units("place", ["m", "cm", "mm", "px"], (value) => {
      choices.place = value;
      showOptions(view);
    });
  options.replaceChildren(
    ...(turning ? [angle(), sigma("sigmaAngle", choices.angle === "deg" ? "\u00b0" : "rad")] : []),
    ...(places
      ? [place(), box("down"), box("origin"), box("turned"), box("tilt"), box("distortion")]
      : []),
    ...(places ? [sigma("sigmaPlace", choices.place)] : []),
  );
}

/** Which numbers are to be found: a row each, a column an arm. @param {View} view */
function unknownsOf({ app, choices, table, tree }) {
  const { text } = app;
  const boxes = (table ? candidatesOf(tree, table) : []).map((one) => {
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
  const { table, columns, unknowns, run } = view;
  columns.replaceChildren(...columnsOf(view));
  showOptions(view);
  unknowns.replaceChildren(...(table ? [unknownsOf(view)] : []));
  run.hidden = !table;
}

/** What keeps the fit from being asked for, in words; "" if nothing does. @param {View} view */
function missing({ app, table }) {
  const { text } = app;
  if (!table) return text("fits.noTable");
  if (table.data) return "";
  if (!tables.columnsLike(table, /^t$/).length) return text("fits.noTime");
  const measured = tables.columnsLike(table, /^(?!t$|sigma|$)/);
  return measured.length ? table.suggestions.join(" ") : text("fits.nothing");
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
    report: () =>
      printed(view, fitted).catch((error) => say(view, said(error, view.app.text), true)),
  };
  view.endPlots = await showFit(view.app, view.answer, fitted, signal, acts);
}

/** @param {View} view @param {import("./fit_answer.js").Fitted} fitted */
async function printed({ app, field, answer }, fitted) {
  const { default: print } = await app.files.script("drawers/share/report.js");
  await print(app, () => paperOf(app.text, fitted, field.value, answer));
}

/** Where the page was in another language. @param {View} view @param {Fitting} left */
async function resume(view, { words, choices, fitted }) {
  const { app, field } = view;
  app.fitting = null;
  field.value = words;
  view.choices.stage = choices.stage;
  if (!(await read(view, choices.columns)) || !view.table) return;
  const known = new Set(candidatesOf(view.tree, view.table).map(({ id }) => id));
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
  const { client, text } = app;
  if (view.stop) return view.stop.abort();
  const fault = missing(view);
  if (fault || !table) return say(view, fault, true);
  const stop = new AbortController();
  const measured = measuredOf(table, choices);
  const body = fitBody(view.tree, table, measured, choices);
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
    await show(view, { body, answer: told, found, measured, unit }, stop.signal);
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
  const words = await wordsOf(file).catch(() => null);
  if (words === null) return say(view, view.app.text("fits.binary"), true);
  view.choices.stage = false;
  view.field.value = words;
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

/** The button that opens a file, and its unseen input. @param {View} view */
function openerOf(view) {
  const accept = ".csv,.txt,.tsv,.dat,.xlsx,.zip,text/csv,text/plain";
  const unseen = { class: "unseen", tabindex: -1, "aria-hidden": "true" };
  const input = h("input", { type: "file", accept, ...unseen });
  input.addEventListener("change", () => take(view, input.files?.[0]));
  return [button(view.app.text("fits.open"), () => input.click()), input];
}

/**
 * The part, and what reads a table that another part of the page hands over.
 * @param {App} app
 */
export default async function mountFits(app) {
  const { store, text, files } = app;
  const style = files.style("drawers/kit/curves.css");
  await Promise.all([text.part("fits"), text.part("physics"), style]);
  const { pendulum } = store.get();
  /** @type {View} */
  const view = {
    ...partsOf(text),
    app,
    table: null,
    choices: firstChoices(pendulum),
    tree: pendulum,
    arms: 0,
    looking: null,
    stop: null,
    endPlots: () => {},
    fitted: null,
    run: button(text("fits.run"), () => fit(view), { class: "button main", hidden: true }),
  };
  view.run.dataset.fit = "run";
  const soon = settled(() => read(view));
  view.field.addEventListener("input", () => {
    say(view, "");
    view.run.hidden = true;
    soon();
  });
  const [open, input] = openerOf(view);
  const element = h("div", { class: "fit" });
  const intro = h("p", { class: "quiet" }, text("fits.intro"));
  const keys = h("div", { class: "row" }, open, input);
  element.append(intro, view.field, keys, view.status, view.columns, view.options, view.unknowns);
  element.append(h("div", { class: "row" }, view.run), view.bar, view.answer);
  dropping(view, element);
  if (app.fitting) resume(view, app.fitting);
  let stage = pendulum.parent.length;
  const end = store.subscribe((doc) => {
    const { length: arms } = doc.pendulum.parent;
    if (arms !== stage && view.table) read(view);
    stage = arms;
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
      soon.end();
      view.looking?.abort();
      view.stop?.abort();
      view.endPlots();
    },
  };
}
