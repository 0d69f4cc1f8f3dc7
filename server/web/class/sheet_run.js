// A worksheet as a pupil works through it: step by step, what is to be done before the next one,
// hints, answers with the stage's state, handing in.
// Leaves to others: where answers are kept (the host: sheet_pupil.js, drawers/worksheet.js), the
// fields (answer.js).
// Invariant: an answer that was given is kept at once; a step is shown only when it may be seen.

import { h } from "../dom.js";
import { button } from "../drawers/kit/kit.js";
import { answerField, answerWords, isRight } from "./answer.js";
import { bareScene, stageScene } from "./scenes.js";
import { printSheet } from "./sheet_print.js";

const PATIENCE_MS = 700; // that an answer takes before it is told that it is on its way

/**
 * Who gives out the worksheet, and keeps what is answered.
 * @typedef {{
 *   room: Bench, sheet: Sheet, handin: Handin, save: (handin: Handin, done: boolean) =>
 *   Promise<unknown>,
 * }} Host
 */

/**
 * The worksheet while it is worked on; step: the id of the one that is shown.
 * @typedef {{
 *   host: Host, place: HTMLElement, list: HTMLElement, body: HTMLElement, mark: HTMLElement,
 *   answers: Map<string, StepAnswer>, step: string, done: boolean, read: Set<string>,
 * }} Run
 */

/** The steps that may be seen now. @param {Run} run */
const visible = ({ host: { sheet }, answers }) =>
  sheet.steps.filter(({ hidden_until }) => !hidden_until || answers.has(hidden_until));

/** Whether nothing more is to be done in a step. @param {Run} run @param {Step} step */
function isDone({ answers, read }, { id, question, needs = "nothing" }) {
  const answer = answers.get(id);
  if (!question) return read.has(id);
  if (!answer) return false;
  return needs !== "right" || isRight(question, answer.value) !== false;
}

/** Whether a step lets one on. @param {Run} run @param {Step} step */
function lets(run, step) {
  return !step.question || (step.needs ?? "nothing") === "nothing" || isDone(run, step);
}

/** The number of the first step that lets nobody past it. @param {Run} run */
function barrier(run) {
  const steps = visible(run);
  const at = steps.findIndex((step) => !lets(run, step));
  return at < 0 ? steps.length - 1 : at;
}

/** @param {Run} run @returns {Handin} */
function handinOf({ host: { sheet }, answers, done }) {
  const ids = sheet.steps.map(({ id }) => id);
  const given = [...answers.values()].sort((a, b) => ids.indexOf(a.step) - ids.indexOf(b.step));
  return { done, answers: given };
}

/** @param {Run} run @param {string} words */
function say(run, words) {
  run.mark.textContent = words;
  if (words) run.host.room.app.announce(words);
}

/** Shows a step and sets its stage. @param {Run} run @param {string} id @param {boolean} focus */
function go(run, id, focus = true) {
  const step = run.host.sheet.steps.find((one) => one.id === id);
  if (!step) return;
  run.step = id;
  const { app, session } = run.host.room;
  const frozen = session?.value("stages/class")?.frozen;
  if (step.scene && !frozen) stageScene(app, step.scene);
  show(run);
  const title = /** @type {HTMLElement | null} */ (run.body.querySelector("h3"));
  if (focus) title?.focus();
}

/** On to the next step, or the end. @param {Run} run @param {string} words of the step before */
function goOn(run, words) {
  const steps = visible(run);
  const at = steps.findIndex(({ id }) => id === run.step);
  if (at + 1 < steps.length) go(run, steps[at + 1].id);
  else show(run);
  say(run, words);
}

/** @param {Run} run @param {boolean} done */
async function save(run, done = run.done) {
  const { room, save: keep } = run.host;
  run.done = done;
  // where the server is away the answer waits for it
  const waits = setTimeout(() => say(run, room.say("class.sending")), PATIENCE_MS);
  try {
    await keep(handinOf(run), done);
    return true;
  } catch {
    say(run, room.say("sheet.notKept"));
    return false;
  } finally {
    clearTimeout(waits);
  }
}

/** @param {Run} run @param {Step} step @param {import("./answer.js").AnswerField} field */
async function answered(run, step, field) {
  const { room } = run.host;
  const value = field.read();
  if (value === undefined || !step.question) return;
  const scene = bareScene(room.app.store.get());
  run.answers.set(step.id, { step: step.id, value, scene });
  const steps = visible(run);
  const last = steps[steps.length - 1].id === step.id;
  const right = isRight(step.question, value);
  const through = lets(run, step);
  if (!(await save(run, run.done || (last && through)))) return;
  if (!through) {
    show(run);
    const hint = /** @type {HTMLDetailsElement | null} */ (run.body.querySelector("details"));
    if (hint) hint.open = true;
    return say(run, room.say("sheet.tryAgain"));
  }
  const verdict = right === null ? "" : room.say(right ? "sheet.wasRight" : "sheet.wasNot");
  goOn(run, last ? room.say("sheet.handedIn") : verdict || room.say("sheet.kept"));
}

/** @param {Run} run @param {Step} step */
function questionPart(run, step) {
  const { room, sheet } = run.host;
  const { question } = step;
  if (!question) return null;
  const field = answerField(room, question);
  const given = run.answers.get(step.id);
  if (given) field.set(given.value);
  const steps = visible(run);
  const last = steps[steps.length - 1].id === step.id;
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    answered(run, step, field);
  };
  const key = last ? "sheet.answerLast" : "sheet.answerOn";
  const attributes = { type: "submit", class: "button main", "data-sheet": "answer" };
  const go1 = h("button", { ...attributes, disabled: sheet.closed }, room.say(key));
  const words = h("p", { class: "question-text" }, question.text ?? "");
  const row = h("div", { class: "row" }, go1);
  return h("form", { novalidate: true, on: { submit } }, words, field.element, row);
}

/** Back, on, and the stage as the step has it. @param {Run} run @param {Step} step */
function keysOf(run, step) {
  const { room } = run.host;
  const steps = visible(run);
  const at = steps.indexOf(step);
  const stage =
    step.scene &&
    button(
      room.say("sheet.stage"),
      () => stageScene(room.app, /** @type {ClassScene} */ (step.scene)),
      { "data-sheet": "stage" },
    );
  const back = button(room.say("sheet.back"), () => go(run, steps[at - 1].id), {
    disabled: at === 0,
    "data-sheet": "back",
  });
  const on = () => {
    run.read.add(step.id);
    if (at + 1 < steps.length) return goOn(run, "");
    save(run, true).then((kept) => kept && goOn(run, room.say("sheet.handedIn")));
  };
  const last = at === steps.length - 1;
  const shut = !lets(run, step) || (last && Boolean(step.question));
  const next = button(room.say(last ? "sheet.handIn" : "sheet.next"), on, {
    disabled: shut,
    "data-sheet": "next",
  });
  return h("div", { class: "row ends" }, back, stage, next);
}

/** @param {Run} run */
function showList(run) {
  const { room } = run.host;
  const most = barrier(run);
  const keys = visible(run).map((step, i) => {
    const done = isDone(run, step);
    const number = h(
      "span",
      { class: "step-number", "aria-hidden": "true" },
      done ? "\u2713" : String(i + 1),
    );
    const attributes = {
      type: "button",
      "data-step": i + 1,
      class: done ? "step-key done" : "step-key",
      disabled: i > most,
      "aria-current": step.id === run.step ? "step" : null,
      on: { click: () => go(run, step.id) },
    };
    const said = done ? h("span", { class: "unseen" }, `, ${room.say("sheet.done")}`) : null;
    return h(
      "li",
      {},
      h("button", attributes, number, step.title || room.say("sheet.step", { step: i + 1 }), said),
    );
  });
  run.list.replaceChildren(...keys);
}

/** @param {Run} run */
function show(run) {
  const { room, sheet } = run.host;
  const step = sheet.steps.find(({ id }) => id === run.step);
  if (!step) return;
  showList(run);
  const steps = visible(run);
  const count = room.say("sheet.stepOf", { step: steps.indexOf(step) + 1, count: steps.length });
  const given = step.question && run.answers.get(step.id);
  const hint =
    step.hint && h("details", {}, h("summary", {}, room.say("sheet.hint")), h("p", {}, step.hint));
  const answer =
    given &&
    h(
      "p",
      { class: "quiet" },
      room.say("sheet.yourAnswer", {
        answer: answerWords(room, /** @type {Question} */ (step.question), given.value),
      }),
    );
  run.body.replaceChildren(
    h("p", { class: "quiet" }, count),
    h(
      "h3",
      { tabindex: -1 },
      step.title || room.say("sheet.step", { step: steps.indexOf(step) + 1 }),
    ),
    h("p", { class: "sheet-text" }, step.text ?? ""),
    ...[questionPart(run, step), answer, hint].filter((part) => part instanceof Node),
    keysOf(run, step),
  );
  if (run.done) say(run, room.say("sheet.handedIn"));
}

/** Arrows walk the list of steps. @param {HTMLElement} list @param {KeyboardEvent} event */
function walk(list, event) {
  const move = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  if (!move) return;
  event.preventDefault();
  event.stopPropagation();
  const keys = [...list.querySelectorAll("button:not(:disabled)")];
  const from = keys.findIndex((key) => key === document.activeElement);
  /** @type {HTMLElement} */ (keys[(from + move + keys.length) % keys.length]).focus();
}

/** A worksheet in a place of its own. @param {Host} host */
export function runSheet(host) {
  const { room, sheet, handin } = host;
  const list = h("ol", { class: "steps" });
  const body = h("div", { class: "step" });
  const mark = h("p", { class: "mark", role: "status" });
  const print = button(room.say("sheet.print"), () => printSheet(room, sheet, handinOf(run)), {
    "data-sheet": "print",
  });
  const nav = h("nav", { "aria-label": room.say("sheet.steps") }, list);
  const place = h("div", { class: "sheet" }, nav, mark, body, print);
  const answers = new Map(handin.answers.map((one) => [one.step, one]));
  /** @type {Run} */
  const run = {
    host,
    place,
    list,
    body,
    mark,
    answers,
    step: "",
    done: handin.done === true,
    read: new Set(),
  };
  list.addEventListener("keydown", (event) => walk(list, event));
  const open = sheet.steps[Math.min(barrier(run), sheet.steps.length - 1)];
  run.step = (visible(run).find((step) => !isDone(run, step)) ?? open).id;
  show(run);
  return {
    place,
    /** Sets the stage as the present step has it. */
    begin: () => go(run, run.step, false),
  };
}
