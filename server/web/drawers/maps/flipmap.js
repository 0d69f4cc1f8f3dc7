// The map of flips: for every start of two arms, when an arm first turns over; a point of it is a
// start.
// Leaves to others: the computing (the server's ensembles, asked strip by strip so that the map
// grows), numbers (flips.js), drawing (flipmap_paint.js).
// Invariant: a point's colour is the server's number; a point that is clicked starts from the
// angles of its middle, all else as when the map was computed.

import { said } from "../../client.js";
import { createBag, h } from "../../dom.js";
import { still } from "../../screen.js";
import { drawMap, imageOf } from "./flipmap_paint.js";
import { bodyOf, createMap, nearestPoint, startOf, takeRows, wordsOf } from "./flips.js";
import { aborted, button, choice, fetchTable, later, save } from "../kit/kit.js";
import {
  fitCanvas,
  moved,
  optionsOf,
  partsOf,
  pointUnder,
  stripByStrip,
  tellProgress,
} from "./map_frame.js";

const SIZES = [60, 120, 240];
const DURATIONS = [5, 10, 20];
const STRIP = 2400; // motions a request, about

/** @typedef {import("./flips.js").FlipMap} FlipMap */
/** @typedef {import("./flips.js").Point} Point */

/**
 * The map while its drawer is there: what is wished for, what is known, and the parts of the page
 * that show it.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, wish: import("./flips.js").Wish, map: FlipMap | null, picture: HTMLCanvasElement,
 *   cross: Point,
 *   stop: AbortController | null, size: import("./map_frame.js").Size | null,
 *   compute: HTMLButtonElement, png: HTMLButtonElement,
 * }} View
 */

/**
 * Two arms that there are, and that are not the same.
 * @param {import("./flips.js").Wish} wish @param {number} arms
 */
function settleWish(wish, arms) {
  wish.across = Math.min(wish.across, arms);
  if (wish.up > arms || wish.up === wish.across) wish.up = wish.across === arms ? 1 : arms;
}

/** @param {View} view */
function showControls({ app, wish, controls, compute, png, status }) {
  const { store, text } = app;
  const arms = store.get().pendulum.length.length;
  settleWish(wish, arms);
  const list = Array.from({ length: arms }, (_, k) => ({ value: k + 1, words: String(k + 1) }));
  const { sizes, spans } = optionsOf(text, SIZES, DURATIONS);
  const pick = (
    /** @type {keyof typeof wish} */ key,
    /** @type {string} */ label,
    /** @type {import("../kit/kit.js").Option[]} */ options,
  ) => {
    const made = choice(text(label), options, wish[key], (value) => {
      wish[key] = Number(value);
    });
    made.select.dataset.map = key;
    return made.element;
  };
  controls.replaceChildren(
    pick("across", "compare.across", list),
    pick("up", "compare.up", list),
    pick("count", "compare.points", sizes),
    pick("duration", "compare.duration", spans),
    compute,
    png,
  );
  compute.disabled = arms < 2;
  if (arms < 2) status.textContent = text("compare.mapOne");
}

/** Begins a map of the pendulum on the stage. @param {View} view @returns {FlipMap} */
function begin(view) {
  const { app, wish } = view;
  const { store, text } = app;
  if (wish.across === wish.up) wish.up = wish.across === 1 ? 2 : 1;
  showControls(view);
  const map = createMap(store.get(), wish);
  view.map = map;
  view.picture = h("canvas", { width: map.count, height: map.count });
  view.cross = nearestPoint(map, store.get().initial);
  view.compute.textContent = text("compare.stop");
  view.place.hidden = view.bar.hidden = false;
  view.png.hidden = true;
  fit(view);
  return map;
}

/** @param {View} view */
async function run(view) {
  const { app, status } = view;
  const { client, text } = app;
  const map = begin(view);
  view.stop = new AbortController();
  const { signal } = view.stop;
  try {
    await fetchMap(view, map, client, signal);
    status.textContent = text("compare.done", { count: map.count ** 2 });
    app.announce(status.textContent);
    view.png.hidden = false;
  } catch (error) {
    status.textContent = aborted(error) ? text("compare.stopped") : said(error, text);
  }
  view.stop = null;
  view.bar.hidden = true;
  view.compute.textContent = text("compare.compute");
  draw(view);
}

/**
 * Strip by strip.
 * @param {View} view @param {FlipMap} map @param {Client} client @param {AbortSignal} signal
 */
async function fetchMap(view, map, client, signal) {
  await stripByStrip(map.count, STRIP, async (row, rows) => {
    const body = bodyOf(map, row, rows);
    takeRows(map, row, await fetchTable(client, "/v1/ensembles", body, { signal }));
    tellProgress(view, map, view.app.text);
    paint(view);
  });
}

/** @param {View} view */
function paint(view) {
  const { map, picture, app } = view;
  if (!map) return;
  picture.getContext("2d")?.putImageData(imageOf(map, app.theme.dark), 0, 0);
  draw(view);
}

/** @param {View} view */
function fit(view) {
  if (!view.place.clientWidth) return;
  view.size = fitCanvas(view.canvas, view.place.clientWidth);
  draw(view);
}

/** @param {View} view */
function draw(view) {
  const { app, canvas, map, size, picture, cross } = view;
  if (!map || !size) return;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  drawMap({ context, map, size, text: app.text }, picture, cross);
  outdated(view);
}

/**
 * Says so where the map is of another pendulum than the stage's; whether it is.
 * @param {View} view
 */
function outdated({ app, map, stop, status }) {
  const other = map !== null && map.pendulum !== app.store.get().pendulum;
  if (other && !stop) status.textContent = app.text("compare.outdated");
  return other;
}

/** @param {View} view @param {FlipMap} map @param {Point} point */
function describe(view, map, point) {
  view.point.textContent = wordsOf(map, point, view.app.text);
}

/**
 * The pendulum starts from a point.
 * @param {View} view @param {FlipMap} map @param {Point} point
 */
function start(view, map, point) {
  const { store, clock } = view.app;
  if (outdated(view)) return;
  view.cross = point;
  store.set({ initial: startOf(map, point) }, { label: "flipmap" });
  clock.seek(0);
  if (!still.matches) clock.play();
  describe(view, map, point);
  draw(view);
}

/** @param {View} view @param {KeyboardEvent} event */
function keys(view, event) {
  const { map, cross } = view;
  if (!map) return;
  if (event.key === "Enter") {
    event.preventDefault();
    start(view, map, cross);
    return;
  }
  const to = moved(event, cross, map.count);
  if (!to) return;
  event.preventDefault();
  event.stopPropagation();
  view.cross = to;
  describe(view, map, view.cross);
  draw(view);
}

/** @param {View} view @param {Bag} bag */
function listen(view, bag) {
  const { canvas } = view;
  const under = (/** @type {MouseEvent} */ event) =>
    view.map && view.size ? pointUnder(canvas, view.map, view.size, event) : null;
  bag.on(canvas, "keydown", (event) => keys(view, event));
  bag.on(canvas, "click", (event) => {
    const point = under(event);
    if (view.map && point) start(view, view.map, point);
  });
  bag.on(canvas, "mousemove", (event) => {
    const point = under(event);
    if (view.map && point) describe(view, view.map, point);
    canvas.style.cursor = point ? "crosshair" : "default";
  });
}

/** @param {View} view */
async function savePng({ app, map, status }) {
  if (!map) return;
  const { client, text } = app;
  try {
    const body = { ...bodyOf(map), picture: { of: "first_flip", scale: "log" } };
    const { blob } = await client.file("/v1/ensembles", body, "image/png");
    save(blob, "flips.png");
  } catch (error) {
    if (!aborted(error)) status.textContent = said(error, text);
  }
}

/** @param {App} app @returns {View} */
function createView(app) {
  const { text } = app;
  const main = { class: "button main", "data-map": "compute" };
  const press = () => (view.stop ? view.stop.abort() : run(view));
  const hidden = { hidden: true, "data-map": "png" };
  /** @type {View} */
  const view = {
    ...partsOf(text("compare.mapLabel"), text("compare.map"), "map-point"),
    app,
    wish: { across: 1, up: 2, count: 120, duration: 10 },
    map: null,
    picture: h("canvas"),
    cross: { i: 0, j: 0 },
    stop: null,
    size: null,
    compute: button(text("compare.compute"), press, main),
    png: button(text("compare.savePng"), () => savePng(view), hidden),
  };
  return view;
}

/** @param {App} app */
export function mountFlipMap(app) {
  const { store, text, theme } = app;
  const bag = createBag();
  const view = createView(app);
  listen(view, bag);
  const observer = new ResizeObserver(later(() => fit(view)));
  observer.observe(view.place);
  bag(() => observer.disconnect());
  bag(theme.subscribe(() => paint(view)));
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum === before.pendulum) return;
      showControls(view);
      outdated(view);
    }),
  );
  showControls(view);
  const title = h("h3", {}, text("compare.map"));
  const intro = h("p", { class: "quiet" }, text("compare.mapIntro"));
  const { controls, bar, status, place } = view;
  const attributes = { "aria-label": text("compare.map") };
  return {
    element: h("section", attributes, title, intro, controls, bar, status, place),
    show: () => fit(view),
    hide() {},
    destroy() {
      view.stop?.abort();
      bag.end();
    },
  };
}
