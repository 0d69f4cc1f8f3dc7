// Modes: a card each with its frequency and a little tree that swings, starts in one or in a sum of
// them, the linear motion beside the full one, and the identity sum 1/omega^2 = l_tot/g.
// Leaves to others: the modes (the server's), a card (mode_card.js), the sum's shape (mode_sum.js),
// the curves (mode_curves.js).
// Invariant: shapes and frequencies are the server's; the thumbnails swing with the page's clock.

import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { pendulumOf, termsOf } from "../terms.js";
import { aborted, button, figure, later, settled, tick } from "./kit.js";
import { createMini } from "./mini.js";
import { createModeCard } from "./mode_card.js";
import { isLinear, openCurves } from "./mode_curves.js";
import { DEGREE, createBlend, hang, partsOf, shapeOf, sumOf, widest } from "./mode_sum.js";

const HANGING = -Math.PI / 2;
const ALL = 300; // so many arms are asked for all of their modes
const SLOWEST = 48;
const PAGE = 12;

/**
 * The drawer while it is there; tree: whose modes `blend` has; many: how many cards are shown.
 * @typedef {ReturnType<typeof partsOfDrawer> & {
 *   app: App, shown: boolean, stop: AbortController | null, tree: Tree | null,
 *   blend: import("./mode_sum.js").Blend | null, many: number, cards: {mini:
 *   import("./mini.js").Mini, k: number}[],
 *   sum: import("./mini.js").Mini | null, curves: Awaited<ReturnType<typeof openCurves>> | null,
 *   opening: ReturnType<typeof openCurves> | null, more: HTMLButtonElement, startSum:
 *   HTMLButtonElement,
 *   linear: ReturnType<typeof tick>,
 * }} View
 */

function partsOfDrawer() {
  return {
    status: h("p", { class: "quiet", role: "status" }),
    list: h("ul", { class: "mode-cards" }),
    identity: h("div", { class: "identity" }),
    sumWords: h("p", {}),
    sumPlace: h("div", { class: "sum-picture" }),
    chartPlace: h("div", { hidden: true }),
  };
}

/**
 * Starts the pendulum at rest in a shape.
 * @param {App} app @param {ArrayLike<number>} theta @param {string} label @param {string} words
 */
function begin({ store, clock, announce }, theta, label, words) {
  const phi = Array.from(theta, (angle) => HANGING + angle);
  store.set({ initial: { phi, phid: phi.map(() => 0) } }, { label });
  clock.seek(0);
  if (words) announce(words);
}

/** @param {View} view */
function beginSum({ app, blend, tree }) {
  if (blend && tree) begin(app, sumOf(blend, tree.length.length), "sum", "");
}

/** @param {Store} store @param {boolean} on */
function setLinear(store, on) {
  const { ghosts, initial } = store.get();
  const others = ghosts.filter((ghost) => !isLinear(ghost));
  const linear = { phi: initial.phi, phid: initial.phid, apart: 0, method: "linear" };
  store.set({ ghosts: on ? [...others, linear] : others }, { label: "ghosts" });
}

/** All cards anew. @param {View} view */
function build(view) {
  const { app, blend, tree, list, more, sumPlace } = view;
  if (!blend || !tree) return;
  const { text } = app;
  const all = blend.modes.omega.length;
  const count = Math.min(view.many, all);
  const changed = () => {
    sumChanged(view);
    draw(view);
  };
  const hooks = { changed, begin: begin.bind(null, app) };
  const cards = Array.from({ length: count }, (_, k) =>
    createModeCard(text, tree, blend, k, hooks),
  );
  view.cards = cards.map(({ mini }, k) => ({ mini, k }));
  list.replaceChildren(...cards.map(({ element }) => element));
  more.hidden = count === all;
  more.textContent = text("modes.more", { count: Math.min(PAGE, all - count) });
  view.sum = createMini(tree, {
    width: 150,
    height: 160,
    top: 0.06,
    label: text("modes.sumPicture"),
  });
  sumPlace.replaceChildren(view.sum.canvas);
  showIdentity(view);
  changed();
}

/** @param {View} view */
function sumChanged({ app, blend, tree, sum, startSum, sumWords }) {
  if (!blend || !tree) return;
  const { text } = app;
  const parts = partsOf(blend);
  startSum.disabled = !parts.length;
  sum?.fit(hang(widest(blend, tree.length.length)));
  const words = parts.map((k) =>
    text("modes.part", { mode: blend.modes.mode[k], angle: text.short(blend.angles[k]) }),
  );
  sumWords.textContent = parts.length ? words.join(" + ") : text("modes.sumNone");
}

/** @param {View} view */
function showIdentity({ app, blend, tree, identity }) {
  const found = blend?.modes.identity;
  identity.hidden = !found;
  if (!found || !tree) return;
  const { text } = app;
  const total = tree.length.reduce((all, one) => all + one, 0);
  const number = (/** @type {string} */ words) => h("p", { class: "number" }, words);
  const sum = figure(text, found.sum_inverse_omega_squared, 8);
  const holes = {
    length: figure(text, total, 6),
    gravity: figure(text, tree.gravity, 6),
    quotient: figure(text, found.length_total_over_g, 8),
  };
  const difference = figure(text, found.relative_difference, 2);
  identity.replaceChildren(
    h("h3", {}, text("modes.identity")),
    h("p", { class: "quiet" }, text("modes.identityText")),
    number(text("modes.identitySum", { sum })),
    number(text("modes.identityLength", holes)),
    h("p", { class: "quiet" }, text("modes.identityDifference", { difference })),
  );
}

/** @param {View} view */
function draw({ app, shown, blend, tree, cards, sum }) {
  if (!shown || !blend || !tree) return;
  const { modes, angles } = blend;
  const { time } = app.clock;
  for (const { mini, k } of cards) {
    const part = angles[k] * DEGREE;
    const pose = (/** @type {number} */ phase) => hang(shapeOf(modes, k, part * phase));
    mini.draw(pose(Math.cos(modes.omega[k] * time)), [pose(1), pose(-1)]);
  }
  const n = tree.length.length;
  sum?.draw(hang(sumOf(blend, n, time)), [hang(sumOf(blend, n))]);
}

/** Asks for the modes of the pendulum on the stage. @param {View} view */
async function load(view) {
  const { store, client, text } = view.app;
  const { pendulum } = store.get();
  if (view.tree === pendulum) return;
  view.stop?.abort();
  view.stop = new AbortController();
  view.tree = pendulum;
  const n = pendulum.length.length;
  if (!(pendulum.gravity > 0)) return refuse(view, text("modes.noGravity"));
  view.status.textContent = text("kit.waiting");
  try {
    if (Object.keys(termsOf(pendulum)).length) return await loadReal(view, pendulum);
    const select = n > ALL ? { select: { slowest: SLOWEST } } : {};
    const body = { pendulum, normalize: "max", ...select };
    const modes = await client.modes(body, { signal: view.stop.signal });
    const count = modes.omega.length;
    view.status.textContent = n > ALL ? text("modes.many", { count, all: n }) : "";
    take(view, modes);
  } catch (error) {
    if (aborted(error)) return;
    view.tree = null;
    refuse(view, said(error, text));
  }
}

/**
 * The frequencies of a real pendulum, with what friction does to them, as a table.
 * @param {View} view @param {Tree} pendulum
 */
async function loadReal(view, pendulum) {
  const { client, text } = view.app;
  const signal = view.stop?.signal;
  const modes = await client.modes({ pendulum: pendulumOf(pendulum) }, { signal });
  refuse(view, text("modes.real"));
  const names = ["frequency", "decay", "damping_ratio"];
  const head = ["modes.mode", ...names.map((name) => `modes.${name}.unit`)];
  const rows = modes.mode.map((/** @type {number} */ mode, /** @type {number} */ k) =>
    h(
      "tr",
      { "data-mode": mode },
      h("th", { scope: "row" }, String(mode)),
      ...names.map((name) => h("td", {}, figure(text, modes[name][k], 4))),
    ),
  );
  const titles = head.map((key) => h("th", { scope: "col" }, text(key)));
  view.list.replaceChildren(h("li", {}, h("table", {}, h("tr", {}, ...titles), ...rows)));
}

/**
 * Amplitudes and choices stay where there are as many modes as before.
 * @param {View} view @param {import("./mode_sum.js").Modes} modes
 */
function take(view, modes) {
  if (view.blend?.modes.omega.length === modes.omega.length) view.blend.modes = modes;
  else {
    view.blend = createBlend(modes);
    view.many = PAGE;
  }
  build(view);
}

/** @param {View} view @param {string} words */
function refuse(view, words) {
  view.blend = null;
  view.cards = [];
  view.list.replaceChildren();
  view.sumPlace.replaceChildren();
  view.identity.hidden = view.more.hidden = true;
  view.startSum.disabled = true;
  view.status.textContent = words;
}

/** @param {View} view */
function closeCurves(view) {
  view.curves?.destroy();
  view.curves = null;
}

/** The curves are there while the linear motion is. @param {View} view */
async function followLinear(view) {
  const { app, linear, chartPlace } = view;
  const on = app.store.get().ghosts.some(isLinear);
  linear.box.checked = on;
  chartPlace.hidden = !on;
  if (view.curves && (!on || view.curves.n !== app.motion.n)) closeCurves(view);
  if (!on || !view.shown) return;
  if (view.curves) return view.curves.fill();
  view.opening ??= openCurves(app, chartPlace);
  view.curves = await view.opening;
  view.opening = null;
}

/** @param {App} app @returns {View} */
function createView(app) {
  const { store, text } = app;
  const more = () => {
    view.many += PAGE;
    build(view);
  };
  const main = { class: "button main", "data-start": "sum" };
  /** @type {View} */
  const view = {
    ...partsOfDrawer(),
    app,
    shown: false,
    stop: null,
    tree: null,
    blend: null,
    many: PAGE,
    cards: [],
    sum: null,
    curves: null,
    opening: null,
    more: button("", more, { hidden: true }),
    startSum: button(text("modes.sumStart"), () => beginSum(view), main),
    linear: tick(text("modes.linear"), false, (on) => setLinear(store, on)),
  };
  view.linear.box.dataset.linear = "";
  return view;
}

/** @param {HTMLElement} element @param {View} view */
function lay(
  element,
  { app, status, list, more, sumPlace, sumWords, startSum, linear, chartPlace, identity },
) {
  const { text } = app;
  const start = h("div", {}, sumWords, h("div", { class: "row" }, startSum));
  element.append(
    h("h2", {}, text("drawer.modes")),
    h("p", { class: "quiet" }, text("modes.intro")),
    status,
    list,
    more,
    h("h3", {}, text("modes.sum")),
    h("div", { class: "sum" }, sumPlace, start),
    h("div", { class: "row" }, linear.element),
    chartPlace,
    identity,
  );
}

/** @param {View} view @param {Bag} bag */
function follow(view, bag) {
  const { clock, store, motion, theme } = view.app;
  const soon = later(() => draw(view));
  const loadSoon = settled(() => load(view), 120);
  const linearSoon = later(() => followLinear(view));
  for (const one of [soon, loadSoon, linearSoon]) bag(one.end);
  bag(clock.subscribe(soon));
  bag(
    store.subscribe((doc, before) => {
      if (!view.shown) return;
      if (doc.pendulum !== before.pendulum) loadSoon();
      if (doc.ghosts !== before.ghosts) linearSoon();
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      if (view.shown && (what === "ghosts" || what === "complete")) linearSoon();
    }),
  );
  bag(
    theme.subscribe(() => {
      for (const { mini } of view.cards) mini.recolour();
      view.sum?.recolour();
      closeCurves(view);
      linearSoon();
      soon();
    }),
  );
  bag(() => view.stop?.abort());
  bag(() => closeCurves(view));
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const bag = createBag();
  const view = createView(app);
  lay(element, view);
  follow(view, bag);
  return {
    show() {
      view.shown = true;
      load(view);
      followLinear(view);
      draw(view);
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
export default { id: "modes", title: (text) => text("drawer.modes"), mount };
