// Compare: ghosts of other starts and how far they are from the pendulum, and a map of starts: when
// an arm first turns over (map.js).
// Leaves to others: the ghosts' motions (motion.js), drawing them (the stage).
// Invariant: the ghosts are the document's; what is shown of their distance is of the server's
// samples.

import { DEGREE, thetaOf } from "../angles.js";
import { createBag, h, iconButton } from "../dom.js";
import { ghostColour } from "../palette.js";
import { createGroup } from "./kit/chart.js";
import { distances, logarithmic } from "./kit/distances.js";
import { button, choice, figure, later, swatch } from "./kit/kit.js";

const OFF = [1, 1e-2, 1e-4, 1e-7, 1e-10]; // degrees
const MOST = 6;
const PARTED = 5; // degrees

/**
 * The drawer while it is there; off: by how much the next ghost is turned; lines: how many the
 * chart was made for.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, shown: boolean, off: number, chart: Chart | null, lines: number, group: ChartGroup |
 *   null,
 *   amount: ReturnType<typeof choice>, addOff: HTMLButtonElement, keep: HTMLButtonElement,
 *   beside: HTMLButtonElement, clear: HTMLButtonElement,
 * }} View
 */

/** What a ghost is, in words. @param {Ghost} ghost @param {Text} text */
export function ghostName(ghost, text) {
  if (ghost.beside)
    return text("compare.second", { length: text.short(ghost.pendulum?.length[0] ?? 0) });
  if (ghost.method) return text("compare.ghostMethod", { method: ghost.method });
  if (ghost.apart !== undefined)
    return text("compare.ghostOff", { amount: figure(text, ghost.apart / DEGREE, 2) });
  const tenth = (/** @type {number} */ phi) => Math.round(thetaOf(phi) * 10) / 10;
  const few = ghost.phi.slice(0, 4).map((phi) => `${text.short(tenth(phi))}\u00b0`);
  const angles = few.join(", ") + (ghost.phi.length > 4 ? ", \u2026" : "");
  return text("compare.ghostStart", { angles });
}

/** @param {Text} text */
function partsOf(text) {
  const label = text("compare.distance");
  const host = h("div", { class: "chart", role: "img", "aria-label": label });
  return {
    list: h("ul", { class: "ghosts" }),
    verdict: h("p", { class: "quiet", role: "status" }),
    host,
    chartPlace: h("div", { hidden: true }, h("h3", { class: "chart-title" }, label), host),
  };
}

/** @param {Store} store @param {Partial<Ghost>} more than the document's start */
function add(store, more) {
  const { ghosts, initial } = store.get();
  if (ghosts.length >= MOST) return;
  const ghost = { phi: initial.phi, phid: initial.phid, ...more };
  store.set({ ghosts: [...ghosts, ghost] }, { label: "ghosts" });
}

/** @param {View} view @param {number} i */
function remove({ app, addOff }, i) {
  const { store } = app;
  store.set({ ghosts: store.get().ghosts.filter((_, at) => at !== i) }, { label: "ghosts" });
  addOff.focus();
}

/** @param {View} view */
function showList(view) {
  const { app, list, addOff, keep, clear } = view;
  const { store, text } = app;
  const { ghosts } = store.get();
  addOff.disabled = keep.disabled = ghosts.length >= MOST;
  clear.hidden = ghosts.length < 2;
  const rows = ghosts.map((ghost, i) => {
    const name = ghostName(ghost, text);
    const close = iconButton("close", text("compare.remove", { what: name }), () =>
      remove(view, i),
    );
    return h("li", {}, swatch(ghostColour(i)), h("span", {}, name), close);
  });
  list.replaceChildren(...rows);
  if (!ghosts.length) list.append(h("li", { class: "quiet" }, text("compare.none")));
}

/**
 * A chart of so many lines.
 * @param {View} view @param {ChartGroup} group @param {number} count @returns {Chart}
 */
function chartOf(view, group, count) {
  if (view.chart && view.lines === count) return view.chart;
  if (view.chart) group.remove(view.chart);
  const series = Array.from({ length: count }, (_, i) => ({ colour: ghostColour(i) }));
  view.lines = count;
  view.chart = group.add(view.host, { series, log: true, height: 170 });
  return view.chart;
}

/**
 * From when on a ghost goes its own way, in words.
 * @param {App} app @param {Float64Array[]} all @param {number} i
 */
function partedWords({ motion, text }, all, i) {
  const at = all[i].findIndex((distance) => distance > PARTED);
  const time = at < 0 ? "" : text.number(motion.t[at], 2);
  const words = at < 0 ? text("compare.together") : text("compare.parted", { time });
  const mark = all.length > 1 ? [swatch(ghostColour(i)), " "] : [];
  return h("span", { class: "parted" }, ...mark, words);
}

/** @param {View} view */
function showDistance(view) {
  const { app, chartPlace, verdict } = view;
  const { motion } = app;
  const { ghosts } = motion;
  chartPlace.hidden = !ghosts.length;
  if (!ghosts.length) verdict.textContent = "";
  if (!view.shown || !ghosts.length || !ghosts[0].count || !motion.count) return;
  view.group ??= createGroup(app);
  const all = ghosts.map((ghost) =>
    ghost.count ? distances(motion.track, ghost, DEGREE) : new Float64Array(0),
  );
  const count = Math.max(...all.map((one) => one.length));
  const curves = all.map((one) => logarithmic(one, count));
  chartOf(view, view.group, ghosts.length).set([motion.t.slice(0, count), ...curves]);
  verdict.replaceChildren(...all.map((_, i) => partedWords(app, all, i)));
}

/** @param {App} app @returns {View} */
function createView(app) {
  const { store, text } = app;
  const amounts = OFF.map((value) => ({
    value,
    words: text("degrees", { angle: figure(text, value, 2) }),
  }));
  const take = (/** @type {string} */ value) => {
    view.off = Number(value);
  };
  const addOff = () => add(store, { apart: view.off * DEGREE });
  const clear = () => store.set({ ghosts: [] }, { label: "ghosts" });
  /** @type {View} */
  const view = {
    ...partsOf(text),
    app,
    shown: false,
    off: 1e-4,
    chart: null,
    lines: -1,
    group: null,
    amount: choice(text("compare.off"), amounts, 1e-4, take),
    addOff: button(text("compare.add"), addOff, { "data-add": "off" }),
    keep: button(text("compare.keep"), () => add(store, {}), { "data-add": "keep" }),
    beside: button(text("compare.beside"), app.edits.addBeside, { "data-add": "beside" }),
    clear: button(text("compare.clear"), clear, { hidden: true }),
  };
  return view;
}

/** @param {HTMLElement} element @param {View} view @param {HTMLElement} map */
function lay(element, { app, amount, addOff, keep, beside, list, clear, ...view }, map) {
  const { text } = app;
  const hint = h("span", { class: "quiet" }, text("compare.keepHint"));
  element.append(
    h("h2", {}, text("drawer.compare")),
    h("p", { class: "quiet" }, text("compare.intro")),
    h("div", { class: "row" }, amount.element, addOff),
    h("div", { class: "row" }, keep, hint),
    h("div", { class: "row" }, beside, h("span", { class: "quiet" }, text("compare.besideHint"))),
    list,
    clear,
    view.chartPlace,
    view.verdict,
    map,
  );
}

/** @param {View} view @param {Bag} bag */
function follow(view, bag) {
  const { store, motion } = view.app;
  const soon = later(() => showDistance(view));
  bag(soon.end);
  bag(
    store.subscribe((doc, before) => {
      if (doc.ghosts === before.ghosts && doc.pendulum === before.pendulum) return;
      showList(view);
      soon();
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      if (what === "ghosts" || what === "complete" || what === "begin") soon();
    }),
  );
  bag(() => view.group?.destroy());
  return soon;
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const bag = createBag();
  const view = createView(app);
  const { text } = app;
  const { default: mountMap } = await app.files.script("drawers/maps/map.js");
  const wish = { across: "theta1", up: "theta2", what: "flip", count: 120, duration: 10 };
  const map = mountMap(app, text("compare.map"), text("compare.mapIntro"), wish);
  lay(element, view, map.element);
  const soon = follow(view, bag);
  showList(view);
  return {
    show() {
      view.shown = true;
      soon();
      map.show();
    },
    hide() {
      view.shown = false;
    },
    destroy() {
      bag.end();
      map.destroy();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "compare", title: (text) => text("drawer.compare"), mount };
