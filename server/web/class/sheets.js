// The teacher's worksheets: taken from those that come with the page, written anew, changed, handed
// out to the room or by a link; answers as they come.
// Leaves to others: writing them (sheet_editor.js), working on them (sheet_run.js).
// Invariant: what is handed out is what stands in the room.

import { linkTo } from "../address.js";
import { createBag, h } from "../dom.js";
import { button, choice, copyButton } from "../drawers/kit/kit.js";
import { pack } from "../link.js";
import { answerWords, isRight } from "./answer.js";
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

/** Who has answered what. @param {Room} room @param {string} id @param {Sheet} sheet */
function answersTable(room, id, sheet) {
  const { session, say } = room;
  const asked = sheet.steps.filter(({ question }) => question);
  const heads = asked.map(({ title, id: step }) => h("th", { scope: "col" }, title || step));
  /** @type {HTMLElement[]} */
  const rows = [];
  for (const { name, value } of session.items.values()) {
    const [kind, sheetId, pupil] = name.split("/");
    if (kind !== "handins" || sheetId !== id) continue;
    const cells = asked.map(({ id: step, question }) => {
      const answer = value.answers.find((/** @type {StepAnswer} */ one) => one.step === step);
      if (!answer || !question) return h("td", {}, "\u2013");
      const right = isRight(question, answer.value);
      const sign = right === null ? "" : right ? "\u2713 " : "\u2717 ";
      return h(
        "td",
        { class: right === false ? "wrong" : null },
        sign + answerWords(room, question, answer.value),
      );
    });
    const nickname = String(session.value(`pupils/${pupil}`)?.nickname ?? pupil);
    const done = value.done ? say("sheet.in") : "";
    rows.push(h("tr", {}, h("th", { scope: "row" }, nickname), h("td", {}, done), ...cells));
  }
  if (!rows.length) return h("p", { class: "quiet" }, say("sheet.noAnswers"));
  const name = (/** @type {HTMLElement} */ row) => row.firstElementChild?.textContent ?? "";
  rows.sort((a, b) => name(a).localeCompare(name(b)));
  const head = h("tr", {}, h("th", {}, say("sheet.pupil")), h("th", {}, ""), ...heads);
  return h(
    "div",
    { class: "scroll" },
    h("table", { class: "answers" }, h("thead", {}, head), h("tbody", {}, ...rows)),
  );
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
  const give = () => desk.change({ worksheet: given ? undefined : id });
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
