// A mode in a card: its little tree that swings, its numbers, its amplitude, and what can be begun
// with it.
// Leaves to others: which modes there are and their sum (modes.js), drawing the tree (mini.js).
// Invariant: shapes and frequencies are the server's.

import { h } from "../../dom.js";
import { button, figure, tick } from "../kit/kit.js";
import { createMini } from "../kit/mini.js";
import { DEGREE, STEEPEST, posed, rangeOf } from "./mode_sum.js";

const FACTS = ["omega", "frequency", "period"];
const LOSSES = ["decay", "ratio"]; // of a real pendulum besides

/** @typedef {import("./mode_sum.js").Blend} Blend */

/**
 * What a card does to the others.
 * @typedef {{changed(): void, begin(parts: number[], label: string, words: string): void}} Hooks
 */

/** How high the pivot is in a picture of modes: above all, where all arms hang at their rest.
 * @param {import("./mode_sum.js").Modes} modes */
export const topOf = ({ rest }) => (rest.every((phi) => Math.sin(phi) < -0.3) ? 0.06 : 0.5);

/** @param {Text} text @param {number} value */
function plainFigure(text, value) {
  return value > 0.01 && value < 1e5 ? text.number(value, 3) : figure(text, value, 4);
}

/** Frequency and period, in words. @param {Text} text @param {Blend} blend @param {number} k */
function factsOf(text, { modes }, k) {
  const rows = [...FACTS, ...(modes.real ? LOSSES : [])].flatMap((id) => {
    const value = modes[/** @type {"omega" | "ratio"} */ (id)][k];
    const words = text(`modes.${id}Value`, { value: plainFigure(text, value) });
    return [h("dt", {}, text(`modes.${id}`)), h("dd", {}, words)];
  });
  return h("dl", {}, ...rows);
}

/**
 * The slider of a mode's amplitude, and its degrees.
 * @param {Text} text @param {Blend} blend @param {number} k @param {Hooks} hooks
 */
function amplitudeOf(text, { modes, angles }, k, hooks) {
  const mode = modes.mode[k];
  const words = () => text("degrees", { angle: text.short(angles[k]) });
  const said = h("output", {}, words());
  const input = () => {
    angles[k] = Number(slider.value);
    said.textContent = words();
    slider.setAttribute("aria-valuetext", said.textContent);
    hooks.changed();
  };
  const label = { "aria-label": text("modes.amplitude", { mode }), "data-amplitude": mode };
  const range = { type: "range", min: 0, max: STEEPEST, step: 1, value: angles[k] };
  const slider = h("input", { ...range, ...label, on: { input } });
  return h("div", { class: "amplitude" }, slider, said);
}

/**
 * @param {Text} text @param {Tree} tree @param {Blend} blend @param {number} k counted from 0
 * @param {Hooks} hooks
 */
export function createModeCard(text, tree, blend, k, hooks) {
  const { modes, chosen } = blend;
  const mode = modes.mode[k];
  const mini = createMini(tree, {
    width: 124,
    height: 132,
    top: topOf(modes),
    label: text("modes.picture", { mode }),
  });
  mini.fit(posed(modes, rangeOf(modes, k, STEEPEST * DEGREE)));
  const part = tick(text("modes.inSum"), chosen.has(k), (on) => {
    if (on) chosen.add(k);
    else chosen.delete(k);
    hooks.changed();
  });
  part.box.dataset.part = String(mode);
  const begin = () => hooks.begin([k], "mode", text("modes.started", { mode }));
  const start = button(text("modes.start"), begin, { "data-start": mode });
  const title = h("h3", {}, text("modes.title", { mode }));
  const amplitude = amplitudeOf(text, blend, k, hooks);
  const body = h(
    "div",
    { class: "mode-body" },
    title,
    factsOf(text, blend, k),
    amplitude,
    part.element,
    start,
  );
  return { mini, element: h("li", { class: "mode-card", "data-mode": mode }, mini.canvas, body) };
}
