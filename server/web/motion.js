// The current trajectory, and those of the ghosts: asked of the server, loaded in pieces.
// Leaves to others: their samples (track.js), time (clock.js), drawing.
// Invariant: the current track is that of the store's document, or is being loaded for it; what was
// given up tells nothing.

import { Failure, gaveUp } from "./client.js";
import { early, motionBody } from "./first.js";
import { ghostOf, sameMotion } from "./state.js";
import { addRows, beginTrack, createGhost, createTrack, instantOf } from "./track.js";

// how finely the horizon is asked for where the motion's own answer does not tell it
const HORIZON_SAMPLES = 401;

/**
 * What loads: the motion that it keeps up to date, who listens, and what is under way; row: the
 * sample from which the next motion goes on, -1: from its own start; ghost: the one that the
 * document changes places with, -1: none; coming: a motion that takes over when the clock is there.
 * @typedef {{
 *   store: Store, client: Client, clock: Clock, motion: Motion,
 *   listeners: Set<(motion: Motion, what: string) => unknown>,
 *   stop: AbortController | null, stopGhosts: AbortController | null,
 *   held: boolean, waiting: boolean, first: typeof early | null,
 *   row: number, ghost: number, coming: {track: Track, at: number} | null,
 * }} Loader
 */

/** @param {Loader} loader @param {string} what */
function tell(loader, what) {
  for (const listener of [...loader.listeners]) listener(loader.motion, what);
}

/**
 * Makes the document's track the current one; it begins with the forces that are seen now.
 * @param {Loader} loader
 */
function renew({ store, motion, clock }) {
  const doc = store.get();
  const seen = motion.n === doc.pendulum.length.length ? motion.at(clock.time).lambda : null;
  motion.track = createTrack(doc, doc.initial);
  motion.track.preview = seen;
  motion.stats = null;
  motion.failure = null;
}

/** Tells the clock how far the samples reach. @param {Loader} loader */
function extend({ motion, clock }) {
  const { track } = motion;
  const duration = (track.total - 1) * track.doc.span.step;
  clock.extent(track.count ? (track.count - 1) * track.doc.span.step : 0, duration, track.complete);
}

/**
 * The reply that is on its way already, if it is the answer to this.
 * @param {Loader} loader @param {object} body
 */
async function takeEarly(loader, body) {
  const taken = loader.first;
  loader.first = null;
  return taken && taken.body === JSON.stringify(body) ? taken.reply : null;
}

/**
 * @param {Loader} loader @param {Track} track @param {AbortSignal} signal
 * @param {() => unknown} arrived after every piece, and at the end
 */
async function fetchTrack(loader, track, signal, arrived) {
  const body = motionBody(track.doc, track.initial);
  const reply = await takeEarly(loader, body);
  await loader.client.table("/v1/trajectories", body, {
    signal,
    reply,
    begin(columns, stats) {
      beginTrack(track, columns);
      track.stats = fromStart(stats, track.doc);
    },
    rows(values, count) {
      addRows(track, values, count);
      arrived();
    },
  });
  if (track.count < track.total) throw new Failure("broken");
  track.complete = true;
  arrived();
}

/**
 * What the server tells of times, from the start on.
 * @template {Stats | null} Told @param {Told} stats @param {Doc} doc @returns {Told}
 */
const fromStart = (stats, { span }) =>
  stats?.horizon !== undefined && span.start
    ? { ...stats, horizon: stats.horizon - span.start }
    : stats;

/**
 * How the integration went: the table's head tells it, but of a long motion, which is sent while it
 * is computed.
 * @param {Loader} loader @param {Doc} doc @param {AbortSignal} signal
 */
async function fetchStats(loader, doc, signal) {
  const { motion, client } = loader;
  let { stats } = motion.track;
  if (!stats) {
    const { start = 0, stop } = doc.span;
    const times = { start, stop: start + stop, count: Math.min(HORIZON_SAMPLES, motion.total) };
    const body = { ...motionBody(doc), times, output: ["energy"], digits: 4 };
    ({ stats } = await client.trajectory(body, { signal }));
    stats = fromStart(stats, doc);
  }
  motion.stats = stats;
  tell(loader, "stats");
}

/** @param {Loader} loader @param {unknown} error */
function fail(loader, error) {
  if (gaveUp(error)) return;
  if (!(error instanceof Failure)) throw error;
  loader.motion.loading = false;
  loader.motion.failure = error;
  if (loader.coming) {
    loader.coming = null;
    extend(loader);
  }
  tell(loader, "failure");
}

/**
 * Abandons what is under way and loads the document's motion; the clock goes back unless only the
 * way to it changed.
 * @param {Loader} loader
 */
async function load(loader) {
  const { store, motion, clock } = loader;
  loader.stop?.abort();
  loader.stop = new AbortController();
  const { signal } = loader.stop;
  const doc = store.get();
  const before = motion.track.doc;
  const sameStart = before.pendulum === doc.pendulum && before.initial === doc.initial;
  loader.waiting = false;
  loader.coming = null;
  renew(loader);
  motion.loading = true;
  clock.restart(sameStart ? clock.time : 0);
  extend(loader);
  tell(loader, "begin");
  loadGhosts(loader, doc);
  try {
    await fetchTrack(loader, motion.track, signal, () => {
      if (signal.aborted) return;
      extend(loader);
      tell(loader, "rows");
    });
    motion.loading = false;
    tell(loader, "complete");
    await fetchStats(loader, doc, signal);
  } catch (error) {
    fail(loader, error);
  }
}

/** @param {Loader} loader @param {Doc} doc */
async function loadGhosts(loader, doc) {
  loader.stopGhosts?.abort();
  loader.stopGhosts = new AbortController();
  const { signal } = loader.stopGhosts;
  loader.motion.ghosts = doc.ghosts.map((ghost) => createGhost(doc, ghost));
  try {
    for (const track of loader.motion.ghosts) {
      await fetchTrack(loader, track, signal, () => !signal.aborted && tell(loader, "ghosts"));
    }
  } catch (error) {
    fail(loader, error);
  }
}

/** While something is dragged the start alone is shown. @param {Loader} loader @param {Doc} doc */
function wait(loader, doc) {
  loader.stop?.abort();
  loader.waiting = true;
  loader.coming = null;
  renew(loader);
  loader.motion.ghosts = doc.ghosts.map((ghost) => createGhost(doc, ghost));
  loader.clock.restart(0);
  extend(loader);
  tell(loader, "begin");
}

/**
 * What is coming becomes the current track, once it has begun to arrive and the clock is there.
 * @param {Loader} loader
 */
function takeOver(loader) {
  const { coming, motion, clock } = loader;
  if (!coming?.track.count) return;
  if (clock.playing && clock.time < coming.at - 1e-9) return;
  loader.coming = null;
  motion.track = coming.track;
  motion.stats = null;
  clock.shift(coming.at);
  extend(loader);
  tell(loader, "begin");
  tell(loader, "rows");
  loadGhosts(loader, motion.doc);
  if (motion.complete) finish(loader);
}

/** The motion that has taken over is whole. @param {Loader} loader */
async function finish(loader) {
  const { motion, stop } = loader;
  const signal = /** @type {AbortController} */ (stop).signal;
  motion.loading = false;
  tell(loader, "complete");
  try {
    await fetchStats(loader, motion.doc, signal);
  } catch (error) {
    fail(loader, error);
  }
}

/**
 * Loads the document's motion as the one that goes on from a sample of this one, which is seen
 * meanwhile.
 * @param {Loader} loader @param {number} row
 */
async function proceed(loader, row) {
  const { store, motion, clock } = loader;
  loader.stop?.abort();
  loader.stop = new AbortController();
  const { signal } = loader.stop;
  const doc = store.get();
  const track = createTrack(doc, doc.initial);
  const at = row * motion.track.doc.span.step;
  loader.coming = { track, at };
  motion.loading = true;
  motion.failure = null;
  clock.extent(at, clock.duration, false);
  try {
    await fetchTrack(loader, track, signal, () => {
      if (signal.aborted) return;
      if (loader.coming) return takeOver(loader);
      extend(loader);
      tell(loader, "rows");
    });
    if (motion.track === track && motion.loading) await finish(loader);
  } catch (error) {
    fail(loader, error);
  }
}

/**
 * The document's motion and that of a ghost have changed places: nothing is loaded.
 * @param {Loader} loader @param {Doc} doc @param {number} ghost
 */
function exchange(loader, doc, ghost) {
  const { motion } = loader;
  const [first, second] = [motion.ghosts[ghost], motion.track];
  Object.assign(first, { doc, initial: doc.initial });
  Object.assign(second, ghostOf(doc, doc.ghosts[ghost]));
  motion.track = first;
  motion.ghosts = motion.ghosts.map((track, i) => (i === ghost ? second : track));
  motion.stats = null;
  for (const what of ["begin", "rows", "ghosts"]) tell(loader, what);
  finish(loader);
}

/** @param {Loader} loader @param {Doc} doc @param {Doc} before */
function follow(loader, doc, before) {
  const { row, ghost } = loader;
  loader.row = loader.ghost = -1;
  const whole = !loader.held && !loader.coming && !loader.motion.loading;
  if (ghost >= 0 && whole && loader.motion.ghosts[ghost]?.complete) exchange(loader, doc, ghost);
  else if (!sameMotion(doc, before)) {
    if (loader.held) wait(loader, doc);
    else if (row >= 0) proceed(loader, row);
    else load(loader);
  } else if (doc.ghosts !== before.ghosts) {
    loadGhosts(loader, doc);
    tell(loader, "ghosts");
  }
}

/** What of the current track is asked for most, as the motion's own. @param {() => Track} track */
const current = (track) => ({
  get t() {
    return track().t;
  },
  get columns() {
    return track().columns;
  },
  get n() {
    return track().n;
  },
  get count() {
    return track().count;
  },
  get total() {
    return track().total;
  },
  get complete() {
    return track().complete;
  },
  get doc() {
    return track().doc;
  },
});

/** What can be done with the motion. @param {Loader} loader */
const verbs = (loader) => ({
  get held() {
    return loader.held;
  },
  /**
   * {time, index, fraction, phi, phid, lambda} at a time; made anew with each call: for what is not
   * a frame.
   * @param {number} time
   */
  at: (time) => instantOf(loader.motion.track, time),
  /** Loads nothing while something is being dragged; loads what has changed when it is let go. */
  hold() {
    loader.held = true;
  },
  /**
   * The document's next change goes on from a sample of this motion, which is shown until then.
   * @param {number} row
   */
  proceed(row) {
    loader.row = row;
  },
  /**
   * With the document's next change it and a ghost change places.
   * @param {number} ghost
   */
  exchange(ghost) {
    loader.ghost = ghost;
  },
  /** The forces of the start, known before its motion. @param {ArrayLike<number>} lambda */
  foresee(lambda) {
    const { track } = loader.motion;
    if (track.count || lambda.length !== track.n) return;
    track.preview = lambda;
    tell(loader, "preview");
  },
  release() {
    loader.held = false;
    if (loader.waiting) load(loader);
  },
  reload: () => load(loader),
  /**
   * Something to be said that is no failure of the motion: a link that cannot be read.
   * @param {string | null} words
   */
  note(words) {
    loader.motion.complaint = words;
    tell(loader, "note");
  },
  begin: () => load(loader),
  /**
   * fn(motion, what) when a motion begins ("begin"), rows arrive ("rows"), it is whole
   * ("complete"), stats come, it fails.
   * @param {(motion: Motion, what: string) => unknown} fn
   */
  subscribe(fn) {
    loader.listeners.add(fn);
    return () => loader.listeners.delete(fn);
  },
});

/** @param {{store: Store, client: Client, clock: Clock}} parts @returns {Motion} */
export function createMotion({ store, client, clock }) {
  const doc = store.get();
  const first = {
    track: createTrack(doc, doc.initial),
    ghosts: [], // one track for each of the document's ghosts
    stats: null, // of the server: energy_drift, and horizon, up to when the digits hold
    loading: false,
    failure: null,
    complaint: null,
  };
  const state = {
    stop: null,
    stopGhosts: null,
    held: false,
    waiting: false,
    first: early,
    row: -1,
    ghost: -1,
    coming: null,
  };
  const motion = /** @type {Motion} */ (/** @type {unknown} */ (first));
  /** @type {Loader} */
  const loader = { store, client, clock, motion, listeners: new Set(), ...state };
  for (const part of [current(() => motion.track), verbs(loader)]) {
    Object.defineProperties(motion, Object.getOwnPropertyDescriptors(part));
  }
  store.subscribe((next, before) => follow(loader, next, before));
  clock.subscribe(() => loader.coming && takeOver(loader));
  return motion;
}
