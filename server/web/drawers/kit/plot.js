// Curves and points over any quantity: axes with round numbers, lines, dots, and one point that
// moves.
// Leaves to others: what the curves are; the clock and the zoom of curves over time (chart.js);
// paper (picture.js).
// Invariant: a colour may be one of the page's properties, so that light and dark need nothing; a
// value that is null or not finite is a gap; the curves are drawn once for what there is.

import { h, svg } from "../../dom.js";
import { figure } from "./kit.js";

/** @typedef {ArrayLike<number | null>} Values */

/**
 * A curve: a line of a width, or dots of a radius; name: the words at its right end.
 * @typedef {{xs: Values, ys: Values, colour: string, dots?: number, dash?: number[] | null, width?:
 * number, name?: string}} Curve
 */

/**
 * What is drawn. x, y: the words of the axes; from: the ends of the x axis, where curves are cut if
 * `clip` is set; low: the y axis includes this value; log: the y axis has powers of ten; degrees:
 * the axes ("x", "y", "xy") whose round numbers are parts of a turn; label: the text of a number of
 * the x axis, and whether it is the last one.
 * @typedef {{x?: string, y?: string, curves: Curve[], from?: [number, number], low?: number, log?:
 * boolean, clip?: boolean, degrees?: string, label?: (value: number, last: boolean) => string
 * }} Picture
 */

/** Where curves lie, pixels. @typedef {{x: number, y: number, wide: number, tall: number}} Box */

/**
 * Where numbers lie, pixels.
 * @typedef {{xs: [number, number], ys: [number, number], x(value: number): number, y(value:
 * number): number}} Scale
 */

const LEAST = 1e-16; // about the last digit of a double near 1
const TURNS = [15, 30, 45, 90, 180, 360, 720, 1800, 3600]; // degrees between round numbers
export const TYPE = 11.5; // pixels: the type for which widths and heights are given

/** @param {number | null} value @returns {value is number} */
const there = (value) => value !== null && Number.isFinite(value);

/** @param {string} colour */
const ink = (colour) => (colour.startsWith("--") ? `var(${colour})` : colour);

/**
 * Round numbers between two, about `many` of them, at least three.
 * @param {number} low @param {number} high @param {number} many @param {boolean} [degrees]
 * @returns {number[]}
 */
export function ticks(low, high, many, degrees = false) {
  const raw = (high - low) / many;
  const power = 10 ** Math.floor(Math.log10(raw));
  const round = power * ([1, 2, 5, 10].find((part) => part * power >= raw) ?? 10);
  const step = (degrees && raw > 10 && TURNS.find((part) => part >= raw)) || round;
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++)
    list.push(i * step);
  return list.length < 3 && many < 20 ? ticks(low, high, many + 1, degrees) : list;
}

/**
 * Powers of ten from one to another, at most seven.
 * @param {number} low @param {number} high
 */
function powers(low, high) {
  const [from, to] = [Math.round(Math.log10(low)), Math.round(Math.log10(high))];
  const step = Math.max(1, Math.ceil((to - from) / 6));
  const list = [];
  for (let power = Math.ceil(from / step) * step; power <= to; power += step)
    list.push(10 ** power);
  return list;
}

/**
 * The powers of ten around positive values, at least one decade; values below LEAST are cut off.
 * @param {Values[]} lists @returns {[number, number]}
 */
function decades(lists) {
  let [low, high] = [Infinity, 0];
  for (const list of lists) {
    for (let i = 0; i < list.length; i++) {
      const value = Number(list[i]);
      if (!(value > 0 && value < Infinity)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  const bottom = Math.floor(Math.log10(high ? Math.max(low, LEAST) : 1e-9));
  return [10 ** bottom, 10 ** Math.max(Math.ceil(Math.log10(high || 1)), bottom + 1)];
}

/**
 * Around what there is.
 * @param {Values[]} lists @param {number} room parts of it, at both ends
 * @param {(number | undefined)[]} more @returns {[number, number]}
 */
function around(lists, room, more = []) {
  let [low, high] = [Infinity, -Infinity];
  const take = (/** @type {number | null | undefined} */ value) => {
    if (!there(value ?? null)) return;
    low = Math.min(low, Number(value));
    high = Math.max(high, Number(value));
  };
  for (const list of lists) for (let i = 0; i < list.length; i++) take(list[i]);
  more.forEach(take);
  if (!Number.isFinite(low)) return [0, 1];
  const extra = low < high ? (high - low) * room : Math.abs(low) * 0.1 || 1;
  return [low - extra, high + extra];
}

/** @param {Picture} picture @param {Box} box @returns {Scale} */
function scaleOf({ curves, low, from, log }, box) {
  const listsOf = (/** @type {"xs" | "ys"} */ key) => curves.map((curve) => curve[key]);
  const xs = from ?? around(listsOf("xs"), 0.01);
  const ys = log ? decades(listsOf("ys")) : around(listsOf("ys"), 0.06, [low]);
  const high = (/** @type {number} */ value) =>
    log
      ? Math.log10(Math.max(value / ys[0], 0.1)) / Math.log10(ys[1] / ys[0])
      : (value - ys[0]) / (ys[1] - ys[0]);
  return {
    xs,
    ys,
    x: (value) => box.x + ((value - xs[0]) / (xs[1] - xs[0])) * box.wide,
    y: (value) => box.y + box.tall - high(value) * box.tall,
  };
}

/**
 * Axes with their numbers and words.
 * @param {Scale} scale @param {Picture} picture @param {Box} box @param {Text} text
 * @param {number} type pixels
 */
function axes({ xs, ys, x, y }, picture, box, text, type) {
  const middle = { "text-anchor": "middle" };
  const floor = box.y + box.tall;
  let lines = "";
  const words = [];
  const label = picture.label ?? ((/** @type {number} */ value) => figure(text, value));
  const { degrees = "" } = picture;
  const across = ticks(...xs, Math.max(3, box.wide / (5.7 * type)), degrees.includes("x"));
  across.forEach((value, i) => {
    const at = x(value).toFixed(1);
    lines += `M${at} ${box.y}V${floor}`;
    const shown = label(value || 0, i === across.length - 1);
    words.push(svg("text", { x: at, y: floor + 1.25 * type, ...middle }, shown));
  });
  const many = Math.max(2, box.tall / (2.6 * type));
  const upwards = picture.log ? powers(...ys) : ticks(...ys, many, degrees.includes("y"));
  for (const value of upwards) {
    const at = y(value).toFixed(1);
    lines += `M${box.x} ${at}h${box.wide}`;
    const place = { x: box.x - 6, y: Number(at) + 0.35 * type, "text-anchor": "end" };
    words.push(svg("text", place, figure(text, value || 0)));
  }
  const turned = `translate(${0.9 * type} ${box.y + box.tall / 2}) rotate(-90)`;
  if (picture.y) words.push(svg("text", { transform: turned, ...middle }, picture.y));
  const below = { x: box.x + box.wide / 2, y: floor + 2.8 * type, ...middle };
  if (picture.x) words.push(svg("text", below, picture.x));
  return { lines, words };
}

/** The way of a line, with gaps. @param {Curve} curve @param {Scale} scale */
function wayOf({ xs, ys }, scale) {
  let way = "";
  let drawn = false;
  for (let i = 0; i < xs.length; i++) {
    const [x, y] = [xs[i], ys[i]];
    if (there(x) && there(y)) {
      way += `${drawn ? "L" : "M"}${scale.x(x).toFixed(1)} ${scale.y(y).toFixed(1)}`;
      drawn = true;
    } else drawn = false;
  }
  return way;
}

/** @param {Curve} curve @param {Scale} scale */
function curveOf(curve, scale) {
  const { xs, ys, colour, dots, dash, width = 1.6 } = curve;
  const look = { stroke: ink(colour), fill: ink(colour) };
  if (!dots) {
    const line = { d: wayOf(curve, scale), ...look, fill: "none", "stroke-width": width };
    const join = { "stroke-dasharray": dash?.join(" ") ?? "none", "stroke-linejoin": "round" };
    return svg("path", { ...line, ...join });
  }
  // one path of all dots: thousands of measurements are one element
  let way = "";
  for (let i = 0; i < xs.length; i++) {
    const [x, y] = [xs[i], ys[i]];
    if (!there(x) || !there(y)) continue;
    const left = (scale.x(x) - dots).toFixed(1);
    // the smallest are squares: there may be thousands
    if (dots < 1) way += `M${left} ${scale.y(y).toFixed(1)}h${2 * dots}`;
    else
      way += `M${left} ${scale.y(y).toFixed(1)}a${dots} ${dots} 0 1 0 ${2 * dots} 0a${dots} ${dots} 0 1 0 ${-2 * dots} 0`;
  }
  if (dots < 1) return svg("path", { d: way, ...look, "stroke-width": 2 * dots });
  return svg("path", { d: way, ...look, stroke: "none", "fill-opacity": 0.75 });
}

/** Letters of the longest name at the end of a curve. @param {{name?: string}[]} curves */
export const longest = (curves) => Math.max(0, ...curves.map(({ name }) => name?.length ?? 0));

/**
 * How wide names of so many letters are, pixels; 0 without any.
 * @param {number} letters @param {number} type pixels
 */
export const nameWidth = (letters, type) => letters && (0.6 * letters + 0.7) * type;

/**
 * The names at the right ends of their curves, in their colours, none over another.
 * @param {Curve[]} curves @param {Scale} scale @param {Box} box @param {number} type pixels
 */
function namesAt(curves, scale, box, type) {
  const ends = curves.flatMap(({ xs, ys, name, colour }) => {
    let i = name ? xs.length - 1 : -1;
    while (i >= 0 && !(there(ys[i]) && Number(xs[i]) <= scale.xs[1])) i--;
    if (i < 0) return [];
    const at = Math.max(box.y, Math.min(scale.y(Number(ys[i])), box.y + box.tall));
    return [{ name: name ?? "", colour, at }];
  });
  ends.sort((a, b) => a.at - b.at);
  ends.forEach((end, i) => {
    if (i) end.at = Math.max(end.at, ends[i - 1].at + type);
  });
  let most = box.y + box.tall;
  for (const end of [...ends].reverse()) {
    end.at = Math.min(end.at, most);
    most = end.at - type;
  }
  const x = box.x + box.wide + 0.4 * type;
  return ends.map(({ name, colour, at }) =>
    svg("text", { x, y: (at + 0.35 * type).toFixed(1), fill: ink(colour) }, name),
  );
}

/**
 * A picture in a box, and where numbers lie in it.
 * @param {Picture} picture @param {Box} box @param {Text} text @param {number} type of its words,
 * pixels @param {string} line @param {string} quiet colours of the axes' lines and words
 */
export function drawn(picture, box, text, type = TYPE, line = "--line", quiet = "--quiet") {
  const scale = scaleOf(picture, box);
  const { lines, words } = axes(scale, picture, box, text, type);
  const named = svg("g", { fill: ink(quiet), "font-size": type }, ...words);
  const ends = namesAt(picture.curves, scale, box, type);
  const names = svg("g", { "font-size": type, "font-weight": 600, class: "curve-names" }, ...ends);
  const curves = picture.curves.map((curve) => curveOf(curve, scale));
  const { x, y, wide: width, tall: height } = box;
  const frame = { x, y, width, height, viewBox: `${x} ${y} ${width} ${height}` };
  const inside = picture.clip ? [svg("svg", frame, ...curves)] : curves;
  const grid = svg("path", { d: lines, stroke: ink(line) });
  return { scale, parts: [grid, named, ...inside, names] };
}

/** The size of the type of a place, pixels. @param {HTMLElement} element */
export const typeOf = (element) => parseFloat(getComputedStyle(element).fontSize) || TYPE;

/**
 * The plot while it is there.
 * @typedef {{element: HTMLElement, point: HTMLElement, text: Text, picture: Picture | null,
 * scale: Scale | null}} Plot
 */

/** @param {Plot} plot */
function draw(plot) {
  const { element, point, text, picture } = plot;
  const [width, height] = [element.clientWidth, element.clientHeight];
  if (!width || !picture) return;
  const type = typeOf(element);
  const right = 0.9 * type + nameWidth(longest(picture.curves), type);
  const tall = height - (picture.x ? 3.8 : 2.6) * type;
  const box = { x: 4.5 * type, y: 0.7 * type, wide: width - 4.5 * type - right, tall };
  const { scale, parts } = drawn(picture, box, text, type);
  const size = { width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" };
  plot.scale = scale;
  element.replaceChildren(svg("svg", size, ...parts), point);
}

/** A plot of so many pixels at the usual type. @param {Text} text @param {number} height */
export function createPlot(text, height) {
  const element = h("div", { class: "plot", role: "img" });
  const point = h("div", { class: "plot-point", hidden: true });
  /** @type {Plot} */
  const plot = { element, point, text, picture: null, scale: null };
  element.style.height = `${height / TYPE}em`;
  const observer = new ResizeObserver(() => draw(plot));
  observer.observe(element);
  return {
    element,
    /** @param {Picture} picture @param {string} label */
    set(picture, label) {
      plot.picture = picture;
      element.setAttribute("aria-label", label);
      draw(plot);
    },
    /** Moves the point. @param {number} x @param {number} y */
    mark(x, y) {
      point.hidden = !plot.scale;
      if (plot.scale)
        point.style.transform = `translate(${plot.scale.x(x)}px, ${plot.scale.y(y)}px)`;
    },
    /** What measures how many pixels a point is from a pointer. @param {MouseEvent} event */
    far({ clientX, clientY }) {
      const { scale } = plot;
      const { left, top } = element.getBoundingClientRect();
      return (/** @type {number} */ x, /** @type {number} */ y) =>
        scale ? Math.hypot(clientX - left - scale.x(x), clientY - top - scale.y(y)) : Infinity;
    },
    /** Where a pointer is on the axis across. @param {MouseEvent} event */
    at({ clientX }) {
      if (!plot.scale) return NaN;
      const { xs, x } = plot.scale;
      const { left } = element.getBoundingClientRect();
      return xs[0] + ((clientX - left - x(xs[0])) / (x(xs[1]) - x(xs[0]))) * (xs[1] - xs[0]);
    },
    destroy: () => observer.disconnect(),
  };
}

/** @typedef {ReturnType<typeof createPlot>} PlotPart */

/**
 * The sample of a curve nearest to a pointer, -1 without one.
 * @param {(x: number, y: number) => number} far @param {ArrayLike<number>} xs
 * @param {ArrayLike<number>} ys
 */
export function nearest(far, xs, ys) {
  let [found, least] = [-1, Infinity];
  for (let i = 0; i < xs.length; i++) {
    const away = far(xs[i], ys[i]);
    if (away < least) [found, least] = [i, away];
  }
  return found;
}
