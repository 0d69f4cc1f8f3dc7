// A fit on paper: the data, the model, the answer as it stands, how to cite.
// Leaves to others: the paper (report.js), what was found (fit_answer.js).
// Invariant: nothing is computed anew.

import { h } from "../../dom.js";

const CITED = "a simulation server for planar pendulum trees.";
const PAPER = "G. Meinsma: Planar Pendulums in Complex Coordinates.";

/** @param {Text} text @param {import("./fit_answer.js").Fitted} fitted
 * @param {string} table @param {HTMLElement} shown the answer */
export function paperOf(text, { body, answer, measured }, table, shown) {
  const made = new Date().toLocaleString(text.language, { dateStyle: "long", timeStyle: "short" });
  const [first] = /^(?:.*[\r\n]+){0,5}/.exec(table) ?? [""];
  const what = measured.series.map(({ kind, arm }) => text(`fits.role.${kind}`, { arm }));
  const copy = /** @type {HTMLElement} */ (shown.cloneNode(true));
  copy.querySelectorAll("button, input, label").forEach((one) => one.remove());
  copy.querySelectorAll("details").forEach((one) => one.setAttribute("open", ""));
  const part = (/** @type {string} */ head, /** @type {(Node | string)[]} */ ...parts) =>
    h("section", {}, h("h2", {}, head), ...parts);
  return h(
    "article",
    { class: "print-report", lang: text.language },
    h("h1", {}, `${text("fits.run")}: ${what.join(", ")}`),
    h("p", { class: "report-made" }, made),
    part(
      text("fits.paste"),
      h("pre", {}, `${first}\u2026`),
      text("fits.rows", { count: measured.t.length }),
    ),
    part(text("report.pendulum"), h("pre", {}, JSON.stringify({ ...body, data: undefined }))),
    part(text("fits.found"), copy),
    part(`pendulumd ${answer.stats.version}`, `The pendulumd authors: ${CITED} ${PAPER}`),
  );
}
