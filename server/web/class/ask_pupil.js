// The teacher's question, as a pupil answers it.
// Leaves to others: the field (answer.js), the teacher's side (ask.js).
// Invariant: what is typed stays while the question is the same; an answer that is there is shown.

import { said } from "../client.js";
import { h } from "../dom.js";
import { button } from "../drawers/kit/kit.js";
import { answerField, answerWords, isRight } from "./answer.js";
import { bareScene, keyOf, stageScene } from "./scenes.js";

/**
 * What is right, once the teacher shows it.
 * @param {Room} room @param {Question} question @param {Solution | null} solution @param {any}
 * value
 */
function verdict(room, question, solution, value) {
  if (!solution) return "";
  const { say } = room;
  const right = isRight({ ...question, ...solution, kind: question.kind }, value);
  const parts = right === null ? [] : [say(right ? "class.right" : "class.notRight")];
  if (solution.value !== undefined)
    parts.push(say("class.rightIs", { answer: answerWords(room, question, solution.value) }));
  if (solution.text) parts.push(solution.text);
  return parts.join(" ");
}

/**
 * The question while it is shown.
 * @typedef {{
 *   room: Room, place: HTMLElement, status: HTMLElement, right: HTMLElement, shown: string,
 * }} Asked
 */

/**
 * @param {Asked} asked @param {string} id @param {Question} question
 * @param {import("./answer.js").AnswerField} field
 */
async function send({ room, status }, id, question, field) {
  const { app, session, say, tell } = room;
  const value = field.read();
  if (value === undefined) return;
  status.textContent = say("class.sending");
  try {
    await session.put(`answers/${id}`, { value, scene: bareScene(app.store.get()) });
    const words = say("class.sent", { answer: answerWords(room, question, value) });
    status.textContent = words;
    tell(words);
  } catch (error) {
    status.textContent = said(error, app.text);
  }
}

/** @param {Asked} asked @param {string} id @param {Question} question */
function formOf(asked, id, question) {
  const { room } = asked;
  const { app, session, say } = room;
  const field = answerField(room, question);
  const { scene } = question;
  const answer = session.value(`answers/${id}/${session.entry?.pupil}`);
  if (answer) field.set(answer.value);
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    send(asked, id, question, field);
  };
  const attributes = { type: "submit", class: "button main", "data-class": "answer" };
  const give = h("button", attributes, say("class.send"));
  const look = scene && button(say("class.toStage"), () => stageScene(app, scene));
  const row = h("div", { class: "row" }, give, look);
  return h("form", { novalidate: true, on: { submit } }, field.element, row);
}

/** @param {Asked} asked @param {string} id @param {Question} question @param {any} answer */
function build(asked, id, question, answer) {
  const { room, place, status, right } = asked;
  const { say } = room;
  const words = answer && say("class.sent", { answer: answerWords(room, question, answer.value) });
  status.textContent = words ?? "";
  place.replaceChildren(
    h("h3", {}, say("class.question")),
    h("p", { class: "question-text" }, question.text ?? ""),
    question.closed ? h("p", { class: "quiet" }, say("class.closed")) : formOf(asked, id, question),
    status,
    right,
  );
}

/** @param {Asked} asked */
function show(asked) {
  const { room, place, right } = asked;
  const { session } = room;
  const id = session.value("stages/class")?.question ?? "";
  /** @type {Question | null} */
  const question = id ? session.value(`questions/${id}`) : null;
  const key = question ? keyOf([id, question]) : "";
  const answer = session.value(`answers/${id}/${session.entry?.pupil}`);
  place.hidden = !question;
  if (question && key !== asked.shown) build(asked, id, question, answer);
  asked.shown = key;
  if (question)
    right.textContent = verdict(room, question, session.value(`solutions/${id}`), answer?.value);
}

/** @param {Room} room */
export function mountQuestion(room) {
  const place = h("section", { class: "question", hidden: true });
  const status = h("p", { class: "quiet", role: "status" });
  const right = h("p", { class: "right-answer" });
  /** @type {Asked} */
  const asked = { room, place, status, right, shown: "" };
  return { place, show: () => show(asked) };
}
