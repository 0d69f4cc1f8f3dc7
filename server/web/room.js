// Whether this page belongs to a room of a class: the address names one, or the browser is in one.
// Leaves to others: the room itself (drawers/class.js), which is loaded only then.
// Invariant: without a room nothing of a class is loaded.

import { keep } from "./keep.js";

/** The code of a room in the address: /?room=CODE, or /CODE. */
export function codeInAddress() {
  const asked =
    new URLSearchParams(location.search).get("room") ?? location.pathname.split("/").pop() ?? "";
  return /^[A-HJ-NP-Z2-9]{6}$/i.test(asked) ? asked.toUpperCase() : null;
}

/** The token by which the address leads a room, /CODE#teach=TOKEN; null without one. */
export const leadInAddress = () => /^#teach=([\w-]{22,200})$/.exec(location.hash)?.[1] ?? null;

/** The worksheet in the address that comes with the page, /?sheet=period; null without one. */
export function sheetInAddress() {
  const asked = new URLSearchParams(location.search).get("sheet");
  return asked && /^[a-z]{1,20}$/.test(asked) ? asked : null;
}

/** Whether the address names a worksheet, or holds one (#w=). */
export const namesSheet = () => location.hash.startsWith("#w=") || sheetInAddress() !== null;

/** Whether there is a room to go into: the address names one, or the browser was in one. */
export function hasRoom() {
  const kept = keep.get("pendulumd.rooms") ?? history.state?.["pendulumd.rooms"] ?? "[]";
  const ofTab = keep.ofTab("pendulumd.rooms.tab") ?? history.state?.["pendulumd.rooms.tab"] ?? "[]";
  return codeInAddress() !== null || kept !== "[]" || ofTab !== "[]";
}

/**
 * Opens the worksheet of a link; goes into the room, if there is one to go into.
 * @param {App} app
 */
export async function enterRoom(app) {
  if (namesSheet()) app.store.set({ view: { drawer: "worksheet" } });
  if (!hasRoom()) return;
  const { resume } = await app.files.script("drawers/class.js");
  await resume(app);
}
