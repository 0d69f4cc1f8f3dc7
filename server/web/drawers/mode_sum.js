// Shapes of modes and of their sum, as angles from hanging.
// Leaves to others: showing them (modes.js, mode_card.js).
// Invariant: shapes and frequencies are the server's; what is added up here is their linear sum,
// which the server calls exact for small angles only.

export const DEGREE = Math.PI / 180;
export const STEEPEST = 60; // degrees of an amplitude
const HANGING = -Math.PI / 2;
const FIRST = 25; // degrees

/** The server's answer. @typedef {{
 *   omega: number[], frequency: number[], period: number[], mode: number[], vectors: number[][],
 *   identity?: {sum_inverse_omega_squared: number, length_total_over_g: number,
 *   relative_difference: number},
 * }} Modes */

/**
 * Modes, the amplitude of each in degrees, and which of them the sum has, counted from 0.
 * @typedef {{modes: Modes, angles: number[], chosen: Set<number>}} Blend
 */

/** @param {Modes} modes @returns {Blend} */
export function createBlend(modes) {
  const few = modes.omega.length > 1 ? [0, 1] : [0];
  return { modes, angles: modes.omega.map(() => FIRST), chosen: new Set(few) };
}

/** Angles from hanging as the angles that are drawn. @param {Float64Array} theta */
export const hang = (theta) => theta.map((angle) => HANGING + angle);

/** One mode, times a factor. @param {Modes} modes @param {number} k @param {number} part radians */
export const shapeOf = ({ vectors }, k, part) =>
  Float64Array.from(vectors[k], (value) => value * part);

/** The modes of the sum, in their order. @param {Blend} blend */
export const partsOf = ({ modes, chosen }) =>
  [...chosen].filter((k) => k < modes.omega.length).sort((a, b) => a - b);

/**
 * The chosen modes added up, each at its phase of a time; at the start without one.
 * @param {Blend} blend @param {number} n arms @param {number | null} time
 */
export function sumOf(blend, n, time = null) {
  const { modes, angles } = blend;
  const theta = new Float64Array(n);
  for (const k of partsOf(blend)) {
    const part = angles[k] * DEGREE * (time === null ? 1 : Math.cos(modes.omega[k] * time));
    modes.vectors[k].forEach((value, arm) => {
      theta[arm] += part * value;
    });
  }
  return theta;
}

/** How far aside the sum can swing. @param {Blend} blend @param {number} n arms */
export function widest(blend, n) {
  const { modes, angles } = blend;
  const parts = partsOf(blend);
  const far = (/** @type {number} */ arm) =>
    parts.reduce((all, k) => all + Math.abs(angles[k] * DEGREE * modes.vectors[k][arm]), 0.05);
  return Float64Array.from({ length: n }, (_, arm) => far(arm));
}
