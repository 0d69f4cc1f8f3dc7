// The small picture of an example: its pose, then its first seconds, forth and back.
// Leaves to others: which examples there are, and when to draw (gallery.js).
// Invariant: what moves is computed by the server; the picture holds all that the motion reaches.

import { widenBy } from "./camera.js";
import { fineness } from "./screen.js";
import { fromRequest } from "./state.js";
import { anglesAt, cartAt } from "./track.js";
import { massOf } from "./terms.js";
import { brackets, createSpots, order, reach, tips } from "./tree.js";

const SECONDS = 6;
const STEP = 0.04;

/**
 * The server's description of an example.
 * @typedef {MotionBody & {name: string, title: string, description: string, n: number}} Preset
 */

/**
 * A picture: drawn at a time, in these colours.
 * @typedef {(time: number, colours: PictureColours) => void} Picture
 */

/** @typedef {{pivot: string, line: string, mass: string}} PictureColours */

/** What a pendulum is drawn with. @typedef {{
 *   context: CanvasRenderingContext2D, track: Samples, tree: Tree, rows: number[],
 *   phi: Float64Array, n: number, spots: Spots, heaviest: number,
 *   middle: number, top: number, scale: number, ratio: number,
 * }} Sketch */

const PLACE = { index: 0, fraction: 0 };

/**
 * A preset as it starts, for a picture that does not move.
 * @param {Preset} preset @returns {Samples}
 */
export function pose(preset) {
  const { pendulum, initial } = fromRequest(preset);
  const columns = { phi: Float64Array.from(initial.phi), phid: Float64Array.from(initial.phid) };
  return {
    doc: { pendulum, span: { step: STEP } },
    initial,
    n: pendulum.length.length,
    count: 1,
    columns,
  };
}

/**
 * A preset's first seconds, coarsely.
 * @param {Preset} preset @param {Client} client @param {AbortSignal} signal @returns
 * {Promise<Samples>}
 */
export async function loadSeconds(preset, client, signal) {
  const { initial } = preset;
  const { pendulum } = fromRequest(preset);
  const n = pendulum.length.length;
  const total = Math.round(SECONDS / STEP) + 1;
  /** @type {Columns} */
  const columns = { phi: new Float64Array(total * n), phid: new Float64Array(total * n) };
  if (pendulum.pivot?.cart) columns.cart_x = new Float64Array(total);
  const track = { doc: { pendulum, span: { step: STEP } }, initial, n, count: 0, columns };
  const times = { start: 0, stop: SECONDS, step: STEP };
  const cart = Boolean(pendulum.pivot?.cart);
  const output = ["phi", "phid", ...(cart ? ["cart"] : [])];
  const body = { pendulum: preset.pendulum, initial: preset.initial, times, rtol: 1e-6, output };
  // place, speed and reaction of a cart
  const width = 1 + 2 * n + (cart ? 3 : 0);
  await client.table("/v1/trajectories", body, {
    signal,
    begin() {},
    rows(values, count) {
      for (let i = 0; i < count; i++) {
        const from = i * width + 1;
        columns.phi.set(values.subarray(from, from + n), (track.count + i) * n);
        columns.phid.set(values.subarray(from + n, from + 2 * n), (track.count + i) * n);
        if (cart) columns.cart_x[track.count + i] = values[from + 2 * n];
      }
      track.count += count;
    },
  });
  return track;
}

/** Widens a box by all that a track reaches. @param {Box} box @param {Sketch} sketch */
function extend(box, { track, tree, rows, spots }) {
  for (let i = 0; i < track.count; i += 3) {
    spots.cart = cartAt(track, i);
    tips(tree, rows, track.columns.phi, i * track.n, spots, i * STEP);
    widenBy(box, tree, track.columns.phi, i * track.n, spots);
  }
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawPivot({ context, spots, middle, top, scale }, colours) {
  const x = middle + scale * spots.pivot.x;
  const y = top - scale * spots.pivot.y;
  context.beginPath();
  context.moveTo(x - 9, y);
  context.lineTo(x + 9, y);
  context.strokeStyle = colours.pivot;
  context.lineWidth = 1.2;
  context.stroke();
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawArms({ context, tree, n, spots, middle, top, scale }, colours) {
  const { x, y, fromX, fromY } = spots;
  context.beginPath();
  for (let k = 0; k < n; k++) {
    context.moveTo(middle + scale * fromX[k], top - scale * fromY[k]);
    context.lineTo(middle + scale * x[k], top - scale * y[k]);
  }
  brackets(tree, spots, (ax, ay, bx, by) => {
    context.moveTo(middle + scale * ax, top - scale * ay);
    context.lineTo(middle + scale * bx, top - scale * by);
  });
  context.strokeStyle = colours.line;
  context.lineWidth = 1.6;
  context.lineCap = "round";
  context.stroke();
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawTips({ context, tree, n, spots, heaviest, middle, top, scale }, colours) {
  const { x, y } = spots;
  context.beginPath();
  for (let k = 0; k < n; k++) {
    const r = Math.max(1.2, 3.4 * Math.cbrt(tree.mass[k] / (heaviest || 1)));
    context.moveTo(middle + scale * x[k] + r, top - scale * y[k]);
    context.arc(middle + scale * x[k], top - scale * y[k], r, 0, 2 * Math.PI);
  }
  context.fillStyle = colours.mass;
  context.fill();
}

/**
 * Makes the canvas as fine as its place, and puts the box in its middle.
 * @param {Sketch[]} sketches @param {HTMLCanvasElement} canvas @param {Box} box
 */
function prepare(sketches, canvas, box) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const [{ ratio, context }] = sketches;
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const along = box.up + box.down;
  const scale = Math.min((width / 2 - 10) / box.side, (height - 20) / along);
  const top = (height - scale * along) / 2 + scale * box.up;
  for (const sketch of sketches) Object.assign(sketch, { scale, middle: width / 2, top });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
}

/**
 * One pendulum of a picture.
 * @param {CanvasRenderingContext2D} context @param {Samples} track @param {number} apart m
 * @returns {Sketch}
 */
function sketchOf(context, track, apart) {
  const tree = track.doc.pendulum;
  const spots = createSpots(track.n, apart);
  return {
    context,
    track,
    tree,
    rows: order(tree.parent),
    phi: new Float64Array(track.n),
    n: track.n,
    spots,
    heaviest: Math.max(...tree.mass.map((_, k) => massOf(tree, k))),
    middle: 0,
    top: 0,
    scale: 1,
    ratio: fineness(),
  };
}

/** @param {Sketch} sketch @param {number} time s @param {PictureColours} colours */
function drawSketch(sketch, time, colours) {
  const { track, tree, rows, phi, spots } = sketch;
  anglesAt(track, time, PLACE, phi);
  spots.cart = cartAt(track, PLACE.index, PLACE.fraction);
  tips(tree, rows, phi, 0, spots, time);
  drawPivot(sketch, colours);
  drawArms(sketch, colours);
  drawTips(sketch, colours);
}

/**
 * Draws tracks, one or two side by side, on a small canvas at a time; forth and back, since a
 * motion may be run backwards.
 * @param {HTMLCanvasElement} canvas @param {Samples[]} tracks @returns {Picture}
 */
export function createPicture(canvas, ...tracks) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const far = tracks.map(({ doc }) => reach(doc.pendulum));
  const apart = tracks.length > 1 ? 0.45 * (far[0] + far[1]) : 0;
  const sketches = tracks.map((track, i) => sketchOf(context, track, i ? apart : -apart));
  const box = { side: 0.1, up: 0, down: 0.1 };
  for (const sketch of sketches) extend(box, sketch);
  const last = (tracks[0].count - 1) * STEP;
  return (time, colours) => {
    const turn = last ? time % (2 * last) : 0;
    prepare(sketches, canvas, box);
    for (const sketch of sketches)
      drawSketch(sketch, turn > last ? 2 * last - turn : turn, colours);
  };
}
