// Draws a map of two numbers: its points, its axes with units, the scale of its colours, a cross at
// the point that is chosen.
// Leaves to others: its numbers (map_numbers.js), when to draw and what a point does
// (param_map.js).
// Invariant: a point's colour is its number's.

import { fitCanvas, pointAt, shade } from "./flipmap_paint.js";
import { cssValue, figure } from "./kit.js";
import { AXES, nameOf, scaleOfMap, valueAt } from "./map_numbers.js";

export { fitCanvas, pointAt };

const LEFT = 48;
const TOP = 8;
const FAILED = [128, 128, 128];

/** @typedef {import("./map_numbers.js").NumberMap} NumberMap */
/** @typedef {import("./flipmap_paint.js").Size} Size */

/**
 * @typedef {{context: CanvasRenderingContext2D, map: NumberMap, size: Size, text: Text}} Drawing
 */

/** The map's points, one pixel each. @param {NumberMap} map @param {boolean} dark */
export function imageOf(map, dark) {
  const { count, values, failed, done } = map;
  const image = new ImageData(count, count);
  const [low, high] = scaleOfMap(map);
  const none = dark ? [31, 36, 45] : [255, 255, 255];
  for (let i = 0; i < done; i++) {
    const to = 4 * ((count - 1 - Math.floor(i / count)) * count + (i % count));
    const told = Number.isNaN(values[i]) ? none : shade((values[i] - low) / (high - low));
    image.data.set(failed[i] ? FAILED : told, to);
    image.data[to + 3] = 255;
  }
  return image;
}

/** @param {Drawing} drawing */
function axes({ context, map, size, text }) {
  const bottom = TOP + size.side;
  context.fillStyle = cssValue("--quiet");
  context.font = "11px system-ui, sans-serif";
  const name = (/** @type {string} */ one) => `${nameOf(text, one)}, ${AXES[one].field.unit}`;
  for (const share of [0, 0.5, 1]) {
    const place = Math.round(share * (map.count - 1));
    const ends = share ? "right" : "left";
    context.textAlign = share === 0.5 ? "center" : ends;
    const x = figure(text, valueAt(map, map.across, place), 3);
    context.fillText(x, LEFT + share * size.side, bottom + 14);
    // the name of the axis stands beside its middle
    if (share === 0.5) continue;
    context.textAlign = "right";
    const y = figure(text, valueAt(map, map.up, place), 3);
    context.fillText(y, LEFT - 5, Math.max(bottom - share * size.side + 4, TOP + 9));
  }
  context.textAlign = "center";
  context.fillText(name(map.across), LEFT + size.side / 2, bottom + 30);
  context.save();
  context.translate(10, TOP + size.side / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(name(map.up), 0, 0);
  context.restore();
}

/** @param {Drawing} drawing */
function scale({ context, map, size, text }) {
  const y = TOP + size.side + 40;
  const [low, high] = scaleOfMap(map);
  for (let x = 0; x < size.side; x++) {
    context.fillStyle = `rgb(${shade(x / size.side).join(",")})`;
    context.fillRect(LEFT + x, y, 1.5, 9);
  }
  context.fillStyle = cssValue("--quiet");
  context.textAlign = "left";
  context.fillText(figure(text, low, 3), LEFT, y + 22);
  context.textAlign = "right";
  context.fillText(figure(text, high, 3), LEFT + size.side, y + 22);
  context.textAlign = "center";
  context.fillText(text(`map.${map.what}.scale`), LEFT + size.side / 2, y + 36);
}

/** @param {Drawing} drawing @param {{i: number, j: number}} point */
function cross({ context, map, size }, { i, j }) {
  const x = LEFT + ((i + 0.5) / map.count) * size.side;
  const y = TOP + ((map.count - 0.5 - j) / map.count) * size.side;
  for (const [colour, width] of /** @type {[string, number][]} */ ([
    ["#000", 3.5],
    ["#fff", 1.5],
  ])) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.stroke();
  }
}

/**
 * All of it; `picture` has the map's points, one pixel each.
 * @param {Drawing} drawing @param {HTMLCanvasElement} picture
 * @param {{i: number, j: number}} chosen
 */
export function paintMap(drawing, picture, chosen) {
  const { context, size } = drawing;
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  context.clearRect(0, 0, size.width, size.height);
  context.imageSmoothingEnabled = false;
  context.drawImage(picture, LEFT, TOP, size.side, size.side);
  context.strokeStyle = cssValue("--line");
  context.strokeRect(LEFT - 0.5, TOP - 0.5, size.side + 1, size.side + 1);
  axes(drawing);
  scale(drawing);
  cross(drawing, chosen);
}
