// Links that people read and write: /?length=1,1&theta=90,45 is a chain of two arms, let go at
// rest; /?example=kapitza is an example.
// Leaves to others: links that hold or name a scene (link.js), checking what was read (link.js).
// Invariant: lengths, masses, carriers, degrees from hanging, rad/s, m/s^2 and seconds, in the
// order of the arms; what is left out is as simple as can be.

import { foldedTheta, phiOf } from "./angles.js";
import { ROOT } from "./root.js";
import { isBeside, request } from "./state.js";

const LISTS = ["length", "mass", "parent", "theta", "omega"];
const ONES = ["gravity", "time"];
const MOST_ARMS = 1000;
const MOST_WRITTEN = 12; // arms of a link that is still read by people
const DIGITS = 6;
const STEP = 0.01;

const NUMBERS = [...LISTS, ...ONES];
const NAMES = [...NUMBERS, "example"];
const OTHERS = ["lang", "embed", "room", "sheet", "title"];
// What mail, search and newsletters put behind a link that they hand on: it is passed over.
const FOLLOWED = /^(utm_.*|mc_[ce]id|fbclid|gclid|msclkid)$/;

/** Whether an address names a motion so, or would. @param {string} search */
export function namesMotion(search) {
  return [...new URLSearchParams(search).keys()].some((name) => NAMES.includes(name.toLowerCase()));
}

/** The example that an address names (/?example=kapitza), or null. @param {string} search */
export function exampleIn(search) {
  const name = new URLSearchParams(search).get("example");
  return name && /^[a-z0-9-]{1,40}$/.test(name) ? name : null;
}

/**
 * What of an address that names a motion means nothing here, or is said twice; "" without any.
 * @param {string} search
 */
export function strangeOf(search) {
  /** @type {Set<string>} */
  const known = new Set([...(exampleIn(search) ? ["example"] : NUMBERS), ...OTHERS]);
  const strange = [...new URLSearchParams(search)].filter(
    ([name]) => !known.delete(name) && !FOLLOWED.test(name),
  );
  return namesMotion(search) ? strange.map((one) => one.join("=")).join(", ") : "";
}

/**
 * A link to this page that others open: who chose a language hands it on.
 * @param {Text} text @param {string} rest what stands behind the host: a path, a query, a hash
 * @param {string} language that the link is to have
 */
export function linkTo(text, rest, language = text.chosen()) {
  const at = rest.includes("#") ? rest.indexOf("#") : rest.length;
  const query = rest.slice(0, at);
  const tongue = language ? `${query.includes("?") ? "&" : "?"}lang=${language}` : "";
  return `${ROOT}${query}${tongue}${rest.slice(at)}`;
}

/** The address without it: what else it says stays. @param {Location | URL} from */
export function ownAddress(from) {
  const address = new URL(from.href);
  for (const name of NAMES) address.searchParams.delete(name);
  address.hash = "";
  return address.pathname + address.search;
}

/**
 * The numbers of a parameter, null without it; throws what cannot be read.
 * @param {URLSearchParams} asked @param {string} name
 */
function numbersOf(asked, name) {
  const words = asked.get(name);
  if (words === null) return null;
  const list = words.split(/[,;\s]+/).map((one) => (one === "" ? NaN : Number(one)));
  const most = ONES.includes(name) ? 1 : MOST_ARMS;
  if (!list.every(Number.isFinite) || list.length > most) throw new Error(`${name}=${words}`);
  return list;
}

/**
 * The request that an address names, null where it names none; throws what is not sound. One
 * number stands for all arms; of what is short the rest is as simple as can be.
 * @param {string} search @returns {MotionBody | null}
 */
export function readAddress(search) {
  if (!namesMotion(search) || exampleIn(search)) return null;
  const asked = new URLSearchParams(search);
  const read = (/** @type {string} */ name) => numbersOf(asked, name);
  const length = read("length") ?? [];
  const n = length.length;
  if (!n) throw new Error(strangeOf(search) || "length");
  const fill = (/** @type {string} */ name, /** @type {(k: number) => number} */ plain) => {
    const list = read(name) ?? [];
    if (list.length > n) throw new Error(`${name}=${asked.get(name)}`);
    const all = list.length === 1 && name !== "parent";
    return length.map((_, k) => (all ? list[0] : (list[k] ?? plain(k))));
  };
  const [gravity] = read("gravity") ?? [9.81];
  const [time] = read("time") ?? [20];
  const carriers = fill("parent", (k) => k);
  return {
    pendulum: { length, mass: fill("mass", () => 1), parent: carriers, gravity },
    initial: { phi: fill("theta", () => 0).map(phiOf), phid: fill("omega", () => 0) },
    times: { stop: time, step: STEP },
  };
}

/** @param {number[]} list @param {number} plain what need not be written */
function written(list, plain) {
  const words = list.map((value) => String(Number(value.toPrecision(DIGITS))));
  if (words.every((one) => one === String(plain))) return null;
  return words.every((one) => one === words[0]) ? words[0] : words.join(",");
}

/**
 * The readable address of a document, null where its pendulum has more than such a one can say;
 * its numbers have six digits.
 * @param {Doc} doc
 */
export function addressOf(doc) {
  const { pendulum, initial, times } = request(doc);
  const { length, mass = [], parent, gravity = 9.81, ...terms } = pendulum;
  const plain = !Object.keys(terms).length && !initial.cart && !times.start;
  if (!plain || length.length > MOST_WRITTEN || doc.ghosts.some(isBeside)) return null;
  const chain = parent.every((carrier, k) => carrier === k);
  const parts = {
    length: length.map((value) => String(Number(value.toPrecision(DIGITS)))).join(","),
    mass: written(/** @type {number[]} */ (mass), 1),
    parent: chain ? null : parent.join(","),
    theta: written(initial.phi.map(foldedTheta), 0),
    omega: written(initial.phid, 0),
    gravity: written([gravity], 9.81),
    time: written([times.stop], 20),
  };
  const told = Object.entries(parts).filter(([, words]) => words !== null);
  return `?${told.map(([name, words]) => `${name}=${words}`).join("&")}`;
}
