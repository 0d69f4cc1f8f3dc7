// What the page has to say about its data: on its way, the server is gone or has no room, the request was refused.
// Leaves to others: trying again (client.js), undoing.
// Invariant: one line, the gravest matter; it goes by itself when the matter is over.

import { said } from "./client.js";
import { createBag, h } from "./dom.js";

const PATIENCE_MS = 350;

export function mountNotices(element, app) {
  const { store, motion, client, text } = app;
  const bag = createBag();
  const words = h("span");
  const act = h("button", { type: "button", class: "button small" });
  const bubble = h("div", { class: "notice", role: "status", hidden: true }, words, act);
  element.append(bubble);
  let action = null;
  let late = false;
  let timer = 0;

  /** The gravest matter: [words, what a button says, what it does, bad]. */
  function matter() {
    const { failure } = motion;
    if (failure?.kind === "refused")
      return [said(failure, text), store.canUndo() && text("undo"), app.undo, true];
    if (failure) return [said(failure, text), text("again"), motion.reload, true];
    if (client.state.kind !== "well") {
      return [
        text(`failure.${client.state.kind}.retry`, { seconds: client.state.retry }),
        text("again.now"),
        client.hurry,
        true,
      ];
    }
    if (motion.complaint) return [motion.complaint, text("close"), () => motion.note(null), true];
    if (motion.loading && late) {
      const share = motion.total ? Math.floor((100 * motion.count) / motion.total) : 0;
      return [text("loading", { share })];
    }
    return null;
  }

  function show() {
    if (!motion.loading) {
      late = false;
      clearTimeout(timer);
      timer = 0;
    } else if (!timer) {
      timer = setTimeout(() => {
        late = true;
        show();
      }, PATIENCE_MS);
    }
    const now = matter();
    bubble.hidden = !now;
    if (!now) return;
    const [said, label, does, bad = false] = now;
    if (words.textContent !== said) words.textContent = said;
    act.hidden = !label;
    act.textContent = label || "";
    action = does;
    bubble.classList.toggle("bad", bad);
  }

  bag.on(act, "click", () => action?.());
  bag(client.watch(show));
  bag(motion.subscribe(show));
  bag(() => clearTimeout(timer));
  show();
  return { destroy: bag.end };
}
