// A map of two numbers, of the start's angles or of the pendulum: for every pair of them what the
// motion comes to; a point of it is a pendulum and its start.
// Leaves to others: the computing (the server's ensembles, asked strip by strip so that the map
// grows), its numbers (map_numbers.js), drawing (map_paint.js).
// Invariant: a point's colour is the server's number; a point that is chosen starts the pendulum
// with the two numbers of its middle, all else as when the map was computed.

import { said } from "../../client.js";
import { createBag, h } from "../../dom.js";
import { still } from "../../screen.js";
import { aborted, button, choice, fetchTable, later, needsServer, save } from "../kit/kit.js";
import {
  OBSERVED,
  begunAt,
  bodyOf,
  createMap,
  offered,
  ownPoint,
  takeRows,
  wordsOf,
} from "./map_numbers.js";
import { fitCanvas, imageOf, paintMap, pointUnder } from "./map_paint.js";

const SIZES = [30, 60, 120, 240];
const DURATIONS = [5, 10, 20, 30, 100];
const STRIP = 2400; // motions a request, about
const FAR = 10; // points that an arrow key goes with shift

/** By how many points the arrow keys go. @type {Record<string, [number, number]>} */
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/** @typedef {import("./map_numbers.js").NumberMap} NumberMap */
/** @typedef {import("./map_numbers.js").Point} Point */
/** @typedef {import("./map_numbers.js").Wish} Wish */

/**
 * The map while its drawer is there: what is wished for, what is known, where the cross is.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, wish: Wish, map: NumberMap | null, cross: Point, picture: HTMLCanvasElement,
 *   stop: AbortController | null, size: import("./map_paint.js").Size | null,
 *   compute: HTMLButtonElement, png: HTMLButtonElement,
 * }} View
 */

/** @param {Text} text @param {string} title @param {string} id of what is told of a point */
function partsOf(text, title, id) {
  const named = { "aria-label": text("map.label"), "aria-describedby": id };
  const canvas = h("canvas", { class: "map", tabindex: 0, role: "application", ...named });
  const point = h("p", { class: "map-point", id, role: "status" });
  return {
    canvas,
    point,
    status: h("p", { class: "quiet", role: "status" }),
    bar: h("progress", { max: 1, value: 0, hidden: true, "aria-label": title }),
    place: h("div", { hidden: true }, canvas, point),
    controls: h("div", { class: "row" }),
  };
}

/** @param {View} view */
function showControls({ app, wish, controls, compute, png }) {
  const { text, store } = app;
  const axes = offered(store.get(), text);
  const names = axes.map(({ value }) => String(value));
  if (!names.includes(wish.across)) wish.across = names[0];
  if (!names.includes(wish.up) || wish.up === wish.across)
    wish.up = names.find((name) => name !== wish.across) ?? names[0];
  if (controls.contains(document.activeElement) && controls.children.length) return;
  const pick = (
    /** @type {keyof Wish} */ key,
    /** @type {string} */ label,
    /** @type {import("../kit/kit.js").Option[]} */ options,
  ) => {
    const made = choice(text(label), options, wish[key], (value) => {
      const number = typeof wish[key] === "number";
      Object.assign(wish, { [key]: number ? Number(value) : value });
    });
    made.select.dataset.map = key;
    return made.element;
  };
  const observed = Object.keys(OBSERVED).map((value) => ({ value, words: text(`map.${value}`) }));
  const sizes = SIZES.map((count) => ({
    value: count,
    words: text("compare.pointsValue", { count }),
  }));
  const spans = DURATIONS.map((time) => ({
    value: time,
    words: text("seconds", { time }),
  }));
  controls.replaceChildren(
    pick("across", "map.across", axes),
    pick("up", "map.up", axes),
    pick("what", "map.what", observed),
    pick("count", "compare.points", sizes),
    pick("duration", "compare.duration", spans),
    compute,
    png,
  );
}

/** Begins a map of the pendulum on the stage. @param {View} view @returns {NumberMap} */
function begin(view) {
  const { app, wish } = view;
  const map = createMap(app.store.get(), wish);
  view.map = map;
  view.picture = h("canvas", { width: map.count, height: map.count });
  view.cross = ownPoint(map);
  view.compute.textContent = app.text("compare.stop");
  view.place.hidden = view.bar.hidden = false;
  view.png.hidden = true;
  fit(view);
  return map;
}

/** @param {View} view */
async function run(view) {
  const { app, wish, status } = view;
  const { text } = app;
  if (wish.across === wish.up) return (status.textContent = text("map.two"));
  const map = begin(view);
  view.stop = new AbortController();
  try {
    await fetchMap(view, map, view.stop.signal);
    status.textContent = text("compare.done", { count: map.count ** 2 });
    app.announce(status.textContent);
    view.png.hidden = !OBSERVED[map.what].scale;
  } catch (error) {
    status.textContent = aborted(error) ? text("compare.stopped") : said(error, text);
  }
  view.stop = null;
  view.bar.hidden = true;
  view.compute.textContent = text("compare.compute");
  draw(view);
}

/**
 * All rows, so many motions a request, one request after the other.
 * @param {View} view @param {NumberMap} map @param {AbortSignal} signal
 */
async function fetchMap(view, map, signal) {
  const { client, text } = view.app;
  const { count } = map;
  const many = Math.max(1, Math.round(STRIP / count));
  for (let row = 0; row < count; row += many) {
    const body = bodyOf(map, row, Math.min(many, count - row));
    takeRows(map, row, await fetchTable(client, "/v1/ensembles", body, { signal }));
    view.bar.value = map.done / count ** 2;
    const percent = Math.floor((100 * map.done) / count ** 2);
    view.status.textContent = text("compare.progress", { percent, count: count ** 2 });
    paint(view);
  }
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
function draw({ app, canvas, map, size, picture, cross, point }) {
  if (!map || !size) return;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  paintMap({ context, map, size, text: app.text }, picture, cross);
  point.textContent = wordsOf(map, cross, app.text);
}

/** The pendulum of a point, from its start. @param {View} view @param {Point} point */
function choose(view, point) {
  const { app, map } = view;
  const { store, clock } = app;
  if (!map) return;
  view.cross = point;
  draw(view);
  const { pendulum, initial } = begunAt(map, point);
  // another start of the pendulum on the stage leaves its ghosts
  if (pendulum === store.get().pendulum) store.set({ initial }, { label: "map" });
  else store.set({ pendulum, initial, ghosts: [] }, { label: "map" });
  clock.seek(0);
  if (!still.matches) clock.play();
}

/** @param {View} view @param {KeyboardEvent} event */
function key(view, event) {
  const { map, cross } = view;
  const move = MOVES[event.key];
  if (!map || (!move && event.key !== "Enter")) return;
  event.preventDefault();
  event.stopPropagation();
  if (!move) return choose(view, cross);
  const far = event.shiftKey ? FAR : 1;
  const within = (/** @type {number} */ value) => Math.max(0, Math.min(map.count - 1, value));
  view.cross = { i: within(cross.i + far * move[0]), j: within(cross.j + far * move[1]) };
  draw(view);
}

/** @param {View} view @param {Bag} bag */
function listen(view, bag) {
  const { app, canvas, place } = view;
  const { store, theme } = app;
  const under = (/** @type {MouseEvent} */ event) =>
    view.map && view.size ? pointUnder(canvas, view.map, view.size, event) : null;
  bag.on(canvas, "keydown", (event) => key(view, event));
  bag.on(canvas, "click", (event) => {
    const point = under(event);
    if (point) choose(view, point);
  });
  bag.on(canvas, "mousemove", (event) => {
    const point = under(event);
    if (view.map && point) view.point.textContent = wordsOf(view.map, point, app.text);
    canvas.style.cursor = point ? "crosshair" : "default";
  });
  bag(theme.subscribe(() => paint(view)));
  const observer = new ResizeObserver(later(() => fit(view)));
  observer.observe(place);
  bag(() => observer.disconnect());
  bag(
    store.subscribe((doc, before) => {
      const other = doc.view.selected !== before.view.selected;
      if (doc.pendulum !== before.pendulum || other) showControls(view);
    }),
  );
}

/** What was computed, as the server draws it. @param {View} view */
async function savePng({ app, map, status }) {
  if (!map) return;
  const { observable: of, scale } = OBSERVED[map.what];
  try {
    const body = { ...bodyOf(map), picture: { of, scale } };
    const { blob } = await app.client.file("/v1/ensembles", body, "image/png");
    save(blob, `${map.what}.png`);
  } catch (error) {
    if (!aborted(error)) status.textContent = said(error, app.text);
  }
}

/**
 * A map, with what is wished for at first.
 * @param {App} app @param {string} title @param {string} intro @param {Partial<Wish>} wish
 */
export default function mountMap(app, title, intro, wish) {
  const { text } = app;
  const bag = createBag();
  const press = () => (view.stop ? view.stop.abort() : run(view));
  const hidden = { hidden: true, "data-map": "png" };
  /** @type {View} */
  const view = {
    ...partsOf(text, title, `map-point-${wish.what}`),
    ...{ app, map: null, picture: h("canvas"), stop: null, size: null, cross: { i: 0, j: 0 } },
    wish: { across: "", up: "", what: "", count: 30, duration: 30, ...wish },
    compute: button(text("compare.compute"), press, { "data-map": "compute" }),
    png: button(text("compare.savePng"), () => savePng(view), hidden),
  };
  listen(view, bag);
  showControls(view);
  const { controls, bar, status, place } = view;
  const words = [h("h3", {}, title), h("p", { class: "quiet" }, intro)];
  return {
    element: needsServer(
      text,
      h("section", { "aria-label": title }, ...words, controls, bar, status, place),
    ),
    show: () => fit(view),
    destroy() {
      view.stop?.abort();
      bag.end();
    },
  };
}
