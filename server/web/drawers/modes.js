// Modes: a card each with its frequency and a little tree that swings, starts in one or in a sum of
// them, the linear motion beside the full one, and the identity sum 1/omega^2 = l_tot/g.
// Leaves to others: the modes (the server's), a card (mode_card.js), the sum's shape (mode_sum.js),
// the curves (mode_curves.js).
// Invariant: shapes and frequencies are the server's; the thumbnails swing with the page's clock.

import { foldedTheta } from "../angles.js";
import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { still } from "../screen.js";
import { pendulumOf, smoothOf, termsOf } from "../terms.js";
import { aborted, button, figure, later, settled, tick } from "./kit/kit.js";
import { lazyPart } from "./kit/lazy.js";
import { createMini } from "./kit/mini.js";
import { createModeCard, topOf } from "./modes/mode_card.js";
import { isLinear, openCurves } from "./modes/mode_curves.js";
import * as sums from "./modes/mode_sum.js";

const ALL = 300; // so many arms are asked for all of their modes
const SLOWEST = 48;
const PAGE = 12;
const SAID = 8; // angles of the rest
const LITTLE = 1e-6; // 1/s: a growth that is none

/**
 * The drawer while it is there; tree: whose modes `blend` has; many: how many cards are shown.
 * @typedef {ReturnType<typeof partsOfDrawer> & {
 *   app: App, shown: boolean, stop: AbortController | null, tree: Tree | null,
 *   blend: import("./modes/mode_sum.js").Blend | null, many: number, cards: {mini:
 *   import("./kit/mini.js").Mini, k: number}[],
 *   sum: import("./kit/mini.js").Mini | null,
 *   curves: ReturnType<typeof openCurves> | null, more: HTMLButtonElement, startSum:
 *   HTMLButtonElement,
 *   linear: ReturnType<typeof tick>, near: ReturnType<typeof tick>,
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
 * Starts the pendulum in some modes; one that loses nothing at rest.
 * @param {View} view @param {number[]} parts modes, from 0 @param {string} label
 * @param {string} words
 */
function begin({ app, blend }, parts, label, words) {
  const { store, clock, announce } = app;
  if (!blend) return;
  store.set({ initial: sums.startOf(blend, parts) }, { label });
  clock.seek(0);
  if (!still.matches) clock.play();
  if (words) announce(words);
}

/** @param {View} view */
function beginSum(view) {
  if (view.blend) begin(view, sums.partsOf(view.blend), "sum", "");
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
  const hooks = { changed, begin: begin.bind(null, view) };
  const cards = Array.from({ length: count }, (_, k) =>
    createModeCard(text, tree, blend, k, hooks),
  );
  view.cards = cards.map(({ mini }, k) => ({ mini, k }));
  list.replaceChildren(...cards.map(({ element }) => element));
  more.hidden = count === all;
  more.textContent = text("modes.more", { count: Math.min(PAGE, all - count) });
  view.near.element.hidden = !blend.modes.real;
  view.linear.element.hidden = blend.modes.real;
  view.sum = createMini(tree, {
    width: 150,
    height: 160,
    top: topOf(blend.modes),
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
  const parts = sums.partsOf(blend);
  startSum.disabled = !parts.length;
  sum?.fit(sums.posed(blend.modes, sums.widest(blend, tree.length.length)));
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
    const part = angles[k] * sums.DEGREE;
    const pose = (/** @type {number} */ far, at = 0) =>
      sums.posed(modes, sums.shapeOf(modes, k, part * far, at));
    mini.draw(pose(1, time), [pose(1), pose(-1)]);
  }
  const n = tree.length.length;
  const all = (/** @type {number} */ at) => sums.posed(modes, sums.sumOf(blend, n, at));
  sum?.draw(all(time), [all(0)]);
}

/**
 * Asks for the modes of the pendulum on the stage; chosen: about which rest, is.
 * @param {View} view
 */
async function load(view, chosen = false) {
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
    if (Object.keys(termsOf(pendulum)).length) return await loadReal(view, pendulum, chosen);
    const select = n > ALL ? { select: { slowest: SLOWEST } } : {};
    const body = { pendulum, normalize: "max", ...select };
    const modes = await client.modes(body, { signal: view.stop.signal });
    const count = modes.omega.length;
    view.status.textContent = n > ALL ? text("modes.many", { count, all: n }) : "";
    take(view, sums.modesOf(modes, n));
  } catch (error) {
    if (aborted(error)) return;
    view.tree = null;
    refuse(view, said(error, text));
  }
}

/**
 * The modes of a real pendulum about its rest: which one, is told. Where it does not stay hanging
 * (a metronome) they are about the one that is nearest to its start, until another is chosen.
 * @param {View} view @param {Tree} pendulum @param {boolean} chosen
 */
async function loadReal(view, pendulum, chosen) {
  const { client, text, store } = view.app;
  const signal = view.stop?.signal;
  const body = { pendulum: pendulumOf(smoothOf(pendulum)) };
  const near = { ...body, initial: { phi: store.get().initial.phi } };
  let answer = await client.modes(view.near.box.checked ? near : body, { signal });
  const grows = answer.decay.some((/** @type {number} */ rate) => rate < -LITTLE);
  if (grows && !chosen && !view.near.box.checked) {
    view.near.box.checked = true;
    answer = await client.modes(near, { signal });
  }
  const angles = answer.equilibrium.map((/** @type {number} */ phi) =>
    text("degrees", { angle: text.number(foldedTheta(phi), 1) }),
  );
  const list = new Intl.ListFormat(text.language).format(angles.slice(0, SAID));
  const more = angles.length > SAID ? " \u2026" : "";
  view.status.textContent = `${text("modes.real")} ${text("modes.rest", { list: list + more })}`;
  take(view, sums.modesOf(answer, pendulum.length.length));
}

/**
 * Amplitudes and choices stay where there are as many modes as before.
 * @param {View} view @param {import("./modes/mode_sum.js").Modes} modes
 */
function take(view, modes) {
  if (view.blend?.modes.omega.length === modes.omega.length) view.blend.modes = modes;
  else {
    view.blend = sums.createBlend(modes);
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
function followLinear(view) {
  const { app, linear, chartPlace } = view;
  const on = app.store.get().ghosts.some(isLinear);
  linear.box.checked = on;
  chartPlace.hidden = !on;
  if (view.curves && (!on || view.curves.n !== app.motion.n)) closeCurves(view);
  if (!on || !view.shown) return;
  if (view.curves) view.curves.fill();
  else view.curves = openCurves(app, chartPlace);
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
    more: button("", more, { hidden: true }),
    startSum: button(text("modes.sumStart"), () => beginSum(view), main),
    linear: tick(text("modes.linear"), false, (on) => setLinear(store, on)),
    near: tick(text("modes.near"), false, () => {
      view.tree = null;
      load(view, true);
    }),
  };
  view.linear.box.dataset.linear = "";
  view.near.box.dataset.near = "";
  return view;
}

/** @param {HTMLElement} element @param {View} view */
function lay(
  element,
  { app, status, near, list, more, sumPlace, sumWords, startSum, linear, chartPlace, identity },
) {
  const { text } = app;
  const start = h("div", {}, sumWords, h("div", { class: "row" }, startSum));
  element.append(
    h("h2", {}, text("drawer.modes")),
    h("p", { class: "quiet" }, text("modes.intro")),
    status,
    h("div", {}, near.element),
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
  for (const name of ["branches", "resonance"]) {
    const part = lazyPart(app, `modes/${name}`, app.text(`modes.${name}`), true);
    element.append(part.element);
    bag(part.destroy);
  }
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
