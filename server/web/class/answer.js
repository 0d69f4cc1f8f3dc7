// The field of an answer: a number with its unit, a choice, an angle on the stage, a text.
// Leaves to others: what was asked, where the answer goes.
// Invariant: read() gives what the server takes (angles in rad, choices from 1), or undefined and
// says why.

import { h } from "../dom.js";
import { button } from "../drawers/kit/kit.js";
import { DEGREE, HANGING, fromHanging } from "./scenes.js";

let fields = 0;

/**
 * @typedef {{element: HTMLElement, read(): number | string | undefined, set(value: number |
 * string):
 * void}} AnswerField
 */

/** An answer in words. @param {Bench} room @param {Question} question @param {any} value */
export function answerWords({ app, say }, { kind, unit, choices }, value) {
  if (value === undefined || value === null) return "";
  if (kind === "choice") return choices?.[value - 1] ?? String(value);
  if (kind === "angle")
    return say("degrees", { angle: app.text.short(fromHanging(value + HANGING), 4) });
  if (kind === "number") return `${app.text.short(value, 6)}${unit ? ` ${unit}` : ""}`;
  return String(value);
}

/**
 * Whether an answer is right; null where nobody said what is. @param {Question} question @param
 * {any} value
 */
export function isRight({ kind, value: right, tolerance = 0 }, value) {
  if (right === undefined || value === undefined || value === null) return null;
  if (kind === "text")
    return String(value).trim().toLowerCase() === String(right).trim().toLowerCase();
  if (kind === "choice") return Number(value) === Number(right);
  const turn = 2 * Math.PI;
  const apart = Number(value) - Number(right);
  const far = kind === "angle" ? apart - turn * Math.round(apart / turn) : apart;
  return Math.abs(far) <= tolerance * (1 + 1e-9) + 1e-9;
}

/** @param {Bench} room @param {Question} question @param {Node[]} label @returns {AnswerField} */
function choiceField({ say, app }, { choices = [] }, label) {
  const name = `choice-${++fields}`;
  const radios = choices.map((_, i) =>
    h("input", { type: "radio", name, value: String(i + 1), "data-choice": i + 1 }),
  );
  const rows = radios.map((radio, i) => h("label", { class: "tick" }, radio, choices[i]));
  const element = h("fieldset", { class: "choices" }, h("legend", {}, ...label), ...rows);
  return {
    element,
    read() {
      const chosen = radios.findIndex(({ checked }) => checked);
      if (chosen < 0) app.object(say("class.wrong.choice"));
      return chosen < 0 ? undefined : chosen + 1;
    },
    set(value) {
      radios.forEach((radio, i) => {
        radio.checked = i + 1 === value;
      });
    },
  };
}

/** @param {Bench} room @param {Node[]} label @returns {AnswerField} */
function textField({ say, app }, label) {
  const area = h("textarea", { rows: 3, maxlength: 2000, "data-answer": "" });
  return {
    element: h("label", { class: "field wide" }, h("span", {}, ...label), area),
    read() {
      const typed = area.value.trim();
      if (!typed) app.object(say("class.wrong.text"));
      return typed || undefined;
    },
    set(value) {
      area.value = String(value);
    },
  };
}

/** The angle of the first arm as it is seen, from hanging, in degrees. @param {App} app */
function angleOnStage({ motion, clock, edits, store }) {
  const phi = edits.grabbed ? store.get().initial.phi[0] : motion.at(clock.time).phi[0];
  return fromHanging(phi);
}

/** @param {Bench} room @param {Question} question @param {Node[]} label @returns {AnswerField} */
function numberField({ app, say }, { kind, unit = "" }, label) {
  const angle = kind === "angle";
  const input = h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-answer": "",
  });
  const shown = h("span", { class: "unit" }, angle ? "\u00b0" : unit);
  const take = () => {
    input.value = app.text.short(angleOnStage(app), 4);
  };
  const field = h(
    "label",
    { class: "field" },
    h("span", {}, ...label),
    h("span", { class: "with-unit" }, input, shown),
  );
  const key = angle && button(say("class.takeAngle"), take, { "data-class": "angle" });
  return {
    element: h("div", { class: "answer-row" }, field, key),
    read() {
      // who writes the unit too means the same
      const typed = input.value.trim();
      const value = app.text.read(
        typed.endsWith(unit) ? typed.slice(0, typed.length - unit.length) : typed,
      );
      const sound = Number.isFinite(value);
      input.setAttribute("aria-invalid", String(!sound));
      if (!sound) app.object(say("class.wrong.number"));
      if (!sound) return undefined;
      return angle ? value * DEGREE : value;
    },
    set(value) {
      const plain = angle ? fromHanging(Number(value) + HANGING) : Number(value);
      input.value = app.text.short(plain, 6);
    },
  };
}

/** The field of a question's kind. @param {Bench} room @param {Question} question */
export function answerField(room, question) {
  // two fields on one page have two names for those who listen
  const asked = h("span", { class: "unseen" }, ` ${question.text ?? ""}`);
  const label = [h("span", {}, room.say(`class.answer.${question.kind}`)), asked];
  if (question.kind === "choice") return choiceField(room, question, label);
  if (question.kind === "text") return textField(room, label);
  return numberField(room, question, label);
}
