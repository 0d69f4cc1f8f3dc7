// The fields with which a teacher writes a question: its words, its kind, what is right.
// Leaves to others: where the question goes (ask.js, sheet_editor.js).
// Invariant: read() gives a question that the server takes, with what is right, or null and says
// what is missing.

import { h } from "../dom.js";
import { choice } from "../drawers/kit/kit.js";
import { DEGREE, HANGING, fromHanging } from "./scenes.js";

const KINDS = ["number", "choice", "angle", "text"];

/** A labelled field. @param {string} label @param {HTMLElement} field */
const labelled = (label, field) => h("label", { class: "field wide" }, h("span", {}, label), field);

/** What a right answer is, as it is typed. @param {Room} room @param {Question} question */
function typedValue({ app }, { kind, value }) {
  if (value === undefined) return "";
  if (kind === "angle") return app.text.short(fromHanging(Number(value) + HANGING), 6);
  return kind === "text" ? String(value) : app.text.short(Number(value), 8);
}

/**
 * The right answer and the tolerance, {} where nothing is typed, null where it is no number.
 * @param {Text} text @param {string} kind @param {string} typed @param {string} typedTolerance
 */
function rightOf(text, kind, typed, typedTolerance) {
  if (!typed.trim()) return {};
  if (kind === "text") return { value: typed.trim() };
  const factor = kind === "angle" ? DEGREE : 1;
  const value = text.read(typed) * factor;
  const tolerance = typedTolerance.trim() ? text.read(typedTolerance) * factor : 0;
  if (!Number.isFinite(value) || !(tolerance >= 0)) return null;
  if (kind === "choice") return Number.isInteger(value) ? { value } : null;
  return { value, tolerance };
}

/** A field of one line. @param {string} name @param {string} value */
const lineOf = (name, value) =>
  h("input", { type: "text", maxlength: 400, value, "data-question": name });

/** A field of some lines. @param {string} name @param {number} rows @param {string} value */
function areaOf(name, rows, value) {
  const area = h("textarea", { rows, maxlength: 3000, "data-question": name });
  area.value = value;
  return area;
}

/** The inputs, as a question has them first. @param {Room} room @param {Partial<Question>} first */
function inputsOf(room, first) {
  const { kind = "number", tolerance } = first;
  const off = tolerance && kind === "angle" ? tolerance / DEGREE : tolerance;
  return {
    words: areaOf("text", 2, first.text ?? ""),
    unit: lineOf("unit", first.unit ?? ""),
    choices: areaOf("choices", 3, (first.choices ?? []).join("\n")),
    right: lineOf("right", typedValue(room, { ...first, kind })),
    tolerance: lineOf("tolerance", off ? room.app.text.short(off, 6) : ""),
  };
}

/** @typedef {ReturnType<typeof inputsOf>} Inputs */

/**
 * The question that is written, or the field that is wrong and why.
 * @param {Text} text @param {string} kind @param {Inputs} inputs
 * @returns {Question | {field: HTMLElement, key: string}}
 */
function questionOf(text, kind, { words, unit, choices, right, tolerance }) {
  const asked = words.value.trim();
  if (!asked) return { field: words, key: "class.wrong.question" };
  const lines = choices.value.split("\n").map((line) => line.trim());
  const list = lines.filter(Boolean);
  if (kind === "choice" && (list.length < 2 || list.length > 12))
    return { field: choices, key: "class.wrong.choices" };
  const solution = rightOf(text, kind, right.value, tolerance.value);
  const beyond = kind === "choice" && !(Number(solution?.value ?? 1) <= list.length);
  if (!solution || beyond) return { field: right, key: "class.wrong.right" };
  const more = kind === "number" && unit.value.trim() ? { unit: unit.value.trim() } : {};
  return { text: asked, kind, ...more, ...(kind === "choice" && { choices: list }), ...solution };
}

/** @param {Room} room @param {Partial<Question>} first */
export function questionFields(room, first) {
  const { app, say } = room;
  let kind = first.kind ?? "number";
  const inputs = inputsOf(room, first);
  const rows = {
    unit: labelled(say("class.ask.unit"), inputs.unit),
    choices: labelled(say("class.ask.choices"), inputs.choices),
    right: labelled(say("class.ask.right"), inputs.right),
    tolerance: labelled(say("class.ask.tolerance"), inputs.tolerance),
  };
  const show = () => {
    rows.unit.hidden = kind !== "number";
    rows.choices.hidden = kind !== "choice";
    rows.tolerance.hidden = kind !== "number" && kind !== "angle";
    const label = /** @type {HTMLElement} */ (rows.right.firstChild);
    label.textContent = say(kind === "choice" ? "class.ask.rightChoice" : "class.ask.right");
  };
  const options = KINDS.map((value) => ({ value, words: say(`class.kind.${value}`) }));
  const kinds = choice(say("class.ask.kind"), options, kind, (value) => {
    kind = value;
    show();
  });
  kinds.select.dataset.question = "kind";
  show();
  const words = labelled(say("class.ask.text"), inputs.words);
  const fields = [words, kinds.element, ...Object.values(rows)];
  return {
    element: h("div", { class: "question-fields" }, ...fields),
    /** What the next question is likely to share with this one. @returns {Partial<Question>} */
    habits: () => (kind === "number" ? { kind, unit: inputs.unit.value } : { kind }),
    /** @returns {Question | null} */
    read() {
      for (const field of Object.values(inputs)) field.removeAttribute("aria-invalid");
      const read = questionOf(app.text, kind, inputs);
      if (!("field" in read)) return read;
      app.object(say(read.key));
      read.field.setAttribute("aria-invalid", "true");
      read.field.focus();
      return null;
    },
  };
}
