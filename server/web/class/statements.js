// What was answered, as xAPI statements (version 1.0.3, verbs and types of ADL): for the page that
// has a worksheet in a frame, and of a whole room for the teacher's file.
// Leaves to others: handing them over (embed.js, teach.js); a store of statements is asked nothing.
// Invariant: nobody is named: an actor is an account of this page, a pupil's number in a room or a
// number that the browser has drawn.

import { isRight } from "./answer.js";
import { ROOT } from "../root.js";

const VERBS = "http://adlnet.gov/expapi/verbs/";
const TYPES = "http://adlnet.gov/expapi/activities/";
/** How a kind of question is called there. @type {Record<string, string>} */
const KINDS = { number: "numeric", angle: "numeric", choice: "choice", text: "fill-in" };

/**
 * Who answers what, where and when; home: the address of the worksheet, without its steps.
 * @typedef {{
 *   actor: {homePage: string, name: string}, home: string, sheet: Sheet, when: string,
 * }} About
 */

/** A random UUID; crypto.randomUUID is for sealed connections alone. */
function uuid() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = (bytes[6] & 15) | 64;
  bytes[8] = (bytes[8] & 63) | 128;
  const digits = [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  return digits.replace(/^(.{8})(.{4})(.{4})(.{4})(.{12})$/, "$1-$2-$3-$4-$5");
}

/** Words in the worksheet's language. @param {Sheet} sheet @param {string} words */
const inLanguage = ({ language = "en" }, words) => ({ [language]: words });

/**
 * The definition of a question. @param {Sheet} sheet @param {Step} step
 * @param {Question} question
 */
function definitionOf(sheet, { id, title }, { kind, text = "", choices = [], value, tolerance }) {
  const most = tolerance ?? 0;
  const numeric = KINDS[kind] === "numeric";
  const right = numeric ? `${Number(value) - most}[:]${Number(value) + most}` : String(value);
  const listed = choices.map((words, i) => ({
    id: String(i + 1),
    description: inLanguage(sheet, words),
  }));
  return {
    type: `${TYPES}cmi.interaction`,
    name: inLanguage(sheet, title || id),
    description: inLanguage(sheet, text),
    interactionType: KINDS[kind] ?? "other",
    ...(listed.length && { choices: listed }),
    ...(value !== undefined && { correctResponsesPattern: [right] }),
  };
}

/** @param {About} about @param {string} verb @param {object} object @param {object} result */
const statementOf = ({ actor, when }, verb, object, result) => ({
  id: uuid(),
  actor: { objectType: "Agent", account: actor },
  verb: { id: VERBS + verb, display: { en: verb } },
  object: { objectType: "Activity", ...object },
  result,
  timestamp: when,
});

/** @param {Sheet} sheet */
const definitionOfSheet = (sheet) => ({
  type: `${TYPES}assessment`,
  name: inLanguage(sheet, sheet.title),
});

/** @param {About} about @param {StepAnswer} answer */
function answered(about, { step: id, value }) {
  const { sheet, home } = about;
  const step = sheet.steps.find((one) => one.id === id);
  if (!step?.question) return null;
  const right = isRight(step.question, value);
  const result = { response: String(value), ...(right !== null && { success: right }) };
  const object = { id: `${home}#${id}`, definition: definitionOf(sheet, step, step.question) };
  const whole = { objectType: "Activity", id: home, definition: definitionOfSheet(sheet) };
  const context = { platform: "pendulumd", contextActivities: { parent: [whole] } };
  return { ...statementOf(about, "answered", object, result), context };
}

/**
 * The end of a worksheet, with the share that was right. @param {About} about @param {Handin} given
 */
function completed(about, { answers }) {
  const { sheet, home } = about;
  const marks = sheet.steps.map(({ id, question }) =>
    question ? isRight(question, answers.find(({ step }) => step === id)?.value) : null,
  );
  const known = sheet.steps.filter(({ question }) => question?.value !== undefined).length;
  const raw = marks.filter((mark) => mark === true).length;
  const score = known ? { score: { scaled: raw / known, raw, min: 0, max: known } } : {};
  const object = { id: home, definition: definitionOfSheet(sheet) };
  const context = { platform: "pendulumd" };
  return { ...statementOf(about, "completed", object, { completion: true, ...score }), context };
}

/**
 * What has become of a worksheet since `before`: "answered" for each answer that is new or another,
 * "completed" when it is handed in.
 * @param {About} about @param {Handin} given @param {Handin} before
 */
export function statementsOf(about, given, before = { answers: [] }) {
  const known = new Map(before.answers.map(({ step, value }) => [step, value]));
  const fresh = given.answers.filter(({ step, value }) => known.get(step) !== value);
  const told = fresh.map((answer) => answered(about, answer)).filter((one) => one !== null);
  return given.done && (!before.done || fresh.length) ? [...told, completed(about, given)] : told;
}

/** All of a room, by whom and when the teacher's page has it. @param {Session} session */
export function statementsOfRoom({ entry, items }) {
  const room = `${ROOT}${entry?.code}`;
  const all = [...items.values()].filter(({ value }) => value);
  return all.flatMap(({ name, value, changed }) => {
    const [kind, id, pupil] = name.split("/");
    const who = { actor: { homePage: room, name: pupil ?? "" }, when: changed };
    if (kind === "handins") {
      const sheet = items.get(`worksheets/${id}`)?.value;
      const home = `${room}/worksheets/${id}`;
      return sheet ? statementsOf({ ...who, sheet, home }, value) : [];
    }
    const question = kind === "answers" && items.get(`questions/${id}`)?.value;
    if (!question) return [];
    const solution = items.get(`solutions/${id}`)?.value ?? {};
    const { value: right, tolerance } = solution;
    const step = { id, question: { ...question, value: right, tolerance } };
    const sheet = { title: room, steps: [step] };
    const about = { ...who, sheet, home: `${room}/questions` };
    return statementsOf(about, { answers: [{ step: id, value: value.value }] });
  });
}
