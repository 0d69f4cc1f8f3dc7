// What there is to draw on: whether motion is wanted there, how fine it is, whether the page's
// style is in force.
// Leaves to others: what stands still then, what is said of a style that did not come.
// Invariant: asked anew at each look, so that a change takes effect.

const FINEST = 2;

/** Whether motion is unwanted, as the system says: still.matches. */
export const still = matchMedia("(prefers-reduced-motion: reduce)");

/**
 * Whether the page's own style sheet is not in force: one that was refused is there, without a
 * rule.
 */
export const bare = () => !getComputedStyle(document.documentElement).getPropertyValue("--paper");

/**
 * How many pixels of a canvas make one of the page; without a style a canvas is as large as its
 * pixels.
 */
export const fineness = () => (bare() ? 1 : Math.min(devicePixelRatio, FINEST));
