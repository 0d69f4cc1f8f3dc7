// The words of the page: one flat object a part and language, in text/; no other file has words
// that are seen.
// Leaves to others: where they stand; which language it is, and how its words come (language.js).
// Invariant: a key that is missing shows itself, so that a test sees it; the English words of the
// first part are here from the start.

import { chosen, decimalMark, direction, wanted, wordsOf } from "./language.js";
import { failed } from "./problems.js";
import en from "./text/en/page.js";

/** @typedef {Record<string, string>} Words */

const FIRST = "page";

/** @param {string} part @param {string} language @returns {Promise<Words>} */
const load = async (part, language) =>
  part === FIRST && language === "en" ? en : wordsOf(part, language);

/** Whether a number has its digits written out by String and toFixed. @param {number} value */
const ordinary = (value) => value === 0 || (Math.abs(value) >= 1e-6 && Math.abs(value) < 1e21);

/**
 * Numbers as the language writes them. Intl takes longer to begin than the first frame, so it is
 * asked for the few that are far from 1 alone.
 * @param {Text} text
 */
function addNumbers(text) {
  /** @param {string} digits as a program has them */
  const written = (digits) =>
    digits
      .replace(".", decimalMark(text.language))
      .replace(/-/g, direction(text.language) === "rtl" ? "\u200e\u2212" : "\u2212");
  /** @param {number} value @param {Intl.NumberFormatOptions} options */
  const far = (value, options) => {
    const size = Math.abs(value);
    // hundreds of zeros are read by nobody
    if (Number.isFinite(value) && (size < 1e-15 || size >= 1e24))
      return String(Number(value.toPrecision(options.maximumSignificantDigits ?? 6)));
    return new Intl.NumberFormat("en", { useGrouping: false, ...options }).format(value);
  };
  text.number = (value, digits = 2) => {
    const sum = Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value;
    const options = { minimumFractionDigits: digits, maximumFractionDigits: digits };
    return written(Math.abs(sum) < 1e21 ? sum.toFixed(digits) : far(sum, options));
  };
  text.short = (value, digits = 4) => {
    const rounded = Number(value.toPrecision(digits));
    const options = { maximumSignificantDigits: digits };
    return written(ordinary(rounded) ? String(rounded) : far(value, options));
  };
  text.read = (typed) => {
    const plain = typed
      .replace(/[\u200e\u200f\u061c]|\s*(\u00b0\s*)?$|^\s+/g, "")
      .replace(/[\u0660-\u0669\u06f0-\u06f9]/g, (digit) => String(digit.charCodeAt(0) & 15))
      .replace(/\u2212/g, "-")
      // between groups of three digits, or behind the sign
      .replace(/(\d)\s(?=\d{3}(?!\d))|^([-+])\s+/g, "$1$2")
      .replace(/[,\u066b]/, ".");
    return plain === "" ? NaN : Number(plain);
  };
}

/**
 * text(key, holes); text.count(key, count, holes) by the language's plural; text.part(name) when
 * the words of a part of the page are here; numbers as the language writes them:
 * text.number(value, digits) fixed decimals, text.short(value, digits) significant digits,
 * text.read(typed) a number or NaN; text.said(failure) what has failed; text.chosen() the language
 * that somebody chose, or "".
 * @returns {Text}
 */
export function createText() {
  /** @type {Words} */
  let words = en;
  const asked = new Set([FIRST]);
  let turns = 0;
  /** @param {string} key @param {Record<string, any>} holes */
  const fill = (key, holes = {}) =>
    (words[key] ?? key).replace(/\{(\w+)\}/g, (hole, name) => holes[name] ?? hole);
  const text = /** @type {Text} */ (fill);
  /** @type {Map<string, Intl.PluralRules>} */
  const plurals = new Map();

  text.language = "en";
  text.chosen = chosen;
  text.said = (failure) => failed(failure, text);
  text.has = (key) => key in words;
  text.count = (key, count, holes = {}) => {
    const { language } = text;
    if (!plurals.has(language)) plurals.set(language, new Intl.PluralRules(language));
    const form = `${key}.${plurals.get(language)?.select(count)}`;
    return fill(text.has(form) ? form : `${key}.other`, { count, ...holes });
  };
  addNumbers(text);
  text.part = async (name) => {
    if (asked.has(name)) return;
    const { language } = text;
    const more = await load(name, language);
    // where another language was chosen meanwhile, its words are asked for
    if (language !== text.language) return text.part(name);
    words = { ...words, ...more };
    asked.add(name);
  };
  text.use = async (language = wanted()) => {
    const turn = ++turns;
    /** @type {Words[]} */
    let lists = [];
    // parts may be asked for meanwhile
    while (lists.length < asked.size)
      lists = await Promise.all([...asked].map((part) => load(part, language)));
    if (turn !== turns) return;
    words = Object.assign({}, ...lists);
    text.language = language;
    document.documentElement.lang = language;
    document.documentElement.dir = direction(language);
  };
  return text;
}
