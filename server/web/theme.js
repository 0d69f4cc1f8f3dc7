// Light or dark: as the system says, until the switch is used.
// Leaves to others: the colours themselves (style.css), redrawing.
// Invariant: the root's data-theme is "light" or "dark", always.

import { keep } from "./keep.js";

const KEPT = "pendulumd.theme";
const system = matchMedia("(prefers-color-scheme: dark)");
/** @type {Set<() => unknown>} */
const listeners = new Set();

/** @type {Theme} */
export const theme = {
  get dark() {
    return document.documentElement.dataset.theme === "dark";
  },
  toggle() {
    keep.set(KEPT, theme.dark ? "light" : "dark");
    apply();
  },
  /** Light whatever was chosen, as on paper, or no longer so. @param {boolean} on */
  paper(on) {
    apply(on ? "light" : undefined);
  },
  /** fn() after every change. */
  subscribe(fn) {
    listeners.add(fn);
    return () => listeners.delete(fn);
  },
};

const chosen = () => keep.get(KEPT) ?? (system.matches ? "dark" : "light");

function apply(name = chosen()) {
  document.documentElement.dataset.theme = name;
  for (const listener of listeners) listener();
}

system.addEventListener("change", () => apply());
apply();
