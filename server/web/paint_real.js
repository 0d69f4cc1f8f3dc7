// Draws what a pendulum has beyond an ideal one: bars and bodies of their mass, springs, friction
// and motors at joints, the pivot's way.
// Leaves to others: arms and tips (paint.js), where they are (tree.js), what the numbers are
// (terms.js).
// Invariant: nothing is drawn of what a pendulum has not, and then nothing is computed.

import { across, down } from "./paint.js";
import { centerOf, farOf, shakes, strongest, termOf, torqueAt } from "./terms.js";

const SPRING_TURNS = 2.5;
const BAR = 7; // pixels of half the width of the heaviest bar
const MOTOR = 21; // pixels of the arc's radius

/** @typedef {import("./paint.js").Painter} Painter */

/** Bars as wide as their mass. @param {Painter} painter @param {Look} look */
function paintBars({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY, x, y } = shape;
  context.fillStyle = context.strokeStyle = colours.mass;
  for (let k = 0; k < shape.n; k++) {
    const mass = termOf(tree, "rod", k);
    if (mass === null) continue;
    const half = Math.max(2.5, BAR * Math.cbrt(mass / shape.heaviest));
    const dx = camera.scale * (x[k] - fromX[k]);
    const dy = -camera.scale * (y[k] - fromY[k]);
    const long = Math.hypot(dx, dy) || 1;
    const [nx, ny] = [(-dy / long) * half, (dx / long) * half];
    const [ax, ay] = [across(camera, fromX[k]), down(camera, fromY[k])];
    context.beginPath();
    context.moveTo(ax + nx, ay + ny);
    context.lineTo(ax + dx + nx, ay + dy + ny);
    context.lineTo(ax + dx - nx, ay + dy - ny);
    context.lineTo(ax - nx, ay - ny);
    context.closePath();
    context.globalAlpha = 0.16;
    context.fill();
    context.globalAlpha = 0.7;
    context.lineWidth = 1;
    context.stroke();
  }
  context.globalAlpha = 1;
}

/**
 * Bodies as discs of their mass and inertia, with the mark of their center.
 * @param {Painter} painter @param {Look} look
 */
function paintBodies({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY, phi } = shape;
  context.fillStyle = context.strokeStyle = colours.mass;
  context.lineWidth = 1;
  for (let k = 0; k < shape.n; k++) {
    const body = termOf(tree, "body", k);
    if (!body) continue;
    const [along, beside] = centerOf(body);
    const [cos, sin] = [Math.cos(phi[k]), Math.sin(phi[k])];
    const px = across(camera, fromX[k] + along * cos - beside * sin);
    const py = down(camera, fromY[k] + along * sin + beside * cos);
    // what holds it, where it is not on the arm itself
    const share = Math.max(0, Math.min(1, along / tree.length[k])) * tree.length[k];
    context.beginPath();
    context.moveTo(across(camera, fromX[k] + share * cos), down(camera, fromY[k] + share * sin));
    context.lineTo(px, py);
    context.lineWidth = shape.thin;
    context.stroke();
    context.lineWidth = 1;
    // a uniform disc of this inertia
    const radius = Math.max(4, camera.scale * Math.sqrt((2 * (body.inertia ?? 0)) / body.mass));
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.globalAlpha = 0.16;
    context.fill();
    context.globalAlpha = 0.7;
    context.stroke();
    // two quarters filled: a center of mass
    context.globalAlpha = 0.9;
    context.beginPath();
    for (const quarter of [0, Math.PI]) {
      context.moveTo(px, py);
      context.arc(px, py, 4, quarter, quarter + Math.PI / 2);
    }
    context.fill();
    context.beginPath();
    context.arc(px, py, 4, 0, 2 * Math.PI);
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** The angle of what an arm hangs on. @param {Shape} shape @param {number} k */
const baseOf = ({ tree, phi }, k) => (tree.parent[k] ? phi[tree.parent[k] - 1] : -Math.PI / 2);

/**
 * Springs as spirals, from what carries the arm to the arm: they are wound up as it turns.
 * @param {Painter} painter @param {Look} look
 */
function paintSprings({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY, phi } = shape;
  context.strokeStyle = colours.trails[2];
  context.lineWidth = 1.6;
  context.lineCap = "round";
  for (let k = 0; k < shape.n; k++) {
    if (!termOf(tree, "stiffness", k)) continue;
    const [px, py] = [across(camera, fromX[k]), down(camera, fromY[k])];
    const from = baseOf(shape, k) - 2 * Math.PI * SPRING_TURNS;
    const turn = phi[k] - from;
    const outer = Math.max(7, Math.min(17, 0.4 * camera.scale * tree.length[k]));
    context.beginPath();
    for (let i = 0; i <= 60; i++) {
      const share = i / 60;
      const r = 3 + (outer - 3) * share;
      const angle = from + turn * share;
      context.lineTo(px + r * Math.cos(angle), py - r * Math.sin(angle));
    }
    context.stroke();
  }
}

/**
 * Rings around joints with friction: whole where it is of oil, broken where it is dry.
 * @param {Painter} painter @param {Look} look
 */
function paintFriction({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY } = shape;
  context.strokeStyle = colours.quiet;
  context.lineWidth = 2.2;
  for (let k = 0; k < shape.n; k++) {
    const oil = termOf(tree, "damping", k);
    const dry = termOf(tree, "friction", k)?.torque;
    if (!oil && !dry) continue;
    context.setLineDash(oil ? [] : [2.5, 2.5]);
    context.beginPath();
    context.arc(across(camera, fromX[k]), down(camera, fromY[k]), 8, 0, 2 * Math.PI);
    context.stroke();
  }
  context.setLineDash([]);
}

/**
 * A motor's torque of now as an arc with a head: the longer the stronger.
 * @param {Painter} painter @param {Look} look
 */
function paintMotors({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY, phi, time } = shape;
  context.strokeStyle = colours.accent;
  context.lineWidth = 2.4;
  context.lineCap = "round";
  for (let k = 0; k < shape.n; k++) {
    const most = strongest(tree, k);
    if (!most) continue;
    const turn = (torqueAt(tree, k, time) / most) * 0.75 * Math.PI;
    if (Math.abs(turn) < 0.02) continue;
    const [px, py] = [across(camera, fromX[k]), down(camera, fromY[k])];
    const to = phi[k] + turn;
    context.beginPath();
    context.arc(px, py, MOTOR, -phi[k], -to, turn > 0);
    const [tx, ty] = [px + MOTOR * Math.cos(to), py - MOTOR * Math.sin(to)];
    const head = Math.min(8, 12 * Math.abs(turn)) * Math.sign(turn);
    for (const side of [-0.5, 0.5]) {
      const angle = to - Math.PI / 2 + side;
      context.moveTo(tx, ty);
      context.lineTo(tx + head * Math.cos(angle), ty - head * Math.sin(angle));
    }
    context.stroke();
  }
}

/** Where a pivot that shakes can be. @param {Painter} painter @param {Look} look */
function paintWay({ context }, { shape, camera, colours }) {
  const { pivot } = shape.tree;
  const [x, y] = [camera.scale * farOf(pivot?.x), camera.scale * farOf(pivot?.y)];
  context.strokeStyle = colours.quiet;
  context.globalAlpha = 0.5;
  context.lineWidth = 1;
  context.strokeRect(camera.x - x, camera.y - y, 2 * x, 2 * y);
  context.globalAlpha = 1;
}

/** A cart on its rail. @param {Painter} painter @param {Look} look */
function paintCart({ context }, { shape, camera, colours }) {
  const { angle = 0 } = shape.tree.pivot?.cart ?? {};
  const wide = Math.max(18, Math.min(46, 0.25 * camera.scale * shape.reach));
  const high = 0.45 * wide;
  context.save();
  context.translate(camera.x, camera.y);
  context.rotate(-angle);
  context.strokeStyle = colours.quiet;
  context.lineWidth = 1.4;
  context.beginPath();
  context.moveTo(-4000, high + 6);
  context.lineTo(4000, high + 6);
  context.stroke();
  context.translate(camera.scale * shape.cart, 0);
  context.fillStyle = colours.paper;
  context.beginPath();
  context.rect(-wide / 2, -high / 2, wide, high);
  for (const x of [-0.3 * wide, 0.3 * wide]) {
    context.moveTo(x + high / 4 + 3, high * 0.75 + 3);
    context.arc(x, high * 0.75 + 3, high / 4 + 3, 0, 2 * Math.PI);
  }
  context.fill();
  context.stroke();
  context.beginPath();
  context.arc(0, 0, 4, 0, 2 * Math.PI);
  context.stroke();
  context.restore();
}

/** Stops as lines from their joints. @param {Painter} painter @param {Look} look */
function paintStops({ context }, { shape, camera, colours }) {
  const { tree, fromX, fromY, phi } = shape;
  context.strokeStyle = colours.quiet;
  context.lineWidth = 3;
  context.beginPath();
  tree.parent.forEach((carrier, k) => {
    const { min = NaN, max = NaN } = termOf(tree, "stop", k) ?? {};
    const [px, py] = [across(camera, fromX[k]), down(camera, fromY[k])];
    const long = 0.6 * camera.scale * tree.length[k];
    for (const angle of [min, max].filter(Number.isFinite)) {
      const at = angle + (carrier ? phi[carrier - 1] : -Math.PI / 2);
      context.moveTo(px, py);
      context.lineTo(px + long * Math.cos(at), py - long * Math.sin(at));
    }
  });
  context.stroke();
}

/** What lies under the arms. @param {Painter} painter @param {Look} look */
export function paintUnder(painter, look) {
  const { tree } = look.shape;
  if (tree.pivot?.cart) paintCart(painter, look);
  else if (tree.pivot && shakes(tree)) paintWay(painter, look);
  if (tree.stop) paintStops(painter, look);
  if (tree.rod) paintBars(painter, look);
  if (tree.body) paintBodies(painter, look);
}

/** What lies over them. @param {Painter} painter @param {Look} look */
export function paintOver(painter, look) {
  const { tree } = look.shape;
  if (tree.damping || tree.friction) paintFriction(painter, look);
  if (tree.stiffness) paintSprings(painter, look);
  if (tree.torque) paintMotors(painter, look);
}
