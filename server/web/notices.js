// What the page has to say about its data: on its way, the server is gone or has no room, the
// request was refused; and that a newer version of the page is there.
// Leaves to others: trying again (client.js), undoing.
// Invariant: one line, the gravest matter; it goes by itself when the matter is over.

import { said } from "./client.js";
import { createBag, h } from "./dom.js";

const PATIENCE_MS = 350;

/**
 * What is to be said: words, what a button says and does, whether it is trouble.
 * @typedef {{words: string, label?: string, act?: () => unknown, bad?: boolean}} Matter
 */

/** @param {App} app @param {Failed} failure @returns {Matter} */
function failed({ store, motion, text, undo }, failure) {
  const words = said(failure, text);
  if (failure.kind !== "refused")
    return { words, label: text("again"), act: motion.reload, bad: true };
  return { words, label: store.canUndo() ? text("undo") : "", act: undo, bad: true };
}

/**
 * The gravest matter, null if all is well.
 * @param {App} app @param {boolean} late @returns {Matter | null}
 */
function matterOf(app, late) {
  const { motion, client, text } = app;
  if (motion.failure) return failed(app, motion.failure);
  const { kind, retry } = client.state;
  if (kind === "away" || kind === "busy") {
    const words = text(`failure.${kind}.retry`, { seconds: retry });
    return { words, label: text("again.now"), act: client.hurry, bad: true };
  }
  if (motion.complaint) {
    return {
      words: motion.complaint,
      label: text("close"),
      act: () => motion.note(null),
      bad: true,
    };
  }
  if (motion.loading && late) {
    const share = motion.total ? Math.floor((100 * motion.count) / motion.total) : 0;
    return { words: text("loading", { share }) };
  }
  if (app.offline.newer)
    return { words: text("offline.newer"), label: text("offline.load"), act: reload };
  return kind === "alone" ? { words: text("offline.alone") } : null;
}

const reload = () => location.reload();

/** @param {HTMLElement} element @param {App} app */
export function mountNotices(element, app) {
  const { motion, client } = app;
  const bag = createBag();
  const words = h("span");
  const button = h("button", { type: "button", class: "button small" });
  const bubble = h("div", { class: "notice", role: "status", hidden: true }, words, button);
  element.append(bubble);
  /** @type {(() => unknown) | undefined} */
  let act;
  let late = false;
  let timer = 0;

  /** Whether the motion has been on its way for a while. */
  function watch() {
    if (motion.loading) {
      timer ||= window.setTimeout(() => {
        late = true;
        show();
      }, PATIENCE_MS);
      return;
    }
    late = false;
    clearTimeout(timer);
    timer = 0;
  }

  function show() {
    watch();
    const matter = matterOf(app, late);
    bubble.hidden = !matter;
    if (!matter) return;
    if (words.textContent !== matter.words) words.textContent = matter.words;
    button.hidden = !matter.label;
    button.textContent = matter.label ?? "";
    act = matter.act;
    bubble.classList.toggle("bad", matter.bad ?? false);
  }

  bag.on(button, "click", () => act?.());
  bag(client.watch(show));
  bag(app.offline.watch(show));
  bag(motion.subscribe(show));
  bag(() => clearTimeout(timer));
  show();
  return { destroy: bag.end };
}
