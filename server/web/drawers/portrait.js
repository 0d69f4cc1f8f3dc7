// The phase portrait of one arm: angular velocity over angle, up to now, and the point where it is now.
// Leaves to others: which arm, the samples.
// Invariant: the path is drawn once for what there is; following the clock moves a point only.

import { h } from "../dom.js";
import { cssValue, figure } from "./kit.js";
import { ticks } from "./picture.js";

const LEFT = 58;
const BOTTOM = 24;

/** {element, set(xs, ys, label), at(x, y)} */
export function createPortrait(text, height = 220) {
  const canvas = h("canvas", { role: "img" });
  const point = h("div", { class: "portrait-point" });
  const element = h("div", { class: "portrait" }, canvas, point);
  const context = canvas.getContext("2d");
  let data = { xs: [], ys: [], colour: "#000" };
  let scale = null;

  function limits(list) {
    let low = Infinity;
    let high = -Infinity;
    for (const value of list) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (!(low < high))
      return [(Number.isFinite(low) ? low : 0) - 1, (Number.isFinite(low) ? low : 0) + 1];
    const room = (high - low) * 0.06;
    return [low - room, high + room];
  }

  function grid(width, [x0, x1], [y0, y1]) {
    context.font = "11px system-ui, sans-serif";
    context.strokeStyle = cssValue("--line");
    context.fillStyle = cssValue("--quiet");
    context.lineWidth = 1;
    context.beginPath();
    context.textAlign = "center";
    for (const x of ticks(x0, x1, 6)) {
      context.moveTo(scale.x(x), 6);
      context.lineTo(scale.x(x), height - BOTTOM);
      context.fillText(figure(text, x), scale.x(x), height - 8);
    }
    context.textAlign = "right";
    for (const y of ticks(y0, y1, 5)) {
      context.moveTo(LEFT, scale.y(y));
      context.lineTo(width - 8, scale.y(y));
      context.fillText(figure(text, y), LEFT - 8, scale.y(y) + 4);
    }
    context.stroke();
  }

  function draw() {
    const width = element.clientWidth;
    if (!width) return;
    const ratio = Math.min(devicePixelRatio, 2);
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    const xs = limits(data.xs);
    const ys = limits(data.ys);
    scale = {
      x: (x) => LEFT + ((x - xs[0]) / (xs[1] - xs[0])) * (width - LEFT - 8),
      y: (y) => height - BOTTOM - ((y - ys[0]) / (ys[1] - ys[0])) * (height - BOTTOM - 6),
    };
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    grid(width, xs, ys);
    context.beginPath();
    for (let i = 0; i < data.xs.length; i++)
      context.lineTo(scale.x(data.xs[i]), scale.y(data.ys[i]));
    context.strokeStyle = data.colour;
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
    destroy: () => observer.disconnect(),
  };
}
