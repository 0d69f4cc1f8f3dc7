// Draws a map of flips: its points, its axes in degrees, the scale of its colours, a cross at the
// point that is chosen.
// Leaves to others: its numbers (flips.js), when to draw and what a point does (flipmap.js).
// Invariant: a point's colour is its number's; the scale goes by logarithms, and shows that.

import { earliest } from "./flips.js";
import { cssValue } from "./kit.js";

const MARGIN = { left: 48, bottom: 40, top: 8, right: 10 };
const WIDEST = 520;
const TICKS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const FAILED = [128, 128, 128];
// even steps in lightness for every kind of colour vision (viridis)
const SHADES = [
  [68, 1, 84],
  [71, 44, 122],
  [59, 81, 139],
  [44, 113, 142],
  [33, 144, 141],
  [39, 173, 129],
  [92, 200, 99],
  [170, 220, 50],
  [253, 231, 37],
];

/** @typedef {import("./flips.js").FlipMap} FlipMap */

/**
 * How large it is drawn: the side of its square, all of it, and how fine.
 * @typedef {{side: number, width: number, height: number, ratio: number}} Size
 */

/** @typedef {{context: CanvasRenderingContext2D, map: FlipMap, size: Size, text: Text}} Drawing */

/** @param {number} share of the scale @returns {number[]} red, green, blue */
export function shade(share) {
  const at = Math.max(0, Math.min(1, share)) * (SHADES.length - 1);
  const i = Math.min(Math.floor(at), SHADES.length - 2);
  return SHADES[i].map((from, c) => Math.round(from + (at - i) * (SHADES[i + 1][c] - from)));
}

/**
 * Makes the canvas as large as its place allows.
 * @param {HTMLCanvasElement} canvas @param {number} wide @returns {Size}
 */
export function fitCanvas(canvas, wide) {
  const width = Math.min(wide, WIDEST);
  const ratio = Math.min(devicePixelRatio, 2);
  const side = width - MARGIN.left - MARGIN.right;
  const height = side + MARGIN.top + MARGIN.bottom + 54;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  return { side, width, height, ratio };
}

/** The map's points, one pixel each. @param {FlipMap} map @param {boolean} dark */
export function imageOf(map, dark) {
  const { count, times, failed } = map;
  const image = new ImageData(count, count);
  const low = Math.log(earliest(map));
  const high = Math.log(map.duration);
  const never = dark ? [31, 36, 45] : [255, 255, 255];
  const colourOf = (/** @type {number} */ i) => {
    if (failed[i]) return FAILED;
    if (times[i] < 0) return never;
    return shade((Math.log(Math.max(times[i], 1e-9)) - low) / (high - low));
  };
  for (let i = 0; i < map.done; i++) {
    const to = 4 * ((count - 1 - Math.floor(i / count)) * count + (i % count));
    image.data.set(colourOf(i), to);
    image.data[to + 3] = 255;
  }
  return image;
}

/**
 * The point under a pointer, null beside the map.
 * @param {{count: number}} map @param {Size} size @param {number} x @param {number} y pixels
 */
export function pointAt({ count }, { side }, x, y) {
  const i = Math.floor(((x - MARGIN.left) / side) * count);
  const j = count - 1 - Math.floor(((y - MARGIN.top) / side) * count);
  return i >= 0 && j >= 0 && i < count && j < count ? { i, j } : null;
}

/** @param {Drawing} drawing */
function axesWithNames({ context, map, size, text }) {
  const bottom = MARGIN.top + size.side;
  context.fillStyle = cssValue("--quiet");
  context.font = "11px system-ui, sans-serif";
  const at = (/** @type {number} */ angle) => ((angle + 180) / 360) * size.side;
  for (const angle of [-180, -90, 0, 90, 180]) {
    const words = `${text.short(angle)}\u00b0`;
    const ends = angle === -180 ? "left" : "center";
    context.textAlign = angle === 180 ? "right" : ends;
    context.fillText(words, MARGIN.left + at(angle), bottom + 14);
    context.textAlign = "right";
    context.fillText(words, MARGIN.left - 5, Math.max(bottom - at(angle) + 4, MARGIN.top + 9));
  }
  context.textAlign = "center";
  const across = text("compare.axisX", { arm: map.across });
  context.fillText(across, MARGIN.left + size.side / 2, bottom + 30);
  context.save();
  context.translate(10, MARGIN.top + size.side / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(text("compare.axisY", { arm: map.up }), 0, 0);
  context.restore();
}

/**
 * Numbers and strokes under the scale.
 * @param {Drawing} drawing @param {number} y @param {number} wide pixels
 */
function ticks({ context, map, text }, y, wide) {
  const low = earliest(map);
  const inside = (/** @type {number} */ time) => time >= low && time <= map.duration;
  const at = (/** @type {number} */ time) =>
    MARGIN.left + (Math.log(time / low) / Math.log(map.duration / low)) * wide;
  context.fillStyle = cssValue("--quiet");
  context.textAlign = "center";
  for (const time of TICKS.filter(inside)) context.fillText(text.short(time), at(time), y + 24);
  // every digit has its stroke, which shows that the scale is one of logarithms
  for (const power of [0.01, 0.1, 1, 10]) {
    for (let digit = 1; digit < 10; digit++) {
      const time = digit * power;
      if (inside(time)) context.fillRect(at(time) - 0.5, y + 9, 1, TICKS.includes(time) ? 5 : 3);
    }
  }
}

/** @param {Drawing} drawing */
function scaleWithTicks(drawing) {
  const { context, size, text } = drawing;
  const y = MARGIN.top + size.side + MARGIN.bottom;
  const wide = size.side - 70;
  for (let x = 0; x < wide; x++) {
    context.fillStyle = `rgb(${shade(x / wide).join(",")})`;
    context.fillRect(MARGIN.left + x, y, 1.5, 9);
  }
  ticks(drawing, y, wide);
  context.fillText(text("compare.neverShort"), MARGIN.left + wide + 42, y + 24);
  context.textAlign = "left";
  context.fillText(text("compare.scale"), MARGIN.left, y + 40);
  context.strokeStyle = cssValue("--quiet");
  context.lineWidth = 1;
  context.strokeRect(MARGIN.left + wide + 32.5, y + 0.5, 20, 8);
}

/** @param {Drawing} drawing @param {import("./flips.js").Point} point */
function cross({ context, map, size }, { i, j }) {
  const x = MARGIN.left + ((i + 0.5) / map.count) * size.side;
  const y = MARGIN.top + ((map.count - 0.5 - j) / map.count) * size.side;
  for (const [colour, width] of /** @type {[string, number][]} */ ([
    ["#000", 3.5],
    ["#fff", 1.5],
  ])) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.moveTo(x - 11, y);
    context.lineTo(x - 6, y);
    context.moveTo(x + 6, y);
    context.lineTo(x + 11, y);
    context.stroke();
  }
}

/**
 * All of it; `picture` has the map's points, one pixel each.
 * @param {Drawing} drawing @param {HTMLCanvasElement} picture @param {import("./flips.js").Point}
 * chosen
 */
export function drawMap(drawing, picture, chosen) {
  const { context, size } = drawing;
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  context.clearRect(0, 0, size.width, size.height);
  context.imageSmoothingEnabled = false;
  context.drawImage(picture, MARGIN.left, MARGIN.top, size.side, size.side);
  context.strokeStyle = cssValue("--line");
  context.strokeRect(MARGIN.left - 0.5, MARGIN.top - 0.5, size.side + 1, size.side + 1);
  axesWithNames(drawing);
  scaleWithTicks(drawing);
  cross(drawing, chosen);
}
