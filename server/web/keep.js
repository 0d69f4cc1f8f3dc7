// What the page keeps in the browser: choices, and the token that says which jobs and scenes are this browser's.
// Leaves to others: what the words mean that are kept.
// Invariant: a browser that refuses storage (blocked site data, a sandboxed frame) keeps all of it as long as the tab lives.

const HOLDER = "pendulumd.token";
const held = (globalThis[Symbol.for("pendulumd.kept")] ??= new Map()); // one for every bundle of the page

export const keep = {
  /** The text that was kept under a name, null without one. */
  get(name) {
    try {
      return localStorage.getItem(name) ?? held.get(name) ?? null;
    } catch {
      return held.get(name) ?? null;
    }
  },
  set(name, text) {
    held.set(name, text);
    try {
      localStorage.setItem(name, text);
    } catch {
      // it lives as long as the tab
    }
  },
};

/** 256 random bits as 43 letters of base64url. */
function fresh() {
  const bytes = crypto.getRandomValues(new Uint8Array(32));
  return btoa(String.fromCharCode(...bytes))
    .replaceAll("+", "-")
    .replaceAll("/", "_")
    .replace(/=+$/, "");
}

/** The header field that says whose request it is: this browser's own token, made at the first request. */
export function bearer() {
  let token = keep.get(HOLDER);
  if (!/^[\w-]{43}$/.test(token ?? "")) {
    token = fresh();
    keep.set(HOLDER, token);
  }
  return { Authorization: `Bearer ${token}` };
}
