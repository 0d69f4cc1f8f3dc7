// The stage: the pendulum at the clock's time, on a canvas that fills its place.
// Leaves to others: the strokes (paint.js), the samples (motion.js), the time (clock.js).
// Invariant: draws at most once a frame, and only when something has changed.

import { createBag, h } from "./dom.js";
import { anglesAt, valuesAt } from "./motion.js";
import { createPainter, readColours } from "./paint.js";
import { theme } from "./theme.js";
import { order, reach, tips } from "./tree.js";

const MARGIN = 28;
const TRAIL_SECONDS = 4;
const TRAIL_PIECES = 10;

export function mountStage(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const canvas = h("canvas", { class: "canvas", role: "img", "aria-label": text("stage.label") });
  element.append(canvas);
  const context = canvas.getContext("2d");
  const painter = createPainter(context);
  const camera = { x: 0, y: 0, scale: 1 };
  const place = { index: 0, fraction: 0 };
  let colours = readColours(store.get().view.palette);
  let frame = 0;
  let size = { width: 0, height: 0, ratio: 1 };
  let shape = null; // what depends on the tree only: {tree, rows, reach, heaviest, phi, lambda, x, y}
  let most = 0;

  function fit() {
    const ratio = Math.min(devicePixelRatio, 2);
    size = { width: element.clientWidth, height: element.clientHeight, ratio };
    canvas.width = Math.round(size.width * ratio);
    canvas.height = Math.round(size.height * ratio);
    draw();
  }

  function shapeOf(tree) {
    if (shape?.tree === tree) return shape;
    const n = tree.length.length;
    const array = () => new Float64Array(n);
    shape = { tree, n, rows: order(tree.parent), reach: reach(tree), heaviest: Math.max(...tree.mass),
      phi: array(), lambda: array(), x: array(), y: array() };
    return shape;
  }

  function aim() {
    camera.x = size.width / 2;
    camera.y = size.height / 2;
    camera.scale = (Math.min(size.width, size.height) / 2 - MARGIN) / shape.reach;
  }

  function draw() {
    frame = 0;
    const { track } = motion;
    const now = shapeOf(track.doc.pendulum);
    aim();
    anglesAt(track, clock.time, place, now.phi);
    valuesAt(track, "lambda", clock.time, place, now.lambda);
    tips(now.tree, now.rows, now.phi, 0, now.x, now.y);
    const thin = Math.max(1.5, Math.min(3.2, 30 / Math.sqrt(now.n) ** 1.2));
    context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
    context.clearRect(0, 0, size.width, size.height);
    painter.pivot(camera, colours, thin);
    painter.arms(now.tree, now.x, now.y, now.lambda, most, camera, colours, thin);
    painter.tips(now.tree, now.x, now.y, now.heaviest, camera, colours, thin);
  }

  function soon() {
    if (!frame) frame = requestAnimationFrame(draw);
  }

  function scale() {
    const { columns, count, n } = motion;
    most = 0;
    for (let i = 0; i < count * n; i++) most = Math.max(most, Math.abs(columns.lambda[i]));
  }

  const observer = new ResizeObserver(fit);
  observer.observe(element);
  bag(() => observer.disconnect());
  // the clock calls once a frame
  bag(clock.subscribe(() => (clock.playing ? draw() : soon())));
  bag(motion.subscribe(() => {
    scale();
    soon();
  }));
  bag(store.subscribe(soon));
  bag(theme.subscribe(() => {
    colours = readColours(store.get().view.palette);
    soon();
  }));
  bag(() => cancelAnimationFrame(frame));
  fit();
  return { destroy: () => { bag.end(); element.replaceChildren(); } };
}
