// The forces of a pendulum that is held: asked of the server again and again while a hand turns it,
// so that colours follow the hand.
// Leaves to others: drawing them.
// Invariant: one question at a time, the newest shape next; a failure is silent, the motion that
// follows will tell.

import { smoothOf } from "./terms.js";

/** Begins; answers what ends it. @param {{motion: Motion, client: Client}} parts @returns {End} */
export function followForces({ motion, client }) {
  let asking = false;
  let again = false;

  async function ask() {
    again = asking;
    if (asking) return;
    asking = true;
    const { pendulum, initial } = motion.track.doc;
    try {
      const { lambda } = await client.forces({
        pendulum: smoothOf(pendulum),
        state: { phi: initial.phi, phid: initial.phid },
      });
      motion.foresee(lambda);
    } catch (failure) {
      if (/** @type {Failed} */ (failure).kind === undefined) throw failure;
    } finally {
      asking = false;
    }
    if (again && motion.held) ask();
  }

  return motion.subscribe((_, what) => what === "begin" && motion.held && ask());
}
