// The teacher asks: a question with its kind, what is right, the answers as they come in a
// histogram.
// Leaves to others: the pupils' side (ask_pupil.js).
// Invariant: pupils see what is right only once the teacher shows it.

import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { button, choice, later, tick } from "../drawers/kit/kit.js";
import { answerWords, isRight } from "./answer.js";
import { openDialog } from "./board.js";
import { HANGING, bareScene, fromHanging } from "./scenes.js";
import { questionFields } from "./question_fields.js";

/** @typedef {import("./teach.js").Desk} Desk */

const BINS = 12; // at most, of numbers
const DIFFERENT = 8; // numbers, up to which each has a bar of its own

/** An angle as it is read, degrees. @param {any} value */
const degreesOf = (value) => fromHanging(Number(value) + HANGING);

/** The numbers of the questions that there are, the newest last. @param {Session} session */
function numbersOf({ items }) {
  const ids = [...items.keys()].map((name) => /^questions\/q(\d+)$/.exec(name)?.[1]);
  return ids
    .filter(Boolean)
    .map(Number)
    .sort((a, b) => a - b);
}

/** @param {Room} room @param {Desk} desk */
function askForm(room, desk) {
  const { app, session, say, tell } = room;
  const fields = questionFields(room, {});
  const fault = h("p", { class: "fault", role: "alert" });
  const scene = tick(say("class.ask.scene"), false, () => {});
  async function ask() {
    fault.textContent = "";
    const read = fields.read();
    if (!read) return;
    const { value, tolerance, ...question } = read;
    const id = `q${(numbersOf(session).pop() ?? 0) + 1}`;
    const shown = scene.box.checked ? { scene: bareScene(app.store.get()) } : {};
    try {
      await session.put(`questions/${id}`, { ...question, ...shown });
      if (value !== undefined)
        await session.put(`solutions/${id}`, {
          value,
          ...(tolerance !== undefined && { tolerance }),
        });
      await desk.change({ question: id });
      tell(say("class.did.ask"));
      place.open = false;
    } catch (error) {
      fault.textContent = said(error, app.text);
    }
  }
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    ask();
  };
  const go = h(
    "button",
    { type: "submit", class: "button main", "data-class": "ask" },
    say("class.ask.go"),
  );
  const form = h(
    "form",
    { novalidate: true, on: { submit } },
    fields.element,
    scene.element,
    fault,
    h("div", { class: "row" }, go),
  );
  const place = h(
    "details",
    { class: "ask-form", "data-class": "askForm" },
    h("summary", {}, say("class.ask.new")),
    form,
  );
  return place;
}

/** A row of a histogram. @typedef {{words: string, count: number, right: boolean}} Bar */

/** Words, a bar, a count. @param {Bar} row @param {number} most */
function bar({ words, count, right }, most) {
  const line = h("span", { class: "bar" });
  line.style.setProperty("--share", String(count / Math.max(1, most)));
  return h(
    "li",
    { class: right ? "right" : null },
    h("span", { class: "bar-words" }, words),
    line,
    h("span", { class: "bar-count" }, String(count)),
  );
}

/**
 * Bins of a round width (1, 2 or 5 times a power of ten) around numbers: in which one a number
 * lies, and the lower edges of all. @param {number[]} values at least two that differ
 */
export function binsOf(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  for (let k = Math.floor(3 * Math.log10((high - low) / BINS)) - 1; ; k++) {
    const width = Number(`${[1, 2, 5][((k % 3) + 3) % 3]}e${Math.floor(k / 3)}`);
    // an edge that rounding has left a little below belongs to the bin above
    const whole = (/** @type {number} */ value) => Math.floor(value / width + 1e-9);
    const count = whole(high) - whole(low) + 1;
    if (count > BINS) continue;
    const edge = (/** @type {number} */ i) => Number(((whole(low) + i) * width).toPrecision(12));
    const edges = Array.from({ length: count + 1 }, (_, i) => edge(i));
    return { edges, at: (/** @type {number} */ value) => whole(value) - whole(low) };
  }
}

/**
 * How many numbers lie in each bin, in the units that are read.
 * @param {Text} text @param {Question} question @param {any[]} values @param {any} answer
 * @returns {Bar[]}
 */
function binned(text, { kind, unit = "" }, values, answer) {
  const read = kind === "angle" ? degreesOf : Number;
  const shown = values.map(read);
  const sign = kind === "angle" ? "\u00b0" : unit && ` ${unit}`;
  const { edges, at } = binsOf(shown);
  const right = answer === undefined ? NaN : at(read(answer));
  return edges.slice(1).map((to, i) => ({
    words: `${text.short(edges[i], 6)} \u2013 ${text.short(to, 6)}${sign}`,
    count: shown.filter((value) => at(value) === i).length,
    right: right === i,
  }));
}

/**
 * How many gave each answer; of many different numbers, how many lie in each bin.
 * @param {Room} room @param {Question} question @param {any[]} values
 * @param {Solution | null} solution @returns {Bar[]}
 */
function barsOf(room, question, values, solution) {
  const { choices = [], kind } = question;
  const whole = { ...question, ...solution, kind };
  /** @type {Map<any, number>} */
  const counts = new Map(kind === "choice" ? choices.map((_, i) => [i + 1, 0]) : []);
  for (const value of values) counts.set(value, (counts.get(value) ?? 0) + 1);
  const numbers = kind === "number" || kind === "angle";
  if (numbers && counts.size > DIFFERENT)
    return binned(room.app.text, question, values, solution?.value);
  const list = [...counts];
  if (numbers) list.sort(([a], [b]) => a - b);
  else if (kind === "text") list.sort(([, a], [, b]) => b - a);
  return list.map(([value, count]) => ({
    words: answerWords(room, question, value),
    count,
    right: solution !== null && isRight(whole, value) === true,
  }));
}

/**
 * The question that is asked now, or one before, while it is shown.
 * @typedef {{room: Room, desk: Desk, id: string, words: HTMLElement, count: HTMLElement, list:
 * HTMLElement, answer: HTMLElement}} Asked
 */

/** What can be done with it. @param {Asked} asked */
function keysOf(asked) {
  const { room, desk } = asked;
  const { session, say } = room;
  const question = () => session.value(`questions/${asked.id}`);
  const solution = () => session.value(`solutions/${asked.id}`);
  const close = () =>
    desk.attempt(() =>
      session.put(`questions/${asked.id}`, { ...question(), closed: !question()?.closed }),
    );
  const reveal = () =>
    desk.attempt(() => session.put(`solutions/${asked.id}`, { ...solution(), shown: true }));
  const away = () => desk.change({ question: undefined });
  const again = () => desk.change({ question: asked.id });
  return {
    close: button(say("class.ask.close"), close, { "data-class": "closeQuestion" }),
    reveal: button(say("class.ask.show"), reveal, { "data-class": "showSolution" }),
    away: button(say("class.ask.away"), away, { "data-class": "endQuestion" }),
    again: button(say("class.ask.again"), again),
  };
}

/**
 * The question as the class sees it: its words, how many have answered, what.
 * @param {Asked} asked
 */
function fillFace({ room, id, ...face }) {
  const { session, say } = room;
  /** @type {Question} */
  const question = session.value(`questions/${id}`);
  /** @type {Solution | null} */
  const solution = session.value(`solutions/${id}`);
  const values = [...session.items.values()]
    .filter(({ name }) => name.startsWith(`answers/${id}/`))
    .map(({ value }) => value.value);
  // a teacher's screen is what the beamer shows: what is right waits until it is shown
  const known = solution?.shown ? solution : null;
  const right = known && { answer: answerWords(room, question, known.value) };
  face.words.textContent = question.text ?? "";
  face.answer.textContent = right ? say("class.rightIs", right) : "";
  face.count.textContent = say.count("class.answers", values.length);
  const rows = barsOf(room, question, values, known);
  const most = Math.max(...rows.map(({ count }) => count), 1);
  face.list.replaceChildren(...rows.map((row) => bar(row, most)));
}

/**
 * The question over the whole screen, as it goes on.
 * @param {Room} room @param {HTMLElement} place @param {HTMLElement[]} parts of the place
 */
function openLarge(room, place, parts) {
  const dialog = openDialog(room, "bars", room.say("class.question"), ...parts);
  dialog.addEventListener("close", () => place.append(...parts));
}

/** @param {Room} room @param {Desk} desk */
function askedPart(room, desk) {
  const { session, say } = room;
  const words = h("p", { class: "question-text" });
  const count = h("p", { class: "counts", role: "status" });
  const list = h("ul", { class: "histogram" });
  const answer = h("p", { class: "quiet" });
  const face = h("div", {}, words, answer, count, list);
  /** @type {Asked} */
  const asked = { room, desk, id: "", words, count, list, answer };
  const keys = keysOf(asked);
  const large = button(say("class.wholeScreen"), () => openLarge(room, place, [face, row]), {
    "data-class": "largeQuestion",
  });
  const row = h("div", { class: "row" }, ...Object.values(keys), large);
  const place = h("div", { class: "asked", hidden: true }, face, row);
  const soon = later(() => session.value(`questions/${asked.id}`) && fillFace(asked));
  return {
    place,
    end: soon.end,
    /** @param {string} id @param {Set<string> | null} names */
    show(id, names) {
      const other = id !== asked.id;
      asked.id = id;
      /** @type {Question | null} */
      const question = id ? session.value(`questions/${id}`) : null;
      place.hidden = !question;
      if (!question) return;
      /** @type {Solution | null} */
      const solution = session.value(`solutions/${id}`);
      const current = session.value("stages/class")?.question === id;
      keys.close.textContent = say(question.closed ? "class.ask.open" : "class.ask.close");
      keys.reveal.hidden = !solution || solution.shown === true;
      keys.away.hidden = !current;
      keys.again.hidden = current;
      if (other || !names || [...names].some((name) => name.split("/")[1] === id)) soon();
    },
  };
}

/** @param {Room} room @param {Desk} desk */
export function mountAsk(room, desk) {
  const { session, say } = room;
  const bag = createBag();
  const asked = askedPart(room, desk);
  let chosen = "";
  const place = h("section", { class: "ask" }, h("h3", {}, say("class.ask")));
  const before = h("div", { class: "row" });
  place.append(askForm(room, desk), asked.place, before);
  let listed = "";

  /** @param {Set<string> | null} names */
  function show(names) {
    const ids = numbersOf(session).map((number) => `q${number}`);
    const current = session.value("stages/class")?.question ?? "";
    if (names?.has("stages/class") && current) chosen = current;
    if (!ids.includes(chosen)) chosen = current || (ids[ids.length - 1] ?? "");
    asked.show(chosen, names);
    const key = [chosen, ...ids].join(" ");
    if (key === listed) return;
    listed = key;
    before.replaceChildren();
    if (ids.length < 2) return;
    const options = ids.map((id) => ({
      value: id,
      words: (session.value(`questions/${id}`)?.text ?? id).slice(0, 60),
    }));
    const { element } = choice(say("class.ask.earlier"), options, chosen, (id) => {
      chosen = id;
      asked.show(id, null);
    });
    before.append(element);
  }
  bag(session.subscribe(show));
  bag(asked.end);
  show(null);
  return { place, destroy: bag.end };
}
