// The worksheets that come with the page, in the reader's language.
// Leaves to others: working on them (sheet_run.js), changing them (sheet_editor.js).
// Invariant: a worksheet is a document (ClassWorksheet of api/call/openapi.yaml) in sheets/, with
// English texts; text/LANGUAGE/sheets.json has their translations.

export const SHIPPED = ["five", "period", "energy", "modes", "tension", "chaos"];

/** @param {string} file */
async function fetched(file) {
  const address = new URL(`../${file}`, import.meta.url);
  const reply = await fetch(address);
  if (!reply.ok) throw Object.assign(new Error(`${address} did not come`), { kind: "file" });
  return reply.json();
}

/**
 * A worksheet in another language: every text that has a translation is replaced.
 * @param {any} sheet @param {Record<string, string>} words @param {string} language
 * @returns {Sheet}
 */
export function translated(sheet, words, language) {
  const turn = (/** @type {string} */ _, /** @type {any} */ value) =>
    typeof value === "string" ? (words[value] ?? value) : value;
  return { ...JSON.parse(JSON.stringify(sheet), turn), language };
}

/** @param {string} id @param {string} language */
export async function shippedSheet(id, language) {
  const words = language === "en" ? {} : fetched(`text/${language}/sheets.json`);
  return translated(await fetched(`sheets/${id}.json`), await words, language);
}
