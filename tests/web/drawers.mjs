// What the drawers' tests share: opening one, files that the page saves, waiting for motions.
// Leaves to others: the rig (rig.mjs).
// Invariant: throws where a drawer does not come.

import { readFile } from "node:fs/promises";

/** Opens a drawer by its tab and waits until it is there; answers its selector. */
export async function openDrawer(page, id) {
  const selector = `[data-drawer="${id}"]`;
  await page.waitForSelector("[data-tab]");
  if (await page.getAttribute(`[data-tab="${id}"]`, "aria-selected") !== "true") await page.click(`[data-tab="${id}"]`);
  await page.waitForSelector(`${selector} h2`, { state: "visible" });
  await page.waitForFunction((at) => !document.querySelector(at).hasAttribute("aria-busy"), selector);
  // what is folded away lies open for those who look at all of it
  await page.locator(`${selector} [data-add][aria-pressed=false]`).evaluateAll((chips) => chips.forEach((chip) => chip.click()));
  return selector;
}

/** {name, bytes} of what a click saves. */
export async function saved(page, selector) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(selector)]);
  return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
}

/** Ends what the page is waiting for: its motion and its ghosts are whole. */
export const settledMotion = (page) => page.waitForFunction(() => {
  const { motion, store } = window.pendulumd;
  return motion.complete && motion.track.doc.initial === store.get().initial && motion.ghosts.length === store.get().ghosts.length && motion.ghosts.every((ghost) => ghost.complete);
});

/** The stage's picture: how many of its pixels are painted, and a digest of all (a PNG of Firefox's is another each time). */
export const pixels = (page) => page.evaluate(async () => {
  const canvas = document.querySelector("#stage .canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", data));
  const painted = new Uint32Array(data.buffer).reduce((sum, pixel) => sum + (pixel ? 1 : 0), 0);
  return `${painted} of ${canvas.width} x ${canvas.height}: ${[...digest].map((byte) => byte.toString(16)).join(" ")}`;
});
