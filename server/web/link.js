// Scenes: what a link stands for. `#d=` holds all of it, as `#j=` does for browsers that compress
// nothing; `#s=` names one that the server keeps.
// Leaves to others: storing (client.storeScene), showing the link (drawers/share.js).
// Invariant: the document of a scene that was made of doc has the motion of doc, to the bit; what
// is read is checked, whoever wrote it.

import { VECTORS } from "./paint_vectors.js";
import { DRAWERS, FARTHEST, fromRequest, request } from "./state.js";
import { listsOf, soundTerms, termsOf } from "./terms.js";
import { order } from "./tree.js";

/**
 * What a scene holds.
 * @typedef {{request: any, title?: unknown, view?: Record<string, any>}} Scene
 */

const PALETTES = ["safe", "paper"];
const MOST_BYTES = 1 << 22; // of a scene that a link holds
const MOST_NUMBERS = 1e7; // of one column of a motion: what a page can hold

/** {title, request, view} of a document, as /v1/scenes takes it. @param {Doc} doc */
export function sceneOf(doc) {
  const scene = { request: request(doc), view: { ...doc.view, ghosts: doc.ghosts } };
  return doc.title ? { ...scene, title: doc.title } : scene;
}

/** What is handed on: all but a drawer being open. @param {Doc} doc @returns {Doc} */
export const handedOn = (doc) => ({ ...doc, view: { ...doc.view, drawer: null } });

/** @param {unknown} list @param {number} n @returns {list is number[]} */
const numbers = (list, n) =>
  Array.isArray(list) && list.length === n && list.every(Number.isFinite);
/** @param {Partial<State> | undefined} value @param {number} n */
const state = (value, n) =>
  numbers(value?.phi, n) &&
  numbers(value?.phid, n) &&
  (!value?.cart || numbers([value.cart.x, value.cart.v], 2));

/**
 * A ruler or a protractor: four numbers, none where it is not laid down yet, null without one.
 * @param {unknown} value @returns {value is number[] | null}
 */
const gauge = (value) =>
  value === null ||
  (Array.isArray(value) && !value.length) ||
  (numbers(value, 4) && value.every((number) => Math.abs(number) <= FARTHEST));

/**
 * What of a scene's view this page understands.
 * @param {Record<string, any>} view @param {number} n
 */
function viewOf(view, n) {
  /** @param {any} k */
  const arm = (k) => Number.isInteger(k) && k >= 1 && k <= n;
  /** @type {Partial<View>} */
  const known = {};
  if (view.drawer === null || DRAWERS.includes(view.drawer)) known.drawer = view.drawer;
  if (view.speed > 0 && view.speed <= 16) known.speed = view.speed;
  for (const name of /** @type {const} */ (["loop", "arrows", "endless"]))
    if (typeof view[name] === "boolean") known[name] = view[name];
  if (Array.isArray(view.vectors))
    known.vectors = Object.keys(VECTORS).filter((name) => view.vectors.includes(name));
  if (view.vectorScale >= 0.1 && view.vectorScale <= 10) known.vectorScale = view.vectorScale;
  for (const name of /** @type {const} */ (["ruler", "protractor"]))
    if (gauge(view[name])) known[name] = view[name];
  if (PALETTES.includes(view.palette)) known.palette = view.palette;
  if (Array.isArray(view.trails)) known.trails = view.trails.filter(arm).slice(0, 8);
  known.selected = arm(view.selected) ? view.selected : 0;
  return known;
}

/** @param {Tree} tree @param {number} n */
function soundTree({ length, mass, parent, ...terms }, n) {
  const carriers =
    Array.isArray(parent) && parent.every((k) => Number.isInteger(k) && k >= 0 && k <= n);
  return (
    numbers(length, n) &&
    numbers(mass, n) &&
    carriers &&
    parent.length === n &&
    order(parent).length === n &&
    soundTerms(terms, n)
  );
}

/** @param {any} ghost @param {number} n */
const soundGhost = (ghost, n) =>
  state(ghost, n) && (!ghost.pendulum || soundTree(ghost.pendulum, n));

/**
 * The patch of a scene whose request is in the page's own form; throws where it is not sound.
 * @param {Scene} scene @returns {Patch}
 */
export function patchOf(scene) {
  const patch = fromRequest(scene.request);
  const n = patch.pendulum.length.length;
  const sound =
    soundTree(patch.pendulum, n) &&
    state(patch.initial, n) &&
    patch.span.stop > 0 &&
    patch.span.step > 0 &&
    (patch.span.stop / patch.span.step) * n < MOST_NUMBERS;
  if (!sound) throw new Error("not a scene of this page");
  const ghosts = Array.isArray(scene.view?.ghosts)
    ? scene.view.ghosts.filter((ghost) => soundGhost(ghost, n)).slice(0, 20)
    : [];
  return {
    ...patch,
    title: String(scene.title ?? ""),
    preset: null,
    ghosts,
    view: viewOf(scene.view ?? {}, n),
  };
}

/**
 * Any body of /v1/trajectories in the page's own form: the server tells what tree and what start it
 * stands for.
 * @param {any} body @param {Client} client
 */
async function plain(body, client) {
  const { pendulum, initial, times } = body;
  const arrays = Array.isArray(pendulum.length) && !pendulum.arms;
  const angles = initial?.phi && (initial.unit ?? "rad") === "rad";
  if (arrays && angles && times.stop > (times.start ?? 0)) return body;
  const begin = Array.isArray(times) ? times[0] : (times.start ?? 0);
  const stop = Array.isArray(times) ? Math.max(...times) : times.stop;
  const tree = plainTree(await client.trees({ pendulum }));
  const start = { pendulum, ...(initial && { initial }), times: [begin] };
  return {
    ...body,
    pendulum: tree,
    initial: await plainStart(start, Boolean(tree.pivot?.cart), client),
    times: { start: begin, stop, step: times.step ?? (stop - begin) / 1000 },
  };
}

/**
 * The start of a motion, whatever its form.
 * @param {object} body of one instant @param {boolean} onCart @param {Client} client
 */
async function plainStart(body, onCart, client) {
  const output = ["phi", "phid", ...(onCart ? ["cart"] : [])];
  const { phi, phid, cart } = await client.trajectory({ ...body, output });
  const start = { phi: phi[0], phid: phid[0] };
  return onCart ? { ...start, cart: { x: cart.x[0], v: cart.v[0] } } : start;
}

/** A tree as lists, from the server's description of it. @param {any} told @returns {Tree} */
function plainTree({ arms, parent, gravity, drag_per_mass: drag, pivot }) {
  return {
    length: arms.map((/** @type {any} */ arm) => arm.length),
    mass: arms.map((/** @type {any} */ arm) => arm.mass),
    parent,
    gravity,
    ...listsOf(arms),
    ...termsOf({ drag_per_mass: drag, pivot }),
  };
}

/**
 * @param {CompressionStream | DecompressionStream} stream @param {Uint8Array<ArrayBuffer>} bytes
 */
async function through(stream, bytes) {
  const writer = stream.writable.getWriter();
  writer.write(bytes).catch(() => {});
  writer.close().catch(() => {});
  const reader = stream.readable.getReader();
  const pieces = [];
  for (let total = 0; ; ) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(pieces).arrayBuffer());
    total += value.length;
    if (total > MOST_BYTES) throw new Error("a link that holds more than a scene has");
    pieces.push(value);
  }
}

/** @param {Uint8Array} bytes */
const lettersOf = (bytes) =>
  btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""))
    .replaceAll("+", "-")
    .replaceAll("/", "_")
    .replace(/=+$/, "");
/** @param {string} letters */
const bytesOf = (letters) =>
  Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (letter) =>
    letter.charCodeAt(0),
  );
/** @param {Uint8Array} bytes */
const parsed = (bytes) => JSON.parse(new TextDecoder().decode(bytes));

/** "#d=..." or "#j=...": needs no store. @param {Doc} doc */
export async function linkOf(doc) {
  const bytes = new TextEncoder().encode(JSON.stringify(sceneOf(doc)));
  if (!("CompressionStream" in globalThis)) return `#j=${lettersOf(bytes)}`;
  return `#d=${await pack(bytes)}`;
}

/** Letters for a link that hold some bytes, compressed. @param {Uint8Array<ArrayBuffer>} bytes */
export async function pack(bytes) {
  return lettersOf(await through(new CompressionStream("deflate-raw"), bytes));
}

/** The JSON that letters of a link hold. @param {string} letters */
export async function unpack(letters) {
  return parsed(await through(new DecompressionStream("deflate-raw"), bytesOf(letters)));
}

/** @type {Record<string, (rest: string, client: Client) => Answer>} */
const READERS = {
  s: (id, client) => client.scene(id),
  d: unpack,
  j: (letters) => parsed(bytesOf(letters)),
};

/**
 * The patch that a scene stands for; throws where it is not sound.
 * @param {Scene} scene @param {Client} client
 */
export async function readScene(scene, client) {
  return patchOf({ ...scene, request: await plain(scene.request, client) });
}

/**
 * The patch that a hash stands for, null without one; throws where it is damaged or the server has
 * no such scene.
 * @param {string} hash @param {Client} client
 */
export async function readLink(hash, client) {
  const [, kind, rest] = /^#([sdj])=(.+)$/.exec(hash) ?? [];
  if (!kind) return null;
  return readScene(await READERS[kind](rest, client), client);
}
