// The small picture of an example: its pose, then its first seconds, forth and back.
// Leaves to others: which examples there are, and when to draw (gallery.js).
// Invariant: what moves is computed by the server; the picture holds all that the motion reaches.

import { widenBy } from "./camera.js";
import { across, down } from "./paint.js";
import { fineness } from "./screen.js";
import { fromRequest } from "./state.js";
import { addRows, anglesAt, beginTrack, cartAt, createTrack } from "./track.js";
import { massOf } from "./terms.js";
import { brackets, createSpots, order, reach, tips } from "./tree.js";

const SECONDS = 6;
const STEP = 0.04;
const THIN = 1.8; // pixels of an arm's width

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
 *   phi: Float64Array, spots: Spots, heaviest: number, camera: Camera, ratio: number,
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
  const doc = /** @type {Doc} */ ({ pendulum, span: { stop: SECONDS, step: STEP } });
  const track = createTrack(doc, initial);
  const times = { start: 0, stop: SECONDS, step: STEP };
  const output = ["phi", "phid", ...(pendulum.pivot?.cart ? ["cart"] : [])];
  const body = { pendulum: preset.pendulum, initial: preset.initial, times, rtol: 1e-6, output };
  await client.table("/v1/trajectories", body, {
    signal,
    begin: (columns) => beginTrack(track, columns),
    rows: (values, count) => addRows(track, values, count),
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

/**
 * A small tree: arms in one colour, tips in another.
 * @param {CanvasRenderingContext2D} context @param {Tree} tree @param {Spots} spots
 * @param {Camera} camera @param {number} thin pixels of an arm's width @param {number} heaviest
 * @param {string} colour @param {string} tipColour
 */
export function paintSmall(context, tree, spots, camera, thin, heaviest, colour, tipColour) {
  const { x, y, fromX, fromY } = spots;
  const line = (/** @type {number[]} */ ...[ax, ay, bx, by]) => {
    context.moveTo(across(camera, ax), down(camera, ay));
    context.lineTo(across(camera, bx), down(camera, by));
  };
  context.beginPath();
  for (let k = 0; k < tree.length.length; k++) line(fromX[k], fromY[k], x[k], y[k]);
  brackets(tree, spots, line);
  context.strokeStyle = colour;
  context.lineWidth = thin;
  context.lineCap = "round";
  context.stroke();
  context.beginPath();
  for (let k = 0; k < tree.length.length; k++) {
    const r = Math.max(thin * 0.9, thin * 1.8 * Math.cbrt(tree.mass[k] / (heaviest || 1)));
    context.moveTo(across(camera, x[k]) + r, down(camera, y[k]));
    context.arc(across(camera, x[k]), down(camera, y[k]), r, 0, 2 * Math.PI);
  }
  context.fillStyle = tipColour;
  context.fill();
}

/**
 * What a small tree hangs on.
 * @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {string}
 * colour
 */
export function paintHook(context, x, y, colour) {
  context.beginPath();
  context.moveTo(x - 9, y);
  context.lineTo(x + 9, y);
  context.strokeStyle = colour;
  context.lineWidth = 1.2;
  context.stroke();
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
  for (const sketch of sketches) sketch.camera = { x: width / 2, y: top, scale };
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
    spots,
    heaviest: Math.max(...tree.mass.map((_, k) => massOf(tree, k))),
    camera: { x: 0, y: 0, scale: 1 },
    ratio: fineness(),
  };
}

/** @param {Sketch} sketch @param {number} time s @param {PictureColours} colours */
function drawSketch(sketch, time, colours) {
  const { track, tree, rows, phi, spots } = sketch;
  anglesAt(track, time, PLACE, phi);
  spots.cart = cartAt(track, PLACE.index, PLACE.fraction);
  tips(tree, rows, phi, 0, spots, time);
  const { context, camera, heaviest } = sketch;
  const { pivot } = spots;
  paintHook(context, across(camera, pivot.x), down(camera, pivot.y), colours.pivot);
  paintSmall(context, tree, spots, camera, THIN, heaviest, colours.line, colours.mass);
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
