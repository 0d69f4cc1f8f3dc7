// The route to chaos of a driven pendulum: once in every period of the drive an arm is looked at,
// over the strength of the drive, after it has settled. One point is a swing with the drive, two
// are one of twice its period, a cloud is chaos.
// Leaves to others: the motions (the server's ensembles), the plot (plot.js), the sliders of drives
// (physics.js).
// Invariant: every point is an instant of a motion that the server computed.

import { foldedTheta } from "../../angles.js";
import { said } from "../../client.js";
import { createBag, h } from "../../dom.js";
import { pendulumOf, termOf } from "../../terms.js";
import { computed } from "../kit/job.js";
import { aborted, choice, settled } from "../kit/kit.js";
import { createPlot } from "../kit/plot.js";

const STRENGTHS = 180;
const SETTLE = 80; // periods
const LOOKS = 36;
const RANGE = [0.78, 1.13]; // of the drive's own strength
const DOT = 0.7; // pixels

/** A drive that has a strength: its name among axes, its arm. @typedef {{
 *   vary: string, arm?: number, wave: Harmonic, unit: string,
 * }} Drive */

/**
 * The part while it is there.
 * @typedef {{
 *   app: App, plot: ReturnType<typeof createPlot>, drive: Drive | null, arm: number, ends:
 *   number[], stop: AbortController | null, picks: HTMLElement, status: HTMLElement,
 *   bar: HTMLProgressElement,
 * }} View
 */

/** What drives a pendulum to and fro. @param {Tree} tree @returns {Drive[]} */
function drivesOf(tree) {
  const motors = tree.length.flatMap((_, k) => {
    const torque = termOf(tree, "torque", k);
    const wave = typeof torque === "object" ? torque?.harmonics?.[0] : null;
    return wave ? [{ vary: "torque_amplitude", arm: k + 1, wave, unit: "N\u00b7m" }] : [];
  });
  const shakes = /** @type {("x" | "y")[]} */ (["x", "y"]).flatMap((axis) => {
    const wave = tree.pivot?.[axis]?.harmonics?.[0];
    return wave ? [{ vary: `pivot_${axis}_amplitude`, wave, unit: "m" }] : [];
  });
  return [...motors, ...shakes].filter(({ wave }) => wave.omega > 0 && wave.amplitude);
}

/** The same pendulum, driven so strongly. @param {Tree} tree @param {Drive} drive
 * @param {number} amplitude @returns {Tree} */
function driven(tree, { vary, arm }, amplitude) {
  const anew = (/** @type {Harmonic[]} */ [first, ...others]) => [
    { ...first, amplitude },
    ...others,
  ];
  if (arm) {
    const torque = (tree.torque ?? []).map((one, k) =>
      k === arm - 1 && typeof one === "object" && one?.harmonics
        ? { ...one, harmonics: anew(one.harmonics) }
        : one,
    );
    return { ...tree, torque };
  }
  const axis = vary === "pivot_x_amplitude" ? "x" : "y";
  const { pivot } = tree;
  return {
    ...tree,
    pivot: { ...pivot, [axis]: { harmonics: anew(pivot?.[axis]?.harmonics ?? []) } },
  };
}

/** @param {View} view @param {Drive} drive */
function bodyOf({ app, ends }, { vary, arm, wave }) {
  const { pendulum, initial } = app.store.get();
  const period = (2 * Math.PI) / wave.omega;
  const [start, stop] = ends;
  const { phi, phid } = initial;
  return {
    pendulum: pendulumOf(pendulum),
    initial: { phi, phid },
    grid: [{ vary, ...(arm && { arm }), start, stop, count: STRENGTHS }],
    // motions begin at the first of these
    times: [0, ...Array.from({ length: LOOKS }, (_, i) => (SETTLE + i) * period)],
    observables: ["trajectory"],
    output: ["phi"],
  };
}

/**
 * Angles that are mostly near upright lie around it, not at both ends.
 * @param {(number | null)[]} ys
 */
function together(ys) {
  const far = ys.filter((one) => one !== null && Math.abs(one) > 90).length;
  const up = far > ys.length / 2;
  return up ? ys.map((one) => (one !== null && one < 0 ? one + 360 : one)) : ys;
}

/** @param {View} view */
async function load(view) {
  const { app, plot, drive, arm, ends, bar, status } = view;
  const { client, text } = app;
  view.stop?.abort();
  if (!drive) return;
  const stop = new AbortController();
  view.stop = stop;
  bar.hidden = false;
  bar.removeAttribute("value");
  try {
    const body = bodyOf(view, drive);
    const answer = await computed(client, "/v1/ensembles", body, stop.signal, (share) => {
      bar.value = share;
    });
    const each = (ends[1] - ends[0]) / (STRENGTHS - 1);
    const xs = answer.member.map((/** @type {number} */ one) => ends[0] + each * one);
    const ys = together(
      answer.phi.map((/** @type {number[]} */ row, /** @type {number} */ i) =>
        answer.t[i] > 0 ? foldedTheta(row[arm - 1]) : null,
      ),
    );
    const curves = [{ xs, ys, colour: "--accent", dots: DOT }];
    plot.set(
      { x: text("route.strength", { unit: drive.unit }), y: "\u00b0", curves },
      text("route.plot"),
    );
    status.textContent = text("route.hint");
  } catch (error) {
    if (!aborted(error)) status.textContent = said(error, text);
  } finally {
    if (view.stop === stop) bar.hidden = true;
  }
}

/** An end of the strengths. @param {View} view @param {0 | 1} end */
function endOf(view, end) {
  const { text } = view.app;
  const label = text(end ? "route.to" : "route.from");
  const change = () => {
    const typed = text.read(input.value);
    const ends = end ? [view.ends[0], typed] : [typed, view.ends[1]];
    if (ends[0] >= 0 && ends[1] > ends[0]) view.ends = ends;
    input.value = text.short(view.ends[end]);
    load(view);
  };
  const more = { type: "text", inputmode: "decimal", "aria-label": label, "data-route": end };
  const input = h("input", { ...more, value: text.short(view.ends[end]), on: { change } });
  const unit = h("span", { class: "unit" }, view.drive?.unit ?? "");
  const field = h("span", { class: "with-unit" }, input, unit);
  return h("label", { class: "choice" }, h("span", {}, label), field);
}

/** @param {View} view */
function choose(view) {
  const { app, picks, status, plot } = view;
  const { text, store } = app;
  const { pendulum } = store.get();
  const [drive = null] = drivesOf(pendulum);
  view.drive = drive;
  view.arm = Math.min(view.arm, pendulum.length.length);
  plot.element.hidden = picks.hidden = !drive;
  if (!drive) {
    view.stop?.abort();
    status.textContent = text("route.none");
    return;
  }
  const size = Math.abs(drive.wave.amplitude);
  // a drive that stays within them leaves the ends as they were typed
  if (!(size >= view.ends[0] && size <= view.ends[1]))
    view.ends = RANGE.map((part) => Number((part * size).toPrecision(2)));
  const arms = pendulum.length.map((_, k) => ({ value: k + 1, words: String(k + 1) }));
  const pick = choice(text("modes.chartArm"), arms, view.arm, (value) => {
    view.arm = Number(value);
    load(view);
  });
  const one = arms.length > 1 ? [pick.element] : [];
  picks.replaceChildren(endOf(view, 0), endOf(view, 1), ...one);
  load(view);
}

/** The part of the drawer Physics, which is loaded when it is opened. @param {App} app */
export default async function mountRoute(app) {
  const { store, text, files, live } = app;
  await Promise.all([text.part("route"), files.style("drawers/kit/curves.css")]);
  const bag = createBag();
  const plot = createPlot(text, 260);
  /** @type {View} */
  const view = {
    ...{ app, plot, drive: null, arm: 1, ends: [0, 0], stop: null },
    picks: h("div", { class: "fit-options branches" }),
    status: h("p", { class: "quiet", role: "status", "data-route": "status" }),
    bar: h("progress", { max: 1, hidden: true, "aria-label": text("route.plot") }),
  };
  const soon = settled(() => choose(view), 300);
  bag(soon.end);
  bag(
    store.subscribe((doc, before) => {
      const { drive } = view;
      // its own strength is what the plot is over
      const same = drive && drivesOf(doc.pendulum).length && driven(doc.pendulum, drive, 0);
      const was = drive && drivesOf(before.pendulum).length && driven(before.pendulum, drive, 0);
      if (doc.pendulum !== before.pendulum && JSON.stringify(same) !== JSON.stringify(was)) soon();
    }),
  );
  bag(() => view.stop?.abort());
  bag(plot.destroy);
  plot.element.classList.add("pickable");
  bag.on(plot.element, "click", (event) => {
    const { drive } = view;
    const at = plot.at(/** @type {PointerEvent} */ (event));
    if (!drive || !(at > 0)) return;
    live.change("route", (tree) => driven(tree, drive, Number(at.toPrecision(4))));
    store.settle();
  });
  const element = h("div", {});
  element.append(h("p", { class: "quiet" }, text("route.intro")), view.picks, view.bar);
  element.append(plot.element, view.status);
  choose(view);
  return { element, destroy: bag.end };
}
