// The server's REST interface, as any page may use it: every request of this page is made here.
// Leaves to others: what to ask and what to show; words come from the texts (said).
// Invariant: asks no other host, and the engine in the browser first; a refusal with Retry-After
// (429, 503) is tried again, a request that was given up never.

import { createEngine } from "./engine.js";
import { bearer } from "./keep.js";
import { isStatic, urlOf } from "./root.js";

const TRIES = 6;
const LONGEST_WAIT = 20;

/**
 * Who asks: how the server is, who watches that, and who waits to try again.
 * @typedef {{
 *   state: {kind: string, retry: number}, watchers: Set<(state: {kind: string, retry: number}) =>
 *   unknown>,
 *   wakers: Set<() => unknown>, engine: Engine,
 * }} Asker
 */

/**
 * What went wrong: kind "refused" (a problem of the request), "busy" (429, 503), "away" (no
 * answer), "broken" (cut off), "static" (needs a server, and the page has none).
 */
export class Failure extends Error {
  /**
   * @param {string} kind @param {{status?: number, problem?: Problem | null, retry?: number}} more
   */
  constructor(kind, { status = 0, problem = null, retry = 0 } = {}) {
    super(problem?.detail ?? kind);
    this.kind = kind;
    this.status = status;
    this.problem = problem;
    this.retry = retry;
  }
}

/** Whether this is no failure: who asked has given it up. @param {unknown} error */
export const gaveUp = (error) => error instanceof Error && error.name === "AbortError";

/**
 * A failure in words, of the texts, which have them for every bundle of the page.
 * @param {any} failure @param {Text} text
 */
export const said = (failure, text) => text.said(failure);

/** @param {Response} reply @returns {Promise<Problem | null>} */
async function problemOf(reply) {
  try {
    const type = reply.headers.get("Content-Type") ?? "";
    return type.includes("json") ? await reply.json() : null;
  } catch {
    return null;
  }
}

/**
 * Waits so long, or until one of `wakers` is called.
 * @param {number} seconds @param {AbortSignal | null | undefined} signal @param {Set<() =>
 * unknown>} wakers
 */
function pause(seconds, signal, wakers) {
  return new Promise((resolve, reject) => {
    const end = (/** @type {() => void} */ settle) => {
      clearTimeout(timer);
      wakers.delete(wake);
      signal?.removeEventListener("abort", stop);
      settle();
    };
    const wake = () => end(() => resolve(null));
    const stop = () => end(() => reject(new DOMException("given up", "AbortError")));
    const timer = setTimeout(wake, seconds * 1000);
    wakers.add(wake);
    signal?.addEventListener("abort", stop, { once: true });
    if (signal?.aborted) stop();
  });
}

/**
 * Tells who watches how the server is: {kind: "well" | "busy" | "away" | "alone", retry}; alone:
 * the engine stands in for it.
 * @param {Asker} asker @param {string} kind @param {number} retry
 */
function report(asker, kind, retry = 0) {
  if (kind === asker.state.kind && retry === asker.state.retry) return;
  asker.state = { kind, retry };
  for (const watcher of asker.watchers) watcher(asker.state);
}

/** What a reply that is no success stands for. @param {Response} reply */
async function failureOf(reply) {
  const { status } = reply;
  const problem = await problemOf(reply);
  const retry = Number(reply.headers.get("Retry-After")) || 1;
  // a proxy whose server is gone answers 502 or 504, or a 503 that is not the server's own
  const gone = status === 503 && (!problem || problem.reachable === false);
  if (status === 502 || status === 504 || gone) return new Failure("away", { status });
  if (status === 429 || status === 503) return new Failure("busy", { status, problem, retry });
  return new Failure("refused", { status, problem });
}

/** The server's reply. @param {string} path @param {RequestInit} options */
async function sent(path, options) {
  try {
    return await fetch(urlOf(path), { ...options, headers: { ...options.headers, ...bearer() } });
  } catch (error) {
    if (gaveUp(error)) throw error;
    throw new Failure("away");
  }
}

/**
 * The engine's reply or the server's: the engine's where it is quick ("here"), or no server is
 * there ("alone").
 * @param {Asker} asker @param {string} path @param {RequestInit} options
 */
async function once({ engine }, path, options) {
  const quick = await engine.answer(path, options, false);
  if (quick?.ok) return { reply: quick, by: "here" };
  try {
    // what the engine refuses too: its limits are not the server's
    const reply = await sent(path, options);
    if (reply.ok) return { reply, by: "well" };
    throw await failureOf(reply);
  } catch (failure) {
    const away = failure instanceof Failure && failure.kind === "away";
    const reply = away ? await engine.answer(path, options, true) : null;
    if (reply?.ok) return { reply, by: "alone" };
    if (reply) throw await failureOf(reply);
    throw failure;
  }
}

/** @type {Promise<void> | null} */
let begun = null;

/** The engine's reply, where the page has no server. @param {Asker} asker @param {string} path
 * @param {RequestInit} options */
async function without({ engine }, path, options) {
  await (begun ??= engine.begin());
  const reply = await engine.answer(path, options, true);
  if (reply?.ok) return { reply, by: "here" };
  throw reply ? await failureOf(reply) : new Failure("static");
}

/** An answer has come. @param {Asker} asker @param {string} by whom (once) */
function answered(asker, by) {
  if (by === "well") return report(asker, by);
  // who waits for the server says so; a quick answer of the engine says nothing of it
  if (asker.wakers.size) return;
  const gone = by === "alone" || asker.state.kind === "alone" || asker.state.kind === "away";
  report(asker, gone ? "alone" : "well");
}

/** Whether another try would end like this one. @param {Failure} failure */
const isFinal = ({ kind }) => kind === "refused" || kind === "static";

/**
 * The reply, after as many tries as it takes; throws Failure, or AbortError where `signal` gave up.
 * @param {Asker} asker @param {string} path @param {RequestInit} options @param {number} longest
 * that one waits between two tries, s, unless one has asked too often
 */
async function ask(asker, path, options = {}, longest = LONGEST_WAIT) {
  for (let tried = 1; ; tried++) {
    try {
      const { reply, by } = await (isStatic ? without : once)(asker, path, options);
      answered(asker, by);
      return reply;
    } catch (failure) {
      if (!(failure instanceof Failure) || isFinal(failure)) throw failure;
      if (failure.kind === "busy" && tried >= TRIES) throw failure;
      // who waits together does not come again together
      const most = failure.status === 429 ? LONGEST_WAIT : longest;
      const wait = Math.min(failure.retry || 2 ** (tried - 1), most) * (1 + 0.25 * Math.random());
      report(asker, failure.kind, Math.ceil(wait));
      await pause(wait, options.signal, asker.wakers);
    }
  }
}

/**
 * @param {Asker} asker @param {string} path @param {object} body
 * @param {AskOptions & {accept?: string}} options
 */
function post(asker, path, body, { accept = "application/json", signal } = {}) {
  const headers = { "Content-Type": "application/json", Accept: accept };
  return ask(asker, path, { method: "POST", headers, body: JSON.stringify(body), signal });
}

/** The routes that answer JSON, by their names. @param {Asker} asker */
function routes(asker) {
  const answer =
    (/** @type {string} */ path) =>
    async (/** @type {object} */ body, /** @type {AskOptions} */ options = {}) =>
      (await post(asker, path, body, options)).json();
  const get = (/** @type {string} */ path, /** @type {AskOptions} */ { signal } = {}) =>
    ask(asker, path, { signal }).then((reply) => reply.json());
  return {
    trajectory: answer("/v1/trajectories"),
    forces: answer("/v1/forces"),
    modes: answer("/v1/modes"),
    trees: answer("/v1/trees"),
    tables: answer("/v1/tables"),
    trials: answer("/v1/trials"),
    ensembles: answer("/v1/ensembles"),
    equations: answer("/v1/equations"),
    storeScene: answer("/v1/scenes"),
    /** @param {string} id @param {AskOptions} [options] */
    scene: (id, options) => get(`/v1/scenes/${encodeURIComponent(id)}`, options),
    /** @param {AskOptions} [options] */
    presets: (options) => get("/v1/presets", options),
    /** @param {string} name @param {AskOptions} [options] */
    preset: (name, options) => get(`/v1/presets/${encodeURIComponent(name)}`, options),
  };
}

/**
 * A table of doubles, read while it arrives.
 *
 * reply    a reply that is on its way already; else the request is made.
 * begin begin(columns, stats), columns = [{name, count}, ...] in the order of a row; stats as the
 *   reply's head tells them,
 *          null where they are known only behind its body, where no page can read them.
 * rows     rows(values, count): count whole rows, valid during the call.
 * Resolves when all of it is here; "broken" if it was cut off.
 * @param {Asker} asker @param {string} path @param {object} body @param {TableOptions} options
 */
async function table(asker, path, body, { begin, rows, signal, reply: early = null }) {
  const reply =
    early ?? (await post(asker, path, body, { accept: "application/octet-stream", signal }));
  const columns = parseColumns(reply.headers.get("X-Columns") ?? "");
  begin(columns, parseStats(reply.headers));
  if (!reply.body) throw new Failure("broken");
  const width = columns.reduce((sum, { count }) => sum + count, 0);
  await readRows(reply.body.getReader(), width, rows);
}

/** @returns {Client} */
export function createClient() {
  /** @type {Asker} */
  const asker = {
    state: { kind: "well", retry: 0 },
    watchers: new Set(),
    wakers: new Set(),
    engine: createEngine(),
  };
  const hurry = () => [...asker.wakers].forEach((wake) => wake());
  window.addEventListener("online", hurry);
  return {
    get state() {
      return asker.state;
    },
    /** Those who wait to try again try now. */
    hurry,
    engine: asker.engine,
    /** fn({kind, retry}) whenever the server comes, goes or asks to wait. */
    watch(fn) {
      asker.watchers.add(fn);
      return () => asker.watchers.delete(fn);
    },
    ask: (path, options, longest) => ask(asker, path, options, longest),
    post: (path, body, options) => post(asker, path, body, options),
    ...routes(asker),
    /** A file of the answer: {blob, name}. */
    async file(path, body, accept, options = {}) {
      const reply = await post(asker, path, body, { ...options, accept });
      const name = /filename="?([^";]+)/.exec(reply.headers.get("Content-Disposition") ?? "")?.[1];
      return { blob: await reply.blob(), name: name ?? "" };
    },
    table: (path, body, options) => table(asker, path, body, options),
  };
}

/**
 * "t,phi[4],energy_total" as [{name: "t", count: 1}, {name: "phi", count: 4}, ...].
 * @param {string} header @returns {Column[]}
 */
export function parseColumns(header) {
  const all = header.matchAll(/([a-z_]+)(?:\[([\d,]+)\])?/g);
  const product = (/** @type {string} */ sizes) =>
    sizes.split(",").reduce((whole, size) => whole * Number(size), 1);
  return [...all].map(([, name, sizes = "1"]) => ({ name, count: product(sizes) }));
}

/**
 * {horizon, energy_drift, warnings} of a reply's header fields, null without them; method linear
 * has warnings alone.
 * @param {Headers} headers @returns {Stats | null}
 */
function parseStats(headers) {
  const number = (/** @type {string} */ name) =>
    headers.has(name) ? Number(headers.get(name)) : undefined;
  if (!headers.has("X-Horizon") && !headers.has("X-Warning")) return null;
  return {
    horizon: number("X-Horizon"),
    energy_drift: number("X-Energy-Drift"),
    warnings: headers.get("X-Warning"),
  };
}

/**
 * Hands whole rows of `width` doubles on as they arrive, each byte copied once.
 * @param {ReadableStreamDefaultReader<Uint8Array>} reader @param {number} width @param {(values:
 * Float64Array, count: number) => unknown} rows
 */
async function readRows(reader, width, rows) {
  const row = width * 8;
  let rest = new Uint8Array(0);
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      const bytes = new Uint8Array(rest.length + value.length);
      bytes.set(rest);
      bytes.set(value, rest.length);
      const count = Math.floor(bytes.length / row);
      if (count) rows(new Float64Array(bytes.buffer, 0, count * width), count);
      rest = bytes.slice(count * row);
    }
  } catch (error) {
    if (gaveUp(error)) throw error;
    throw new Failure("broken");
  }
  if (rest.length) throw new Failure("broken");
}
