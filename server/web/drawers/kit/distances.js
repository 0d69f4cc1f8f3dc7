// How far two motions of one pendulum are from each other.
// Leaves to others: the motions (motion.js), the chart of it (compare.js, method.js).
// Invariant: both are the server's samples, at the same instants.

/**
 * The largest difference of an angle at each instant that both have, rad, or in another unit.
 * @param {{n: number, count: number, columns: Columns}} track @param {{count: number, columns:
 * Columns}} other @param {number} unit rad
 */
export function distances(track, other, unit = 1) {
  const { n } = track;
  const count = Math.min(track.count, other.count);
  const list = new Float64Array(count);
  const { phi } = track.columns;
  const { phi: beside } = other.columns;
  for (let i = 0; i < count; i++) {
    let most = 0;
    for (let k = i * n; k < (i + 1) * n; k++) most = Math.max(most, Math.abs(phi[k] - beside[k]));
    list[i] = most / unit;
  }
  return list;
}

/**
 * As a list for an axis of powers of ten: 0 has no place there.
 * @param {Float64Array} list @param {number} count
 */
export const logarithmic = (list, count = list.length) =>
  Array.from({ length: count }, (_, i) => list[i] || null);
