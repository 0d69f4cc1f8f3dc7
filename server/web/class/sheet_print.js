// A worksheet on paper: all of its steps, with the answers that were given, or with what is right.
// Leaves to others: the paper (the browser), the look (class.css).
// Invariant: the page is as it was when the printing is over.

import { h } from "../dom.js";
import { answerWords } from "./answer.js";

/**
 * What stands below a question: the answer, or a line to write on. @param {Bench} room @param
 * {Step} step @param {Handin | null} handin
 */
function answerOf(room, { id, question }, handin) {
  if (!question) return null;
  const given = handin?.answers.find((answer) => answer.step === id)?.value;
  const value = handin ? given : question.value;
  if (value === undefined) return h("p", { class: "print-line" });
  const words = { answer: answerWords(room, question, value) };
  const key = handin ? "sheet.yourAnswer" : "class.rightIs";
  return h("p", { class: "print-answer" }, room.say(key, words));
}

/** @param {Bench} room @param {Step} step @param {number} i @param {Handin | null} handin */
function stepOf(room, step, i, handin) {
  const { title = "", text = "", question } = step;
  const choices = (question?.choices ?? []).map((words) => h("li", {}, words));
  return h(
    "section",
    {},
    h("h2", {}, `${i + 1}. ${title}`),
    h("p", {}, text),
    question ? h("p", { class: "print-question" }, question.text ?? "") : null,
    choices.length ? h("ol", {}, ...choices) : null,
    answerOf(room, step, handin),
  );
}

/**
 * Lays the worksheet on paper for the print that begins, unless something else lies there: with a
 * pupil's answers, or with what is right (null).
 * @param {Bench} room @param {Sheet} sheet @param {Handin | null} handin
 */
export function layOnPaper(room, sheet, handin) {
  if (document.body.matches(".printing, .reporting")) return;
  const steps = sheet.steps.map((step, i) => stepOf(room, step, i, handin));
  const paper = h(
    "article",
    { class: "print-sheet", lang: sheet.language },
    h("h1", {}, sheet.title),
    ...steps,
  );
  const end = () => {
    paper.remove();
    document.body.classList.remove("printing");
  };
  document.body.append(paper);
  document.body.classList.add("printing");
  window.addEventListener("afterprint", end, { once: true });
}

/** @type {typeof layOnPaper} */
export function printSheet(...what) {
  layOnPaper(...what);
  window.print();
}
