// Draws a pendulum on a canvas: arms in the colours of their forces, tips, arrows, ghosts, words
// beside a tip.
// Leaves to others: where the tips are (tree.js), the colours (palette.js), what is chosen, when to
// draw.
// Invariant: drawing a frame allocates nothing but what the canvas does; arms of one colour are one
// path.

import { BINS, MIDDLE, bin } from "./palette.js";
import { brackets } from "./tree.js";

const ARROW = 120; // pixels of the force at the end of the scale
const BESIDE = 11; // pixels between an arm and the arrow of its force
const LABEL_HEIGHT = 26;

/**
 * A canvas, and room to chain the arms of every colour.
 * @typedef {{context: CanvasRenderingContext2D, heads: Int32Array, next: Int32Array}} Painter
 */

/** @param {CanvasRenderingContext2D} context @returns {Painter} */
export const createPainter = (context) => ({
  context,
  heads: new Int32Array(BINS),
  next: new Int32Array(0),
});

/**
 * Pixels of a place in metres, from the left and from the top.
 * @param {Camera} camera @param {number} x
 */
export const across = (camera, x) => camera.x + camera.scale * x;
/** @param {Camera} camera @param {number} y */
export const down = (camera, y) => camera.y - camera.scale * y;

/**
 * Chains the arms of every colour, in place.
 * @param {Painter} painter @param {ArrayLike<number>} forces @param {number} most @param {number} n
 */
function chain(painter, forces, most, n) {
  if (painter.next.length < n) painter.next = new Int32Array(n);
  painter.heads.fill(-1);
  for (let k = n - 1; k >= 0; k--) {
    const i = bin(forces[k], most);
    painter.next[k] = painter.heads[i];
    painter.heads[i] = k;
  }
}

/**
 * How wide an arm is drawn, in pixels: wider with its force.
 * @param {number} i @param {number} thin
 */
const width = (i, thin) => thin * (1 + (1.9 * Math.abs(i - MIDDLE)) / MIDDLE);

/**
 * Radius of a tip in pixels: by its mass, but a short arm is not to vanish behind it.
 * @param {Shape} shape @param {number} k @param {Camera} camera
 */
function tipRadius({ tree, heaviest, thin }, k, camera) {
  const wanted = Math.max(thin * 1.1, thin * 3 * Math.cbrt(tree.mass[k] / (heaviest || 1)));
  return Math.max(0.6, Math.min(wanted, 0.35 * camera.scale * tree.length[k]));
}

/**
 * Adds an arm to the path: from its joint to its tip.
 * @param {CanvasRenderingContext2D} context @param {Spots} spots @param {Camera} camera
 * @param {number} k
 */
function rod(context, { x, y, fromX, fromY }, camera, k) {
  context.moveTo(across(camera, fromX[k]), down(camera, fromY[k]));
  context.lineTo(across(camera, x[k]), down(camera, y[k]));
}

/** What holds joints beside an arm. @param {Painter} painter @param {Look} look */
export function paintBrackets({ context }, { shape, camera, colours }) {
  context.beginPath();
  brackets(shape.tree, shape, (ax, ay, bx, by) => {
    context.moveTo(across(camera, ax), down(camera, ay));
    context.lineTo(across(camera, bx), down(camera, by));
  });
  context.strokeStyle = colours.quiet;
  context.lineWidth = shape.thin;
  context.stroke();
}

/** @param {Painter} painter @param {Look} look */
export function paintArms(painter, { shape, camera, colours, most }) {
  const { context, heads } = painter;
  chain(painter, shape.lambda, most, shape.n);
  context.lineCap = "round";
  for (let i = 0; i < BINS; i++) {
    if (heads[i] < 0) continue;
    context.beginPath();
    for (let k = heads[i]; k >= 0; k = painter.next[k]) rod(context, shape, camera, k);
    context.strokeStyle = colours.bins[i];
    context.lineWidth = width(i, shape.thin);
    context.stroke();
  }
}

/** @param {Painter} painter @param {Look} look */
export function paintTips({ context }, { shape, camera, colours }) {
  let outlined = false;
  context.beginPath();
  for (let k = 0; k < shape.n; k++) {
    const px = across(camera, shape.x[k]);
    const py = down(camera, shape.y[k]);
    const r = tipRadius(shape, k, camera);
    outlined ||= r > 3;
    context.moveTo(px + r, py);
    context.arc(px, py, r, 0, 2 * Math.PI);
  }
  context.fillStyle = colours.mass;
  context.fill();
  if (!outlined) return;
  context.lineWidth = Math.max(1, shape.thin * 0.5);
  context.strokeStyle = colours.paper;
  context.stroke();
}

/** What the pendulum hangs on. @param {Painter} painter @param {Look} look */
export function paintPivot({ context }, { shape, camera, colours }) {
  const half = 22;
  const x = across(camera, shape.pivot.x);
  const y = down(camera, shape.pivot.y);
  const up = y - 9;
  context.strokeStyle = colours.quiet;
  context.fillStyle = colours.paper;
  context.lineCap = "round";
  context.lineWidth = 1.6;
  context.beginPath();
  context.moveTo(x - half, up);
  context.lineTo(x + half, up);
  context.moveTo(x - 8, up);
  context.lineTo(x, y);
  context.lineTo(x + 8, up);
  context.stroke();
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
}

/**
 * Adds an arrow of so many pixels to the path.
 * @param {CanvasRenderingContext2D} context
 * @param {number} x @param {number} y @param {number} dx @param {number} dy @param {number} pixels
 */
function arrow(context, x, y, dx, dy, pixels) {
  const head = Math.min(9, 3 + pixels * 0.2);
  const tx = x + dx * pixels;
  const ty = y + dy * pixels;
  context.moveTo(x, y);
  context.lineTo(tx, ty);
  context.moveTo(tx - head * (dx + 0.55 * dy), ty - head * (dy - 0.55 * dx));
  context.lineTo(tx, ty);
  context.lineTo(tx - head * (dx - 0.55 * dy), ty - head * (dy + 0.55 * dx));
}

/**
 * At every tip the force that its arm pushes it with.
 * @param {Painter} painter @param {Look} look
 */
export function paintArrows({ context }, { shape, camera, colours, most }) {
  if (!(most > 0)) return;
  const { x, y, phi, lambda } = shape;
  for (let sign = -1; sign <= 1; sign += 2) {
    context.beginPath();
    for (let k = 0; k < shape.n; k++) {
      if (lambda[k] * sign <= most * 0.01) continue;
      const pixels = ARROW * Math.min(1.5, (lambda[k] * sign) / most);
      // beside the arm, which has the same colour
      const [beside, below] = [Math.sin(phi[k]) * BESIDE, Math.cos(phi[k]) * BESIDE];
      arrow(
        context,
        across(camera, x[k]) + beside,
        down(camera, y[k]) + below,
        Math.cos(phi[k]) * sign,
        -Math.sin(phi[k]) * sign,
        pixels,
      );
    }
    context.lineCap = "round";
    context.lineJoin = "round";
    context.strokeStyle = colours.paper;
    context.lineWidth = 7;
    context.stroke();
    context.strokeStyle = colours.bins[sign < 0 ? 0 : BINS - 1];
    context.lineWidth = 3.5;
    context.stroke();
  }
}

/**
 * Around the tip of the arm that is chosen, or under the hand.
 * @param {Painter} painter @param {number} arm @param {Look} look @param {boolean} strong
 */
export function paintRing({ context }, arm, { shape, camera, colours }, strong) {
  const k = arm - 1;
  context.beginPath();
  context.arc(
    across(camera, shape.x[k]),
    down(camera, shape.y[k]),
    tipRadius(shape, k, camera) + 5,
    0,
    2 * Math.PI,
  );
  context.strokeStyle = colours.accent;
  context.lineWidth = strong ? 3.5 : 2;
  context.stroke();
}

/**
 * Whether a value lies between two.
 * @param {number} low @param {number} value @param {number} high
 */
const within = (low, value, high) => value > low && value < high;

/**
 * How many tips, and half as much how many rods' middles, a label at a place would hide.
 * @param {Shape} shape @param {Camera} camera @param {number} x @param {number} y @param {number}
 * wide
 */
function hides(shape, camera, x, y, wide) {
  let hidden = 0;
  for (let k = 0; k < shape.n; k++) {
    const dx = across(camera, shape.x[k]) - x;
    const dy = down(camera, shape.y[k]) - y;
    if (within(-8, dx, wide + 8) && within(-8, dy, 34)) hidden++;
    const mx = dx - (camera.scale * (shape.x[k] - shape.fromX[k])) / 2;
    const my = dy + (camera.scale * (shape.y[k] - shape.fromY[k])) / 2;
    if (within(-4, mx, wide + 4) && within(-4, my, 30)) hidden += 0.5;
  }
  return hidden;
}

/**
 * The place beside a tip where a label hides the fewest other tips.
 * @param {Look} look @param {number} arm @param {number} wide @param {number} most the stage's
 * width in pixels
 * @returns {Point}
 */
function labelPlace({ shape, camera }, arm, wide, most) {
  const px = across(camera, shape.x[arm - 1]);
  const py = down(camera, shape.y[arm - 1]);
  const places = [
    { x: px + 16, y: py - 13 },
    { x: px - 16 - wide, y: py - 13 },
    { x: px - wide / 2, y: py - 44 },
    { x: px - wide / 2, y: py + 18 },
  ];
  let best = places[0];
  let least = Infinity;
  for (const place of places) {
    const beside = place.x < 4 || place.x + wide > most - 4;
    const hidden = hides(shape, camera, place.x, place.y, wide) + (beside ? 50 : 0);
    if (hidden < least) [best, least] = [place, hidden];
  }
  return best;
}

/**
 * Adds a rectangle with round ends.
 * @param {CanvasRenderingContext2D} context @param {Point} at @param {number} wide
 */
function pill(context, { x, y }, wide) {
  const r = LABEL_HEIGHT / 2;
  context.arc(x + r, y + r, r, Math.PI / 2, 1.5 * Math.PI);
  context.arc(x + wide - r, y + r, r, 1.5 * Math.PI, 0.5 * Math.PI);
}

/**
 * Words beside a tip.
 * @param {Painter} painter @param {string} words @param {number} arm @param {Look} look
 * @param {number} most the stage's width in pixels
 */
export function paintLabel({ context }, words, arm, look, most) {
  const { colours } = look;
  context.font = colours.font;
  const wide = context.measureText(words).width + 20;
  const place = labelPlace(look, arm, wide, most);
  context.beginPath();
  pill(context, place, wide);
  context.fillStyle = colours.glass;
  context.fill();
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.fillStyle = colours.ink;
  context.fillText(words, place.x + 10, place.y + 14);
}

/**
 * Thin and pale: another motion of the same pendulum, the `i`th.
 * @param {Painter} painter @param {number} i @param {Look} look
 */
export function paintGhost({ context }, i, { shape, camera, colours }) {
  context.beginPath();
  for (let k = 0; k < shape.n; k++) rod(context, shape.ghost, camera, k);
  context.strokeStyle = colours.ghosts[i % colours.ghosts.length];
  context.lineWidth = shape.thin * 0.7;
  context.globalAlpha = 0.65;
  context.stroke();
  context.globalAlpha = 1;
}
