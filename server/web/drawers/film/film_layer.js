// The film over the stage while it is marked: its picture, the marks in it, a cross that pointers
// and keys move, a glass around it.
// Leaves to others: what a mark does (film.js), the pictures (film_frames.js).
// Invariant: what is marked is where the cross is, to a part of a pixel of the film; all that
// pointers do keys do too.

import { createBag, h, iconButton } from "../../dom.js";
import { armLook, button, cssValue } from "../kit/kit.js";
import { tipAt } from "./film_marks.js";

const FAR = 10; // steps of the cross with shift
const GLASS = 54; // pixels: half of the glass
const ZOOM = 5; // of the glass, to the picture on the stage
const EDGE = 10; // pixels around the picture

/** @type {Record<string, number[]>} */
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Colours of what is marked once. @type {Record<string, string>} */
const FIXED = { one: "--arm-4", two: "--arm-4", pivot: "--arm-2", below: "--arm-5" };

/**
 * What the layer asks and tells: `place` a mark at a spot, `step` a picture, `remove` the mark that
 * is chosen, `done`.
 * @typedef {{place(spot: number[]): void, step(way: 1 | -1): void, remove(): void, done(): void}}
 * Hooks
 */

/**
 * The layer while it is there. cross: pixels of the film; fit: where the picture lies on the stage.
 * @typedef {{
 *   canvas: HTMLCanvasElement, film: import("./film_frames.js").Film, marks:
 *   import("./film_marks.js").Marks, cross: number[], near: boolean, fit: {x: number, y: number,
 *   scale: number},
 * }} Layer
 */

/** Where the picture lies. @param {Layer} layer */
function fit(layer) {
  const { canvas, film } = layer;
  const { clientWidth: wide, clientHeight: tall } = canvas;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(wide * ratio);
  canvas.height = Math.round(tall * ratio);
  const free = (/** @type {number} */ side) => Math.max(1, side - 2 * EDGE);
  const scale = Math.min(free(wide) / film.width, free(tall) / film.height);
  const [x, y] = [(wide - scale * film.width) / 2, (tall - scale * film.height) / 2];
  layer.fit = { x, y, scale };
}

/** On the stage. @param {Layer} layer @param {number[]} spot */
const seenAt = ({ fit: { x, y, scale } }, spot) => [x + scale * spot[0], y + scale * spot[1]];

/**
 * A ring or a dot that is seen on every picture.
 * @param {CanvasRenderingContext2D} context @param {number[]} at @param {number} radius
 * @param {string} colour @param {boolean} full
 */
function ring(context, [x, y], radius, colour, full) {
  for (const [width, stroke] of /** @type {[number, string][]} */ ([
    [4, "#fff"],
    [2, colour],
  ])) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.lineWidth = width;
    context.strokeStyle = stroke;
    context.stroke();
  }
  context.fillStyle = colour;
  if (full) context.fill();
}

/** Two strokes that cross. @param {CanvasRenderingContext2D} context @param {number[]} at
 * @param {number} long */
function crossing(context, [x, y], long) {
  for (const [width, stroke] of /** @type {[number, string][]} */ ([
    [3, "#fff"],
    [1, "#000"],
  ])) {
    context.beginPath();
    context.moveTo(x - long, y);
    context.lineTo(x + long, y);
    context.moveTo(x, y - long);
    context.lineTo(x, y + long);
    context.lineWidth = width;
    context.strokeStyle = stroke;
    context.stroke();
  }
}

/** The scale, the pivot, what hangs below it. @param {Layer} layer
 * @param {CanvasRenderingContext2D} context */
function drawFixed(layer, context) {
  const { fixed } = layer.marks;
  const line = (
    /** @type {number[] | undefined} */ from,
    /** @type {number[] | undefined} */ to,
  ) => {
    if (!from || !to) return;
    context.beginPath();
    context.moveTo(...pair(seenAt(layer, from)));
    context.lineTo(...pair(seenAt(layer, to)));
    context.lineWidth = 1.5;
    context.stroke();
  };
  context.strokeStyle = cssValue(FIXED.one);
  line(fixed.one, fixed.two);
  context.strokeStyle = cssValue(FIXED.below);
  line(fixed.pivot, fixed.below);
  for (const [name, spot] of Object.entries(fixed))
    ring(context, seenAt(layer, spot), 5, cssValue(FIXED[name]), name === "pivot");
}

/** @param {number[]} list @returns {[number, number]} */
const pair = ([x, y]) => [x, y];

/** The tips: of all pictures small, of this one large. @param {Layer} layer
 * @param {CanvasRenderingContext2D} context */
function drawTips(layer, context) {
  const { marks, film } = layer;
  for (const [arm, rows] of Object.entries(marks.tips)) {
    const { colour } = armLook(Number(arm));
    context.fillStyle = colour;
    for (const [, across, down] of rows) {
      const [x, y] = seenAt(layer, [across, down]);
      context.fillRect(x - 1, y - 1, 2, 2);
    }
    const now = tipAt(marks, Number(arm), film.time);
    if (now) ring(context, seenAt(layer, now.slice(1)), 7, colour, false);
  }
}

/** The picture around the cross, larger, in the corner that is further. @param {Layer} layer
 * @param {CanvasRenderingContext2D} context */
function drawGlass(layer, context) {
  const { canvas, film, cross, fit: shown } = layer;
  const [at] = seenAt(layer, cross);
  const x = at < canvas.clientWidth / 2 ? canvas.clientWidth - GLASS - EDGE : GLASS + EDGE;
  const y = GLASS + EDGE;
  const half = GLASS / (ZOOM * shown.scale);
  context.save();
  context.beginPath();
  context.arc(x, y, GLASS, 0, 2 * Math.PI);
  context.fillStyle = "#000";
  context.fill();
  context.clip();
  const [left, top] = [cross[0] - half, cross[1] - half];
  const wide = 2 * GLASS;
  context.drawImage(film.video, left, top, 2 * half, 2 * half, x - GLASS, y - GLASS, wide, wide);
  crossing(context, [x, y], 12);
  context.restore();
  ring(context, [x, y], GLASS, "#000", false);
}

/** @param {Layer} layer */
function draw(layer) {
  const { canvas, film, near } = layer;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const ratio = canvas.width / Math.max(1, canvas.clientWidth);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  const { x, y, scale } = layer.fit;
  context.drawImage(film.video, x, y, scale * film.width, scale * film.height);
  drawFixed(layer, context);
  drawTips(layer, context);
  if (!near) return;
  crossing(context, seenAt(layer, layer.cross), 14);
  drawGlass(layer, context);
}

/** Moves the cross, inside of the picture. @param {Layer} layer @param {number[]} spot */
function moveTo(layer, [across, down]) {
  const { film } = layer;
  layer.cross = [
    Math.min(Math.max(across, 0), film.width),
    Math.min(Math.max(down, 0), film.height),
  ];
  layer.near = true;
  draw(layer);
}

/** @param {Layer} layer @param {Hooks} hooks @param {KeyboardEvent} event */
function key(layer, hooks, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const move = MOVES[event.key];
  const { cross } = layer;
  const far = (event.shiftKey ? FAR : 1) / Math.min(1, layer.fit.scale);
  /** @type {Record<string, () => void>} */
  const acts = {
    Enter: () => hooks.place(cross),
    " ": () => hooks.place(cross),
    PageDown: () => hooks.step(1),
    ".": () => hooks.step(1),
    PageUp: () => hooks.step(-1),
    ",": () => hooks.step(-1),
    Delete: hooks.remove,
    Backspace: hooks.remove,
    Escape: hooks.done,
  };
  const act = move
    ? () => moveTo(layer, [cross[0] + far * move[0], cross[1] + far * move[1]])
    : acts[event.key];
  if (!act) return;
  event.preventDefault();
  event.stopPropagation();
  act();
}

/** @param {Layer} layer @param {PointerEvent} event */
function spotOf({ canvas, fit: { x, y, scale } }, event) {
  const place = canvas.getBoundingClientRect();
  return [(event.clientX - place.left - x) / scale, (event.clientY - place.top - y) / scale];
}

/** @param {Layer} layer @param {Hooks} hooks @param {Bag} bag */
function hands(layer, hooks, bag) {
  const { canvas } = layer;
  let pressed = false;
  bag.on(canvas, "pointerdown", (event) => {
    if (!event.isPrimary || event.button !== 0) return;
    pressed = true;
    canvas.setPointerCapture(event.pointerId);
    moveTo(layer, spotOf(layer, event));
  });
  bag.on(canvas, "pointermove", (event) => {
    if (pressed || event.pointerType === "mouse") moveTo(layer, spotOf(layer, event));
  });
  bag.on(canvas, "pointerup", (event) => {
    if (!pressed) return;
    pressed = false;
    moveTo(layer, spotOf(layer, event));
    hooks.place(layer.cross);
  });
  bag.on(canvas, "pointercancel", () => (pressed = false));
  bag.on(canvas, "keydown", (event) => key(layer, hooks, event));
  bag.on(canvas, "focus", () => moveTo(layer, layer.cross));
}

/**
 * Lays the film over the stage: {draw, focus, destroy}; what else is on the stage waits. tools:
 * what stands below the picture.
 * @param {Text} text @param {import("./film_frames.js").Film} film
 * @param {import("./film_marks.js").Marks} marks @param {Hooks} hooks
 * @param {HTMLElement[]} tools
 */
export function createLayer(text, film, marks, hooks, tools) {
  const bag = createBag();
  const label = { "aria-label": text("film.picture"), "aria-roledescription": text("film.roles") };
  const canvas = h("canvas", { class: "film-canvas", tabindex: 0, role: "application", ...label });
  const back = iconButton("back", text("film.back"), () => hooks.step(-1), { "data-film": "back" });
  const on = iconButton("forward", text("film.on"), () => hooks.step(1), { "data-film": "on" });
  const done = button(text("film.done"), hooks.done, { "data-film": "done" });
  const bar = h("div", { class: "film-tools", role: "group" }, back, on, ...tools, done);
  bar.setAttribute("aria-label", text("film.tools"));
  const element = h("div", { class: "film-layer" }, canvas, bar);
  const cross = [film.width / 2, film.height / 2];
  /** @type {Layer} */
  const layer = { canvas, film, marks, cross, near: false, fit: { x: 0, y: 0, scale: 1 } };
  const stage = document.getElementById("stage");
  const others = [...(stage?.children ?? [])].filter((one) => !one.hasAttribute("inert"));
  for (const one of others) one.setAttribute("inert", "");
  stage?.append(element);
  const again = () => {
    fit(layer);
    draw(layer);
  };
  const observer = new ResizeObserver(again);
  observer.observe(canvas);
  bag(() => observer.disconnect());
  bag(() => others.forEach((one) => one.removeAttribute("inert")));
  hands(layer, hooks, bag);
  again();
  return {
    draw: () => draw(layer),
    focus: () => canvas.focus(),
    /** Where a spot is on the page's stage, pixels. @param {number[]} spot */
    seenAt: (spot) => seenAt(layer, spot),
    destroy() {
      bag.end();
      element.remove();
    },
  };
}
