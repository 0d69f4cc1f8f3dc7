// The document: what the page shows, one immutable object with its history; and the request that it
// stands for.
// Leaves to others: the motion, which follows from it (motion.js), and the time (clock.js).
// Invariant: a document is frozen and complete; what touches only `view` makes no step of history.

import { pendulumOf, termsOf } from "./terms.js";

/** What the page opens with: the example "single". @type {Doc} */
export const FIRST = {
  title: "",
  preset: "single",
  pendulum: { length: [1], mass: [1], parent: [0], gravity: 9.81 },
  initial: { phi: [-0.8726646259971648], phid: [0] },
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
    trails: [1],
    arrows: false,
    vectors: [],
    vectorScale: 1,
    endless: false,
    ruler: null,
    protractor: null,
    palette: "safe",
    selected: 0,
  },
};

/** How far a ruler or a protractor may lie, m and degrees, typed or in a link. */
export const FARTHEST = 1e6;

/** What can lie open beside the stage (view.drawer). */
export const DRAWERS = [
  "presets",
  "physics",
  "measure",
  "plots",
  "modes",
  "control",
  "compare",
  "method",
  "equations",
  "share",
  "worksheet",
  "class",
];

const HISTORY = 500;

/** Whether a ghost is a second pendulum beside the document's. @param {Ghost} ghost */
export const isBeside = ({ beside }) => Boolean(beside);

/**
 * A start as requests have it.
 * @param {Tree} tree @param {State} start
 */
export const stateOf = (tree, { phi, phid, cart }) =>
  tree.pivot?.cart && cart ? { phi, phid, cart } : { phi, phid };

/**
 * The body for POST /v1/trajectories; rtol and atol are left to the server where the document has
 * none.
 * @param {Doc} doc @param {State} initial
 */
export function request(doc, initial = doc.initial) {
  const { start = 0 } = doc.span;
  /** @type {MotionBody} */
  const body = {
    pendulum: pendulumOf(doc.pendulum),
    initial: stateOf(doc.pendulum, initial),
    times: { start, stop: start + doc.span.stop, step: doc.span.step },
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
  const { phi, phid, cart, apart, method, rtol = null, atol = null, pendulum } = ghost;
  const of = pendulum ? { ...doc, pendulum } : doc;
  const own = method ? { ...of, method, rtol, atol, precision: "double" } : of;
  if (apart === undefined) return { doc: own, initial: { phi, phid, cart } };
  const start = doc.initial;
  return {
    doc: own,
    initial: { ...start, phi: [start.phi[0] + apart, ...start.phi.slice(1)] },
  };
}

/**
 * The parts of a document that a body of /v1/trajectories (a scene's request, a preset) stands for.
 * @param {MotionBody} body
 */
export function fromRequest(body) {
  const { length, parent, gravity = 9.81 } = body.pendulum;
  const mass = length.map((_, k) => body.pendulum.mass?.[k] ?? 0);
  const still = length.map(() => 0);
  const cart = body.initial?.cart;
  return {
    pendulum: { length, mass, parent, gravity, ...termsOf(body.pendulum) },
    initial: {
      phi: body.initial?.phi ?? still,
      phid: body.initial?.phid ?? still,
      ...(cart && { cart: { x: cart.x ?? 0, v: cart.v ?? 0 } }),
    },
    span: spanOf(body.times),
    method: body.method ?? "taylor",
    rtol: body.rtol ?? null,
    atol: body.atol ?? null,
    // links of before 62 digits were removed
    precision: (body.precision === "quad" ? "extended" : body.precision) ?? "double",
    ghosts: [],
  };
}

/**
 * From when on, for how long and how finely; a start at 0 is left out.
 * @param {MotionBody["times"]} times
 */
function spanOf({ start = 0, stop, step, count }) {
  // the last digits of a difference are not of the duration
  const long = start ? Number((stop - start).toPrecision(12)) : stop;
  const span = { stop: long, step: step ?? long / ((count ?? 1001) - 1) };
  return start ? { start, ...span } : span;
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
  // another start is one at 0
  const anew = doc.span.start !== undefined && patch.initial && !patch.span;
  const span = anew && { span: { stop: doc.span.stop, step: doc.span.step } };
  const next = { ...doc, ...(other && { preset: null, title: "" }), ...span, ...patch };
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

/** @param {Patch} first @returns {Omit<Store, "refuse">} */
function freeStore(first) {
  let doc = patched(FIRST, first);
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

/** @param {Patch} first @returns {Store} */
export function createStore(first = {}) {
  const store = freeStore(first);
  /** @type {(() => unknown) | null} */
  let refusing = null;
  const travel = (/** @type {() => string | null} */ step) => {
    refusing?.();
    return refusing ? null : step();
  };
  return {
    ...store,
    set(patch, options) {
      if (refusing && !onlyView(patch)) refusing();
      else store.set(patch, options);
    },
    undo: () => travel(store.undo),
    redo: () => travel(store.redo),
    /** From now on nobody changes more than the view: fn is told instead; null ends that. */
    refuse(fn) {
      refusing = fn;
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
