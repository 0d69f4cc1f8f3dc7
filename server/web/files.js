// Files of the page that are loaded when they are needed: its own script, libraries and their
// styles.
// Leaves to others: what is said where a file does not come (its error has the kind "file").
// Invariant: a file that is refused is asked for again, under an address that was never refused,
// since some browsers keep a module's refusal; a file that came is asked for once.

import { bare } from "./screen.js";

/**
 * What has been asked for, by path: files that come, and how often each was refused.
 * @typedef {{brought: Map<string, Promise<any>>, refusals: Map<string, number>}} Asked
 */

const PAUSES_MS = [300, 1000, 3000];
// one for every bundle of the page
const shared = /** @type {Record<symbol, Asked>} */ (globalThis);
const { brought, refusals } = (shared[Symbol.for("pendulumd.files")] ??= {
  brought: new Map(),
  refusals: new Map(),
});

/** Where the page's files are; what runs first stands in the document, which is elsewhere. */
const home = new URL(`${document.documentElement.dataset.page}/`, location.href);

/** @param {string} path */
function addressOf(path) {
  const count = refusals.get(path);
  return new URL(count ? `${path}?again=${count}` : path, home).href;
}

/** @param {number} milliseconds */
const pause = (milliseconds) =>
  new Promise((resolve) => {
    setTimeout(resolve, milliseconds);
  });

/** @param {string} path @param {(address: string) => Promise<any>} load */
async function insist(path, load) {
  for (let tried = 0; ; tried++) {
    try {
      return await load(addressOf(path));
    } catch (error) {
      refusals.set(path, (refusals.get(path) ?? 0) + 1);
      if (tried === PAUSES_MS.length)
        throw Object.assign(
          new Error(`${path} did not come: ${/** @type {Error} */ (error).message}`),
          { kind: "file" },
        );
      await pause(PAUSES_MS[tried] * (1 + 0.25 * Math.random()));
    }
  }
}

/**
 * What came once stays; what failed is tried anew by who asks next.
 * @param {string} path @param {(address: string) => Promise<any>} load
 * @returns {Promise<any>}
 */
function once(path, load) {
  const there = brought.get(path);
  if (there) return there;
  const coming = insist(path, load);
  coming.catch(() => brought.delete(path));
  brought.set(path, coming);
  return coming;
}

/** @param {string} address @returns {Promise<unknown>} */
function linked(address) {
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    link.rel = "stylesheet";
    link.href = address;
    link.onload = resolve;
    link.onerror = () => {
      link.remove();
      reject(new Error("refused"));
    };
    document.head.append(link);
  });
}

/** The module at a path below the page's directory. @param {string} path */
export const script = (path) => once(path, (address) => import(address));

/**
 * Resolves when the style sheet at a path below the page's directory is in force.
 * @param {string} path
 */
export const style = (path) => once(path, linked);

/** @type {Promise<unknown>} */
const ready = new Promise((resolve) => {
  if (document.readyState === "complete") resolve(null);
  else window.addEventListener("load", resolve, { once: true });
});

/**
 * Whether the document's own style sheet is in force, asked for again where it did not come with
 * the document.
 * @param {string} path
 */
export async function dressed(path) {
  await ready;
  if (!bare()) return true;
  return style(path).then(
    () => true,
    () => false,
  );
}
