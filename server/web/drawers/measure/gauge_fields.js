// The ruler and the protractor in the drawer: whether they are there, their numbers to type, and
// what they read.
// Leaves to others: their handles on the stage (gauges.js).
// Invariant: what a hand can do on the stage can be typed here.

import { createBag, h } from "../../dom.js";
import { NUMBERS, rulerReads } from "./gauge_numbers.js";
import { FARTHEST } from "../../state.js";
import { readings } from "./gauge_words.js";
import { tick } from "../kit/kit.js";

/** @typedef {import("./gauge_numbers.js").Gauge} Gauge */

/** Why a number cannot stand there, "" where it can. @param {Text} text @param {number} value */
function faultOf(text, value) {
  if (!Number.isFinite(value)) return text("measure.noNumber");
  const most = text.short(FARTHEST, 7);
  return Math.abs(value) > FARTHEST ? text("measure.tooFar", { most }) : "";
}

/** A number that can be typed. @param {App} app @param {Gauge} gauge @param {number} i */
function field({ store, text, object }, gauge, i) {
  const name = NUMBERS[gauge][i];
  const change = () => {
    const value = text.read(input.value);
    const numbers = store.get().view[gauge];
    const wrong = faultOf(text, value);
    input.setAttribute("aria-invalid", String(Boolean(wrong)));
    if (wrong) return object(wrong);
    if (!numbers?.length) return;
    store.set({ view: { [gauge]: numbers.map((old, k) => (k === i ? value : old)) } });
  };
  const input = h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-number": name,
    on: { change },
  });
  const words = h("span", {}, text(`measure.number.${name}`));
  return { input, element: h("label", { class: "choice" }, words, input) };
}

/**
 * What a gauge reads, as rows.
 * @param {Text} text @param {Gauge} gauge @param {number[]} numbers
 */
function rowsOf(text, gauge, numbers) {
  /** @param {string} name @param {string} value */
  const row = (name, value) => [
    h("dt", {}, text(`measure.${name}`)),
    h("dd", { "data-read": name }, value),
  ];
  if (gauge === "protractor") return row("between", readings(text, gauge, numbers));
  const { across, up } = rulerReads(numbers);
  const metres = (/** @type {number} */ length) =>
    text("measure.metres", { length: text.number(length, 3) });
  return [
    ...row("length", readings(text, gauge, numbers)),
    ...row("across", metres(across)),
    ...row("up", metres(up)),
  ];
}

/** @param {App} app @param {Gauge} gauge */
function partOf(app, gauge) {
  const { store, text } = app;
  const there = tick(text(`measure.${gauge}`), store.get().view[gauge] !== null, (on) =>
    store.set({ view: { [gauge]: on ? [] : null } }),
  );
  there.box.dataset.measure = gauge;
  const fields = NUMBERS[gauge].map((_, i) => field(app, gauge, i));
  const read = h("dl", { class: "readout" });
  const numbers = h(
    "div",
    { class: "gauge-fields" },
    read,
    ...fields.map(({ element }) => element),
  );
  const show = () => {
    const values = store.get().view[gauge];
    there.box.checked = values !== null;
    numbers.hidden = !values?.length;
    if (!values?.length) return;
    fields.forEach(({ input }, i) => {
      input.defaultValue = text.short(values[i], 6);
      if (document.activeElement !== input) input.value = input.defaultValue;
      input.removeAttribute("aria-invalid");
    });
    read.replaceChildren(...rowsOf(text, gauge, values));
  };
  show();
  return { element: h("div", {}, there.element, numbers), show };
}

/** @param {App} app */
export function createGauges(app) {
  const bag = createBag();
  const [ruler, protractor] = [partOf(app, "ruler"), partOf(app, "protractor")];
  bag(
    app.store.subscribe(({ view }, before) => {
      if (view.ruler !== before.view.ruler) ruler.show();
      if (view.protractor !== before.view.protractor) protractor.show();
    }),
  );
  const hint = h("p", { class: "quiet" }, app.text("measure.gauges.hint"));
  return { element: h("div", {}, hint, ruler.element, protractor.element), destroy: bag.end };
}
