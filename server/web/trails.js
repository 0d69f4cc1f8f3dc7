// Trails of chosen tips: where each was at every sample, and the last seconds of it as a fading
// line.
// Leaves to others: the samples, the colours.
// Invariant: a frame allocates nothing; a trail is computed once a sample, when it is seen first.

import { hangsAt } from "./terms.js";
import { cartAt } from "./track.js";
import { path, pivotAt } from "./tree.js";

const SECONDS = 5;
const PIECES = 14;
const POINTS = 700;

/**
 * The path of a tip; legs: the arms on the way to it, from 0, and how far along and across each of
 * them it goes.
 * @typedef {{k: number, along: number, across: number}} Leg
 * @typedef {{arm: number, legs: Leg[], count: number, x: Float32Array, y: Float32Array}} Trail
 */

/**
 * Which samples of a trail are drawn, in pieces of how many.
 * @typedef {{first: number, last: number, span: number, stride: number, piece: number, trusted:
 * number}} Stretch
 */

/**
 * The path of one tip: extend() computes what is seen of it.
 * @param {Track} track @param {number} arm @returns {Trail}
 */
function createTrail(track, arm) {
  const tree = track.doc.pendulum;
  const arms = path(tree.parent, arm).map((k) => k - 1);
  const legs = arms.map((k, i) => {
    const [along, across] = i + 1 < arms.length ? hangsAt(tree, arms[i + 1]) : [tree.length[k], 0];
    return { k, along, across };
  });
  return {
    arm,
    legs,
    count: 0,
    x: new Float32Array(track.total),
    y: new Float32Array(track.total),
  };
}

/** @param {Trail} trail @param {Track} track @param {number} until the last sample that is seen */
function extend(trail, track, until) {
  const { pendulum, span } = track.doc;
  const pivot = { x: 0, y: 0 };
  for (; trail.count <= until; trail.count++) {
    const row = trail.count * track.n;
    const time = (span.start ?? 0) + trail.count * span.step;
    pivotAt(pendulum, time, pivot, cartAt(track, trail.count));
    let { x, y } = pivot;
    for (const { k, along, across } of trail.legs) {
      const cos = Math.cos(track.columns.phi[row + k]);
      const sin = Math.sin(track.columns.phi[row + k]);
      x += along * cos - across * sin;
      y += along * sin + across * cos;
    }
    trail.x[trail.count] = x;
    trail.y[trail.count] = y;
  }
}

/**
 * One piece of a trail, from one sample to another; the last one ends at the tip of now.
 * @param {CanvasRenderingContext2D} context @param {Trail} trail @param {Look} look @param
 * {Stretch} stretch
 * @param {number} begin @param {number} end
 */
function drawPiece(context, trail, { camera, shape }, stretch, begin, end) {
  const age = (stretch.last - end) / stretch.span;
  context.globalAlpha = (1 - age) * (1 - age) * (end > stretch.trusted ? 0.22 : 0.8);
  context.beginPath();
  const { x, y } = trail;
  const { stride } = stretch;
  const left = camera.x + camera.scale * shape.apart;
  context.moveTo(left + camera.scale * x[begin], camera.y - camera.scale * y[begin]);
  for (let s = begin - (begin % stride) + stride; s < end; s += stride)
    context.lineTo(left + camera.scale * x[s], camera.y - camera.scale * y[s]);
  context.lineTo(left + camera.scale * x[end], camera.y - camera.scale * y[end]);
  if (end === stretch.last) {
    const k = trail.arm - 1;
    context.lineTo(camera.x + camera.scale * shape.x[k], camera.y - camera.scale * shape.y[k]);
  }
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context @param {Trail} trail @param {Look} look @param
 * {Stretch} stretch
 */
function drawTrail(context, trail, look, stretch) {
  const { first, last, piece } = stretch;
  // pieces lie at fixed samples, so that none flickers while time goes on
  for (let from = Math.floor(first / piece) * piece; from <= last; from += piece) {
    drawPiece(context, trail, look, stretch, Math.max(from, first), Math.min(from + piece, last));
  }
}

/** @param {CanvasRenderingContext2D} context */
export function createTrails(context) {
  /** @type {Trail[]} */
  let trails = [];
  /** @type {Track | null} */
  let of = null;
  const stretch = { first: 0, last: 0, span: 1, stride: 1, piece: 1, trusted: Infinity };

  return {
    /**
     * Brings the trails up to date with what is chosen.
     * @param {Track} track @param {number[]} chosen
     */
    follow(track, chosen) {
      const same = of === track && chosen.length === trails.length;
      if (!same || !chosen.every((arm, i) => trails[i].arm === arm)) {
        const kept = of === track ? new Map(trails.map((trail) => [trail.arm, trail])) : new Map();
        const there = chosen.filter((arm) => arm <= track.n);
        trails = there.map((arm) => kept.get(arm) ?? createTrail(track, arm));
        of = track;
      }
    },
    /**
     * place: the samples around now; trusted: the last sample whose digits hold.
     * @param {Place} place @param {Look} look @param {number} trusted
     */
    draw(place, look, trusted) {
      if (!of || of.n !== look.shape.n || of.count < 2) return;
      const span = Math.ceil(SECONDS / of.doc.span.step);
      const stride = Math.max(1, Math.ceil(span / POINTS));
      stretch.span = span;
      stretch.stride = stride;
      stretch.first = Math.max(0, place.index - span);
      stretch.last = place.index;
      stretch.piece = Math.max(stride, Math.ceil(span / PIECES / stride) * stride);
      stretch.trusted = trusted;
      context.lineWidth = Math.max(1, look.shape.thin * 0.55);
      context.lineCap = "butt";
      context.lineJoin = "round";
      for (let i = 0; i < trails.length; i++) {
        extend(trails[i], of, Math.min(place.index, of.count - 1));
        context.strokeStyle = look.colours.trails[i % look.colours.trails.length];
        drawTrail(context, trails[i], look, stretch);
      }
      context.globalAlpha = 1;
    },
  };
}
