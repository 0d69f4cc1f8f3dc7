// The engine as a WebAssembly module: a request in, the bytes of its answer out.
// Leaves to others: when it is asked (engine_worker.js); how it computes (api/clients/browser).
// Invariant: what the module has not, and a module that fails, throws; the next request gets a new
// instance, as good as the first.

/** Progress of a computation, as api/call/call.h numbers it. */
const MORE = 0;
const DONE = 1;
/** From so many seconds on an answer is handed out while it is computed. */
const STREAMS = 0.5;

/** What is not computed here: a server is to be asked. */
export class Elsewhere extends Error {}

const refuse = (/** @type {string} */ name) => () => {
  throw new Elsewhere(name);
};

/**
 * What the module imports: of SHA-256 and advice about memory nothing is used, and nothing is freed
 * of what is never made; all else is not here.
 * @param {WebAssembly.Module} module
 */
function imports(module) {
  const idle = /^(nettle_sha256_\w+|madvise|(pend|api)_\w+_(free|clear))$/;
  /** @type {Record<string, Record<string, () => unknown>>} */
  const all = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    all[from] ??= {};
    all[from][name] = idle.test(name) ? () => 0 : refuse(name);
  }
  return all;
}

/** @param {any} door @param {number} at a text that ends with a NUL */
function textAt(door, at) {
  const bytes = new Uint8Array(door.memory.buffer, at);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}

/** @param {any} door @returns {Record<string, string>} the answer's header fields */
function headOf(door) {
  const at = door.door_head();
  if (!at) throw new Elsewhere("memory");
  const lines = textAt(door, at).split("\n").filter(Boolean);
  return Object.fromEntries(lines.map((line) => line.split(/: (.*)/s, 2)));
}

/** The bytes computed so far, taken away from the module. @param {any} door */
function take(door) {
  const bytes = new Uint8Array(door.memory.buffer, door.door_data(), door.door_bytes()).slice();
  door.door_taken();
  return bytes;
}

/** @param {any} door @param {EngineRequest} request */
function open(door, { operation, argument = "", accept = "application/json", body = "" }) {
  const bytes = new TextEncoder().encode(`${operation}\0${argument}\0${accept}\0${body}`);
  const room = door.door_room(bytes.length);
  if (!room) throw new Elsewhere("memory");
  new Uint8Array(door.memory.buffer, room, bytes.length).set(bytes);
  const progress = door.door_open();
  if (progress < 0) throw new Elsewhere(operation);
  return progress;
}

/**
 * An answer piece by piece: first its head {status, fields, cost}, then bytes.
 * @param {any} door @param {EngineRequest} request @returns {Generator<EngineHead | Uint8Array |
 * null>} null between pieces
 */
function* pieces(door, request) {
  let progress = open(door, request);
  const cost = progress === MORE ? door.door_cost() : 0;
  if (cost > (request.most ?? Infinity)) throw new Elsewhere("cost");
  const streams = cost > STREAMS;
  if (streams) {
    door.door_promise();
    yield { status: 200, fields: headOf(door), cost };
  }
  while (progress === MORE) {
    progress = door.door_run();
    yield streams && door.door_bytes() ? take(door) : null;
  }
  if (progress !== DONE) throw new Error("broken");
  if (!streams) yield { status: door.door_status(), fields: headOf(door), cost };
  if (door.door_bytes()) yield take(door);
  door.door_close();
}

/**
 * @param {WebAssembly.Module} module
 * @returns {{answer: (request: EngineRequest) => Generator<EngineHead | Uint8Array | null>}}
 */
export function createEngine(module) {
  /** @type {any} */
  let door = null;

  function* answer(/** @type {EngineRequest} */ request) {
    if (!door) {
      door = new WebAssembly.Instance(module, imports(module)).exports;
      door._initialize?.();
    }
    const own = door;
    door = null;
    yield* pieces(own, request);
    // one that has thrown is left behind
    door = own;
  }

  return { answer };
}
