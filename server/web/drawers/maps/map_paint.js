// Draws a map: its points, its axes with units, the scale of its colours, a cross at the point that
// is chosen.
// Leaves to others: its numbers (map_numbers.js), when to draw and what a point does (map.js).
// Invariant: a point's colour is its number's; row 0 is at the bottom; a scale that goes by
// logarithms shows that.

import { cssValue, figure } from "../kit/kit.js";
import { scaleOfMap } from "./map_numbers.js";

const MARGIN = { left: 48, bottom: 40, top: 8, right: 10 };
const TOP_LINE = MARGIN.top + 9; // where words stand that would reach above
const WIDEST = 520;
const FAILED = [128, 128, 128];
const TICKS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

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

/** @typedef {import("./map_numbers.js").NumberMap} NumberMap */
/** @typedef {import("./map_numbers.js").Point} Point */

/**
 * How large it is drawn: the side of its square, all of it, and how fine.
 * @typedef {{side: number, width: number, height: number, ratio: number}} Size
 */

/**
 * @typedef {{context: CanvasRenderingContext2D, map: NumberMap, size: Size, text: Text}} Drawing
 */

/** @param {number} share of the scale @returns {number[]} red, green, blue */
function shade(share) {
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

/**
 * The point under a pointer, null beside the map.
 * @param {HTMLCanvasElement} canvas @param {{count: number}} map @param {Size} size
 * @param {MouseEvent} event @returns {Point | null}
 */
export function pointUnder(canvas, { count }, { side }, event) {
  const box = canvas.getBoundingClientRect();
  const i = Math.floor(((event.clientX - box.left - MARGIN.left) / side) * count);
  const j = count - 1 - Math.floor(((event.clientY - box.top - MARGIN.top) / side) * count);
  return i >= 0 && j >= 0 && i < count && j < count ? { i, j } : null;
}

/** The map's points, one pixel each. @param {NumberMap} map @param {boolean} dark */
export function imageOf(map, dark) {
  const { count, done, failed, values } = map;
  const { share } = scaleOfMap(map);
  const image = new ImageData(count, count);
  const none = dark ? [31, 36, 45] : [255, 255, 255];
  for (let i = 0; i < done; i++) {
    const to = 4 * ((count - 1 - Math.floor(i / count)) * count + (i % count));
    const told = Number.isNaN(values[i]) ? none : shade(share(values[i]));
    image.data.set(failed[i] ? FAILED : told, to);
    image.data[to + 3] = 255;
  }
  return image;
}

/** @param {Drawing} drawing */
function axes({ context, map, size, text }) {
  const bottom = MARGIN.top + size.side;
  const [across, up] = map.axes.map(({ words, unit, marks, ends: [low, high] }) => ({
    name: `${words(text)}, ${unit}`,
    marks: Array.from({ length: marks }, (_, i) => {
      const share = i / (marks - 1);
      return { share, words: figure(text, low + (high - low) * share, 3) };
    }),
  }));
  context.fillStyle = cssValue("--quiet");
  context.font = "11px system-ui, sans-serif";
  for (const { share, words } of across.marks) {
    const ends = share ? "right" : "left";
    context.textAlign = share > 0 && share < 1 ? "center" : ends;
    context.fillText(words, MARGIN.left + share * size.side, bottom + 14);
  }
  context.textAlign = "right";
  // the name of the axis may stand beside its middle
  for (const { share, words } of up.marks.filter((one) => one.share !== 0.5 || up.marks.length > 3))
    context.fillText(words, MARGIN.left - 5, Math.max(bottom - share * size.side + 4, TOP_LINE));
  context.textAlign = "center";
  context.fillText(across.name, MARGIN.left + size.side / 2, bottom + 30);
  context.save();
  context.translate(10, MARGIN.top + size.side / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(up.name, 0, 0);
  context.restore();
}

/** The colours of the scale, below the axes. @param {Drawing} drawing */
function scale({ context, map, size: { side }, text }) {
  const y = MARGIN.top + side + MARGIN.bottom;
  const { low, high, log, share } = scaleOfMap(map);
  for (let x = 0; x < side; x++) {
    context.fillStyle = `rgb(${shade(x / side).join(",")})`;
    context.fillRect(MARGIN.left + x, y, 1.5, 9);
  }
  context.fillStyle = cssValue("--quiet");
  const inside = (/** @type {number} */ value) => value >= low && value <= high;
  const at = (/** @type {number} */ value) => MARGIN.left + share(value) * side;
  const told = log ? TICKS.filter(inside) : [low, high];
  for (const value of told) {
    const ends = value === low ? "left" : "right";
    context.textAlign = value === low || value === high ? ends : "center";
    context.fillText(figure(text, value, 3), at(value), y + 22);
  }
  // every digit has its stroke, which shows that the scale is one of logarithms
  for (let power = 0.01; log && power < high; power *= 10) {
    for (let digit = 1; digit < 10; digit++)
      if (inside(digit * power)) context.fillRect(at(digit * power) - 0.5, y + 9, 1, 3);
  }
  context.textAlign = "center";
  context.fillText(text(`map.${map.what}.scale`), MARGIN.left + side / 2, y + 36);
}

/**
 * @param {CanvasRenderingContext2D} context @param {number} count @param {Size} size
 * @param {Point} point
 */
function drawCross(context, count, size, { i, j }) {
  const x = MARGIN.left + ((i + 0.5) / count) * size.side;
  const y = MARGIN.top + ((count - 0.5 - j) / count) * size.side;
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
 * @param {Drawing} drawing @param {HTMLCanvasElement} picture @param {Point} chosen
 */
export function paintMap(drawing, picture, chosen) {
  const { context, size, map } = drawing;
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  context.clearRect(0, 0, size.width, size.height);
  context.imageSmoothingEnabled = false;
  context.drawImage(picture, MARGIN.left, MARGIN.top, size.side, size.side);
  context.lineWidth = 1;
  context.strokeStyle = cssValue("--line");
  context.strokeRect(MARGIN.left - 0.5, MARGIN.top - 0.5, size.side + 1, size.side + 1);
  axes(drawing);
  scale(drawing);
  drawCross(context, map.count, size, chosen);
}
