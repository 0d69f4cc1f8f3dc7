// Pointers on the stage: a tip that is dragged turns its arm (with shift its length follows too), a
// click chooses an arm.
// Leaves to others: what turning does (edits.js), where the tips are (the stage's look).
// Invariant: a press is a click until it has moved; whatever ends it, what was grabbed is released.

import { createBag } from "./dom.js";

const MOVED = 4; // pixels, from which on a press is a drag

/**
 * A press, and how far it has become a drag.
 * @typedef {{id: number, arm: number, x: number, y: number, drag: {turn: number, stretch: number} |
 * null}} Press
 */

/** @typedef {{app: App, canvas: HTMLCanvasElement, look: Look, press: Press | null}} Hands */

/**
 * The arm whose tip is nearest to a point, or whose rod; 0 if none is near.
 * @param {Look} look @param {number} px @param {number} py @param {boolean} coarse
 */
function pick(look, px, py, coarse) {
  const { shape, camera } = look;
  const { x, y, fromX, fromY } = shape;
  const across = (/** @type {number} */ place) => camera.x + camera.scale * place;
  const down = (/** @type {number} */ place) => camera.y - camera.scale * place;
  let arm = 0;
  let least = coarse ? 26 : 15;
  for (let k = 0; k < shape.n; k++) {
    const far = Math.hypot(px - across(x[k]), py - down(y[k]));
    if (far <= least) [arm, least] = [k + 1, far];
  }
  if (arm) return arm;
  least = coarse ? 16 : 8;
  for (let k = 0; k < shape.n; k++) {
    const [ax, ay] = [across(fromX[k]), down(fromY[k])];
    const far = toSegment(px, py, ax, ay, across(x[k]), down(y[k]));
    if (far <= least) [arm, least] = [k + 1, far];
  }
  return arm;
}

/** The same of a second pendulum; 0 without one. @type {typeof pick} */
const pickOther = (look, ...at) => (look.second ? pick({ ...look, shape: look.second }, ...at) : 0);

/**
 * @param {number} px @param {number} py @param {number} ax @param {number} ay @param {number} bx
 * @param {number} by
 */
function toSegment(px, py, ax, ay, bx, by) {
  const long = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
  const share = Math.max(0, Math.min(1, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / long));
  return Math.hypot(px - ax - share * (bx - ax), py - ay - share * (by - ay));
}

/** @param {HTMLCanvasElement} canvas @param {PointerEvent} event @returns {Point} */
function point(canvas, event) {
  const place = canvas.getBoundingClientRect();
  return { x: event.clientX - place.left, y: event.clientY - place.top };
}

/**
 * The pointer as seen from the joint that carries the arm: its angle and distance in metres.
 * @param {Look} look @param {number} arm @param {Point} at
 */
function seen({ shape, camera }, arm, at) {
  const dx = (at.x - camera.x) / camera.scale - shape.fromX[arm - 1];
  const dy = (camera.y - at.y) / camera.scale - shape.fromY[arm - 1];
  return { angle: Math.atan2(dy, dx), far: Math.max(Math.hypot(dx, dy), 1e-3) };
}

/**
 * A press that has moved takes hold of its arm.
 * @param {Hands} hands @param {Press} press @param {Point} at
 */
function begin({ app, canvas, look }, press, at) {
  const { edits, store } = app;
  edits.grab();
  edits.select(press.arm);
  const from = seen(look, press.arm, press);
  const { initial, pendulum } = store.get();
  const turn = initial.phi[press.arm - 1] - from.angle;
  press.drag = { turn, stretch: pendulum.length[press.arm - 1] / from.far };
  canvas.classList.add("grabbing");
  follow(app, look, press, at, false);
}

/**
 * @param {App} app @param {Look} look @param {Press} press @param {Point} at @param {boolean}
 * stretching
 */
function follow(app, look, press, at, stretching) {
  if (!press.drag) return;
  const { angle, far } = seen(look, press.arm, at);
  app.edits.turn(press.arm, angle + press.drag.turn, stretching ? far * press.drag.stretch : null);
}

/**
 * A finger on an arm moves the arm; beside it, it scrolls.
 * @param {Hands} hands @param {TouchEvent} event
 */
function hold({ canvas, look }, event) {
  const [touch] = event.touches;
  const place = canvas.getBoundingClientRect();
  if (event.touches.length > 1) return;
  const [x, y] = [touch.clientX - place.left, touch.clientY - place.top];
  if (pick(look, x, y, true) || pickOther(look, x, y, true)) event.preventDefault();
}

/** @param {Hands} hands @param {PointerEvent} event */
function down(hands, event) {
  if (!event.isPrimary || event.button !== 0) return;
  const at = point(hands.canvas, event);
  const coarse = event.pointerType !== "mouse";
  const own = pick(hands.look, at.x, at.y, coarse);
  const arm = own || pickOther(hands.look, at.x, at.y, coarse);
  if (arm && !own) hands.app.edits.swap();
  if (arm) hands.canvas.setPointerCapture(event.pointerId);
  hands.press = { id: event.pointerId, arm, ...at, drag: null };
}

/** @param {Hands} hands @param {PointerEvent} event */
function move(hands, event) {
  const { app, canvas, look, press } = hands;
  const at = point(canvas, event);
  if (!press || press.id !== event.pointerId) return hover(hands, event, at);
  if (!press.arm) return;
  if (press.drag) follow(app, look, press, at, event.shiftKey);
  else if (Math.hypot(at.x - press.x, at.y - press.y) > MOVED) begin(hands, press, at);
}

/** @param {Hands} hands @param {PointerEvent} event @param {Point} at */
function hover({ canvas, look }, event, at) {
  if (event.pointerType !== "mouse") return;
  const arm = pick(look, at.x, at.y, false);
  canvas.classList.toggle("grab", arm > 0 || pickOther(look, at.x, at.y, false) > 0);
  if (arm === look.hover) return;
  look.hover = arm;
  look.soon();
}

/** @param {Hands} hands @param {PointerEvent} event */
function up(hands, event) {
  const { app, canvas, press } = hands;
  if (!press || press.id !== event.pointerId) return;
  if (press.drag) app.edits.release();
  else if (event.type === "pointerup") app.edits.select(press.arm);
  canvas.classList.remove("grabbing");
  hands.press = null;
}

/** Escape takes a drag back. @param {Hands} hands @param {KeyboardEvent} event */
function escape(hands, event) {
  if (event.key !== "Escape" || !hands.press?.drag) return;
  event.preventDefault();
  hands.app.edits.cancel();
  hands.canvas.classList.remove("grabbing");
  hands.press = null;
}

/** @param {Hands} hands */
function leave({ look }) {
  if (!look.hover) return;
  look.hover = 0;
  look.soon();
}

/** @param {HTMLCanvasElement} canvas @param {App} app @param {Look} look */
export function mountHands(canvas, app, look) {
  const bag = createBag();
  /** @type {Hands} */
  const hands = { app, canvas, look, press: null };
  bag.on(canvas, "touchstart", (event) => hold(hands, event), { passive: false });
  bag.on(canvas, "pointerdown", (event) => down(hands, event));
  bag.on(canvas, "pointermove", (event) => move(hands, event));
  bag.on(canvas, "pointerup", (event) => up(hands, event));
  bag.on(canvas, "pointercancel", (event) => up(hands, event));
  bag.on(canvas, "pointerleave", () => leave(hands));
  bag.on(document, "keydown", (event) => escape(hands, event));
  return { destroy: bag.end };
}
