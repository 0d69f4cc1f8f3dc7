// The card of the chosen arm: its length, mass and start, edited in place, its force of now, and what can be done with it.
// Leaves to others: the changes themselves (edits.js).
// Invariant: lies beside the tip while the pendulum stands still, in a corner while it moves; shows what the document holds.

import { createBag, h, icon, iconButton } from "./dom.js";
import { removable } from "./tree.js";

const LEGEND = 76; // pixels at the bottom of the stage
const DEGREES = 180 / Math.PI;

// name, unit, from the document, back; positive: must be greater than 0; pivot: only of the arm at the pivot
const FIELDS = [
  {
    name: "length",
    unit: "m",
    positive: true,
    get: (doc, k) => doc.pendulum.length[k],
    set: (edits, arm, value) => edits.setLength(arm, value),
  },
  {
    name: "mass",
    unit: "kg",
    positive: true,
    get: (doc, k) => doc.pendulum.mass[k],
    set: (edits, arm, value) => edits.setMass(arm, value),
  },
  {
    name: "angle",
    unit: "\u00b0",
    get: (doc, k) => doc.initial.phi[k] * DEGREES,
    set: (edits, arm, value) => edits.setStart(arm, "phi", value / DEGREES),
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
    set: (edits, arm, value) => edits.setGravity(value),
  },
];

export function mountCard(element, app, look) {
  const { store, clock, edits, text } = app;
  const bag = createBag();
  let arm = 0;
  let placed = null; // for which place the card was laid out

  const inputs = FIELDS.map((field) =>
    h("input", {
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      "data-field": field.name,
      "aria-label": text(`arm.${field.name}.unit`, { unit: field.unit }),
      on: {
        change: (event) => commit(field, event.target),
        focus: (event) => event.target.select(),
      },
    }),
  );
  const labels = FIELDS.map((field, i) =>
    h(
      "label",
      { class: "field" },
      h("span", {}, text(`arm.${field.name}`)),
      h("span", { class: "with-unit" }, inputs[i], h("span", { class: "unit" }, field.unit)),
    ),
  );
  const name = h("strong");
  const carrier = h("span", { class: "quiet" });
  const force = h("p", { class: "force" });
  const add = h(
    "button",
    { type: "button", class: "button", "data-act": "add", on: { click: () => edits.add(arm) } },
    icon("plus"),
    text("arm.add"),
  );
  const trail = iconButton("trail", text("arm.trail"), () => edits.trail(arm), {
    "data-act": "trail",
  });
  const remove = iconButton("trash", text("arm.remove"), () => edits.remove(arm), {
    "data-act": "remove",
  });
  const card = h(
    "div",
    { class: "card", role: "group", "aria-label": text("arm.card"), hidden: true },
    h(
      "div",
      { class: "card-head" },
      name,
      carrier,
      iconButton("close", text("close"), () => edits.select(0)),
    ),
    h("div", { class: "fields" }, ...labels),
    h("div", { class: "card-foot" }, force, add, trail, remove),
  );
  element.append(card);
  look.cardHeight = () => (card.hidden ? 0 : card.offsetHeight);

  function commit(field, input) {
    const value = text.read(input.value);
    const sound = Number.isFinite(value) && (!field.positive || value > 0);
    input.setAttribute("aria-invalid", !sound);
    if (sound) {
      field.set(edits, arm, value);
      input.value = input.defaultValue;
    } else
      app.announce(
        text(field.positive ? "arm.wrong.positive" : "arm.wrong", {
          what: text(`arm.${field.name}`),
        }),
      );
  }

  function show(doc) {
    arm = doc.view.selected;
    card.hidden = !arm;
    if (!arm) return;
    placed = null;
    const on = doc.pendulum.parent[arm - 1];
    name.textContent = text("arm.name", { arm });
    carrier.textContent = on ? text("arm.on", { carrier: on }) : text("arm.on.pivot");
    FIELDS.forEach((field, i) => {
      const shown = text.short(field.get(doc, arm - 1), 5);
      labels[i].hidden = Boolean(field.pivot && on);
      inputs[i].defaultValue = shown;
      if (document.activeElement !== inputs[i] || text.read(inputs[i].value) !== text.read(shown))
        inputs[i].value = shown;
      inputs[i].setAttribute("aria-invalid", "false");
    });
    trail.setAttribute("aria-pressed", doc.view.trails.includes(arm));
    remove.disabled = !removable(doc.pendulum.parent, arm);
  }

  function tellForce() {
    const lambda = look.shape.lambda[arm - 1];
    const kind =
      Math.abs(lambda) < look.most * 1e-3 ? "slack" : lambda < 0 ? "tension" : "compression";
    const words = text(`force.${kind}`, { force: text.number(lambda, 2) });
    if (force.textContent === words) return;
    force.textContent = words;
    force.dataset.kind = kind;
  }

  /** Beside the tip, where it hides the fewest tips. */
  function beside(width, height) {
    const { shape, camera } = look;
    const k = arm - 1;
    const px = camera.x + camera.scale * shape.x[k];
    const py = camera.y - camera.scale * shape.y[k];
    const gap = 20;
    const spots = [
      [px + gap, py - height / 2],
      [px - gap - width, py - height / 2],
      [px - width / 2, py + gap],
      [px - width / 2, py - gap - height],
    ];
    const clamp = (value, most) => Math.max(8, Math.min(value, most - 8));
    let best = null;
    for (const [left, top] of spots) {
      const x = clamp(left, element.clientWidth - width);
      const y = clamp(top, element.clientHeight - LEGEND - height);
      let hidden = Math.abs(x - left) / 40 + Math.abs(y - top) / 40;
      const hides = (ax, ay) => {
        const [dx, dy] = [camera.x + camera.scale * ax, camera.y - camera.scale * ay];
        return dx > x - 10 && dx < x + width + 10 && dy > y - 10 && dy < y + height + 10;
      };
      if (hides(0, 0)) hidden += 5;
      for (let i = 0; i < shape.n; i++) {
        const from = shape.tree.parent[i] - 1;
        if (hides(shape.x[i], shape.y[i])) hidden += i === k ? 30 : 3;
        if (
          hides(
            (shape.x[i] + (from < 0 ? 0 : shape.x[from])) / 2,
            (shape.y[i] + (from < 0 ? 0 : shape.y[from])) / 2,
          )
        )
          hidden += 3;
      }
      if (!best || hidden < best.hidden) best = { x, y, hidden };
    }
    return best;
  }

  function lay() {
    const docked = clock.playing || element.clientWidth < 560;
    const key = docked
      ? "docked"
      : `${clock.time} ${element.clientWidth} ${element.clientHeight} ${look.camera.scale}`;
    if (key === placed) return;
    placed = key;
    card.classList.toggle("docked", docked);
    const spot = docked ? { x: 0, y: 0 } : beside(card.offsetWidth, card.offsetHeight);
    card.style.transform = docked
      ? ""
      : `translate(${Math.round(spot.x)}px, ${Math.round(spot.y)}px)`;
  }

  app.editArm = (chosen) => {
    edits.select(chosen);
    inputs[0].focus();
  };
  bag.on(card, "keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    element.querySelector(`[data-arm="${arm}"]`)?.focus();
  });
  bag(store.subscribe(show));
  show(store.get());
  return {
    destroy: bag.end,
    /** Called with every frame of the stage. */
    follow() {
      if (!arm || arm > look.shape.n) return;
      card.classList.toggle("away", edits.grabbed);
      tellForce();
      lay();
    },
  };
}
