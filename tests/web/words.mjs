// The words of the page (server/web/text, server/web/sheets) without a browser: `node tests/web/words.mjs` says what each language
// lacks, has too much, or has left in English; the last line counts the checks.
// Leaves to others: how it looks (test_language.mjs).
// Invariant: English is the measure; a key is used where the sources name it, or build it of pieces that fit.

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const WEB = fileURLToPath(new URL("../../server/web/", import.meta.url));
const { LANGUAGES } = await import(join(WEB, "text/languages.js"));
const OTHERS = Object.keys(LANGUAGES).filter((language) => language !== "en");
let passed = 0;
let failed = 0;

/** One check: what it says, and a list of faults that should be empty. */
function check(what, faults) {
  if (faults.length) failed++;
  else passed++;
  for (const fault of faults) console.log(`FAIL ${what}: ${fault}`);
}

const partsOf = (language) => readdirSync(join(WEB, "text", language)).sort();
const wordsOf = async (language, part) => (await import(join(WEB, "text", language, part))).default;
const holes = (words) => [...new Set(words.match(/\{\w+\}/g) ?? [])].sort();
const less = (list, other) => list.filter((one) => !other.includes(one));

/** The English keys that are forms of a plural, by their stem. */
const stems = (words) => Object.keys(words).filter((key) => key.endsWith(".one") && key.replace(/one$/, "other") in words).map((key) => key.slice(0, -4));

/** The forms of a plural that counts of things have in a language. */
function formsOf(language) {
  const rules = new Intl.PluralRules(language);
  return [...new Set(Array.from({ length: 200 }, (_, count) => rules.select(count)))];
}

/** The keys that a language must have, with the English words of each. */
function wantedOf(english, language) {
  const plural = stems(english);
  const plain = Object.entries(english).filter(([key]) => !plural.includes(key.replace(/\.(one|other)$/, "")));
  const forms = plural.flatMap((stem) => formsOf(language).map((form) => [`${stem}.${form}`, english[`${stem}.other`]]));
  return new Map([...plain, ...forms]);
}

/** Whether both say the same sentence, letter for letter. */
const untranslated = (words, english) => words === english && (words.replace(/\{\w+\}/g, "").match(/\p{L}{3,}/gu) ?? []).length > 3;

function compare(english, words, language, part) {
  const wanted = wantedOf(english, language);
  const here = `${language}/${part}`;
  check(`${here} says all`, less([...wanted.keys()], Object.keys(words)).map((key) => `${key} is missing: ${wanted.get(key)}`));
  check(`${here} says nothing else`, less(Object.keys(words), [...wanted.keys()]).map((key) => `${key} is too much`));
  const both = [...wanted].filter(([key]) => key in words);
  const form = (key) => /\.(zero|one|two)$/.test(key); // may say the number in words
  check(`${here} has the holes of en`, both.filter(([key, said]) =>
    less(holes(words[key]), holes(said)).length || (!form(key) && less(holes(said), holes(words[key])).length)).map(([key]) => key));
  check(`${here} has no empty words, and none that are still English`,
    both.filter(([key, said]) => !words[key].trim() || untranslated(words[key], said)).map(([key]) => key));
}

/** What the page's modules say: all text of those that are not words. */
function sources(folder = WEB) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return ["text", "sheets", "node_modules", "docs"].includes(entry.name) ? [] : sources(path);
    return entry.name.endsWith(".js") ? [readFileSync(path, "utf8")] : [];
  });
}

/** Patterns of the keys that are built of pieces, as `class.told.${kind}`. */
function built(code) {
  const templates = [...code.matchAll(/`([^`]*\$\{[^`]*)`/g)].map(([, inner]) => inner.split(/\$\{[^}]*\}/));
  return templates.filter((pieces) => pieces.every((piece) => /^[\w.-]*$/.test(piece)) && pieces.some((piece) => /\w\.|\.\w/.test(piece)))
    .map((pieces) => new RegExp(`^${pieces.map((piece) => piece.replaceAll(".", "\\.")).join("[\\w.-]+")}$`));
}

function checkUse(english) {
  const code = sources().join("\n");
  const literals = new Set([...code.matchAll(/"([\w.-]+)"/g)].map(([, key]) => key));
  const patterns = built(code);
  const plural = stems(english);
  const used = (key) => literals.has(key) || patterns.some((pattern) => pattern.test(key));
  const stem = (key) => key.replace(/\.(one|other)$/, "");
  check("every key is used", Object.keys(english).filter((key) => !used(plural.includes(stem(key)) ? stem(key) : key)));
  const said = [...code.matchAll(/\b(?:text|say)(?:\.(?:has|count))?\(\s*"([^"]+)"/g), ...code.matchAll(/\b(?:text|say)\([^()"]*\? "([\w.-]+)"/g), ...code.matchAll(/\b(?:text|say)\([^()"]*\? "[\w.-]+" : "([\w.-]+)"/g)];
  check("every key that is used is there", said.map(([, key]) => key).filter((key) => !(key in english) && !plural.includes(key)));
}

const TEXTS = ["title", "text", "hint", "choices"]; // the members of a worksheet that people read

function checkSheets() {
  const texts = new Set();
  const kept = new Set(["en"]);
  for (const name of readdirSync(join(WEB, "sheets")))
    JSON.parse(readFileSync(join(WEB, "sheets", name), "utf8"), (member, value) => {
      if (typeof value === "string") kept.add(value);
      if (TEXTS.includes(member)) [value].flat().forEach((text) => texts.add(text));
      return value;
    });
  for (const language of Object.keys(LANGUAGES).filter((each) => each !== "en")) {
    const words = JSON.parse(readFileSync(join(WEB, "text", language, "sheets.json"), "utf8"));
    // a word may be the same in two languages
    check(`worksheets are whole in ${language}`, [...texts].filter((text) => /\w \w/.test(text) && !words[text]));
    check(`worksheets use every translation into ${language}`, Object.keys(words).filter((text) => !kept.has(text)));
  }
}

const all = {};
for (const part of partsOf("en")) {
  const english = await wordsOf("en", part);
  check(`en/${part} has no key of another part`, Object.keys(english).filter((key) => key in all));
  Object.assign(all, english);
  for (const language of OTHERS) {
    const there = partsOf(language).includes(part);
    check(`${language} has ${part}`, there ? [] : [`text/${language}/${part} is missing`]);
    if (there) compare(english, await wordsOf(language, part), language, part);
  }
}
check("every folder is a language that the page offers", less(readdirSync(join(WEB, "text")), [...Object.keys(LANGUAGES), "languages.js"]));
check("every worksheet has a title", less(readdirSync(join(WEB, "sheets")).map((name) => `sheet.ours.${name.replace(".json", "")}`), Object.keys(all)));
checkUse(all);
checkSheets();
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
