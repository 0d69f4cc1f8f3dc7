// The examples: the server's presets in groups, each as a small picture that moves under the
// pointer; a click puts one on the stage.
// Leaves to others: which there are (GET /v1/presets), drawing one (preset_picture.js).
// Invariant: one request brings all of them but one; a picture asks for its motion when somebody
// points at it first, and moves only while they do.

import { gaveUp } from "./client.js";
import { createBag, h } from "./dom.js";
import { farthest } from "./edits.js";
import { YOURS, keep } from "./keep.js";
import { createPicture, loadSeconds, pose } from "./preset_picture.js";
import { still } from "./screen.js";
import { fromRequest } from "./state.js";
import { theme } from "./theme.js";

const SHORTEST_SPAN = 20;

/**
 * The examples of each group, in their order; the last group has all others.
 * @type {Record<string, string[]>}
 */
const GROUPS = {
  first: ["single", "side-by-side", "double", "upright"],
  surprising: ["kapitza", "coupled", "two-to-one", "chaotic-double"],
  driven: ["double-bars", "driven-damped", "laboratory-double", "metronome-cart", "bar-on-stop"],
  trees: ["triple", "non-standard-triple", "paper-four-arms", "chain-10", "star", "binary-4"],
  more: [],
};
GROUPS.driven.push("clock");
GROUPS.trees.push("whip", "thor", "octopus", "mobile");

/** @typedef {import("./preset_picture.js").Preset} Preset */
/** @typedef {import("./preset_picture.js").PictureColours} PictureColours */

/**
 * The one example that is no request: two pendulums, of which requests have one.
 * @type {Preset & {second: Preset["pendulum"]}}
 */
const PAIR = {
  name: "side-by-side",
  title: "Two side by side",
  description: "",
  n: 1,
  pendulum: { length: [1], mass: [1], parent: [0], gravity: 9.81 },
  second: { length: [0.25], mass: [1], parent: [0], gravity: 9.81 },
  initial: { phi: [-1.2217304763960306], phid: [0] },
  times: { start: 0, stop: 20, step: 0.01 },
};

/**
 * An example by its name.
 * @param {Client} client @param {string} name @returns {Promise<Preset>}
 */
export const exampleNamed = async (client, name) =>
  name === PAIR.name ? PAIR : client.preset(name);

/** The second pendulum of an example that has two. @param {Preset} preset @returns {Preset[]} */
const secondOf = (preset) => (preset === PAIR ? [{ ...PAIR, pendulum: PAIR.second }] : []);

/**
 * @typedef {{preset: Preset, button: HTMLElement, canvas: HTMLCanvasElement, picture:
 * import("./preset_picture.js").Picture, moves: boolean}} Card
 */

/**
 * The examples while they are there; pointed: the card that somebody points at, or came to by keys;
 * since: when that began, ms.
 * @typedef {{
 *   app: App, bag: Bag, stop: AbortController, place: HTMLElement, cards: Map<string, Card>,
 *   colours: PictureColours | null, pointed: Card | null, since: number, frame: number,
 * }} Gallery
 */

/** The document of a preset. @param {Preset} preset @returns {Patch} */
export function documentOf(preset) {
  const patch = fromRequest(preset);
  const seconds = secondOf(preset).map(fromRequest);
  return {
    ...patch,
    span: { ...patch.span, stop: Math.max(patch.span.stop, SHORTEST_SPAN) },
    title: preset.title,
    preset: preset.name,
    ghosts: seconds.map(({ pendulum, initial }) => ({ ...initial, pendulum, beside: 1 })),
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

/** @param {Gallery} gallery @param {Preset} preset @returns {Card} */
function cardOf(gallery, preset) {
  const { text } = gallery.app;
  const { name, n } = preset;
  const words = explained(text, preset);
  const canvas = h("canvas", { "aria-hidden": "true" });
  const on = {
    click: () => choose(gallery, preset),
    pointerenter: () => point(gallery, card),
    focus: () => point(gallery, card),
    pointerleave: () => leave(gallery),
    blur: () => leave(gallery),
  };
  const attributes = { type: "button", class: "preset", "data-preset": name, title: words, on };
  const button = h(
    "button",
    attributes,
    canvas,
    h("span", { class: "preset-name" }, named(text, preset)),
    h("span", { class: "quiet" }, text.count("presets.arms", n)),
    h("span", { class: "preset-words" }, words),
  );
  const picture = createPicture(canvas, ...[preset, ...secondOf(preset)].map(pose));
  /** @type {Card} */
  const card = { preset, button, canvas, picture, moves: false };
  gallery.cards.set(name, card);
  return card;
}

/** A group with its heading; none without an example. @param {Gallery} gallery */
function groupOf(gallery, /** @type {string} */ id, /** @type {Preset[]} */ presets) {
  if (!presets.length) return;
  const cards = presets.map((preset) => cardOf(gallery, preset).button);
  const heading = h("h3", {}, gallery.app.text(`examples.${id}`));
  gallery.place.append(heading, h("div", { class: "gallery" }, ...cards));
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
  const { client, text } = gallery.app;
  await when(gallery, ({ motion }) => motion.complete || motion.failure);
  const [{ presets }] = await Promise.all([
    client.presets({ signal: gallery.stop.signal }),
    text.part("examples"),
    when(gallery, ({ clock }) => !clock.playing || clock.time > 0),
  ]);
  /** @type {Map<string, Preset>} */
  const left = new Map([PAIR, ...presets].map((/** @type {Preset} */ one) => [one.name, one]));
  for (const [id, names] of Object.entries(GROUPS)) {
    const chosen = id === "more" ? [...left.keys()] : names.filter((name) => left.has(name));
    groupOf(
      gallery,
      id,
      chosen.map((name) => /** @type {Preset} */ (left.get(name))),
    );
    for (const name of chosen) left.delete(name);
  }
  mark(gallery);
  draw(gallery);
}

/** The picture moves as long as somebody points at it. @param {Gallery} gallery */
async function point(gallery, /** @type {Card} */ card) {
  const { app, stop } = gallery;
  if (gallery.pointed === card || still.matches) return;
  leave(gallery);
  gallery.pointed = card;
  try {
    if (!card.moves) {
      const load = (/** @type {Preset} */ one) => loadSeconds(one, app.client, stop.signal);
      const tracks = await Promise.all([card.preset, ...secondOf(card.preset)].map(load));
      card.picture = createPicture(card.canvas, ...tracks);
      card.moves = true;
    }
  } catch (error) {
    // a picture that does not move is a picture
    if (!gaveUp(error) && !(/** @type {Failed} */ (error).kind)) throw error;
  }
  if (gallery.pointed !== card || !card.moves) return;
  gallery.since = performance.now();
  follow(gallery);
}

/** @param {Gallery} gallery */
function follow(gallery) {
  gallery.frame = requestAnimationFrame((now) => {
    if (!gallery.pointed || !gallery.colours) return;
    gallery.pointed.picture(Math.max(0, now - gallery.since) / 1000, gallery.colours);
    follow(gallery);
  });
}

/** It stands as it starts again. @param {Gallery} gallery */
function leave(gallery) {
  cancelAnimationFrame(gallery.frame);
  const { pointed, colours } = gallery;
  gallery.pointed = null;
  if (pointed && colours) pointed.picture(0, colours);
}

/** @param {Gallery} gallery @param {unknown} error */
function nothing(gallery, error) {
  if (gaveUp(error)) return;
  const { text } = gallery.app;
  const click = () => begin(gallery);
  const again = h("button", { type: "button", class: "button", on: { click } }, text("again"));
  gallery.place.replaceChildren(h("p", { class: "quiet" }, text("presets.none")), again);
}

/** @param {Gallery} gallery */
function begin(gallery) {
  gallery.place.replaceChildren();
  fill(gallery).catch((error) => nothing(gallery, error));
}

/** All pictures as they start. @param {Gallery} gallery */
function draw(gallery) {
  const colours = (gallery.colours ??= readPictureColours());
  for (const { picture, canvas } of gallery.cards.values())
    if (canvas.clientWidth) picture(0, colours);
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
  const { store, text } = app;
  const place = h("div", {});
  const yours = h("div", {});
  element.append(
    h("h2", {}, text("drawer.presets")),
    h("p", { class: "quiet" }, text("presets.words")),
    yours,
    place,
  );
  const stop = new AbortController();
  const bag = createBag();
  const state = { colours: null, pointed: null, since: 0, frame: 0 };
  /** @type {Gallery} */
  const gallery = { app, bag, stop, place, cards: new Map(), ...state };
  bag(store.subscribe(() => mark(gallery)));
  bag(
    theme.subscribe(() => {
      gallery.colours = readPictureColours();
      draw(gallery);
    }),
  );
  const observer = new ResizeObserver(() => draw(gallery));
  observer.observe(place);
  begin(gallery);
  return {
    show: () => showYours(app, yours),
    hide: () => leave(gallery),
    destroy() {
      stop.abort();
      leave(gallery);
      observer.disconnect();
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "presets", title: (text) => text("drawer.presets"), mount };
