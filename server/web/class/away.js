// What waits for a server that does not answer says so where one waits: on the way into a room, and
// beside what one has sent.
// Leaves to others: trying again (client.js), the line to a room one is in (session.js).
// Invariant: it is seen for as long as the server is away or asks to wait, and no longer.

import { h } from "../dom.js";
import { button } from "../drawers/kit/kit.js";

/** @param {App} app */
export function awayLine({ client, text }) {
  const words = h("span", {});
  const hurry = button(text("again.now"), client.hurry, { class: "button small" });
  const place = h("p", { class: "fault away", role: "status", hidden: true }, words, " ", hurry);
  function show() {
    const { kind, retry } = client.state;
    place.hidden = kind !== "away" && kind !== "busy";
    if (!place.hidden) words.textContent = text(`failure.${kind}.retry`, { seconds: retry });
  }
  const end = client.watch(show);
  show();
  return { place, end };
}
