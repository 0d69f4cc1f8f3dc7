// Trails of chosen tips: where each was at every sample, and the last seconds of it as a fading line.
// Leaves to others: the samples, the colours.
// Invariant: a frame allocates nothing; a trail is computed once a sample.

import { path } from "./tree.js";

const SECONDS = 5;
const PIECES = 14;
const POINTS = 700;

/** The path of one tip: extend() computes what has arrived since. */
function createTrail(track, arm) {
  const arms = path(track.doc.pendulum.parent, arm).map((k) => k - 1);
  return {
    arm,
    arms,
    count: 0,
    x: new Float32Array(track.total),
    y: new Float32Array(track.total),
  };
}

function extend(trail, track) {
  const { length } = track.doc.pendulum;
  for (; trail.count < track.count; trail.count++) {
    const row = trail.count * track.n;
    let x = 0;
    let y = 0;
    for (const k of trail.arms) {
      x += length[k] * Math.cos(track.columns.phi[row + k]);
      y += length[k] * Math.sin(track.columns.phi[row + k]);
    }
    trail.x[trail.count] = x;
    trail.y[trail.count] = y;
  }
}

export function createTrails(context) {
  let trails = [];
  let of = null;

  return {
    /** Brings the trails up to date with what is chosen and what has arrived. */
    follow(track, chosen) {
      const same =
        of === track &&
        chosen.length === trails.length &&
        chosen.every((arm, i) => trails[i].arm === arm);
      if (!same) {
        const kept = of === track ? new Map(trails.map((trail) => [trail.arm, trail])) : new Map();
        trails = chosen
          .filter((arm) => arm <= track.n)
          .map((arm) => kept.get(arm) ?? createTrail(track, arm));
        of = track;
      }
      for (const trail of trails) extend(trail, track);
    },
    /** place: the samples around now; x, y: the tips now; trusted: the last sample whose digits hold. */
    draw(track, place, x, y, camera, colours, thin, trusted) {
      if (of !== track || track.count < 2) return;
      const span = Math.ceil(SECONDS / track.doc.span.step);
      const first = Math.max(0, place.index - span);
      const stride = Math.max(1, Math.ceil(span / POINTS));
      const piece = Math.max(stride, Math.ceil(span / PIECES / stride) * stride);
      context.lineWidth = Math.max(1, thin * 0.55);
      context.lineCap = "butt";
      context.lineJoin = "round";
      for (let i = 0; i < trails.length; i++) {
        const trail = trails[i];
        context.strokeStyle = colours.trails[i % colours.trails.length];
        // pieces lie at fixed samples, so that none flickers while time goes on
        for (let from = Math.floor(first / piece) * piece; from <= place.index; from += piece) {
          const begin = Math.max(from, first);
          const end = Math.min(from + piece, place.index);
          const age = (place.index - end) / span;
          context.globalAlpha = (1 - age) * (1 - age) * (end > trusted ? 0.22 : 0.8);
          context.beginPath();
          context.moveTo(
            camera.x + camera.scale * trail.x[begin],
            camera.y - camera.scale * trail.y[begin],
          );
          for (let s = begin - (begin % stride) + stride; s < end; s += stride) {
            context.lineTo(
              camera.x + camera.scale * trail.x[s],
              camera.y - camera.scale * trail.y[s],
            );
          }
          context.lineTo(
            camera.x + camera.scale * trail.x[end],
            camera.y - camera.scale * trail.y[end],
          );
          if (end === place.index)
            context.lineTo(
              camera.x + camera.scale * x[trail.arm - 1],
              camera.y - camera.scale * y[trail.arm - 1],
            );
          context.stroke();
        }
      }
      context.globalAlpha = 1;
    },
  };
}
