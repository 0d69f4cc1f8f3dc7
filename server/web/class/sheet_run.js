// A worksheet as a pupil works through it: step by step, what is to be done before the next one,
// hints, answers with the stage's state and earlier tries, handing in, what was right.
// Leaves to others: where answers are kept (the host: sheet_pupil.js, drawers/worksheet.js), the
// fields (answer.js).
// Invariant: an answer that was given is kept at once; a step is shown only when it may be seen;
// what is right is told when the worksheet says so.

import { h } from "../dom.js";
import { button } from "../drawers/kit/kit.js";
import { answerField, answerWords, isRight } from "./answer.js";
import { bareScene, stageScene } from "./scenes.js";
import { layOnPaper, printSheet } from "./sheet_print.js";

const PATIENCE_MS = 700; // that an answer takes before it is told that it is on its way
const MOST_TRIES = 20; // that are kept of an answer

/**
 * Who gives out the worksheet, and keeps what is answered; pace: how many steps are open.
 * @typedef {{
 *   room: Bench, sheet: Sheet, handin: Handin, save: (handin: Handin, done: boolean) =>
 *   Promise<unknown>, pace?: () => number | undefined,
 * }} Host
 */

/**
 * The worksheet while it is worked on; step: the id of the one that is shown; mine: what was on
 * the stage before; back: leads to that.
 * @typedef {{
 *   host: Host, place: HTMLElement, list: HTMLElement, body: HTMLElement, mark: HTMLElement,
 *   answers: Map<string, StepAnswer>, step: string, done: boolean, read: Set<string>,
 *   mine: Doc | null, back: HTMLElement,
 * }} Run
 */

/** The steps that may be seen now. @param {Run} run */
const visible = ({ host: { sheet }, answers }) =>
  sheet.steps.filter(({ hidden_until }) => !hidden_until || answers.has(hidden_until));

/** Whether nothing more is to be done in a step. @param {Run} run @param {Step} step */
function isDone({ host, answers, read }, { id, question, needs = "nothing" }) {
  const answer = answers.get(id);
  if (!question) return read.has(id);
  if (!answer) return false;
  // who is not told what is right cannot be kept from going on
  const later = (host.sheet.feedback ?? "at_once") !== "at_once";
  return later || needs !== "right" || isRight(question, answer.value) !== false;
}

/**
 * Whether the answer to a step is right, where that is told by now.
 * @param {Run} run @param {Step} step
 */
function verdictOf({ host, answers, done }, { id, question }) {
  const { feedback = "at_once" } = host.sheet;
  const told = feedback === "at_once" || (feedback === "at_end" && done);
  return told && question ? isRight(question, answers.get(id)?.value) : null;
}

/** Handed in, and how much of it is right, where that is told. @param {Run} run */
function handedIn(run) {
  const { room, sheet } = run.host;
  const known = sheet.steps.filter(({ question }) => question?.value !== undefined);
  const right = known.filter((step) => verdictOf(run, step)).length;
  const told = known.length > 0 && (sheet.feedback ?? "at_once") !== "never";
  if (!told) return room.say("sheet.handedIn");
  return room.say("sheet.handedInRight", { right, count: known.length });
}

/** Whether a step lets one on. @param {Run} run @param {Step} step */
function lets(run, step) {
  return !step.question || (step.needs ?? "nothing") === "nothing" || isDone(run, step);
}

/** The number of the last step that the teacher has opened. @param {Run} run */
const paceOf = ({ host }) => (host.pace?.() ?? Infinity) - 1;

/** The number of the first step that lets nobody past it. @param {Run} run */
function barrier(run) {
  const steps = visible(run);
  const at = steps.findIndex((step) => !lets(run, step));
  return Math.min(at < 0 ? steps.length - 1 : at, paceOf(run));
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
  const { frozen, follow } = session?.value("stages/class") ?? {};
  if (step.scene && !frozen && !follow) {
    if (!run.mine) run.mine = app.store.get();
    run.back.hidden = false;
    stageScene(app, step.scene);
  }
  show(run);
  const title = /** @type {HTMLElement | null} */ (run.body.querySelector("h3"));
  if (focus) title?.focus();
  // on a phone the field and its button may lie below the fold
  requestAnimationFrame(() =>
    run.body.querySelector("form .button.main")?.scrollIntoView({ block: "nearest" }),
  );
}

/** On to the next step, or the end. @param {Run} run @param {string} words of the step before */
function goOn(run, words) {
  const steps = visible(run);
  const at = steps.findIndex(({ id }) => id === run.step);
  const open = at + 1 <= paceOf(run);
  if (at + 1 < steps.length && open) go(run, steps[at + 1].id);
  else show(run);
  say(run, open ? words : `${words} ${run.host.room.say("sheet.waits")}`);
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

/**
 * Keeps an answer, the ones before it and the stage.
 * @param {Run} run @param {string} step @param {number | string} value
 */
function take({ host, answers }, step, value) {
  const scene = bareScene(host.room.app.store.get());
  const before = answers.get(step);
  const earlier = before && before.value !== value ? [before.value] : [];
  const tries = [...(before?.tries ?? []), ...earlier].slice(-MOST_TRIES);
  answers.set(step, { step, value, scene, ...(tries.length && { tries }) });
}

/** @param {Run} run @param {Step} step @param {import("./answer.js").AnswerField} field */
async function answered(run, step, field) {
  const { room } = run.host;
  const value = field.read();
  if (value === undefined || !step.question) return;
  take(run, step.id, value);
  const last = visible(run).at(-1)?.id === step.id;
  const through = lets(run, step);
  if (!(await save(run, run.done || (last && through)))) return;
  if (!through) {
    show(run);
    const hint = /** @type {HTMLDetailsElement | null} */ (run.body.querySelector("details"));
    if (hint) hint.open = true;
    return say(run, room.say("sheet.tryAgain"));
  }
  const right = verdictOf(run, step);
  const verdict = right === null ? "" : room.say(right ? "sheet.wasRight" : "sheet.wasNot");
  goOn(run, last ? `${verdict} ${handedIn(run)}`.trim() : verdict || room.say("sheet.kept"));
}

/** @param {Run} run @param {Step} step */
function questionPart(run, step) {
  const { room, sheet } = run.host;
  const { question } = step;
  if (!question) return null;
  const field = answerField(room, question);
  const given = run.answers.get(step.id);
  if (given) field.set(given.value);
  const last = visible(run).at(-1)?.id === step.id;
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
    save(run, true).then((kept) => kept && goOn(run, handedIn(run)));
  };
  const last = at === steps.length - 1;
  const waits = !last && at + 1 > paceOf(run);
  const shut = !lets(run, step) || waits || (last && Boolean(step.question));
  const next = button(room.say(last ? "sheet.handIn" : "sheet.next"), on, {
    disabled: shut,
    "data-sheet": "next",
  });
  const words = waits && h("p", { class: "quiet" }, room.say("sheet.waits"));
  return h("div", { class: "row ends" }, back, stage, next, words);
}

/** @param {Run} run */
function showList(run) {
  const { room } = run.host;
  const most = barrier(run);
  const keys = visible(run).map((step, i) => {
    const done = isDone(run, step);
    const right = verdictOf(run, step);
    const sign = right === false ? "\u2717" : right || (done && !step.question) ? "\u2713" : "";
    const shown = { class: "step-number", "aria-hidden": "true" };
    const number = h("span", shown, sign || String(i + 1));
    const attributes = {
      type: "button",
      "data-step": i + 1,
      class: `step-key${done ? " done" : ""}${right === false ? " wrong" : ""}`,
      disabled: i > most,
      "aria-current": step.id === run.step ? "step" : null,
      on: { click: () => go(run, step.id) },
    };
    const words = right === false ? "class.notRight" : "sheet.done";
    const said = done ? h("span", { class: "unseen" }, `, ${room.say(words)}`) : null;
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
  const words = (/** @type {any} */ value) =>
    answerWords(room, /** @type {Question} */ (step.question), value);
  const tries = given?.tries?.length
    ? ` ${room.say("sheet.tries", { answers: given.tries.map(words).join("; ") })}`
    : "";
  const told = given && room.say("sheet.yourAnswer", { answer: words(given.value) });
  const answer = told && h("p", { class: "quiet" }, told + tries);
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
  if (run.done) say(run, handedIn(run));
}

/** The teacher has opened other steps: what is typed stays. @param {Run} run */
function repace(run) {
  const step = run.host.sheet.steps.find(({ id }) => id === run.step);
  if (!step) return;
  showList(run);
  run.body.lastElementChild?.replaceWith(keysOf(run, step));
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
  const mine = () => {
    const { view, ...doc } = /** @type {Doc} */ (run.mine);
    room.app.store.set({ ...doc, view: { trails: view.trails, selected: 0 } }, { label: "open" });
    run.mine = null;
    back.hidden = true;
  };
  const back = button(room.say("sheet.mine"), mine, { hidden: true, "data-sheet": "mine" });
  const nav = h("nav", { "aria-label": room.say("sheet.steps") }, list);
  const ends = h("div", { class: "row" }, back, print);
  const place = h("div", { class: "sheet" }, nav, mark, body, ends);
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
    mine: null,
    back,
  };
  list.addEventListener("keydown", (event) => walk(list, event));
  // the browser's own print command prints the worksheet that is seen
  const paper = () => {
    if (!place.isConnected) window.removeEventListener("beforeprint", paper);
    else if (place.getClientRects().length) layOnPaper(room, sheet, handinOf(run));
  };
  window.addEventListener("beforeprint", paper);
  const open = sheet.steps[Math.min(barrier(run), sheet.steps.length - 1)];
  run.step = (visible(run).find((step) => !isDone(run, step)) ?? open).id;
  show(run);
  return {
    place,
    /** Sets the stage as the present step has it. */
    begin: () => go(run, run.step, false),
    /** Other steps may be open. */
    repace: () => repace(run),
  };
}
