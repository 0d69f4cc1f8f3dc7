// Pointers on the stage: a tip that is dragged turns its arm (with shift its length follows too), a click chooses an arm.
// Leaves to others: what turning does (edits.js), where the tips are (the stage's look).
// Invariant: a press is a click until it has moved; whatever ends it, what was grabbed is released.

import { createBag } from "./dom.js";

const MOVED = 4; // pixels, from which on a press is a drag

/** The arm whose tip is nearest to a point, or whose rod; 0 if none is near. */
function pick(look, px, py, coarse) {
  const { shape, camera } = look;
  const { tree, x, y } = shape;
  const across = (k) => camera.x + camera.scale * (k < 0 ? 0 : x[k]);
  const down = (k) => camera.y - camera.scale * (k < 0 ? 0 : y[k]);
  let arm = 0;
  let least = coarse ? 26 : 15;
  for (let k = 0; k < shape.n; k++) {
    const far = Math.hypot(px - across(k), py - down(k));
    if (far <= least) [arm, least] = [k + 1, far];
  }
  if (arm) return arm;
  least = coarse ? 16 : 8;
  for (let k = 0; k < shape.n; k++) {
    const from = tree.parent[k] - 1;
    const far = toSegment(px, py, across(from), down(from), across(k), down(k));
    if (far <= least) [arm, least] = [k + 1, far];
  }
  return arm;
}

function toSegment(px, py, ax, ay, bx, by) {
  const long = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
  const share = Math.max(0, Math.min(1, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / long));
  return Math.hypot(px - ax - share * (bx - ax), py - ay - share * (by - ay));
}

export function mountHands(canvas, app, look) {
  const { edits, store } = app;
  const bag = createBag();
  let press = null; // {id, arm, x, y, drag: {turn, stretch} or null}

  function point(event) {
    const place = canvas.getBoundingClientRect();
    return { x: event.clientX - place.left, y: event.clientY - place.top };
  }

  /** The pointer as seen from the joint that carries the arm: its angle and distance in metres. */
  function seen(arm, at) {
    const { shape, camera } = look;
    const carrier = shape.tree.parent[arm - 1];
    const dx = (at.x - camera.x) / camera.scale - (carrier ? shape.x[carrier - 1] : 0);
    const dy = (camera.y - at.y) / camera.scale - (carrier ? shape.y[carrier - 1] : 0);
    return { angle: Math.atan2(dy, dx), far: Math.max(Math.hypot(dx, dy), 1e-3) };
  }

  function begin(at) {
    edits.grab();
    edits.select(press.arm);
    const from = seen(press.arm, { x: press.x, y: press.y });
    const { initial, pendulum } = store.get();
    press.drag = {
      turn: initial.phi[press.arm - 1] - from.angle,
      stretch: pendulum.length[press.arm - 1] / from.far,
    };
    canvas.classList.add("grabbing");
    follow(at, false);
  }

  function follow(at, stretching) {
    const { angle, far } = seen(press.arm, at);
    edits.turn(press.arm, angle + press.drag.turn, stretching ? far * press.drag.stretch : null);
  }

  function down(event) {
    if (!event.isPrimary || event.button !== 0) return;
    const at = point(event);
    const arm = pick(look, at.x, at.y, event.pointerType !== "mouse");
    if (arm) canvas.setPointerCapture(event.pointerId);
    press = { id: event.pointerId, arm, ...at, drag: null };
  }

  function move(event) {
    const at = point(event);
    if (!press || press.id !== event.pointerId) return hover(event, at);
    if (!press.arm) return;
    if (press.drag) follow(at, event.shiftKey);
    else if (Math.hypot(at.x - press.x, at.y - press.y) > MOVED) begin(at);
  }

  function hover(event, at) {
    if (event.pointerType !== "mouse") return;
    const arm = pick(look, at.x, at.y, false);
    canvas.classList.toggle("grab", arm > 0);
    if (arm === look.hover) return;
    look.hover = arm;
    look.soon();
  }

  function up(event) {
    if (!press || press.id !== event.pointerId) return;
    if (press.drag) edits.release();
    else if (event.type === "pointerup") edits.select(press.arm);
    canvas.classList.remove("grabbing");
    press = null;
  }

  /** Escape takes a drag back. */
  function escape(event) {
    if (event.key !== "Escape" || !press?.drag) return;
    event.preventDefault();
    edits.cancel();
    canvas.classList.remove("grabbing");
    press = null;
  }

  function leave() {
    if (!look.hover) return;
    look.hover = 0;
    look.soon();
  }

  bag.on(canvas, "pointerdown", down);
  bag.on(canvas, "pointermove", move);
  bag.on(canvas, "pointerup", up);
  bag.on(canvas, "pointercancel", up);
  bag.on(canvas, "pointerleave", leave);
  bag.on(document, "keydown", escape);
  return { destroy: bag.end };
}
