// The motion's numbers as files: a table for a pupil's spreadsheet, and the forms that programs
// read.
// Leaves to others: writing them (table_file.js, the server), where they stand (plots.js,
// share.js).
// Invariant: a program's file is the server's answer for the document as it is now; a table holds
// the motion that is shown, whole.

import { said } from "../../client.js";
import { h } from "../../dom.js";
import { isStatic } from "../../root.js";
import { request } from "../../state.js";
import { aborted, button, choice, needsServer, save } from "./kit.js";
import { MARKS, ownMarks, tableText } from "./table_file.js";

const FILES = [
  { name: "CSV", type: "text/csv", ending: "csv" },
  { name: "NPZ", type: "application/x-npz", ending: "npz" },
  { name: "MAT", type: "application/x-matlab-data", ending: "mat" },
];

/**
 * @param {App} app @param {{type: string, ending: string}} file @param {HTMLElement} status where
 * it is told
 */
async function saveNumbers({ client, store, text }, { type, ending }, status) {
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

/** @param {App} app @param {string} marks @param {HTMLElement} status */
function saveTable({ motion, text }, marks, status) {
  if (!motion.complete) {
    status.textContent = text("kit.waiting");
    return;
  }
  const blob = new Blob([tableText(motion, text, marks)], { type: "text/csv;charset=utf-8" });
  save(blob, "pendulum-table.csv");
  status.textContent = text("plots.saved", { name: "pendulum-table.csv" });
}

/**
 * Both, with what they are; status: where it is told.
 * @param {App} app @param {HTMLElement} status
 */
export function numbersAsFiles(app, status) {
  const { text } = app;
  const names = Object.keys(MARKS);
  const options = names.map((value) => ({ value, words: text(`table.marks.${value}`) }));
  const marks = choice(text("table.marks"), options, ownMarks(), () => {});
  const take = () => saveTable(app, marks.select.value, status);
  const files = FILES.map((file) =>
    button(file.name, () => saveNumbers(app, file, status), { "data-save": file.ending }),
  );
  const table = button(text("table.save"), take, { "data-save": "table" });
  const group = { class: "row", role: "group", "aria-label": text("table.raw") };
  return h(
    "div",
    { class: "number-files" },
    h("h3", {}, text("table.title")),
    h("p", { class: "quiet" }, text("table.hint")),
    h("div", { class: "row" }, marks.element, table),
    h("h3", {}, text("table.raw")),
    h("p", { class: "quiet" }, text("angles.interface")),
    ...(isStatic
      ? [files[0], needsServer(text, h("div", group, ...files.slice(1)))]
      : [h("div", group, ...files)]),
  );
}
