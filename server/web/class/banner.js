// What the teacher does, in words over the stage, for a pupil who looks at the pendulum; a tap
// leads to what is asked.
// Leaves to others: the words (pupil.js), what is asked (pupil_panel.js).
// Invariant: goes by itself, and stays while the stage is frozen.

import { h } from "../dom.js";

const SEEN_MS = 10000;

/** @param {Room} room */
export function createBanner({ app, session, say }) {
  const lead = () => {
    app.store.set({ view: { drawer: "class" } });
    hide();
  };
  const banner = h("button", { type: "button", class: "class-banner", hidden: true });
  banner.addEventListener("click", lead);
  document.getElementById("main")?.append(banner);
  let timer = 0;
  const frozen = () => session.value("stages/class")?.frozen === true;

  function hide() {
    clearTimeout(timer);
    const held = session.entry?.role === "pupil" && frozen();
    banner.hidden = !held;
    if (held) banner.textContent = say("class.now.frozen");
  }
  session.subscribe(() => {
    if (!timer) hide();
  });
  return {
    /** @param {string} words */
    show(words) {
      clearTimeout(timer);
      banner.textContent = words;
      banner.hidden = false;
      timer = window.setTimeout(() => {
        timer = 0;
        hide();
      }, SEEN_MS);
    },
  };
}
