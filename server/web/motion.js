// The current trajectory, and those of the ghosts: tables of samples from the server, loaded in pieces.
// Leaves to others: time (clock.js), drawing. Between samples it interpolates; it integrates nothing.
// Invariant: rows 0 ... count-1 of every column are what the server sent, for the document of `doc`.

import { Failure } from "./client.js";
import { early, motionBody } from "./first.js";
import { ghostOf, sameMotion } from "./state.js";

const HORIZON_SAMPLES = 401; // how finely the horizon is asked for where the motion's own answer does not tell it

/** One trajectory: {n, t, columns: {phi, phid, lambda, energy_total, ...}, count, total, complete}, row by row. */
function createTrack(doc, initial) {
  const n = doc.pendulum.length.length;
  const total = Math.floor(doc.span.stop / doc.span.step + 1e-9) + 1;
  return {
    doc,
    initial,
    n,
    total,
    count: 0,
    complete: false,
    preview: null,
    t: new Float64Array(0),
    columns: {},
    widths: {},
  };
}

function createGhost(doc, ghost) {
  const { doc: own, initial } = ghostOf(doc, ghost);
  return createTrack(own, initial);
}

function beginTrack(track, columns) {
  track.parts = [];
  let offset = 0;
  for (const { name, count } of columns) {
    const values = new Float64Array(track.total * count);
    if (name === "t") track.t = values;
    else {
      track.columns[name] = values;
      track.widths[name] = count;
    }
    track.parts.push({ values, count, offset });
    offset += count;
  }
  track.width = offset;
}

function addRows(track, rows, count) {
  const room = Math.min(count, track.total - track.count);
  for (const { values, count: width, offset } of track.parts) {
    for (let i = 0; i < room; i++) {
      const from = i * track.width + offset;
      const to = (track.count + i) * width;
      for (let k = 0; k < width; k++) values[to + k] = rows[from + k];
    }
  }
  track.count += room;
}

/** Where a time lies among the samples: writes {index, fraction} into place. */
export function locate(track, time, place) {
  const last = Math.max(track.count - 1, 0);
  const position = Math.min(Math.max(time / track.doc.span.step, 0), last);
  place.index = Math.min(Math.floor(position), Math.max(last - 1, 0));
  place.fraction = position - place.index;
}

/** The angles at a time (cubic between two samples, by their angular velocities) into phi; no allocation. */
export function anglesAt(track, time, place, phi) {
  if (!track.count) return phi.set(track.initial.phi);
  locate(track, time, place);
  const { n, columns, doc } = track;
  const s = place.fraction;
  const from = place.index * n;
  const to = track.count > 1 ? from + n : from;
  const h = doc.span.step;
  const b1 = s * s * (3 - 2 * s);
  const d0 = s * (1 - s) * (1 - s) * h;
  const d1 = s * s * (s - 1) * h;
  for (let k = 0; k < n; k++) {
    const a = columns.phi[from + k];
    phi[k] =
      a + b1 * (columns.phi[to + k] - a) + d0 * columns.phid[from + k] + d1 * columns.phid[to + k];
  }
}

/** A column at a time, linear between two samples, into values; what is known before the first sample, else zeros. */
export function valuesAt(track, name, time, place, values) {
  if (!track.count)
    return track.preview && name === "lambda" ? values.set(track.preview) : values.fill(0);
  locate(track, time, place);
  const width = track.widths[name];
  const column = track.columns[name];
  const from = place.index * width;
  const to = track.count > 1 ? from + width : from;
  for (let k = 0; k < width; k++)
    values[k] = column[from + k] + place.fraction * (column[to + k] - column[from + k]);
}

export function createMotion({ store, client, clock }) {
  const listeners = new Set();
  let stop = null;
  let stopGhosts = null;
  let held = false;
  let waiting = false;
  let first = early;
  const place = { index: 0, fraction: 0 };

  const motion = {
    track: createTrack(store.get(), store.get().initial),
    ghosts: [], // one track for each of the document's ghosts
    stats: null, // of the server: at least energy_drift, and horizon, up to when the digits hold
    loading: false,
    failure: null,
    complaint: null,
    get t() {
      return motion.track.t;
    },
    get columns() {
      return motion.track.columns;
    },
    get widths() {
      return motion.track.widths;
    },
    get n() {
      return motion.track.n;
    },
    get count() {
      return motion.track.count;
    },
    get total() {
      return motion.track.total;
    },
    get complete() {
      return motion.track.complete;
    },
    get doc() {
      return motion.track.doc;
    },
    /** {time, index, fraction, phi, phid, lambda} at a time; made anew with each call: for what is not a frame. */
    at(time) {
      const row = (name) => {
        const values = new Float64Array(motion.track.n);
        valuesAt(motion.track, name, time, place, values);
        return values;
      };
      const phi = new Float64Array(motion.track.n);
      anglesAt(motion.track, time, place, phi);
      return { time, ...place, phi, phid: row("phid"), lambda: row("lambda") };
    },
    /** Loads nothing while something is being dragged; loads what has changed when it is let go. */
    hold() {
      held = true;
    },
    get held() {
      return held;
    },
    /** The forces of the start, known before its motion. */
    foresee(lambda) {
      if (motion.track.count || lambda.length !== motion.track.n) return;
      motion.track.preview = lambda;
      tell("preview");
    },
    release() {
      held = false;
      if (waiting) load();
    },
    reload: () => load(),
    /** Something to be said that is no failure of the motion: a link that cannot be read. */
    note(words) {
      motion.complaint = words;
      tell("note");
    },
    /** fn(motion, what) when a motion begins ("begin"), rows arrive ("rows"), it is whole ("complete"), stats come, it fails. */
    subscribe(fn) {
      listeners.add(fn);
      return () => listeners.delete(fn);
    },
  };

  function tell(what) {
    for (const listener of [...listeners]) listener(motion, what);
  }

  /** Makes the document's track the current one; it begins with the forces that are seen now. */
  function renew() {
    const doc = store.get();
    const seen = motion.n === doc.pendulum.length.length ? motion.at(clock.time).lambda : null;
    motion.track = createTrack(doc, doc.initial);
    motion.track.preview = seen;
    motion.stats = null;
    motion.failure = null;
  }

  function extend() {
    const { track } = motion;
    const duration = (track.total - 1) * track.doc.span.step;
    clock.extent(
      track.count ? (track.count - 1) * track.doc.span.step : 0,
      duration,
      track.complete,
    );
  }

  /** The reply that is on its way already, if it is the answer to this. */
  async function takeEarly(body) {
    const taken = first;
    first = null;
    return taken && taken.body === JSON.stringify(body) ? taken.reply : null;
  }

  async function fetchTrack(track, signal, arrived) {
    const body = motionBody(track.doc, track.initial);
    const reply = await takeEarly(body);
    await client.table("/v1/trajectories", body, {
      signal,
      reply,
      begin(columns, stats) {
        beginTrack(track, columns);
        track.stats = stats;
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

  /** How the integration went: the table's head tells it, but of a long motion, which is sent while it is computed. */
  async function fetchStats(doc, signal) {
    let { stats } = motion.track;
    if (!stats) {
      const { output, ...body } = motionBody(doc);
      body.times = {
        start: 0,
        stop: doc.span.stop,
        count: Math.min(HORIZON_SAMPLES, motion.total),
      };
      ({ stats } = await client.trajectory({ ...body, output: ["energy"], digits: 4 }, { signal }));
    }
    motion.stats = stats;
    tell("stats");
  }

  function fail(error) {
    if (error.name === "AbortError") return;
    if (!(error instanceof Failure)) throw error;
    motion.loading = false;
    motion.failure = error;
    tell("failure");
  }

  /** Abandons what is under way and loads the document's motion; the clock goes back unless only the way to it changed. */
  async function load() {
    stop?.abort();
    stop = new AbortController();
    const { signal } = stop;
    const doc = store.get();
    const before = motion.track.doc;
    const sameStart = before.pendulum === doc.pendulum && before.initial === doc.initial;
    waiting = false;
    renew();
    motion.loading = true;
    clock.restart(sameStart ? clock.time : 0);
    extend();
    tell("begin");
    loadGhosts(doc);
    try {
      await fetchTrack(motion.track, signal, () => {
        if (signal.aborted) return;
        extend();
        tell("rows");
      });
      motion.loading = false;
      tell("complete");
      await fetchStats(doc, signal);
    } catch (error) {
      fail(error);
    }
  }

  async function loadGhosts(doc) {
    stopGhosts?.abort();
    stopGhosts = new AbortController();
    const { signal } = stopGhosts;
    motion.ghosts = doc.ghosts.map((ghost) => createGhost(doc, ghost));
    try {
      for (const track of motion.ghosts)
        await fetchTrack(track, signal, () => !signal.aborted && tell("ghosts"));
    } catch (error) {
      fail(error);
    }
  }

  store.subscribe((doc, before) => {
    if (!sameMotion(doc, before)) {
      if (!held) return load();
      stop?.abort();
      waiting = true;
      renew();
      motion.ghosts = doc.ghosts.map((ghost) => createGhost(doc, ghost));
      clock.restart(0);
      extend();
      tell("begin");
      return;
    }
    if (doc.ghosts !== before.ghosts) {
      loadGhosts(doc);
      tell("ghosts");
    }
  });

  motion.begin = () => load();
  return motion;
}
