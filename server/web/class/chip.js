// What the page's head says of the room: its code, who one is, whether the line holds.
// Leaves to others: the head itself (header.js), which is built anew in another language.
// Invariant: one chip; it leads to the drawer of the class.

import { h } from "../dom.js";

/** Who one is in a class, for parts of the page that follow it. @param {string} role */
function told(role) {
  const { dataset } = document.documentElement;
  if ((dataset.room ?? "") === role) return;
  if (role) dataset.room = role;
  else delete dataset.room;
  document.dispatchEvent(new Event("pendulumd-room"));
}

/** @param {Room} room @returns {{end: End, show: () => void}} */
export function mountChip({ app, session, say }) {
  const header = /** @type {HTMLElement} */ (document.getElementById("header"));
  const click = () => app.store.set({ view: { drawer: "class" } });
  const chip = h("button", { type: "button", class: "room-chip", "data-room": "", on: { click } });

  function show() {
    const { entry, state } = session;
    told(entry && state !== "none" && state !== "gone" ? entry.role : "");
    if (!entry || state === "none") return chip.remove();
    const frozen = entry.role === "pupil" && session.value("stages/class")?.frozen;
    const kind = state === "live" && frozen ? "frozen" : state;
    chip.dataset.state = kind;
    const who = entry.role === "teacher" ? say("class.teacher") : (entry.nickname ?? "");
    chip.textContent = `${entry.code} \u00b7 ${who}`;
    const words = say(`class.state.${kind}`);
    if (kind !== "live") chip.append(` \u00b7 ${words}`);
    chip.title = words;
    const title = header.querySelector(".title");
    if (title && title.nextSibling !== chip) title.after(chip);
  }
  // the head is built anew where the language changes
  const sight = new MutationObserver(show);
  sight.observe(header, { childList: true });
  const end = session.subscribe(show);
  show();
  return {
    show,
    end() {
      sight.disconnect();
      end();
      chip.remove();
    },
  };
}
