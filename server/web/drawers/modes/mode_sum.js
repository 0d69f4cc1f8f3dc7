// Shapes of modes and of their sum, as angles from the rest about which they swing; of a pendulum
// with friction they turn and die away.
// Leaves to others: showing them (modes.js, mode_card.js).
// Invariant: shapes, frequencies and decays are the server's; what is added up here is their linear
// sum, which the server calls exact for small angles only.

export const DEGREE = Math.PI / 180;
export const STEEPEST = 60; // degrees of an amplitude
const HANGING = -Math.PI / 2;
const FIRST = 25; // degrees
const MOST = 1; // of the exponent of a mode that grows: more is not drawn

/**
 * Modes of any pendulum: v e^((-decay + i omega) t) about the rest, v = re + i im; real: whether it
 * has more than an ideal one; cart: the rest of a pivot on a rail, and its part of each shape.
 * @typedef {{
 *   omega: number[], frequency: number[], period: number[], mode: number[], decay: number[],
 *   ratio: number[], re: number[][], im: number[][], rest: number[], real: boolean,
 *   cart?: {equilibrium: number, re: number[], im: number[]},
 *   identity?: {sum_inverse_omega_squared: number, length_total_over_g: number,
 *   relative_difference: number},
 * }} Modes
 */

/**
 * Modes, the amplitude of each in degrees, and which of them the sum has, counted from 0.
 * @typedef {{modes: Modes, angles: number[], chosen: Set<number>}} Blend
 */

/** What the server says. @param {any} answer @param {number} n arms @returns {Modes} */
export function modesOf(answer, n) {
  const { vectors, omega, equilibrium, decay, damping_ratio: ratio } = answer;
  const none = omega.map(() => 0);
  const { re = vectors, im = omega.map(() => new Array(n).fill(0)) } = vectors;
  return {
    ...answer,
    ...{ re, im, decay: decay ?? none, ratio: ratio ?? none, real: Boolean(equilibrium) },
    period: omega.map((/** @type {number} */ one) => (2 * Math.PI) / one),
    rest: equilibrium ?? new Array(n).fill(HANGING),
  };
}

/** @param {Modes} modes @returns {Blend} */
export function createBlend(modes) {
  const few = modes.omega.length > 1 ? [0, 1] : [0];
  return { modes, angles: modes.omega.map(() => FIRST), chosen: new Set(few) };
}

/** Angles from the rest as the angles that are drawn. @param {Modes} modes
 * @param {Float64Array} theta */
export const posed = ({ rest }, theta) => theta.map((angle, arm) => rest[arm] + angle);

/**
 * One mode at a time, times a factor.
 * @param {Modes} modes @param {number} k @param {number} part radians @param {number} time s
 */
export function shapeOf({ re, im, omega, decay }, k, part, time = 0) {
  const far = part * Math.exp(Math.min(MOST, -decay[k] * time));
  const [cos, sin] = [far * Math.cos(omega[k] * time), far * Math.sin(omega[k] * time)];
  return Float64Array.from(re[k], (value, arm) => cos * value - sin * im[k][arm]);
}

/** A mode's velocity at time 0, rad/s. @param {Modes} modes @param {number} k
 * @param {number} part radians */
export const speedOf = ({ re, im, omega, decay }, k, part) =>
  re[k].map((value, arm) => part * (-decay[k] * value - omega[k] * im[k][arm]));

/** How far a mode's arms swing at most, times a factor. @param {Modes} modes @param {number} k
 * @param {number} part radians */
export const rangeOf = ({ re, im }, k, part) =>
  Float64Array.from(re[k], (value, arm) => part * Math.hypot(value, im[k][arm]));

/** The modes of the sum, in their order. @param {Blend} blend */
export const partsOf = ({ modes, chosen }) =>
  [...chosen].filter((k) => k < modes.omega.length).sort((a, b) => a - b);

/**
 * The chosen modes added up, at a time.
 * @param {Blend} blend @param {number} n arms @param {number} time s
 */
export function sumOf(blend, n, time = 0) {
  const theta = new Float64Array(n);
  for (const k of partsOf(blend))
    shapeOf(blend.modes, k, blend.angles[k] * DEGREE, time).forEach((value, arm) => {
      theta[arm] += value;
    });
  return theta;
}

/** How far aside the sum can swing. @param {Blend} blend @param {number} n arms */
export function widest(blend, n) {
  const far = new Float64Array(n).fill(0.05);
  for (const k of partsOf(blend))
    rangeOf(blend.modes, k, blend.angles[k] * DEGREE).forEach((value, arm) => {
      far[arm] += value;
    });
  return far;
}

/**
 * The start of a motion that small swings would keep in some modes: each with its amplitude.
 * @param {Blend} blend @param {number[]} parts modes, counted from 0 @returns {State}
 */
export function startOf({ modes, angles }, parts) {
  const { rest, cart, omega, decay } = modes;
  const phi = [...rest];
  const phid = rest.map(() => 0);
  let [x, v] = [cart?.equilibrium ?? 0, 0];
  for (const k of parts) {
    const part = angles[k] * DEGREE;
    shapeOf(modes, k, part).forEach((value, arm) => (phi[arm] += value));
    if (modes.real) speedOf(modes, k, part).forEach((value, arm) => (phid[arm] += value));
    x += part * (cart?.re[k] ?? 0);
    v += cart ? part * (-decay[k] * cart.re[k] - omega[k] * cart.im[k]) : 0;
  }
  return { phi, phid, ...(cart && { cart: { x, v } }) };
}
