// Curves over time: uPlot in the page's colours, charts of a group sharing one time axis, one zoom
// and the clock.
// Leaves to others: what the curves are.
// Invariant: hovering a chart while the clock stands sets the clock; a click does so always;
// nothing else is changed.

import { createBag, h } from "../../dom.js";
import { cssValue, figure } from "./kit.js";

const AXIS = 58;
const LEAST = 1e-16;

/**
 * What charts are made of: the library, the clock, the words.
 * @typedef {{uPlot: any, motion: Motion, clock: Clock, text: Text, key: string, group:
 * ChartGroup}} Frame
 */

/** @typedef {Required<ChartOptions>} Look */

/**
 * Charts that share time.
 * @param {App} app @param {string} key a name of the group @returns {Promise<ChartGroup>}
 */
export async function createGroup({ motion, clock, text, files }, key) {
  const coming = [files.script("lib/uplot.js"), files.style("lib/uplot.css")];
  const [{ default: uPlot }] = await Promise.all(coming);
  /** @type {Set<Chart>} */
  const charts = new Set();
  const bag = createBag();
  /** @type {[number, number] | null} */
  let zoomed = null; // from, to; null: all of it

  /** @type {ChartGroup} */
  const group = {
    get zoomed() {
      return zoomed;
    },
    /** What is to be seen of the time axis; without arguments all of it. */
    zoom(from = null, to = null) {
      zoomed = from === null || to === null ? null : [from, to];
      for (const chart of charts) chart.range();
    },
    /** By a factor about the clock, or about the middle where the clock is not to be seen. */
    magnify: (factor) => magnify(group, clock, factor),
    add(host, options) {
      const chart = createChart(host, options, { uPlot, motion, clock, text, key, group });
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

/** Powers of ten between two, not more than a few. @param {number} low @param {number} high */
function powers(low, high) {
  const from = Math.round(Math.log10(low));
  const to = Math.round(Math.log10(high));
  const step = Math.max(1, Math.ceil((to - from) / 6));
  const list = [];
  for (let power = Math.ceil(from / step) * step; power <= to; power += step)
    list.push(10 ** power);
  return list;
}

/** @param {Frame} frame @param {Look} look */
function axes({ text, motion }, { times, log }) {
  const line = cssValue("--line");
  const common = {
    stroke: cssValue("--quiet"),
    font: "11px system-ui, sans-serif",
    ticks: { stroke: line, width: 1, size: 4 },
    grid: { stroke: line, width: 1 },
  };
  const time = {
    ...common,
    show: true,
    size: times ? 26 : 6,
    space: 60,
    values: (/** @type {unknown} */ _, /** @type {number[]} */ ticks) =>
      ticks.map((tick) => (times ? text.short((motion.doc.span.start ?? 0) + tick) : "")),
  };
  const value = {
    ...common,
    size: AXIS,
    space: log ? 22 : 30,
    values: (/** @type {unknown} */ _, /** @type {(number | null)[]} */ ticks) =>
      ticks.map((tick) => (tick === null ? "" : figure(text, tick))),
  };
  return [time, log ? { ...value, ...LOG_AXIS } : value];
}

const LOG_AXIS = {
  /** @param {unknown} _ @param {unknown} _axis @param {number} low @param {number} high */
  splits: (_, _axis, low, high) => powers(low, high),
  /** @param {unknown} _ @param {number[]} ticks */
  filter: (_, ticks) => ticks,
};

/**
 * Powers of ten around what there is, so that few values make an axis too; what is below the last
 * digit of a double is cut off.
 * @param {unknown} _ @param {number} low @param {number} high
 */
function logRange(_, low, high) {
  const from = Number.isFinite(low) && low > 0 ? Math.max(low, LEAST) : 1e-9;
  const to = Number.isFinite(high) && high > 0 ? high : 1;
  const bottom = Math.floor(Math.log10(from));
  return [10 ** bottom, 10 ** Math.max(Math.ceil(Math.log10(to)), bottom + 1)];
}

/**
 * Around what there is; what is as good as constant gets room, so that it is a line and no frame.
 * @param {unknown} _ @param {number} low @param {number} high
 */
function plainRange(_, low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [-1, 1];
  const room = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
  return [low - room, high + room];
}

/** @param {Series} one */
function curve(one) {
  const ratio = Math.max(1, Math.min(devicePixelRatio, 2));
  return {
    stroke: one.colour,
    width: one.width ?? 1.4,
    dash: one.dash?.map((part) => part * ratio),
    show: one.shown ?? true,
    points: { show: false },
    spanGaps: false,
  };
}

/** What is to be seen of the time axis. @param {Frame} frame @returns {[number, number]} */
const span = ({ group, clock }) => group.zoomed ?? [0, clock.duration || 1];

/** uPlot's options of a chart. @param {HTMLElement} host @param {Look} look @param {Frame} frame */
function optionsOf(host, look, frame) {
  const y = look.log ? { distr: 3, range: logRange } : { range: plainRange };
  return {
    width: Math.max(host.clientWidth, 120),
    height: look.height,
    pxAlign: 0,
    padding: [8, 8, 0, 0],
    legend: { show: false },
    cursor: {
      y: false,
      points: { show: false },
      sync: { key: frame.key, scales: ["x", null] },
      drag: { x: true, y: false, setScale: false },
    },
    scales: { x: { time: false, auto: false, range: () => span(frame) }, y },
    axes: axes(frame, look),
    series: [{}, ...look.series.map(curve)],
    hooks: { setSelect: [(/** @type {any} */ plotted) => chosen(frame.group, plotted)] },
  };
}

/**
 * A stretch of time that has been drawn over is what is seen next.
 * @param {ChartGroup} group @param {any} plotted
 */
function chosen(group, plotted) {
  const { left, width } = plotted.select;
  if (width < 5) return;
  group.zoom(plotted.posToVal(left, "x"), plotted.posToVal(left + width, "x"));
  plotted.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
}

/** The mouse sets the clock. @param {Bag} bag @param {any} plot @param {Frame} frame */
function followMouse(bag, plot, { clock, group }) {
  let pressed = 0;
  const timeAt = (/** @type {MouseEvent} */ event) =>
    plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
  bag.on(plot.over, "mousedown", (event) => {
    pressed = event.clientX;
  });
  bag.on(plot.over, "mousemove", (event) => {
    if (!clock.playing && !event.buttons) clock.seek(timeAt(event));
  });
  bag.on(plot.over, "click", (event) => {
    if (Math.abs(event.clientX - pressed) > 4) return;
    clock.pause();
    clock.seek(timeAt(event));
  });
  bag.on(plot.over, "dblclick", () => group.zoom());
}

/**
 * One chart: `series` has one entry for each list of data after the times; `times` says whether the
 * time axis has its numbers; `log` means powers of ten.
 * @param {HTMLElement} host @param {ChartOptions} options @param {Frame} frame @returns {Chart}
 */
function createChart(host, options, frame) {
  const look = { times: false, log: false, height: 120, ...options };
  const now = h("div", { class: "now-line" });
  /** @type {ChartData} */
  let data = [new Float64Array(0), ...look.series.map(() => [])];
  let width = 0;
  const plot = new frame.uPlot(optionsOf(host, look, frame), data, host);
  plot.over.append(now);
  const bag = createBag();
  followMouse(bag, plot, frame);

  function follow() {
    const [from, to] = span(frame);
    const { time } = frame.clock;
    const inside = time >= from && time <= to;
    now.style.visibility = inside ? "visible" : "hidden";
    if (inside) now.style.transform = `translateX(${plot.valToPos(time, "x")}px)`;
  }
  function range() {
    plot.setData(data);
    follow();
  }
  const observer = new ResizeObserver(() => {
    if (!host.clientWidth || host.clientWidth === width) return;
    width = host.clientWidth;
    plot.setSize({ width, height: look.height });
    follow();
  });
  observer.observe(host);
  return {
    follow,
    range,
    set(next) {
      data = next;
      range();
    },
    show: (i, shown) => plot.setSeries(i + 1, { show: shown }),
    destroy() {
      observer.disconnect();
      bag.end();
      plot.destroy();
    },
  };
}
