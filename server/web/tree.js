// A pendulum tree as arrays {length, mass, parent, gravity}, and lists of terms: where its joints
// and tips are, and trees made from it.
// Leaves to others: forces and motion, which only the server computes.
// Invariant: arms are numbered from 1, 0 is the pivot; trees made here are valid, what is given
// stays as it was.

import { ROWS, centerOf, hangsAt, massOf, placeAt, shakes, termOf, withTerm } from "./terms.js";

/**
 * Indices (from 0) of all arms such that every parent comes before its children.
 * @param {number[]} parent
 */
export function order(parent) {
  /** @type {number[]} */
  const rows = [];
  const kids = children(parent);
  const wait = [...kids[0]];
  for (let i = 0; i < wait.length; i++) {
    rows.push(wait[i] - 1);
    wait.push(...kids[wait[i]]);
  }
  return rows;
}

/**
 * children(parent)[arm]: the arms that hang on it; [0] those at the pivot.
 * @param {number[]} parent
 */
export function children(parent) {
  /** @type {number[][]} */
  const rows = Array.from({ length: parent.length + 1 }, () => []);
  parent.forEach((carrier, k) => rows[carrier].push(k + 1));
  return rows;
}

/**
 * Room for the places of n arms.
 * @param {number} n @param {number} apart m, of one of two pendulums side by side
 * @returns {Spots}
 */
export const createSpots = (n, apart = 0) => ({
  x: new Float64Array(n),
  y: new Float64Array(n),
  fromX: new Float64Array(n),
  fromY: new Float64Array(n),
  pivot: { x: 0, y: 0 },
  cart: 0,
  apart,
});

/**
 * Where the pivot is at a time, but for its constant acceleration, with which the eye goes.
 * @param {Tree} tree @param {number} time s of the request's own time @param {Point} pivot
 * @param {number} cart the place of the cart, where the pivot is on one, m
 */
export function pivotAt(tree, time, pivot, cart = 0) {
  pivot.x = placeAt(tree.pivot?.x, time);
  pivot.y = placeAt(tree.pivot?.y, time);
  if (!tree.pivot?.cart) return;
  const { angle = 0 } = tree.pivot.cart;
  pivot.x += cart * Math.cos(angle);
  pivot.y += cart * Math.sin(angle);
}

/**
 * Writes the joints and tips of all arms into spots (metres, from where the pivot is at rest, y
 * upwards); phi from offset on. An ideal tree's allocates nothing.
 * @param {Tree} tree @param {number[]} rows @param {ArrayLike<number>} phi @param {number} offset
 * @param {Spots} spots @param {number} time s of the request's own time
 */
export function tips(tree, rows, phi, offset, spots, time = 0) {
  const { x, y, fromX, fromY, pivot } = spots;
  pivotAt(tree, time, pivot, spots.cart);
  pivot.x += spots.apart;
  for (let i = 0; i < rows.length; i++) {
    const k = rows[i];
    const carrier = tree.parent[k] - 1;
    fromX[k] = carrier < 0 ? pivot.x : x[carrier];
    fromY[k] = carrier < 0 ? pivot.y : y[carrier];
    if (tree.at && carrier >= 0 && termOf(tree, "at", k) !== null)
      hang(tree, k, phi[offset + carrier], spots);
    x[k] = fromX[k] + tree.length[k] * Math.cos(phi[offset + k]);
    y[k] = fromY[k] + tree.length[k] * Math.sin(phi[offset + k]);
  }
}

/**
 * The joint of an arm that hangs elsewhere than at its parent's tip.
 * @param {Tree} tree @param {number} k @param {number} angle of the parent @param {Spots} spots
 */
function hang(tree, k, angle, { fromX, fromY }) {
  const carrier = tree.parent[k] - 1;
  const [along, across] = hangsAt(tree, k);
  fromX[k] = fromX[carrier] + along * Math.cos(angle) - across * Math.sin(angle);
  fromY[k] = fromY[carrier] + along * Math.sin(angle) + across * Math.cos(angle);
}

/**
 * Calls line(ax, ay, bx, by) for every joint that is not on the parent's arm: from the nearest
 * point of the arm to the joint, metres.
 * @param {Tree} tree @param {Spots} spots
 * @param {(ax: number, ay: number, bx: number, by: number) => unknown} line
 */
export function brackets(tree, { x, y, fromX, fromY }, line) {
  for (let k = 0; k < (tree.at?.length ?? 0); k++) {
    const carrier = tree.parent[k] - 1;
    if (carrier < 0 || termOf(tree, "at", k) === null) continue;
    const long = tree.length[carrier];
    const share = Math.max(0, Math.min(1, hangsAt(tree, k)[0] / long));
    const ax = fromX[carrier] + share * (x[carrier] - fromX[carrier]);
    const ay = fromY[carrier] + share * (y[carrier] - fromY[carrier]);
    line(ax, ay, fromX[k], fromY[k]);
  }
}

/**
 * The arms from the pivot to this arm, this arm last.
 * @param {number[]} parent @param {number} arm
 */
export function path(parent, arm) {
  /** @type {number[]} */
  const rows = [];
  for (let k = arm; k > 0; k = parent[k - 1]) rows.unshift(k);
  return rows;
}

/** How far the farthest part can be from where the pivot rests. @param {Tree} tree */
export function reach(tree) {
  const joint = new Float64Array(tree.length.length);
  let most = 0;
  for (const k of order(tree.parent)) {
    const carrier = tree.parent[k] - 1;
    joint[k] = carrier < 0 ? shakes(tree) : joint[carrier] + Math.hypot(...hangsAt(tree, k));
    const body = termOf(tree, "body", k);
    const far = Math.max(tree.length[k], body ? Math.hypot(...centerOf(body)) : 0);
    most = Math.max(most, joint[k] + far);
  }
  return most;
}

/**
 * The least energy of height, J, counted from the pivot: each arm's center of mass, with all that
 * it carries, straight below its joint.
 * @param {Tree} tree
 */
export function lowest(tree) {
  const mass = tree.mass.map((_, k) => massOf(tree, k));
  const moment = tree.length.map((length, k) => {
    const body = termOf(tree, "body", k);
    const [along, across] = body ? centerOf(body) : [0, 0];
    const bar = (tree.mass[k] + (termOf(tree, "rod", k) ?? 0) / 2) * length;
    return [bar + (body?.mass ?? 0) * along, (body?.mass ?? 0) * across];
  });
  for (const k of order(tree.parent).reverse()) {
    const carrier = tree.parent[k] - 1;
    if (carrier < 0) continue;
    mass[carrier] += mass[k];
    hangsAt(tree, k).forEach((part, i) => (moment[carrier][i] += mass[k] * part));
  }
  return -Math.abs(tree.gravity) * moment.reduce((sum, [x, y]) => sum + Math.hypot(x, y), 0);
}

/** The arm and all that hangs on it. @param {number[]} parent @param {number} arm */
export function branch(parent, arm) {
  const kids = children(parent);
  const rows = [arm];
  for (let i = 0; i < rows.length; i++) rows.push(...kids[rows[i]]);
  return rows;
}

/**
 * Whether the branch may be taken away: something must stay.
 * @param {number[]} parent @param {number} arm
 */
export function removable(parent, arm) {
  return branch(parent, arm).length < parent.length;
}

/**
 * Terms by which a new arm is like the one that carries it, where it is a bar: a rig is of one
 * make.
 * @type {import("./terms.js").Row[]}
 */
const ALIKE = ["rod", "damping", "friction"];

/**
 * The mass at a new arm's tip on `carrier`: 0 of a bar, else as much as the carrier weighs.
 * @param {Tree} tree @param {number} carrier
 */
export const tipMass = (tree, carrier) =>
  termOf(tree, "rod", carrier - 1) ? tree.mass[carrier - 1] : massOf(tree, carrier - 1);

/**
 * {pendulum, initial, ghosts} with one more arm on `carrier`, its number the last.
 * @param {Doc} doc @param {number} carrier @param {{length: number, mass: number, phi: number}} arm
 */
export function withArm(doc, carrier, { length, mass, phi }) {
  const { pendulum } = doc;
  /** @template {State} Start @param {Start} state @returns {Start} */
  const longer = (state) => ({ ...state, phi: [...state.phi, phi], phid: [...state.phid, 0] });
  /** @param {Ghost} ghost @returns {Ghost} */
  const grownGhost = (ghost) => {
    if (!ghost.pendulum) return longer(ghost);
    const own = { ...doc, pendulum: ghost.pendulum, ghosts: [] };
    return { ...longer(ghost), pendulum: withArm(own, carrier, { length, mass, phi }).pendulum };
  };
  /** @type {Tree} */
  let grown = {
    ...pendulum,
    length: [...pendulum.length, length],
    mass: [...pendulum.mass, mass],
    parent: [...pendulum.parent, carrier],
  };
  // gains are of so many arms
  delete grown.control;
  for (const name of ROWS) {
    const like = ALIKE.includes(name) ? termOf(pendulum, name, carrier - 1) : null;
    if (pendulum[name])
      grown = withTerm(
        grown,
        name,
        (k) => pendulum[name]?.[k] ?? (k < pendulum.length.length ? null : like),
      );
  }
  return {
    pendulum: grown,
    initial: longer(doc.initial),
    ghosts: doc.ghosts.map(grownGhost),
  };
}

/**
 * A ghost whose own pendulum, where it has one, is without the arm and its branch too.
 * @param {Doc} doc @param {Ghost} ghost @param {number} arm @returns {Ghost}
 */
function shorterGhost(doc, ghost, arm) {
  if (!ghost.pendulum) return ghost;
  const own = withoutBranch({ ...doc, pendulum: ghost.pendulum, ghosts: [] }, arm);
  return { ...ghost, pendulum: own.pendulum };
}

/**
 * {pendulum, initial, ghosts, view} without the arm and its branch; the others close up.
 * @param {Doc} doc @param {number} arm
 * @returns {{pendulum: Tree, initial: State, ghosts: Ghost[], view: View}}
 */
export function withoutBranch(doc, arm) {
  const { pendulum } = doc;
  const gone = new Set(branch(pendulum.parent, arm));
  const keep = pendulum.parent.map((_, k) => k).filter((k) => !gone.has(k + 1));
  const number = new Map(keep.map((k, i) => [k + 1, i + 1]));
  /** @param {number[]} list */
  const pick = (list) => keep.map((k) => list[k]);
  /** @template {State} Start @param {Start} state @returns {Start} */
  const shorter = (state) => ({ ...state, phi: pick(state.phi), phid: pick(state.phid) });
  /** @type {Tree} */
  let rest = {
    ...pendulum,
    length: pick(pendulum.length),
    mass: pick(pendulum.mass),
    parent: pick(pendulum.parent).map((carrier) => number.get(carrier) ?? 0),
  };
  delete rest.control;
  for (const name of ROWS)
    if (pendulum[name]) rest = withTerm(rest, name, (k) => termOf(pendulum, name, keep[k]));
  return {
    pendulum: rest,
    initial: shorter(doc.initial),
    ghosts: doc.ghosts.map((ghost) => shorterGhost(doc, shorter(ghost), arm)),
    view: {
      ...doc.view,
      selected: number.get(pendulum.parent[arm - 1]) ?? 0,
      trails: doc.view.trails.filter((tip) => !gone.has(tip)).map((tip) => number.get(tip) ?? 0),
    },
  };
}
