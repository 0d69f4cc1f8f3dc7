// Draws a map of flips: its points, its axes in degrees, the scale of its colours, a cross at the
// point that is chosen.
// Leaves to others: its numbers (flips.js), when to draw and what a point does (flipmap.js).
// Invariant: a point's colour is its number's; the scale goes by logarithms, and shows that.

import { earliest } from "./flips.js";
import { cssValue } from "../kit/kit.js";
import { MARGIN, drawCross, drawNames, drawPoints, drawScale, pixelsOf } from "./map_frame.js";

const TICKS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];

/** @typedef {import("./flips.js").FlipMap} FlipMap */

/** @typedef {import("./map_frame.js").Size} Size */
/** @typedef {{context: CanvasRenderingContext2D, map: FlipMap, size: Size, text: Text}} Drawing */

/** The map's points, one pixel each. @param {FlipMap} map @param {boolean} dark */
export function imageOf(map, dark) {
  const { times } = map;
  const low = Math.log(earliest(map));
  const high = Math.log(map.duration);
  const shareOf = (/** @type {number} */ i) =>
    times[i] < 0 ? null : (Math.log(Math.max(times[i], 1e-9)) - low) / (high - low);
  return pixelsOf(map, dark, shareOf);
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
  const across = text("compare.axisX", { arm: map.across });
  drawNames(context, size, across, text("compare.axisY", { arm: map.up }));
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
  drawScale(context, y, wide);
  ticks(drawing, y, wide);
  context.fillText(text("compare.neverShort"), MARGIN.left + wide + 42, y + 24);
  context.textAlign = "left";
  context.fillText(text("compare.scale"), MARGIN.left, y + 40);
  context.strokeStyle = cssValue("--quiet");
  context.lineWidth = 1;
  context.strokeRect(MARGIN.left + wide + 32.5, y + 0.5, 20, 8);
}

/**
 * All of it; `picture` has the map's points, one pixel each.
 * @param {Drawing} drawing @param {HTMLCanvasElement} picture @param {import("./flips.js").Point}
 * chosen
 */
export function drawMap(drawing, picture, chosen) {
  const { context, size, map } = drawing;
  drawPoints(context, size, picture);
  axesWithNames(drawing);
  scaleWithTicks(drawing);
  drawCross(context, map.count, size, chosen);
}
