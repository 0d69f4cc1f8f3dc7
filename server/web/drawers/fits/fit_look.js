// What a trained eye sees in residuals, in words: a drift, a period that is left over, a changing
// spread.
// Leaves to others: the residuals and their plot (fit_answer.js), outliers (the server's words).
// Invariant: what chance makes in one of a thousand series of noise is not said.

import { h } from "../../dom.js";
import { figure } from "../kit/kit.js";

const CHANCE = 1e-3;
const SURE = 5; // standard errors from which a slope is no chance
const SEEN = 0.15; // fraction of the variance from which a pattern is seen
const WORK = 2e7; // sines, at most
const WIDER = 1.5; // ratio of spreads that the eye sees
const FEWEST = 16; // residuals

/** @param {number[]} list @param {(value: number, i: number) => number} of */
const sum = (list, of) => list.reduce((all, value, i) => all + of(value, i), 0);

/** A straight line through points: its values, its slope in standard errors, the fraction of the
 * variance that it explains. @param {number[]} xs @param {number[]} ys */
function lineOf(xs, ys) {
  const [x, y] = [xs, ys].map((list) => sum(list, (value) => value / list.length));
  const xx = sum(xs, (value) => (value - x) ** 2);
  const slope = sum(xs, (value, i) => (value - x) * (ys[i] - y)) / xx;
  const told = (slope ** 2 * xx) / sum(ys, (value) => (value - y) ** 2);
  const errors = Math.sqrt((told * (xs.length - 2)) / (1 - told));
  return { at: (/** @type {number} */ t) => y + slope * (t - x), errors, told };
}

/** The strongest frequency of values without a mean (Lomb and Scargle), Hz; 0 where chance would do
 * as well. @param {number[]} ts from 0 on @param {number[]} values */
function frequencyOf(ts, values) {
  const span = ts[ts.length - 1];
  const many = Math.floor(Math.min(ts.length, WORK / ts.length));
  let [most, power] = [0, 0];
  for (let k = 3; k <= many; k++) {
    const [s, c] = [Math.sin, Math.cos].map((wave) =>
      ts.map((t) => wave((Math.PI * k * t) / span)),
    );
    const [ss, cc, sc] = [sum(s, (v) => v * v), sum(c, (v) => v * v), sum(s, (v, i) => v * c[i])];
    const [sy, cy] = [s, c].map((list) => sum(list, (v, i) => v * values[i]));
    const own = (cc * sy * sy + ss * cy * cy - 2 * sc * sy * cy) / (ss * cc - sc * sc);
    if (own > power) [most, power] = [k, own];
  }
  const told = power / sum(values, (value) => value * value);
  const chance = many * (1 - told) ** ((ts.length - 3) / 2);
  return told > SEEN && chance < CHANCE ? most / (2 * span) : 0;
}

/**
 * A paragraph of what is seen in the residuals of series k; none if nothing is.
 * @param {Text} text @param {import("./fit_answer.js").Fitted} fitted @param {number} k
 * @param {(number | null)[]} rest @param {string} unit
 */
export function looked(text, { answer, measured }, k, rest, unit) {
  const out = answer.outliers.map((/** @type {any} */ one) => one.series === k + 1 && one.t);
  const rows = measured.t
    .flatMap((t, i) => (rest[i] === null || out.includes(t) ? [] : [[t, Number(rest[i])]]))
    .sort(([a], [b]) => a - b);
  if (rows.length < FEWEST) return [];
  const ts = rows.map(([t]) => t - rows[0][0]);
  const line = lineOf(
    ts,
    rows.map(([, value]) => value),
  );
  const flat = rows.map(([, value], i) => value - line.at(ts[i]));
  const [size, frequency] = [lineOf(ts, flat.map(Math.abs)), frequencyOf(ts, flat)];
  const ends = (/** @type {typeof line} */ { at }) => {
    const [from, to] = [0, ts[ts.length - 1]].map((t) => figure(text, at(t)));
    return { from, to, unit };
  };
  const wider = size.at(ts[ts.length - 1]) / size.at(0);
  const said = [];
  if (line.errors > SURE && line.told > SEEN) said.push(text("fits.look.drift", ends(line)));
  if (frequency) {
    const [period, hertz] = [1 / frequency, frequency].map((one) => figure(text, one));
    said.push(text("fits.look.period", { period, frequency: hertz }));
  }
  if (size.errors > SURE && !(wider < WIDER && wider > 1 / WIDER))
    said.push(text("fits.look.spread", ends(size)));
  const { kind, arm } = measured.series[k];
  const words = `${text(`fits.role.${kind}`, { arm })}: ${said.join(" ")}`;
  return said.length ? [h("p", { "data-fit": "look" }, words)] : [];
}
