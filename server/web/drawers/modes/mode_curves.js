// The linear motion beside the full one: a curve of each, of one arm.
// Leaves to others: the two motions (motion.js), the chart (chart.js).
// Invariant: both are the server's.

import { h } from "../../dom.js";
import { ghostColour } from "../../palette.js";
import { createGroup } from "../kit/chart.js";
import { choice, swatch } from "../kit/kit.js";

const HANGING = -Math.PI / 2;
const DEGREE = Math.PI / 180;

/** @param {{method?: string}} ghost */
export const isLinear = (ghost) => ghost.method === "linear";

/**
 * An arm's angle from hanging, in degrees.
 * @param {Track} track @param {number} arm @param {number} count
 */
function thetaOf(track, arm, count) {
  const { phi } = track.columns;
  return Array.from({ length: count }, (_, i) => (phi[i * track.n + arm - 1] - HANGING) / DEGREE);
}

/**
 * Puts the curves into their place: {n, fill, destroy}.
 * @param {App} app @param {HTMLElement} place
 */
export function openCurves(app, place) {
  const { motion, store, text } = app;
  const group = createGroup(app);
  const { n } = motion;
  let arm = 1;
  const title = h("h3", { class: "chart-title" });
  const host = h("div", { class: "chart", role: "img" });
  const arms = Array.from({ length: n }, (_, k) => ({ value: k + 1, words: String(k + 1) }));
  const pick = choice(text("modes.chartArm"), arms, arm, (value) => {
    arm = Number(value);
    fill();
  });
  const pale = ghostColour(store.get().ghosts.findIndex(isLinear));
  const named = (/** @type {string} */ colour, /** @type {string} */ key) =>
    h("span", { class: "name" }, swatch(colour), " ", text(key));
  const names = [named("--ink", "modes.nonlinear"), named(pale, "modes.linearName")];
  const hint = h("p", { class: "quiet" }, text("modes.linearHint"));
  place.replaceChildren(
    hint,
    title,
    h("div", { class: "row small" }, ...names, pick.element),
    host,
  );
  const series = [{ colour: "--ink" }, { colour: pale, dash: [6, 3] }];
  const chart = group.add(host, { series, degrees: true, height: 150 });

  function fill() {
    const ghost = motion.ghosts.find(({ doc }) => isLinear(doc));
    title.textContent = text("modes.chart", { arm });
    host.setAttribute("aria-label", title.textContent);
    if (!ghost?.count || !motion.count || motion.n !== n) return;
    const count = Math.min(ghost.count, motion.count);
    const curves = [motion.track, ghost].map((track) => thetaOf(track, arm, count));
    chart.set([motion.t.slice(0, count), ...curves]);
  }
  fill();
  return {
    n,
    fill,
    destroy: () => {
      group.destroy();
      place.replaceChildren();
    },
  };
}
