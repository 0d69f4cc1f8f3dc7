// The examples: the server's presets, each as a small picture; a click puts one on the stage.
// Leaves to others: which there are (GET /v1/presets), drawing one (preset_picture.js).
// Invariant: one request brings all of them; a picture moves, with the one clock, once somebody has
// come near the examples, and asks for its motion when it can be seen; only what can be seen is
// drawn.

import { gaveUp } from "./client.js";
import { createBag, h } from "./dom.js";
import { farthest } from "./edits.js";
import { YOURS, keep } from "./keep.js";
import { createPicture, loadSeconds, pose } from "./preset_picture.js";
import { fromRequest } from "./state.js";
import { theme } from "./theme.js";

const SHORTEST_SPAN = 20;
const FRAME_MS = 30;

/** @typedef {import("./preset_picture.js").Preset} Preset */
/** @typedef {import("./preset_picture.js").PictureColours} PictureColours */
/**
 * @typedef {{preset: Preset, button: HTMLElement, canvas: HTMLCanvasElement, picture:
 * import("./preset_picture.js").Picture, seen: boolean, moves: boolean}} Card
 */

/**
 * The examples while they are there; near: somebody has pointed at them, touched them or come there
 * by keys.
 * @typedef {{
 *   app: App, bag: Bag, stop: AbortController, grid: HTMLElement, cards: Map<string, Card>, sight:
 *   IntersectionObserver,
 *   colours: PictureColours | null, shown: boolean, drawn: number, near:
 *   boolean, animating: boolean,
 * }} Gallery
 */

/** The document of a preset. @param {Preset} preset @returns {Patch} */
function documentOf(preset) {
  const patch = fromRequest(preset);
  return {
    ...patch,
    span: { ...patch.span, stop: Math.max(patch.span.stop, SHORTEST_SPAN) },
    title: preset.title,
    preset: preset.name,
    view: { selected: 0, trails: [farthest(patch.pendulum)] },
  };
}

/** @param {Text} text @param {{name: string, title: string}} preset */
const named = (text, { name, title }) =>
  text.has(`preset.${name}`) ? text(`preset.${name}`) : title;

/** What an example shows, in the page's language. @param {Text} text @param {Preset} preset */
function explained(text, { name, description }) {
  if (text.has(`preset.${name}.words`)) return text(`preset.${name}.words`);
  return text.language === "en" ? description : "";
}

/** @param {Gallery} gallery @param {Preset} preset */
function choose({ app }, preset) {
  app.store.set(documentOf(preset), { label: "preset" });
  app.announce(app.text("said.preset", { name: named(app.text, preset) }));
  app.clock.play();
}

/** @param {Gallery} gallery @param {Preset} preset */
function addCard(gallery, preset) {
  const { text } = gallery.app;
  const { name, n } = preset;
  const canvas = h("canvas", { "aria-hidden": "true" });
  const button = h(
    "button",
    {
      type: "button",
      class: "preset",
      "data-preset": name,
      on: { click: () => choose(gallery, preset) },
    },
    canvas,
    h("span", { class: "preset-name" }, named(text, preset)),
    h("span", { class: "quiet" }, text.count("presets.arms", n)),
    h("span", { class: "preset-words" }, explained(text, preset)),
  );
  gallery.grid.append(button);
  const picture = createPicture(canvas, pose(preset));
  gallery.cards.set(name, { preset, button, canvas, picture, seen: false, moves: false });
  gallery.sight.observe(button);
}

/**
 * Resolves when something is so that the motion or the clock tells.
 * @param {Gallery} gallery @param {(app: App) => unknown} so @returns {Promise<unknown>}
 */
function when({ app, bag }, so) {
  if (so(app)) return Promise.resolve();
  return new Promise((resolve) => {
    const look = () => {
      if (!so(app)) return;
      ends.forEach((end) => end());
      resolve(null);
    };
    const ends = [app.motion.subscribe(look), app.clock.subscribe(look)];
    ends.forEach(bag);
  });
}

/** The stage comes first, and moves before the cards are built. @param {Gallery} gallery */
async function fill(gallery) {
  const { client } = gallery.app;
  await when(gallery, ({ motion }) => motion.complete || motion.failure);
  const [{ presets }] = await Promise.all([
    client.presets({ signal: gallery.stop.signal }),
    when(gallery, ({ clock }) => !clock.playing || clock.time > 0),
  ]);
  for (const preset of presets) addCard(gallery, preset);
  mark(gallery);
  draw(gallery);
}

/** The next picture that can be seen and does not move yet. @param {Gallery} gallery */
const nextStill = ({ cards }) => [...cards.values()].find(({ seen, moves }) => seen && !moves);

/** One motion after the other, of what can be seen. @param {Gallery} gallery */
async function animate(gallery) {
  const { app, stop } = gallery;
  if (!gallery.near || gallery.animating || stop.signal.aborted) return;
  gallery.animating = true;
  try {
    for (let card = nextStill(gallery); card; card = nextStill(gallery)) {
      card.moves = true;
      card.picture = createPicture(
        card.canvas,
        await loadSeconds(card.preset, app.client, stop.signal),
      );
      draw(gallery);
    }
  } catch (error) {
    // a picture that does not move is a picture
    if (!gaveUp(error) && !(/** @type {Failed} */ (error).kind)) throw error;
  } finally {
    gallery.animating = false;
  }
}

/** @param {Gallery} gallery @param {unknown} error */
function nothing(gallery, error) {
  if (gaveUp(error)) return;
  const { text } = gallery.app;
  const click = () => begin(gallery);
  const again = h("button", { type: "button", class: "button", on: { click } }, text("again"));
  gallery.grid.replaceChildren(h("p", { class: "quiet" }, text("presets.none")), again);
}

/** @param {Gallery} gallery */
function begin(gallery) {
  gallery.grid.replaceChildren();
  fill(gallery).catch((error) => nothing(gallery, error));
}

/** @param {Gallery} gallery */
function draw(gallery) {
  if (!gallery.shown || !gallery.cards.size || document.hidden) return;
  gallery.drawn = performance.now();
  const colours = (gallery.colours ??= readPictureColours());
  for (const { picture, seen } of gallery.cards.values()) {
    if (seen) picture(gallery.app.clock.time, colours);
  }
}

/** @param {Gallery} gallery */
function mark({ app, cards }) {
  const { preset } = app.store.get();
  for (const [name, { button }] of cards)
    button.setAttribute("aria-pressed", String(name === preset));
}

function readPictureColours() {
  const style = getComputedStyle(document.documentElement);
  const value = (/** @type {string} */ name) => style.getPropertyValue(name);
  return { pivot: value("--faint"), line: value("--quiet"), mass: value("--mass") };
}

/** @param {HTMLElement} grid @param {App} app @returns {Gallery} */
function createGallery(grid, app) {
  /** @type {Map<string, Card>} */
  const cards = new Map();
  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const card = cards.get(/** @type {HTMLElement} */ (target).dataset.preset ?? "");
      if (card) card.seen = isIntersecting;
    }
    draw(gallery);
    animate(gallery);
  });
  const state = { colours: null, shown: false, drawn: 0, near: false, animating: false };
  const gallery = {
    app,
    bag: createBag(),
    stop: new AbortController(),
    grid,
    cards,
    sight,
    ...state,
  };
  return gallery;
}

/**
 * What was made in this browser, where there is something; it comes with a file of its own.
 * @param {App} app @param {HTMLElement} place
 */
async function showYours(app, place) {
  if (!keep.get(YOURS) && !place.hasChildNodes()) return;
  const [{ default: fillYours }] = await Promise.all([
    app.files.script("drawers/yours.js"),
    app.text.part("drawers"),
  ]);
  fillYours(app, place);
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const { store, clock, text } = app;
  const grid = h("div", { class: "gallery" });
  const yours = h("div", {});
  element.append(
    h("h2", {}, text("drawer.presets")),
    h("p", { class: "quiet" }, text("presets.words")),
    yours,
    grid,
  );
  const gallery = createGallery(grid, app);
  const { bag, stop, sight } = gallery;
  const late = () => performance.now() - gallery.drawn > FRAME_MS;
  bag(clock.subscribe(() => (!clock.playing || late()) && draw(gallery)));
  bag.on(document, "visibilitychange", () => draw(gallery));
  bag(store.subscribe(() => mark(gallery)));
  bag(
    theme.subscribe(() => {
      gallery.colours = readPictureColours();
      draw(gallery);
    }),
  );
  const approach = () => {
    gallery.near = true;
    animate(gallery);
  };
  for (const event of ["pointerenter", "focusin", "touchstart"])
    bag.on(grid, event, approach, { passive: true });
  begin(gallery);
  return {
    show() {
      gallery.shown = true;
      showYours(app, yours);
      draw(gallery);
    },
    hide() {
      gallery.shown = false;
    },
    destroy() {
      stop.abort();
      sight.disconnect();
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "presets", title: (text) => text("drawer.presets"), mount };
