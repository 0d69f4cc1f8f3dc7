// A coloured spot followed through the pictures of a film: the weighted middle of what has its
// colour, near where it is expected.
// Leaves to others: the pictures (film_frames.js), what is done with the places (film.js).
// Invariant: a place is told only where enough of the colour is; brightness counts less than hue,
// since light and shadow change it.

const LUMA = 0.35; // of brightness, to a unit of hue
const FIRST = 6; // pixels: the first window's half
const GROWS = 1.05; // times as much colour, while a window is still too small
const ENOUGH = 0.25; // of the colour that the first picture had
const TURNS = 12;

/** @typedef {{data: Uint8ClampedArray, width: number, height: number}} Picture */

/** brightness and two hues; mass: of the spot, in whole pixels; half: of its window, pixels.
 * @typedef {{colour: number[], tolerance: number, mass: number, half: number}} Wanted */

/** @typedef {{x: number, y: number, mass: number}} Found */

/** @param {ArrayLike<number>} data @param {number} i @returns {number[]} */
function hues(data, i) {
  const [red, green, blue] = [data[i], data[i + 1], data[i + 2]];
  const luma = 0.299 * red + 0.587 * green + 0.114 * blue;
  return [luma, 0.564 * (blue - luma), 0.713 * (red - luma)];
}

/** The mean colour around a place. @param {Picture} picture @param {number} x @param {number} y */
function colourAt({ data, width, height }, x, y) {
  const sum = [0, 0, 0];
  let count = 0;
  for (let row = Math.floor(y) - 1; row <= Math.floor(y) + 1; row++)
    for (let column = Math.floor(x) - 1; column <= Math.floor(x) + 1; column++) {
      if (row < 0 || column < 0 || row >= height || column >= width) continue;
      hues(data, 4 * (row * width + column)).forEach((value, k) => (sum[k] += value));
      count++;
    }
  return sum.map((value) => value / count);
}

/**
 * How much of the colour a square holds, and its middle.
 * @param {Picture} picture @param {Wanted} wanted @param {number} x @param {number} y its own
 * middle @param {number} half of its side @returns {Found}
 */
function within({ data, width, height }, { colour, tolerance }, x, y, half) {
  const top = Math.max(0, Math.floor(y - half));
  const left = Math.max(0, Math.floor(x - half));
  const bottom = Math.min(height, Math.ceil(y + half));
  const right = Math.min(width, Math.ceil(x + half));
  let [mass, across, down] = [0, 0, 0];
  for (let row = top; row < bottom; row++)
    for (let column = left; column < right; column++) {
      const [luma, blue, red] = hues(data, 4 * (row * width + column));
      const far = Math.hypot(LUMA * (luma - colour[0]), blue - colour[1], red - colour[2]);
      if (far >= tolerance) continue;
      // what is nearly the colour counts whole, what lies between it and another one in part
      const weight = Math.min(1, 2 - (2 * far) / tolerance);
      mass += weight;
      across += weight * (column + 0.5);
      down += weight * (row + 0.5);
    }
  return mass ? { x: across / mass, y: down / mass, mass } : { x, y, mass: 0 };
}

/**
 * The window moved to the middle of what it holds, until it stays.
 * @param {Picture} picture @param {Wanted} wanted @param {number} x @param {number} y
 * @param {number} half
 */
function settle(picture, wanted, x, y, half) {
  let found = within(picture, wanted, x, y, half);
  for (let turn = 0; turn < TURNS && found.mass; turn++) {
    const before = found;
    found = within(picture, wanted, before.x, before.y, half);
    if (Math.hypot(found.x - before.x, found.y - before.y) < 0.01) break;
  }
  return found;
}

/**
 * The colour at a place, and the spot that has it; null where there is none to speak of.
 * @param {Picture} picture @param {number} x @param {number} y @param {number} tolerance
 * @returns {{wanted: Wanted, found: Found} | null}
 */
export function pickColour(picture, x, y, tolerance) {
  /** @type {Wanted} */
  const wanted = { colour: colourAt(picture, x, y), tolerance, mass: 0, half: FIRST };
  let found = settle(picture, wanted, x, y, wanted.half);
  while (wanted.half < picture.width / 4) {
    const wider = settle(picture, wanted, found.x, found.y, 1.4 * wanted.half);
    const still = wider.mass < GROWS * found.mass;
    found = wider;
    wanted.half *= 1.4;
    if (still) break;
  }
  wanted.mass = found.mass;
  return found.mass >= 3 ? { wanted, found } : null;
}

/** The window of a whole picture that holds most of the colour. @param {Picture} picture
 * @param {Wanted} wanted */
function anywhere(picture, wanted) {
  const { half } = wanted;
  let most = { x: 0, y: 0, mass: 0 };
  for (let y = half; y < picture.height + half; y += half)
    for (let x = half; x < picture.width + half; x += half) {
      const found = within(picture, wanted, x, y, half);
      if (found.mass > most.mass) most = found;
    }
  return settle(picture, wanted, most.x, most.y, half);
}

/**
 * Where the spot is in a picture: near a place, then further around it, then anywhere; null where
 * it is not seen.
 * @param {Picture} picture @param {Wanted} wanted @param {{x: number, y: number}} near
 * @returns {Found | null}
 */
export function followColour(picture, wanted, { x, y }) {
  const { mass, half } = wanted;
  const enough = (/** @type {Found} */ one) => one.mass >= ENOUGH * mass;
  const close = settle(picture, wanted, x, y, half);
  if (enough(close)) return close;
  const wide = within(picture, wanted, x, y, 3 * half);
  const around = settle(picture, wanted, wide.x, wide.y, half);
  if (enough(around)) return around;
  const far = anywhere(picture, wanted);
  return enough(far) ? far : null;
}
