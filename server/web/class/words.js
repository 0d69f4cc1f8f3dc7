// The words of the classes, which a page loads with them: one flat object a language, as in text/.
// Leaves to others: which language it is, and the words of the rest of the page (text.js).
// Invariant: a key that is missing shows itself; every language has the keys of words_en.js.

import de from "./words_de.js";
import en from "./words_en.js";

/** @type {Record<string, Record<string, string>>} */
export const WORDS = { en, de };

/** @param {Text} text @returns {Say} */
export function sayOf(text) {
  const fill = (/** @type {string} */ key, /** @type {Record<string, any>} */ holes = {}) => {
    const words = (WORDS[text.language] ?? en)[key];
    if (words === undefined) return text(key, holes);
    return words.replace(/\{(\w+)\}/g, (hole, name) => String(holes[name] ?? hole));
  };
  const say = /** @type {Say} */ (fill);
  say.count = (key, count) =>
    fill(`${key}.${new Intl.PluralRules(text.language).select(count)}`, { count });
  return say;
}
