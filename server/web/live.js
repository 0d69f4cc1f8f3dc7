// A pendulum that is changed while it moves: it goes on from where it is, at the same time, by its
// new numbers.
// Leaves to others: the controls (drawers/physics.js), taking over from one motion to the next
// (motion.js).
// Invariant: one motion is asked for at a time, and seldom enough; what is changed meanwhile waits,
// the newest change of a name stands for all of it.

import { sameMotion } from "./state.js";

const LEAD = 0.08; // s ahead of the clock, where the next motion begins while this one plays
const GAP_MS = 120;
const AHEAD = 1.5; // s before its end, where an endless motion asks for what follows

/**
 * Makes another pendulum of one; time: when it begins, s of the request's own time.
 * @typedef {(tree: Tree, time: number) => Tree} Change
 */

/**
 * The sample from which the next motion goes on.
 * @param {Track} track @param {Clock} clock
 */
function rowOf({ count, doc }, { time, playing, speed }) {
  const ahead = playing ? time + LEAD * speed : time;
  const row = playing ? Math.ceil(ahead / doc.span.step) : Math.round(ahead / doc.span.step);
  return Math.max(0, Math.min(row, count - 1));
}

/** The state of a sample, as the server sent it. @param {Track} track @param {number} row */
function stateAt({ columns, n }, row) {
  const part = (/** @type {string} */ name) => [...columns[name].subarray(row * n, row * n + n)];
  const state = { phi: part("phi"), phid: part("phid") };
  if (!columns.cart_x) return state;
  return { ...state, cart: { x: columns.cart_x[row], v: columns.cart_v[row] } };
}

/**
 * Ghosts go on from where they are as well.
 * @param {Motion} motion @param {Ghost[]} ghosts @param {number} row @returns {Ghost[]}
 */
function onward(motion, ghosts, row) {
  return ghosts.map((ghost, i) => {
    const track = motion.ghosts[i];
    if (!track || track.count <= row) return ghost;
    const own = { ...ghost, ...stateAt(track, row) };
    delete own.apart;
    return own;
  });
}

/**
 * At the end of an endless motion the next stretch is asked for, which takes over there.
 * @param {{store: Store, motion: Motion, clock: Clock}} parts
 */
function runOn({ store, motion, clock }) {
  const doc = store.get();
  const { track } = motion;
  const near = clock.duration - clock.time < AHEAD * clock.speed;
  if (!doc.view.endless || !clock.playing || !near || motion.loading || motion.held) return;
  if (!track.complete || !sameMotion(track.doc, doc)) return;
  const row = track.count - 1;
  const { start = 0, ...span } = track.doc.span;
  const time = Number((start + row * span.step).toPrecision(12));
  const ghosts = doc.ghosts.length ? { ghosts: onward(motion, doc.ghosts, row) } : {};
  motion.proceed(row);
  const patch = { initial: stateAt(track, row), span: { start: time, ...span }, ...ghosts };
  store.set(patch, { label: "endless", merge: "endless" });
  motion.proceed(-1);
}

/** @param {{store: Store, motion: Motion, clock: Clock}} parts @returns {Live} */
export function createLive({ store, motion, clock }) {
  /** @type {Map<string, Change>} */
  const wanted = new Map();
  let last = 0;
  let timer = 0;

  function apply() {
    timer = 0;
    if (!wanted.size || motion.loading || motion.held) return;
    last = performance.now();
    const name = [...wanted.keys()].join(" ");
    const changes = [...wanted.values()];
    wanted.clear();
    const doc = store.get();
    const { track } = motion;
    const row = rowOf(track, clock);
    const { start = 0, ...span } = track.doc.span;
    const time = row > 0 ? Number((start + row * span.step).toPrecision(12)) : start;
    const pendulum = changes.reduce((tree, change) => change(tree, time), doc.pendulum);
    const how = { label: "physics", merge: `physics ${name}` };
    if (row <= 0) return store.set({ pendulum }, how);
    const initial = stateAt(track, row);
    const { table } = pendulum.pivot?.x ?? {};
    // the motion ends with the places of its pivot
    const left = table ? (table.t[table.t.length - 1] - time) / span.step : Infinity;
    span.stop = Math.min(span.stop, Math.floor(left - 1e-6) * span.step);
    const ghosts = doc.ghosts.length ? { ghosts: onward(motion, doc.ghosts, row) } : {};
    motion.proceed(row);
    store.set({ pendulum, initial, span: { start: time, ...span }, ...ghosts }, how);
    // where the store has refused it, nothing goes on
    motion.proceed(-1);
  }

  function soon() {
    const wait = last + GAP_MS - performance.now();
    if (wait <= 0) apply();
    else timer ||= window.setTimeout(apply, wait);
  }

  clock.subscribe(() => runOn({ store, motion, clock }));
  motion.subscribe((_, what) => {
    if (what === "complete" || what === "failure") soon();
  });

  return {
    /** Soon, by the newest change of each name. */
    change(name, change) {
      wanted.set(name, change);
      soon();
    },
    /** How many changes wait. */
    waiting: () => wanted.size,
  };
}
