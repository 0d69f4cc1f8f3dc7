// The numbers with a slider of a pendulum on a cart, of bodies fixed to arms, of where an arm hangs
// and of a pivot that goes ever faster.
// Leaves to others: the other numbers (physics_fields.js), the sliders (physics.js).
// Invariant: as of physics_fields.js; a cart or a body of mass 0 is none.

import { DEGREE } from "../../angles.js";
import { centerOf, hangsAt, massOf, shakes, termOf, withTerm } from "../../terms.js";
import { LIGHT, retuned } from "./physics_fields.js";

const TURN = 2 * Math.PI;

/** @typedef {import("./physics_fields.js").Field} Field */
/** @typedef {import("./physics_fields.js").Scale} Scale */

/** The force on a cart, as its constant and its harmonics. @param {Cart | undefined} cart */
const forceOf = (cart) =>
  typeof cart?.force === "number" ? { constant: cart.force } : (cart?.force ?? {});

/**
 * A number of the cart.
 * @param {string} name @param {string} unit @param {(cart: Cart) => number} get
 * @param {(cart: Cart, value: number, time: number, tree: Tree) => Partial<Cart>} change
 * @param {(scale: Scale) => number} most @param {(scale: Scale) => number} [least]
 * @returns {Field}
 */
const ofCart = (name, unit, get, change, most, least) => ({
  name,
  group: "cart",
  unit,
  whole: true,
  get: (tree) => (tree.pivot?.cart ? get(tree.pivot.cart) : 0),
  set: (tree, _, value, time) => {
    const cart = tree.pivot?.cart;
    if (!cart) return tree;
    return { ...tree, pivot: { cart: { ...cart, ...change(cart, value, time, tree) } } };
  },
  most,
  least,
  needs: (tree) => Boolean(tree.pivot?.cart),
});

/** @type {Field} */
const cartMass = {
  name: "cart",
  group: "cart",
  unit: "kg",
  whole: true,
  get: (tree) => tree.pivot?.cart?.mass ?? 0,
  set: (tree, _, mass) => {
    if (mass) return { ...tree, pivot: { cart: { ...tree.pivot?.cart, mass } } };
    const fixed = { ...tree };
    delete fixed.pivot;
    return fixed;
  },
  most: ({ mass }) => 4 * mass,
  // a pivot that is shaken, or drawn away, is no cart
  needs: (tree) => Boolean(tree.pivot?.cart) || !(shakes(tree) || tree.pivot?.acceleration),
};

/** @type {(cart: Cart, change: Partial<Harmonic>, time: number, tree: Tree) => Partial<Cart>} */
const pushed = (cart, change, time, tree) => {
  const { constant = 0, harmonics } = forceOf(cart);
  return { force: { constant, harmonics: retuned(harmonics, change, time, tree) } };
};

/** @type {Field[]} */
const CART = [
  cartMass,
  ofCart(
    "rail",
    "\u00b0",
    ({ angle = 0 }) => angle / DEGREE,
    (_, value) => ({ angle: value * DEGREE }),
    () => 90,
    () => -90,
  ),
  ofCart(
    "cartDamping",
    "N\u00b7s/m",
    ({ damping = 0 }) => damping,
    (_, damping) => ({ damping }),
    ({ mass, omega }) => 2 * mass * omega,
  ),
  ofCart(
    "cartStiffness",
    "N/m",
    ({ stiffness = 0 }) => stiffness,
    (_, stiffness) => ({ stiffness }),
    ({ mass, omega }) => 10 * mass * omega * omega,
  ),
  ofCart(
    "cartForce",
    "N",
    (cart) => forceOf(cart).constant ?? 0,
    (cart, constant) => ({ force: { ...forceOf(cart), constant } }),
    ({ torque, far }) => torque / far,
    ({ torque, far }) => -torque / far,
  ),
  ofCart(
    "cartPush",
    "N",
    (cart) => forceOf(cart).harmonics?.[0]?.amplitude ?? 0,
    (cart, amplitude, time, tree) => pushed(cart, { amplitude }, time, tree),
    ({ torque, far }) => torque / far,
  ),
  {
    ...ofCart(
      "cartRate",
      "Hz",
      (cart) => (forceOf(cart).harmonics?.[0]?.omega ?? 0) / TURN,
      (cart, value, time, tree) => pushed(cart, { omega: value * TURN }, time, tree),
      ({ omega }) => (5 * omega) / TURN,
    ),
    needs: (tree) => Boolean(forceOf(tree.pivot?.cart).harmonics?.length),
  },
];

/** @param {Tree} tree @param {Set<number>} arms @param {number} mass */
function setBody(tree, arms, mass) {
  const bodies = withTerm(tree, "body", (k) => {
    const old = termOf(tree, "body", k);
    if (!arms.has(k)) return old;
    return mass ? { center: tree.length[k] / 2, ...old, mass } : null;
  });
  // an arm without any mass is none
  const tips = tree.mass.map((tip, k) => (massOf(bodies, k) > 0 ? tip : Math.max(tip, LIGHT)));
  return { ...bodies, mass: tips };
}

/**
 * A number of the bodies that there are.
 * @param {string} name @param {string} unit @param {(body: Body) => number} get
 * @param {(body: Body, value: number) => Partial<Body>} change
 * @param {(scale: Scale) => number} most @param {(scale: Scale) => number} [least]
 * @returns {Field}
 */
const ofBody = (name, unit, get, change, most, least) => ({
  name,
  group: "body",
  unit,
  get: (tree, k) => {
    const body = termOf(tree, "body", k);
    return body ? get(body) : 0;
  },
  set: (tree, arms, value) =>
    withTerm(tree, "body", (k) => {
      const body = termOf(tree, "body", k);
      return body && arms.has(k) ? { ...body, ...change(body, value) } : body;
    }),
  most,
  least,
  needs: (tree, k) => termOf(tree, "body", k) !== null,
});

const far = (/** @type {Scale} */ scale) => scale.far;
const back = (/** @type {Scale} */ scale) => -scale.far;

/** @type {Field[]} */
const BODY = [
  {
    name: "body",
    group: "body",
    unit: "kg",
    get: (tree, k) => termOf(tree, "body", k)?.mass ?? 0,
    set: setBody,
    most: ({ mass }) => 2 * mass,
  },
  ofBody(
    "along",
    "m",
    (body) => centerOf(body)[0],
    (body, value) => ({ center: [value, centerOf(body)[1]] }),
    far,
    back,
  ),
  ofBody(
    "across",
    "m",
    (body) => centerOf(body)[1],
    (body, value) => ({ center: [centerOf(body)[0], value] }),
    far,
    back,
  ),
  ofBody(
    "inertia",
    "kg\u00b7m\u00b2",
    ({ inertia = 0 }) => inertia,
    (_, inertia) => ({ inertia }),
    (scale) => scale.mass * scale.far ** 2,
  ),
];

/**
 * Where on its carrier an arm hangs.
 * @param {string} name @param {0 | 1} axis along it, or across
 * @returns {Field}
 */
const hanging = (name, axis) => ({
  name,
  group: "hanging",
  unit: "m",
  get: (tree, k) => hangsAt(tree, k)[axis],
  set: (tree, arms, value) =>
    withTerm(tree, "at", (k) => {
      if (!arms.has(k) || !tree.parent[k]) return termOf(tree, "at", k);
      const at = [...hangsAt(tree, k)];
      at[axis] = value;
      const tip = tree.length[tree.parent[k] - 1];
      return at[0] === tip && !at[1] ? null : at;
    }),
  most: far,
  least: back,
  needs: (tree, k) => tree.parent[k] > 0,
});

/**
 * How much faster the pivot becomes along an axis.
 * @param {string} name @param {0 | 1} axis @returns {Field}
 */
const faster = (name, axis) => ({
  name,
  group: "faster",
  unit: "m/s\u00b2",
  whole: true,
  get: (tree) => tree.pivot?.acceleration?.[axis] ?? 0,
  set: (tree, _, value) => {
    const acceleration = [...(tree.pivot?.acceleration ?? [0, 0])];
    acceleration[axis] = value;
    const pivot = { ...tree.pivot, acceleration };
    if (acceleration.some(Boolean)) return { ...tree, pivot };
    const still = { ...tree };
    delete still.pivot;
    return still;
  },
  most: () => 20,
  least: () => -20,
  needs: (tree) => !tree.pivot?.cart && !shakes(tree),
});

/** @type {Field[]} */
export const MORE_FIELDS = [
  ...CART,
  ...BODY,
  hanging("hangsAlong", 0),
  hanging("hangsAcross", 1),
  faster("fasterAside", 0),
  faster("fasterUp", 1),
];
