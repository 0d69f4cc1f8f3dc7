// The stage: the pendulum at the clock's time, on a canvas that fills its place, and what lies on
// it.
// Leaves to others: the strokes (paint.js, trails.js), what to show (camera.js), hands (hands.js),
// keys (arms.js), words (card.js, legend.js, notices.js), ruler and protractor
// (drawers/measure/gauges.js).
// Invariant: draws at most once a frame, and only when something has changed.

import { foldedTheta } from "./angles.js";
import { mountArms } from "./arms.js";
import { aim, boxOf, forceScale } from "./camera.js";
import { mountCard } from "./card.js";
import { said } from "./client.js";
import { createBag, h } from "./dom.js";
import { mountHands } from "./hands.js";
import { mountInvite } from "./invite.js";
import { mountLegend } from "./legend.js";
import { mountNotices } from "./notices.js";
import * as paint from "./paint.js";
import { paintAngle } from "./paint_angle.js";
import { paintOver, paintUnder } from "./paint_real.js";
import { createVectors } from "./paint_vectors.js";
import { readColours } from "./palette.js";
import { bare, fineness, still } from "./screen.js";
import { anglesAt, cartAt, valuesAt } from "./track.js";
import { createTrails } from "./trails.js";
import { isBeside } from "./state.js";
import { massOf } from "./terms.js";
import { createSpots, order, reach, tips } from "./tree.js";
import { tried } from "./trouble.js";

const EASE_SECONDS = 0.09;
const BARE_HEIGHT = 480; // pixels, where the style has not come
const LOW = 360; // pixels, below which the stage is the pendulum's alone
const NARROW = 560; // pixels, below which the card lies under the pendulum

/**
 * The stage, while it is there: its place, what it draws with, and what it has drawn.
 * @typedef {{
 *   app: App, element: HTMLElement, canvas: HTMLCanvasElement, context: CanvasRenderingContext2D,
 *   vectors: ReturnType<typeof createVectors>,
 *   painter: paint.Painter, trails: ReturnType<typeof createTrails>, look: Look,
 *   place: Place, ghostPlace: Place, goal: Camera, frame: number, last: number, box: Box | null,
 *   stale: boolean, gauges: boolean, size: {width: number, height: number, ratio: number},
 *   parts: StagePart[],
 * }} Stage
 */

/**
 * What depends on the tree only, and on how far beside the middle it is drawn, m.
 * @param {Tree} tree @param {number} apart @returns {Shape}
 */
function shapeOf(tree, apart = 0) {
  const n = tree.length.length;
  const array = () => new Float64Array(n);
  return {
    tree,
    n,
    rows: order(tree.parent),
    reach: reach(tree),
    heaviest: Math.max(...tree.mass.map((_, k) => massOf(tree, k))),
    thin: Math.max(1.5, 3.6 - 0.3 * Math.log2(n)),
    phi: array(),
    lambda: array(),
    ghostPhi: array(),
    ...createSpots(n, apart),
    ghost: createSpots(n, apart),
    time: 0,
  };
}

/** @param {Box} a @param {Box} b @returns {Box} */
const union = (a, b) => ({
  side: Math.max(a.side, b.side),
  up: Math.max(a.up, b.up),
  down: Math.max(a.down, b.down),
});

/** @param {Stage} stage */
function fit(stage) {
  const { element, canvas, look } = stage;
  const ratio = fineness();
  // without a style the place is as high as what lies in it, which the canvas must not follow
  const height = bare() ? BARE_HEIGHT : element.clientHeight;
  stage.size = { width: element.clientWidth, height, ratio };
  canvas.width = Math.round(stage.size.width * ratio);
  canvas.height = Math.round(stage.size.height * ratio);
  look.camera.scale = 0;
  look.colours = readColours(stage.app.store.get().view.palette);
  draw(stage);
}

/** The second pendulum beside the document's, and on which side. @param {App} app */
function secondOf({ motion, store }) {
  const { ghosts } = store.get();
  const i = ghosts.findIndex(isBeside);
  const track = motion.ghosts[i];
  return track ? { track, side: ghosts[i].beside ?? 1 } : null;
}

/**
 * Takes the measure of the motion; while it is not whole, nothing that is shown goes out of sight.
 * @param {Stage} stage
 */
function measure(stage) {
  stage.stale = false;
  const { track } = stage.app.motion;
  const { look } = stage;
  const { shape, second } = look;
  const boxed = (/** @type {Track} */ of, /** @type {Shape} */ { rows, reach: far, ghost }) =>
    boxOf(of, rows, far + Math.abs(ghost.apart), ghost);
  const other = second && secondOf(stage.app);
  const own = boxed(track, shape);
  const found = other ? union(own, boxed(other.track, second)) : own;
  stage.box = track.complete || !stage.box ? found : union(stage.box, found);
  if (track.complete || !look.most) look.most = forceScale(track);
}

/** @param {Stage} stage @returns {Box} the box of the motion that is shown */
function settleShape(stage) {
  const { look } = stage;
  const { pendulum } = stage.app.motion.doc;
  const second = secondOf(stage.app);
  const other = second?.track.doc.pendulum;
  // as far apart as they do not touch
  const gap = other ? 0.9 * (reach(pendulum) + reach(other)) : 0;
  const apart = second ? (-second.side * gap) / 2 : 0;
  if (look.shape.tree !== pendulum || look.shape.apart !== apart) {
    look.shape = shapeOf(pendulum, apart);
    stage.stale = true;
  }
  if (!other) look.second = null;
  else if (look.second?.tree !== other || look.second.apart !== -apart) {
    look.second = shapeOf(other, -apart);
    stage.stale = true;
  }
  if (stage.stale) measure(stage);
  return /** @type {Box} */ (stage.box);
}

/**
 * Moves the camera towards where it belongs; true when it is there.
 * @param {Stage} stage @param {Box} box @param {number} seconds
 */
function approach({ look, size, goal }, box, seconds) {
  const { camera } = look;
  // a low stage has no scale of forces below the pendulum (style.css)
  const low = size.height < LOW;
  const legend = size.width < NARROW ? Math.max(70, look.cardHeight() + 20) : 84;
  const [top, bottom] = low ? [22, 14] : [36, legend];
  aim(box, size.width, size.height, { left: 28, right: 28, top, bottom }, goal);
  // the card lies beside the motion where there is room for both
  const card = size.width < NARROW ? 0 : look.cardWidth();
  if (card && goal.x - goal.scale * box.side < card + 28) {
    const rightwards = document.documentElement.dir !== "rtl";
    const [left, right] = rightwards ? [card + 28, 28] : [28, card + 28];
    aim(box, size.width, size.height, { left, right, top, bottom }, goal);
  }
  const far = Math.hypot(goal.x - camera.x, goal.y - camera.y);
  const near = Math.abs(goal.scale - camera.scale) < 0.002 * goal.scale && far < 0.5;
  const share = near || !camera.scale || still.matches ? 1 : 1 - Math.exp(-seconds / EASE_SECONDS);
  camera.x = share === 1 ? goal.x : camera.x + share * (goal.x - camera.x);
  camera.y = share === 1 ? goal.y : camera.y + share * (goal.y - camera.y);
  camera.scale = share === 1 ? goal.scale : camera.scale + share * (goal.scale - camera.scale);
  return share === 1;
}

/** @param {Stage} stage */
function draw(stage) {
  cancelAnimationFrame(stage.frame);
  stage.frame = 0;
  const { app, size, look, place, context } = stage;
  if (!size.width || !size.height) return;
  const box = settleShape(stage);
  const now = performance.now();
  const there = approach(stage, box, Math.min((now - stage.last) / 1000, 0.05));
  stage.last = now;
  const { track } = app.motion;
  const { shape } = look;
  anglesAt(track, app.clock.time, place, shape.phi);
  valuesAt(track, "lambda", app.clock.time, place, shape.lambda);
  shape.time = (track.doc.span.start ?? 0) + app.clock.time;
  shape.cart = cartAt(track, place.index, place.fraction);
  tips(shape.tree, shape.rows, shape.phi, 0, shape, shape.time);
  context.setTransform(size.ratio, 0, 0, size.ratio, 0, 0);
  context.clearRect(0, 0, size.width, size.height);
  drawPendulum(stage);
  drawChosen(stage);
  for (const part of stage.parts) part.follow?.();
  if (!there) look.soon();
}

/** @param {Stage} stage */
function drawPendulum(stage) {
  const { app, painter, look, place } = stage;
  const { motion, store } = app;
  for (let i = 0; i < motion.ghosts.length; i++)
    if (!isBeside(store.get().ghosts[i] ?? {})) drawGhost(stage, i);
  drawSecond(stage);
  const until = motion.stats?.horizon;
  stage.trails.draw(
    place,
    look,
    until === undefined ? Infinity : until / motion.track.doc.span.step,
  );
  paintUnder(painter, look);
  if (!look.shape.tree.pivot?.cart) paint.paintPivot(painter, look);
  if (look.shape.tree.at) paint.paintBrackets(painter, look);
  paint.paintArms(painter, look);
  paint.paintTips(painter, look);
  paintOver(painter, look);
  const { view } = store.get();
  if (view.arrows) paint.paintArrows(painter, look);
  stage.vectors(painter.context, look, motion.track, view, app.clock.time);
}

/**
 * The arm that is chosen, the arm under the hand, and the numbers of one of them.
 * @param {Stage} stage
 */
function drawChosen(stage) {
  const { app, painter, look } = stage;
  const { selected } = app.store.get().view;
  const { hover, shape } = look;
  /** @param {number} arm */
  const there = (arm) => arm > 0 && arm <= shape.n;
  if (there(hover) && hover !== selected) paint.paintRing(painter, hover, look, false);
  if (there(selected)) {
    paint.paintRing(painter, selected, look, look.focused);
    if (!app.clock.playing) {
      const angle = app.text.number(foldedTheta(shape.phi[selected - 1]), 1);
      paintAngle(painter.context, look, selected, app.text("arm.theta", { angle }));
    }
  }
  const told = hover || (app.clock.playing ? selected : 0);
  if (there(told))
    paint.paintLabel(painter, numbersOf(app.text, shape, told), told, look, stage.size.width);
}

/** An arm's numbers in words. @param {Text} text @param {Shape} shape @param {number} arm */
function numbersOf(text, { tree, phi, lambda }, arm) {
  return text("arm.numbers", {
    arm,
    length: text.short(tree.length[arm - 1]),
    mass: text.short(massOf(tree, arm - 1)),
    angle: text.number(foldedTheta(phi[arm - 1]), 0),
    force: text.number(lambda[arm - 1], 1),
  });
}

/** @param {Stage} stage @param {number} i */
function drawGhost({ app, look, painter, ghostPlace }, i) {
  const ghost = app.motion.ghosts[i];
  const { shape } = look;
  if (ghost.n !== shape.n) return;
  anglesAt(ghost, app.clock.time, ghostPlace, shape.ghostPhi);
  shape.ghost.cart = cartAt(ghost, ghostPlace.index, ghostPlace.fraction);
  tips(ghost.doc.pendulum, shape.rows, shape.ghostPhi, 0, shape.ghost, shape.time);
  paint.paintGhost(painter, i, look);
}

/** The second pendulum, paler than the one that the tools show. @param {Stage} stage */
function drawSecond({ app, look, painter, ghostPlace }) {
  const { second } = look;
  const other = second && secondOf(app);
  if (!other || other.track.n !== second.n) return;
  const { track } = other;
  anglesAt(track, app.clock.time, ghostPlace, second.phi);
  if (track.columns.lambda) valuesAt(track, "lambda", app.clock.time, ghostPlace, second.lambda);
  second.cart = cartAt(track, ghostPlace.index, ghostPlace.fraction);
  tips(second.tree, second.rows, second.phi, 0, second, look.shape.time);
  const own = { ...look, shape: second };
  painter.context.globalAlpha = 0.6;
  paintUnder(painter, own);
  if (!second.tree.pivot?.cart) paint.paintPivot(painter, own);
  if (second.tree.at) paint.paintBrackets(painter, own);
  paint.paintArms(painter, own);
  paint.paintTips(painter, own);
  paintOver(painter, own);
  painter.context.globalAlpha = 1;
}

/** @param {Stage} stage */
function recolour(stage) {
  stage.look.colours = readColours(stage.app.store.get().view.palette);
  for (const part of stage.parts) part.show?.();
  stage.look.soon();
}

/** @param {Stage} stage */
function describe({ app, canvas }) {
  const n = app.store.get().pendulum.length.length;
  canvas.setAttribute("aria-label", app.text.count("stage.label", n));
}

/** @param {Stage} stage @param {string} what */
function followMotion(stage, what) {
  const { motion, store } = stage.app;
  if (what === "begin" || what === "rows" || what === "complete") {
    stage.stale = true;
    stage.trails.follow(motion.track, store.get().view.trails);
  }
  if (what === "complete") {
    settleShape(stage);
    for (const part of stage.parts) part.show?.();
  }
  stage.look.soon();
}

/** @param {Stage} stage @param {Doc} doc @param {Doc} before */
function followDocument(stage, doc, before) {
  if (doc.view.palette !== before.view.palette) recolour(stage);
  if (doc.view.trails !== before.view.trails)
    stage.trails.follow(stage.app.motion.track, doc.view.trails);
  const { look } = stage;
  // they have changed places, and a hand may hold one of them
  if (look.second && doc.pendulum === look.second.tree)
    [look.shape, look.second] = [look.second, look.shape];
  if (doc.pendulum !== before.pendulum) describe(stage);
  stage.look.soon();
}

/** @param {HTMLElement} element @param {App} app @returns {Stage} with nothing on it */
function createStage(element, app) {
  const canvas = h("canvas", { class: "canvas", role: "img" });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  /** What is on the stage, for those who ask where. */
  const look = {
    shape: shapeOf(app.motion.doc.pendulum),
    camera: { x: 0, y: 0, scale: 0 },
    colours: readColours(app.store.get().view.palette),
    /** @type {Shape | null} */
    second: null,
    most: 0,
    hover: 0,
    focused: false,
    soon() {
      stage.frame ||= requestAnimationFrame(() => draw(stage));
    },
    cardHeight: () => 0,
    cardWidth: () => 0,
  };
  /** @type {Stage} */
  const stage = {
    app,
    element,
    canvas,
    context,
    painter: paint.createPainter(context),
    trails: createTrails(context),
    vectors: createVectors(),
    look,
    place: { index: 0, fraction: 0 },
    ghostPlace: { index: 0, fraction: 0 },
    goal: { x: 0, y: 0, scale: 0 },
    frame: 0,
    last: 0,
    box: null,
    gauges: false, // they have been asked for
    stale: true, // the box and the scale are of an older motion
    size: { width: 0, height: 0, ratio: 1 },
    parts: [],
  };
  element.append(canvas);
  return stage;
}

/**
 * Where on the stage an arm's tip is (0: the pivot), in pixels; for those who point at it.
 * @param {Look} look @param {number} arm @param {boolean} other of the second pendulum
 */
function tipOf({ shape: own, second, camera }, arm, other) {
  const shape = other && second ? second : own;
  return {
    x: camera.x + camera.scale * (arm ? shape.x[arm - 1] : shape.pivot.x),
    y: camera.y - camera.scale * (arm ? shape.y[arm - 1] : shape.pivot.y),
  };
}

/** What is in sight, metres. @param {Stage} stage @returns {Seen} */
function seenOf({ look: { camera }, size }) {
  const scale = camera.scale || 1;
  return {
    left: -camera.x / scale,
    right: (size.width - camera.x) / scale,
    up: camera.y / scale,
    down: (camera.y - size.height) / scale,
  };
}

/**
 * The ruler and the protractor, which come when one of them is wanted.
 * @param {Stage} stage @param {Bag} bag
 */
async function wantGauges(stage, bag) {
  const { app, element, canvas, look } = stage;
  const { ruler, protractor } = app.store.get().view;
  if (stage.gauges || (!ruler && !protractor)) return;
  stage.gauges = true;
  try {
    const [{ default: mount }] = await Promise.all([
      app.files.script("drawers/measure/gauges.js"),
      app.files.style("drawers/measure/gauges.css"),
      app.text.part("measure"),
    ]);
    if (!canvas.isConnected) return;
    const part = tried(app, () => mount(element, app, look));
    app.stage.join(part);
    bag(part.destroy);
  } catch (error) {
    stage.gauges = false;
    app.complain(said(error, app.text));
  }
}

/** @param {HTMLElement} element @param {App} app */
export function mountStage(element, app) {
  const bag = createBag();
  const stage = createStage(element, app);
  const { look, canvas } = stage;
  app.stage = {
    tip: (arm, other = false) => tipOf(look, arm, other),
    camera: look.camera,
    seen: () => seenOf(stage),
    join(part) {
      stage.parts.push(part);
      look.soon();
      return () => stage.parts.splice(stage.parts.indexOf(part), 1);
    },
  };
  // in the order of the tab key
  const mounts = [mountArms, mountCard, mountLegend, mountNotices, mountInvite];
  stage.parts = mounts.map((mount) => tried(app, () => mount(element, app, look)));
  stage.parts.push(tried(app, () => mountHands(canvas, app, look)));
  for (const { destroy } of [...stage.parts].reverse()) if (destroy) bag(destroy);

  bag(app.motion.subscribe((_, what) => followMotion(stage, what)));
  bag(
    app.store.subscribe((doc, before) => {
      followDocument(stage, doc, before);
      wantGauges(stage, bag);
    }),
  );
  bag(app.clock.subscribe(() => (app.clock.framing ? draw(stage) : look.soon())));
  bag(app.theme.subscribe(() => recolour(stage)));
  const observer = new ResizeObserver(() => fit(stage));
  observer.observe(element);
  bag(() => observer.disconnect());
  bag(() => cancelAnimationFrame(stage.frame));
  stage.trails.follow(app.motion.track, app.store.get().view.trails);
  describe(stage);
  // measured by the observer, when the whole page is laid out
  wantGauges(stage, bag);
  return {
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}
