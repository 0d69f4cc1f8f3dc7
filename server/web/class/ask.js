// The teacher asks: a question with its kind, what is right, the answers as they come in a
// histogram.
// Leaves to others: the pupils' side (ask_pupil.js), counting (the server's histograms).
// Invariant: pupils see what is right only once the teacher shows it.

import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { button, choice, settled, tick } from "../drawers/kit/kit.js";
import { answerWords, isRight } from "./answer.js";
import { bareScene } from "./scenes.js";
import { questionFields } from "./question_fields.js";

/** @typedef {import("./teach.js").Desk} Desk */

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

/**
 * A row of the histogram: words, a bar, a count. @param {string} words @param {number} count
 * @param {number} most @param {boolean} right
 */
function bar(words, count, most, right) {
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
 * @param {Room} room @param {Question} question @param {any} histogram @param {Solution | null}
 * solution
 */
function bars(room, question, { values, bins }, solution) {
  const { text } = room.app;
  const { choices = [], kind } = question;
  /** @type {{words: string, count: number, right: boolean}[]} */
  let rows;
  if (kind === "choice") {
    const counts = new Map(values.map((/** @type {any} */ one) => [one.value, one.count]));
    rows = choices.map((words, i) => ({
      words,
      count: Number(counts.get(i + 1) ?? 0),
      right: solution?.value === i + 1,
    }));
  } else if (bins.length) {
    const edge = (/** @type {number} */ value) =>
      answerWords(room, { kind, unit: "" }, Number(text.read(String(value)).toPrecision(4)));
    rows = bins.map((/** @type {any} */ { from, to, count }) => ({
      words: `${edge(from)} \u2013 ${edge(to)}`,
      count,
      right: Number(solution?.value) >= from && Number(solution?.value) <= to,
    }));
  } else {
    rows = values.map((/** @type {any} */ { value, count }) => ({
      words: answerWords(room, question, value),
      count,
      right: solution !== null && isRight({ ...question, ...solution, kind }, value) === true,
    }));
  }
  const most = Math.max(...rows.map(({ count }) => count), 1);
  return rows.map(({ words, count, right }) => bar(words, count, most, right));
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

/** @param {Asked} asked */
async function loadAnswers({ room, desk, id, count, list }) {
  const { session, say } = room;
  /** @type {Question | null} */
  const question = session.value(`questions/${id}`);
  if (!question) return;
  await desk.attempt(async () => {
    const histogram = await (await session.get(`histograms/${id}`)).json();
    count.textContent = say.count("class.answers", histogram.answers);
    const solution = session.value(`solutions/${id}`);
    list.replaceChildren(...bars(room, question, histogram, solution?.shown ? solution : null));
  });
}

/** @param {Room} room @param {Desk} desk */
function askedPart(room, desk) {
  const { session, say } = room;
  const words = h("p", { class: "question-text" });
  const count = h("p", { class: "counts", role: "status" });
  const list = h("ul", { class: "histogram" });
  const answer = h("p", { class: "quiet" });
  /** @type {Asked} */
  const asked = { room, desk, id: "", words, count, list, answer };
  const keys = keysOf(asked);
  const row = h("div", { class: "row" }, ...Object.values(keys));
  const place = h("div", { class: "asked", hidden: true }, words, answer, count, list, row);
  const soon = settled(() => loadAnswers(asked), 300);
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
      // a teacher's screen is what the beamer shows: what is right waits until it is shown
      const right = solution?.shown && { answer: answerWords(room, question, solution.value) };
      const current = session.value("stages/class")?.question === id;
      words.textContent = question.text ?? "";
      answer.textContent = right ? say("class.rightIs", right) : "";
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
