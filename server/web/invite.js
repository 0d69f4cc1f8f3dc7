// "Drag me" beside the tip of the pendulum that a first visit opens with.
// Leaves to others: dragging (hands.js).
// Invariant: stays until somebody has taken hold of a pendulum in this browser once, or shows
// another one; it is never in the way of a pointer.

import { createBag, h } from "./dom.js";
import { keep } from "./keep.js";
import { FIRST } from "./state.js";

const KNOWN = "pendulumd.dragged";
const ABOVE = 14; // pixels between the tip and the words below it, or above

/** @param {HTMLElement} element @param {App} app */
export function mountInvite(element, app) {
  const { store, edits, text } = app;
  const { pendulum } = store.get();
  if (keep.get(KNOWN) || pendulum !== FIRST.pendulum) return { destroy() {} };
  const bag = createBag();
  // keys are told of by the names of the arms
  const words = h("p", { class: "invite", "aria-hidden": "true" }, text("stage.invite"));
  element.append(words);

  const end = () => {
    words.remove();
    bag.end();
  };
  bag(
    store.subscribe((doc) => {
      if (edits.grabbed) keep.set(KNOWN, "1");
      if (edits.grabbed || doc.pendulum !== pendulum) end();
    }),
  );
  return {
    /** Called with every frame of the stage. */
    follow() {
      const { x, y } = app.stage.tip(1);
      const { offsetWidth: width, offsetHeight: height } = words;
      const fits = y + ABOVE + height < element.clientHeight;
      const top = Math.round(fits ? y + ABOVE : y - ABOVE - height);
      words.style.transform = `translate(${Math.round(x - width / 2)}px, ${top}px)`;
    },
    destroy: end,
  };
}
