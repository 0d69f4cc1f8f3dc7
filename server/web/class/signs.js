// Who in a room gives no sign any more: a page that sleeps, or whose network is gone, says nothing,
// and what stands there of it looks as if somebody worked on it.
// Leaves to others: the signs (sender.js), how it is shown (wall.js).
// Invariant: the server's clock counts, not this machine's; nobody is silent while this page itself
// is not in the room, or has just come back.

const SILENCE_MS = 50000; // two signs are missing (sender.js)
const GRACE_MS = 15000; // in which the others come back as well

/** @param {Session} session */
export function createSigns(session) {
  let since = 0;
  let live = false;
  let first = true;

  /** Takes in what the room has. */
  function hear() {
    if ((session.state === "live") === live) return;
    live = !live;
    // who comes to a room that others are in need not wait for them
    if (live && !first) since = performance.now();
    first = false;
  }
  const { now } = session;
  return {
    hear,
    /** When a pupil has last changed something, by this machine's clock. @param {ClassItem} item */
    changed({ changed, value }) {
      return Date.parse(changed) - 1000 * (value.idle ?? 0) - now() + Date.now();
    },
    /** For how many ms a pupil's page is silent, 0 if it is not. @param {ClassItem} item */
    silence({ changed, value }) {
      const counts = live && !(since && performance.now() - since < GRACE_MS);
      if (!counts || value.idle === undefined || value.state === "away") return 0;
      const past = now() - Date.parse(changed);
      return past > SILENCE_MS ? past : 0;
    },
  };
}
