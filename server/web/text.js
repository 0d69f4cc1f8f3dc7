// The words of the page: one flat object a part and language, in text/; no other file has words
// that are seen.
// Leaves to others: where they stand; which language it is, and how its words come (language.js).
// Invariant: a key that is missing shows itself, so that a test sees it; the English words of the
// first part are here from the start.

import { chosen, direction, wanted, wordsOf } from "./language.js";
import en from "./text/en/page.js";

/** @typedef {Record<string, string>} Words */

const FIRST = "page";

/** @param {string} part @param {string} language @returns {Promise<Words>} */
const load = async (part, language) =>
  part === FIRST && language === "en" ? en : wordsOf(part, language);

/** Numbers as the language writes them. @param {Text} text */
function addNumbers(text) {
  const formats = new Map();
  /** @param {Intl.NumberFormatOptions} options */
  function format(options) {
    const key = text.language + JSON.stringify(options);
    const locale = `${text.language}-u-nu-latn`;
    if (!formats.has(key))
      formats.set(key, new Intl.NumberFormat(locale, { useGrouping: false, ...options }));
    return formats.get(key);
  }
  text.number = (value, digits = 2) =>
    format({ minimumFractionDigits: digits, maximumFractionDigits: digits })
      .format(Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value)
      .replace("-", "\u2212");
  text.short = (value, digits = 4) =>
    format({ maximumSignificantDigits: digits }).format(value).replace("-", "\u2212");
  text.read = (typed) => {
    const plain = typed.trim().replace("\u2212", "-").replace(",", ".");
    return plain === "" ? NaN : Number(plain);
  };
}

/**
 * text(key, holes); text.count(key, count, holes) by the language's plural; text.part(name) when
 * the words of a part of the page are here; numbers as the language writes them:
 * text.number(value, digits) fixed decimals, text.short(value, digits) significant digits,
 * text.read(typed) a number or NaN; text.chosen() the language that somebody chose, or "".
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

  text.language = "en";
  text.chosen = chosen;
  text.has = (key) => key in words;
  text.count = (key, count, holes = {}) => {
    const form = `${key}.${new Intl.PluralRules(text.language).select(count)}`;
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
