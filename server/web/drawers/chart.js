// Curves over time: uPlot in the page's colours, charts of a group sharing one time axis, one zoom and the clock.
// Leaves to others: what the curves are.
// Invariant: hovering a chart while the clock stands sets the clock; a click does so always; nothing else is changed.

import { createBag, h } from "../dom.js";
import { script, style } from "../files.js";
import { cssValue, figure } from "./kit.js";

let uPlot = null; // comes with the first group

const AXIS = 58;
const LEAST = 1e-16;

/** Charts that share time: {add(host, options), zoom(from, to), span(), follow(), destroy()}. */
export async function createGroup({ clock, text, key }) {
  [{ default: uPlot }] = await Promise.all([script("lib/uplot.js"), style("lib/uplot.css")]);
  const charts = new Set();
  const bag = createBag();
  let zoomed = null; // [from, to], null: all of it

  const group = {
    get zoomed() {
      return zoomed;
    },
    /** What is to be seen of the time axis; without arguments all of it. */
    zoom(from = null, to = null) {
      zoomed = from === null ? null : [from, to];
      for (const chart of charts) chart.range();
    },
    /** By a factor about the clock, or about the middle where the clock is not to be seen. */
    magnify(factor) {
      const [from, to] = zoomed ?? [0, clock.duration];
      const about = clock.time >= from && clock.time <= to ? clock.time : (from + to) / 2;
      const left = Math.max(0, about - (about - from) * factor);
      const right = Math.min(clock.duration, about + (to - about) * factor);
      if (left <= 0 && right >= clock.duration) group.zoom();
      else group.zoom(left, right);
    },
    add(host, options) {
      const chart = createChart(host, { ...options, group, clock, text, key });
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

/** Powers of ten between two, not more than a few. */
function powers(low, high) {
  const from = Math.round(Math.log10(low));
  const to = Math.round(Math.log10(high));
  const step = Math.max(1, Math.ceil((to - from) / 6));
  const list = [];
  for (let power = Math.ceil(from / step) * step; power <= to; power += step)
    list.push(10 ** power);
  return list;
}

function axes({ text, times, log }) {
  const ink = cssValue("--quiet");
  const line = cssValue("--line");
  const font = "11px system-ui, sans-serif";
  const common = {
    stroke: ink,
    font,
    ticks: { stroke: line, width: 1, size: 4 },
    grid: { stroke: line, width: 1 },
  };
  const time = {
    ...common,
    show: true,
    size: times ? 26 : 6,
    space: 60,
    values: (_, ticks) => ticks.map((tick) => (times ? text.short(tick) : "")),
  };
  const value = {
    ...common,
    size: AXIS,
    space: log ? 22 : 30,
    values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : figure(text, tick))),
  };
  if (log)
    Object.assign(value, {
      splits: (_, axis, low, high) => powers(low, high),
      filter: (_, ticks) => ticks,
    });
  return [time, value];
}

/** Powers of ten around what there is, so that few values make an axis too; what is below the last digit of a double is cut off. */
function logRange(_, low, high) {
  const from = Number.isFinite(low) && low > 0 ? Math.max(low, LEAST) : 1e-9;
  const to = Number.isFinite(high) && high > 0 ? high : 1;
  return [
    10 ** Math.floor(Math.log10(from)),
    10 ** Math.max(Math.ceil(Math.log10(to)), Math.floor(Math.log10(from)) + 1),
  ];
}

/** Around what there is; what is as good as constant gets room, so that it is a line and no frame. */
function plainRange(_, low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [-1, 1];
  const room = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
  return [low - room, high + room];
}

/**
 * {set(data), show(i, shown), range(), follow(), destroy()}
 *
 * series  [{colour, dash, width, shown}], one for each list of data after the times.
 * times   whether the time axis has its numbers.
 * log     powers of ten.
 */
function createChart(
  host,
  { series, times = false, log = false, height = 120, group, clock, text, key },
) {
  const now = h("div", { class: "now-line" });
  let data = [new Float64Array(0), ...series.map(() => [])];
  let width = 0;
  const ratio = Math.max(1, Math.min(devicePixelRatio, 2));

  const plot = new uPlot(
    {
      width: Math.max(host.clientWidth, 120),
      height,
      pxAlign: 0,
      padding: [8, 8, 0, 0],
      legend: { show: false },
      cursor: {
        y: false,
        points: { show: false },
        sync: { key, scales: ["x", null] },
        drag: { x: true, y: false, setScale: false },
      },
      scales: {
        x: { time: false, auto: false, range: () => group.zoomed ?? [0, clock.duration || 1] },
        y: log ? { distr: 3, range: logRange } : { range: plainRange },
      },
      axes: axes({ text, times, log }),
      series: [
        {},
        ...series.map((one) => ({
          stroke: one.colour,
          width: one.width ?? 1.4,
          dash: one.dash?.map((part) => part * ratio),
          show: one.shown ?? true,
          points: { show: false },
          spanGaps: false,
        })),
      ],
      hooks: { setSelect: [chosen] },
    },
    data,
    host,
  );
  plot.over.append(now);

  function chosen(plotted) {
    const { left, width: wide } = plotted.select;
    if (wide < 5) return;
    group.zoom(plotted.posToVal(left, "x"), plotted.posToVal(left + wide, "x"));
    plotted.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  const timeAt = (event) =>
    plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
  const bag = createBag();
  let pressed = 0;
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

  const chart = {
    set(next) {
      data = next;
      plot.setData(data);
      chart.follow();
    },
    show(i, shown) {
      plot.setSeries(i + 1, { show: shown });
    },
    range() {
      plot.setData(data);
      chart.follow();
    },
    follow() {
      const [from, to] = group.zoomed ?? [0, clock.duration || 1];
      const inside = clock.time >= from && clock.time <= to;
      now.style.visibility = inside ? "visible" : "hidden";
      if (inside) now.style.transform = `translateX(${plot.valToPos(clock.time, "x")}px)`;
    },
    destroy() {
      observer.disconnect();
      bag.end();
      plot.destroy();
    },
  };

  const observer = new ResizeObserver(() => {
    if (!host.clientWidth || host.clientWidth === width) return;
    width = host.clientWidth;
    plot.setSize({ width, height });
    chart.follow();
  });
  observer.observe(host);
  return chart;
}
