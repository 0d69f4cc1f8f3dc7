// What a real pendulum has beyond an ideal one, in the page's own form: one list a term, an entry
// an arm, null where an arm has none.
// Leaves to others: what the terms do, which only the server computes; where arms are (tree.js).
// Invariant: a term that no arm has is not there; what is given stays as it was.

/** The terms of single arms, and those of the whole pendulum, by the names of requests. */
export const ROWS = /** @type {const} */ ([
  "rod",
  "body",
  "at",
  "damping",
  "stiffness",
  "rest",
  "friction",
  "torque",
  "drag",
  "stop",
]);
const ONES = /** @type {const} */ (["drag_per_mass", "pivot", "control"]);

/** @typedef {typeof ROWS[number]} Row */

/** @param {any} value */
const there = (value) => value !== null && value !== undefined;

/**
 * The terms that a pendulum has, in one order: what no arm has is left out.
 * @param {any} pendulum @returns {Terms}
 */
export function termsOf(pendulum) {
  /** @type {any} */
  const terms = {};
  for (const name of ROWS) {
    const list = pendulum[name];
    if (Array.isArray(list) ? list.some(there) : there(list)) terms[name] = list;
  }
  for (const name of ONES) if (there(pendulum[name])) terms[name] = pendulum[name];
  return terms;
}

/** A pendulum as requests have it. @param {Tree} tree */
export const pendulumOf = ({ length, mass, parent, gravity, ...more }) => ({
  length,
  mass,
  parent,
  gravity,
  ...termsOf(more),
});

/**
 * The lists of terms of arms that have a field each, as the server tells trees.
 * @param {any[]} arms
 */
export function listsOf(arms) {
  const lists = ROWS.map((name) => [name, arms.map((arm) => arm[name] ?? null)]);
  return termsOf(Object.fromEntries(lists));
}

/**
 * A pendulum without what divides its motion into pieces: controllers, stops, tables, friction that
 * sticks.
 * @param {Tree} tree @returns {Tree}
 */
export function smoothOf(tree) {
  const smooth = { ...tree };
  delete smooth.control;
  delete smooth.stop;
  const untabled = withTerm(smooth, "torque", (k) => {
    const torque = termOf(tree, "torque", k);
    if (!torque || typeof torque === "number" || !torque.table) return torque;
    const { constant = 0, harmonics = [] } = torque;
    return { constant, harmonics };
  });
  return withTerm(untabled, "friction", (k) => {
    const friction = termOf(tree, "friction", k);
    return friction?.speed ? friction : null;
  });
}

/**
 * Whether the motion is in pieces: by controllers, stops, friction that sticks or tables.
 * @param {Tree} tree
 */
export const inPieces = ({ control, stop, friction, torque, pivot }) =>
  Boolean(control || stop || pivot?.x?.table || pivot?.y?.table) ||
  Boolean(friction?.some((one) => one && !one.speed)) ||
  Boolean(torque?.some((one) => typeof one === "object" && one?.table));

/** Whether drives or friction change the energy of a pendulum. @param {Tree} tree */
export function exchanges(tree) {
  const { damping, friction, torque, drag, drag_per_mass: air, pivot, stop, control } = tree;
  const moved = pivot && (pivot.x || pivot.y || pivot.acceleration);
  const cart = pivot?.cart && (pivot.cart.damping || pivot.cart.force);
  return Boolean(damping || friction || torque || drag || air || moved || cart || stop || control);
}

const number = Number.isFinite;
/** @param {any} value */
const place = (value) =>
  number(value) || (Array.isArray(value) && value.length === 2 && value.every(number));
/** @param {any} value */
const waves = (value) =>
  !there(value) ||
  (Array.isArray(value) && value.every((one) => number(one?.amplitude) && number(one?.omega)));
/** @param {any} axis */
const moves = (axis) =>
  !there(axis) ||
  (typeof axis === "object" &&
    waves(axis.harmonics) &&
    (!there(axis.table) || (place(axis.table.t?.slice(0, 2)) && axis.table.value?.every(number))));

/**
 * What an entry of a list must be for the page to draw it.
 * @type {Record<Row, (value: any) => boolean>}
 */
const SOUND = {
  rod: number,
  body: (value) => number(value.mass) && place(value.center),
  at: place,
  damping: number,
  stiffness: number,
  rest: number,
  friction: (value) => number(value.torque),
  torque: (value) => number(value) || (typeof value === "object" && waves(value.harmonics)),
  drag: (value) => typeof value === "object",
  stop: (value) => number(value.min ?? 0) && number(value.max ?? 0),
};

/**
 * Whether the terms of a pendulum of n arms can be drawn; what else is wrong with them the server
 * says.
 * @param {any} pendulum @param {number} n
 */
export function soundTerms(pendulum, n) {
  const rows = ROWS.every((name) => {
    const list = pendulum[name];
    if (!there(list)) return true;
    return (
      Array.isArray(list) &&
      list.length === n &&
      list.every((value) => !there(value) || SOUND[name](value))
    );
  });
  const { pivot, drag_per_mass: drag } = pendulum;
  if (!rows || (there(drag) && !number(drag))) return false;
  if (!there(pivot)) return true;
  if (typeof pivot !== "object" || !moves(pivot.x) || !moves(pivot.y)) return false;
  const { cart } = pivot;
  return !there(cart) || (number(cart.mass) && number(cart.angle ?? 0));
}

/**
 * The term of an arm, counted from 0; null where it has none.
 * @template {Row} Name @param {Tree} tree @param {Name} name @param {number} k
 * @returns {NonNullable<Tree[Name]>[number] | null}
 */
export const termOf = (tree, name, k) => tree[name]?.[k] ?? null;

/**
 * A pendulum in which some arms, counted from 0, have another value of a term; null: none.
 * @param {Tree} tree @param {Row} name @param {(k: number) => any} value of an arm
 * @returns {Tree}
 */
export function withTerm(tree, name, value) {
  const list = tree.length.map((_, k) => value(k) ?? null);
  const changed = { ...tree, [name]: list };
  if (!list.some(there)) delete changed[name];
  return /** @type {Tree} */ (changed);
}

/** [along, across] of a place on an arm. @param {Place2 | null} at @param {number} length */
function pair(at, length) {
  if (at === null) return [length, 0];
  return typeof at === "number" ? [at, 0] : at;
}

/** Where on its parent an arm hangs: [along, across], m. @param {Tree} tree @param {number} k */
export const hangsAt = (tree, k) =>
  tree.parent[k] ? pair(termOf(tree, "at", k), tree.length[tree.parent[k] - 1]) : [0, 0];

/** The center of mass of an arm's body: [along, across], m. @param {Body} body */
export const centerOf = (body) => pair(body.center, 0);

/** What an arm weighs, kg: its tip, its bar and its body. @param {Tree} tree @param {number} k */
export const massOf = (tree, k) =>
  tree.mass[k] + (termOf(tree, "rod", k) ?? 0) + (termOf(tree, "body", k)?.mass ?? 0);

/** @param {Harmonic[] | undefined} harmonics @param {number} t s of the request's own time */
export function waveAt(harmonics, t) {
  let sum = 0;
  if (!harmonics) return sum;
  for (const { amplitude, omega, phase = 0 } of harmonics)
    sum += amplitude * Math.cos(omega * t + phase);
  return sum;
}

/** The most that harmonics and a table can be. @param {Axis} [axis] */
export const farOf = ({ harmonics = [], table } = {}) =>
  harmonics.reduce((sum, { amplitude }) => sum + Math.abs(amplitude), 0) +
  (table ? table.value.reduce((most, one) => Math.max(most, Math.abs(one)), 0) : 0);

/** How far harmonics and tables of the pivot can take it, m. @param {Tree} tree */
export const shakes = ({ pivot }) => farOf(pivot?.x) + farOf(pivot?.y);

/** Second derivatives of natural splines. @type {WeakMap<PlaceTable, number[]>} */
const BENDS = new WeakMap();

/** @param {PlaceTable} table */
function bendsOf(table) {
  const { t, value } = table;
  const known = BENDS.get(table);
  if (known) return known;
  const [bend, part] = [t.map(() => 0), t.map(() => 0)];
  for (let i = 1; i < t.length - 1; i++) {
    const [before, after] = [t[i] - t[i - 1], t[i + 1] - t[i]];
    const turn = (value[i + 1] - value[i]) / after - (value[i] - value[i - 1]) / before;
    const divisor = 2 * (before + after) - before * part[i - 1];
    part[i] = after / divisor;
    bend[i] = (6 * turn - before * bend[i - 1]) / divisor;
  }
  for (let i = t.length - 2; i > 0; i--) bend[i] -= part[i] * bend[i + 1];
  BENDS.set(table, bend);
  return bend;
}

/** A coordinate of the pivot at a time, m. @param {Axis | undefined} axis @param {number} time s */
export function placeAt(axis, time) {
  const waves = waveAt(axis?.harmonics, time);
  if (!axis?.table) return waves;
  const { t, value } = axis.table;
  const bend = bendsOf(axis.table);
  let k = 0;
  while (k < t.length - 2 && t[k + 1] <= time) k++;
  const h = t[k + 1] - t[k];
  const b = Math.max(0, Math.min(1, (time - t[k]) / h));
  const a = 1 - b;
  const curve = (a * a - 1) * a * bend[k] + (b * b - 1) * b * bend[k + 1];
  return waves + a * value[k] + b * value[k + 1] + (curve * h * h) / 6;
}

/**
 * The motor's torque on an arm at a time, N m.
 * @param {Tree} tree @param {number} k @param {number} t s
 */
export function torqueAt(tree, k, t) {
  const torque = termOf(tree, "torque", k);
  if (torque === null || typeof torque === "number") return torque ?? 0;
  return (torque.constant ?? 0) + waveAt(torque.harmonics, t) + tableAt(torque.table, t);
}

/** @param {TorqueTable | undefined} table @param {number} time s */
function tableAt(table, time) {
  if (!table) return 0;
  const { t, value, hold, outside } = table;
  const last = t.length - 1;
  if (time < t[0] || time > t[last]) return outside === "hold" ? value[time < t[0] ? 0 : last] : 0;
  let k = 0;
  while (k < last && t[k + 1] <= time) k++;
  if (hold === "zero" || k === last) return value[k];
  return value[k] + ((value[k + 1] - value[k]) * (time - t[k])) / (t[k + 1] - t[k]);
}

/** The largest torque that a motor can have, N m. @param {Tree} tree @param {number} k */
export function strongest(tree, k) {
  const torque = termOf(tree, "torque", k);
  if (torque === null || typeof torque === "number") return Math.abs(torque ?? 0);
  return Math.abs(torque.constant ?? 0) + farOf(torque);
}

/**
 * The energy of the springs, J, at the angles phi from offset on, the cart being at `cart`.
 * @param {Tree} tree @param {ArrayLike<number>} phi @param {number} offset @param {number} cart m
 */
export function springEnergy(tree, phi, offset = 0, cart = 0) {
  let sum = ((tree.pivot?.cart?.stiffness ?? 0) * cart * cart) / 2;
  for (let k = 0; k < (tree.stiffness?.length ?? 0); k++) {
    const stiffness = termOf(tree, "stiffness", k) ?? 0;
    const carrier = tree.parent[k];
    const base = carrier ? phi[offset + carrier - 1] : -Math.PI / 2;
    const turn = phi[offset + k] - base - (termOf(tree, "rest", k) ?? 0);
    sum += (stiffness * turn * turn) / 2;
  }
  return sum;
}
