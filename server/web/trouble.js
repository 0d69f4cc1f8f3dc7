// A part of the page that fails is said in words.
// Leaves to others: files that do not come (files.js), telling it on the stage (notices.js).
// Invariant: one part that fails takes no other with it.

import { h } from "./dom.js";

/**
 * What a part's mount answers, or nothing where it fails, which is told: in its place where it has
 * one of its own.
 * @template {{destroy: End}} Part
 * @param {App} app @param {() => Part} mount @param {HTMLElement | null} place
 * @returns {Part | {destroy: End}}
 */
export function tried(app, mount, place = null) {
  try {
    return mount();
  } catch (error) {
    console.error(error);
    const words = app.text("failure.part");
    if (!place) app.complain(words);
    else place.replaceChildren(h("p", { class: "fault", role: "alert" }, words));
    return { destroy: () => place?.replaceChildren() };
  }
}
