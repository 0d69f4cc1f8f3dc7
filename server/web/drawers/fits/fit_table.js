// A table of measurements as people have it: what the engine takes its columns for, shown, with a
// choice for each.
// Leaves to others: reading the table (the engine, POST /v1/tables), the request (fit_request.js).
// Invariant: what the engine is not sure of is shown with its reason.

import { h } from "../../dom.js";
import { pendulumOf } from "../../terms.js";
import { choice, figure } from "../kit/kit.js";

const SHOWN = 4; // rows of the table
const KINDS = "theta x y phi joint thetad amplitude period along across".split(" ");
const DEGREE = Math.PI / 180;

/** A column: `is` "t", "theta 1", "x 2", "sigma theta 1" or "".
 * @typedef {{name: string, is: string, unit?: number, sure: boolean, why?: string}} FitColumn */

/** One of the things measured, as requests have it: {theta: 1, values, sigma}.
 * @typedef {{values: (number | null)[], sigma?: number[]} & Record<string, any>} FitSeries */

/**
 * What the engine found; data: absent where no fit is possible yet.
 * @typedef {{
 *   columns: FitColumn[], first: (number | null)[][], rows: number, suggestions: string[],
 *   data?: {t: number[], series: FitSeries[]},
 * }} FitTable
 */

/** What was chosen for each column: the name sent instead of its own, "" for one that is not used,
 * null for one that the engine decides on. @typedef {(string | null)[]} Given */

/**
 * Asks the engine for its reading; throws what the client throws.
 * @param {Client} client @param {Tree | null} tree null: the table names the arms
 * @param {string} csv @param {Given} columns
 * @param {AbortSignal} signal @returns {Promise<FitTable>}
 */
export async function tableOf(client, tree, csv, columns, signal) {
  const data = { csv, ...(columns.length && { columns }) };
  const body = { ...(tree && { pendulum: pendulumOf(tree) }), data, include: ["data"] };
  return (await client.tables(body, { signal })).tables[0];
}

/** Columns of a kind: "theta", "x". @param {FitTable} table @param {RegExp} kind */
export const columnsLike = ({ columns }, kind) => columns.filter(({ is }) => kind.test(is));

/** The highest arm that is measured. @param {FitTable} table */
const armsIn = ({ columns }) =>
  columns.reduce((most, { is }) => Math.max(most, Number(/ (\d+)$/.exec(is)?.[1] ?? 0)), 0);

/**
 * How many arms a table measures, as the engine reads it for the pendulum of the stage, or by
 * itself where it names arms that this one has not.
 * @param {Client} client @param {FitTable} table @param {string} csv @param {AbortSignal} signal
 */
export async function armsOf(client, table, csv, signal) {
  const more = table.columns.some(({ why }) => why?.startsWith("names no arm"));
  return armsIn(more ? await tableOf(client, null, csv, [], signal) : table);
}

/** "deg" or "rad", whichever the angles and angular velocities are in. @param {FitTable} table */
export function angleOf(table) {
  const [one] = columnsLike(table, /^(theta|phi|joint)/);
  return (one?.unit ?? DEGREE) < 1 ? "deg" : "rad";
}

/**
 * The unit of places, "m", "cm", "mm", or "px" for an unknown one: the table's, or by how far the
 * places go, in parts of how far the pendulum reaches.
 * @param {FitTable} table @param {number} reach m
 */
export function placeOf(table, reach) {
  const places = columnsLike(table, /^[xy]/);
  const named = places.find(({ unit }) => unit)?.unit;
  if (named) return { 1: "m", 0.01: "cm", 0.001: "mm" }[named] ?? "px";
  const lists = (table.data?.series ?? []).filter((one) => "x" in one || "y" in one);
  const sizes = lists.flatMap(({ values }) => values.map((one) => Math.abs(one ?? 0)));
  const far = sizes.reduce((most, one) => Math.max(most, one), 0) / reach;
  if (far > 0.2 && far < 2) return "m";
  const pixels = places.some(({ name }) => /px|pixel/i.test(name));
  return far > 20 && far < 130 && !pixels ? "cm" : "px";
}

/** The instants' unit is part of their name. @param {FitColumn} column */
const chosenOf = ({ is, unit }) =>
  is === "t" && unit !== 1 ? `t (${unit === 60 ? "min" : "ms"})` : is;

/**
 * The names to send after a choice for a column.
 * @param {FitTable} table @param {Given} given @param {number} k @param {string} value
 * @returns {Given}
 */
export const givenWith = ({ columns }, given, k, value) =>
  columns.map((_, i) => (i === k ? (value === "t" ? "t (s)" : value) : (given[i] ?? null)));

/** The names to send where angles are in another unit. @param {FitTable} table
 * @param {Given} given @param {string} unit @returns {Given} */
export const givenIn = ({ columns }, given, unit) =>
  columns.map(({ is }, i) => {
    const rate = /thetad/.test(is);
    if (!/theta|phi|joint/.test(is)) return given[i] ?? null;
    return `${is} (${unit}${rate ? "/s" : ""})`;
  });

/** What a column may be. @param {Text} text @param {number} arms @param {FitTable} table */
function optionsOf(text, arms, table) {
  const name = (/** @type {string} */ kind, /** @type {number} */ arm) => ({
    value: `${kind} ${arm}`,
    words: text(`fits.role.${kind}`, { arm }),
  });
  const all = Array.from({ length: arms }, (_, k) => KINDS.map((kind) => name(kind, k + 1))).flat();
  const errors = all
    .filter(({ value }) => table.columns.some(({ is }) => is === value))
    .map(({ value, words }) => ({
      value: `sigma ${value}`,
      words: text("fits.role.sigma", { what: words }),
    }));
  const times = [
    { value: "t", words: text("fits.t") },
    { value: "t (ms)", words: text("fits.ms") },
    { value: "t (min)", words: text("fits.min") },
  ];
  const cart = table.columns.some(({ is }) => is === "cart")
    ? [{ value: "cart", words: text("fits.role.cart") }]
    : [];
  return [{ value: "", words: text("fits.role.none") }, ...times, ...all, ...cart, ...errors];
}

/**
 * The table's first rows under what each column is.
 * @param {Text} text @param {FitTable} table @param {number} arms of the pendulum
 * @param {(k: number, value: string) => unknown} change
 */
export function columnsShown(text, table, arms, change) {
  const options = optionsOf(text, arms, table);
  const heads = table.columns.map((column, k) => {
    const label = `${column.name || k + 1}${column.sure ? "" : " ?"}`;
    const pick = choice(label, options, chosenOf(column), (value) => change(k, value));
    pick.select.dataset.column = String(k);
    pick.select.dataset.sure = String(column.sure);
    return h("th", { scope: "col" }, pick.element);
  });
  const rows = table.first.slice(0, SHOWN).map((row) => {
    const cells = row.map((value) => h("td", {}, value === null ? "" : figure(text, value, 5)));
    return h("tr", {}, ...cells);
  });
  return [h("tr", {}, ...heads), ...rows];
}

/**
 * What the engine was not sure of, why it leaves columns out, and what it suggests; null if
 * nothing.
 * @param {Text} text @param {FitTable} table
 */
export function doubtsShown(text, { columns, suggestions }) {
  const whys = columns.flatMap(({ name, why }, k) =>
    why ? [h("li", {}, `${name || k + 1}: ${why}`)] : [],
  );
  const advice = suggestions.map((words) => h("li", { "data-fit": "suggestion" }, words));
  const list = [...advice, ...whys];
  if (!list.length) return null;
  const sure = columns.every((column) => column.sure);
  const head = h("p", { class: "quiet" }, text(sure ? "fits.words" : "fits.check"));
  return h(
    "div",
    { "data-fit": "doubts" },
    head,
    h("ul", { class: "fit-said", lang: "en" }, ...list),
  );
}
