// What is kept of a person in a room, for pupils, parents and a school's data protection.
// Leaves to others: that it is so (README.md, "A class works together").
// Invariant: what is said here is true of the server and of this page.

import { h, iconButton } from "../dom.js";

const POINTS = ["who", "what", "token", "not", "passed", "log", "end", "browser"];

/** A button that opens it. @param {Room} room */
export function keptLink({ app, say }) {
  function open() {
    /** @type {HTMLDialogElement} */
    const dialog = h(
      "dialog",
      { class: "help kept", "aria-labelledby": "kept-title", on: { close: () => dialog.remove() } },
      h(
        "div",
        { class: "dialog-head" },
        h("h2", { id: "kept-title" }, say("class.kept.title")),
        iconButton("close", app.text("close"), () => dialog.close()),
      ),
      h(
        "dl",
        {},
        ...POINTS.flatMap((point) => [
          h("dt", {}, say(`class.kept.${point}.name`)),
          h("dd", {}, say(`class.kept.${point}`)),
        ]),
      ),
    );
    document.body.append(dialog);
    dialog.showModal();
  }
  return h(
    "button",
    { type: "button", class: "as-link", "data-class": "kept", on: { click: open } },
    say("class.kept"),
  );
}
