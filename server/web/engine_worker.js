// The engine in a worker: requests come as messages, their answers go back in pieces.
// Leaves to others: what is asked of it (engine.js), the module (engine_module.js).
// Invariant: a long answer gives way to other messages many times a second, so that it can be given
// up.

import { createEngine, Elsewhere } from "./engine_module.js";

const SLICE_MS = 20;
/** Their last digits are those of a C library, other than the server's: for want of a server. */
const NEAR = ["ode23", "linear"];

const module = WebAssembly.compileStreaming(fetch(new URL("engine.wasm", import.meta.url)));
const engine = module.then(createEngine);
/** @type {Set<number>} */
const stopped = new Set();

const pause = () =>
  new Promise((resolve) => {
    setTimeout(resolve);
  });

/** @param {EngineRequest} request @param {boolean} alone no server is there */
function refuseNear({ body }, alone) {
  if (!alone && body && NEAR.includes(JSON.parse(body).method)) throw new Elsewhere("digits");
}

/** @param {{id: number, request: EngineRequest, alone: boolean}} asked */
async function answer({ id, request, alone }) {
  const { answer: begin } = await engine;
  refuseNear(request, alone);
  let until = performance.now() + SLICE_MS;
  for (const part of begin(request)) {
    if (part) postMessage({ id, part });
    if (performance.now() < until) continue;
    await pause();
    until = performance.now() + SLICE_MS;
    if (stopped.delete(id)) return;
  }
  postMessage({ id, end: true });
}

addEventListener("message", ({ data }) => {
  if (data.stop) {
    stopped.add(data.stop);
    return;
  }
  answer(data)
    .catch(() => postMessage({ id: data.id, none: true }))
    .finally(() => stopped.delete(data.id));
});

engine.then(
  () => postMessage({ ready: true }),
  () => postMessage({ ready: false }),
);
