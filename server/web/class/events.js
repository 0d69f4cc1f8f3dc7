// A stream of server-sent events about a room, read by fetch: an EventSource cannot say who asks.
// Leaves to others: asking again (session.js), what the items mean.
// Invariant: a stream that is silent for longer than the server's comments are apart is given up,
// since a network that went away says nothing.

const SILENCE_MS = 40000; // the server writes at least every 15 s
const STALE_MS = 17000; // on coming back to the page, or to the network

/**
 * How a stream is opened, and who is told.
 * @typedef {{
 *   open: (signal: AbortSignal) => Promise<Response>, live: () => unknown,
 *   items: (items: ClassItem[]) => unknown, signal: AbortSignal,
 * }} Hearing
 */

/**
 * The events in a text, and its rest, which is not whole.
 * @param {string} text
 */
function parse(text) {
  const blocks = text.split(/\r?\n\r?\n/);
  const rest = blocks.pop() ?? "";
  const events = blocks.map((block) => {
    const event = { kind: "", data: "" };
    for (const line of block.split(/\r?\n/)) {
      const [, field, value] = /^(\w+): ?(.*)$/.exec(line) ?? [];
      if (field === "event") event.kind = value;
      if (field === "data") event.data += value;
    }
    return event;
  });
  return { events, rest };
}

/**
 * Gives the stream up where it is silent, and where somebody comes back to it who cannot know.
 * @param {AbortController} stop
 */
function watch(stop) {
  let heard = performance.now();
  const look = () => performance.now() - heard > SILENCE_MS && stop.abort();
  const back = () => performance.now() - heard > STALE_MS && stop.abort();
  const lost = () => stop.abort();
  const timer = setInterval(look, 5000);
  window.addEventListener("offline", lost);
  window.addEventListener("online", back);
  document.addEventListener("visibilitychange", back);
  return {
    hear() {
      heard = performance.now();
    },
    end() {
      clearInterval(timer);
      window.removeEventListener("offline", lost);
      window.removeEventListener("online", back);
      document.removeEventListener("visibilitychange", back);
    },
  };
}

/**
 * Reads one stream to its end; true where the server says that the room is gone.
 * @param {Hearing} hearing
 */
export async function readEvents({ open, live, items, signal }) {
  const stop = new AbortController();
  const end = () => stop.abort();
  signal.addEventListener("abort", end, { once: true });
  const watched = watch(stop);
  try {
    const reply = await open(stop.signal);
    watched.hear();
    live();
    const reader = /** @type {ReadableStream<Uint8Array>} */ (reply.body).getReader();
    const decoder = new TextDecoder();
    for (let text = ""; ; ) {
      const { done, value } = await reader.read();
      if (done) return false;
      watched.hear();
      const { events, rest } = parse(text + decoder.decode(value, { stream: true }));
      text = rest;
      items(events.filter(({ kind }) => kind === "item").map(({ data }) => JSON.parse(data)));
      if (events.some(({ kind }) => kind === "end")) return true;
    }
  } finally {
    watched.end();
    signal.removeEventListener("abort", end);
    stop.abort();
  }
}
