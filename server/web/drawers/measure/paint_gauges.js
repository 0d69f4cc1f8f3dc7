// The strokes of the ruler and the protractor: marks with numbers, legs with degrees between them,
// and what they read.
// Leaves to others: where they lie (gauge_numbers.js), their handles (gauges.js).
// Invariant: every line has an outline, which keeps it apart from arms and trails.

import { phiOf } from "../../angles.js";
import { protractorReads, roundStep } from "./gauge_numbers.js";

export const LEG = 96; // pixels of a leg of the protractor
const ARC = 62; // pixels: the radius of the degrees
const FINE = 6; // pixels, least distance of two marks
const NUMBERED = 46; // pixels, least distance of two numbers

/** @typedef {CanvasRenderingContext2D} Context */

/** A place in pixels. @param {Camera} camera @param {number} x @param {number} y */
export const pixelOf = (camera, x, y) => ({
  x: camera.x + camera.scale * x,
  y: camera.y - camera.scale * y,
});

/**
 * Strokes a path, with an outline.
 * @param {Context} context @param {Colours} colours @param {string} ink @param {number} width
 * @param {() => void} path
 */
function stroke(context, colours, ink, width, path) {
  context.lineCap = context.lineJoin = "round";
  context.beginPath();
  path();
  context.strokeStyle = colours.paper;
  context.lineWidth = width + 4;
  context.stroke();
  context.strokeStyle = ink;
  context.lineWidth = width;
  context.stroke();
}

/**
 * @param {Context} context @param {Colours} colours @param {string} words @param {number} x
 * @param {number} y
 */
function write(context, colours, words, x, y) {
  context.strokeStyle = colours.paper;
  context.lineWidth = 4;
  context.strokeText(words, x, y);
  context.fillStyle = colours.ink;
  context.fillText(words, x, y);
}

/**
 * A ruler from A to B, with its length beside it.
 * @param {Context} context @param {Look} look @param {number[]} ruler @param {string} reading
 * @param {Text} text
 */
export function paintRuler(context, { camera, colours }, [ax, ay, bx, by], reading, text) {
  const [a, b] = [pixelOf(camera, ax, ay), pixelOf(camera, bx, by)];
  const long = Math.hypot(b.x - a.x, b.y - a.y);
  if (!(long > 1)) return;
  const [dx, dy] = [(b.x - a.x) / long, (b.y - a.y) / long];
  const fine = roundStep(FINE / camera.scale);
  const numbered = Math.max(1, Math.round(roundStep(NUMBERED / camera.scale) / fine));
  const count = Math.floor(long / (fine * camera.scale) + 1e-6);
  // a ruler may be far longer than the stage: only marks that may be seen are drawn
  const { clientWidth, clientHeight } = context.canvas;
  const middle = dx * (clientWidth / 2 - a.x) + dy * (clientHeight / 2 - a.y);
  const around = Math.hypot(clientWidth, clientHeight) / 2 + NUMBERED;
  const first = Math.max(0, Math.ceil((middle - around) / (fine * camera.scale)));
  const last = Math.min(count, Math.floor((middle + around) / (fine * camera.scale)));
  // marks on the upper side, numbers beyond them
  const [nx, ny] = dx < 0 ? [-dy, dx] : [dy, -dx];
  const mark = (/** @type {number} */ i) => {
    const at = i * fine * camera.scale;
    return { x: a.x + dx * at, y: a.y + dy * at };
  };
  stroke(context, colours, colours.ink, 1.5, () => {
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
    for (let i = first; i <= last; i++) {
      const { x, y } = mark(i);
      const tall = i % numbered === 0 ? 12 : 6;
      context.moveTo(x, y);
      context.lineTo(x + nx * tall, y + ny * tall);
    }
  });
  context.font = colours.font;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let i = Math.ceil(first / numbered) * numbered; i <= last; i += numbered) {
    const { x, y } = mark(i);
    write(context, colours, text.short(i * fine, 3), x + nx * 22, y + ny * 22);
  }
  context.font = `600 ${colours.font}`;
  write(context, colours, reading, (a.x + b.x) / 2 - nx * 20, (a.y + b.y) / 2 - ny * 20);
}

/**
 * A protractor: two legs, degrees from the first to the second, and the angle between them.
 * @param {Context} context @param {Look} look @param {number[]} protractor @param {string} reading
 */
export function paintProtractor(context, { camera, colours }, protractor, reading) {
  const [cx, cy, from, to] = protractor;
  const angle = protractorReads(protractor);
  const { x, y } = pixelOf(camera, cx, cy);
  /** @param {number} theta @param {number} inner @param {number} outer */
  const ray = (theta, inner, outer) => {
    const phi = phiOf(theta);
    context.moveTo(x + inner * Math.cos(phi), y - inner * Math.sin(phi));
    context.lineTo(x + outer * Math.cos(phi), y - outer * Math.sin(phi));
  };
  stroke(context, colours, colours.quiet, 1, () => {
    for (let degrees = 0; degrees < 360; degrees += 10)
      ray(from + degrees, degrees % 90 ? ARC - 5 : ARC - 10, ARC);
  });
  stroke(context, colours, colours.accent, 2, () => {
    ray(from, 0, LEG);
    ray(to, 0, LEG);
    context.moveTo(x + ARC * Math.cos(phiOf(from)), y - ARC * Math.sin(phiOf(from)));
    // a canvas counts angles clockwise
    context.arc(x, y, ARC, -phiOf(from), -phiOf(from + angle), angle > 0);
  });
  const middle = phiOf(from + angle / 2);
  context.font = `600 ${colours.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const far = ARC + 26;
  write(context, colours, reading, x + far * Math.cos(middle), y - far * Math.sin(middle));
}
