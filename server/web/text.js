// The words of the page: one flat object a language, in text/; no other file has words that are
// seen.
// Leaves to others: where they stand.
// Invariant: a key that is missing shows itself, so that a test sees it.

import { keep as kept } from "./keep.js";
import de from "./text/de.js";
import en from "./text/en.js";

/** @type {Record<string, Record<string, string>>} */
const WORDS = { en, de };
const KEPT = "pendulumd.language";

export const LANGUAGES = Object.keys(WORDS);

function wanted() {
  const tongues = [kept.get(KEPT) ?? "", ...navigator.languages.map((name) => name.slice(0, 2))];
  return tongues.find((name) => name in WORDS) ?? "en";
}

/**
 * text(key, holes) with numbers as the language writes them: text.number(value, digits) fixed
 * decimals, text.short(value, digits) significant digits, text.read(typed) a number or NaN.
 * @returns {Text}
 */
export function createText() {
  /** @type {Record<string, string>} */
  let words = en;
  const formats = new Map();
  /** @param {string} key @param {Record<string, any>} holes */
  const fill = (key, holes = {}) =>
    (words[key] ?? key).replace(/\{(\w+)\}/g, (hole, name) => holes[name] ?? hole);
  const text = /** @type {Text} */ (fill);

  /** @param {Intl.NumberFormatOptions} options */
  function format(options) {
    const key = JSON.stringify(options);
    if (!formats.has(key))
      formats.set(key, new Intl.NumberFormat(text.language, { useGrouping: false, ...options }));
    return formats.get(key);
  }

  text.language = "en";
  text.has = (key) => key in words;
  text.number = (value, digits = 2) =>
    format({ minimumFractionDigits: digits, maximumFractionDigits: digits })
      .format(Object.is(value, -0) ? 0 : value)
      .replace("-", "\u2212");
  text.short = (value, digits = 4) =>
    format({ maximumSignificantDigits: digits }).format(value).replace("-", "\u2212");
  text.read = (typed) => {
    const plain = typed.trim().replace("\u2212", "-").replace(",", ".");
    return plain === "" ? NaN : Number(plain);
  };
  /** Words that come with a part of the page, by language. */
  text.teach = (more) => {
    for (const [language, list] of Object.entries(more)) Object.assign(WORDS[language], list);
  };
  /** Changes the language, keeps the choice. */
  text.use = (language = wanted(), keep = false) => {
    words = WORDS[language];
    text.language = language;
    formats.clear();
    document.documentElement.lang = language;
    if (keep) kept.set(KEPT, language);
  };
  return text;
}
