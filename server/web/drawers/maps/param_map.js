// A map of two numbers of the pendulum: for every pair of them what its motion comes to; a point
// of it is a pendulum.
// Leaves to others: the computing (the server's ensembles, asked strip by strip so that the map
// grows), its numbers (map_numbers.js), drawing (map_paint.js).
// Invariant: a point's colour is the server's number; a point that is chosen starts the pendulum
// with the two numbers of its middle, all else as when the map was computed.

import { said } from "../../client.js";
import { createBag, h } from "../../dom.js";
import { still } from "../../screen.js";
import { aborted, button, choice, fetchTable, later } from "../kit/kit.js";
import {
  fitCanvas,
  moved,
  optionsOf,
  partsOf,
  pointUnder,
  stripByStrip,
  tellProgress,
} from "./map_frame.js";
import {
  AXES,
  OBSERVED,
  bodyOf,
  createMap,
  nameOf,
  offered,
  takeRows,
  valueAt,
  wordsOf,
} from "./map_numbers.js";
import { imageOf, paintMap } from "./map_paint.js";

const SIZES = [30, 60, 120];
const DURATIONS = [10, 30, 100];
const STRIP = 1200; // motions a request, about

/** @typedef {import("./map_numbers.js").NumberMap} NumberMap */

/**
 * The map while its drawer is there: what is wished for, what is known, where the cross is.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, wish: import("./map_numbers.js").Wish, map: NumberMap | null, cross: {i: number, j:
 *   number}, picture: HTMLCanvasElement | null, stop: AbortController | null,
 *   size: import("./map_frame.js").Size | null, compute: HTMLButtonElement,
 * }} View
 */

/** @param {View} view */
function showControls(view) {
  const { app, wish, controls, compute } = view;
  const { text, store } = app;
  const { pendulum, view: seen } = store.get();
  const names = offered(pendulum, Math.max(seen.selected, 1) - 1);
  if (!names.includes(wish.across)) wish.across = names[0];
  if (!names.includes(wish.up) || wish.up === wish.across)
    wish.up = names.find((name) => name !== wish.across) ?? names[0];
  const axes = names.map((value) => ({ value, words: nameOf(text, value) }));
  const observed = Object.keys(OBSERVED).map((value) => ({ value, words: text(`map.${value}`) }));
  const { sizes, spans } = optionsOf(text, SIZES, DURATIONS);
  const pick = (
    /** @type {keyof typeof wish} */ key,
    /** @type {string} */ label,
    /** @type {import("../kit/kit.js").Option[]} */ options,
  ) => {
    const made = choice(text(label), options, wish[key], (value) => {
      const number = typeof wish[key] === "number";
      Object.assign(wish, { [key]: number ? Number(value) : value });
    });
    made.select.dataset.wish = key;
    return made.element;
  };
  if (controls.contains(document.activeElement) && controls.children.length) return;
  controls.replaceChildren(
    pick("across", "map.across", axes),
    pick("up", "map.up", axes),
    pick("what", "map.what", observed),
    pick("count", "compare.points", sizes),
    pick("duration", "compare.duration", spans),
    compute,
  );
}

/** @param {View} view */
async function run(view) {
  const { app, wish, status } = view;
  const { client, store, text } = app;
  if (wish.across === wish.up) return (status.textContent = text("map.two"));
  const map = createMap(store.get(), wish);
  view.map = map;
  view.picture = h("canvas", { width: map.count, height: map.count });
  view.cross = map.start;
  view.compute.textContent = text("compare.stop");
  view.place.hidden = view.bar.hidden = false;
  fit(view);
  view.stop = new AbortController();
  try {
    await fetchMap(view, map, client, view.stop.signal);
    status.textContent = text("compare.done", { count: map.count ** 2 });
    app.announce(status.textContent);
  } catch (error) {
    status.textContent = aborted(error) ? text("compare.stopped") : said(error, text);
  }
  view.stop = null;
  view.bar.hidden = true;
  view.compute.textContent = text("map.compute");
  draw(view);
}

/**
 * Strip by strip.
 * @param {View} view @param {NumberMap} map @param {Client} client @param {AbortSignal} signal
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
  if (!map || !picture) return;
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
  if (!map || !size || !picture) return;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  paintMap({ context, map, size, text: app.text }, picture, cross);
  point.textContent = wordsOf(map, cross, app.text);
}

/** The pendulum starts with the numbers of the cross. @param {View} view */
function choose({ app, map, cross }) {
  if (!map) return;
  const arms = new Set([map.k]);
  const { across, up } = map;
  const first = AXES[across].field.set(map.pendulum, arms, valueAt(map, across, cross.i), 0);
  const pendulum = AXES[up].field.set(first, arms, valueAt(map, up, cross.j), 0);
  app.store.set({ pendulum, initial: map.initial, ghosts: [] }, { label: "physics" });
  if (!still.matches) app.clock.play();
}

/** @param {View} view @param {KeyboardEvent} event */
function key(view, event) {
  const { map, cross } = view;
  if (!map) return;
  const to = moved(event, cross, map.count);
  if (!to && event.key !== "Enter") return;
  event.preventDefault();
  event.stopPropagation();
  if (!to) return choose(view);
  view.cross = to;
  draw(view);
}

/** @param {View} view @param {PointerEvent} event @param {boolean} take */
function pointed(view, event, take) {
  const { map, size, canvas } = view;
  if (!map || !size) return;
  const at = pointUnder(canvas, map, size, event);
  if (!at) return;
  if (!take) {
    view.point.textContent = wordsOf(map, at, view.app.text);
    return;
  }
  view.cross = at;
  draw(view);
  choose(view);
}

/** @param {App} app */
export function mountNumberMap(app) {
  const { text, store, theme } = app;
  const bag = createBag();
  const state = { map: null, picture: null, stop: null, size: null, cross: { i: 0, j: 0 } };
  const wish = { across: "motorRate", up: "motor", what: "end", count: 30, duration: 30 };
  const click = () => (view.stop ? view.stop.abort() : run(view));
  const compute = button(text("map.compute"), click, { "data-wish": "compute" });
  /** @type {View} */
  const view = {
    ...partsOf(text("map.label"), text("map.title"), "number-map-point"),
    ...state,
    app,
    wish,
    compute,
  };
  bag.on(view.canvas, "keydown", (event) => key(view, event));
  bag.on(view.canvas, "pointermove", (event) => pointed(view, event, false));
  bag.on(view.canvas, "pointerup", (event) => pointed(view, event, true));
  bag(theme.subscribe(() => paint(view)));
  const observer = new ResizeObserver(later(() => fit(view)));
  observer.observe(view.place);
  bag(() => observer.disconnect());
  bag(
    store.subscribe((doc, before) => {
      const other = doc.view.selected !== before.view.selected;
      if (doc.pendulum !== before.pendulum || other) showControls(view);
    }),
  );
  showControls(view);
  const { controls, bar, status, place } = view;
  const words = h("p", { class: "quiet" }, text("map.intro"));
  return {
    element: h(
      "section",
      { "aria-label": text("map.title") },
      h("h3", {}, text("map.title")),
      words,
      controls,
      bar,
      status,
      place,
    ),
    show: () => fit(view),
    destroy() {
      view.stop?.abort();
      bag.end();
    },
  };
}
