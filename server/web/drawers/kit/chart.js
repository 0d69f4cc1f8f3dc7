// Curves over time that share one time axis, one zoom and the clock.
// Leaves to others: what the curves are; how they are drawn (plot.js).
// Invariant: hovering a chart while the clock stands sets the clock; a click does so always;
// nothing else is changed.

import { createBag, h, svg } from "../../dom.js";
import { TYPE, drawn, longest, nameWidth, typeOf } from "./plot.js";

// beside the curves, in heights of the type: the numbers on the left, above, and the times below
const SIDE = 5;
const ABOVE = 0.7;
const BELOW = 2.2;
const DRAG = 5; // pixels, from which on a press is a drag

/** @typedef {{motion: Motion, clock: Clock, text: Text, group: ChartGroup}} Frame */

/**
 * Charts that share time.
 * @param {Pick<App, "motion" | "clock" | "text">} app @returns {ChartGroup}
 */
export function createGroup({ motion, clock, text }) {
  /** @type {Set<Chart>} */
  const charts = new Set();
  const bag = createBag();
  /** @type {[number, number] | null} */
  let zoomed = null; // from, to; null: all of it
  let letters = 0; // of the longest name beside a chart: all leave the same room for it

  /** @type {ChartGroup} */
  const group = {
    get zoomed() {
      return zoomed;
    },
    get letters() {
      return letters;
    },
    /** What is to be seen of the time axis; without arguments all of it. */
    zoom(from = null, to = null) {
      zoomed = from === null || to === null ? null : [from, to];
      for (const chart of charts) chart.range();
    },
    /** By a factor about the clock, or about the middle where the clock is not to be seen. */
    magnify: (factor) => magnify(group, clock, factor),
    /** The time under the pointer, in all charts; null without a pointer. */
    point(time) {
      for (const chart of charts) chart.point(time);
    },
    add(host, options) {
      letters = Math.max(letters, longest(options.series));
      const chart = createChart(host, options, { motion, clock, text, group });
      charts.add(chart);
      return chart;
    },
    remove(chart) {
      chart.destroy();
      charts.delete(chart);
    },
    follow() {
      for (const chart of charts) chart.follow();
    },
    destroy() {
      bag.end();
      for (const chart of charts) chart.destroy();
      charts.clear();
    },
  };
  bag(clock.subscribe(group.follow));
  return group;
}

/** @param {ChartGroup} group @param {Clock} clock @param {number} factor */
function magnify(group, clock, factor) {
  const [from, to] = group.zoomed ?? [0, clock.duration];
  const about = clock.time >= from && clock.time <= to ? clock.time : (from + to) / 2;
  const left = Math.max(0, about - (about - from) * factor);
  const right = Math.min(clock.duration, about + (to - about) * factor);
  if (left <= 0 && right >= clock.duration) group.zoom();
  else group.zoom(left, right);
}

/** What is to be seen of the time axis. @param {Frame} frame @returns {[number, number]} */
const span = ({ group, clock }) => group.zoomed ?? [0, clock.duration || 1];

/**
 * The part of a curve that is seen, with a sample before and behind it: of each of `most` stretches
 * of samples the lowest and the highest, which is all that differs in pixels. A stretch with a gap
 * (NaN) is kept whole.
 * @param {ChartData[0]} ts @param {ChartData[0]} ys @param {[number, number]} seen
 * @param {number} most
 */
function partOf(ts, ys, [from, to], most) {
  let [begin, end] = [0, ts.length];
  while (begin + 1 < end && Number(ts[begin + 1]) <= from) begin++;
  while (end - 1 > begin && Number(ts[end - 2]) >= to) end--;
  const stretch = Math.max(1, Math.ceil((end - begin) / most));
  const kept = [];
  for (let first = begin; first < end; first += stretch) {
    let [low, high] = [first, first];
    const last = Math.min(first + stretch, end);
    let gap = Number.isNaN(ys[first]);
    for (let i = first + 1; i < last; i++) {
      gap ||= Number.isNaN(ys[i]);
      if (!(Number(ys[i]) >= Number(ys[low]))) low = i;
      if (!(Number(ys[i]) <= Number(ys[high]))) high = i;
    }
    if (gap) {
      for (let i = first; i < last; i++) kept.push(i);
      continue;
    }
    kept.push(Math.min(low, high));
    if (low !== high) kept.push(Math.max(low, high));
  }
  return { xs: kept.map((i) => ts[i]), ys: kept.map((i) => ys[i]) };
}

/**
 * The pointer sets the clock, and the zoom where it is dragged.
 * @param {Bag} bag @param {HTMLElement} area @param {HTMLElement} chosen @param {Frame} frame
 */
function followPointer(bag, area, chosen, frame) {
  const { clock, group } = frame;
  /** @type {number | null} */
  let pressed = null; // where, pixels from the left
  const placeOf = (/** @type {PointerEvent} */ { clientX }) =>
    Math.max(0, Math.min(clientX - area.getBoundingClientRect().left, area.clientWidth));
  const timeAt = (/** @type {number} */ place) => {
    const [from, to] = span(frame);
    return from + (place / (area.clientWidth || 1)) * (to - from);
  };
  const release = () => {
    pressed = null;
    chosen.hidden = true;
  };
  bag.on(area, "pointerdown", (event) => {
    if (event.button) return;
    pressed = placeOf(event);
    area.setPointerCapture(event.pointerId);
  });
  bag.on(area, "pointermove", (event) => {
    const place = placeOf(event);
    if (pressed !== null) {
      chosen.hidden = Math.abs(place - pressed) < DRAG;
      chosen.style.left = `${Math.min(place, pressed)}px`;
      chosen.style.width = `${Math.abs(place - pressed)}px`;
    } else if (!clock.playing) clock.seek(timeAt(place));
    group.point(timeAt(place));
  });
  bag.on(area, "pointerup", (event) => {
    if (pressed === null) return;
    const place = placeOf(event);
    const ends = [timeAt(Math.min(pressed, place)), timeAt(Math.max(pressed, place))];
    const dragged = Math.abs(place - pressed) >= DRAG;
    release();
    if (dragged) group.zoom(...ends);
    else {
      clock.pause();
      clock.seek(timeAt(place));
    }
  });
  bag.on(area, "pointercancel", release);
  bag.on(area, "pointerleave", () => group.point(null));
  bag.on(area, "dblclick", () => group.zoom());
}

/**
 * The lines over a chart: of the clock, of the pointer, and the stretch that is chosen.
 * @param {Frame} frame
 */
function createArea(frame) {
  const now = h("div", { class: "now-line" });
  const pointer = h("div", { class: "now-line pointer" });
  const chosen = h("div", { class: "chart-chosen", hidden: true });
  const area = h("div", { class: "chart-area" }, chosen, pointer, now);
  const bag = createBag();
  let wide = 0;
  const put = (/** @type {HTMLElement} */ line, /** @type {number | null} */ time) => {
    const [from, to] = span(frame);
    const inside = time !== null && time >= from && time <= to;
    line.style.visibility = inside ? "visible" : "hidden";
    if (inside) line.style.transform = `translateX(${((time - from) / (to - from)) * wide}px)`;
  };
  followPointer(bag, area, chosen, frame);
  put(pointer, null);
  return {
    area,
    /** @param {import("./plot.js").Box} box */
    lay({ x, y, wide: width, tall }) {
      wide = width;
      const [left, top] = [`${x}px`, `${y}px`];
      Object.assign(area.style, { left, top, width: `${width}px`, height: `${tall}px` });
    },
    follow: () => put(now, frame.clock.time),
    point: (/** @type {number | null} */ time) => put(pointer, time),
    end: bag.end,
  };
}

/**
 * One chart: `series` has one entry for each list of data after the times; `log` means powers of
 * ten; `degrees`: its values are angles; `height` in pixels at the usual type.
 * @param {HTMLElement} host @param {ChartOptions} options @param {Frame} frame @returns {Chart}
 */
function createChart(host, { series, log = false, degrees = false, height = 140 }, frame) {
  const { motion, text, group } = frame;
  const { area, lay, follow, point, end } = createArea(frame);
  let drawing = svg("svg", {});
  host.replaceChildren(drawing, area);
  host.style.height = `${height / TYPE}em`;
  const shown = series.map((one) => one.shown ?? true);
  /** @type {ChartData} */
  let data = [new Float64Array(0), ...series.map(() => [])];
  let width = 0;
  const label = (/** @type {number} */ tick, /** @type {boolean} */ last) =>
    text.short((motion.doc.span.start ?? 0) + tick) + (last ? " s" : "");

  function range() {
    const type = typeOf(host);
    const height = host.clientHeight;
    const wide = width - SIDE * type - nameWidth(group.letters, type);
    if (wide <= 0) return;
    const from = span(frame);
    const box = { x: SIDE * type, y: ABOVE * type, wide, tall: height - (ABOVE + BELOW) * type };
    const curves = series.flatMap(({ colour, dash, width: thick = 1.4, name }, i) => {
      const look = { colour, dash, width: (thick * type) / TYPE, name };
      return shown[i] ? [{ ...partOf(data[0], data[i + 1], from, 2 * box.wide), ...look }] : [];
    });
    const axes = { log, clip: true, label, degrees: degrees ? "y" : "" };
    const { parts } = drawn({ from, curves, ...axes }, box, text, type);
    const size = { width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" };
    const next = svg("svg", size, ...parts);
    drawing.replaceWith(next);
    drawing = next;
    lay(box);
    follow();
  }
  const measure = () => {
    if (!host.clientWidth) return;
    width = host.clientWidth;
    range();
  };
  const observer = new ResizeObserver(measure);
  observer.observe(host);
  measure();
  return {
    range,
    follow,
    point,
    set(next) {
      data = next;
      range();
    },
    show(i, on) {
      shown[i] = on;
      range();
    },
    destroy() {
      observer.disconnect();
      end();
      host.replaceChildren();
    },
  };
}
