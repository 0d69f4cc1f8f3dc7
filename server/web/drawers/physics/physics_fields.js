// The numbers of a real pendulum that have a slider: where each stands in the pendulum, its unit,
// how far its slider goes.
// Leaves to others: the sliders (physics.js), when a change happens (live.js).
// Invariant: what a field gets is the number of requests, in the field's unit; a field that is set
// changes nothing else but what would have no meaning without it.

import { massOf, termOf, withTerm } from "../../terms.js";
import { reach } from "../../tree.js";

const DEGREE = Math.PI / 180;
const TURN = 2 * Math.PI;
const SLOW = 0.05; // rad/s, below which dry friction lets go, where the pendulum does not tell
export const LIGHT = 0.001; // kg
const SHORTEST = 0.05; // m

/**
 * A number with a slider. Arms are counted from 0; of one that belongs to the whole pendulum k is
 * 0. least: where its slider begins (0 where it is left out); most: where it ends; needs: whether
 * there is something that it is a number of.
 * @typedef {{
 *   name: string, group: string, unit: string, whole?: boolean, even?: boolean,
 *   get: (tree: Tree, k: number) => number, most: (scale: Scale) => number,
 *   least?: (scale: Scale) => number, needs?: (tree: Tree, k: number) => boolean,
 *   set: (tree: Tree, arms: Set<number>, value: number, time: number) => Tree,
 * }} Field
 */

/**
 * What is large for a pendulum.
 * @typedef {{torque: number, omega: number, far: number, mass: number}} Scale
 */

/**
 * A torque, an angular frequency, a length and a mass that are large for a pendulum.
 * @param {Tree} tree @returns {Scale}
 */
export function scaleOf(tree) {
  const far = reach({ ...tree, pivot: undefined });
  const mass = tree.mass.reduce((sum, _, k) => sum + massOf(tree, k), 0);
  const gravity = Math.abs(tree.gravity) || 9.81;
  return { far, mass, torque: mass * gravity * far, omega: Math.sqrt(gravity / far) };
}

/** @param {Scale} scale torque over rate that damps a swing at once */
const strong = ({ torque, omega }) => torque / omega;

/**
 * A row of numbers that is there where it is not 0.
 * @param {"damping" | "stiffness" | "rod"} name
 */
const plain = (name) => ({
  get: (/** @type {Tree} */ tree, /** @type {number} */ k) => termOf(tree, name, k) ?? 0,
  set: (/** @type {Tree} */ tree, /** @type {Set<number>} */ arms, /** @type {number} */ value) =>
    withTerm(tree, name, (k) => (arms.has(k) ? value || null : termOf(tree, name, k))),
});

/** @param {Tree} tree @param {Set<number>} arms @param {number} value */
function setStiffness(tree, arms, value) {
  const sprung = plain("stiffness").set(tree, arms, value);
  // a rest is of a spring
  return withTerm(sprung, "rest", (k) =>
    termOf(sprung, "stiffness", k) === null ? null : termOf(tree, "rest", k),
  );
}

/** @param {Tree} tree @param {Set<number>} arms @param {number} value */
function setRod(tree, arms, value) {
  const bars = plain("rod").set(tree, arms, value);
  // an arm without any mass is none
  const mass = tree.mass.map((tip, k) => (massOf(bars, k) > 0 ? tip : Math.max(tip, LIGHT)));
  return { ...bars, mass };
}

/** @param {Tree} tree @param {Set<number>} arms @param {number} value */
function setTip(tree, arms, value) {
  const bare = { ...tree, mass: tree.mass.map((tip, k) => (arms.has(k) ? 0 : tip)) };
  const mass = bare.mass.map((tip, k) => {
    if (!arms.has(k)) return tip;
    return massOf(bare, k) > 0 ? value : Math.max(value, LIGHT);
  });
  return { ...tree, mass };
}

/** @param {"linear" | "quadratic"} part */
const air = (part) => ({
  get: (/** @type {Tree} */ tree, /** @type {number} */ k) => termOf(tree, "drag", k)?.[part] ?? 0,
  set: (/** @type {Tree} */ tree, /** @type {Set<number>} */ arms, /** @type {number} */ value) =>
    withTerm(tree, "drag", (k) => {
      const old = termOf(tree, "drag", k);
      if (!arms.has(k)) return old;
      const drag = { ...old, [part]: value };
      return drag.linear || drag.quadratic ? drag : null;
    }),
});

/** @param {Tree} tree @param {number} k */
function motorOf(tree, k) {
  const torque = termOf(tree, "torque", k);
  return typeof torque === "number" ? { constant: torque } : torque;
}

/** @param {Tree} tree */
const natural = (tree) => {
  const { omega } = scaleOf(tree);
  return Number(omega.toPrecision(3));
};

/**
 * The first harmonic with another amplitude or another frequency; at `time` it is where it was.
 * @param {Harmonic[] | undefined} waves @param {Partial<Harmonic>} change @param {number} time
 * @param {Tree} tree @returns {Harmonic[]}
 */
export function retuned(waves, change, time, tree) {
  const [first = { amplitude: 0, omega: natural(tree), phase: 0 }, ...others] = waves ?? [];
  const { omega = first.omega } = change;
  const turned = (first.phase ?? 0) + (first.omega - omega) * time;
  const phase = omega === first.omega ? (first.phase ?? 0) : turned % TURN;
  return [{ ...first, ...change, phase }, ...others];
}

/**
 * @param {(old: {constant?: number, harmonics?: Harmonic[]}, value: number, time: number, tree:
 * Tree) => object} change
 * @returns {Field["set"]}
 */
const setMotor = (change) => (tree, arms, value, time) =>
  withTerm(tree, "torque", (k) => {
    if (!arms.has(k)) return termOf(tree, "torque", k);
    const motor = {
      constant: 0,
      ...motorOf(tree, k),
      ...change(motorOf(tree, k) ?? {}, value, time, tree),
    };
    return motor.constant || motor.harmonics?.length ? motor : null;
  });

/**
 * The shaking of the pivot along an axis.
 * @param {"x" | "y"} axis
 */
function shaking(axis) {
  const first = (/** @type {Tree} */ tree) => tree.pivot?.[axis]?.harmonics?.[0];
  const set = (
    /** @type {Tree} */ tree,
    /** @type {Partial<Harmonic>} */ change,
    /** @type {number} */ time,
  ) => {
    const harmonics = retuned(tree.pivot?.[axis]?.harmonics, change, time, tree);
    const own = { ...tree.pivot?.[axis], harmonics };
    return { ...tree, pivot: { ...tree.pivot, [axis]: own } };
  };
  return { first, set };
}

/** @param {"x" | "y"} axis @param {string} name @returns {Field[]} */
function shakingFields(axis, name) {
  const { first, set } = shaking(axis);
  return [
    {
      name,
      group: "shaking",
      unit: "m",
      whole: true,
      get: (tree) => first(tree)?.amplitude ?? 0,
      set: (tree, _, amplitude, time) => set(tree, { amplitude }, time),
      most: ({ far }) => far / 2,
      // a cart moves by itself
      needs: (tree) => !tree.pivot?.cart,
    },
    {
      name: `${name}Rate`,
      group: "shaking",
      unit: "Hz",
      whole: true,
      get: (tree) => (first(tree)?.omega ?? natural(tree)) / TURN,
      set: (tree, _, value, time) => set(tree, { omega: value * TURN }, time),
      most: ({ omega }) => (40 * omega) / TURN,
      needs: (tree) => Boolean(first(tree)),
    },
  ];
}

/** @type {Field[]} */
export const FIELDS = [
  {
    name: "length",
    group: "arms",
    unit: "m",
    even: true,
    get: (tree, k) => tree.length[k],
    most: ({ far }) => Math.max(2, far),
    set: (tree, arms, value) => ({
      ...tree,
      length: tree.length.map((old, k) => (arms.has(k) ? Math.max(SHORTEST, value) : old)),
    }),
  },
  {
    name: "gravity",
    group: "gravity",
    unit: "m/s\u00b2",
    whole: true,
    even: true,
    get: (tree) => tree.gravity,
    set: (tree, _, gravity) => ({ ...tree, gravity }),
    most: () => 25,
  },
  {
    name: "damping",
    group: "friction",
    unit: "N\u00b7m\u00b7s",
    ...plain("damping"),
    most: (scale) => 2 * strong(scale),
  },
  {
    name: "dry",
    group: "friction",
    unit: "N\u00b7m",
    get: (tree, k) => {
      const friction = termOf(tree, "friction", k);
      return friction?.speed ? friction.torque : 0;
    },
    set: (tree, arms, torque) =>
      withTerm(tree, "friction", (k) => {
        const old = termOf(tree, "friction", k);
        if (!arms.has(k) || (!torque && old && !old.speed)) return old;
        return torque ? { torque, speed: old?.speed ?? SLOW } : null;
      }),
    most: ({ torque }) => torque / 2,
  },
  {
    name: "drag",
    group: "air",
    unit: "N\u00b7s/m",
    ...air("linear"),
    most: ({ mass, omega }) => 2 * mass * omega,
  },
  {
    name: "quadratic",
    group: "air",
    unit: "N\u00b7s\u00b2/m\u00b2",
    ...air("quadratic"),
    most: ({ mass, far }) => (2 * mass) / far,
  },
  {
    name: "everywhere",
    group: "air",
    unit: "1/s",
    whole: true,
    get: (tree) => tree.drag_per_mass ?? 0,
    set: (tree, _, value) => {
      const changed = { ...tree, drag_per_mass: value };
      if (!value) delete (/** @type {Terms} */ (changed).drag_per_mass);
      return changed;
    },
    most: ({ omega }) => omega,
  },
  {
    name: "stiffness",
    group: "spring",
    unit: "N\u00b7m",
    get: plain("stiffness").get,
    set: setStiffness,
    most: ({ torque }) => 4 * torque,
  },
  {
    name: "rest",
    group: "spring",
    unit: "\u00b0",
    even: true,
    get: (tree, k) => (termOf(tree, "rest", k) ?? 0) / DEGREE,
    set: (tree, arms, value) =>
      withTerm(tree, "rest", (k) => {
        const old = termOf(tree, "rest", k);
        const sprung = termOf(tree, "stiffness", k) !== null;
        return arms.has(k) && sprung ? value * DEGREE || null : old;
      }),
    least: () => -180,
    most: () => 180,
    needs: (tree, k) => termOf(tree, "stiffness", k) !== null,
  },
  {
    name: "rod",
    group: "masses",
    unit: "kg",
    get: plain("rod").get,
    set: setRod,
    most: ({ mass }) => 2 * mass,
  },
  {
    name: "tip",
    group: "masses",
    unit: "kg",
    get: (tree, k) => tree.mass[k],
    set: setTip,
    most: ({ mass }) => 2 * mass,
  },
  {
    name: "motor",
    group: "motor",
    unit: "N\u00b7m",
    get: (tree, k) => motorOf(tree, k)?.harmonics?.[0]?.amplitude ?? 0,
    set: setMotor(({ harmonics }, amplitude, time, tree) => ({
      harmonics: retuned(harmonics, { amplitude }, time, tree),
    })),
    most: ({ torque }) => 2 * torque,
  },
  {
    name: "motorRate",
    group: "motor",
    unit: "Hz",
    get: (tree, k) => (motorOf(tree, k)?.harmonics?.[0]?.omega ?? natural(tree)) / TURN,
    set: setMotor(({ harmonics }, value, time, tree) => ({
      harmonics: retuned(harmonics, { omega: value * TURN }, time, tree),
    })),
    most: ({ omega }) => (5 * omega) / TURN,
    needs: (tree, k) => Boolean(motorOf(tree, k)?.harmonics?.length),
  },
  {
    name: "constant",
    group: "motor",
    unit: "N\u00b7m",
    get: (tree, k) => motorOf(tree, k)?.constant ?? 0,
    set: setMotor((_, constant) => ({ constant })),
    least: ({ torque }) => -torque,
    most: ({ torque }) => torque,
  },
  ...shakingFields("y", "up"),
  ...shakingFields("x", "aside"),
];

/** A tree without what gives or takes energy, and without springs. @param {Tree} tree */
export function withoutLosses(tree) {
  const { length, mass, parent, gravity, rod, body, at, pivot } = tree;
  const kept = { length, mass, parent, gravity };
  const cart = pivot?.cart && { mass: pivot.cart.mass, angle: pivot.cart.angle ?? 0 };
  return /** @type {Tree} */ ({
    ...kept,
    ...(rod && { rod }),
    ...(body && { body }),
    ...(at && { at }),
    ...(cart && { pivot: { cart } }),
  });
}
