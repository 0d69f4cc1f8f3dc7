// What the maps have in common, whose points are pendulums: their parts, the keys and the pointer
// that go over them, asking strip by strip, their square with its frame, axes' names and cross.
// Leaves to others: what a point means, its colour and its words (flips.js, map_numbers.js).
// Invariant: row 0 is at the bottom.

import { h } from "../../dom.js";
import { cssValue } from "../kit/kit.js";

export const MARGIN = { left: 48, bottom: 40, top: 8, right: 10 };
const WIDEST = 520;
const FAR = 10; // points that an arrow key goes with shift
const FAILED = [128, 128, 128];

/** By how many points the arrow keys go. @type {Record<string, [number, number]>} */
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

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

/** @typedef {{i: number, j: number}} Point */

/**
 * How large it is drawn: the side of its square, all of it, and how fine.
 * @typedef {{side: number, width: number, height: number, ratio: number}} Size
 */

/** @typedef {{count: number, done: number, failed: ArrayLike<number | boolean>}} Points */

/**
 * The parts of the page that show a map.
 * @param {string} label of the picture @param {string} title @param {string} id of the words
 */
export function partsOf(label, title, id) {
  const named = { "aria-label": label, "aria-describedby": id };
  const canvas = h("canvas", { class: "map", tabindex: 0, role: "application", ...named });
  const point = h("p", { class: "map-point", id, role: "status" });
  return {
    canvas,
    point,
    status: h("p", { class: "quiet", role: "status" }),
    bar: h("progress", { max: 1, value: 0, hidden: true, "aria-label": title }),
    place: h("div", { hidden: true }, canvas, point),
    controls: h("div", { class: "row" }),
  };
}

/**
 * What there is to choose from: points a side, seconds.
 * @param {Text} text @param {number[]} sizes @param {number[]} durations
 */
export function optionsOf(text, sizes, durations) {
  return {
    sizes: sizes.map((value) => ({ value, words: text("compare.pointsValue", { count: value }) })),
    spans: durations.map((value) => ({ value, words: text("compare.seconds", { time: value }) })),
  };
}

/**
 * Where a key leads to, null where it is no arrow.
 * @param {KeyboardEvent} event @param {Point} from @param {number} count
 */
export function moved(event, from, count) {
  const move = MOVES[event.key];
  if (!move) return null;
  const far = event.shiftKey ? FAR : 1;
  const within = (/** @type {number} */ value) => Math.max(0, Math.min(count - 1, value));
  return { i: within(from.i + far * move[0]), j: within(from.j + far * move[1]) };
}

/**
 * The point under a pointer, null beside the map.
 * @param {HTMLCanvasElement} canvas @param {{count: number}} map @param {Size} size
 * @param {MouseEvent} event
 */
export function pointUnder(canvas, { count }, { side }, event) {
  const box = canvas.getBoundingClientRect();
  const i = Math.floor(((event.clientX - box.left - MARGIN.left) / side) * count);
  const j = count - 1 - Math.floor(((event.clientY - box.top - MARGIN.top) / side) * count);
  return i >= 0 && j >= 0 && i < count && j < count ? { i, j } : null;
}

/**
 * Asks for all rows, so many motions a request, one request after the other.
 * @param {number} count of rows @param {number} strip motions a request, about
 * @param {(row: number, rows: number) => Promise<void>} ask
 */
export async function stripByStrip(count, strip, ask) {
  const rows = Math.max(1, Math.round(strip / count));
  for (let row = 0; row < count; row += rows) await ask(row, Math.min(rows, count - row));
}

/**
 * Shows how far a map is.
 * @param {{bar: HTMLProgressElement, status: HTMLElement}} parts @param {Points} map
 * @param {Text} text
 */
export function tellProgress({ bar, status }, map, text) {
  const all = map.count ** 2;
  bar.value = map.done / all;
  const percent = Math.floor((100 * map.done) / all);
  status.textContent = text("compare.progress", { percent, count: all });
}

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

/**
 * The map's points, one pixel each; a share of null is that of a point of which there is nothing
 * to tell.
 * @param {Points} map @param {boolean} dark @param {(i: number) => number | null} shareOf
 */
export function pixelsOf(map, dark, shareOf) {
  const { count, done, failed } = map;
  const image = new ImageData(count, count);
  const none = dark ? [31, 36, 45] : [255, 255, 255];
  for (let i = 0; i < done; i++) {
    const to = 4 * ((count - 1 - Math.floor(i / count)) * count + (i % count));
    const share = failed[i] ? null : shareOf(i);
    const told = share === null ? none : shade(share);
    image.data.set(failed[i] ? FAILED : told, to);
    image.data[to + 3] = 255;
  }
  return image;
}

/**
 * Empties the canvas and draws the points with a line about them.
 * @param {CanvasRenderingContext2D} context @param {Size} size @param {HTMLCanvasElement} picture
 */
export function drawPoints(context, size, picture) {
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  context.clearRect(0, 0, size.width, size.height);
  context.imageSmoothingEnabled = false;
  context.drawImage(picture, MARGIN.left, MARGIN.top, size.side, size.side);
  context.strokeStyle = cssValue("--line");
  context.strokeRect(MARGIN.left - 0.5, MARGIN.top - 0.5, size.side + 1, size.side + 1);
}

/**
 * @param {CanvasRenderingContext2D} context @param {Size} size
 * @param {string} across @param {string} up
 */
export function drawNames(context, size, across, up) {
  context.textAlign = "center";
  context.fillText(across, MARGIN.left + size.side / 2, MARGIN.top + size.side + 30);
  context.save();
  context.translate(10, MARGIN.top + size.side / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(up, 0, 0);
  context.restore();
}

/**
 * The colours of the scale, below the axes.
 * @param {CanvasRenderingContext2D} context @param {number} y @param {number} wide pixels
 */
export function drawScale(context, y, wide) {
  for (let x = 0; x < wide; x++) {
    context.fillStyle = `rgb(${shade(x / wide).join(",")})`;
    context.fillRect(MARGIN.left + x, y, 1.5, 9);
  }
  context.fillStyle = cssValue("--quiet");
}

/**
 * @param {CanvasRenderingContext2D} context @param {number} count @param {Size} size
 * @param {Point} point
 */
export function drawCross(context, count, size, { i, j }) {
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
