// The motion's numbers as files, in the forms that other programs read.
// Leaves to others: writing them (the server), where the buttons stand (plots.js, share.js).
// Invariant: what is saved is the server's answer for the document as it is now.

import { said } from "../client.js";
import { request } from "../state.js";
import { aborted, save } from "./kit.js";

export const FILES = [
  { name: "CSV", type: "text/csv", ending: "csv" },
  { name: "NPZ", type: "application/x-npz", ending: "npz" },
  { name: "MAT", type: "application/x-matlab-data", ending: "mat" },
];

/**
 * @param {App} app @param {{type: string, ending: string}} file @param {HTMLElement} status where
 * it is told
 */
export async function saveNumbers({ client, store, text }, { type, ending }, status) {
  status.textContent = text("kit.waiting");
  try {
    const body = { ...request(store.get()), output: ["phi", "phid", "lambda", "z", "energy"] };
    const { blob, name } = await client.file("/v1/trajectories", body, type);
    const called = name || `pendulum.${ending}`;
    save(blob, called);
    status.textContent = text("plots.saved", { name: called });
  } catch (error) {
    if (!aborted(error)) status.textContent = said(error, text);
  }
}
