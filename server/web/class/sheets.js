// The teacher's worksheets: taken from those that come with the page, written anew, changed, handed
// out to the room or by a link; answers as they come.
// Leaves to others: writing them (sheet_editor.js), working on them (sheet_run.js).
// Invariant: what is handed out is what stands in the room.

import { linkTo } from "../address.js";
import { createBag, h } from "../dom.js";
import { button, choice, copyButton } from "../drawers/kit/kit.js";
import { pack } from "../link.js";
import { answerWords, isRight } from "./answer.js";
import { nameOf } from "./answers_table.js";
import { openDialog } from "./board.js";
import { keyOf } from "./scenes.js";
import { editSheet } from "./sheet_editor.js";
import { printSheet } from "./sheet_print.js";
import { SHIPPED, shippedSheet } from "./shipped.js";

/** @typedef {import("./teach.js").Desk} Desk */

/** The worksheets of the room, by id. @param {Session} session @returns {[string, Sheet][]} */
const sheetsOf = ({ items }) =>
  [...items.values()]
    .filter(({ name }) => name.startsWith("worksheets/"))
    .map(({ name, value }) => [name.slice(11), value]);

/** An id that no worksheet of the room has. @param {Session} session @param {string} wanted */
function freeId({ items }, wanted) {
  for (let i = 1; ; i++) {
    const id = i === 1 ? wanted : `${wanted}-${i}`;
    if (!items.has(`worksheets/${id}`)) return id;
  }
}

/** What was asked in a step, with its unit. @param {Step} step */
function headOf({ id, title, question }) {
  const unit = question?.kind === "angle" ? "\u00b0" : question?.unit;
  const words = h("span", { class: "asked-words" }, question?.text ?? "");
  return h("th", { scope: "col" }, (title || id) + (unit ? `, ${unit}` : ""), words);
}

/**
 * An answer with whether it is right, and the tries before it.
 * @param {Room} room @param {Step} step @param {Handin} handin
 */
function cellOf(room, { id, question }, { answers }) {
  const answer = answers.find(({ step }) => step === id);
  if (!answer || !question) return h("td", {}, "\u2013");
  const right = isRight(question, answer.value);
  const sign = right === null ? "" : right ? "\u2713 " : "\u2717 ";
  const words = sign + answerWords(room, question, answer.value);
  const earlier = (answer.tries ?? []).map((value) => answerWords(room, question, value));
  const tries = earlier.length
    ? h("span", { class: "quiet" }, room.say("sheet.tries", { answers: earlier.join("; ") }))
    : null;
  return h("td", { class: right === false ? "wrong" : null }, words, tries);
}

/** How many answers to a step are right. @param {Step} step @param {Handin[]} handins */
function shareOf({ id, question }, handins) {
  const given = handins.flatMap(({ answers }) => answers.filter(({ step }) => step === id));
  const marks = given.map(({ value }) => question && isRight(question, value));
  const right = marks.filter((mark) => mark === true).length;
  return question?.value === undefined ? `${given.length}` : `${right} / ${given.length}`;
}

/** Who has answered what. @param {Room} room @param {string} id @param {Sheet} sheet */
function answersTable(room, id, sheet) {
  const { session, say } = room;
  const asked = sheet.steps.filter(({ question }) => question);
  /** @type {[number, Handin][]} */
  const handins = [...session.items.values()]
    .filter(({ name }) => name.startsWith(`handins/${id}/`))
    .map(({ name, value }) => [Number(name.split("/")[2]), value]);
  if (!handins.length) return h("p", { class: "quiet" }, say("sheet.noAnswers"));
  const named = handins.map(([pupil, value]) => ({ name: nameOf(room, pupil), value }));
  named.sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }));
  const rows = named.map(({ name, value }) => {
    const cells = asked.map((step) => cellOf(room, step, value));
    const done = value.done ? say("sheet.in") : "";
    return h("tr", {}, h("th", { scope: "row" }, name), h("td", {}, done), ...cells);
  });
  const all = handins.map(([, value]) => value);
  const shares = asked.map((step) => h("td", {}, shareOf(step, all)));
  const sum = h("tr", {}, h("th", { scope: "row" }, say("sheet.correct")), h("td", {}), ...shares);
  const heads = asked.map((step) => headOf(step));
  const head = h("tr", {}, h("th", {}, say("sheet.pupil")), h("th", {}, ""), ...heads);
  const body = [h("thead", {}, head), h("tbody", {}, ...rows), h("tfoot", {}, sum)];
  return h("div", { class: "scroll" }, h("table", { class: "answers" }, ...body));
}

/** How far the class may go. @param {Room} room @param {Desk} desk @param {Sheet} sheet */
function paceChoice({ session, say }, desk, { steps }) {
  const options = [
    { value: 0, words: say("sheet.pace.all") },
    ...steps.map((_, i) => ({ value: i + 1, words: say("sheet.step", { step: i + 1 }) })),
  ];
  const pace = session.value("stages/class")?.pace ?? 0;
  const set = (/** @type {string} */ value) => desk.change({ pace: Number(value) || undefined });
  const { element, select } = choice(say("sheet.pace"), options, pace, set);
  select.dataset.class = "pace";
  return element;
}

/** The answers over the page, as they come. @param {Room} room @param {string} id */
function openAnswers(room, id) {
  const { session, say } = room;
  const place = h("div", {});
  const show = () => {
    const sheet = session.value(`worksheets/${id}`);
    if (sheet) place.replaceChildren(answersTable(room, id, sheet));
  };
  const dialog = openDialog(room, "together", say("sheet.answers"), place);
  const end = session.subscribe(show);
  dialog.addEventListener("close", end);
  show();
}

/**
 * One worksheet and what can be done with it. @param {Room} room @param {Desk} desk @param
 * {string} id @param {Sheet} sheet
 */
function rowOf(room, desk, id, sheet) {
  const { app, session, say } = room;
  const given = session.value("stages/class")?.worksheet === id;
  const handins = [...session.items.values()].filter(({ name }) =>
    name.startsWith(`handins/${id}/`),
  );
  const done = handins.filter(({ value }) => value.done).length;
  const write = (/** @type {Sheet} */ changed) => session.put(`worksheets/${id}`, changed);
  // an old question would stand above the worksheet
  const begin = { worksheet: id, question: undefined, pace: undefined };
  const give = () => desk.change(given ? { worksheet: undefined, pace: undefined } : begin);
  const edit = () => editSheet(room, sheet, write);
  const link = async () => {
    const letters = await pack(new TextEncoder().encode(JSON.stringify(sheet)));
    return linkTo(app.text, `#w=${letters}`, sheet.language);
  };
  const remove = () => {
    if (confirm(say("sheet.remove.sure", { title: sheet.title })))
      desk.attempt(() => session.drop(`worksheets/${id}`));
  };
  return h(
    "li",
    { class: given ? "sheet-row given" : "sheet-row" },
    h("strong", {}, sheet.title),
    h("span", { class: "quiet" }, say("sheet.count", { count: handins.length, done })),
    h(
      "div",
      { class: "row" },
      button(say(given ? "sheet.takeBack" : "sheet.give"), give, {
        "data-give": id,
        class: given ? "button" : "button main",
      }),
      given ? paceChoice(room, desk, sheet) : null,
      button(say("sheet.answers"), () => openAnswers(room, id), { "data-answers": id }),
      button(say("sheet.edit"), edit, { "data-edit": id }),
      copyButton(app, say("sheet.link"), link),
      button(say("sheet.printRight"), () => printSheet(room, sheet, null)),
      button(say("sheet.remove"), remove),
    ),
  );
}

/** @param {Room} room @param {Desk} desk */
export function mountSheets(room, desk) {
  const { app, session, say } = room;
  const bag = createBag();
  const list = h("ul", { class: "plain" });
  let ours = SHIPPED[0];
  const options = SHIPPED.map((id) => ({ value: id, words: say(`sheet.ours.${id}`) }));
  const which = choice(say("sheet.fromOurs"), options, ours, (id) => {
    ours = id;
  });
  which.select.dataset.class = "ours";
  const take = button(
    say("sheet.take"),
    () =>
      desk.attempt(async () => {
        const sheet = await shippedSheet(ours, app.text.language);
        await session.put(`worksheets/${freeId(session, ours)}`, sheet);
      }),
    { "data-class": "takeSheet" },
  );
  const make = button(
    say("sheet.make"),
    () =>
      editSheet(room, null, (sheet) =>
        session.put(`worksheets/${freeId(session, "sheet")}`, sheet),
      ),
    { "data-class": "newSheet" },
  );
  const place = h(
    "section",
    {},
    h("h3", {}, say("sheet.title")),
    h("div", { class: "row" }, which.element, take, make),
    list,
  );
  let shown = "";
  function show() {
    const sheets = sheetsOf(session);
    const handins = [...session.items.values()].filter(({ name }) => name.startsWith("handins/"));
    const key = keyOf([
      sheets,
      session.value("stages/class")?.worksheet,
      session.value("stages/class")?.pace,
      handins.map(({ name, value }) => [name, value.done]),
    ]);
    if (key === shown) return;
    shown = key;
    list.replaceChildren(...sheets.map(([id, sheet]) => rowOf(room, desk, id, sheet)));
  }
  bag(session.subscribe(show));
  show();
  return { place, destroy: bag.end };
}
