// A controller in numbers: what is asked of the server, what of its answer acts, examples.
// Leaves to others: the design itself (the server), the controls (control.js).
// Invariant: angles from hanging; a reference is that of the turns at which an arm is.

import { thetaOf } from "../../angles.js";
import { pendulumOf, smoothOf } from "../../terms.js";
import { scaleOf } from "../physics/physics_fields.js";

const TURN = 2 * Math.PI;
/** How near a swing-up has to come before the feedback takes over: rad, rad/s. */
const WITHIN = { theta: 0.4, thetad: 3 };

/**
 * What is wished for: what acts (an arm's joint, 0: the cart), which arms stand upright, weights of
 * a deviation and of the effort as powers of ten, s between samples, the most that acts (0: no
 * limit), swinging up first.
 * @typedef {{
 *   motor: number, up: boolean[], deviation: number, effort: number, period: number, limit: number,
 *   swing: boolean,
 * }} Wish
 */

/** What can act: the cart (0) and the joints. @param {Tree} tree */
export const actuators = ({ length, pivot }) => [
  ...(pivot?.cart ? [0] : []),
  ...length.map((_, k) => k + 1),
];

/** Which arms are nearer to upright than to hanging. @param {ArrayLike<number>} phi */
export const poseOf = (phi) => Array.from(phi, (one) => Math.abs(thetaOf(one)) > 90);

/** A force or a torque that is large for a pendulum. @param {Tree} tree @param {number} motor */
function large(tree, motor) {
  const { torque, far } = scaleOf(tree);
  return motor ? torque : torque / far;
}

/** A pendulum with another controller, or none. @param {Tree} tree @param {object[]} [control] */
export function withControl(tree, control) {
  const { ...changed } = tree;
  delete changed.control;
  return control ? { ...changed, control } : changed;
}

/** The body for POST /v1/controllers. @param {Tree} tree @param {Wish} wish */
export function designBody(tree, { motor, up, deviation, effort, period }) {
  // a design is of the smooth pendulum: what sticks or hits is left out
  const pendulum = pendulumOf(smoothOf(tree));
  const arms = up.map(() => 10 ** deviation);
  const still = up.map(() => 0);
  const cart = tree.pivot?.cart ? [10 ** deviation, 0] : [];
  return {
    pendulum,
    equilibrium: { theta: up.map((one) => (one ? 180 : 0)), unit: "deg" },
    actuators: motor ? { joints: [motor] } : { cart: true },
    period,
    Q: [...arms, ...still, ...cart],
    R: [10 ** effort / large(tree, motor) ** 2],
  };
}

/**
 * The controller of an answer for a pendulum at the angles phi.
 * @param {any} answer @param {Wish} wish @param {ArrayLike<number>} phi
 */
export function controlOf({ control: [made] }, { limit, swing, up, motor }, phi) {
  const { gains, reference } = made.law.feedback;
  const turned = reference.map((/** @type {number} */ angle, /** @type {number} */ i) => {
    if (i >= up.length) return angle;
    const theta = phi[i] + Math.PI / 2;
    return angle + TURN * Math.round((theta - angle) / TURN);
  });
  const catches = { feedback: { gains, reference: turned } };
  // energy at a rate that suits pendulums of a table; a cart stays near its place
  const law =
    swing && up.length <= 2
      ? {
          swing_up: {
            gain: motor ? 2 : 100,
            ...(motor ? {} : { p: 1, d: 1 }),
            within: WITHIN,
            then: catches,
          },
        }
      : catches;
  return [{ ...made, law, ...(limit && { limit: [-limit, limit] }) }];
}

const WISH = { motor: 0, deviation: 0, effort: 0, limit: 20, swing: false, period: 0.01 };

/**
 * @param {number[]} length @param {number[]} theta degrees @param {Partial<Wish>} wish
 * @param {object} terms
 */
const armsOf = (length, theta, wish, terms) => ({
  pendulum: {
    length,
    mass: length.map(() => 0.2),
    parent: length.map((_, k) => k),
    gravity: 9.81,
    ...terms,
  },
  initial: {
    phi: theta.map((angle) => ((angle - 90) * Math.PI) / 180),
    phid: theta.map(() => 0),
  },
  wish: { ...WISH, ...wish },
});

/** @param {number[]} length @param {number[]} theta degrees @param {Partial<Wish>} wish */
function onCart(length, theta, wish) {
  const made = armsOf(length, theta, wish, { pivot: { cart: { mass: 0.5 } } });
  return { ...made, initial: { ...made.initial, cart: { x: 0, v: 0 } } };
}

/**
 * Two arms with a motor in one joint, which swings them up.
 * @param {number} motor @param {number[]} theta degrees
 */
const byMotor = (motor, theta) =>
  armsOf([0.5, 0.5], theta, { motor, limit: 3, swing: true }, { damping: [0.002, 0.002] });

/** Pendulums that are held. */
export const EXAMPLES = [
  { name: "one", ...onCart([0.5], [170], {}) },
  { name: "two", ...onCart([0.5, 0.4], [177, 183], {}) },
  { name: "three", ...onCart([0.5, 0.4, 0.3], [179, 181, 180], { period: 0.005 }) },
  { name: "swing", ...onCart([0.5], [1], { swing: true, limit: 5, period: 0.02 }) },
  { name: "pendubot", ...byMotor(1, [10, 90]) },
  { name: "acrobot", ...byMotor(2, [57, 0]) },
];
