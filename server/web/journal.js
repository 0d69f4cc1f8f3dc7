// Nothing is lost: every change is kept in the tab's history, so that reload, back and forward lead
// to what was there, and in the browser's storage, as a list of what was made here.
// Leaves to others: what a scene holds (link.js), showing the list (drawers/yours.js).
// Invariant: an address that names a scene stands for it alone: the first change of it makes an
// entry of its own, without that address; what a frame of another page shows is not kept.

import { exampleIn, namesMotion, ownAddress, readAddress, strangeOf } from "./address.js";
import { YOURS, keep } from "./keep.js";
import { patchOf, sceneOf } from "./link.js";

const ENTRY = "pendulumd.entry";
const PAUSE_MS = 400;
const MOST = 24;
const MOST_LETTERS = 100000;
const MOST_TITLE = 200;
// what begins something else, which back leads away from
const BEGINS = ["preset", "new", "yours"];

/**
 * What is kept of one pendulum: its scene, where the clock stood; own: whether somebody has changed
 * it here.
 * @typedef {{id: string, scene: import("./link.js").Scene, preset: string | null, time: number,
 * playing: boolean, own: boolean, when: number}} Entry
 */

/** Whether the address itself says what is shown. */
const addressed = () => location.hash.length > 1 || namesMotion(location.search);

/** What the tab's history has for where it is. @returns {Entry | null} */
function entryHere() {
  const entry = history.state?.[ENTRY];
  return entry?.scene ? entry : null;
}

/** The patch of what was kept; null where it is not sound. @param {Entry} entry */
function patchOfEntry({ scene, preset }) {
  try {
    return { ...patchOf(scene), preset: typeof preset === "string" ? preset : null };
  } catch {
    return null;
  }
}

/** What the browser has kept of all tabs, the newest first. @returns {Entry[]} */
function listOfYours() {
  try {
    const list = JSON.parse(keep.get(YOURS) ?? "[]");
    return Array.isArray(list) ? list.filter((one) => one?.id && one.scene) : [];
  } catch {
    return [];
  }
}

/** @param {Entry[]} list */
function keepYours(list) {
  keep.set(YOURS, JSON.stringify(list.slice(0, MOST)));
}

/** The list, for those who show it. */
export const yours = { list: listOfYours, keep: keepYours, patch: patchOfEntry };

/** @param {Entry} entry */
function keepAmongYours(entry) {
  if (!entry.own || JSON.stringify(entry.scene).length > MOST_LETTERS) return;
  keepYours([entry, ...listOfYours().filter(({ id }) => id !== entry.id)]);
}

/**
 * What is to be shown at once: what the tab had here, or what a readable address names; fault: what
 * of the address cannot be read, "" without any.
 * @returns {{patch: Patch | null, time: number, playing: boolean, fault: string}}
 */
export function beginning() {
  const entry = entryHere();
  const patch = entry && patchOfEntry(entry);
  if (patch) return { patch, time: entry.time, playing: entry.playing, fault: "" };
  let fault = "";
  try {
    const body = readAddress(location.search);
    fault = location.search.slice(1);
    const title = new URLSearchParams(location.search).get("title") ?? "";
    const named = body && patchOf({ request: body, title: title.slice(0, MOST_TITLE) });
    return { patch: named, time: 0, playing: true, fault: strangeOf(location.search) };
  } catch (error) {
    fault ||= /** @type {Error} */ (error).message;
    return { patch: null, time: 0, playing: true, fault };
  }
}

/** A name that no other pendulum has. */
const fresh = () => crypto.randomUUID?.() ?? String(Math.random());

/**
 * Writes the tab's history; timer: a change waits to be written; id, own: of the entry where the
 * tab is (Entry); last: when it was written last, ms.
 * late: what was left before it was written, by its entry's name.
 * @typedef {{app: App, late: Map<string, Entry>, timer: number, last: number, id: string,
 * own: boolean}} Journal
 */

/** @param {Journal} journal @param {Doc} doc @returns {Entry} */
function entryOf({ id, own, app }, doc) {
  const { time, playing } = app.clock;
  const { preset } = doc;
  return { id, scene: sceneOf(doc), preset, time, playing, own, when: Date.now() };
}

/**
 * @param {"replaceState" | "pushState"} way @param {Entry} entry @param {string} [address]
 */
function put(way, entry, address) {
  try {
    history[way]({ ...history.state, [ENTRY]: entry }, "", address);
  } catch {
    // a browser may refuse to be asked so often; the next change asks again
  }
}

/**
 * @param {Journal} journal @param {"replaceState" | "pushState"} way @param {Doc} doc
 * @param {string} [address]
 */
function write(journal, way, doc, address) {
  clearTimeout(journal.timer);
  journal.timer = 0;
  journal.last = performance.now();
  const entry = entryOf(journal, doc);
  put(way, entry, address);
  keepAmongYours(entry);
}

/**
 * Another entry of the history, with a name of its own.
 * @param {Journal} journal @param {Doc} doc @param {Doc} before
 */
function turn(journal, doc, before) {
  if (!addressed() || journal.timer) write(journal, "replaceState", before);
  journal.id = fresh();
  journal.own = false;
  write(journal, "pushState", doc, ownAddress(location));
}

/** Whether more than the view differs. @param {Doc} doc @param {Doc} before */
const changed = (doc, before) =>
  Object.entries(doc).some(
    ([key, value]) => key !== "view" && value !== before[/** @type {"title"} */ (key)],
  );

/** At once, and while changes follow each other every now and then. @param {Journal} journal */
function keepSoon(journal) {
  const save = () => write(journal, "replaceState", journal.app.store.get());
  const wait = journal.last + PAUSE_MS - performance.now();
  if (wait <= 0) save();
  else journal.timer ||= window.setTimeout(save, wait);
}

/** @param {Journal} journal @param {Doc} doc @param {Doc} before @param {string} label */
function follow(journal, doc, before, label) {
  const soon = () => keepSoon(journal);
  if (!changed(doc, before)) return soon();
  if (label === "open") return addressed() || soon();
  if (addressed() || BEGINS.includes(label)) turn(journal, doc, before);
  if (!BEGINS.includes(label) && label !== "endless") journal.own = true;
  soon();
}

/**
 * Whether what the address stands for is not here at once: a link, read as soon as its hash
 * is there, or an example.
 * @param {() => unknown} open
 */
function openedLater(open) {
  if (location.hash.length > 1) return true;
  const example = exampleIn(location.search) !== null;
  if (example) open();
  return example;
}

/**
 * Keeps the document from now on; open() shows what the address stands for.
 * @param {App} app @param {() => unknown} open
 */
export function beginJournal(app, open) {
  const { store, clock } = app;
  const { id = fresh(), own = false } = entryHere() ?? {};
  /** @type {Journal} */
  const journal = { app, late: new Map(), timer: 0, last: -PAUSE_MS, id, own };
  const first = store.get();
  let travelling = false;

  function arrive() {
    if (journal.timer) journal.late.set(journal.id, entryOf(journal, store.get()));
    const late = journal.late.get(entryHere()?.id ?? "");
    if (late) {
      put("replaceState", late);
      journal.late.delete(late.id);
    }
    const entry = entryHere();
    const patch = beginning().patch ?? first;
    if (!entry && openedLater(open)) return;
    clearTimeout(journal.timer);
    Object.assign(journal, { timer: 0, id: entry?.id ?? fresh(), own: entry?.own ?? false });
    travelling = true;
    store.set(patch, { label: "open" });
    travelling = false;
    clock.restart(entry?.time ?? 0);
  }
  store.subscribe((doc, before, { label }) => travelling || follow(journal, doc, before, label));
  window.addEventListener("popstate", arrive);
  window.addEventListener("hashchange", () => entryHere() ?? open());
  // whoever leaves, reloads or puts the tab away comes back to this
  const leave = () => {
    const known = journal.timer || !addressed() || entryHere();
    if (known) write(journal, "replaceState", store.get());
  };
  // a reload takes the history as it is before this page is left
  for (const event of ["beforeunload", "pagehide"]) window.addEventListener(event, leave);
  document.addEventListener("visibilitychange", () => document.hidden && leave());
}
