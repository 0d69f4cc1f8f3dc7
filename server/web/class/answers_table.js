// All answers of a room as a table for spreadsheets: each with its question, its unit and whether
// it is right, in words instead of codes; and what pupils are called on a screen that all see.
// Leaves to others: answers on the page (sheets.js, ask.js), the server's own table (/v1/classes).
// Invariant: what a pupil wrote is a text in every spreadsheet, never a formula.

import { MARKS, ownMarks } from "../drawers/kit/table_file.js";
import { answerWords, isRight } from "./answer.js";
import { HANGING, fromHanging } from "./scenes.js";

/**
 * What a pupil is called; a number where names are not to be seen.
 * @param {Room} room @param {number} number
 */
export function nameOf({ session, say, anonymous }, number) {
  const { nickname } = session.value(`pupils/${number}`) ?? {};
  return anonymous || !nickname ? say("class.pupil", { number }) : String(nickname);
}

/** A text as one cell, which no spreadsheet computes. @param {string} words */
function cell(words) {
  const sign = /(^|[;,\t\r\n])(?=[\s"]*[=+\-@\uff0b\uff0d\uff1d\uff20])/g;
  return `"${words.replace(sign, "$1'").replaceAll('"', '""')}"`;
}

/** @param {number} value @param {string} decimal */
const plain = (value, decimal) => String(Number(value.toPrecision(9))).replace(".", decimal);

/**
 * An answer as it is read: a number in the question's unit (angles in degrees), or words.
 * @param {Room} room @param {Question} question @param {any} value @param {string} decimal
 */
function valueCell(room, question, value, decimal) {
  const { kind } = question;
  if (kind === "angle") return plain(fromHanging(Number(value) + HANGING), decimal);
  return kind === "number"
    ? plain(Number(value), decimal)
    : cell(answerWords(room, question, value));
}

/**
 * An answer, and what it answers.
 * @typedef {{from: string, step: string, question: Question, pupil: number, answer: StepAnswer,
 * changed: string}} Given
 */

/**
 * The answers to a worksheet that a pupil has given.
 * @param {Session} session @param {ClassItem} item
 */
function ofSheet(session, { name, value, changed }) {
  const [, id, pupil] = name.split("/");
  /** @type {Sheet | null} */
  const sheet = session.value(`worksheets/${id}`);
  const steps = sheet?.steps ?? [];
  return value.answers.flatMap((/** @type {StepAnswer} */ answer) => {
    const step = steps.find((one) => one.id === answer.step);
    const question = step?.question ?? { kind: "text" };
    const named = { from: sheet?.title ?? id, step: step?.title || answer.step, question };
    return { ...named, pupil: Number(pupil), answer, changed };
  });
}

/** All answers of a room. @param {Session} session @returns {Given[]} */
function answersOf(session) {
  return [...session.items.values()].flatMap((item) => {
    const [kind, id, pupil] = item.name.split("/");
    if (kind === "handins") return ofSheet(session, item);
    if (kind !== "answers") return [];
    const solution = session.value(`solutions/${id}`);
    const asked = session.value(`questions/${id}`) ?? { kind: "text" };
    const question = { ...asked, ...solution, text: asked.text, kind: asked.kind };
    const { value, changed } = item;
    return { from: "", step: "", question, pupil: Number(pupil), answer: value, changed };
  });
}

/**
 * As a spreadsheet of the browser's language opens it, with the names that a screen may hide.
 * @param {Room} shown
 */
export function answersText(shown) {
  const room = { ...shown, anonymous: false };
  const { session, say } = room;
  const [decimal, between] = MARKS[ownMarks()];
  const heads = say("class.csv.heads").split("|").map(cell);
  const rows = answersOf(session).map(({ from, step, question, pupil, answer, changed }) => {
    const { kind, text = "", unit = "" } = question;
    const right = isRight(question, answer.value);
    const value = (/** @type {any} */ one) => valueCell(room, question, one, decimal);
    const tries = (answer.tries ?? []).map((one) => answerWords(room, question, one)).join("; ");
    return [
      ...[from, step, text, kind === "angle" ? "\u00b0" : unit, nameOf(room, pupil)].map(cell),
      ...[value(answer.value), right === null ? "" : String(Number(right))],
      ...[cell(tries), cell(changed)],
    ];
  });
  return `\ufeff${[heads, ...rows].map((row) => row.join(between)).join("\r\n")}\r\n`;
}
