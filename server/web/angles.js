// Angles as people read and type them: from hanging, in degrees, counterclockwise (θ); and as
// requests have them: from the horizontal, in radians (phi).
// Leaves to others: words beside them.
// Invariant: theta = phi + 90 degrees; 0 is hanging, 90 points to the right, 180 upwards.

const HANGING = -Math.PI / 2;
export const DEGREE = Math.PI / 180;

/** Degrees from hanging, with its full turns. @param {number} phi */
export const thetaOf = (phi) => (phi - HANGING) / DEGREE;

/** @param {number} theta degrees from hanging */
export const phiOf = (theta) => HANGING + theta * DEGREE;

/** Degrees from hanging without full turns, in (-180, 180]. @param {number} phi */
export function foldedTheta(phi) {
  // of many turns a quotient has no digits left, where sine and cosine have theirs
  const theta = thetaOf(Math.abs(phi) < 1e6 ? phi : Math.atan2(Math.sin(phi), Math.cos(phi)));
  return theta - 360 * Math.ceil(theta / 360 - 0.5);
}
