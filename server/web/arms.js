// The arms for the keyboard and for those who listen: one button an arm, unseen; the stage shows which has the focus.
// Leaves to others: what keys do (edits.js), drawing the focus.
// Invariant: all that a hand can do here a key can.

import { createBag, h } from "./dom.js";

const TURN = Math.PI / 36;
const SETTLE_SECONDS = 0.6;

export function mountArms(element, app, look) {
  const { store, edits, text } = app;
  const bag = createBag();
  const list = h("div", { role: "group", class: "unseen arms", "aria-label": text("arms") });
  element.append(list);

  function label(doc, arm) {
    const { length, mass, parent } = doc.pendulum;
    return text(parent[arm - 1] ? "arm.label" : "arm.label.pivot", {
      arm,
      carrier: parent[arm - 1],
      length: text.short(length[arm - 1]),
      mass: text.short(mass[arm - 1]),
      angle: text.number((doc.initial.phi[arm - 1] * 180) / Math.PI, 0),
    });
  }

  function fill(doc) {
    const n = doc.pendulum.length.length;
    while (list.children.length > n) list.lastChild.remove();
    while (list.children.length < n)
      list.append(h("button", { type: "button", "data-arm": list.children.length + 1 }));
    for (let arm = 1; arm <= n; arm++) list.children[arm - 1].textContent = label(doc, arm);
  }

  const turn = (arm, by) => {
    edits.grab();
    edits.turn(arm, edits.angle(arm) + by);
    edits.release(SETTLE_SECONDS);
    app.announce(label(store.get(), arm));
  };
  const told = (arm, change) => {
    change();
    app.announce(label(store.get(), arm));
  };
  const KEYS = {
    ArrowLeft: (arm) => turn(arm, TURN),
    ArrowUp: (arm) => turn(arm, TURN),
    ArrowRight: (arm) => turn(arm, -TURN),
    ArrowDown: (arm) => turn(arm, -TURN),
    "shift ArrowUp": (arm) => told(arm, () => edits.lengthen(arm, 0.05)),
    "shift ArrowRight": (arm) => told(arm, () => edits.lengthen(arm, 0.05)),
    "shift ArrowDown": (arm) => told(arm, () => edits.lengthen(arm, -0.05)),
    "shift ArrowLeft": (arm) => told(arm, () => edits.lengthen(arm, -0.05)),
    "+": (arm) => told(arm, () => edits.weigh(arm, 1.1)),
    "-": (arm) => told(arm, () => edits.weigh(arm, 1 / 1.1)),
    a: (arm) => focusAfter(() => edits.add(arm)),
    t: (arm) => edits.trail(arm),
    Delete: (arm) => focusAfter(() => edits.remove(arm)),
    Backspace: (arm) => focusAfter(() => edits.remove(arm)),
    Enter: (arm) => app.editArm(arm),
    Escape: () => edits.select(0),
  };

  /** A change of the list, and the focus to the arm that is chosen after it. */
  function focusAfter(change) {
    change();
    list.children[Math.max(store.get().view.selected, 1) - 1]?.focus();
  }

  bag.on(list, "keydown", (event) => {
    const arm = Number(event.target.dataset.arm);
    const shifted =
      event.shiftKey && event.key.startsWith("Arrow") ? `shift ${event.key}` : event.key;
    const act =
      KEYS[shifted] ?? KEYS[event.key.toLowerCase()] ?? (event.key === "=" ? KEYS["+"] : null);
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    act(arm);
  });
  bag.on(list, "focusin", (event) => {
    look.focused = true;
    edits.select(Number(event.target.dataset.arm));
    look.soon();
  });
  bag.on(list, "focusout", () => {
    look.focused = false;
    look.soon();
  });
  bag.on(list, "click", (event) => app.editArm(Number(event.target.dataset.arm)));
  bag(
    store.subscribe(
      (doc, before) =>
        (doc.pendulum !== before.pendulum || doc.initial !== before.initial) && fill(doc),
    ),
  );
  fill(store.get());
  return { destroy: bag.end };
}
