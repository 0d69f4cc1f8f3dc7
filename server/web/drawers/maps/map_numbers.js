// A map of two numbers of a pendulum, in numbers: its axes, what is asked of the server, what came.
// Leaves to others: asking (param_map.js), drawing (map_paint.js).
// Invariant: what is known of a point is the server's number; all else of the pendulum and its
// start is as when the map was begun.

import { roundUp } from "../../camera.js";
import { stateOf } from "../../state.js";
import { pendulumOf, termOf } from "../../terms.js";
import { figure } from "../kit/kit.js";
import { FIELDS, scaleOf } from "../physics/physics_fields.js";

const TURN = 2 * Math.PI;
const NATURAL = 1e-6; // of the largest value, where 0 is none

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

/** The fields that can be an axis. */
export const AXES = Object.fromEntries(
  FIELDS.filter(({ name }) => name in VARIED).map((field) => [
    field.name,
    { field, ...VARIED[field.name] },
  ]),
);

/**
 * What a map shows: the server's observable, the number of a member (NaN: none), and the ends of
 * the scale, of which null is the largest there is.
 * @typedef {(columns: Columns, i: number, n: number, k: number) => number} Read
 * @type {Record<string, {observable: string, read: Read, low: number | null, high: number |
 * null}>}
 */
export const OBSERVED = {
  end: {
    observable: "final",
    read: (columns, i, n, k) => folded(columns.final_phi[i * n + k]),
    low: 0,
    high: 180,
  },
  flip: {
    observable: "first_flip",
    read: ({ first_flip_time: times }, i) => (times[i] < 0 ? NaN : times[i]),
    low: 0,
    high: null,
  },
  swing: {
    observable: "lambda_min",
    read: ({ lambda_min_value: forces }, i, n, k) => -forces[i * n + k],
    low: 0,
    high: null,
  },
  chaos: {
    observable: "lyapunov",
    read: ({ lyapunov }, i) => lyapunov[i],
    low: null,
    high: null,
  },
};

/** How far an angle is from hanging, degrees, 0 ... 180. @param {number} phi */
const folded = (phi) => {
  const turns = (phi + Math.PI / 2) / TURN;
  return Math.abs(turns - Math.round(turns)) * 360;
};

/**
 * What is wished for: the axes' fields, what to show, how many points a side, how many seconds.
 * @typedef {{across: string, up: string, what: string, count: number, duration: number}} Wish
 */

/**
 * A map: the pendulum and the start it was begun with, of arm k from 0; `start`: the point of the
 * pendulum itself; ends: of every axis. The first `done` points are known, row by row from below.
 * @typedef {Wish & {
 *   pendulum: Tree, initial: State, k: number, start: {i: number, j: number},
 *   ends: Record<string, [number, number]>, values: Float64Array, failed: Uint8Array, done: number,
 * }} NumberMap
 */

/**
 * Whether a pendulum has the number of a field.
 * @param {Tree} tree @param {string} name @param {number} k
 */
function has(tree, name, k) {
  const { field } = AXES[name];
  if (name === "gravity" || name === "tip") return true;
  if (name === "constant") return termOf(tree, "torque", k) !== null;
  return field.needs ? field.needs(tree, k) : field.get(tree, k) !== 0;
}

/** The fields that can be an axis of this pendulum. @param {Tree} tree @param {number} k */
export const offered = (tree, k) => Object.keys(AXES).filter((name) => has(tree, name, k));

/**
 * From where to where an axis goes: around the pendulum's own value.
 * @param {Tree} tree @param {string} name @param {number} k @returns {[number, number]}
 */
function endsOf(tree, name, k) {
  const { field } = AXES[name];
  const own = field.get(tree, k);
  const high = own > 0 ? roundUp(2 * own) : roundUp(field.most(scaleOf(tree)));
  if (name === "constant") return [-high, high];
  return [name === "tip" || name === "rod" ? high * NATURAL : 0, high];
}

/** @param {Doc} doc @param {Wish} wish @returns {NumberMap} of which nothing is known */
export function createMap({ pendulum, initial, view }, wish) {
  const k = Math.max(view.selected, 1) - 1;
  const points = wish.count ** 2;
  const ends = {
    [wish.across]: endsOf(pendulum, wish.across, k),
    [wish.up]: endsOf(pendulum, wish.up, k),
  };
  const near = (/** @type {string} */ name) => {
    const [low, high] = ends[name];
    const share = (AXES[name].field.get(pendulum, k) - low) / (high - low);
    return Math.max(0, Math.min(wish.count - 1, Math.round(share * (wish.count - 1))));
  };
  return {
    ...wish,
    pendulum,
    initial,
    k,
    ends,
    start: { i: near(wish.across), j: near(wish.up) },
    values: new Float64Array(points).fill(NaN),
    failed: new Uint8Array(points),
    done: 0,
  };
}

/**
 * The value of an axis at a place.
 * @param {NumberMap} map @param {string} name @param {number} i
 */
export function valueAt({ ends, count }, name, i) {
  const [low, high] = ends[name];
  return low + ((high - low) * i) / (count - 1);
}

/** @param {NumberMap} map @param {string} name @param {number} from @param {number} count */
function axisOf(map, name, from, count) {
  const { field, vary, factor = 1 } = AXES[name];
  const axis = {
    vary,
    start: factor * valueAt(map, name, from),
    stop: factor * valueAt(map, name, from + count - 1),
    count,
  };
  return field.whole ? axis : { ...axis, arm: map.k + 1 };
}

/**
 * The body for /v1/ensembles of rows `row` ... row + rows - 1 from below.
 * @param {NumberMap} map @param {number} row @param {number} rows
 */
export function bodyOf(map, row = 0, rows = map.count) {
  const { pendulum, initial, across, up, count, duration, what } = map;
  return {
    pendulum: pendulumOf(pendulum),
    initial: stateOf(pendulum, initial),
    grid: [axisOf(map, across, 0, count), axisOf(map, up, row, rows)],
    duration,
    observables: [OBSERVED[what].observable],
  };
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
  map.failed.set(columns.status.subarray(0, count), from);
  map.done = from + count;
}

/** The ends of the scale of what is here. @param {NumberMap} map @returns {[number, number]} */
export function scaleOfMap({ what, values }) {
  const { low, high } = OBSERVED[what];
  let least = Infinity;
  let most = -Infinity;
  for (const value of values) {
    if (value < least) least = value;
    if (value > most) most = value;
  }
  if (!(most > least)) most = least + 1;
  if (!Number.isFinite(least)) [least, most] = [0, 1];
  return [low ?? least, high ?? most];
}

/** A field's name with that of its group. @param {Text} text @param {string} name */
export function nameOf(text, name) {
  const { group } = AXES[name].field;
  const own = text(`physics.${name}`);
  const title = text(`physics.group.${group}`);
  return title === own ? own : `${own} (${title})`;
}

/**
 * A point in words.
 * @param {NumberMap} map @param {{i: number, j: number}} point @param {Text} text
 */
export function wordsOf(map, { i, j }, text) {
  const at = j * map.count + i;
  const value = map.values[at];
  const shown = Number.isNaN(value)
    ? text("compare.never", { time: text.short(map.duration) })
    : "";
  const known = shown || text(`map.${map.what}.value`, { value: figure(text, value, 3) });
  const what = map.failed[at] ? text("compare.failed") : known;
  const number = (/** @type {string} */ name, /** @type {number} */ place) =>
    `${nameOf(text, name)} ${figure(text, valueAt(map, name, place), 3)} ${AXES[name].field.unit}`;
  return text("map.point", {
    x: number(map.across, i),
    y: number(map.up, j),
    what: at < map.done ? what : text("compare.unknown"),
  });
}
