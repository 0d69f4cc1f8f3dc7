// The stage: the pendulum at the clock's time, on a canvas that fills its place, and what lies on it.
// Leaves to others: the strokes (paint.js, trails.js), what to show (camera.js), hands (hands.js), keys (arms.js), words (card.js, legend.js, notices.js).
// Invariant: draws at most once a frame, and only when something has changed.

import { mountArms } from "./arms.js";
import { aim, boxOf, forceScale } from "./camera.js";
import { mountCard } from "./card.js";
import { createBag, h } from "./dom.js";
import { mountHands } from "./hands.js";
import { mountLegend } from "./legend.js";
import { anglesAt, valuesAt } from "./motion.js";
import { mountNotices } from "./notices.js";
import { createPainter, readColours } from "./paint.js";
import { still, theme } from "./theme.js";
import { createTrails } from "./trails.js";
import { order, reach, tips } from "./tree.js";

const EASE_SECONDS = 0.09;

/** What depends on the tree only. */
function shapeOf(tree) {
  const n = tree.length.length;
  const array = () => new Float64Array(n);
  return {
    tree,
    n,
    rows: order(tree.parent),
    reach: reach(tree),
    heaviest: Math.max(...tree.mass),
    thin: Math.max(1.5, 3.6 - 0.3 * Math.log2(n)),
    phi: array(),
    lambda: array(),
    x: array(),
    y: array(),
    ghostPhi: array(),
    ghostX: array(),
    ghostY: array(),
  };
}

const union = (a, b) => ({
  side: Math.max(a.side, b.side),
  up: Math.max(a.up, b.up),
  down: Math.max(a.down, b.down),
});

export function mountStage(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const canvas = h("canvas", { class: "canvas", role: "img" });
  element.append(canvas);
  const context = canvas.getContext("2d");
  const painter = createPainter(context);
  const trails = createTrails(context);
  const place = { index: 0, fraction: 0 };
  const ghostPlace = { index: 0, fraction: 0 };
  const goal = { x: 0, y: 0, scale: 0 };
  let frame = 0;
  let last = 0;
  let box = null;
  let stale = true; // the box and the scale are of an older motion
  let size = { width: 0, height: 0, ratio: 1 };

  /** What is on the stage, for those who ask where. */
  const look = {
    shape: shapeOf(motion.doc.pendulum),
    camera: { x: 0, y: 0, scale: 0 },
    colours: readColours(store.get().view.palette),
    most: 0,
    hover: 0,
    focused: false,
    soon,
  };

  function fit() {
    const ratio = Math.min(devicePixelRatio, 2);
    size = { width: element.clientWidth, height: element.clientHeight, ratio };
    canvas.width = Math.round(size.width * ratio);
    canvas.height = Math.round(size.height * ratio);
    look.camera.scale = 0;
    draw();
  }

  /** Takes the measure of the motion; while it is not whole, nothing that is shown goes out of sight. */
  function measure() {
    stale = false;
    const { track } = motion;
    const { shape } = look;
    const found = boxOf(track, shape.rows, shape.reach, shape.ghostX, shape.ghostY);
    box = track.complete || !box ? found : union(box, found);
    if (track.complete || !look.most) look.most = forceScale(track);
  }

  /** Moves the camera towards where it belongs; true when it is there. */
  function approach(seconds) {
    const { camera } = look;
    // on a narrow stage the card lies below the pendulum
    const bottom = size.width < 560 ? Math.max(70, look.cardHeight() + 20) : 84;
    aim(box, size.width, size.height, { left: 28, right: 28, top: 36, bottom }, goal);
    const near =
      Math.abs(goal.scale - camera.scale) < 0.002 * goal.scale &&
      Math.hypot(goal.x - camera.x, goal.y - camera.y) < 0.5;
    const share =
      near || !camera.scale || still.matches ? 1 : 1 - Math.exp(-seconds / EASE_SECONDS);
    for (const key of ["x", "y", "scale"])
      camera[key] = share === 1 ? goal[key] : camera[key] + share * (goal[key] - camera[key]);
    return share === 1;
  }

  function settleShape() {
    if (look.shape.tree !== motion.doc.pendulum) look.shape = shapeOf(motion.doc.pendulum);
    if (stale) measure();
  }

  function draw() {
    cancelAnimationFrame(frame);
    frame = 0;
    if (!size.width || !size.height) return;
    settleShape();
    const now = performance.now();
    const there = approach(Math.min((now - last) / 1000, 0.05));
    last = now;
    const { track } = motion;
    const { shape } = look;
    anglesAt(track, clock.time, place, shape.phi);
    valuesAt(track, "lambda", clock.time, place, shape.lambda);
    tips(shape.tree, shape.rows, shape.phi, 0, shape.x, shape.y);
    context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
    context.clearRect(0, 0, size.width, size.height);
    drawAll(track, shape);
    card.follow();
    if (!there) soon();
  }

  function drawAll(track, shape) {
    const { camera, colours, most } = look;
    const { view } = store.get();
    const { tree, x, y, thin } = shape;
    motion.ghosts.forEach((ghost, i) => drawGhost(ghost, i, shape));
    const until = motion.stats?.horizon;
    trails.draw(
      track,
      place,
      x,
      y,
      camera,
      colours,
      thin,
      until === undefined ? Infinity : until / track.doc.span.step,
    );
    painter.pivot(camera, colours);
    painter.arms(tree, x, y, shape.lambda, most, camera, colours, thin);
    painter.tips(tree, x, y, shape.heaviest, camera, colours, thin);
    if (view.arrows) painter.arrows(tree, x, y, shape.phi, shape.lambda, most, camera, colours);
    const { selected } = view;
    if (look.hover && look.hover <= shape.n && look.hover !== selected)
      painter.ring(look.hover, shape, camera, colours, false);
    if (selected && selected <= shape.n)
      painter.ring(selected, shape, camera, colours, look.focused);
    const told = look.hover || (clock.playing ? selected : 0);
    if (told && told <= shape.n) tell(told, shape);
  }

  /** An arm's numbers beside its tip. */
  function tell(arm, shape) {
    const k = arm - 1;
    const { length, mass } = shape.tree;
    const words = text("arm.numbers", {
      arm,
      length: text.short(length[k]),
      mass: text.short(mass[k]),
      force: text.number(shape.lambda[k], 1),
    });
    painter.label(words, arm, shape, look.camera, look.colours, size.width);
  }

  function drawGhost(ghost, i, shape) {
    if (ghost.n !== shape.n) return;
    anglesAt(ghost, clock.time, ghostPlace, shape.ghostPhi);
    tips(shape.tree, shape.rows, shape.ghostPhi, 0, shape.ghostX, shape.ghostY);
    painter.ghost(
      i,
      shape.tree,
      shape.ghostX,
      shape.ghostY,
      look.camera,
      look.colours,
      shape.thin * 0.7,
    );
  }

  function soon() {
    if (!frame) frame = requestAnimationFrame(draw);
  }

  function recolour() {
    look.colours = readColours(store.get().view.palette);
    legend.show();
    soon();
  }

  function describe() {
    const { pendulum } = store.get();
    const n = pendulum.length.length;
    canvas.setAttribute("aria-label", text(n === 1 ? "stage.label.one" : "stage.label", { n }));
  }

  /** Where on the stage an arm's tip is (0: the pivot), in pixels; for those who point at it. */
  app.stage = {
    tip(arm) {
      const { shape, camera } = look;
      return {
        x: camera.x + (arm ? camera.scale * shape.x[arm - 1] : 0),
        y: camera.y - (arm ? camera.scale * shape.y[arm - 1] : 0),
      };
    },
  };
  // in the order of the tab key
  const arms = mountArms(element, app, look);
  const card = mountCard(element, app, look);
  const legend = mountLegend(element, app, look);
  const notices = mountNotices(element, app);
  const hands = mountHands(canvas, app, look);
  for (const part of [notices, legend, card, arms, hands]) bag(part.destroy);

  bag(
    motion.subscribe((_, what) => {
      if (what === "begin" || what === "rows" || what === "complete") {
        stale = true;
        trails.follow(motion.track, store.get().view.trails);
      }
      if (what === "complete") {
        settleShape();
        legend.show();
      }
      soon();
    }),
  );
  bag(
    store.subscribe((doc, before) => {
      if (doc.view.palette !== before.view.palette) recolour();
      if (doc.view.trails !== before.view.trails) trails.follow(motion.track, doc.view.trails);
      if (doc.pendulum !== before.pendulum) describe();
      soon();
    }),
  );
  // while it plays the clock calls once a frame
  bag(clock.subscribe(() => (clock.playing ? draw() : soon())));
  bag(theme.subscribe(recolour));
  const observer = new ResizeObserver(fit);
  observer.observe(element);
  bag(() => observer.disconnect());
  bag(() => cancelAnimationFrame(frame));
  trails.follow(motion.track, store.get().view.trails);
  describe();
  fit();
  return {
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}
