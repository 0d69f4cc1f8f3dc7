// The numbers with a slider of what ends a smooth motion: dry friction that holds, stops; and
// tables of a motor's torque and of the pivot's places.
// Leaves to others: the other numbers (physics_fields.js), the sliders (physics.js).
// Invariant: as of physics_fields.js; a stop whose range is 0 is none.

import { DEGREE } from "../../angles.js";
import { h } from "../../dom.js";
import { termOf, withTerm } from "../../terms.js";
import { button } from "../kit/kit.js";

/** @typedef {import("./physics_fields.js").Field} Field */

/** Coulomb's friction of an arm: one without a speed. @param {Tree} tree @param {number} k */
function coulombOf(tree, k) {
  const friction = termOf(tree, "friction", k);
  return friction && !friction.speed ? friction : null;
}

/** The middle and half the width of what a stop leaves free, degrees. @param {Stop} stop */
function rangeOf({ min = -Math.PI, max = Math.PI }) {
  return { middle: (min + max) / 2 / DEGREE, half: (max - min) / 2 / DEGREE };
}

/**
 * A number of the stops that there are.
 * @param {string} name @param {string} unit @param {(stop: Stop) => number} get
 * @param {(stop: Stop, value: number) => Stop} change @param {number} most @param {number} least
 * @returns {Field}
 */
const ofStop = (name, unit, get, change, most, least = 0) => ({
  name,
  group: "stop",
  unit,
  even: true,
  get: (tree, k) => {
    const stop = termOf(tree, "stop", k);
    return stop ? get(stop) : 0;
  },
  set: (tree, arms, value) =>
    withTerm(tree, "stop", (k) => {
      const stop = termOf(tree, "stop", k);
      return stop && arms.has(k) ? change(stop, value) : stop;
    }),
  most: () => most,
  ...(least && { least: () => least }),
  needs: (tree, k) => termOf(tree, "stop", k) !== null,
});

/**
 * @param {number} middle @param {number} half degrees @param {number} restitution
 * @returns {Stop}
 */
const stopOf = (middle, half, restitution) => ({
  min: (middle - half) * DEGREE,
  max: (middle + half) * DEGREE,
  restitution,
});

/** @type {Field[]} */
export const STOP_FIELDS = [
  {
    name: "coulomb",
    group: "friction",
    unit: "N\u00b7m",
    get: (tree, k) => coulombOf(tree, k)?.torque ?? 0,
    set: (tree, arms, torque) =>
      withTerm(tree, "friction", (k) => {
        const old = termOf(tree, "friction", k);
        if (!arms.has(k) || (!torque && old?.speed)) return old;
        return torque ? { torque } : null;
      }),
    most: ({ torque }) => torque / 2,
  },
  {
    name: "holding",
    group: "friction",
    unit: "N\u00b7m",
    get: (tree, k) => coulombOf(tree, k)?.static ?? coulombOf(tree, k)?.torque ?? 0,
    set: (tree, arms, value) =>
      withTerm(tree, "friction", (k) => {
        const old = coulombOf(tree, k);
        if (!old || !arms.has(k)) return termOf(tree, "friction", k);
        return { torque: old.torque, static: Math.max(old.torque, value) };
      }),
    most: ({ torque }) => torque / 2,
    needs: (tree, k) => coulombOf(tree, k) !== null,
  },
  {
    name: "stopRange",
    group: "stop",
    unit: "\u00b0",
    even: true,
    get: (tree, k) => {
      const stop = termOf(tree, "stop", k);
      return stop ? rangeOf(stop).half : 0;
    },
    set: (tree, arms, half) =>
      withTerm(tree, "stop", (k) => {
        const old = termOf(tree, "stop", k);
        if (!arms.has(k)) return old;
        return half ? stopOf(old ? rangeOf(old).middle : 0, half, old?.restitution ?? 0.5) : null;
      }),
    most: () => 180,
  },
  ofStop(
    "stopMiddle",
    "\u00b0",
    (stop) => rangeOf(stop).middle,
    (stop, middle) => stopOf(middle, rangeOf(stop).half, stop.restitution ?? 0),
    180,
    -180,
  ),
  ofStop(
    "restitution",
    "",
    ({ restitution = 0 }) => restitution,
    (stop, restitution) => ({ ...stop, restitution: Math.min(1, restitution) }),
    1,
  ),
];

/**
 * Columns of times, which ascend, and of one or two quantities, a line a row; null where there are
 * none.
 * @param {Text} text @param {string} typed @returns {number[][] | null}
 */
export function columnsOf(text, typed) {
  /** @param {string} line */
  const cells = (line) => line.split(/[\t; ]+|,\s+/).map((cell) => text.read(cell));
  const rows = typed
    .split("\n")
    .map((line) => cells(line.trim()))
    .filter((row) => row.length >= 2 && row.every(Number.isFinite));
  const [t, ...values] = [0, 1, 2].map((i) => rows.map((row) => row[i] ?? 0));
  return rows.length < 2 || t.some((time, i) => time <= t[i - 1]) ? null : [t, ...values];
}

/** @param {Live} live @param {number} k @param {number[][]} columns none: no table */
function useTorque(live, k, [t, value]) {
  live.change(`table ${k}`, (tree) =>
    withTerm(tree, "torque", (i) => {
      const old = termOf(tree, "torque", i);
      if (i !== k) return old;
      const motor = typeof old === "number" ? { constant: old } : { ...old };
      if (t) return { ...motor, table: { t, value, hold: "linear", outside: "zero" } };
      if ("table" in motor) delete motor.table;
      return Object.keys(motor).length ? motor : null;
    }),
  );
}

/** The motion lasts as long as its pivot's places. @param {App} app @param {number[][]} columns */
function usePlaces({ store, clock }, [times, x, y]) {
  const { pendulum, span, view } = store.get();
  const { pivot } = pendulum;
  const t = times?.map((one) => one - times[0]);
  /** @param {Axis | undefined} axis @param {number[]} value @returns {Axis} */
  const moved = ({ harmonics = [] } = {}, value) => ({
    harmonics,
    ...(t && { table: { t, value } }),
  });
  const tree = { ...pendulum, pivot: { ...pivot, x: moved(pivot?.x, x), y: moved(pivot?.y, y) } };
  const lasts = { stop: t ? t[t.length - 1] : span.stop, step: span.step };
  store.set({ pendulum: tree, span: lasts, view: { ...view, endless: false } }, { label: "table" });
  clock.seek(0);
}

/**
 * A field for a table: the torque of the chosen arm, or the places of the pivot.
 * @param {App} app @param {"table" | "track"} name
 */
export function createTable(app, name) {
  const { text, store, live, object } = app;
  const words = text(`physics.${name}`);
  const area = h("textarea", {
    rows: 4,
    "data-table": name,
    "aria-label": words,
    placeholder: name === "table" ? "0 0\n1 0.5\n2 0" : "0 0 0\n1 0.1 0\n2 0 0",
  });
  const use = () => {
    const columns = area.value.trim() ? columnsOf(text, area.value) : [];
    if (!columns) return object(text("physics.tableWrong"));
    if (name === "track") usePlaces(app, columns);
    else useTorque(live, Math.max(store.get().view.selected, 1) - 1, columns);
    store.settle();
  };
  return h(
    "details",
    { class: "lazy" },
    h("summary", {}, words),
    name === "table" ? h("p", { class: "quiet" }, text("physics.tableHint")) : "",
    area,
    h("div", { class: "row" }, button(text("physics.tableUse"), use, { "data-use": name })),
  );
}
