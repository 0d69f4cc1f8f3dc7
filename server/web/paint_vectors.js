// Arrows at the tips: velocity, acceleration, weight, and the force of the arm, each with its
// letter and an outline that keeps it apart from arms and trails.
// Leaves to others: which are wanted and how long they are (view.vectors, view.vectorScale).
// Invariant: what moves follows from the samples by differences of places one sample apart; arrows
// of forces have one scale, so that weight and arm force can be compared.

import { anglesAt, cartAt } from "./track.js";
import { massOf } from "./terms.js";
import { createSpots, order, reach, tips } from "./tree.js";

/** What there is, with the colour of each and its letter. @type {Record<string, string[]>} */
export const VECTORS = {
  velocity: ["--arm-3", "v"],
  acceleration: ["--arm-4", "a"],
  weight: ["--arm-5", "G"],
  force: ["--ink", "F"],
};
const LONG = 80; // pixels of what is the measure of its kind
const LEAST = 5; // pixels, below which an arrow is none

/** @typedef {{x: Float64Array, y: Float64Array}} Field */

/**
 * Room for the places before, now and after, and for what is drawn.
 * @param {Track} track
 */
function roomFor({ doc, n }) {
  const tree = doc.pendulum;
  const field = () => ({ x: new Float64Array(n), y: new Float64Array(n) });
  // gravity may be none
  const pull = Math.max(Math.abs(tree.gravity), 1);
  return {
    tree,
    rows: order(tree.parent),
    spots: [createSpots(n), createSpots(n), createSpots(n)],
    phi: new Float64Array(n),
    place: { index: 0, fraction: 0 },
    field: field(),
    speed: Math.sqrt(2 * pull * reach(tree)),
    pull,
  };
}

/** @typedef {ReturnType<typeof roomFor>} Room */

/**
 * Where the tips are around a time; answers the step, s.
 * @param {Room} room @param {Track} track @param {number} time
 */
function around(room, track, time) {
  const { step, start = 0 } = track.doc.span;
  const last = (track.count - 1) * step;
  const middle = Math.max(step, Math.min(time, last - step));
  for (let i = 0; i < 3; i++) {
    const at = middle + (i - 1) * step;
    anglesAt(track, at, room.place, room.phi);
    room.spots[i].cart = cartAt(track, room.place.index, room.place.fraction);
    tips(room.tree, room.rows, room.phi, 0, room.spots[i], start + at);
  }
  return step;
}

/** @typedef {(room: Room, shape: Shape, step: number, k: number, most: number) => void} Fill */

/** @type {Record<string, Fill>} */
const FILLS = {
  velocity({ spots: [a, , b], field, speed }, _, step, k) {
    field.x[k] = (b.x[k] - a.x[k]) / (2 * step) / speed;
    field.y[k] = (b.y[k] - a.y[k]) / (2 * step) / speed;
  },
  acceleration({ spots: [a, o, b], field, pull }, _, step, k) {
    field.x[k] = (b.x[k] - 2 * o.x[k] + a.x[k]) / step ** 2 / (2 * pull);
    field.y[k] = (b.y[k] - 2 * o.y[k] + a.y[k]) / step ** 2 / (2 * pull);
  },
  weight({ tree, field }, _, _step, k, most) {
    field.x[k] = 0;
    field.y[k] = (-massOf(tree, k) * tree.gravity) / (0.4 * most);
  },
  force({ field }, { phi, lambda }, _, k, most) {
    field.x[k] = (lambda[k] * Math.cos(phi[k])) / (0.4 * most);
    field.y[k] = (lambda[k] * Math.sin(phi[k])) / (0.4 * most);
  },
};

/**
 * Adds an arrow with a filled head to the path.
 * @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} dx
 * @param {number} dy @param {number} pixels
 */
function arrow(context, x, y, dx, dy, pixels) {
  const head = Math.min(12, 5 + pixels * 0.12);
  const neck = pixels - head;
  context.moveTo(x, y);
  context.lineTo(x + dx * neck, y + dy * neck);
  context.moveTo(x + dx * pixels, y + dy * pixels);
  context.lineTo(x + dx * neck - dy * head * 0.5, y + dy * neck + dx * head * 0.5);
  context.lineTo(x + dx * neck + dy * head * 0.5, y + dy * neck - dx * head * 0.5);
  context.closePath();
}

/**
 * One kind, of all arms: an outline, then the arrow.
 * @param {CanvasRenderingContext2D} context @param {Look} look @param {Field} field
 * @param {number} long pixels of 1 @param {string} colour @param {string} letter
 */
function paintKind(context, { shape, camera, colours }, field, long, colour, letter) {
  /** @type {[number, number][]} */
  const ends = [];
  context.beginPath();
  for (let k = 0; k < shape.n; k++) {
    const size = Math.hypot(field.x[k], field.y[k]);
    const pixels = Math.min(size * long, 400);
    if (!(pixels > LEAST)) continue;
    const [dx, dy] = [field.x[k] / size, -field.y[k] / size];
    const x = camera.x + camera.scale * shape.x[k];
    const y = camera.y - camera.scale * shape.y[k];
    arrow(context, x, y, dx, dy, pixels);
    ends.push([x + dx * (pixels + 9), y + dy * (pixels + 9)]);
  }
  context.lineJoin = context.lineCap = "round";
  context.strokeStyle = colours.paper;
  context.lineWidth = 7;
  context.stroke();
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = 3;
  context.stroke();
  context.fill();
  context.font = `italic ${colours.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.strokeStyle = colours.paper;
  for (const [x, y] of ends) {
    context.strokeText(letter, x, y);
    context.fillText(letter, x, y);
  }
}

/** A painter of arrows, which keeps its room while the pendulum is the same. */
export function createVectors() {
  /** @type {Room | null} */
  let room = null;
  return (
    /** @type {CanvasRenderingContext2D} */ context,
    /** @type {Look} */ look,
    /** @type {Track} */ track,
    /** @type {View} */ { vectors, vectorScale },
    /** @type {number} */ time,
  ) => {
    if (!vectors.length || track.count < 3) return;
    if (room?.tree !== track.doc.pendulum) room = roomFor(track);
    const step = around(room, track, time);
    const style = getComputedStyle(document.documentElement);
    for (const name of vectors) {
      const [property, letter] = VECTORS[name];
      for (let k = 0; k < track.n; k++) FILLS[name](room, look.shape, step, k, look.most || 1);
      const colour = style.getPropertyValue(property).trim();
      paintKind(context, look, room.field, LONG * vectorScale, colour, letter);
    }
  };
}
