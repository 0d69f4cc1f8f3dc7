// Physics: gravity, friction, air, springs, bars, a motor, the shaking of the pivot, a cart,
// bodies, each by a slider and a number, while the pendulum moves; and where its energy is.
// Leaves to others: the fields (physics_fields.js, physics_cart.js), the motion that goes on
// (live.js), the bars of energy (energy_bars.js).
// Invariant: a number shown is the document's, and so the request's, but for what is under a hand.

import { createBag, h } from "../dom.js";
import { roundUp } from "../camera.js";
import { createArmsTable } from "./physics/arms_table.js";
import { createEnergyBars } from "./physics/energy_bars.js";
import { button, choice, figure, toggle } from "./kit/kit.js";
import { lazyPart } from "./kit/lazy.js";
import { MORE_FIELDS } from "./physics/physics_cart.js";
import { FIELDS, scaleOf, withoutLosses } from "./physics/physics_fields.js";
import { STOP_FIELDS, createTable } from "./physics/physics_stop.js";

const PLACES = { earth: 9.81, moon: 1.62, mars: 3.71, jupiter: 24.79, none: 0 };
const GROUPS = [
  "arms",
  "gravity",
  "friction",
  "masses",
  "air",
  "spring",
  "motor",
  "stop",
  "shaking",
  "cart",
  "body",
  "hanging",
  "faster",
];
/** What most lessons need; the others come by a chip, or where the pendulum has them. */
const ALWAYS = ["arms", "gravity", "friction", "masses"];
const STEPS = 1000;

/** @typedef {import("./physics/physics_fields.js").Field} Field */

/**
 * A field's row; range: from where to where its slider goes; busy: whether a hand has it.
 * @typedef {{
 *   field: Field, element: HTMLElement, slider: HTMLInputElement, input: HTMLInputElement,
 *   low: number, high: number, busy: boolean,
 * }} Row
 */

/**
 * The drawer while it is there.
 * @typedef {{
 *   app: App, rows: Row[], scope: HTMLElement, places: HTMLElement[],
 *   bars: ReturnType<typeof createEnergyBars>, table: ReturnType<typeof createArmsTable>,
 *   folds: Map<string, {chip: HTMLElement, section: HTMLElement}>,
 *   map: ReturnType<typeof import("./maps/map.js").default>,
 * }} View
 */

/** @param {number} value */
const tidy = (value) => Number(value.toPrecision(3));

/**
 * The arm whose number a field shows, those that it changes, from 0, and whether these differ.
 * @param {View} view @param {Field} field
 */
function armsOf({ app }, field) {
  const { view, pendulum } = app.store.get();
  const all = [...pendulum.length.keys()];
  if (!field.whole && view.selected)
    return { k: view.selected - 1, arms: new Set([view.selected - 1]), differ: false };
  const has = (/** @type {number} */ k) =>
    field.needs ? field.needs(pendulum, k) : field.get(pendulum, k) !== 0;
  const k = field.whole ? 0 : Math.max(0, all.findIndex(has));
  const same = (/** @type {number} */ one) =>
    field.get(pendulum, one) === field.get(pendulum, k) && has(one) === has(k);
  return { k, arms: new Set(all), differ: !field.whole && !all.every(same) };
}

/**
 * The slider's place of a value: of those that begin at 0 small values have more room.
 * @param {Row} row @param {number} value
 */
function placeOf({ field, low, high }, value) {
  const share = Math.max(0, Math.min(1, (value - low) / (high - low)));
  return Math.round((field.even || low < 0 ? share : Math.sqrt(share)) * STEPS);
}

/** @param {Row} row @param {number} place */
function valueAt({ field, low, high }, place) {
  const share = place / STEPS;
  return tidy(low + (high - low) * (field.even || low < 0 ? share : share * share));
}

/** @param {View} view @param {Row} row @param {number} value */
function change(view, row, value) {
  const { field } = row;
  const { arms } = armsOf(view, field);
  const name = `${field.name} ${arms.size === 1 ? [...arms][0] : "all"}`;
  view.app.live.change(name, (tree, time) => field.set(tree, arms, value, time));
}

/**
 * A value with its unit, for those who listen.
 * @param {View} view @param {Row} row @param {number} value
 */
function say({ app }, { field, slider }, value) {
  slider.setAttribute("aria-valuetext", `${figure(app.text, value)} ${field.unit}`);
}

/** @param {View} view @param {Row} row */
function slid(view, row) {
  row.busy = true;
  const value = valueAt(row, Number(row.slider.value));
  row.input.value = row.input.defaultValue = view.app.text.short(value, 5);
  say(view, row, value);
  change(view, row, value);
}

/** @param {View} view @param {Row} row */
function letGo(view, row) {
  row.busy = false;
  view.app.store.settle();
}

/** @param {View} view @param {Row} row */
function typed(view, row) {
  const { text, object, store } = view.app;
  const { field, input } = row;
  const value = text.read(input.value);
  const signed = field.least !== undefined || field.name === "gravity";
  const sound = Number.isFinite(value) && (signed || value >= 0);
  input.setAttribute("aria-invalid", String(!sound));
  if (!sound) return object(text("physics.wrong", { what: text(`physics.${field.name}`) }));
  change(view, row, value);
  store.settle();
}

/** @param {View} view @param {Field} field @returns {Row} */
function rowOf(view, field) {
  const { text } = view.app;
  const label = text(`physics.${field.name}`);
  const id = `physics-${field.name}`;
  const slider = h("input", {
    type: "range",
    min: 0,
    max: STEPS,
    step: 1,
    id,
    "data-slider": field.name,
    on: {
      input: () => slid(view, row),
      change: () => letGo(view, row),
    },
  });
  const input = h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-number": field.name,
    "aria-label": text("physics.number", { what: label, unit: field.unit }),
    on: { change: () => typed(view, row) },
  });
  const unit = h("span", { class: "unit" }, field.unit);
  const element = h(
    "div",
    { class: "physics-row" },
    h("label", { for: id }, label),
    slider,
    h("span", { class: "with-unit" }, input, unit),
  );
  /** @type {Row} */
  const row = { field, element, slider, input, low: 0, high: 1, busy: false };
  return row;
}

/** @param {View} view @param {Row} row */
function showRow(view, row) {
  const { store, text } = view.app;
  const { field, slider, input } = row;
  const { pendulum } = store.get();
  const { k, differ } = armsOf(view, field);
  const value = field.get(pendulum, k);
  const off = field.needs ? !field.needs(pendulum, k) : false;
  slider.disabled = input.disabled = off;
  if (row.busy) return;
  const scale = scaleOf(pendulum);
  row.low = field.least ? -roundUp(-field.least(scale)) : 0;
  row.high = roundUp(field.most(scale));
  slider.value = String(placeOf(row, value));
  say(view, row, value);
  input.placeholder = differ ? text("physics.differ") : "";
  input.defaultValue = differ ? "" : text.short(value, 5);
  if (document.activeElement !== input) input.value = input.defaultValue;
  input.setAttribute("aria-invalid", "false");
}

/** Whose joints the sliders are of. @param {View} view */
function showScope({ app, scope }) {
  const { store, text, edits } = app;
  const { pendulum, view } = store.get();
  const n = pendulum.length.length;
  scope.hidden = n === 1;
  const all = { value: 0, words: text("physics.all") };
  const arms = pendulum.length.map((_, k) => ({
    value: k + 1,
    words: text("arm.name", { arm: k + 1 }),
  }));
  const pick = choice(text("physics.scope"), [all, ...arms], view.selected, (value) =>
    edits.select(Number(value)),
  );
  pick.select.dataset.scope = "";
  if (scope.contains(document.activeElement)) return;
  scope.replaceChildren(pick.element);
}

/** What the pendulum has lies open. @param {View} view */
function showFolds({ app, rows, folds }) {
  const { pendulum } = app.store.get();
  for (const [group, { chip, section }] of folds) {
    const has = rows.some(
      ({ field }) =>
        field.group === group &&
        pendulum.length.some((_, k) => field.get(pendulum, k) !== 0 && !field.needs),
    );
    if (has) fold(chip, section, true);
  }
}

/** @param {HTMLElement} chip @param {HTMLElement} section @param {boolean} open */
function fold(chip, section, open) {
  section.hidden = !open;
  chip.setAttribute("aria-pressed", String(open));
}

/** @param {View} view */
function show(view) {
  const { gravity } = view.app.store.get().pendulum;
  showScope(view);
  view.table.show();
  showFolds(view);
  for (const row of view.rows) showRow(view, row);
  Object.values(PLACES).forEach((value, i) => {
    view.places[i].setAttribute("aria-pressed", String(value === gravity));
  });
}

/** @param {View} view */
function placesOf({ app }) {
  const { text, live, store } = app;
  return Object.entries(PLACES).map(([name, gravity]) => {
    const set = () => {
      live.change("gravity all", (tree) => ({ ...tree, gravity }));
      store.settle();
    };
    return toggle(text(`physics.place.${name}`), false, set, { "data-place": name });
  });
}

/** @param {View} view @param {string} group */
function groupOf({ app, rows, places, table }, group) {
  const { text } = app;
  const label = text(`physics.group.${group}`);
  const hint = `physics.hint.${group}`;
  const own = rows.filter(({ field }) => field.group === group).map((one) => one.element);
  const section = h("section", { "aria-label": label, "data-group": group }, h("h3", {}, label));
  if (text.has(hint)) section.append(h("p", { class: "quiet" }, text(hint)));
  const row = { class: "chips", role: "group", "aria-label": text("physics.places") };
  if (group === "gravity") section.append(h("div", row, ...places));
  section.append(...own);
  if (group === "arms") section.append(table.element);
  if (group === "motor") section.append(createTable(app, "table"));
  if (group === "shaking") section.append(createTable(app, "track"));
  return section;
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, view) {
  const { app, scope, bars, map } = view;
  const { text, live } = app;
  const clear = button(
    text("physics.clear"),
    () => live.change("clear", (tree) => withoutLosses(tree)),
    { "data-clear": "" },
  );
  const chips = h("div", { class: "chips", role: "group" }, h("span", {}, text("physics.add")));
  element.append(h("h2", {}, text("drawer.physics")), h("div", { class: "row" }, scope, clear));
  for (const group of GROUPS) {
    const section = groupOf(view, group);
    element.append(section);
    if (group === "masses") element.append(chips, h("div", { class: "row" }, clear));
    if (ALWAYS.includes(group)) continue;
    const words = text(`physics.group.${group}`);
    const chip = toggle(words, false, (on) => fold(chip, section, on), { "data-add": group });
    section.hidden = true;
    view.folds.set(group, { chip, section });
    chips.append(chip);
  }
  element.append(bars.element);
  const route = lazyPart(app, "physics/route", text("physics.route"), true);
  element.append(map.element, route.element);
  return route.destroy;
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const bag = createBag();
  const { text } = app;
  const { default: mountMap } = await app.files.script("drawers/maps/map.js");
  const wish = { across: "motorRate", up: "motor", what: "end" };
  /** @type {View} */
  const view = {
    app,
    rows: [],
    scope: h("div", {}),
    places: [],
    bars: createEnergyBars(app),
    map: mountMap(app, text("map.title"), text("map.intro"), wish),
    table: createArmsTable(app),
    folds: new Map(),
  };
  view.rows = [...FIELDS, ...STOP_FIELDS, ...MORE_FIELDS].map((field) => rowOf(view, field));
  view.places = placesOf(view);
  bag(lay(element, view));
  bag(
    app.store.subscribe((doc, before) => {
      const other = doc.pendulum !== before.pendulum || doc.initial !== before.initial;
      if (other || doc.view.selected !== before.view.selected) show(view);
    }),
  );
  bag(view.bars.destroy);
  bag(view.map.destroy);
  show(view);
  return {
    show() {
      view.bars.show();
      view.map.show();
    },
    hide: () => view.bars.hide(),
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "physics", title: (text) => text("drawer.physics"), mount };
