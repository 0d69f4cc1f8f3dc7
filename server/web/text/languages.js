// The languages that the page speaks, each by its own name; a folder here for each.
// Invariant: the folders have the same parts with the same keys (tests/rules/words.sh).

/** @type {Record<string, string>} */
export const LANGUAGES = {
  en: "English",
  de: "Deutsch",
  fr: "Français",
  es: "Español",
  nl: "Nederlands",
  tr: "Türkçe",
};
