// What axe-core finds in a page.
// Leaves to others: which views are looked at (test_axe.mjs, the drawers' tests).
// Invariant: the rules of WCAG 2.2 AA and axe's best practices, all of them; where only the colours are others, those of colours.

import { readFileSync } from "node:fs";
import { fetched } from "./rig.mjs";

export const AXE = readFileSync(fetched.resolve("axe-core/axe.min.js"), "utf8");
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** What a change of theme can spoil. */
const COLOURS = ["color-contrast", "link-in-text-block"];

/** What axe finds in the page as it is, or in a part of it (axe's context): "rule: element", none if all is well.
 *  `colours`: by the rules of colours alone, `shapes`: by all the others. */
export async function violations(page, { context = null, colours = false, shapes = false } = {}) {
  const rules = shapes ? Object.fromEntries(COLOURS.map((id) => [id, { enabled: false }])) : {};
  if (!await page.evaluate(() => "axe" in window)) await page.evaluate(AXE);
  const { violations: found } = await page.evaluate(([part, only, rules]) => window.axe.run(part ?? document, { runOnly: only, rules, resultTypes: ["violations"], preload: false }), [context, colours ? COLOURS : TAGS, rules]);
  return found.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.any[0]?.message ?? ""}`));
}
