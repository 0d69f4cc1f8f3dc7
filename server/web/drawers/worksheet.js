// Worksheets without a room: those that come with the page, or one that a link holds; answers stay
// in the browser.
// Leaves to others: the steps (class/sheet_run.js), worksheets of a class (class/sheet_pupil.js).
// Invariant: what was answered stays answered (kept in the browser), each worksheet by itself; a
// worksheet that no address names takes the stage when its reader begins; the event
// "pendulumd-handin" tells of each answer that was kept.

import { said } from "../client.js";
import { h } from "../dom.js";
import { keep } from "../keep.js";
import { unpack } from "../link.js";
import { namesSheet, sheetInAddress } from "../room.js";
import { runSheet } from "../class/sheet_run.js";
import { SHIPPED, shippedSheet } from "../class/shipped.js";
import { button, choice } from "./kit/kit.js";

const KEPT = "pendulumd.sheet";

/** What the browser has of a worksheet. @param {string} id @returns {Handin} */
function keptHandin(id) {
  try {
    const kept = JSON.parse(keep.get(`${KEPT}.${id}`) ?? "null");
    return Array.isArray(kept?.answers) ? kept : { answers: [] };
  } catch {
    return { answers: [] };
  }
}

/** The worksheet of the address, #w=..., null without one. @returns {Promise<Sheet | null>} */
async function linkedSheet() {
  const [, letters] = /^#w=(.+)$/.exec(location.hash) ?? [];
  if (!letters) return null;
  const sheet = await unpack(letters);
  const sound = Array.isArray(sheet?.steps) && sheet.steps.length > 0;
  const step = (/** @type {any} */ one) => typeof one?.id === "string";
  if (!sound || !sheet.steps.every(step)) throw new Error("not a worksheet");
  return sheet;
}

/** The worksheet that is opened first: of the address, else the last one. */
function firstOf() {
  const last = sheetInAddress() ?? keep.get(KEPT) ?? "";
  return SHIPPED.includes(last) ? last : SHIPPED[0];
}

/**
 * The drawer while it is there.
 * @typedef {{app: App, element: HTMLElement, body: HTMLElement, fault: HTMLElement}} View
 */

/** @param {View} view @param {string} id @param {Sheet} sheet */
function layRun({ app, element, body }, id, sheet) {
  const save = async (/** @type {Handin} */ given) => {
    const before = keptHandin(id);
    keep.set(`${KEPT}.${id}`, JSON.stringify(given));
    const detail = { id, sheet, before, given };
    element.dispatchEvent(new CustomEvent("pendulumd-handin", { detail, bubbles: true }));
  };
  const run = runSheet({ room: { app, say: app.text }, sheet, handin: keptHandin(id), save });
  body.replaceChildren(h("h3", {}, sheet.title), run.place);
  run.begin();
}

/**
 * The worksheet before it takes the stage.
 * @param {View} view @param {string} id @param {Sheet} sheet
 */
function layStart(view, id, sheet) {
  const { text } = view.app;
  const words = text(keptHandin(id).answers.length ? "sheet.goOn" : "sheet.begin");
  const attributes = { class: "button main", "data-sheet": "begin" };
  const begin = button(words, () => layRun(view, id, sheet), attributes);
  const start = h("p", {}, text("sheet.start", { count: sheet.steps.length }));
  view.body.replaceChildren(h("h3", {}, sheet.title), start, begin);
}

/** @param {View} view @param {string} id @param {boolean} begins */
async function open(view, id, begins) {
  const { app, fault } = view;
  const { text } = app;
  fault.textContent = "";
  try {
    const linked = id === "linked" ? await linkedSheet() : null;
    const sheet = linked ?? (await shippedSheet(id, text.language));
    keep.set(`${KEPT}`, id);
    (begins ? layRun : layStart)(view, id, sheet);
  } catch (error) {
    const link = id === "linked" ? text("failure.link") : text("failure.file");
    fault.textContent = /** @type {Failed} */ (error).kind === "refused" ? said(error, text) : link;
  }
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const { text } = app;
  const body = h("div", {});
  const fault = h("p", { class: "fault", role: "alert" });
  const view = { app, element, body, fault };
  app.files.style("class/class.css").catch(() => {});
  const linked = location.hash.startsWith("#w=");
  const ids = [...(linked ? ["linked"] : []), ...SHIPPED];
  const options = ids.map((id) => ({ value: id, words: text(`sheet.ours.${id}`) }));
  const first = linked ? "linked" : firstOf();
  const { element: chooser, select } = choice(text("sheet.which"), options, first, (id) =>
    open(view, id, false),
  );
  select.dataset.sheet = "which";
  element.append(
    h("h2", {}, text("drawer.worksheet")),
    h("p", { class: "quiet" }, text("sheet.intro")),
    h("div", { class: "row" }, chooser),
    fault,
    body,
  );
  await open(view, first, namesSheet());
  return {
    show() {},
    hide() {},
    destroy: () => element.replaceChildren(),
  };
}

/** @type {DrawerPart} */
export default { id: "worksheet", title: (text) => text("drawer.worksheet"), mount };
