// The worksheet that the class is given, in a pupil's panel; what is answered goes to the room.
// Leaves to others: the steps (sheet_run.js).
// Invariant: what is typed stays while the worksheet is the same; the room has every answer.

import { h } from "../dom.js";
import { runSheet } from "./sheet_run.js";
import { keyOf } from "./scenes.js";

/** @param {Room} room */
export function mountGivenSheet(room) {
  const { session, say } = room;
  const place = h("section", { class: "given-sheet", hidden: true });
  let shown = "";
  /** @type {ReturnType<typeof runSheet> | null} */
  let run = null;
  let pace = 0;
  return {
    place,
    show() {
      const id = session.value("stages/class")?.worksheet ?? "";
      /** @type {Sheet | null} */
      const sheet = id ? session.value(`worksheets/${id}`) : null;
      const key = sheet ? keyOf([id, sheet]) : "";
      place.hidden = !sheet;
      const open = session.value("stages/class")?.pace;
      if (key === shown && pace !== open) run?.repace();
      pace = open;
      if (key === shown) return;
      shown = key;
      place.replaceChildren();
      if (!sheet) return;
      const handin = session.value(`handins/${id}/${session.entry?.pupil}`) ?? { answers: [] };
      place.setAttribute("aria-label", sheet.title);
      run = runSheet({
        room,
        sheet,
        handin,
        save: (given) => session.put(`handins/${id}`, given),
        pace: () => session.value("stages/class")?.pace,
      });
      const closed = sheet.closed ? h("p", { class: "quiet" }, say("class.closed")) : null;
      place.append(
        h("h3", {}, sheet.title),
        ...[closed].filter((part) => part !== null),
        run.place,
      );
      if (!handin.answers.length) run.begin();
    },
  };
}
