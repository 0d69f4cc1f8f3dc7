// What the time bar knows of the whole motion: how far its data reaches, moments at which an arm
// goes slack, and from when on digits are not to be trusted.
// Leaves to others: the clock's hand (timebar.js).
// Invariant: drawn anew only when the motion, the chosen arm, the size or the theme changes.

import { h } from "./dom.js";
import { fineness } from "./screen.js";

const HEIGHT = 22;

/**
 * For every pixel how many arms go slack there: the sign of their force changes between two
 * samples.
 * @param {Track} track @param {number} only an arm, 0 for all @param {number} pixels
 */
function slackMoments(track, only, pixels) {
  const counts = new Uint16Array(pixels);
  const { lambda } = track.columns;
  const { n, count, total } = track;
  if (!lambda || !pixels) return counts;
  for (let i = 1; i < count; i++) {
    const pixel = Math.min(pixels - 1, Math.floor((i / (total - 1)) * pixels));
    const row = i * n;
    for (let k = only ? only - 1 : 0; k < (only || n); k++) {
      if (lambda[row + k] * lambda[row - n + k] < 0) counts[pixel]++;
    }
  }
  return counts;
}

/** @param {string} name a custom property of the style */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** @param {CanvasRenderingContext2D} context @param {number} from @param {number} to pixels */
function hatch(context, from, to) {
  context.save();
  context.beginPath();
  context.rect(from, 0, to - from, HEIGHT);
  context.clip();
  context.beginPath();
  for (let x = from - HEIGHT; x < to; x += 6) {
    context.moveTo(x, HEIGHT);
    context.lineTo(x + HEIGHT, 0);
  }
  context.strokeStyle = colour("--hatch");
  context.lineWidth = 1.2;
  context.stroke();
  context.restore();
}

/**
 * @param {CanvasRenderingContext2D} context @param {Uint16Array} counts of slack moments, a pixel
 * each
 */
function ticks(context, counts) {
  context.fillStyle = colour("--mark");
  for (let x = 0; x < counts.length; x++) {
    if (!counts[x]) continue;
    context.globalAlpha = Math.min(1, 0.5 + 0.15 * counts[x]);
    context.fillRect(x, 0, 1, 6);
  }
  context.globalAlpha = 1;
}

/**
 * Makes the canvas as fine as its place.
 * @param {CanvasRenderingContext2D} context @param {number} width of its place
 */
function prepare(context, width) {
  const { canvas } = context;
  const ratio = fineness();
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(HEIGHT * ratio);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
}

/**
 * Draws all of it; answers how many slack moments there are.
 * @param {App} app @param {CanvasRenderingContext2D} context @param {number} width
 */
function paint({ store, motion, clock }, context, width) {
  prepare(context, width);
  const share = clock.duration ? clock.available / clock.duration : 0;
  context.fillStyle = colour("--line");
  context.fillRect(0, HEIGHT / 2 - 2, width, 4);
  context.fillStyle = colour("--loaded");
  context.fillRect(0, HEIGHT / 2 - 2, width * share, 4);
  const until = motion.stats?.horizon ?? Infinity;
  if (until < clock.duration) hatch(context, (width * until) / clock.duration, width);
  // who looks at forces sees when a rod has none
  const { arrows, selected } = store.get().view;
  const counts = slackMoments(motion.track, selected, arrows ? Math.round(width) : 0);
  ticks(context, counts);
  return counts.reduce((sum, count) => sum + count, 0);
}

/** @param {App} app @param {() => void} drawn told when the marks are drawn anew */
export function createMarks(app, drawn) {
  const canvas = h("canvas", { class: "marks", "aria-hidden": "true" });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  let slack = 0;
  let frame = 0;
  let width = 0; // pixels, 0 while it is not to be seen

  function draw() {
    frame = 0;
    if (!width) return;
    slack = paint(app, context, width);
    drawn();
  }

  const later = () => {
    frame ||= requestAnimationFrame(draw);
  };
  const observer = new ResizeObserver(([{ contentRect }]) => {
    width = contentRect.width;
    later();
  });
  observer.observe(canvas);
  const forget = app.theme.subscribe(later);

  return {
    canvas,
    draw: later,
    /** How many slack moments are marked. */
    count: () => slack,
    /** @param {string} what */
    follow(what) {
      if (what === "begin") slack = 0;
      if (what !== "preview") later();
    },
    destroy() {
      observer.disconnect();
      forget();
      cancelAnimationFrame(frame);
    },
  };
}
