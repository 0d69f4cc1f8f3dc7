// The worksheets that come with the page, in the reader's language where they have it.
// Leaves to others: working on them (sheet_run.js), changing them (sheet_editor.js).
// Invariant: a worksheet is a document (ClassWorksheet of api/call/openapi.yaml) in sheets/.

export const SHIPPED = ["five", "period", "energy", "modes", "tension", "chaos"];
const LANGUAGES = ["en", "de"];

/** @param {string} id @param {string} language @returns {Promise<Sheet>} */
export async function shippedSheet(id, language) {
  const tongue = LANGUAGES.includes(language) ? language : "en";
  const address = new URL(`../sheets/${id}.${tongue}.json`, import.meta.url);
  const reply = await fetch(address);
  if (!reply.ok) throw Object.assign(new Error(`${address} did not come`), { kind: "file" });
  return reply.json();
}
