// The words of the classes, which a page loads with them, its language alone: one flat object a
// language, as in text/.
// Leaves to others: which language it is, and the words of the rest of the page (text.js).
// Invariant: a key that is missing shows itself; every language has the keys of words_en.js.

const LANGUAGES = ["en", "de"];

/** @param {Pick<App, "text" | "files">} app @returns {Say} */
export function sayOf({ text, files }) {
  /** @type {Record<string, string>} */
  let words = {};
  const fill = (/** @type {string} */ key, /** @type {Record<string, any>} */ holes = {}) => {
    if (words[key] === undefined) return text(key, holes);
    return words[key].replace(/\{(\w+)\}/g, (hole, name) => String(holes[name] ?? hole));
  };
  const say = /** @type {Say} */ (fill);
  say.count = (key, count) =>
    fill(`${key}.${new Intl.PluralRules(text.language).select(count)}`, { count });
  say.load = async () => {
    const { language } = text;
    const name = LANGUAGES.includes(language) ? language : LANGUAGES[0];
    const { default: loaded } = await files.script(`class/words_${name}.js`);
    if (language === text.language) words = loaded;
  };
  return say;
}
