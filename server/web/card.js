// The card of the chosen arm: its length, mass and start, edited in place, its force of now, and
// what can be done with it.
// Leaves to others: the changes themselves (edits.js).
// Invariant: lies beside the tip while the pendulum stands still, if no arm is there, and in a
// corner while it moves; shows what the document holds.

import { foldedTheta, phiOf } from "./angles.js";
import { createBag, h, icon, iconButton } from "./dom.js";
import { massOf } from "./terms.js";
import { removable } from "./tree.js";

const LEGEND = 76; // pixels at the bottom of the stage
const NARROW = 560; // pixels, below which it never lies beside the tip
const CORNER = 3; // what a corner must hide less than a place beside the tip
const LEAST = Number.MIN_VALUE;

/**
 * A number of an arm: from the document, and back; least: what it must not be below (a mass may be
 * 0 where the arm is a bar); pivot: only of the arm at the pivot.
 * @typedef {{
 *   name: string, unit: string, least?: (doc: Doc, k: number) => number, pivot?: boolean,
 *   get: (doc: Doc, k: number) => number, set: (edits: Edits, arm: number, value: number) => void,
 * }} Field
 */

/** @type {Field[]} */
export const FIELDS = [
  {
    name: "length",
    unit: "m",
    least: () => LEAST,
    get: (doc, k) => doc.pendulum.length[k],
    set: (edits, arm, value) => edits.setLength(arm, value),
  },
  {
    name: "mass",
    unit: "kg",
    least: (doc, k) => (massOf(doc.pendulum, k) > doc.pendulum.mass[k] ? 0 : LEAST),
    get: (doc, k) => doc.pendulum.mass[k],
    set: (edits, arm, value) => edits.setMass(arm, value),
  },
  {
    name: "angle",
    unit: "\u00b0",
    get: (doc, k) => foldedTheta(doc.initial.phi[k]),
    set: (edits, arm, value) => edits.setStart(arm, "phi", phiOf(value)),
  },
  {
    name: "rate",
    unit: "rad/s",
    get: (doc, k) => doc.initial.phid[k],
    set: (edits, arm, value) => edits.setStart(arm, "phid", value),
  },
  // where the pendulum hangs
  {
    name: "gravity",
    unit: "m/s\u00b2",
    pivot: true,
    get: (doc) => doc.pendulum.gravity,
    set: (edits, _, value) => edits.setGravity(value),
  },
];

/**
 * The card while it is there; arm: whose it is, 0 if none is chosen; placed: for which place it was
 * laid out.
 * @typedef {{
 *   app: App, element: HTMLElement, look: Look, arm: number, placed: string | null, inputs:
 *   HTMLInputElement[],
 *   labels: HTMLElement[], name: HTMLElement, carrier: HTMLElement, hint: HTMLElement, force:
 *   HTMLElement, trail: HTMLElement,
 *   remove: HTMLButtonElement, root: HTMLElement,
 * }} Card
 */

/**
 * Takes what has been typed, if it is sound.
 * @param {Card} card @param {Field} field @param {HTMLInputElement} input
 */
function commit({ app, arm, hint }, field, input) {
  const value = app.text.read(input.value);
  const least = field.least?.(app.store.get(), arm - 1) ?? -Infinity;
  const sound = Number.isFinite(value) && value >= least;
  input.setAttribute("aria-invalid", String(!sound));
  if (sound) {
    field.set(app.edits, arm, value);
    input.value = input.defaultValue;
    return;
  }
  const what = app.text(`arm.${field.name}`);
  const words = app.text(least > 0 ? "arm.wrong.positive" : "arm.wrong", { what });
  hint.textContent = words;
  hint.classList.add("wrong");
  app.announce(words);
}

/** @param {Card} card @param {Field} field @param {Doc} doc @param {number} i */
function showField({ app, arm, inputs, labels }, field, doc, i) {
  const shown = app.text.short(field.get(doc, arm - 1), 5);
  const input = inputs[i];
  labels[i].hidden = Boolean(field.pivot && doc.pendulum.parent[arm - 1]);
  input.defaultValue = shown;
  // who types is not disturbed while the number stays the same
  const same = app.text.read(input.value) === app.text.read(shown);
  if (document.activeElement !== input || !same) input.value = shown;
  input.setAttribute("aria-invalid", "false");
}

/** @param {Card} card @param {Doc} doc */
function show(card, doc) {
  const { text } = card.app;
  const arm = doc.view.selected;
  card.arm = arm;
  card.root.hidden = !arm;
  if (!arm) return;
  card.placed = null;
  const on = doc.pendulum.parent[arm - 1];
  card.name.textContent = text("arm.name", { arm });
  card.carrier.textContent = on ? text("arm.on", { carrier: on }) : text("arm.on.pivot");
  FIELDS.forEach((field, i) => showField(card, field, doc, i));
  card.hint.textContent = text("arm.angle.hint");
  card.hint.classList.remove("wrong");
  card.trail.setAttribute("aria-pressed", String(doc.view.trails.includes(arm)));
  card.remove.disabled = !removable(doc.pendulum.parent, arm);
}

/** @param {Card} card */
function tellForce({ app, look, arm, force }) {
  const lambda = look.shape.lambda[arm - 1];
  const sign = lambda < 0 ? "tension" : "compression";
  const kind = Math.abs(lambda) < look.most * 1e-3 ? "slack" : sign;
  const words = app.text(`force.${kind}`, { force: app.text.number(lambda, 2) });
  if (force.textContent === words) return;
  force.textContent = words;
  force.dataset.kind = kind;
}

/**
 * How much the card hides at a place: its own tip most, other tips and rods' middles less, the
 * pivot in between.
 * @param {Look} look @param {number} arm @param {Point} at @param {number} width @param {number}
 * height
 */
function hiddenBy({ shape, camera }, arm, { x, y }, width, height) {
  const hides = (/** @type {number} */ ax, /** @type {number} */ ay) => {
    const dx = camera.x + camera.scale * ax - x;
    const dy = camera.y - camera.scale * ay - y;
    return dx > -10 && dx < width + 10 && dy > -10 && dy < height + 10;
  };
  let hidden = hides(shape.pivot.x, shape.pivot.y) ? 5 : 0;
  for (let i = 0; i < shape.n; i++) {
    if (hides(shape.x[i], shape.y[i])) hidden += i === arm - 1 ? 30 : 12;
    for (const part of [0.25, 0.5, 0.75]) {
      const x = shape.fromX[i] + part * (shape.x[i] - shape.fromX[i]);
      if (hides(x, shape.fromY[i] + part * (shape.y[i] - shape.fromY[i]))) hidden += 4;
    }
  }
  return hidden;
}

/**
 * The place beside the tip, or else in a corner, where the card hides the least.
 * @param {Card} card @param {number} width @param {number} height
 */
function beside({ element, look, arm }, width, height) {
  const { shape, camera } = look;
  const px = camera.x + camera.scale * shape.x[arm - 1];
  const py = camera.y - camera.scale * shape.y[arm - 1];
  const gap = 20;
  const spots = [
    { x: px + gap, y: py - height / 2 },
    { x: px - gap - width, y: py - height / 2 },
    { x: px - width / 2, y: py + gap },
    { x: px - width / 2, y: py - gap - height },
  ];
  const corners = [8, element.clientWidth - width - 8].map((x) => ({ x, y: 8 }));
  const clamp = (/** @type {number} */ value, /** @type {number} */ most) =>
    Math.max(8, Math.min(value, most - 8));
  let best = spots[0];
  let least = Infinity;
  for (const spot of [...spots, ...corners]) {
    const x = clamp(spot.x, element.clientWidth - width);
    const y = clamp(spot.y, element.clientHeight - LEGEND - height);
    const away = corners.includes(spot) ? CORNER : 0;
    const moved = away + Math.abs(x - spot.x) / 40 + Math.abs(y - spot.y) / 40;
    const hidden = moved + hiddenBy(look, arm, { x, y }, width, height);
    if (hidden < least) [best, least] = [{ x, y }, hidden];
  }
  return best;
}

/** @param {Card} card */
function lay(card) {
  const { app, element, look, root } = card;
  const docked = app.clock.playing || element.clientWidth < NARROW;
  const { clientWidth, clientHeight } = element;
  const key = docked
    ? "docked"
    : `${app.clock.time} ${clientWidth} ${clientHeight} ${look.camera.scale}`;
  if (key === card.placed) return;
  card.placed = key;
  root.classList.toggle("docked", docked);
  const spot = docked ? null : beside(card, root.offsetWidth, root.offsetHeight);
  root.style.transform = spot ? `translate(${Math.round(spot.x)}px, ${Math.round(spot.y)}px)` : "";
}

/** @param {Text} text @param {Field} field @param {(input: HTMLInputElement) => void} change */
function inputOf(text, field, change) {
  return h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-field": field.name,
    "aria-label": text(`arm.${field.name}.unit`, { unit: field.unit }),
    on: {
      change: (/** @type {any} */ event) => change(event.target),
      focus: (/** @type {any} */ event) => event.target.select(),
    },
  });
}

/** @param {HTMLElement} element @param {App} app @param {Look} look @returns {Card} */
function createCard(element, app, look) {
  const { edits, text } = app;
  const arm = () => card.arm;
  const inputs = FIELDS.map((field) => inputOf(text, field, (input) => commit(card, field, input)));
  const labels = FIELDS.map((field, i) => {
    const unit = h("span", { class: "unit" }, field.unit);
    const name = h("span", {}, text(`arm.${field.name}`));
    return h("label", { class: "field" }, name, h("span", { class: "with-unit" }, inputs[i], unit));
  });
  const name = h("strong");
  const carrier = h("span", { class: "quiet" });
  const force = h("p", { class: "force" });
  const click = () => edits.add(arm());
  const hint = h("p", { class: "quiet card-hint" });
  const add = h(
    "button",
    { type: "button", class: "button", "data-act": "add", on: { click } },
    icon("plus"),
    text("arm.add"),
  );
  const trail = iconButton("trail", text("arm.trail"), () => edits.trail(arm()), {
    "data-act": "trail",
  });
  const remove = iconButton("trash", text("arm.remove"), () => edits.remove(arm()), {
    "data-act": "remove",
  });
  const close = iconButton("close", text("close"), () => edits.select(0));
  const root = h(
    "div",
    { class: "card", role: "group", "aria-label": text("arm.card"), hidden: true },
    h("div", { class: "card-head" }, name, carrier, close),
    h("div", { class: "fields" }, ...labels),
    hint,
    h("div", { class: "card-foot" }, force, add, trail, remove),
  );
  /** @type {Card} */
  const card = {
    app,
    element,
    look,
    arm: 0,
    placed: null,
    inputs,
    labels,
    name,
    carrier,
    hint,
    force,
    trail,
    remove,
    root,
  };
  element.append(root);
  return card;
}

/** @param {HTMLElement} element @param {App} app @param {Look} look */
export function mountCard(element, app, look) {
  const { store, edits } = app;
  const bag = createBag();
  const card = createCard(element, app, look);
  look.cardHeight = () => (card.root.hidden ? 0 : card.root.offsetHeight);
  look.cardWidth = () =>
    card.root.hidden || !card.root.classList.contains("docked") ? 0 : card.root.offsetWidth;
  app.editArm = (chosen) => {
    edits.select(chosen);
    card.inputs[0].focus();
  };
  bag.on(card.root, "keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    /** @type {HTMLElement | null} */ (element.querySelector(`[data-arm="${card.arm}"]`))?.focus();
  });
  bag(store.subscribe((doc) => show(card, doc)));
  show(card, store.get());
  return {
    destroy: bag.end,
    /** Called with every frame of the stage. */
    follow() {
      if (!card.arm || card.arm > look.shape.n) return;
      card.root.classList.toggle("away", edits.grabbed);
      tellForce(card);
      lay(card);
    },
  };
}
