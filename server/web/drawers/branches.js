// Branches of nonlinear modes: the frequency of each mode over how far or with how much energy it
// swings, where it is stable, where others branch off; a chosen orbit is set in motion.
// Leaves to others: the modes (modes.js), the plot (plot.js), a long computation (job.js).
// Invariant: every orbit is the server's, closed to round-off; between two of them nothing is set
// in motion.

import { DEGREE } from "../angles.js";
import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { pendulumOf } from "../terms.js";
import { computed } from "./job.js";
import { aborted, button, choice, figure, settled } from "./kit.js";
import { createPlot } from "./plot.js";

const MOST = 6; // modes that are followed
const FAR = 120; // degrees, up to which they are at first
const ALONG = ["amplitude", "energy"];

/**
 * An orbit of a branch: where it begins, at rest. amplitude, degrees: of the arm that swings most.
 * @typedef {{phi: number[], amplitude: number, energy: number, period: number, stable: boolean}}
 * Orbit
 */

/** @typedef {{mode: number, orbits: Orbit[], special: {kind: string, after: number}[]}} Branch */

/**
 * The part while it is there; far: up to how many degrees; mode, at: which orbit is chosen.
 * @typedef {{
 *   app: App, plot: ReturnType<typeof createPlot>, branches: Branch[], along: string, far: number,
 *   mode: number, at: number, stop: AbortController | null, parts: ReturnType<typeof partsOf>,
 * }} View
 */

/** @param {Text} text */
const partsOf = (text) => ({
  status: h("p", { class: "quiet", role: "status", "data-branches": "status" }),
  bar: h("progress", { max: 1, hidden: true, "aria-label": text("branches.running") }),
  names: h("p", { class: "plot-names" }),
  picks: h("div", { class: "fit-options" }),
  orbit: h("p", { "data-branches": "orbit" }),
  special: h("ul", { class: "fit-said" }),
});

/** @param {number} mode */
const colourOf = (mode) => `--arm-${((mode - 1) % 8) + 1}`;

/** What an answer says. @param {number} mode @param {any} answer @returns {Branch} */
function branchOf(mode, answer) {
  const orbits = answer.period.map((/** @type {number} */ period, /** @type {number} */ i) => ({
    phi: answer.phi[i],
    amplitude: Math.max(...answer.amplitude[i]) / DEGREE,
    energy: answer.energy[i],
    period,
    stable: answer.stable[i] === 1,
  }));
  return { mode, orbits, special: answer.bifurcations };
}

/** Where an orbit is on the plot. @param {View} view @param {Orbit} orbit */
const across = ({ along }, { amplitude, energy }) => (along === "energy" ? energy : amplitude);

/**
 * A branch as lines: whole where it is stable, broken where it is not, which meet.
 * @param {View} view @param {Branch} branch @returns {import("./plot.js").Curve[]}
 */
function curvesOf(view, { mode, orbits, special }) {
  const xs = orbits.map((one) => across(view, one));
  const colour = colourOf(mode);
  const line = (/** @type {boolean} */ stable) => {
    const seen = (/** @type {number} */ i) => orbits[i] && orbits[i].stable === stable;
    // the piece between two kinds is drawn as unstable
    const ys = orbits.map(({ period }, i) =>
      seen(i) || (!stable && (seen(i - 1) || seen(i + 1))) ? 1 / period : null,
    );
    return { xs, ys, colour, dashed: !stable };
  };
  const spots = special.map(({ after }) => Math.min(after, orbits.length) - 1);
  const dots = {
    xs: spots.map((i) => xs[i]),
    ys: spots.map((i) => 1 / orbits[i].period),
    ...{ colour, dots: 3.4 },
  };
  return [line(true), line(false), ...(spots.length ? [dots] : [])];
}

/** @param {View} view */
const chosen = ({ branches, mode, at }) =>
  branches.find((one) => one.mode === mode)?.orbits[at] ?? null;

/** @param {View} view */
function draw(view) {
  const { app, plot, branches, along } = view;
  const { text } = app;
  const orbit = chosen(view);
  const curves = branches.flatMap((branch) => curvesOf(view, branch));
  if (orbit)
    curves.push({ xs: [across(view, orbit)], ys: [1 / orbit.period], colour: "--ink", dots: 5 });
  plot.set({ x: text(`branches.${along}.axis`), y: "Hz", curves }, text("branches.plot"));
}

/** The orbit that is chosen, in words. @param {View} view */
function showOrbit(view) {
  const { app, parts } = view;
  const { text } = app;
  const orbit = chosen(view);
  const holes = orbit && {
    angle: text.number(orbit.amplitude, 1),
    energy: figure(text, orbit.energy, 4),
    frequency: figure(text, 1 / orbit.period, 5),
    period: figure(text, orbit.period, 5),
  };
  const key = orbit?.stable ? "branches.stable" : "branches.unstable";
  parts.orbit.textContent = holes ? text(key, holes) : "";
}

/** What branches off, a sentence each. @param {View} view */
function showSpecial({ app, branches, parts }) {
  const { text } = app;
  const lines = branches.flatMap(({ mode, orbits, special }) =>
    special.map(({ kind, after }) => {
      const { amplitude } = orbits[Math.min(after, orbits.length) - 1];
      const angle = text.number(amplitude, 0);
      return h("li", {}, text(`branches.${kind}`, { mode, angle }));
    }),
  );
  parts.special.replaceChildren(...lines);
}

/** Sets the orbit in motion that is chosen. @param {View} view */
function begin(view) {
  const { store, clock, text, announce } = view.app;
  const orbit = chosen(view);
  if (!orbit) return;
  store.set({ initial: { phi: orbit.phi, phid: orbit.phi.map(() => 0) } }, { label: "mode" });
  clock.seek(0);
  clock.play();
  announce(text("branches.moving", { mode: view.mode }));
}

/** @param {View} view @param {number} mode @param {number} at */
function choose(view, mode, at) {
  Object.assign(view, { mode, at });
  showPicks(view);
  draw(view);
}

/** Which orbit, by keys: a mode, and how far along its branch. @param {View} view */
function showPicks(view) {
  const { app, branches, parts, mode, at, along } = view;
  const { text } = app;
  const branch = branches.find((one) => one.mode === mode);
  showOrbit(view);
  const modes = branches.map((one) => ({
    value: one.mode,
    words: text("modes.title", { mode: one.mode }),
  }));
  const pick = choice(text("modes.mode"), modes, mode, (value) => {
    const next = branches.find((one) => one.mode === Number(value));
    choose(view, Number(value), Math.floor((next?.orbits.length ?? 1) / 2));
    parts.picks.querySelector("select")?.focus();
  });
  pick.select.dataset.branches = "mode";
  const max = Math.max(0, (branch?.orbits.length ?? 1) - 1);
  const input = () => {
    view.at = Number(slider.value);
    showOrbit(view);
    slider.setAttribute("aria-valuetext", parts.orbit.textContent ?? "");
    draw(view);
  };
  const label = { "aria-label": text("branches.along"), "data-branches": "orbit" };
  const slider = h("input", { type: "range", min: 0, max, value: at, ...label, on: { input } });
  slider.setAttribute("aria-valuetext", parts.orbit.textContent ?? "");
  const start = button(text("branches.begin"), () => begin(view), {
    ...{ class: "button main", "data-branches": "begin" },
  });
  const kinds = ALONG.map((value) => ({ value, words: text(`branches.${value}`) }));
  const over = choice(text("branches.over"), kinds, along, (value) => {
    view.along = value;
    draw(view);
  });
  over.select.dataset.branches = "over";
  parts.picks.replaceChildren(over.element, pick.element, slider, start);
}

/** @param {View} view */
function showNames({ app, branches, parts }) {
  const names = branches.map(({ mode }) => {
    const line = h("span", { class: "stroke" });
    line.style.setProperty("--colour", `var(${colourOf(mode)})`);
    return h("span", {}, line, " ", app.text("modes.title", { mode }));
  });
  parts.names.replaceChildren(...names);
}

/** Follows the slowest modes, one after the other. @param {View} view */
async function load(view) {
  const { app, parts, far } = view;
  const { store, client, text } = app;
  view.stop?.abort();
  const stop = new AbortController();
  Object.assign(view, { stop, branches: [], mode: 1, at: 0 });
  const tree = store.get().pendulum;
  const pendulum = pendulumOf(tree);
  const count = Math.min(MOST, tree.length.length);
  parts.bar.hidden = false;
  parts.status.textContent = text("branches.running");
  try {
    for (let mode = 1; mode <= count; mode++) {
      const body = { pendulum, mode, amplitude: far, unit: "deg", branch: true };
      const answer = await computed(client, "/v1/orbits", body, stop.signal, (share) => {
        parts.bar.value = (mode - 1 + share) / count;
      });
      parts.bar.value = mode / count;
      if (answer.period.length) view.branches.push(branchOf(mode, answer));
      if (mode === 1) view.at = Math.floor(answer.period.length / 2);
      showNames(view);
      showSpecial(view);
      choose(view, view.mode, view.at);
    }
    parts.status.textContent = text("branches.hint");
  } catch (error) {
    if (!aborted(error)) parts.status.textContent = said(error, text);
  } finally {
    if (view.stop === stop) parts.bar.hidden = true;
  }
}

/** How far the branches are followed. @param {View} view */
function farOf(view) {
  const { text } = view.app;
  const change = () => {
    const typed = text.read(input.value);
    if (typed > 0) view.far = Math.min(typed, 720);
    input.value = text.short(view.far);
    load(view);
  };
  const label = text("branches.far");
  const input = h("input", {
    ...{ type: "text", inputmode: "decimal", "aria-label": label, "data-branches": "far" },
    ...{ value: text.short(view.far), on: { change } },
  });
  const field = h("span", { class: "with-unit" }, input, h("span", { class: "unit" }, "\u00b0"));
  return h("label", { class: "choice" }, h("span", {}, label), field);
}

/** A click on the plot chooses the orbit that is nearest, and sets it in motion. @param {View} view
 * @param {PointerEvent} event */
function clicked(view, event) {
  const { branches, plot } = view;
  let least = Infinity;
  let found = [0, 0];
  for (const { mode, orbits } of branches)
    orbits.forEach((orbit, at) => {
      const far = plot.far(across(view, orbit), 1 / orbit.period, event);
      if (far < least) [least, found] = [far, [mode, at]];
    });
  if (!(least < 30)) return;
  choose(view, found[0], found[1]);
  begin(view);
}

/** The part of the drawer Modes, which is loaded when it is opened. @param {App} app */
export default async function mountBranches(app) {
  const { store, text, files } = app;
  await Promise.all([text.part("branches"), files.style("drawers/curves.css")]);
  const bag = createBag();
  const plot = createPlot(text, 240);
  /** @type {View} */
  const view = {
    ...{ app, plot, branches: [], along: "amplitude", far: FAR, mode: 1, at: 0, stop: null },
    parts: partsOf(text),
  };
  const { status, bar, names, picks, orbit, special } = view.parts;
  const soon = settled(() => load(view), 300);
  bag(soon.end);
  bag(store.subscribe((doc, before) => doc.pendulum !== before.pendulum && soon()));
  bag(() => view.stop?.abort());
  bag(plot.destroy);
  bag.on(plot.element, "click", (event) => clicked(view, /** @type {PointerEvent} */ (event)));
  plot.element.classList.add("pickable");
  const element = h("div", { class: "branches" });
  element.append(h("p", { class: "quiet" }, text("branches.intro")), farOf(view), status, bar);
  element.append(plot.element, names, orbit, picks, special);
  load(view);
  return { element, destroy: bag.end };
}
