// The small picture of an example: its pose, then its first seconds, forth and back.
// Leaves to others: which examples there are, and when to draw (gallery.js).
// Invariant: what moves is computed by the server; the picture holds all that the motion reaches.

import { fineness } from "./screen.js";
import { anglesAt } from "./track.js";
import { order, reach, tips } from "./tree.js";

const SECONDS = 6;
const STEP = 0.04;

/**
 * The server's description of an example.
 * @typedef {MotionBody & {name: string, title: string, n: number}} Preset
 */

/**
 * A picture: drawn at a time, in these colours.
 * @typedef {(time: number, colours: PictureColours) => void} Picture
 */

/** @typedef {{pivot: string, line: string, mass: string}} PictureColours */

/** What a picture is drawn with. @typedef {{
 *   context: CanvasRenderingContext2D, tree: Tree, n: number, x: Float64Array, y: Float64Array,
 *   heaviest: number,
 *   middle: number, top: number, scale: number, ratio: number,
 * }} Sketch */

/**
 * A preset as it starts, for a picture that does not move.
 * @param {Preset} preset @returns {Samples}
 */
export function pose({ pendulum, initial }) {
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
  const { pendulum, initial } = preset;
  const n = pendulum.length.length;
  const total = Math.round(SECONDS / STEP) + 1;
  const columns = { phi: new Float64Array(total * n), phid: new Float64Array(total * n) };
  const track = { doc: { pendulum, span: { step: STEP } }, initial, n, count: 0, columns };
  const times = { start: 0, stop: SECONDS, step: STEP };
  const body = { pendulum, initial, times, rtol: 1e-6, output: ["phi", "phid"] };
  const width = 1 + 2 * n;
  await client.table("/v1/trajectories", body, {
    signal,
    begin() {},
    rows(values, count) {
      for (let i = 0; i < count; i++) {
        const from = i * width + 1;
        columns.phi.set(values.subarray(from, from + n), (track.count + i) * n);
        columns.phid.set(values.subarray(from + n, from + 2 * n), (track.count + i) * n);
      }
      track.count += count;
    },
  });
  return track;
}

/**
 * How far around its pivot a track goes.
 * @param {Samples} track @param {number[]} rows @param {Float64Array} x @param {Float64Array} y
 * @returns {Box}
 */
function extent(track, rows, x, y) {
  const box = { side: 0.1, up: 0, down: 0.1 };
  for (let i = 0; i < track.count; i += 3) {
    tips(track.doc.pendulum, rows, track.columns.phi, i * track.n, x, y);
    for (let k = 0; k < track.n; k++) {
      box.side = Math.max(box.side, Math.abs(x[k]));
      box.up = Math.max(box.up, y[k]);
      box.down = Math.max(box.down, -y[k]);
    }
  }
  return box;
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawPivot({ context, middle, top }, colours) {
  context.beginPath();
  context.moveTo(middle - 9, top);
  context.lineTo(middle + 9, top);
  context.strokeStyle = colours.pivot;
  context.lineWidth = 1.2;
  context.stroke();
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawArms({ context, tree, n, x, y, middle, top, scale }, colours) {
  context.beginPath();
  for (let k = 0; k < n; k++) {
    const from = tree.parent[k] - 1;
    context.moveTo(
      middle + (from < 0 ? 0 : scale * x[from]),
      top - (from < 0 ? 0 : scale * y[from]),
    );
    context.lineTo(middle + scale * x[k], top - scale * y[k]);
  }
  context.strokeStyle = colours.line;
  context.lineWidth = 1.6;
  context.lineCap = "round";
  context.stroke();
}

/** @param {Sketch} sketch @param {PictureColours} colours */
function drawTips({ context, tree, n, x, y, heaviest, middle, top, scale }, colours) {
  context.beginPath();
  for (let k = 0; k < n; k++) {
    const r = Math.max(1.2, 3.4 * Math.cbrt(tree.mass[k] / heaviest));
    context.moveTo(middle + scale * x[k] + r, top - scale * y[k]);
    context.arc(middle + scale * x[k], top - scale * y[k], r, 0, 2 * Math.PI);
  }
  context.fillStyle = colours.mass;
  context.fill();
}

/**
 * Makes the canvas as fine as its place, and puts the box in its middle.
 * @param {Sketch} sketch @param {HTMLCanvasElement} canvas @param {Box} box
 */
function prepare(sketch, canvas, box) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const { ratio } = sketch;
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const along = box.up + box.down;
  sketch.scale = Math.min((width / 2 - 10) / box.side, (height - 20) / along);
  sketch.middle = width / 2;
  sketch.top = (height - sketch.scale * along) / 2 + sketch.scale * box.up;
  sketch.context.setTransform(ratio, 0, 0, ratio, 0, 0);
  sketch.context.clearRect(0, 0, width, height);
}

/**
 * Draws a track on a small canvas at a time; forth and back, since a motion may be run backwards.
 * @param {HTMLCanvasElement} canvas @param {Samples} track @returns {Picture}
 */
export function createPicture(canvas, track) {
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const tree = track.doc.pendulum;
  const rows = order(tree.parent);
  const [phi, x, y] = [0, 1, 2].map(() => new Float64Array(track.n));
  const place = { index: 0, fraction: 0 };
  const far = reach(tree);
  const box = track.count ? extent(track, rows, x, y) : { side: far, up: far, down: far };
  const last = (track.count - 1) * STEP;
  const sketch = {
    context,
    tree,
    n: track.n,
    x,
    y,
    heaviest: Math.max(...tree.mass),
    middle: 0,
    top: 0,
    scale: 1,
    ratio: fineness(),
  };

  return (time, colours) => {
    const turn = track.count > 1 ? time % (2 * last) : 0;
    anglesAt(track, turn > last ? 2 * last - turn : turn, place, phi);
    tips(tree, rows, phi, 0, x, y);
    prepare(sketch, canvas, box);
    drawPivot(sketch, colours);
    drawArms(sketch, colours);
    drawTips(sketch, colours);
  };
}
