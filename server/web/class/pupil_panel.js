// What a pupil sees in the drawer of the class: what the teacher does, a start to make by hand, a
// question, a worksheet; and how the teacher hears of trouble.
// Leaves to others: following the class (pupil.js), the parts (ask_pupil.js, sheet_pupil.js).
// Invariant: a field that somebody types in is not built anew.

import { createBag, h } from "../dom.js";
import { button, later, toggle } from "../drawers/kit/kit.js";
import { createMini } from "../drawers/kit/mini.js";
import { mountQuestion } from "./ask_pupil.js";
import { keptLink } from "./kept.js";
import { fromHanging } from "./scenes.js";
import { mountGivenSheet } from "./sheet_pupil.js";

/** @typedef {import("./pupil.js").Follower} Follower */

/** What holds just now, in words. @param {Room} room @param {Follower} follower */
function situation({ session, say }, follower) {
  if (session.state === "away") return say("class.now.away");
  if (follower.frozen) return say("class.now.frozen");
  if (follower.target) return say(`class.now.${follower.target.by}`);
  return say("class.now.own");
}

/** The start that is to be made by hand. @param {Room} room @param {Follower} follower */
function handPart(room, follower) {
  const { app, say } = room;
  const place = h("section", { class: "by-hand", hidden: true });
  let shown = "";
  return {
    place,
    show() {
      const { target } = follower;
      const wanted = target?.by === "hand" ? target.key : "";
      if (wanted === shown) return;
      shown = wanted;
      place.hidden = !wanted;
      place.replaceChildren();
      if (!target || !wanted) return;
      const { pendulum, initial } = target.scene.request;
      const tree = { gravity: 9.81, ...pendulum };
      const mini = createMini(tree, { width: 180, height: 150, label: say("class.hand.picture") });
      const degrees = initial.phi.map((/** @type {number} */ phi) =>
        say("degrees", { angle: app.text.short(fromHanging(phi), 3) }),
      );
      place.append(
        h("h3", {}, say("class.together")),
        h("p", {}, say("class.hand", { angles: degrees.join(", ") })),
        mini.canvas,
        button(say("class.release"), () => follower.release(), {
          class: "button main",
          "data-class": "letGo",
        }),
      );
      mini.draw(initial.phi);
    },
  };
}

/** How the teacher hears of it: stuck, done. @param {Room} room @param {Follower} follower */
function stateKeys({ say, tell }, follower) {
  const { sender } = follower;
  /** @param {string} state */
  const key = (state) =>
    toggle(
      say(`class.am.${state}`),
      sender.state === state,
      (on) => {
        sender.set({ state: on ? state : "working" });
        tell(say(on ? `class.told.${state}` : "class.told.working"));
        for (const one of keys)
          one.setAttribute("aria-pressed", String(one.dataset.state === sender.state));
      },
      { "data-state": state },
    );
  const keys = [key("stuck"), key("done")];
  return h("div", { class: "row", role: "group", "aria-label": say("class.am") }, ...keys);
}

/** What a pupil is asked to do. */
const TASKS = "[data-class=letGo], .question form, .given-sheet form";

/**
 * Scrolls to a new task, which on a phone would lie out of sight; again when the phone is turned.
 * @param {HTMLElement} element @param {Bag} bag
 */
function revealing(element, bag) {
  /** @type {Element | undefined} */
  let last;
  const reveal = later(() => {
    const tasks = [...element.querySelectorAll(TASKS)];
    const task = tasks.find((one) => one.getClientRects().length);
    if (task !== last) task?.scrollIntoView({ block: "nearest" });
    last = task;
  });
  bag(reveal.end);
  bag.on(window, "resize", () => {
    last = undefined;
    reveal();
  });
  return reveal;
}

/** @param {HTMLElement} element @param {Room} room @param {Follower} follower */
export function mountPupil(element, room, follower) {
  const { session, say } = room;
  const bag = createBag();
  const now = h("p", { class: "class-now", role: "status" });
  const words = h("blockquote", { class: "class-words", hidden: true });
  const hand = handPart(room, follower);
  const question = mountQuestion(room);
  const sheet = mountGivenSheet(room);
  const { code, nickname } = session.entry ?? { code: "" };
  element.append(
    words,
    question.place,
    hand.place,
    now,
    sheet.place,
    stateKeys(room, follower),
    h("p", { class: "quiet" }, say("class.youAre", { code, nickname })),
    h(
      "p",
      { class: "class-foot" },
      button(say("class.leave"), () => session.leave(), { "data-class": "leave" }),
      keptLink(room),
    ),
  );
  const reveal = revealing(element, bag);
  function show() {
    const text = session.value("stages/class")?.text ?? "";
    const told = situation(room, follower);
    if (now.textContent !== told) now.textContent = told;
    words.hidden = !text;
    words.textContent = text;
    hand.show();
    question.show();
    sheet.show();
    reveal();
  }
  bag(follower.subscribe(show));
  bag(session.subscribe((names) => names ?? show()));
  show();
  return {
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}
