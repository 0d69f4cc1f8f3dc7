// The document: what the page shows, one immutable object with its history; and the request that it stands for.
// Leaves to others: the motion, which follows from it (motion.js), and the time (clock.js).
// Invariant: a document is frozen and complete; what touches only `view` makes no step of history.

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

/** The body for POST /v1/trajectories; rtol and atol are left to the server where the document has none. */
export function request(doc, initial = doc.initial) {
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
 * {doc, initial} of a ghost {phi, phid, apart?, method?, rtol?, atol?}: another start as it stands, or, with `apart`, the
 * document's start with its first arm turned by so much (0: the same start); by its own method where it names one.
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

/** The parts of a document that a body of /v1/trajectories (a scene's request, a preset) stands for. */
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

function freeze(value) {
  if (value && typeof value === "object" && !Object.isFrozen(value)) {
    Object.freeze(value);
    Object.values(value).forEach(freeze);
  }
  return value;
}

/** The whole document of a patch: what it does not name stays, `view` is merged key by key; another pendulum is no longer the example. */
function patched(doc, patch) {
  const other = doc.preset && patch.pendulum && !("preset" in patch);
  const next = { ...doc, ...(other && { preset: null, title: "" }), ...patch };
  if (patch.view) next.view = { ...doc.view, ...patch.view };
  return freeze(next);
}

const onlyView = (patch) => Object.keys(patch).every((key) => key === "view");

export function createStore(first = {}) {
  let doc = patched(PAPER, first);
  let past = [];
  let future = [];
  let merging = null;
  const listeners = new Set();

  function tell(before, cause) {
    for (const listener of [...listeners]) listener(doc, before, cause);
  }

  function replace(next, cause) {
    const before = doc;
    doc = next;
    tell(before, cause);
  }

  /** Steps from one list of documents to the other; the view stays as it is, but for an arm that is no more. */
  function travel(from, to, cause) {
    if (!from.length) return null;
    const entry = from.pop();
    to.push({ doc, label: entry.label });
    merging = null;
    const arms = entry.doc.pendulum.length.length;
    const there = (arm) => arm <= arms;
    const trails = doc.view.trails.filter(there);
    const view = {
      ...doc.view,
      selected: there(doc.view.selected) ? doc.view.selected : 0,
      trails: trails.length ? trails : entry.doc.view.trails,
    };
    replace(freeze({ ...entry.doc, view }), cause);
    return entry.label;
  }

  return {
    get: () => doc,
    /**
     * patch  what changes; `view` may name only some of its keys.
     * label  what undo will call it (a key of the texts).
     * merge  a name: steps of one name, one after the other, are one step of history.
     */
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
    undo: () => travel(past, future, { label: "undo" }),
    redo: () => travel(future, past, { label: "redo" }),
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    /** fn(doc, before, cause) after every change; answers what ends it. */
    subscribe(fn) {
      listeners.add(fn);
      return () => listeners.delete(fn);
    },
  };
}

/** Whether two documents have the same motion. */
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
