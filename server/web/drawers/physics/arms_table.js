// All arms in a table: length, mass, angle and rate of each, changed in place, by typing or by the
// arrow keys.
// Leaves to others: what a number is and what setting it does (card.js), the slider (physics.js).
// Invariant: shows the start that the document has; a field that somebody types in stays.

import { FIELDS } from "../../card.js";
import { h } from "../../dom.js";

/** By how much an arrow key changes a number. @type {Record<string, number>} */
const STEPS = { length: 0.1, mass: 0.1, angle: 5, rate: 0.1 };
const MOST = 60; // arms that have a row
const COLUMNS = FIELDS.filter(({ name }) => STEPS[name]);

/**
 * @param {App} app @param {import("../../card.js").Field} field @param {number} arm
 * @param {HTMLInputElement} input @param {number} value
 */
function commit({ store, text, edits, object }, field, arm, input, value) {
  const least = field.least?.(store.get(), arm - 1) ?? -Infinity;
  const sound = Number.isFinite(value) && value >= least;
  input.setAttribute("aria-invalid", String(!sound));
  const what = text(`arm.${field.name}`);
  if (!sound) return object(text(least > 0 ? "arm.wrong.positive" : "arm.wrong", { what }));
  field.set(edits, arm, value);
}

/** @param {App} app @param {import("../../card.js").Field} field @param {number} arm */
function cellOf(app, field, arm) {
  const { text, store } = app;
  const label = text(`arm.${field.name}.unit`, { unit: field.unit });
  const input = h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-cell": `${field.name}-${arm}`,
    "aria-label": `${text("arm.name", { arm })}: ${label}`,
  });
  input.addEventListener("change", () => commit(app, field, arm, input, text.read(input.value)));
  input.addEventListener("keydown", ({ key }) => {
    const sign = { ArrowUp: 1, ArrowDown: -1 }[key];
    if (!sign) return;
    const value = field.get(store.get(), arm - 1) + sign * STEPS[field.name];
    commit(app, field, arm, input, Number(value.toPrecision(8)));
  });
  return input;
}

/** How many arms there are, to be changed. @param {App} app */
function countOf({ text, edits, store }) {
  const change = () => {
    const count = Math.min(Math.round(Number(input.value)), MOST);
    if (count > 0) edits.resize(count);
    input.value = String(store.get().pendulum.length.length);
  };
  const limits = { type: "number", min: 1, max: MOST, "data-arms": "count" };
  const input = h("input", { ...limits, on: { change } });
  return { input, label: h("label", { class: "inline" }, text("arms.count"), " ", input) };
}

/** @param {App} app */
export function createArmsTable(app) {
  const { text, store, edits } = app;
  const body = h("tbody");
  const heads = COLUMNS.map(({ name, unit }) =>
    h("th", { scope: "col" }, text(`arm.${name}`), " ", h("span", { class: "unit" }, unit)),
  );
  const table = h(
    "table",
    { class: "arms-table" },
    h("thead", {}, h("tr", {}, h("th", { scope: "col" }, text("arms.column")), ...heads)),
    body,
  );
  const { input: count, label } = countOf(app);
  /** @type {HTMLInputElement[][]} */
  let rows = [];

  /** @param {number} n */
  function build(n) {
    rows = Array.from({ length: Math.min(n, MOST) }, (_, k) =>
      COLUMNS.map((field) => cellOf(app, field, k + 1)),
    );
    const choose = (/** @type {number} */ arm) => () => edits.select(arm);
    body.replaceChildren(
      ...rows.map((cells, k) =>
        h(
          "tr",
          { on: { focusin: choose(k + 1) } },
          h("th", { scope: "row" }, String(k + 1)),
          ...cells.map((cell) => h("td", {}, cell)),
        ),
      ),
    );
  }
  return {
    element: h("div", { class: "scroll" }, label, table),
    show() {
      const doc = store.get();
      const n = doc.pendulum.length.length;
      count.value = String(n);
      if (rows.length !== Math.min(n, MOST)) build(n);
      rows.forEach((cells, k) => {
        COLUMNS.forEach((field, i) => {
          const shown = text.short(field.get(doc, k), 5);
          if (cells[i].defaultValue === shown) return;
          cells[i].defaultValue = shown;
          if (document.activeElement !== cells[i] || text.read(cells[i].value) !== text.read(shown))
            cells[i].value = shown;
        });
        body.rows[k].setAttribute("aria-current", String(doc.view.selected === k + 1));
      });
    },
  };
}
