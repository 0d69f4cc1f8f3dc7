// The ruler and the protractor on the stage: their handles, dragged or moved by keys, and what they
// read. Loaded when one of them is wanted (view.ruler, view.protractor).
// Leaves to others: their numbers (gauge_numbers.js), strokes (paint_gauges.js), fields and the
// switches (gauge_fields.js).
// Invariant: a handle stays on the stage, so that it can be taken; what is read is in the scene.

import { createBag, h } from "../../dom.js";
import { laid, leg, legEnd, meant, roundStep } from "./gauge_numbers.js";
import { readings, shownIn } from "./gauge_words.js";
import { LEG, paintProtractor, paintRuler, pixelOf } from "./paint_gauges.js";

const STEP = 4; // pixels that an arrow moves an end by, about
const TURN = 1; // degrees that it turns a leg by
const FINE = 0.1; // of that, with shift
// pixels of the stage's edge where handles stop, which are larger for fingers
const MARGIN = matchMedia("(pointer: coarse)").matches ? 23 : 14;

/** @typedef {import("./gauge_numbers.js").Gauge} Gauge */

/**
 * Which numbers of a gauge a handle moves: a place (two of them), or the direction of a leg.
 * @typedef {{gauge: Gauge, name: string, first: number, turns: boolean}} Handle
 */

/**
 * A handle in a hand, and the numbers from before.
 * @typedef {{handle: Handle, id: number, before: number[]}} Held
 */

/** @type {Handle[]} */
const HANDLES = [
  { gauge: "ruler", name: "a", first: 0, turns: false },
  { gauge: "ruler", name: "b", first: 2, turns: false },
  { gauge: "protractor", name: "corner", first: 0, turns: false },
  { gauge: "protractor", name: "from", first: 2, turns: true },
  { gauge: "protractor", name: "to", first: 3, turns: true },
];

/** @type {Record<string, [number, number]>} */
const ARROWS = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/**
 * @typedef {{app: App, element: HTMLElement, look: Look, canvas: HTMLCanvasElement, handles:
 * Map<Handle, HTMLButtonElement>, held: Held | null}} Bench
 */

/**
 * Its numbers with some of them changed.
 * @param {number[]} list @param {number} first @param {number[]} values
 */
const changed = (list, first, values) =>
  list.map((old, i) => (i >= first && i < first + values.length ? values[i - first] : old));

/** @param {Bench} bench @param {Gauge} gauge @param {number[]} numbers */
function set({ app }, gauge, numbers) {
  app.store.set({ view: { [gauge]: numbers } });
}

/**
 * Where a handle is, metres.
 * @param {Bench} bench @param {Handle} handle @param {number[]} numbers
 */
function placeOf({ look }, { first, turns }, numbers) {
  if (!turns) return [numbers[first], numbers[first + 1]];
  return legEnd(numbers, numbers[first], LEG / look.camera.scale);
}

/** A gauge that is wanted and lies nowhere yet is laid down. @param {Bench} bench */
function lay(bench) {
  const { view } = bench.app.store.get();
  for (const gauge of /** @type {Gauge[]} */ (["ruler", "protractor"]))
    if (view[gauge]?.length === 0) set(bench, gauge, laid(gauge, bench.app.stage.seen()));
}

/** Handles are buttons while their gauge is there. @param {Bench} bench */
function fill(bench) {
  const { app, element, handles } = bench;
  const { view } = app.store.get();
  for (const handle of HANDLES) {
    const numbers = view[handle.gauge];
    const there = handles.get(handle);
    if (!numbers?.length) {
      there?.remove();
      handles.delete(handle);
      continue;
    }
    const button =
      there ?? h("button", { type: "button", class: "gauge", "data-gauge": handle.name });
    button.setAttribute("aria-label", shownIn(app.text, handle.name, numbers));
    if (there) continue;
    handles.set(handle, button);
    listen(bench, handle, button);
    element.append(button);
  }
}

/**
 * The place of a pointer, metres.
 * @param {Bench} bench @param {PointerEvent} event
 */
function under({ canvas, look }, event) {
  const place = canvas.getBoundingClientRect();
  const { camera } = look;
  return [
    (event.clientX - place.left - camera.x) / camera.scale,
    (camera.y - (event.clientY - place.top)) / camera.scale,
  ];
}

/** @param {Bench} bench @param {Handle} handle @param {PointerEvent} event */
function drag(bench, { gauge, first, turns }, event) {
  const numbers = bench.app.store.get().view[gauge];
  if (!numbers?.length) return;
  const at = under(bench, event);
  const theta = turns ? leg(bench.look, numbers, at) : null;
  if (turns && theta === null) return;
  const values = theta === null ? meant(bench.look, at) : [theta];
  set(bench, gauge, changed(numbers, first, values));
}

/**
 * What an arrow does to a handle.
 * @param {Bench} bench @param {Handle} handle @param {KeyboardEvent} event
 */
function nudge(bench, { gauge, first, turns }, event) {
  const arrow = ARROWS[event.key];
  const numbers = bench.app.store.get().view[gauge];
  if (!arrow || !numbers?.length || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation();
  const share = event.shiftKey ? FINE : 1;
  const step = turns ? TURN : roundStep(STEP / bench.look.camera.scale);
  // right and up turn against the clock
  const by = turns ? [arrow[0] + arrow[1]] : arrow;
  const values = by.map((way, i) => {
    const value = numbers[first + i] + way * step * share;
    return Number(value.toPrecision(10));
  });
  set(bench, gauge, changed(numbers, first, values));
  bench.app.announce(readings(bench.app.text, gauge, bench.app.store.get().view[gauge] ?? []));
}

/** @param {Bench} bench @param {Handle} handle @param {HTMLButtonElement} button */
function listen(bench, handle, button) {
  button.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && bench.held) return cancel(bench);
    nudge(bench, handle, event);
  });
  button.addEventListener("pointerdown", (event) => {
    if (!event.isPrimary || event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    const before = bench.app.store.get().view[handle.gauge] ?? [];
    bench.held = { handle, id: event.pointerId, before };
  });
  button.addEventListener("pointermove", (event) => {
    if (bench.held?.id === event.pointerId) drag(bench, handle, event);
  });
  for (const end of ["pointerup", "pointercancel"])
    button.addEventListener(end, () => (bench.held = null));
}

/** What was dragged goes back. @param {Bench} bench */
function cancel(bench) {
  if (!bench.held) return;
  set(bench, bench.held.handle.gauge, bench.held.before);
  bench.held = null;
}

/** Strokes and handles, where the stage is now. @param {Bench} bench */
function follow(bench) {
  const { app, canvas, look, handles } = bench;
  const { ruler, protractor } = app.store.get().view;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  if (ruler?.length) paintRuler(context, look, ruler, readings(app.text, "ruler", ruler), app.text);
  if (protractor?.length)
    paintProtractor(context, look, protractor, readings(app.text, "protractor", protractor));
  for (const [handle, button] of handles) {
    const numbers = app.store.get().view[handle.gauge];
    if (!numbers?.length) continue;
    const [mx, my] = placeOf(bench, handle, numbers);
    const { x, y } = pixelOf(look.camera, mx, my);
    const within = (/** @type {number} */ value, /** @type {number} */ most) =>
      Math.round(Math.max(MARGIN, Math.min(most - MARGIN, value)));
    const { clientWidth, clientHeight } = canvas;
    button.style.transform = `translate(${within(x, clientWidth)}px, ${within(y, clientHeight)}px)`;
  }
}

/** @param {HTMLElement} stage @param {App} app @param {Look} look */
export default function mountGauges(stage, app, look) {
  const bag = createBag();
  const label = app.text("measure.gauges.title");
  const element = h("div", { role: "group", "aria-label": label });
  const canvas = /** @type {HTMLCanvasElement} */ (stage.querySelector(".canvas"));
  stage.append(element);
  /** @type {Bench} */
  const bench = { app, element, look, canvas, handles: new Map(), held: null };
  const show = () => {
    lay(bench);
    fill(bench);
    look.soon();
  };
  bag(
    app.store.subscribe(({ view }, before) => {
      if (view.ruler !== before.view.ruler || view.protractor !== before.view.protractor) show();
    }),
  );
  show();
  return { follow: () => follow(bench), destroy: bag.end };
}
