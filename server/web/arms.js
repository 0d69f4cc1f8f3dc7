// The arms for the keyboard and for those who listen: one button an arm, unseen; the stage shows
// which has the focus.
// Leaves to others: what keys do (edits.js), drawing the focus.
// Invariant: all that a hand can do here a key can.

import { foldedTheta } from "./angles.js";
import { createBag, h } from "./dom.js";

const TURN = Math.PI / 36;
const SETTLE_SECONDS = 0.6;

/** An arm's button in words. @param {Text} text @param {Doc} doc @param {number} arm */
function labelOf(text, doc, arm) {
  const { length, mass, parent } = doc.pendulum;
  return text(parent[arm - 1] ? "arm.label" : "arm.label.pivot", {
    arm,
    carrier: parent[arm - 1],
    length: text.short(length[arm - 1]),
    mass: text.short(mass[arm - 1]),
    angle: text.number(foldedTheta(doc.initial.phi[arm - 1]), 0),
  });
}

/** One button for each arm. @param {HTMLElement} list @param {Text} text @param {Doc} doc */
function fill(list, text, doc) {
  const n = doc.pendulum.length.length;
  while (list.children.length > n) list.lastChild?.remove();
  while (list.children.length < n) {
    list.append(h("button", { type: "button", "data-arm": list.children.length + 1 }));
  }
  for (let arm = 1; arm <= n; arm++) list.children[arm - 1].textContent = labelOf(text, doc, arm);
}

/** What the keys do to an arm, by the key's name. @param {App} app @param {HTMLElement} list */
function actionsOf(app, list) {
  const { store, edits, text } = app;
  const told = (/** @type {number} */ arm, /** @type {() => void} */ change) => {
    change();
    app.announce(labelOf(text, store.get(), arm));
  };
  const turn = (/** @type {number} */ by) => (/** @type {number} */ arm) =>
    told(arm, () => {
      edits.grab();
      edits.turn(arm, edits.angle(arm) + by);
      edits.release(SETTLE_SECONDS);
    });
  const lengthen = (/** @type {number} */ by) => (/** @type {number} */ arm) =>
    told(arm, () => edits.lengthen(arm, by));
  const weigh = (/** @type {number} */ by) => (/** @type {number} */ arm) =>
    told(arm, () => edits.weigh(arm, by));
  /**
   * A change of the list, and the focus to the arm that is chosen after it.
   * @param {() => void} change
   */
  const focusAfter = (change) => {
    change();
    const chosen = list.children[Math.max(store.get().view.selected, 1) - 1];
    /** @type {HTMLElement | undefined} */ (chosen)?.focus();
  };
  const remove = (/** @type {number} */ arm) => focusAfter(() => edits.remove(arm));
  /** @type {Record<string, (arm: number) => unknown>} */
  const actions = {
    ArrowLeft: turn(TURN),
    ArrowUp: turn(TURN),
    ArrowRight: turn(-TURN),
    ArrowDown: turn(-TURN),
    "shift ArrowUp": lengthen(0.05),
    "shift ArrowRight": lengthen(0.05),
    "shift ArrowDown": lengthen(-0.05),
    "shift ArrowLeft": lengthen(-0.05),
    "+": weigh(1.1),
    "-": weigh(1 / 1.1),
    a: (arm) => focusAfter(() => edits.add(arm)),
    t: (arm) => edits.trail(arm),
    Delete: remove,
    Backspace: remove,
    Enter: (arm) => app.editArm(arm),
    Escape: () => edits.select(0),
  };
  return actions;
}

/**
 * The action of a key, none where it is not for an arm.
 * @param {Record<string, (arm: number) => unknown>} actions @param {KeyboardEvent} event
 */
function actionOf(actions, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const name = event.key === "=" ? "+" : event.key;
  const shifted = event.shiftKey && name.startsWith("Arrow") ? `shift ${name}` : name;
  return actions[shifted] ?? actions[name.toLowerCase()] ?? null;
}

/** @param {HTMLElement} element @param {App} app @param {Look} look */
export function mountArms(element, app, look) {
  const { store, edits, text } = app;
  const bag = createBag();
  const list = h("div", { role: "group", class: "unseen arms", "aria-label": text("arms") });
  element.append(list);
  const actions = actionsOf(app, list);
  const armOf = (/** @type {Event} */ event) =>
    Number(/** @type {HTMLElement} */ (event.target).dataset.arm);

  bag.on(list, "keydown", (event) => {
    const act = actionOf(actions, event);
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act(armOf(event));
  });
  bag.on(list, "focusin", (event) => {
    look.focused = true;
    edits.select(armOf(event));
    look.soon();
  });
  bag.on(list, "focusout", () => {
    look.focused = false;
    look.soon();
  });
  bag.on(list, "click", (event) => app.editArm(armOf(event)));
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum !== before.pendulum || doc.initial !== before.initial) fill(list, text, doc);
    }),
  );
  fill(list, text, store.get());
  return { destroy: bag.end };
}
