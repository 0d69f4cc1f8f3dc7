// A map of two numbers in numbers: its axes, which are the start's angles and the numbers of a real
// pendulum, what is asked of the server, what came.
// Leaves to others: asking (map.js), drawing (map_paint.js).
// Invariant: what is known of a point is the server's number; all else of the pendulum and its
// start is as when the map was begun.

import { foldedTheta, phiOf } from "../../angles.js";
import { roundUp } from "../../camera.js";
import { stateOf } from "../../state.js";
import { pendulumOf, termOf } from "../../terms.js";
import { figure } from "../kit/kit.js";
import { FIELDS, scaleOf } from "../physics/physics_fields.js";

const TURN = 2 * Math.PI;
const NATURAL = 1e-6; // of the largest value, where 0 is none
// with the arm's number behind it: the axis of its angle, of its rate at the start
const ANGLE = "theta";
const RATE = "thetad";

/**
 * What a field is called in ensembles, and how much of the server's unit its unit has.
 * @type {Record<string, {vary: string, factor?: number}>}
 */
const VARIED = {
  gravity: { vary: "gravity" },
  damping: { vary: "damping" },
  dry: { vary: "friction_torque" },
  drag: { vary: "drag" },
  quadratic: { vary: "drag_quadratic" },
  everywhere: { vary: "drag_per_mass" },
  stiffness: { vary: "stiffness" },
  rod: { vary: "rod" },
  tip: { vary: "mass" },
  motor: { vary: "torque_amplitude" },
  motorRate: { vary: "torque_omega", factor: TURN },
  constant: { vary: "torque" },
  up: { vary: "pivot_y_amplitude" },
  upRate: { vary: "pivot_y_omega", factor: TURN },
  aside: { vary: "pivot_x_amplitude" },
  asideRate: { vary: "pivot_x_omega", factor: TURN },
};
const VARYING = FIELDS.filter(({ name }) => name in VARIED);

/** @typedef {Pick<Doc, "pendulum" | "initial">} Begun */

/**
 * An axis: what it is called, its ends in its unit, how many numbers stand at it, where the
 * pendulum itself is; what of the server's varies, and how much of its unit is one of these.
 * @typedef {{
 *   words: (text: Text) => string, unit: string, ends: [number, number], marks: number,
 *   own: number, vary: object, factor: number, set: (begun: Begun, value: number) => Begun,
 * }} Axis
 */

/**
 * What a map shows: the server's observable, the number of a member (NaN: none), the ends of the
 * scale, of which null is what there is; scale: its kind, where the server draws it too.
 * @typedef {(columns: Columns, i: number, n: number, k: number) => number} Read
 * @type {Record<string, {observable: string, read: Read, low: number | null, high: number | null,
 * scale?: "log" | "linear"}>}
 */
export const OBSERVED = {
  end: {
    observable: "final",
    read: (columns, i, n, k) => Math.abs(foldedTheta(columns.final_phi[i * n + k])),
    low: 0,
    high: 180,
  },
  flip: {
    observable: "first_flip",
    read: ({ first_flip_time: times }, i) => (times[i] < 0 ? NaN : times[i]),
    low: null,
    high: null,
    scale: "log",
  },
  swing: {
    observable: "lambda_min",
    read: ({ lambda_min_value: forces }, i, n, k) => -forces[i * n + k],
    low: 0,
    high: null,
  },
  caught: {
    observable: "settled",
    read: ({ settled }, i) => (settled[i] < 0 ? NaN : settled[i]),
    low: 0,
    high: null,
    scale: "linear",
  },
  chaos: {
    observable: "lyapunov",
    read: ({ lyapunov }, i) => lyapunov[i],
    low: null,
    high: null,
    scale: "linear",
  },
};

/** A point of a map, from the left and from below. @typedef {{i: number, j: number}} Point */

/**
 * What is wished for: the axes, what to show, how many points a side, how many seconds.
 * @typedef {{across: string, up: string, what: string, count: number, duration: number}} Wish
 */

/**
 * A map of the pendulum and the start it was begun with, of arm k from 0. Row by row from below:
 * the value of a point, which arm it is of, whether its motion failed; the first `done` are known.
 * @typedef {Wish & Begun & {
 *   axes: [Axis, Axis], k: number, values: Float64Array, arms: Uint16Array, failed: Uint8Array,
 *   done: number,
 * }} NumberMap
 */

/**
 * Whether a pendulum has the number of a field.
 * @param {import("../physics/physics_fields.js").Field} field @param {Tree} tree @param {number} k
 */
function has({ name, needs, get }, tree, k) {
  if (name === "gravity" || name === "tip") return true;
  if (name === "constant") return termOf(tree, "torque", k) !== null;
  return needs ? needs(tree, k) : get(tree, k) !== 0;
}

/** @param {Doc} doc the selected arm, from 0 */
const armOf = ({ view }) => Math.max(view.selected, 1) - 1;

/**
 * What can be an axis, by its name, with its words.
 * @param {Doc} doc @param {Text} text @returns {import("../kit/kit.js").Option[]}
 */
export function offered(doc, text) {
  const fields = VARYING.filter((field) => has(field, doc.pendulum, armOf(doc)));
  const angles = Array.from(doc.initial.phi, (_, k) => ANGLE + (k + 1));
  const rates = angles.map((_, k) => RATE + (k + 1));
  const names = [...fields.map(({ name }) => name), ...angles, ...rates];
  return names.map((value) => ({ value, words: axisOf(doc, value).words(text) }));
}

/** A field's name with that of its group. @param {string} name @param {string} group */
const named = (name, group) => (/** @type {Text} */ text) => {
  const own = text(`physics.${name}`);
  const title = text(`physics.group.${group}`);
  return title === own ? own : `${own} (${title})`;
};

/** The start's angle of an arm. @param {Doc} doc @param {number} arm @returns {Axis} */
const angleAxis = ({ initial }, arm) => ({
  words: (text) => text("map.theta", { arm }),
  unit: "°",
  ends: [-180, 180],
  marks: 5,
  own: foldedTheta(initial.phi[arm - 1]),
  vary: { vary: "theta", arm, unit: "deg" },
  factor: 1,
  set: (begun, value) => {
    const phi = [...begun.initial.phi];
    phi[arm - 1] = phiOf(value);
    return { ...begun, initial: { ...begun.initial, phi } };
  },
});

/** The start's rate of an arm. @param {Doc} doc @param {number} arm @returns {Axis} */
const rateAxis = ({ initial }, arm) => ({
  words: (text) => text("map.thetad", { arm }),
  unit: "rad/s",
  ends: [-10, 10],
  marks: 5,
  own: initial.phid[arm - 1],
  vary: { vary: "thetad", arm },
  factor: 1,
  set: (begun, value) => {
    const phid = [...begun.initial.phid];
    phid[arm - 1] = value;
    return { ...begun, initial: { ...begun.initial, phid } };
  },
});

/** @param {Doc} doc @param {string} name @returns {Axis} */
function axisOf(doc, name) {
  if (name.startsWith(RATE)) return rateAxis(doc, Number(name.slice(RATE.length)));
  if (name.startsWith(ANGLE)) return angleAxis(doc, Number(name.slice(ANGLE.length)));
  const [field] = VARYING.filter((one) => one.name === name);
  const k = armOf(doc);
  const own = field.get(doc.pendulum, k);
  const high = roundUp(own > 0 ? 2 * own : field.most(scaleOf(doc.pendulum)));
  const low = name === "tip" || name === "rod" ? high * NATURAL : 0;
  const { vary, factor = 1 } = VARIED[name];
  return {
    words: named(name, field.group),
    unit: field.unit,
    ends: [name === "constant" ? -high : low, high],
    marks: 3,
    own,
    vary: field.whole ? { vary } : { vary, arm: k + 1 },
    factor,
    set: (begun, value) => ({
      ...begun,
      pendulum: field.set(begun.pendulum, new Set([k]), value, 0),
    }),
  };
}

/** @param {Doc} doc @param {Wish} wish @returns {NumberMap} of which nothing is known */
export function createMap(doc, wish) {
  const points = wish.count ** 2;
  return {
    ...wish,
    pendulum: doc.pendulum,
    initial: doc.initial,
    axes: [axisOf(doc, wish.across), axisOf(doc, wish.up)],
    k: armOf(doc),
    values: new Float64Array(points).fill(NaN),
    arms: new Uint16Array(points),
    failed: new Uint8Array(points),
    done: 0,
  };
}

/** The point nearest to the pendulum itself. @param {NumberMap} map @returns {Point} */
export function ownPoint({ axes, count }) {
  const [i, j] = axes.map(({ own, ends: [low, high] }) => {
    const place = Math.round(((own - low) / (high - low)) * (count - 1));
    return Math.max(0, Math.min(count - 1, place));
  });
  return { i, j };
}

/**
 * The value of an axis at a place.
 * @param {{count: number}} map @param {Axis} axis @param {number} i
 */
const valueAt = ({ count }, { ends: [low, high] }, i) => low + ((high - low) * i) / (count - 1);

/** The pendulum and the start of a point. @param {NumberMap} map @param {Point} point */
export function begunAt(map, { i, j }) {
  const { pendulum, initial, axes } = map;
  const first = axes[0].set({ pendulum, initial }, valueAt(map, axes[0], i));
  return axes[1].set(first, valueAt(map, axes[1], j));
}

/**
 * The body for /v1/ensembles of rows `row` ... row + rows - 1 from below.
 * @param {NumberMap} map @param {number} row @param {number} rows
 */
export function bodyOf(map, row = 0, rows = map.count) {
  const { pendulum, initial, axes, count, duration, what } = map;
  const grid = [0, row].map((from, which) => {
    const { vary, factor } = axes[which];
    const many = which ? rows : count;
    const [start, stop] = [from, from + many - 1].map((i) => factor * valueAt(map, axes[which], i));
    return { ...vary, start, stop, count: many };
  });
  const observables = [OBSERVED[what].observable];
  const begun = { pendulum: pendulumOf(pendulum), initial: stateOf(pendulum, initial) };
  return { ...begun, grid, duration, observables };
}

/**
 * The server's answer for the rows from `row` on.
 * @param {NumberMap} map @param {number} row @param {import("../kit/kit.js").Table} table
 */
export function takeRows(map, row, { columns, count }) {
  const from = row * map.count;
  const n = map.pendulum.length.length;
  const { read } = OBSERVED[map.what];
  for (let i = 0; i < count; i++) map.values[from + i] = read(columns, i, n, map.k);
  if (columns.first_flip_arm) map.arms.set(columns.first_flip_arm.subarray(0, count), from);
  map.failed.set(columns.status.subarray(0, count), from);
  map.done = from + count;
}

/**
 * The scale of what is here: its ends, and the place of a value between them; of times it goes by
 * logarithms, over two powers of ten at most.
 * @param {NumberMap} map
 */
export function scaleOfMap({ what, values, duration }) {
  const { scale, ...given } = OBSERVED[what];
  let [least, most] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  if (!(most > least)) most = least + 1;
  if (!Number.isFinite(least)) [least, most] = [0, 1];
  const log = scale === "log";
  const low = log ? Math.max(Math.min(least, duration / 2), duration / 100) : (given.low ?? least);
  const high = log ? duration : (given.high ?? most);
  const share = (/** @type {number} */ value) =>
    log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return { low, high, log, share };
}

/** A point in words. @param {NumberMap} map @param {Point} point @param {Text} text */
export function wordsOf(map, { i, j }, text) {
  const at = j * map.count + i;
  const value = figure(text, map.values[at], 3);
  const none = map.what === "caught" ? "map.caught.never" : "compare.never";
  const never = text(none, { time: text.short(map.duration) });
  const told =
    map.what === "flip"
      ? text("compare.flips", { arm: map.arms[at], time: value })
      : text(`map.${map.what}.value`, { value });
  const known = Number.isNaN(map.values[at]) ? never : told;
  const what = map.failed[at] ? text("compare.failed") : known;
  const [x, y] = map.axes.map((axis, which) => {
    const number = figure(text, valueAt(map, axis, which ? j : i), 3);
    return `${axis.words(text)} = ${number} ${axis.unit}`;
  });
  return text("map.point", { x, y, what: at < map.done ? what : text("compare.unknown") });
}
