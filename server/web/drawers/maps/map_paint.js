// Draws a map of two numbers: its points, its axes with units, the scale of its colours, a cross at
// the point that is chosen.
// Leaves to others: its numbers (map_numbers.js), when to draw and what a point does
// (param_map.js).
// Invariant: a point's colour is its number's.

import { cssValue, figure } from "../kit/kit.js";
import { MARGIN, drawCross, drawNames, drawPoints, drawScale, pixelsOf } from "./map_frame.js";
import { AXES, nameOf, scaleOfMap, valueAt } from "./map_numbers.js";

/** @typedef {import("./map_numbers.js").NumberMap} NumberMap */
/** @typedef {import("./map_frame.js").Size} Size */

/**
 * @typedef {{context: CanvasRenderingContext2D, map: NumberMap, size: Size, text: Text}} Drawing
 */

/** The map's points, one pixel each. @param {NumberMap} map @param {boolean} dark */
export function imageOf(map, dark) {
  const [low, high] = scaleOfMap(map);
  const { values } = map;
  return pixelsOf(map, dark, (i) =>
    Number.isNaN(values[i]) ? null : (values[i] - low) / (high - low),
  );
}

/** @param {Drawing} drawing */
function axes({ context, map, size, text }) {
  const bottom = MARGIN.top + size.side;
  context.fillStyle = cssValue("--quiet");
  context.font = "11px system-ui, sans-serif";
  const name = (/** @type {string} */ one) => `${nameOf(text, one)}, ${AXES[one].field.unit}`;
  for (const share of [0, 0.5, 1]) {
    const place = Math.round(share * (map.count - 1));
    const ends = share ? "right" : "left";
    context.textAlign = share === 0.5 ? "center" : ends;
    const x = figure(text, valueAt(map, map.across, place), 3);
    context.fillText(x, MARGIN.left + share * size.side, bottom + 14);
    // the name of the axis stands beside its middle
    if (share === 0.5) continue;
    context.textAlign = "right";
    const y = figure(text, valueAt(map, map.up, place), 3);
    context.fillText(y, MARGIN.left - 5, Math.max(bottom - share * size.side + 4, MARGIN.top + 9));
  }
  drawNames(context, size, name(map.across), name(map.up));
}

/** @param {Drawing} drawing */
function scale({ context, map, size, text }) {
  const y = MARGIN.top + size.side + 40;
  const [low, high] = scaleOfMap(map);
  drawScale(context, y, size.side);
  context.textAlign = "left";
  context.fillText(figure(text, low, 3), MARGIN.left, y + 22);
  context.textAlign = "right";
  context.fillText(figure(text, high, 3), MARGIN.left + size.side, y + 22);
  context.textAlign = "center";
  context.fillText(text(`map.${map.what}.scale`), MARGIN.left + size.side / 2, y + 36);
}

/**
 * All of it; `picture` has the map's points, one pixel each.
 * @param {Drawing} drawing @param {HTMLCanvasElement} picture
 * @param {{i: number, j: number}} chosen
 */
export function paintMap(drawing, picture, chosen) {
  const { context, size, map } = drawing;
  drawPoints(context, size, picture);
  axes(drawing);
  scale(drawing);
  drawCross(context, map.count, size, chosen);
}
