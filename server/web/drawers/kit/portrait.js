// The phase portrait of one arm: angular velocity over angle, up to now, and the point where it is
// now.
// Leaves to others: which arm, the samples.
// Invariant: the path is drawn once for what there is; following the clock moves a point only.

import { h } from "../../dom.js";
import { cssValue, figure } from "./kit.js";
import { ticks } from "./picture.js";

const LEFT = 58;
const BOTTOM = 24;

/** @typedef {[number, number]} Limits */

/**
 * Where numbers lie on the canvas.
 * @typedef {{xs: Limits, ys: Limits, width: number, height: number, x(value: number): number,
 * y(value: number): number}} Scale
 */

/**
 * @typedef {{element: HTMLElement, set(xs: ArrayLike<number>, ys: ArrayLike<number>, colour:
 * string, label: string): void, at(x: number, y: number): void, find(event: PointerEvent): number,
 * destroy(): void}} Portrait
 */

/** Around what there is. @param {ArrayLike<number>} list @returns {Limits} */
function limits(list) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < list.length; i++) {
    if (list[i] < low) low = list[i];
    if (list[i] > high) high = list[i];
  }
  const middle = Number.isFinite(low) ? low : 0;
  if (!(low < high)) return [middle - 1, middle + 1];
  const room = (high - low) * 0.06;
  return [low - room, high + room];
}

/**
 * @param {Limits} xs @param {Limits} ys @param {number} width @param {number} height @returns
 * {Scale}
 */
function scaleOf(xs, ys, width, height) {
  return {
    xs,
    ys,
    width,
    height,
    x: (value) => LEFT + ((value - xs[0]) / (xs[1] - xs[0])) * (width - LEFT - 8),
    y: (value) => height - BOTTOM - ((value - ys[0]) / (ys[1] - ys[0])) * (height - BOTTOM - 6),
  };
}

/** @param {CanvasRenderingContext2D} context @param {Text} text @param {Scale} scale */
function grid(context, text, scale) {
  const { xs, ys, width, height } = scale;
  context.font = "11px system-ui, sans-serif";
  context.strokeStyle = cssValue("--line");
  context.fillStyle = cssValue("--quiet");
  context.lineWidth = 1;
  context.beginPath();
  context.textAlign = "center";
  for (const x of ticks(...xs, 6)) {
    context.moveTo(scale.x(x), 6);
    context.lineTo(scale.x(x), height - BOTTOM);
    context.fillText(figure(text, x), scale.x(x), height - 8);
  }
  context.textAlign = "right";
  for (const y of ticks(...ys, 5)) {
    context.moveTo(LEFT, scale.y(y));
    context.lineTo(width - 8, scale.y(y));
    context.fillText(figure(text, y), LEFT - 8, scale.y(y) + 4);
  }
  context.stroke();
}

/**
 * Makes the canvas as fine as its place.
 * @param {HTMLCanvasElement} canvas @param {number} width @param {number} height
 */
function prepare(canvas, width, height) {
  const ratio = Math.min(devicePixelRatio, 2);
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  canvas.getContext("2d")?.setTransform(ratio, 0, 0, ratio, 0, 0);
}

/** @param {Text} text @param {number} height pixels @returns {Portrait} */
export function createPortrait(text, height = 220) {
  const canvas = h("canvas", { role: "img" });
  const point = h("div", { class: "portrait-point" });
  const element = h("div", { class: "portrait" }, canvas, point);
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  /** @type {{xs: ArrayLike<number>, ys: ArrayLike<number>, colour: string}} */
  let data = { xs: [], ys: [], colour: "#000" };
  /** @type {Scale | null} */
  let scale = null;

  function draw() {
    const width = element.clientWidth;
    if (!width) return;
    prepare(canvas, width, height);
    const { xs, ys, colour } = data;
    scale = scaleOf(limits(xs), limits(ys), width, height);
    grid(context, text, scale);
    context.beginPath();
    for (let i = 0; i < xs.length; i++) context.lineTo(scale.x(xs[i]), scale.y(ys[i]));
    context.strokeStyle = colour;
    context.lineWidth = 1.2;
    context.lineJoin = "round";
    context.stroke();
  }

  const observer = new ResizeObserver(draw);
  observer.observe(element);
  return {
    element,
    set(xs, ys, colour, label) {
      data = { xs, ys, colour };
      canvas.setAttribute("aria-label", label);
      draw();
    },
    at(x, y) {
      if (scale) point.style.transform = `translate(${scale.x(x)}px, ${scale.y(y)}px)`;
    },
    /** The sample nearest to a pointer, -1 without one. */
    find(event) {
      const { left, top } = canvas.getBoundingClientRect();
      let [nearest, least] = [-1, Infinity];
      for (let i = 0; scale && i < data.xs.length; i++) {
        const dx = scale.x(data.xs[i]) - (event.clientX - left);
        const far = dx ** 2 + (scale.y(data.ys[i]) - (event.clientY - top)) ** 2;
        if (far < least) [nearest, least] = [i, far];
      }
      return nearest;
    },
    destroy: () => observer.disconnect(),
  };
}
