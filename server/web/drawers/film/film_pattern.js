// A pattern followed through the pictures of a film: the square around a mark, found again where
// its brightness correlates best.
// Leaves to others: the pictures (film_frames.js), a spot of one colour (film_colour.js).
// Invariant: only shape counts, not how bright the light is. What is tracked turns, so the pattern
// takes over a little of each place found; it stays tied to the first one.

import { followColour, pickColour } from "./film_colour.js";

const LEAST = 0.6; // correlation, below which a place is not the pattern
const NEAR = 1.5; // times the square, searched around the place where it is expected
const FAR = 4; // times the square, where it is not there
const FLAT = 4; // of 255: the deviation of a square without a pattern
const OLD = 0.75; // of the pattern from one picture to the next
const NEW = 0.2; // of the place that was found; the rest is of the first one

/** @typedef {import("./film_colour.js").Picture} Picture */
/** half: of the square, pixels; first, square: brightness without its mean, of the norm 1.
 * @typedef {{half: number, first: Float64Array, square: Float64Array}} Pattern */

/** Brightness of a pixel, at the edge beyond it. @param {Picture} picture @param {number} x
 * @param {number} y */
function lumaAt({ data, width, height }, x, y) {
  const column = Math.max(0, Math.min(width - 1, x));
  const i = 4 * (Math.max(0, Math.min(height - 1, y)) * width + column);
  return 0.299 * data[i] + 0.587 * data[i + 1] + 0.114 * data[i + 2];
}

/** Without its mean, of the norm 1; null of what is flat. @param {Float64Array} square
 * @param {number} least its deviation */
function normed(square, least = FLAT) {
  const mean = square.reduce((sum, value) => sum + value, 0) / square.length;
  const norm = Math.hypot(...square.map((value) => value - mean));
  const flat = norm <= least * Math.sqrt(square.length);
  return flat ? null : square.map((value) => (value - mean) / norm);
}

/** The square around a place, between pixels. @param {Picture} picture @param {number} x
 * @param {number} y @param {number} half */
function squareAt(picture, x, y, half) {
  const [left, top] = [Math.floor(x - 0.5), Math.floor(y - 0.5)];
  const [right, low] = [x - 0.5 - left, y - 0.5 - top];
  const side = 2 * half + 1;
  return Float64Array.from({ length: side * side }, (_, i) => {
    const [column, row] = [left + (i % side) - half, top + Math.floor(i / side) - half];
    const line = (/** @type {number} */ y1) =>
      (1 - right) * lumaAt(picture, column, y1) + right * lumaAt(picture, column + 1, y1);
    return (1 - low) * line(row) + low * line(row + 1);
  });
}

/**
 * The pattern at a place; null where all is flat.
 * @param {Picture} picture @param {number} x @param {number} y
 */
export function pickPattern(picture, x, y) {
  const half = Math.max(6, Math.round(picture.height / 36));
  const square = normed(squareAt(picture, x, y, half));
  return square && { wanted: { half, first: square, square }, found: { x, y, mass: 1 } };
}

/** Correlations with the pattern at all pixels around one, in rows. @param {Picture} picture
 * @param {Pattern} wanted @param {number} x @param {number} y @param {number} far */
function correlations(picture, { half, square }, x, y, far) {
  const [side, wide] = [2 * half + 1, 2 * (far + half) + 1];
  const luma = Float64Array.from({ length: wide * wide }, (_, i) =>
    lumaAt(picture, x - far - half + (i % wide), y - far - half + Math.floor(i / wide)),
  );
  return Float64Array.from({ length: (2 * far + 1) ** 2 }, (_, place) => {
    const begin = Math.floor(place / (2 * far + 1)) * wide + (place % (2 * far + 1));
    let [sum, squares, both] = [0, 0, 0];
    for (let row = 0, i = 0; row < side; row++)
      for (let at = begin + row * wide, end = at + side; at < end; at++, i++) {
        sum += luma[at];
        squares += luma[at] * luma[at];
        both += luma[at] * square[i];
      }
    return both / Math.sqrt(Math.max(1, squares - (sum * sum) / square.length));
  });
}

/** Between three values the place of the parabola's top. @param {number} a @param {number} b
 * @param {number} c */
const top = (a, b, c) => (a < b && c < b ? (a - c) / (2 * (a - 2 * b + c)) : 0);

/**
 * Where the pattern is in a picture: near a place, else further around it; null where it is not.
 * @param {Picture} picture @param {Pattern} wanted @param {{x: number, y: number}} near
 */
export function followPattern(picture, wanted, near) {
  const { half, first, square } = wanted;
  const [x, y] = [Math.floor(near.x), Math.floor(near.y)];
  for (const times of [NEAR, FAR]) {
    const far = Math.round(times * half);
    const side = 2 * far + 1;
    const all = correlations(picture, wanted, x, y, far);
    const best = all.reduce((most, value, i) => (value > all[most] ? i : most), 0);
    if (all[best] < LEAST) continue;
    const found = {
      x: x - far + (best % side) + 0.5 + top(all[best - 1], all[best], all[best + 1]),
      y:
        y -
        far +
        Math.floor(best / side) +
        0.5 +
        top(all[best - side], all[best], all[best + side]),
      mass: 1,
    };
    const now = normed(squareAt(picture, found.x, found.y, half)) ?? square;
    const mixed = square.map((old, i) => OLD * old + NEW * now[i] + (1 - OLD - NEW) * first[i]);
    wanted.square = normed(mixed, 0) ?? square;
    return found;
  }
  return null;
}

/** How a tip is tracked from its mark on. @type {Record<string, {pick: any, follow: any}>} */
export const TRACKERS = {
  colour: { pick: pickColour, follow: followColour },
  pattern: { pick: pickPattern, follow: followPattern },
};
