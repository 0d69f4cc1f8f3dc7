// What the page keeps in the browser: choices, and the token that says which jobs and scenes are
// this browser's.
// Leaves to others: what the words mean that are kept.
// Invariant: a browser that refuses storage (blocked site data, a sandboxed frame) keeps all of it
// as long as the tab lives.

/** Where the pendulums lie that were made in this browser (journal.js). */
export const YOURS = "pendulumd.yours";
const HOLDER = "pendulumd.token";
const KEPT = Symbol.for("pendulumd.kept");
// one for every bundle of the page
const shared = /** @type {Record<symbol, {words: Map<string, string>, refused: boolean}>} */ (
  globalThis
);
const held = (shared[KEPT] ??= { words: new Map(), refused: false });

/**
 * What the browser's storage does for a name, null where it refuses.
 * @param {() => string | null | void} use
 */
function stored(use) {
  try {
    return use() ?? null;
  } catch {
    held.refused = true;
    return null;
  }
}

export const keep = {
  /** The text that was kept under a name, null without one. @param {string} name */
  get: (name) => stored(() => localStorage.getItem(name)) ?? held.words.get(name) ?? null,
  /**
   * What the browser refuses lives as long as the tab.
   * @param {string} name @param {string} text
   */
  set(name, text) {
    held.words.set(name, text);
    stored(() => localStorage.setItem(name, text));
  },
  /**
   * The same for as long as the tab lives, and no longer.
   * @param {string} name @param {string} text
   */
  setForTab(name, text) {
    held.words.set(name, text);
    stored(() => sessionStorage.setItem(name, text));
  },
  /** What the tab has under a name, null without one. @param {string} name */
  ofTab: (name) => stored(() => sessionStorage.getItem(name)) ?? held.words.get(name) ?? null,
  /** Whether the browser has refused to keep something. */
  get refused() {
    return held.refused;
  },
};

/** 256 random bits as 43 letters of base64url. */
export function fresh() {
  const bytes = crypto.getRandomValues(new Uint8Array(32));
  return btoa(String.fromCharCode(...bytes))
    .replaceAll("+", "-")
    .replaceAll("/", "_")
    .replace(/=+$/, "");
}

/**
 * The header field that says whose request it is: this browser's own token, made at the first
 * request.
 */
export function bearer() {
  let token = keep.get(HOLDER);
  if (!/^[\w-]{43}$/.test(token ?? "")) {
    token = fresh();
    keep.set(HOLDER, token);
  }
  return { Authorization: `Bearer ${token}` };
}
