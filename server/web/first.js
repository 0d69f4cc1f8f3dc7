// The first request, made before the rest of the page is there: the motion that the page opens
// with.
// Leaves to others: reading it (motion.js). A link that names another motion, and a tab
// that has one to go on with, ask nothing here.
// Invariant: `early.body` is to the letter what motion.js would ask for the first document; it is
// asked once, whichever bundle of the page comes first.

import { namesMotion } from "./address.js";
import { bearer } from "./keep.js";
import { isStatic, urlOf } from "./root.js";
import { FIRST, request } from "./state.js";
import { exchanges } from "./terms.js";

export const OUTPUT = ["phi", "phid", "lambda", "energy"];

/** With work and heat where there are any, and the place of a cart. @param {Doc} doc */
function outputOf({ pendulum, method }) {
  const told = exchanges(pendulum) && method !== "symplectic" && method !== "linear";
  const cart = pendulum.pivot?.cart;
  return told || cart
    ? [...OUTPUT, ...(told ? ["exchange"] : []), ...(cart ? ["cart"] : [])]
    : OUTPUT;
}

/** @param {Doc} doc @param {State} [initial] */
export const motionBody = (doc, initial) => ({
  ...request(doc, initial),
  output: outputOf(doc),
});

/**
 * The reply, whose bytes are read as they come and not when they are wanted: the first frame has
 * them then.
 * @param {Response} answer
 */
function eager({ body, headers }) {
  const reader = /** @type {ReadableStream<Uint8Array>} */ (body).getReader();
  const start = async (/** @type {ReadableStreamDefaultController} */ controller) => {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return controller.close();
      controller.enqueue(value);
    }
  };
  return new Response(new ReadableStream({ start }), { headers });
}

/** @returns {{body: string, reply: Promise<Response | null>} | null} */
function ask() {
  const kept = Boolean(history.state?.["pendulumd.entry"]);
  if (isStatic || location.hash.length > 1 || kept || namesMotion(location.search)) return null;
  const body = JSON.stringify(motionBody(FIRST));
  const headers = {
    "Content-Type": "application/json",
    Accept: "application/octet-stream",
    ...bearer(),
  };
  const reply = fetch(urlOf("/v1/trajectories"), { method: "POST", headers, body }).then(
    (answer) => (answer.ok ? eager(answer) : null),
    () => null,
  );
  return { body, reply };
}

const ASKED = Symbol.for("pendulumd.first");
const shared = /** @type {Record<symbol, ReturnType<typeof ask>>} */ (globalThis);
if (!(ASKED in globalThis)) shared[ASKED] = ask();

export const early = shared[ASKED];
