// The worksheets that come with the page, in the reader's language.
// Leaves to others: working on them (sheet_run.js), changing them (sheet_editor.js).
// Invariant: a worksheet is a document (ClassWorksheet of api/call/openapi.yaml) in sheets/.

export const SHIPPED = ["five", "period", "energy", "modes", "tension", "chaos"];

/** @param {string} id @param {string} language @returns {Promise<Sheet>} */
export async function shippedSheet(id, language) {
  const address = new URL(`../sheets/${id}.${language}.json`, import.meta.url);
  const reply = await fetch(address);
  if (!reply.ok) throw Object.assign(new Error(`${address} did not come`), { kind: "file" });
  return reply.json();
}
