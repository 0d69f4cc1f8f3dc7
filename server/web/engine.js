// Who computes beside the server: the engine in a worker, asked first for what is quick, and for
// all that it can where no server answers.
// Leaves to others: the worker (engine_worker.js), asking the server (client.js).
// Invariant: an answer is a Response as the server's; null means that the server is to be asked;
// without an engine, or with one that does not come, every answer is null.

const OPERATIONS = ["trajectories", "forces", "modes", "trees", "tables", "trials", "equations"];
/** What takes longer, s by the engine's own estimate, is the server's. */
const QUICK = 0.05;

/**
 * What waits for an answer: the head makes a Response, further pieces go into its body.
 * @typedef {{
 *   settle: (reply: Response | null) => void, body: ReadableStreamDefaultController | null,
 * }} Waiting
 */

/** @param {Waiting} waiting @param {any} data @returns {boolean} whether that was the end of it */
function hear(waiting, { part, end, none }) {
  if (part instanceof Uint8Array) waiting.body?.enqueue(part);
  else if (part) {
    const stream = new ReadableStream({
      start(controller) {
        waiting.body = controller;
      },
    });
    waiting.settle(new Response(stream, { status: part.status, headers: part.fields }));
  }
  if (end) waiting.body?.close();
  if (none && waiting.body) waiting.body.error(new Error("broken"));
  else if (none) waiting.settle(null);
  return Boolean(end || none);
}

/** Begins the worker; resolves whether it is ready. @param {Worker} worker */
const started = (worker) =>
  new Promise((resolve) => {
    worker.addEventListener("message", ({ data }) => "ready" in data && resolve(data.ready));
    worker.addEventListener("error", () => resolve(false));
  });

/**
 * The operation of a route and its argument, null if the engine has none. The examples are the
 * server's where it is there: they cost it nothing.
 * @param {string} path @param {unknown} body @param {boolean} alone
 */
function operationOf(path, body, alone) {
  const [, , name, argument = ""] = path.split("/");
  if (typeof body === "string") return OPERATIONS.includes(name) && !argument ? { name } : null;
  return alone && name === "presets" ? { name, argument: decodeURIComponent(argument) } : null;
}

/** Null in a frame that is refused one: the server computes all. @returns {Worker | null} */
function workerOf() {
  try {
    return new Worker(new URL("engine_worker.js", import.meta.url), { type: "module" });
  } catch {
    return null;
  }
}

/** @returns {Engine} */
export function createEngine() {
  /** @type {Worker | null} */
  let worker = null;
  let ready = false;
  let last = 0;
  /** @type {Map<number, Waiting>} */
  const asked = new Map();

  function lose() {
    ready = false;
    worker?.terminate();
    for (const waiting of asked.values()) hear(waiting, { none: true });
    asked.clear();
  }

  async function begin() {
    if (worker || !("engine" in document.documentElement.dataset)) return;
    if (!(worker = workerOf())) return;
    worker.addEventListener("message", ({ data }) => {
      const waiting = asked.get(data.id);
      if (waiting && hear(waiting, data)) asked.delete(data.id);
    });
    worker.addEventListener("error", lose);
    ready = await started(worker);
    if (!ready) lose();
  }

  /** @param {string} path @param {RequestInit} options @param {boolean} alone */
  function answer(path, { body, headers, signal }, alone) {
    const asks = operationOf(path, body, alone);
    if (!ready || !asks) return Promise.resolve(null);
    const { Accept: accept } = /** @type {Record<string, string>} */ (headers ?? {});
    const id = ++last;
    const most = alone ? undefined : QUICK;
    const request = { operation: asks.name, argument: asks.argument, accept, body, most };
    return new Promise((resolve, reject) => {
      const stop = () => {
        const waiting = asked.get(id);
        if (!waiting) return;
        asked.delete(id);
        worker?.postMessage({ stop: id });
        const error = new DOMException("given up", "AbortError");
        waiting.body?.error(error);
        reject(error);
      };
      asked.set(id, { settle: resolve, body: null });
      signal?.addEventListener("abort", stop, { once: true });
      if (signal?.aborted) stop();
      else worker?.postMessage({ id, request, alone });
    });
  }

  return {
    begin,
    answer,
    get ready() {
      return ready;
    },
  };
}
