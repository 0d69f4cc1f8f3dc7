// One trajectory as a table of samples: rows are added while they arrive, values are read between
// two of them.
// Leaves to others: asking the server for it (motion.js), where its tips are (tree.js).
// Invariant: rows 0 ... count-1 of every column are what the server sent (t: since the start);
// between them it interpolates and integrates nothing.

import { ghostOf } from "./state.js";

/** @param {Doc} doc @param {State} initial @returns {Track} without a sample */
export function createTrack(doc, initial) {
  const n = doc.pendulum.length.length;
  const total = Math.floor(doc.span.stop / doc.span.step + 1e-9) + 1;
  const table = { t: new Float64Array(0), columns: {}, widths: {}, parts: [], width: 0 };
  return {
    doc,
    initial,
    n,
    total,
    count: 0,
    complete: false,
    preview: null,
    stats: null,
    ...table,
  };
}

/** @param {Doc} doc @param {Ghost} ghost */
export function createGhost(doc, ghost) {
  const { doc: own, initial } = ghostOf(doc, ghost);
  return createTrack(own, initial);
}

/** Makes room for the columns of a table. @param {Track} track @param {Column[]} columns */
export function beginTrack(track, columns) {
  track.parts = [];
  let offset = 0;
  for (const { name, count } of columns) {
    const values = new Float64Array(track.total * count);
    if (name === "t") track.t = values;
    else {
      track.columns[name] = values;
      track.widths[name] = count;
    }
    const shift = name === "t" ? (track.doc.span.start ?? 0) : 0;
    track.parts.push({ values, count, offset, shift });
    offset += count;
  }
  track.width = offset;
}

/**
 * @param {Track} track @param {Float64Array} rows @param {number} count how many whole rows these
 * are
 */
export function addRows(track, rows, count) {
  const room = Math.min(count, track.total - track.count);
  for (const { values, count: width, offset, shift } of track.parts) {
    for (let i = 0; i < room; i++) {
      const from = i * track.width + offset;
      const to = (track.count + i) * width;
      for (let k = 0; k < width; k++) values[to + k] = rows[from + k] - shift;
    }
  }
  track.count += room;
}

/**
 * Where a time lies among the samples, written into place.
 * @param {Samples} track @param {number} time @param {Place} place
 */
export function locate(track, time, place) {
  const last = Math.max(track.count - 1, 0);
  const position = Math.min(Math.max(time / track.doc.span.step, 0), last);
  place.index = Math.min(Math.floor(position), Math.max(last - 1, 0));
  place.fraction = position - place.index;
}

/**
 * The angles at a time (cubic between two samples, by their angular velocities) into phi; no
 * allocation.
 * @param {Samples} track @param {number} time @param {Place} place @param {Float64Array} phi
 */
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

/**
 * A column at a time, linear between two samples, into values; what is known before the first
 * sample, else zeros.
 * @param {Track} track @param {string} name @param {number} time @param {Place} place @param
 * {Float64Array} values
 */
export function valuesAt(track, name, time, place, values) {
  if (!track.count) {
    if (track.preview && name === "lambda") values.set(track.preview);
    else values.fill(0);
    return;
  }
  locate(track, time, place);
  const width = track.widths[name];
  const column = track.columns[name];
  const from = place.index * width;
  const to = track.count > 1 ? from + width : from;
  for (let k = 0; k < width; k++)
    values[k] = column[from + k] + place.fraction * (column[to + k] - column[from + k]);
}

/**
 * Where the cart is at a sample, or between two, m; 0 of a pendulum without one.
 * @param {Samples} track @param {number} row @param {number} fraction of the way to the next
 */
export function cartAt({ count, columns, initial }, row, fraction = 0) {
  const places = columns.cart_x;
  if (!count || !places) return initial.cart?.x ?? 0;
  return places[row] + fraction * (places[Math.min(row + 1, count - 1)] - places[row]);
}

/**
 * {time, index, fraction, phi, phid, lambda, cart} at a time, made anew.
 * @param {Track} track @param {number} time @returns {Instant}
 */
export function instantOf(track, time) {
  const place = { index: 0, fraction: 0 };
  /** @param {string} name */
  const row = (name) => {
    const values = new Float64Array(track.n);
    valuesAt(track, name, time, place, values);
    return values;
  };
  const phi = new Float64Array(track.n);
  anglesAt(track, time, place, phi);
  const cart = cartAt(track, place.index, place.fraction);
  return { time, ...place, phi, phid: row("phid"), lambda: row("lambda"), cart };
}
