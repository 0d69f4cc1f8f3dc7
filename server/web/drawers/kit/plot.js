// Curves and points over any quantity: axes with round numbers, lines, dots.
// Leaves to others: what the curves are; curves over time, which follow the clock (chart.js).
// Invariant: colours are the page's properties, so that light and dark need nothing; a value that
// is null or not finite is a gap.

import { h } from "../../dom.js";
import { figure } from "./kit.js";
import { ticks } from "./picture.js";

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 52;
const BOTTOM = 36;
const TOP = 8;
const RIGHT = 10;

/** @typedef {ArrayLike<number | null>} Values */

/**
 * A curve: a line, or dots of a radius; colour is a custom property.
 * @typedef {{xs: Values, ys: Values, colour: string, dots?: number, dashed?: boolean}} Curve
 */

/**
 * What is drawn. x, y: the words of the axes; low: what the y axis holds at least.
 * @typedef {{x: string, y: string, curves: Curve[], low?: number}} Picture
 */

/**
 * Where numbers lie, pixels.
 * @typedef {{xs: [number, number], ys: [number, number], width: number, height: number, x(value:
 * number): number, y(value: number): number}} Scale
 */

/**
 * @param {string} name @param {Record<string, string | number>} attributes
 * @param {string} words
 */
function svg(name, attributes, words = "") {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = words;
  return element;
}

/** @param {number | null} value @returns {value is number} */
const there = (value) => value !== null && Number.isFinite(value);

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

/** @param {Picture} picture @param {number} width @param {number} height @returns {Scale} */
function scaleOf({ curves, low }, width, height) {
  const xs = around(
    curves.map((curve) => curve.xs),
    0.01,
  );
  const ys = around(
    curves.map((curve) => curve.ys),
    0.06,
    [low],
  );
  const [wide, tall] = [width - LEFT - RIGHT, height - BOTTOM - TOP];
  return {
    xs,
    ys,
    width,
    height,
    x: (value) => LEFT + ((value - xs[0]) / (xs[1] - xs[0])) * wide,
    y: (value) => TOP + tall - ((value - ys[0]) / (ys[1] - ys[0])) * tall,
  };
}

/** Axes with their numbers and words. @param {Scale} scale @param {Picture} picture
 * @param {Text} text */
function frame(scale, { x: across, y: up }, text) {
  const { xs, ys, width, height } = scale;
  const floor = height - BOTTOM;
  const parts = [];
  for (const value of ticks(...xs, Math.max(3, width / 80))) {
    const at = scale.x(value).toFixed(1);
    parts.push(svg("path", { d: `M${at} ${TOP}V${floor}`, class: "plot-line" }));
    parts.push(
      svg("text", { x: at, y: floor + 14, "text-anchor": "middle" }, figure(text, value || 0)),
    );
  }
  for (const value of ticks(...ys, Math.max(2, height / 45))) {
    const at = scale.y(value).toFixed(1);
    parts.push(svg("path", { d: `M${LEFT} ${at}H${width - RIGHT}`, class: "plot-line" }));
    const place = { x: LEFT - 6, y: Number(at) + 4, "text-anchor": "end" };
    parts.push(svg("text", place, figure(text, value || 0)));
  }
  const middle = (TOP + floor) / 2;
  const turned = { x: 0, y: 0, transform: `translate(10 ${middle}) rotate(-90)` };
  parts.push(svg("text", { ...turned, "text-anchor": "middle" }, up));
  const below = { x: (LEFT + width - RIGHT) / 2, y: height - 4, "text-anchor": "middle" };
  parts.push(svg("text", below, across));
  return parts;
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
  const { xs, ys, colour, dots, dashed } = curve;
  const look = { stroke: `var(${colour})`, fill: `var(${colour})` };
  if (!dots) {
    const line = { d: wayOf(curve, scale), ...look, fill: "none", "stroke-width": 1.6 };
    const dash = { "stroke-dasharray": dashed ? "5 4" : "none" };
    return svg("path", { ...line, ...dash, "stroke-linejoin": "round" });
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

/**
 * The plot while it is there.
 * @typedef {{element: HTMLElement, text: Text, height: number, picture: Picture | null}} Plot
 */

/** @param {Plot} plot */
function draw({ element, text, height, picture }) {
  const width = element.clientWidth;
  if (!width || !picture) return;
  const scale = scaleOf(picture, width, height);
  const size = { width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" };
  const paper = svg("svg", size);
  const curves = picture.curves.map((curve) => curveOf(curve, scale));
  paper.append(...frame(scale, picture, text), ...curves);
  element.replaceChildren(paper);
}

/**
 * A plot: {element, set(picture, label), far(event)(x, y), at(event), destroy}.
 * @param {Text} text @param {number} height pixels
 */
export function createPlot(text, height) {
  const element = h("div", { class: "plot", role: "img" });
  /** @type {Plot} */
  const plot = { element, text, height, picture: null };
  element.style.height = `${height}px`;
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
    /** What measures how many pixels a point is from a pointer: all points are looked at once
     * for the scale, not once for each. @param {{clientX: number, clientY: number}} event
     * @returns {(x: number, y: number) => number} */
    far({ clientX, clientY }) {
      if (!plot.picture) return () => Infinity;
      const { left, top, width, height: tall } = element.getBoundingClientRect();
      const scale = scaleOf(plot.picture, width, tall);
      return (x, y) => Math.hypot(clientX - left - scale.x(x), clientY - top - scale.y(y));
    },
    /** Where a pointer is on the axis across. @param {{clientX: number}} event */
    at({ clientX }) {
      if (!plot.picture) return NaN;
      const { left, width, height: tall } = element.getBoundingClientRect();
      const { xs, x } = scaleOf(plot.picture, width, tall);
      return xs[0] + ((clientX - left - x(xs[0])) / (x(xs[1]) - x(xs[0]))) * (xs[1] - xs[0]);
    },
    destroy: () => observer.disconnect(),
  };
}
