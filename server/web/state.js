// The document: what the page shows, one immutable object with its history; and the request that it
// stands for.
// Leaves to others: the motion, which follows from it (motion.js), and the time (clock.js).
// Invariant: a document is frozen and complete; what touches only `view` makes no step of history.

/** @type {Doc} */
export const PAPER = {
  title: "",
  preset: "paper-four-arms",
  pendulum: {
    length: [2, 1.5, 0.75, 1.25],
    mass: [1, 1, 1, 0.1],
    parent: [0, 1, 2, 2],
    gravity: 9.81,
  },
  initial: { phi: [0, 0, 0, 0], phid: [0, 0, 0, 0] },
  span: { stop: 20, step: 0.01 },
  method: "taylor",
  rtol: null,
  atol: null,
  precision: "double",
  ghosts: [],
  view: {
    drawer: null,
    speed: 1,
    loop: true,
    trails: [4],
    arrows: false,
    palette: "safe",
    selected: 0,
  },
};

/** What can lie open beside the stage (view.drawer). */
export const DRAWERS = [
  "presets",
  "plots",
  "modes",
  "compare",
  "method",
  "equations",
  "share",
  "worksheet",
];

const HISTORY = 500;

/**
 * The body for POST /v1/trajectories; rtol and atol are left to the server where the document has
 * none.
 * @param {Doc} doc @param {State} initial
 */
export function request(doc, initial = doc.initial) {
  /** @type {MotionBody} */
  const body = {
    pendulum: {
      length: doc.pendulum.length,
      mass: doc.pendulum.mass,
      parent: doc.pendulum.parent,
      gravity: doc.pendulum.gravity,
    },
    initial: { phi: initial.phi, phid: initial.phid },
    times: { start: 0, stop: doc.span.stop, step: doc.span.step },
    method: doc.method,
  };
  const tolerant = doc.method !== "symplectic" && doc.method !== "linear";
  if (tolerant && doc.rtol !== null) body.rtol = doc.rtol;
  if (tolerant && doc.atol !== null) body.atol = doc.atol;
  if (doc.precision !== "double" && doc.method === "taylor") body.precision = doc.precision;
  return body;
}

/**
 * {doc, initial} of a ghost {phi, phid, apart?, method?, rtol?, atol?}: another start as it stands,
 * or, with `apart`, the document's start with its first arm turned by so much (0: the same start);
 * by its own method where it names one.
 * @param {Doc} doc @param {Ghost} ghost
 */
export function ghostOf(doc, ghost) {
  const { phi, phid, apart, method, rtol = null, atol = null } = ghost;
  const own = method ? { ...doc, method, rtol, atol, precision: "double" } : doc;
  if (apart === undefined) return { doc: own, initial: { phi, phid } };
  const start = doc.initial;
  return {
    doc: own,
    initial: { phi: [start.phi[0] + apart, ...start.phi.slice(1)], phid: start.phid },
  };
}

const IDEAL = ["arms", "length", "mass", "parent", "L", "m", "S", "gravity"];
const IDEAL_ARM = ["name", "parent", "length", "mass"];

/**
 * Whether this page can show a pendulum: bars, springs, friction and drives it does not draw.
 * @param {any} pendulum
 */
export const isIdeal = (pendulum) =>
  Object.keys(pendulum).every((name) => IDEAL.includes(name)) &&
  (Array.isArray(pendulum.arms) ? pendulum.arms : []).every((/** @type {any} */ arm) =>
    Object.keys(arm).every((name) => IDEAL_ARM.includes(name)),
  );

/**
 * The parts of a document that a body of /v1/trajectories (a scene's request, a preset) stands for.
 * @param {MotionBody} body
 */
export function fromRequest(body) {
  const { length, mass, parent, gravity = 9.81 } = body.pendulum;
  const still = length.map(() => 0);
  const { stop, step, count } = body.times;
  return {
    pendulum: { length, mass, parent, gravity },
    initial: { phi: body.initial?.phi ?? still, phid: body.initial?.phid ?? still },
    span: { stop, step: step ?? stop / ((count ?? 1001) - 1) },
    method: body.method ?? "taylor",
    rtol: body.rtol ?? null,
    atol: body.atol ?? null,
    precision: body.precision ?? "double",
    ghosts: [],
  };
}

/** @template Value @param {Value} value @returns {Value} */
function freeze(value) {
  if (value && typeof value === "object" && !Object.isFrozen(value)) {
    Object.freeze(value);
    Object.values(value).forEach(freeze);
  }
  return value;
}

/**
 * The whole document of a patch: what it does not name stays, `view` is merged key by key; another
 * pendulum is no longer the example.
 * @param {Doc} doc @param {Patch} patch @returns {Doc}
 */
function patched(doc, patch) {
  const other = doc.preset && patch.pendulum && !("preset" in patch);
  const view = { ...doc.view, ...patch.view };
  const next = { ...doc, ...(other && { preset: null, title: "" }), ...patch };
  return freeze({ ...next, view: patch.view ? view : doc.view });
}

/** @param {Patch} patch */
const onlyView = (patch) => Object.keys(patch).every((key) => key === "view");

/**
 * A document that can be gone back to, and what led away from it.
 * @typedef {{doc: Doc, label: string}} Step
 */

/**
 * The view on a document of the history: as it is now, but for arms that are no more.
 * @param {View} view @param {Doc} to @returns {View}
 */
function viewOn(view, to) {
  const arms = to.pendulum.length.length;
  const trails = view.trails.filter((arm) => arm <= arms);
  const selected = view.selected <= arms ? view.selected : 0;
  return { ...view, selected, trails: trails.length ? trails : to.view.trails };
}

/** @param {Patch} first @returns {Store} */
export function createStore(first = {}) {
  let doc = patched(PAPER, first);
  /** @type {Step[]} */
  let past = [];
  /** @type {Step[]} */
  let future = [];
  /** @type {string | null} */
  let merging = null;
  /** @type {Set<Listener>} */
  const listeners = new Set();

  /** @param {Doc} next @param {Cause} cause */
  function replace(next, cause) {
    const before = doc;
    doc = next;
    for (const listener of [...listeners]) listener(doc, before, cause);
  }

  /**
   * Steps from one list of documents to the other.
   * @param {Step[]} from @param {Step[]} to @param {string} label
   */
  function travel(from, to, label) {
    const entry = from.pop();
    if (!entry) return null;
    to.push({ doc, label: entry.label });
    merging = null;
    replace(freeze({ ...entry.doc, view: viewOn(doc.view, entry.doc) }), { label });
    return entry.label;
  }

  return {
    get: () => doc,
    // label: what undo will call it (a key of the texts)
    // merge: a name; steps of one name, one after the other, are one step of history
    set(patch, { label = "change", merge = null } = {}) {
      if (onlyView(patch)) return replace(patched(doc, patch), { label });
      if (merge === null || merge !== merging) past.push({ doc, label });
      if (past.length > HISTORY) past.shift();
      merging = merge;
      future = [];
      replace(patched(doc, patch), { label, merge });
    },
    /** Ends a run of merged steps: the next one of the same name is a new step. */
    settle() {
      merging = null;
    },
    undo: () => travel(past, future, "undo"),
    redo: () => travel(future, past, "redo"),
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    /** fn(doc, before, cause) after every change; answers what ends it. */
    subscribe(fn) {
      listeners.add(fn);
      return () => listeners.delete(fn);
    },
  };
}

/** Whether two documents have the same motion. @param {Doc} a @param {Doc} b */
export function sameMotion(a, b) {
  return (
    a.pendulum === b.pendulum &&
    a.initial === b.initial &&
    a.span === b.span &&
    a.method === b.method &&
    a.rtol === b.rtol &&
    a.atol === b.atol &&
    a.precision === b.precision
  );
}
