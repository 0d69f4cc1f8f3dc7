// The editor of a worksheet: its title and steps as forms, in an order that buttons change.
// Leaves to others: the fields of a question (question_fields.js), where the worksheet goes.
// Invariant: a step keeps its id, so that answers stay with it; nothing is written before "Save"; a
// new step asks and needs what the one before it does.

import { said } from "../client.js";
import { h, iconButton } from "../dom.js";
import { button, choice } from "../drawers/kit/kit.js";
import { createMini } from "../drawers/kit/mini.js";
import { openDialog } from "./board.js";
import { questionFields } from "./question_fields.js";
import { bareScene } from "./scenes.js";
import { poseOf } from "./wall.js";

const NEEDS = ["nothing", "answer", "right"];
const FEEDBACK = ["at_once", "at_end", "never"];
const MOST_STEPS = 50;

/**
 * A step while it is written.
 * @typedef {{
 *   id: string, element: HTMLElement, number: HTMLElement, read(): Step | null,
 *   habits(): Partial<Draft>,
 * }} Part
 */

/** A step before it is written, whose question may have only a kind. */
/** @typedef {Omit<Step, "question"> & {question?: Partial<Question>}} Draft */

/**
 * @typedef {{room: Room, parts: Part[], list: HTMLElement, fault: HTMLElement}} Editor
 */

/** @param {string} label @param {HTMLElement} field */
const labelled = (label, field) => h("label", { class: "field wide" }, h("span", {}, label), field);

/** @param {string} name @param {string} value @param {number} rows */
function areaOf(name, value, rows) {
  const area = h("textarea", { rows, maxlength: 4000, "data-step-field": name });
  area.value = value;
  return area;
}

/** The stage that a step sets. @param {Room} room @param {ClassScene | undefined} first */
function scenePart(room, first) {
  const { app, say } = room;
  let scene = first;
  const picture = h("span", { class: "scene-picture" });
  const clear = button(say("sheet.scene.none"), () => set(undefined));
  const take = button(say("sheet.scene.take"), () => set(bareScene(app.store.get())), {
    "data-step-field": "scene",
  });
  /** @param {ClassScene | undefined} value */
  async function set(value) {
    scene = value;
    const pose = value ? await poseOf(app, value) : null;
    const mini =
      pose && createMini(pose.tree, { width: 90, height: 70, label: say("sheet.scene") });
    picture.replaceChildren(mini ? mini.canvas : say("sheet.scene.off"));
    clear.hidden = !value;
    if (mini && pose) mini.draw(pose.phi);
  }
  set(first);
  const element = h("div", { class: "row" }, picture, take, clear);
  return { element, read: () => scene };
}

/**
 * Whether a step asks something. @param {Room} room @param {Partial<Question> | undefined} first
 */
function questionPart(room, first) {
  const fields = questionFields(room, first ?? {});
  const box = h("input", { type: "checkbox", checked: Boolean(first), "data-step-field": "asks" });
  const show = () => {
    fields.element.hidden = !box.checked;
  };
  box.addEventListener("change", show);
  show();
  const tick = h("label", { class: "tick" }, box, h("span", {}, room.say("sheet.asks")));
  return {
    element: h("div", {}, tick, fields.element),
    /** @returns {Question | null | undefined} */
    read: () => (box.checked ? fields.read() : undefined),
    /** What a question after this one begins with; undefined where none is asked. */
    habits: () => (box.checked ? fields.habits() : undefined),
  };
}

/** Moves a step, or takes it away. @param {Editor} editor @param {Part} part @param {number} by */
function move(editor, part, by) {
  const { parts } = editor;
  const at = parts.indexOf(part);
  parts.splice(at, 1);
  if (by) parts.splice(Math.max(0, Math.min(parts.length, at + by)), 0, part);
  order(editor);
}

/** Puts the steps in their order and numbers them. @param {Editor} editor */
function order({ room, parts, list }) {
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  list.replaceChildren(...parts.map(({ element }) => element));
  parts.forEach((part, i) => {
    part.number.textContent = room.say("sheet.step", { step: i + 1 });
  });
  if (focused?.isConnected) focused.focus();
}

/** The inputs of a step. @param {Editor} editor @param {Draft} step */
function inputsOf({ room }, step) {
  const { say } = room;
  const title = h("input", {
    type: "text",
    maxlength: 200,
    value: step.title ?? "",
    "data-step-field": "title",
  });
  const needs = choice(
    say("sheet.needs"),
    NEEDS.map((value) => ({ value, words: say(`sheet.needs.${value}`) })),
    step.needs ?? "nothing",
    () => {},
  );
  needs.select.dataset.stepField = "needs";
  return {
    title,
    text: areaOf("text", step.text ?? "", 3),
    hint: areaOf("hint", step.hint ?? "", 1),
    scene: scenePart(room, step.scene),
    question: questionPart(room, step.question),
    needs,
    hidden: h("input", {
      type: "checkbox",
      checked: Boolean(step.hidden_until),
      "data-step-field": "hidden",
    }),
  };
}

/** @param {Editor} editor @param {Draft} step @returns {Part} */
function partOf(editor, step) {
  const { say } = editor.room;
  const inputs = inputsOf(editor, step);
  const number = h("strong", {});
  const up = button("\u2191", () => move(editor, part, -1), {
    "aria-label": say("sheet.up"),
    "data-step-field": "up",
  });
  const down = button("\u2193", () => move(editor, part, 1), {
    "aria-label": say("sheet.down"),
    "data-step-field": "down",
  });
  const remove = iconButton("trash", say("sheet.removeStep"), () => move(editor, part, 0));
  const hidden = h("label", { class: "tick" }, inputs.hidden, h("span", {}, say("sheet.hidden")));
  const element = h(
    "li",
    { class: "edit-step" },
    h("div", { class: "row" }, number, up, down, remove),
    labelled(say("share.title"), inputs.title),
    labelled(say("sheet.stepText"), inputs.text),
    inputs.scene.element,
    inputs.question.element,
    labelled(say("sheet.hint"), inputs.hint),
    h("div", { class: "row" }, inputs.needs.element, hidden),
  );
  /** @type {Part} */
  const part = {
    id: step.id,
    element,
    number,
    read: () => readStep(editor, part, inputs),
    habits: () => ({ question: inputs.question.habits(), needs: inputs.needs.select.value }),
  };
  return part;
}

/**
 * The step as it is written, null where something is missing. @param {Editor} editor @param {Part}
 * part @param {ReturnType<typeof inputsOf>} inputs @returns {Step | null}
 */
function readStep({ parts }, part, { title, text, hint, scene, question, needs, hidden }) {
  const asked = question.read();
  if (asked === null) return null;
  const at = parts.indexOf(part);
  /** @type {Step} */
  const step = { id: part.id };
  if (title.value.trim()) step.title = title.value.trim();
  if (text.value.trim()) step.text = text.value.trim();
  const set = scene.read();
  if (set) step.scene = set;
  if (asked) step.question = asked;
  if (hint.value.trim()) step.hint = hint.value.trim();
  if (asked && needs.select.value !== "nothing") step.needs = needs.select.value;
  if (hidden.checked && at > 0) step.hidden_until = parts[at - 1].id;
  return step;
}

/** An id that no step has. @param {Editor} editor */
function freeId({ parts }) {
  for (let i = parts.length + 1; ; i++) if (!parts.some(({ id }) => id === `s${i}`)) return `s${i}`;
}

/**
 * @param {Editor} editor @param {HTMLInputElement} title @param {string} feedback
 * @param {Sheet | null} before @returns {Sheet | null}
 */
function readSheet({ room, parts, fault }, title, feedback, before) {
  fault.textContent = "";
  if (!title.value.trim()) {
    fault.textContent = room.say("sheet.wrong.title");
    title.focus();
    return null;
  }
  const steps = [];
  for (const part of parts) {
    const step = part.read();
    if (!step) {
      fault.textContent = room.say("sheet.wrong.step", { step: part.number.textContent });
      return null;
    }
    steps.push(step);
  }
  const language = before?.language ?? room.app.text.language;
  const closed = before?.closed && { closed: true };
  const told = feedback !== "at_once" && { feedback };
  return { title: title.value.trim(), language, ...closed, ...told, steps };
}

/**
 * Opens the editor; write gets what is saved.
 * @param {Room} room @param {Sheet | null} sheet null: a new one @param {(sheet: Sheet) =>
 * Promise<unknown>} write
 */
export function editSheet(room, sheet, write) {
  const { app, say } = room;
  const fault = h("p", { class: "fault", role: "alert" });
  /** @type {Editor} */
  const editor = { room, parts: [], list: h("ol", { class: "plain edit-steps" }), fault };
  const title = h("input", {
    type: "text",
    maxlength: 200,
    value: sheet?.title ?? "",
    "data-sheet": "title",
  });
  const told = choice(
    say("sheet.feedback"),
    FEEDBACK.map((value) => ({ value, words: say(`sheet.feedback.${value}`) })),
    sheet?.feedback ?? "at_once",
    () => {},
  );
  told.select.dataset.sheet = "feedback";
  editor.parts = (sheet?.steps ?? [{ id: "s1" }]).map((step) => partOf(editor, step));
  const add = button(
    say("sheet.addStep"),
    () => {
      if (editor.parts.length >= MOST_STEPS) return;
      const part = partOf(editor, { id: freeId(editor), ...editor.parts.at(-1)?.habits() });
      editor.parts.push(part);
      order(editor);
      part.element.querySelector("input")?.focus();
    },
    { "data-sheet": "add" },
  );
  const save = button(
    say("sheet.save"),
    async () => {
      const written = readSheet(editor, title, told.select.value, sheet);
      if (!written) return;
      try {
        await write(written);
        dialog.close();
      } catch (error) {
        fault.textContent = said(error, app.text);
      }
    },
    { class: "button main", "data-sheet": "save" },
  );
  const dialog = openDialog(
    room,
    "edit",
    say(sheet ? "sheet.edit" : "sheet.make"),
    labelled(say("sheet.name"), title),
    told.element,
    editor.list,
    h("div", { class: "row" }, add, save),
    fault,
  );
  order(editor);
  title.focus();
}
