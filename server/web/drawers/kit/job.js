// A computation that may be long: asked for as a job, whose progress is told until its results are
// here; at once where the server keeps no jobs.
// Leaves to others: what is asked and what is shown; refusals (client.js).
// Invariant: a job that nobody waits for any more is cancelled.

import { Failure, gaveUp } from "../../client.js";

const WAIT = 2; // s that the first answer may take before there is progress to tell
const PAUSE_MS = 500;

/** @param {AbortSignal} signal */
const pause = (signal) =>
  new Promise((resolve, reject) => {
    const stop = () => {
      clearTimeout(timer);
      reject(new DOMException("given up", "AbortError"));
    };
    const timer = setTimeout(() => {
      signal.removeEventListener("abort", stop);
      resolve(null);
    }, PAUSE_MS);
    signal.addEventListener("abort", stop, { once: true });
    if (signal.aborted) stop();
  });

/**
 * Waits for the end of a job.
 * @param {Client} client @param {any} job @param {AbortSignal} signal
 * @param {(share: number) => void} progress
 */
async function followed(client, job, signal, progress) {
  const path = `/v1/jobs/${job.id}`;
  let now = job;
  while (now.status === "accepted" || now.status === "running") {
    progress(now.progress / 100);
    await pause(signal);
    now = await (await client.ask(path, { signal })).json();
  }
  if (now.status === "successful") {
    const headers = { Accept: "application/json" };
    return (await client.ask(`${path}/results`, { signal, headers })).json();
  }
  throw new Failure("refused", { status: 422, problem: { detail: now.message } });
}

/**
 * The JSON of an answer, however long it takes; throws Failure, or AbortError where `signal` gave
 * up.
 * @param {Client} client @param {string} path @param {object} body @param {AbortSignal} signal
 * @param {(share: number) => void} progress told 0 ... 1 while it is under way
 */
export async function computed(client, path, body, signal, progress) {
  const headers = {
    "Content-Type": "application/json",
    Accept: "application/json",
    Prefer: `respond-async, wait=${WAIT}`,
  };
  const options = { method: "POST", headers, body: JSON.stringify(body), signal };
  const reply = await client.ask(path, options);
  if (reply.status !== 202) return reply.json();
  const job = await reply.json();
  try {
    return await followed(client, job, signal, progress);
  } catch (error) {
    if (gaveUp(error)) client.ask(`/v1/jobs/${job.id}`, { method: "DELETE" }).catch(() => {});
    throw error;
  }
}
