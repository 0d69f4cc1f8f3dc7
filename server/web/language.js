// Which language the page speaks, and where its words are: text/LANGUAGE/PART.js, each asked for
// when it is needed, in the language in use alone.
// Leaves to others: what is done with words (text.js).
// Invariant: the address (?lang=) goes before what was chosen here once, that before the browser's
// own languages; the browser's language is one that Intl knows.

import { script } from "./files.js";
import { keep as kept } from "./keep.js";
import { LANGUAGES } from "./text/languages.js";

const RIGHT_TO_LEFT = ["ar", "fa", "he", "ur"];
// with the digits 0 ... 9; all others write a comma
const WITH_POINT = ["en", "ar", "he", "hi", "ja", "ko", "th", "ur", "zh"];
const KEPT = "pendulumd.language";

/** The language of the address, "" without one that is known. */
export function inAddress() {
  const asked = new URLSearchParams(location.search).get("lang") ?? "";
  return asked in LANGUAGES ? asked : "";
}

/** The language that was chosen, by the address or here once; "" where the browser's own holds. */
export function chosen() {
  const before = kept.get(KEPT) ?? "";
  return inAddress() || (before in LANGUAGES ? before : "");
}

/** What the page shall speak. */
export function wanted() {
  const own = navigator.languages.map((name) => name.slice(0, 2));
  return [chosen(), ...own].find((name) => name in LANGUAGES) ?? "en";
}

/** Whether a name is one of a language. @param {string} name */
function isLanguage(name) {
  try {
    return Intl.getCanonicalLocales(name).length === 1;
  } catch {
    return false;
  }
}

// a WebKit of a system without a locale says "C", at which Intl and the libraries with it throw
if (!isLanguage(navigator.language))
  Object.defineProperty(navigator, "language", { value: wanted(), configurable: true });

/** Keeps a choice, in the address too, which may be handed on. @param {string} language */
export function choose(language) {
  kept.set(KEPT, language);
  const address = new URL(location.href);
  address.searchParams.set("lang", language);
  history.replaceState(history.state, "", address);
}

/** What stands between a number's whole part and the rest. @param {string} language */
export const decimalMark = (language) => (WITH_POINT.includes(language) ? "." : ",");

/** @param {string} language */
export const direction = (language) => (RIGHT_TO_LEFT.includes(language) ? "rtl" : "ltr");

/**
 * The words of a part of the page; refused as files are (files.js).
 * @param {string} part @param {string} language @returns {Promise<Record<string, string>>}
 */
export const wordsOf = async (part, language) =>
  (await script(`text/${language}/${part}.js`)).default;

/** Asks for the first words as soon as it is known which; the English ones come with the page. */
export function beginWords() {
  const language = wanted();
  // text.js asks for the same, and says where they do not come
  if (language !== "en") wordsOf("page", language).catch(() => {});
}
