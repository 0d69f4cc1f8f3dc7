// A stopwatch of the motion's own time: started, stopped, and its laps, by hand.
// Leaves to others: the clock; the true period (periods.js).
// Invariant: it runs while the motion runs, as fast as that, and over the end of a loop.

import { createBag, h } from "../../dom.js";
import { button } from "../kit/kit.js";

const MOST_JUMP = 2; // s of a frame: what is longer is a leap, not a motion

/** @param {App} app */
export function createStopwatch({ clock, text }) {
  const bag = createBag();
  const shown = h("output", { class: "stopwatch" });
  const laps = h("ol", { class: "laps" });
  let [running, sum, last, lap] = [false, 0, 0, 0];
  const show = () => {
    shown.textContent = text("seconds", { time: text.number(sum, 2) });
    start.textContent = text(running ? "measure.stop" : "measure.start");
    round.disabled = !running;
  };
  const start = button(
    text("measure.start"),
    () => {
      running = !running;
      last = clock.time;
      show();
    },
    { "data-watch": "start" },
  );
  const round = button(
    text("measure.lap"),
    () => {
      const time = text.number(sum - lap, 2);
      lap = sum;
      laps.append(h("li", {}, text("seconds", { time })));
    },
    { "data-watch": "lap" },
  );
  const reset = button(
    text("measure.reset"),
    () => {
      [sum, lap] = [0, 0];
      laps.replaceChildren();
      show();
    },
    { "data-watch": "reset" },
  );
  bag(
    clock.subscribe(() => {
      let passed = clock.time - last;
      if (passed < 0 && clock.loop) passed += clock.available;
      last = clock.time;
      if (!running || !clock.playing || passed < 0 || passed > MOST_JUMP) return;
      sum += passed;
      show();
    }),
  );
  show();
  const row = h("div", { class: "row" }, start, round, reset);
  return { element: h("div", {}, shown, row, laps), destroy: bag.end };
}
