// The stage for a projector: full screen, large type, and the link as a large code for the room.
// Leaves to others: the code (qr.js), which link (share.js).
// Invariant: whatever ends the full screen ends this; an address that other machines cannot reach
// is told as such.

import { h } from "../../dom.js";
import { ROOT } from "../../root.js";
import { button } from "../kit/kit.js";
import { localOf, qrOf } from "../kit/qr.js";

/**
 * Until it is closed, or the full screen left.
 * @param {App} app @param {any} qrcode the library @param {string} link
 */
export function showProjector({ text, store }, qrcode, link) {
  const root = document.documentElement;
  /** @type {Element | null} */
  const before = document.activeElement;
  const end = () => {
    if (!("projector" in root.dataset)) return;
    delete root.dataset.projector;
    part.remove();
    document.removeEventListener("fullscreenchange", left);
    if (document.fullscreenElement) document.exitFullscreen();
    /** @type {HTMLElement | null} */ (before)?.focus();
  };
  const left = () => document.fullscreenElement ?? end();
  const close = button(text("close"), end, { "data-projector": "end" });
  const part = h(
    "aside",
    { class: "projector", "aria-label": text("share.projector") },
    qrOf(qrcode, link, text("share.projector")),
    h("p", { class: "projector-link" }, link.length < 90 ? link : ROOT),
    localOf(text),
    close,
  );
  part.addEventListener("keydown", ({ key }) => key === "Escape" && end());
  root.dataset.projector = "";
  document.body.append(part);
  store.set({ view: { selected: 0 } });
  close.focus();
  document.addEventListener("fullscreenchange", left);
  // where it is refused the page alone is large
  root.requestFullscreen?.().catch(() => {});
}
