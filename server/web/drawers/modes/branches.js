// Branches of nonlinear modes: the frequency of each mode over how far or with how much energy it
// swings, where it is stable, where others branch off; of a driven pendulum how far it swings over
// the frequency of its drive, round the folds. A chosen orbit is set in motion.
// Leaves to others: the modes (modes.js), the plot (plot.js), a long computation (job.js).
// Invariant: every orbit is the server's, closed to round-off; between two of them nothing is set
// in motion.

import { DEGREE } from "../../angles.js";
import { said } from "../../client.js";
import { createBag, h } from "../../dom.js";
import { pendulumOf } from "../../terms.js";
import { computed } from "../kit/job.js";
import { aborted, button, choice, figure, settled } from "../kit/kit.js";
import { createPlot } from "../kit/plot.js";

const MOST = 6; // modes that are followed
const FAR = 120; // degrees, up to which they are at first
const ALONG = ["amplitude", "energy"];
const SETTLE = 50; // periods of the drive, after which an orbit is looked for

/**
 * An orbit of a branch: where it begins. amplitude, degrees: of the arm that swings most; energy of
 * what nothing drives, drive (rad/s) of what is driven.
 * @typedef {{phi: number[], phid: number[], amplitude: number, energy: number, drive: number,
 *   period: number, stable: boolean}} Orbit
 */

/** @typedef {{mode: number, orbits: Orbit[], special: {kind: string, after: number}[]}} Branch */

/**
 * The part while it is there; far: up to how many degrees; mode, at: which orbit is chosen; omega:
 * the frequency of the drive, 0 = nothing drives it; own: the pendulum that an orbit has set.
 * @typedef {{
 *   app: App, plot: ReturnType<typeof createPlot>, branches: Branch[], along: string, far: number,
 *   omega: number, own: Tree | null, mode: number, at: number, stop: AbortController | null,
 *   parts: ReturnType<typeof partsOf>,
 * }} View
 */

/** @param {Text} text */
const partsOf = (text) => ({
  intro: h("p", { class: "quiet" }),
  far: h("div"),
  status: h("p", { class: "quiet", role: "status", "data-branches": "status" }),
  bar: h("progress", { max: 1, hidden: true, "aria-label": text("branches.running") }),
  names: h("p", { class: "plot-names" }),
  picks: h("div", { class: "fit-options" }),
  orbit: h("p", { "data-branches": "orbit" }),
  special: h("ul", { class: "fit-said" }),
});

/** @param {number} mode */
const colourOf = (mode) => `--arm-${((mode - 1) % 8) + 1}`;

/** The harmonics of all drives. @param {Tree} tree @returns {{omega: number}[]} */
function wavesOf({ torque, pivot }) {
  /** @type {any[]} */
  const drives = [...(torque ?? []), pivot?.x, pivot?.y, pivot?.cart?.force];
  return drives.flatMap((one) => one?.harmonics ?? []);
}

/** The frequency that all drives have in common, rad/s; 0 = there are none. @param {Tree} tree */
function driveOf(tree) {
  const omegas = wavesOf(tree).map(({ omega }) => Math.abs(omega));
  const common = (/** @type {number} */ a, /** @type {number} */ b) => {
    for (const little = 1e-6 * Math.max(a, b); b > little; ) [a, b] = [b, a % b];
    return a;
  };
  return omegas.reduce(common, 0);
}

/** What an answer says. @param {number} mode @param {any} answer @returns {Branch} */
function branchOf(mode, answer) {
  const orbits = answer.period.map((/** @type {number} */ period, /** @type {number} */ i) => ({
    phi: answer.phi[i],
    phid: answer.phid[i],
    amplitude: Math.max(...answer.amplitude[i]) / DEGREE,
    energy: answer.energy?.[i] ?? 0,
    drive: answer.omega?.[i] ?? 0,
    period,
    stable: answer.stable[i] === 1,
  }));
  return { mode, orbits, special: answer.bifurcations };
}

/**
 * One branch of two that begin at the same orbit, the first of them backwards.
 * @param {Branch} down @param {Branch} up @returns {Branch}
 */
function joined(down, up) {
  const skip = Math.max(0, down.orbits.length - 1);
  const orbits = [...down.orbits.slice(1).reverse(), ...up.orbits];
  const back = down.special.map(({ kind, after }) => ({ kind, after: skip + 1 - after }));
  const on = up.special.map(({ kind, after }) => ({ kind, after: skip + after }));
  return { mode: 1, orbits, special: [...back.reverse(), ...on] };
}

/** Where an orbit is on the plot. @param {View} view @param {Orbit} orbit */
function across({ along, omega }, { amplitude, energy, drive }) {
  if (omega) return drive / (2 * Math.PI);
  return along === "energy" ? energy : amplitude;
}

/** @param {View} view @param {Orbit} orbit */
const upwards = ({ omega }, { amplitude, period }) => (omega ? amplitude : 1 / period);

/**
 * A branch as lines: whole where it is stable, broken where it is not, which meet.
 * @param {View} view @param {Branch} branch @returns {import("../kit/plot.js").Curve[]}
 */
function curvesOf(view, { mode, orbits, special }) {
  const xs = orbits.map((one) => across(view, one));
  const colour = colourOf(mode);
  const line = (/** @type {boolean} */ stable) => {
    const seen = (/** @type {number} */ i) => orbits[i] && orbits[i].stable === stable;
    // the piece between two kinds is drawn as unstable
    const ys = orbits.map((one, i) =>
      seen(i) || (!stable && (seen(i - 1) || seen(i + 1))) ? upwards(view, one) : null,
    );
    return { xs, ys, colour, dash: stable ? null : [5, 4] };
  };
  const spots = special.map(({ after }) => Math.min(after, orbits.length) - 1);
  const dots = {
    xs: spots.map((i) => xs[i]),
    ys: spots.map((i) => upwards(view, orbits[i])),
    ...{ colour, dots: 3.4 },
  };
  return [line(true), line(false), ...(spots.length ? [dots] : [])];
}

/** @param {View} view */
const chosen = ({ branches, mode, at }) =>
  branches.find((one) => one.mode === mode)?.orbits[at] ?? null;

/** @param {View} view */
function draw(view) {
  const { app, plot, branches, along, omega } = view;
  const { text } = app;
  const orbit = chosen(view);
  const curves = branches.flatMap((branch) => curvesOf(view, branch));
  const spot = orbit && { xs: [across(view, orbit)], ys: [upwards(view, orbit)] };
  if (spot) curves.push({ ...spot, colour: "--ink", dots: 5 });
  const words = omega
    ? { x: text("branches.driven.axis"), y: text("branches.driven.swing"), low: 0 }
    : { x: text(`branches.${along}.axis`), y: "Hz" };
  plot.set({ ...words, curves }, text(omega ? "branches.driven.name" : "branches.plot"));
}

/** The orbit that is chosen, in words. @param {View} view */
function showOrbit(view) {
  const { app, parts } = view;
  const { text } = app;
  const orbit = chosen(view);
  const holes = orbit && {
    angle: text.number(orbit.amplitude, 1),
    energy: figure(text, orbit.energy, 4),
    frequency: figure(text, view.omega ? across(view, orbit) : 1 / orbit.period, 5),
    period: figure(text, orbit.period, 5),
  };
  const key = `branches.${view.omega ? "driven." : ""}${orbit?.stable ? "stable" : "unstable"}`;
  parts.orbit.textContent = holes ? text(key, holes) : "";
}

/** What branches off, a sentence each. @param {View} view */
function showSpecial(view) {
  const { app, branches, parts, omega } = view;
  const { text } = app;
  const lines = branches.flatMap(({ mode, orbits, special }) =>
    special.map(({ kind, after }) => {
      const orbit = orbits[Math.max(0, Math.min(after, orbits.length) - 1)];
      const angle = text.number(orbit.amplitude, 0);
      if (!omega) return h("li", {}, text(`branches.${kind}`, { mode, angle }));
      const frequency = figure(text, across(view, orbit), 4);
      return h("li", {}, text(`branches.driven.${kind}`, { frequency, angle }));
    }),
  );
  parts.special.replaceChildren(...lines);
}

/** Sets the orbit in motion that is chosen, a driven one under its own drive. @param {View} view */
function begin(view) {
  const { store, clock, text, announce } = view.app;
  const orbit = chosen(view);
  if (!orbit) return;
  const initial = { phi: orbit.phi, phid: orbit.phid };
  if (view.omega) {
    const pendulum = structuredClone(store.get().pendulum);
    const factor = orbit.drive / driveOf(pendulum);
    for (const wave of wavesOf(pendulum)) wave.omega *= factor;
    view.own = pendulum;
    store.set({ pendulum, initial }, { label: "mode" });
  } else store.set({ initial }, { label: "mode" });
  clock.seek(0);
  clock.play();
  const words = text("branches.moving", { mode: view.mode });
  announce(view.omega ? (view.parts.orbit.textContent ?? "") : words);
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
  const which = view.omega ? [] : [over.element, pick.element];
  parts.picks.replaceChildren(...which, slider, start);
}

/** @param {View} view */
function showNames({ app, branches, parts, omega }) {
  const names = branches.map(({ mode }) => {
    const line = h("span", { class: "stroke" });
    line.style.setProperty("--colour", `var(${colourOf(mode)})`);
    const words = omega ? app.text("branches.driven.name") : app.text("modes.title", { mode });
    return h("span", {}, line, " ", words);
  });
  parts.names.replaceChildren(...names);
}

/** What has been found. @param {View} view */
function show(view) {
  showNames(view);
  showSpecial(view);
  choose(view, view.mode, view.at);
}

/** Follows the slowest modes, one after the other. @param {View} view @param {Tree} tree
 * @param {AbortSignal} signal */
async function loadModes(view, tree, signal) {
  const { app, parts, far } = view;
  const count = Math.min(MOST, tree.length.length);
  const pendulum = pendulumOf(tree);
  for (let mode = 1; mode <= count; mode++) {
    const body = { pendulum, mode, amplitude: far, unit: "deg", branch: true };
    const answer = await computed(app.client, "/v1/orbits", body, signal, (share) => {
      parts.bar.value = (mode - 1 + share) / count;
    });
    parts.bar.value = mode / count;
    if (answer.period.length) view.branches.push(branchOf(mode, answer));
    if (mode === 1) view.at = Math.floor(answer.period.length / 2);
    show(view);
  }
  return "branches.hint";
}

/** Follows the orbit of a driven pendulum to half and to twice the frequency of its drive.
 * @param {View} view @param {Tree} tree @param {AbortSignal} signal */
async function loadDriven(view, tree, signal) {
  const { app, parts, omega } = view;
  /** @type {Branch[]} */
  const halves = [];
  for (const to of [omega / 2, omega * 2]) {
    const branch = { vary: "omega", to };
    const body = { pendulum: pendulumOf(tree), settle: SETTLE, branch };
    const answer = await computed(app.client, "/v1/orbits", body, signal, (share) => {
      parts.bar.value = (halves.length + share) / 2;
    });
    halves.push(branchOf(1, answer));
  }
  const branch = joined(halves[0], halves[1]);
  if (!branch.orbits.length) return "branches.driven.none";
  view.branches.push(branch);
  view.at = Math.max(0, halves[0].orbits.length - 1);
  show(view);
  return "branches.hint";
}

/** Follows what there is to follow. @param {View} view */
async function load(view) {
  const { app, parts } = view;
  const { store, text } = app;
  view.stop?.abort();
  const stop = new AbortController();
  const tree = store.get().pendulum;
  const omega = driveOf(tree);
  Object.assign(view, { stop, omega, branches: [], mode: 1, at: 0 });
  parts.far.style.display = omega ? "none" : "";
  parts.intro.textContent = text(omega ? "branches.driven.intro" : "branches.intro");
  parts.bar.hidden = false;
  parts.status.textContent = text("branches.running");
  try {
    const follow = omega ? loadDriven : loadModes;
    parts.status.textContent = text(await follow(view, tree, stop.signal));
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
  const measure = plot.far(event);
  let least = Infinity;
  let found = [0, 0];
  for (const { mode, orbits } of branches)
    orbits.forEach((orbit, at) => {
      const far = measure(across(view, orbit), upwards(view, orbit));
      if (far < least) [least, found] = [far, [mode, at]];
    });
  if (!(least < 30)) return;
  choose(view, found[0], found[1]);
  begin(view);
}

/** The part of the drawer Modes, which is loaded when it is opened. @param {App} app */
export default async function mountBranches(app) {
  const { store, text, files } = app;
  await Promise.all([text.part("branches"), files.style("drawers/kit/curves.css")]);
  const bag = createBag();
  const plot = createPlot(text, 240);
  /** @type {View} */
  const view = {
    ...{ app, plot, branches: [], along: "amplitude", far: FAR, mode: 1, at: 0, stop: null },
    ...{ omega: 0, own: null },
    parts: partsOf(text),
  };
  const { intro, far, status, bar, names, picks, orbit, special } = view.parts;
  const soon = settled(() => load(view), 300);
  bag(soon.end);
  bag(
    store.subscribe(({ pendulum }, before) => {
      // an orbit's own drive does not change the branch that it is on
      if (pendulum !== before.pendulum && pendulum !== view.own) soon();
    }),
  );
  bag(() => view.stop?.abort());
  bag(plot.destroy);
  bag.on(plot.element, "click", (event) => clicked(view, /** @type {PointerEvent} */ (event)));
  plot.element.classList.add("pickable");
  const element = h("div", { class: "branches" });
  far.append(farOf(view));
  element.append(intro, far, status, bar);
  element.append(plot.element, names, orbit, picks, special);
  load(view);
  return { element, destroy: bag.end };
}
