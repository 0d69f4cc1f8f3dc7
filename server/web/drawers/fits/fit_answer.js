// What a fit found, for people: how it ended, each number with its error, what goes together, what
// the data do not tell, the measurements over the model's motion and what is left over; and the
// fitted pendulum on the stage.
// Leaves to others: the request (fit_request.js), curves (plot.js).
// Invariant: every number is the server's; curves between the measurements are the motion that it
// computes of the fitted pendulum.

import { DEGREE, foldedTheta } from "../../angles.js";
import { h } from "../../dom.js";
import { listsOf } from "../../terms.js";
import { createSpots, order, tips } from "../../tree.js";
import { button, fetchTable, figure } from "../kit/kit.js";
import { createPlot } from "../kit/plot.js";
import { looked } from "./fit_look.js";

const TOGETHER = 0.9; // correlations from here on are said
const FINE = 800; // points of the model's curve
const HANGING = -Math.PI / 2;

/** What the server says that data do not tell, up to the names. @type {[string, string][]} */
const SENTENCES = [
  ["the data do not depend on ", "fits.untold.none"],
  ["the data determine only the ratios of ", "fits.untold.ratios"],
  ["the data do not distinguish ", "fits.untold.apart"],
];

/**
 * A fit that has ended: what was asked, the names of what was found, and the answer.
 * @typedef {{
 *   body: ReturnType<typeof import("./fit_request.js").fitBody>, answer: any,
 *   found: import("./fit_request.js").Candidate[], measured:
 *   import("./fit_request.js").Measured, unit: string,
 * }} Fitted
 */

/** @type {Record<string, string>} */
const OF_CART = {
  mass: "physics.cart",
  damping: "physics.cartDamping",
  phi: "control.place",
  phid: "control.speed",
};

/**
 * The name of a number in the page's language.
 * @param {Text} text @param {{vary: string, arm?: number | "cart"}} one
 */
export const nameOf = (text, { vary, arm }) => {
  if (arm === "cart") return text(OF_CART[vary]);
  if (/^bias_/.test(vary))
    return `${text("fits.acceleration")}: ${text(`fits.role.${vary.slice(5)}`, { arm })}`;
  return arm ? text("fits.ofArm", { what: text(`fits.${vary}`), arm }) : text(`fits.${vary}`);
};

/** An answer's pendulum as the page has pendulums. @param {any} pendulum @returns {Tree} */
function treeOf({ arms, gravity, drag_per_mass: air, pivot }) {
  const names = arms.map((/** @type {any} */ arm) => arm.name);
  return {
    length: arms.map((/** @type {any} */ arm) => arm.length),
    mass: arms.map((/** @type {any} */ arm) => arm.mass ?? 0),
    parent: arms.map((/** @type {any} */ arm) => names.indexOf(arm.parent) + 1),
    gravity,
    ...listsOf(arms),
    ...(air && { drag_per_mass: air }),
    ...(pivot && { pivot }),
  };
}

/** @param {Fitted} fitted the fitted pendulum, its start, and when it is there */
export function motionOf({ answer }) {
  const { pendulum, initial, times } = answer.request;
  const { phi, phid = phi.map(() => 0), cart } = initial;
  const start = { phi, phid, ...(cart && { cart }) };
  return { pendulum: treeOf(pendulum), initial: start, times };
}

/** What a minimum is told by that has nothing beside it. */
const PLAIN = "a minimum, whose motion follows the data";

/**
 * The measurement that is farthest from the model, in words; "" if there is none.
 * @param {Text} text @param {Fitted} fitted
 */
function farthest(text, { answer, measured }) {
  let most = 0;
  let words = "";
  measured.series.forEach(({ kind, arm }, k) =>
    measured.t.forEach((t, i) => {
      const off = Math.abs(answer.residuals[i][k] ?? 0);
      if (!(off > most)) return;
      most = off;
      const holes = { what: text(`fits.role.${kind}`, { arm }), time: figure(text, t, 4) };
      words = text("fits.farthest", holes);
    }),
  );
  return words;
}

/** What the server says of it beyond the verdict. @param {Text} text @param {Fitted} fitted */
function messageOf(text, fitted) {
  const { model, message } = fitted.answer;
  const lines = [];
  const off = model === "accepted" ? "" : farthest(text, fitted);
  if (off) lines.push(h("p", { "data-fit": "farthest" }, off));
  const said = [...(message === PLAIN ? [] : [message]), ...fitted.answer.hints];
  if (!said.length) return lines;
  const words = h("span", { lang: "en" }, said.join(" \u2013 "));
  lines.push(h("p", { class: "quiet", "data-fit": "message" }, text("fits.words"), " ", words));
  return lines;
}

/** How it ended, in words. @param {Text} text @param {Fitted} fitted */
function verdictOf(text, fitted) {
  const { answer } = fitted;
  const { status, model, follows_until: until, explained, errors_widened: times } = answer;
  const words = text(`fits.${status === "converged" ? model : status}`);
  const lines = [
    h("p", { class: "fit-verdict", "data-status": status, "data-model": model }, words),
  ];
  const percent = text.number(100 * explained, explained > 0.99 ? 2 : 1);
  lines.push(h("p", { "data-fit": "explained" }, text("fits.explained", { percent })));
  if (until !== null)
    lines.push(h("p", {}, text("fits.follows", { time: figure(text, until, 4) })));
  const wide =
    times === null
      ? text("fits.withheld")
      : text("fits.widened", { times: figure(text, times, 3) });
  if (times !== 1) lines.push(h("p", { "data-fit": "widened" }, wide));
  const { chi_squared_per_degree: chi, p_value: p, durbin_watson: watson } = answer;
  if (p !== null)
    lines.push(
      h(
        "p",
        { class: "quiet" },
        text("fits.chi", { chi: figure(text, chi), p: figure(text, p, 2) }),
      ),
    );
  if (watson !== null)
    lines.push(
      h("p", { class: "quiet" }, text("fits.watson", { watson: figure(text, watson, 3) })),
    );
  return [...lines, ...messageOf(text, fitted)];
}

/** Each number with its error. @param {Text} text @param {Fitted} fitted */
function estimatesOf(text, { answer, found }) {
  const rows = found.map((one, k) => {
    const { value, error, at_bound: bound } = answer.unknowns[k];
    const known = error !== null;
    // as many digits as the error leaves
    const places = known && error > 0 ? Math.ceil(-Math.log10(error * one.factor)) + 1 : 3;
    const digits = Math.max(0, Math.min(8, places));
    const plus = known ? `\u00b1 ${figure(text, error * one.factor, 2)}` : "";
    const wrong = bound ? `${text("fits.bound")} ${plus}` : plus || text("fits.unknown");
    return h(
      "tr",
      { "data-found": one.id },
      h("th", { scope: "row" }, nameOf(text, one)),
      h("td", { "data-value": value }, `${text.number(value * one.factor, digits)} ${one.unit}`),
      h("td", { "data-value": known && error }, wrong),
    );
  });
  const heads = ["fits.number", "fits.value", "fits.error"];
  const head = heads.map((key) => h("th", { scope: "col" }, text(key)));
  return scrolled(
    text("fits.found"),
    h("thead", {}, h("tr", {}, ...head)),
    h("tbody", {}, ...rows),
  );
}

/** @param {string} label @param {...HTMLElement} parts of a table that may be wide */
export const scrolled = (label, ...parts) =>
  h(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": label },
    h("table", {}, ...parts),
  );

/** All correlations. @param {Text} text @param {Fitted} fitted */
function matrixOf(text, { answer, found }) {
  const names = found.map((one) => nameOf(text, one));
  const head = [h("td", {}), ...names.map((_, k) => h("th", { scope: "col" }, String(k + 1)))];
  const rows = names.map((name, i) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, `${i + 1} ${name}`),
      ...answer.correlation[i].map((/** @type {number} */ value) =>
        h("td", {}, Number.isFinite(value) ? text.number(value, 2) : "\u2013"),
      ),
    ),
  );
  const summary = h("summary", {}, text("fits.correlations"));
  const table = scrolled(text("fits.correlations"), h("tr", {}, ...head), ...rows);
  return h("details", {}, summary, table);
}

/**
 * A sentence of the server's about what data do not tell, with the page's names.
 * @param {Text} text @param {string} sentence @param {Fitted} fitted
 */
function untold(text, sentence, { answer, found }) {
  const known = SENTENCES.find(([begin]) => sentence.startsWith(begin));
  if (!known) return sentence;
  const rest = sentence.slice(known[0].length);
  const named = found.filter((_, k) => {
    const { name } = answer.unknowns[k];
    // "drag of arm 1" is not named by "drag of arm 12"
    return new RegExp(`(^|, | and )${name.replace(/[()]/g, "\\$&")}(?![\\d])`).test(rest);
  });
  const list = new Intl.ListFormat(text.language).format(named.map((one) => nameOf(text, one)));
  return text(known[1], { list });
}

/** Correlated and unidentifiable unknowns, one sentence for each. @param {Text} text
 * @param {Fitted} fitted */
function sentencesOf(text, fitted) {
  const { answer, found } = fitted;
  const lines = answer.unidentifiable.map((/** @type {string} */ one) => untold(text, one, fitted));
  found.forEach((a, i) =>
    found.slice(0, i).forEach((b, j) => {
      const value = answer.correlation[i][j];
      if (!(Math.abs(value) > TOGETHER)) return;
      const holes = { a: nameOf(text, b), b: nameOf(text, a), value: text.number(value, 2) };
      lines.push(text("fits.together", holes));
    }),
  );
  const items = lines.map((/** @type {string} */ words) => h("li", {}, words));
  return lines.length ? h("ul", { class: "fit-said" }, ...items) : null;
}

/**
 * The motion of the fitted pendulum over the measured time: times, and a column for what a series
 * measures.
 * @param {Client} client @param {Fitted} fitted @param {AbortSignal} signal
 */
async function modelOf(client, fitted, signal) {
  const { answer, measured, unit } = fitted;
  const { pendulum, initial, times } = answer.request;
  // the motion's time is ahead of the measurements' by the camera's shift
  const { scale, rotation, origin, shift } = answer.camera;
  const stop = measured.t[measured.t.length - 1] + shift;
  const span = { start: times.start, stop: Math.max(stop, times.start + 1e-3), count: FINE };
  const body = { pendulum, initial, times: span, output: ["phi", "phid"] };
  const { count, columns } = await fetchTable(client, "/v1/trajectories", body, { signal });
  const tree = treeOf(pendulum);
  const n = tree.length.length;
  const rows = order(tree.parent);
  const spots = createSpots(n);
  const [cos, sin] = [Math.cos(rotation) * scale, Math.sin(rotation) * scale];
  // what the instruments add, rad and rad/s
  const added = (/** @type {string} */ vary, /** @type {number} */ arm) =>
    answer.unknowns[fitted.found.findIndex(({ id }) => id === `${vary} ${arm}`)]?.value ?? 0;
  const column = (/** @type {string} */ kind, /** @type {number} */ arm) =>
    Array.from({ length: count }, (_, i) => {
      const place = i * n + arm - 1;
      if (kind === "thetad") return (columns.phid[place] + added("bias", arm)) / DEGREE;
      const phi = columns.phi[place] + added("zero", arm);
      const carrier = tree.parent[arm - 1];
      if (kind === "theta" || (kind === "joint" && !carrier)) return foldedTheta(phi);
      if (kind === "phi") return foldedTheta(phi + HANGING);
      if (kind === "joint") return foldedTheta(phi - columns.phi[i * n + carrier - 1] + HANGING);
      tips(tree, rows, columns.phi, i * n, spots, columns.t[i]);
      const [x, y] = [spots.x[arm - 1], spots.y[arm - 1]];
      return kind === "x" ? origin[0] + cos * x - sin * y : origin[1] + sin * x + cos * y;
    });
  return { t: columns.t.map((time) => time - shift), column, unit };
}

/** Angles without whole turns, broken where they pass the top. @param {(number | null)[]} list */
const broken = (list) =>
  list.map((value, i) => {
    const before = list[i - 1] ?? value;
    return value !== null && Math.abs(value - (before ?? 0)) > 180 ? null : value;
  });

/** @param {number} k of a series */
const colourOf = (k) => `--arm-${(k % 8) + 1}`;

/** What is drawn together: its unit is that of the picture. @type {{[unit: string]: RegExp}} */
const GROUPS = {
  "\u00b0": /^(theta|phi|joint|amplitude)$/,
  "\u00b0/s": /^thetad$/,
  "": /^[xy]$/,
  "m/s\u00b2": /^(along|across)$/,
  s: /^period$/,
  m: /^cart$/,
};
const TURNS = /^(theta|phi|joint|thetad|amplitude)$/;
const SMOOTH = /^(theta|phi|joint|thetad)$/;

/**
 * The series of one kind, angles, rates or places: measured, of the model, and left over.
 * @param {Fitted} fitted @param {Awaited<ReturnType<typeof modelOf>>} model @param {RegExp} group
 */
function curvesOf({ answer, body, measured }, model, group) {
  /** @type {import("../kit/plot.js").Curve[]} */
  const over = [];
  /** @type {import("../kit/plot.js").Curve[]} */
  const left = [];
  /** @type {{k: number, rest: (number | null)[]}[]} */
  const rests = [];
  measured.series.forEach(({ kind, arm, values }, k) => {
    if (!group.test(kind)) return;
    const colour = colourOf(k);
    const turning = GROUPS["\u00b0"].test(kind);
    const factor = TURNS.test(kind) ? 1 / DEGREE : 1;
    const folded = (/** @type {number | null} */ value) => {
      const scaled = value === null ? null : value * factor;
      return scaled === null || !turning ? scaled : scaled - 360 * Math.ceil(scaled / 360 - 0.5);
    };
    // between the instants it is known of angles, rates, and places without a lens and a cart
    const bare = !("reach" in answer.camera) && !answer.request.pendulum.pivot?.cart;
    const smooth = GROUPS[""].test(kind) ? bare : SMOOTH.test(kind);
    // the server's are model less measurement, over a sigma that it knows
    const { sigma = 1 } = /** @type {{sigma?: number | number[]}} */ (body.data.series[k]);
    const rest = answer.residuals.map(
      (/** @type {(number | null)[]} */ row, /** @type {number} */ i) =>
        row[k] === null
          ? null
          : -Number(row[k]) * factor * (Array.isArray(sigma) ? sigma[i] : sigma),
    );
    const ends = values.map((value, i) =>
      value === null || rest[i] === null ? null : folded(value - rest[i] / factor),
    );
    const line = smooth ? model.column(kind, arm) : ends;
    over.push({ xs: smooth ? model.t : measured.t, ys: turning ? broken(line) : line, colour });
    over.push({ xs: measured.t, ys: values.map(folded), colour, dots: 2.2 });
    left.push({ xs: measured.t, ys: rest, colour, dots: 1.8 });
    rests.push({ k, rest });
  });
  return { over, left, rests };
}

/** What the colours are. @param {Text} text @param {Fitted} fitted @param {RegExp} group */
function namesOf(text, { measured }, group) {
  const names = measured.series.flatMap(({ kind, arm }, k) => {
    if (!group.test(kind)) return [];
    const line = h("span", { class: "stroke" });
    line.style.setProperty("--colour", `var(${colourOf(k)})`);
    return [h("span", {}, line, " ", text(`fits.role.${kind}`, { arm }))];
  });
  return h("p", { class: "plot-names" }, ...names);
}

/**
 * The plots of what was measured over what the model does.
 * @param {App} app @param {Fitted} fitted @param {AbortSignal} signal
 */
async function plotsOf({ client, text }, fitted, signal) {
  const model = await modelOf(client, fitted, signal);
  /** @type {(ReturnType<typeof createPlot> | HTMLElement)[]} */
  const parts = [];
  for (const [own, group] of Object.entries(GROUPS)) {
    const { over, left, rests } = curvesOf(fitted, model, group);
    if (!over.length) continue;
    const unit = own || fitted.unit;
    const x = text("fits.t");
    const first = createPlot(text, 220);
    const second = createPlot(text, 120);
    const label = text("fits.over");
    first.set({ x, y: unit, curves: over }, label);
    second.set({ x, y: unit, curves: left, low: 0 }, text("fits.left"));
    parts.push(h("h4", {}, label), namesOf(text, fitted, group), first);
    parts.push(h("h4", {}, text("fits.left")), second);
    parts.push(...rests.flatMap(({ k, rest }) => looked(text, fitted, k, rest, unit)));
  }
  return parts;
}

/**
 * Shows a fit in its place: {destroy}.
 * @param {App} app @param {HTMLElement} place @param {Fitted} fitted @param {AbortSignal} signal
 * @param {{instead(): void, beside(): void, report(): void}} acts
 */
export async function showFit(app, place, fitted, signal, acts) {
  const { text } = app;
  const said = sentencesOf(text, fitted);
  const keys = [
    button(text("fits.instead"), acts.instead, { class: "button main", "data-fit": "instead" }),
    button(text("fits.beside"), acts.beside, { "data-fit": "beside" }),
    button(text("share.report"), acts.report, { "data-fit": "report" }),
  ];
  place.replaceChildren(
    ...verdictOf(text, fitted),
    estimatesOf(text, fitted),
    ...(said ? [said] : []),
    matrixOf(text, fitted),
    h("div", { class: "row" }, ...keys),
  );
  const parts = await plotsOf(app, fitted, signal);
  place.append(...parts.map((part) => ("element" in part ? part.element : part)));
  return () => parts.forEach((part) => "element" in part && part.destroy());
}
