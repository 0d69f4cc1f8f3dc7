// Method: how the motion is integrated, what that took, and how far it is from a reference that can
// be believed.
// Leaves to others: integrating (the server), the overlaid ghost's motion (motion.js), the fields
// (method_fields.js).
// Invariant: the reference is the server's taylor series of the same start at the same instants,
// finer than the run itself.

import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { ghostColour } from "../palette.js";
import { isStatic } from "../root.js";
import { request, sameMotion } from "../state.js";
import { inPieces } from "../terms.js";
import { createGroup } from "./kit/chart.js";
import { distances, logarithmic } from "./kit/distances.js";
import { aborted, fetchTable, figure, later, settled, swatch, tick } from "./kit/kit.js";
import { showFields } from "./physics/method_fields.js";

const WRONG = 0.1;
const FINE_ARMS = 20; // what 32 digits are cheap for
const FINE_SECONDS = 120;
const EXACT_ARMS = 20; // what the exact bound of the digits is cheap for
const EXACT_SECONDS = 120;
const FACTS = ["steps", "rejected", "evaluations", "drift", "trust", "atEnd", "compute"];
const UNKNOWN = "\u2026";

/**
 * A motion that is judged; distance: from the reference, where that is here.
 * @typedef {{name: string, colour: string, stats: Stats | null, distance: Float64Array | null}} Run
 */

/**
 * The drawer while it is there; known: what the last motions took that were asked about; look: for
 * which colours the chart was made.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, overlay: ReturnType<typeof tick>, shown: boolean, stop: AbortController | null,
 *   reference: {doc: Doc, table: import("./kit/kit.js").Table} | null, known: {doc: Doc, stats:
 *   Stats}[],
 *   group: ChartGroup | null, chart: Chart | null, look: string,
 * }} View
 */

/** @param {Ghost} ghost */
const isPaper = (ghost) => ghost.method === "ode23";
/** @param {Doc} doc @returns {Doc} */
const paperOf = (doc) => ({ ...doc, method: "ode23", rtol: null, atol: null, precision: "double" });

/**
 * 32 digits where they are cheap, else a tolerance that is finer than the run's.
 * @param {Doc} doc @returns {{words: string, way: Partial<Doc>}}
 */
function referenceOf(doc) {
  const { method, precision, rtol, pendulum, span } = doc;
  const taylor = method === "taylor";
  // a server alone has 32 digits, of motions in one piece
  if (
    !isStatic &&
    !inPieces(pendulum) &&
    pendulum.length.length <= FINE_ARMS &&
    span.stop <= FINE_SECONDS
  ) {
    return { words: "method.referenceFine", way: { precision: "extended", rtol: null } };
  }
  const fine = taylor && (precision === "extended" || (rtol ?? 1e-12) <= 1e-12);
  const way = { precision: "double", rtol: fine ? 1e-15 : 1e-12 };
  return { words: fine ? "method.referenceFiner" : "method.reference", way };
}

/** @param {Text} text */
function partsOf(text) {
  const region = {
    class: "scroll",
    tabindex: 0,
    role: "region",
    "aria-label": text("method.stats"),
  };
  return {
    way: h("div", { class: "method-fields" }),
    facts: h("div", region),
    referenceWords: h("p", { class: "quiet" }),
    verdicts: h("div", { role: "status" }),
    legend: h("div", { class: "row small" }),
    host: h("div", { class: "chart", role: "img", "aria-label": text("method.error") }),
  };
}

/** @param {Store} store @param {boolean} on */
function setOverlay(store, on) {
  const { ghosts, initial } = store.get();
  const others = ghosts.filter((ghost) => !isPaper(ghost));
  const paper = { phi: initial.phi, phid: initial.phid, apart: 0, method: "ode23" };
  store.set({ ghosts: on ? [...others, paper] : others }, { label: "ghosts" });
}

/** @param {Text} text @param {Stats} stats @param {Doc["span"]} span @param {Tree} pendulum */
function trust(text, { trust_until: exact, horizon }, { start = 0, stop }, pendulum) {
  const time = exact ?? horizon;
  if (time === undefined) return inPieces(pendulum) ? text("method.trustPieces") : UNKNOWN;
  if (time >= start + stop) return text("method.trustAll");
  return text("seconds", { time: text.number(time, 2) });
}

/**
 * The facts of a run in words, in the order of FACTS.
 * @param {Text} text @param {Run} run @param {Doc} doc
 */
function factsInWords(text, { stats, distance }, { span, pendulum }) {
  if (!stats) return FACTS.map(() => UNKNOWN);
  const whole = (/** @type {number} */ count = 0) => text.short(count, 9);
  const time = figure(text, (stats.compute_seconds ?? 0) * 1000, 2);
  return [
    whole(stats.steps),
    whole(stats.rejected),
    whole(stats.evaluations),
    figure(text, stats.energy_drift ?? NaN, 2),
    trust(text, stats, span, pendulum),
    distance?.length ? figure(text, distance[distance.length - 1], 2) : UNKNOWN,
    text("method.computeValue", { time }),
  ];
}

/** @param {View} view @param {Run[]} runs */
function showFacts({ app, facts }, runs) {
  const { motion, text } = app;
  const columns = runs.map((run) => factsInWords(text, run, motion.doc));
  const heads = runs.map(({ name }) => h("th", { scope: "col" }, name));
  const rows = FACTS.map((name, i) => {
    const title = h("th", { scope: "row" }, text(`method.${name}`));
    return h(
      "tr",
      { "data-fact": name },
      title,
      ...columns.map((column) => h("td", {}, column[i])),
    );
  });
  const head = h("thead", {}, h("tr", {}, h("td", {}), ...heads));
  facts.replaceChildren(h("table", {}, head, h("tbody", {}, ...rows)));
}

/** @param {View} view @param {Doc} doc */
const factsOf = ({ known }, doc) => known.find((one) => sameMotion(one.doc, doc))?.stats ?? null;

/**
 * The motion, and the paper's beside it where it is overlaid.
 * @param {View} view @returns {Run[]}
 */
function runsNow(view) {
  const { app, reference } = view;
  const { motion, text } = app;
  const { doc } = motion;
  const believed = reference && sameMotion(reference.doc, doc) ? reference.table : null;
  const far = (/** @type {Track} */ track) =>
    believed && track.complete ? distances(track, believed) : null;
  const own = {
    name: doc.method,
    colour: "--arm-1",
    stats: factsOf(view, doc),
    distance: far(motion.track),
  };
  const sameStart = (/** @type {State} */ { phi }) =>
    phi.every((angle, k) => angle === doc.initial.phi[k]);
  const paper = motion.ghosts.find(
    (ghost) => ghost.doc.method === "ode23" && sameStart(ghost.initial),
  );
  if (!paper) return [own];
  const colour = ghostColour(motion.ghosts.indexOf(paper));
  const stats = factsOf(view, paperOf(doc));
  return [own, { name: text("method.overlaid"), colour, stats, distance: far(paper) }];
}

/**
 * A chart in the runs' colours.
 * @param {View} view @param {ChartGroup} group @param {Run[]} runs @returns {Chart}
 */
function chartOf(view, group, runs) {
  const series = runs.map(({ colour }) => ({ colour }));
  const look = series.map(({ colour }) => colour).join();
  if (view.chart && look === view.look) return view.chart;
  if (view.chart) group.remove(view.chart);
  view.look = look;
  view.chart = group.add(view.host, { series, log: true, height: 180 });
  return view.chart;
}

/** @param {View} view @param {Run[]} runs */
function showChart(view, runs) {
  const { motion } = view.app;
  view.group ??= createGroup(view.app);
  const chart = chartOf(view, view.group, runs);
  const curves = runs.flatMap(({ distance }) => (distance ? [logarithmic(distance)] : []));
  if (curves.length === runs.length) chart.set([motion.t.slice(0, motion.count), ...curves]);
  else chart.set([new Float64Array(0), ...runs.map(() => [])]);
}

/**
 * Whether a run goes wrong, in words.
 * @param {App} app @param {string} name @param {Float64Array} distance
 */
function verdictOf({ motion, text }, name, distance) {
  const at = distance.findIndex((value) => value > WRONG);
  if (at >= 0) {
    const words = text("method.goesWrong", { name, time: text.number(motion.t[at], 2) });
    return h("p", { class: "verdict wrong" }, words);
  }
  const most = distance.reduce((all, value) => Math.max(all, value), 0);
  return h(
    "p",
    { class: "verdict" },
    text("method.staysRight", { name, most: figure(text, most, 2) }),
  );
}

/** @param {View} view @param {Run[]} runs */
function showVerdicts({ app, verdicts }, runs) {
  const said = runs.flatMap(({ name, distance }) =>
    distance ? [verdictOf(app, name, distance)] : [],
  );
  const waiting = h("p", { class: "quiet" }, app.text("kit.waiting"));
  verdicts.replaceChildren(...(said.length ? said : [waiting]));
}

/** @param {View} view */
function show(view) {
  if (!view.shown) return;
  const { store, motion, text } = view.app;
  view.overlay.box.checked = store.get().ghosts.some(isPaper);
  view.referenceWords.textContent = text(referenceOf(motion.doc).words);
  const runs = runsNow(view);
  showFacts(view, runs);
  showVerdicts(view, runs);
  const names = runs.map(({ name, colour }) =>
    h("span", { class: "name" }, swatch(colour), " ", name),
  );
  view.legend.replaceChildren(...names);
  showChart(view, runs);
}

/**
 * Asks what a motion took, once; with the exact bound of its digits where that is cheap.
 * @param {View} view @param {Doc} doc @param {AbortSignal} signal
 */
async function fetchFacts(view, doc, signal) {
  if (factsOf(view, doc)) return;
  const few =
    !isStatic &&
    !inPieces(doc.pendulum) &&
    doc.pendulum.length.length <= EXACT_ARMS &&
    doc.span.stop <= EXACT_SECONDS;
  const { start = 0, stop } = doc.span;
  const times = { start, stop: start + stop, count: 201 };
  const exact = few && doc.precision === "double" ? { trust: true } : {};
  const body = { ...request(doc), times, output: ["energy"], digits: 4, ...exact };
  const { stats } = await view.app.client.trajectory(body, { signal });
  view.known = [{ doc, stats }, ...view.known].slice(0, 2);
  show(view);
}

/** @param {View} view @param {Doc} doc @param {AbortSignal} signal */
async function fetchReference(view, doc, signal) {
  if (view.reference && sameMotion(view.reference.doc, doc)) return;
  const finer = { ...doc, method: "taylor", atol: null, ...referenceOf(doc).way };
  const body = { ...request(finer), output: ["phi"] };
  const table = await fetchTable(view.app.client, "/v1/trajectories", body, { signal });
  view.reference = { doc, table };
  show(view);
}

/** The facts and the reference of the present run, once that is here itself. @param {View} view */
async function load(view) {
  const { motion, store, text } = view.app;
  if (!view.shown || !motion.complete) return;
  const { doc } = motion;
  view.stop?.abort();
  view.stop = new AbortController();
  const { signal } = view.stop;
  try {
    await fetchFacts(view, doc, signal);
    if (store.get().ghosts.some(isPaper)) await fetchFacts(view, paperOf(store.get()), signal);
    await fetchReference(view, doc, signal);
  } catch (error) {
    if (aborted(error)) return;
    view.verdicts.replaceChildren(h("p", { class: "fault" }, said(error, text)));
  }
}

/** @param {App} app @returns {View} */
function createView(app) {
  const { store, text } = app;
  const overlay = tick(text("method.overlay"), false, (on) => setOverlay(store, on));
  overlay.box.dataset.overlay = "";
  const state = { shown: false, stop: null, reference: null, known: [] };
  return { ...partsOf(text), app, overlay, ...state, group: null, chart: null, look: "" };
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, { app, way, overlay, facts, legend, host, verdicts, referenceWords }) {
  const { text } = app;
  element.append(
    h("h2", {}, text("drawer.method")),
    h("p", { class: "quiet" }, text("method.intro")),
    way,
    h("div", { class: "row" }, overlay.element),
    h("p", { class: "quiet" }, text("method.overlayHint")),
    h("h3", {}, text("method.stats")),
    facts,
    h("h3", { class: "chart-title" }, text("method.error")),
    legend,
    host,
    verdicts,
    referenceWords,
  );
}

/** @param {View} view @param {Bag} bag */
function follow(view, bag) {
  const { store, motion } = view.app;
  const soon = later(() => show(view));
  const loadSoon = settled(() => load(view), 60);
  bag(soon.end);
  bag(loadSoon.end);
  bag(
    store.subscribe((doc, before) => {
      const others = doc.ghosts !== before.ghosts;
      if (!sameMotion(doc, before) || others) showFields(view.app, view.way, doc);
      if (others) loadSoon();
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      if (!view.shown) return;
      soon();
      if (what === "complete") loadSoon();
    }),
  );
  bag(() => view.stop?.abort());
  bag(() => view.group?.destroy());
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const bag = createBag();
  const view = createView(app);
  lay(element, view);
  follow(view, bag);
  showFields(app, view.way, app.store.get());
  return {
    show() {
      view.shown = true;
      show(view);
      load(view);
    },
    hide() {
      view.shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "method", title: (text) => text("drawer.method"), mount };
