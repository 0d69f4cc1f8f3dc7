// What drawers are built of: small controls, files to save, text to copy, numbers to print.
// Leaves to others: all that has a meaning.
// Invariant: a control's label is its name for everybody.

import { gaveUp } from "../../client.js";
import { h } from "../../dom.js";
import { isStatic } from "../../root.js";

/** @param {string} words @param {() => unknown} click @param {Record<string, any>} attributes */
export const button = (words, click, attributes = {}) =>
  h("button", { type: "button", class: "button", on: { click }, ...attributes }, words);

/**
 * A part that a server alone computes: where the page has none, it is greyed out, below the reason.
 * @param {Text} text @param {HTMLElement} part
 */
export function needsServer(text, part) {
  if (!isStatic) return part;
  part.inert = true;
  part.classList.add("greyed");
  return h("div", {}, serverless(text), part);
}

/** The reason. @param {Text} text */
export const serverless = (text) =>
  h("p", { class: "quiet", "data-serverless": "" }, text("failure.static"));

/** One of a choice. @typedef {{value: string | number, words: string}} Option */

/**
 * A select with a label.
 * @param {string} label @param {Option[]} options @param {string | number} value
 * @param {(value: string) => unknown} change
 */
export function choice(label, options, value, change) {
  const select = h("select", { on: { change: () => change(select.value) } });
  for (const option of options) {
    const selected = String(option.value) === String(value);
    select.append(h("option", { value: option.value, selected }, option.words));
  }
  return { element: h("label", { class: "choice" }, h("span", {}, label), select), select };
}

/**
 * A box to tick, with a label: {element, box}.
 * @param {string} label @param {boolean} checked @param {(on: boolean) => unknown} change
 */
export function tick(label, checked, change) {
  const box = h("input", { type: "checkbox", checked, on: { change: () => change(box.checked) } });
  return { element: h("label", { class: "tick" }, box, h("span", {}, label)), box };
}

/**
 * A button that stays pressed.
 * @param {Node | string} words @param {boolean} pressed @param {(on: boolean) => unknown} change
 * @param {Record<string, any>} attributes
 */
export function toggle(words, pressed, change, attributes = {}) {
  const click = () => {
    const next = key.getAttribute("aria-pressed") !== "true";
    key.setAttribute("aria-pressed", String(next));
    change(next);
  };
  const state = { "aria-pressed": String(pressed), ...attributes, on: { click } };
  const key = h("button", { type: "button", class: "chip", ...state }, words);
  return key;
}

/**
 * A bit of a line in the colour of a custom property, for legends.
 * @param {string} name @param {number[] | string | null} dash
 */
export function swatch(name, dash = null) {
  const line = h("span", { class: dash ? "stroke dashed" : "stroke" });
  line.style.setProperty("--colour", `var(${name})`);
  return line;
}

/**
 * Calls fn once in the next frame, however often it is asked to; end() forgets it.
 * @param {() => unknown} fn @returns {Soon}
 */
export function later(fn) {
  let frame = 0;
  const ask = () => {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      fn();
    });
  };
  ask.end = () => {
    cancelAnimationFrame(frame);
    frame = 0;
  };
  return ask;
}

/**
 * Calls fn when nobody has asked for it for a while.
 * @param {() => unknown} fn @param {number} milliseconds @returns {Soon}
 */
export function settled(fn, milliseconds = 250) {
  let timer = 0;
  const ask = () => {
    clearTimeout(timer);
    timer = setTimeout(fn, milliseconds);
  };
  ask.end = () => clearTimeout(timer);
  return ask;
}

/** @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const url = URL.createObjectURL(blob);
  h("a", { href: url, download: name }).click();
  // a browser that asks where to keep it waits for an answer
  setTimeout(() => URL.revokeObjectURL(url), 300000);
}

/**
 * To the clipboard; where the page is not trusted with it (plain HTTP), by the old way. Answers
 * whether it worked.
 * @param {string} words
 */
export async function copy(words) {
  try {
    await navigator.clipboard.writeText(words);
    return true;
  } catch {
    const field = h("textarea", { class: "unseen", "aria-hidden": "true" });
    field.value = words;
    document.body.append(field);
    field.select();
    const done = document.execCommand("copy");
    field.remove();
    return done;
  }
}

/**
 * A button that copies what `give` gives, and says so.
 * @param {App} app @param {string} words @param {() => string | Promise<string>} give
 */
export function copyButton(app, words, give) {
  const key = button(words, async () => {
    const given = await give();
    const done = given !== "" && (await copy(given));
    app.announce(app.text(done ? "kit.copied" : "kit.notCopied"));
    key.textContent = app.text(done ? "kit.copied" : "kit.notCopied");
    setTimeout(() => {
      key.textContent = words;
    }, 1600);
  });
  return key;
}

/** @type {Record<string, string>} */
const RAISED = {
  "-": "\u207b",
  0: "\u2070",
  1: "\u00b9",
  2: "\u00b2",
  3: "\u00b3",
  4: "\u2074",
  5: "\u2075",
  6: "\u2076",
  7: "\u2077",
  8: "\u2078",
  9: "\u2079",
};
/** @param {number} power */
const raised = (power) => [...String(power)].map((letter) => RAISED[letter]).join("");

/**
 * A number to read: 0.0123, 3.2·10⁻¹⁴.
 * @param {Text} text @param {number} value @param {number} digits
 */
export function figure(text, value, digits = 3) {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return text.short(value, digits);
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const front = text.short(Number(mantissa), digits);
  return front === "1" ? `10${raised(Number(power))}` : `${front}\u00b710${raised(Number(power))}`;
}

/** How many colours there are for arms; beyond, they come again, dashed. */
export const COLOURS = 8;
export const DASHES = [null, [7, 4], [2, 3], [9, 3, 2, 3]];

/**
 * The look of arm k = 1, 2, ...: {name, colour, dash}; `name` is the custom property of its colour.
 * @param {number} k
 */
export function armLook(k) {
  const name = `--arm-${((k - 1) % COLOURS) + 1}`;
  return {
    name,
    colour: cssValue(name),
    dash: DASHES[Math.floor((k - 1) / COLOURS) % DASHES.length],
  };
}

/** @param {string} name */
export const cssValue = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/**
 * A table of the server, by columns.
 * @typedef {{count: number, columns: Columns, widths: Record<string, number>}} Table
 */

/**
 * A table of the server, whole.
 * @param {Client} client @param {string} path @param {object} body @param {AskOptions} options
 */
export async function fetchTable(client, path, body, { signal } = {}) {
  /** @type {Float64Array[]} */
  const pieces = [];
  /** @type {Column[]} */
  let layout = [];
  let count = 0;
  await client.table(path, body, {
    signal,
    begin: (columns) => {
      layout = columns;
    },
    rows(values, many) {
      pieces.push(values.slice());
      count += many;
    },
  });
  const width = layout.reduce((sum, column) => sum + column.count, 0);
  const all = new Float64Array(count * width);
  pieces.reduce((to, piece) => (all.set(piece, to), to + piece.length), 0);
  /** @type {Table} */
  const table = { count, columns: {}, widths: {} };
  let offset = 0;
  for (const { name, count: wide } of layout) {
    const values = new Float64Array(count * wide);
    for (let row = 0; row < count; row++)
      values.set(all.subarray(row * width + offset, row * width + offset + wide), row * wide);
    table.columns[name] = values;
    table.widths[name] = wide;
    offset += wide;
  }
  return table;
}

/** @param {unknown} error */
export const aborted = (error) => gaveUp(error);
