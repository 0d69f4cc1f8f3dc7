// A tab that was asleep, or a clock of the machine that jumped: the motion goes on from where it
// was, and the page says so.
// Leaves to others: the motion's own time, which follows neither (clock.js).
// Invariant: nothing is drawn or asked for by looking.

const LOOK_MS = 5000;
/** s of a gap that is told. */
const GAP = 60;

/**
 * Looks at both clocks every few seconds, and when the tab comes back.
 * @param {App} app @returns {End}
 */
export function watchSleep({ text, complain }) {
  let [wall, steady] = [Date.now(), performance.now()];
  function look() {
    const [now, passed] = [Date.now(), performance.now()];
    const jump = (now - wall - (passed - steady)) / 1000;
    const slept = (passed - steady) / 1000;
    [wall, steady] = [now, passed];
    if (jump < -GAP) complain(text.count("asleep.back", Math.round(-jump / 60)));
    else if (jump > GAP) complain(text.count("asleep.jump", Math.round(jump / 60)));
    else if (slept > GAP + LOOK_MS / 1000)
      complain(text.count("asleep.slept", Math.round(slept / 60)));
  }
  const timer = setInterval(look, LOOK_MS);
  // a tab in the background is asked once a minute at most, which is no sleep
  const back = () => !document.hidden && look();
  document.addEventListener("visibilitychange", back);
  return () => {
    clearInterval(timer);
    document.removeEventListener("visibilitychange", back);
  };
}
