// The page without a server: asks the browser to keep it (sw.js), and knows whether it does and
// whether a newer version waits.
// Leaves to others: the words (notices.js, header.js), computing (engine.js).
// Invariant: begins when the pendulum swings; where the browser or the server has no such worker,
// nothing is asked and nothing fails.

import { urlOf } from "./root.js";

/** ms between two questions for a newer version, by a page that is looked at again. */
const PAUSE_MS = 600000;

/**
 * kind: "none" (cannot be kept), "coming", "kept"; newer: another version waits.
 * @typedef {{kind: string, newer: boolean}} Kept
 */

/** Whether a browser and a server have it. */
const possible = () =>
  "offline" in document.documentElement.dataset &&
  "serviceWorker" in navigator &&
  // who counts bytes is not sent more than is asked for
  !(/** @type {any} */ (navigator).connection?.saveData);

/**
 * The page as the browser has it: state: what is told; asked: when the server was asked for a newer
 * version, ms.
 * @typedef {{
 *   text: Text, state: Kept, watchers: Set<() => unknown>, asked: number,
 *   registration: ServiceWorkerRegistration | null,
 * }} Copy
 */

/** @param {Copy} copy @param {Partial<Kept>} change */
function tell(copy, change) {
  Object.assign(copy.state, change);
  for (const watcher of copy.watchers) watcher();
}

/**
 * Tells a worker whose page this is (sw.js); one that has come newly says if it is of another.
 * @param {ServiceWorker | null} worker @param {boolean} waits
 */
function greet(worker, waits = true) {
  const { page } = document.documentElement.dataset;
  worker?.postMessage({ page, waits });
}

/** Greets a version that comes. @param {Copy} copy @param {ServiceWorker | null} worker */
function follow(copy, worker) {
  worker?.addEventListener("statechange", () => {
    if (worker.state === "installed") greet(worker);
    // it found no room, or a file was missing
    if (worker.state === "redundant" && !copy.registration?.active) tell(copy, { kind: "none" });
  });
}

/** Asks the server for a newer version. @param {Copy} copy */
async function check(copy) {
  copy.asked = performance.now();
  await copy.registration?.update().catch(() => {});
}

/** The words of the language in use are kept too. @param {Copy} copy */
const speak = ({ registration, text }) =>
  registration?.active?.postMessage({ language: text.language });

/** @param {Copy} copy */
async function begin(copy) {
  if (copy.state.kind !== "none" || !possible()) return;
  tell(copy, { kind: "coming" });
  const workers = navigator.serviceWorker;
  workers.addEventListener("message", ({ data }) => data?.newer && tell(copy, { newer: true }));
  // another window may have taken a newer one
  workers.addEventListener("controllerchange", () => greet(workers.controller));
  try {
    const registration = await workers.register(urlOf("/sw.js"), { updateViaCache: "none" });
    copy.registration = registration;
    registration.addEventListener("updatefound", () => follow(copy, registration.installing));
    follow(copy, registration.installing);
    greet(registration.waiting);
    greet((await workers.ready).active, false);
    speak(copy);
    tell(copy, { kind: "kept" });
  } catch {
    tell(copy, { kind: "none" });
  }
}

/** @param {Text} text @returns {Offline} */
export function createOffline(text) {
  /** @type {Copy} */
  const copy = {
    text,
    state: { kind: "none", newer: false },
    watchers: new Set(),
    asked: 0,
    registration: null,
  };
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden && performance.now() - copy.asked > PAUSE_MS) check(copy);
  });
  return {
    get kind() {
      return copy.state.kind;
    },
    get newer() {
      return copy.state.newer;
    },
    begin: () => begin(copy),
    check: () => check(copy),
    speak: () => speak(copy),
    watch(fn) {
      copy.watchers.add(fn);
      return () => copy.watchers.delete(fn);
    },
  };
}
