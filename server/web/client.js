// The server's REST interface, as any page may use it: every request of this page is made here.
// Leaves to others: what to ask and what to show; words come from the texts (said).
// Invariant: asks no other host; a refusal with Retry-After (429, 503) is tried again, a request that was given up never.

import { bearer } from "./keep.js";

const TRIES = 6;
const LONGEST_WAIT = 20;

/** What went wrong: kind "refused" (a problem of the request), "busy" (429, 503), "away" (no answer), "broken" (cut off). */
export class Failure extends Error {
  constructor(kind, { status = 0, problem = null, retry = 0 } = {}) {
    super(problem?.detail ?? kind);
    this.kind = kind;
    this.status = status;
    this.problem = problem;
    this.retry = retry;
  }
}

/** A failure in words, of the texts where it is the server's absence, else the server's own. */
export function said(failure, text) {
  if (failure.kind !== "refused")
    return text(`failure.${failure.kind}`, { status: failure.status });
  const faults = (failure.problem?.errors ?? []).map(
    (fault) => `${fault.pointer || "/"}: ${fault.detail}`,
  );
  const first = failure.problem?.detail ?? text("failure.refused", { status: failure.status });
  return faults.length ? faults.join("; ") : first;
}

async function problemOf(reply) {
  try {
    return (reply.headers.get("Content-Type") ?? "").includes("json") ? await reply.json() : null;
  } catch {
    return null;
  }
}

/** Waits so long, or until one of `wakers` is called. */
function pause(seconds, signal, wakers) {
  return new Promise((resolve, reject) => {
    const end = (settle) => {
      clearTimeout(timer);
      wakers.delete(wake);
      signal?.removeEventListener("abort", stop);
      settle();
    };
    const wake = () => end(resolve);
    const stop = () => end(() => reject(new DOMException("given up", "AbortError")));
    const timer = setTimeout(wake, seconds * 1000);
    wakers.add(wake);
    signal?.addEventListener("abort", stop, { once: true });
    if (signal?.aborted) stop();
  });
}

const gaveUp = (error) => error?.name === "AbortError";

export function createClient() {
  const watchers = new Set();
  const wakers = new Set();
  let state = { kind: "well", retry: 0 };

  /** Tells who watches how the server is: {kind: "well" | "busy" | "away", retry}. */
  function report(kind, retry = 0) {
    if (kind === state.kind && retry === state.retry) return;
    state = { kind, retry };
    for (const watcher of watchers) watcher(state);
  }

  async function once(path, options) {
    let reply;
    try {
      reply = await fetch(path, { ...options, headers: { ...options.headers, ...bearer() } });
    } catch (error) {
      if (gaveUp(error)) throw error;
      throw new Failure("away");
    }
    if (reply.ok) return reply;
    const problem = await problemOf(reply);
    const retry = Number(reply.headers.get("Retry-After")) || 1;
    // a proxy whose server is gone answers 502 or 504
    if (reply.status === 502 || reply.status === 504)
      throw new Failure("away", { status: reply.status });
    if (reply.status === 429 || reply.status === 503)
      throw new Failure("busy", { status: reply.status, problem, retry });
    throw new Failure("refused", { status: reply.status, problem });
  }

  /** The reply, after as many tries as it takes; throws Failure, or AbortError where `signal` gave up. */
  async function ask(path, options = {}) {
    for (let tried = 1; ; tried++) {
      try {
        const reply = await once(path, options);
        report("well");
        return reply;
      } catch (failure) {
        if (gaveUp(failure) || failure.kind === "refused") throw failure;
        if (failure.kind === "busy" && tried >= TRIES) throw failure;
        // who waits together does not come again together
        const wait =
          Math.min(failure.retry || 2 ** (tried - 1), LONGEST_WAIT) * (1 + 0.25 * Math.random());
        report(failure.kind, Math.ceil(wait));
        await pause(wait, options.signal, wakers);
      }
    }
  }

  function post(path, body, { accept = "application/json", signal } = {}) {
    const headers = { "Content-Type": "application/json", Accept: accept };
    return ask(path, { method: "POST", headers, body: JSON.stringify(body), signal });
  }

  const answer = (path) => async (body, options) => (await post(path, body, options)).json();
  const get =
    (path) =>
    async ({ signal } = {}) =>
      (await ask(path, { signal })).json();

  const hurry = () => [...wakers].forEach((wake) => wake());
  window.addEventListener("online", hurry);

  return {
    get state() {
      return state;
    },
    /** Those who wait to try again try now. */
    hurry,
    /** fn({kind, retry}) whenever the server comes, goes or asks to wait. */
    watch(fn) {
      watchers.add(fn);
      return () => watchers.delete(fn);
    },
    ask,
    post,
    trajectory: answer("/v1/trajectories"),
    forces: answer("/v1/forces"),
    modes: answer("/v1/modes"),
    trees: answer("/v1/trees"),
    ensembles: answer("/v1/ensembles"),
    equations: answer("/v1/equations"),
    storeScene: answer("/v1/scenes"),
    scene: (id, options) => get(`/v1/scenes/${encodeURIComponent(id)}`)(options),
    presets: get("/v1/presets"),
    preset: (name, options) => get(`/v1/presets/${encodeURIComponent(name)}`)(options),
    /** A file of the answer: {blob, name}. */
    async file(path, body, accept, options = {}) {
      const reply = await post(path, body, { ...options, accept });
      const name = /filename="?([^";]+)/.exec(reply.headers.get("Content-Disposition") ?? "")?.[1];
      return { blob: await reply.blob(), name: name ?? "" };
    },
    /**
     * A table of doubles, read while it arrives.
     *
     * reply    a reply or a promise of one that is on its way already; else the request is made.
     * begin    begin(columns, stats), columns = [{name, count}, ...] in the order of a row; stats as the reply's head tells them,
     *          null where they are known only behind its body, where no page can read them.
     * rows     rows(values, count): count whole rows, valid during the call.
     * Resolves when all of it is here; "broken" if it was cut off.
     */
    async table(path, body, { begin, rows, signal, reply: early = null } = {}) {
      const reply =
        early ?? (await post(path, body, { accept: "application/octet-stream", signal }));
      const columns = parseColumns(reply.headers.get("X-Columns") ?? "");
      begin(columns, parseStats(reply.headers));
      await readRows(
        reply.body.getReader(),
        columns.reduce((sum, { count }) => sum + count, 0),
        rows,
      );
    },
  };
}

/** "t,phi[4],energy_total" as [{name: "t", count: 1}, {name: "phi", count: 4}, ...]. */
export function parseColumns(header) {
  return header
    .split(",")
    .filter(Boolean)
    .map((part) => {
      const [, name, count] = /^([a-z_]+)(?:\[(\d+)\])?$/.exec(part.trim()) ?? [null, part, "1"];
      return { name, count: Number(count ?? 1) };
    });
}

/** {horizon, energy_drift, warnings} of a reply's header fields, null without them. */
function parseStats(headers) {
  if (!headers.has("X-Horizon")) return null;
  return {
    horizon: Number(headers.get("X-Horizon")),
    energy_drift: Number(headers.get("X-Energy-Drift")),
    warnings: headers.get("X-Warning"),
  };
}

/** Hands whole rows of `width` doubles on as they arrive, each byte copied once. */
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
