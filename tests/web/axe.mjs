// What axe-core finds in a page.
// Leaves to others: which views are looked at (test_axe.mjs, the drawers' tests).
// Invariant: the rules of WCAG 2.2 AA and axe's best practices, all of them.

import { readFileSync } from "node:fs";
import { fetched } from "./rig.mjs";

export const AXE = readFileSync(fetched.resolve("axe-core/axe.min.js"), "utf8");
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** What axe finds in the page as it is, or in a part of it (axe's context): "rule: element", none if all is well. */
export async function violations(page, context = null) {
  if (!await page.evaluate(() => "axe" in window)) await page.evaluate(AXE);
  const { violations: found } = await page.evaluate(([part, tags]) => window.axe.run(part ?? document, { runOnly: tags, resultTypes: ["violations"], preload: false }), [context, TAGS]);
  return found.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.any[0]?.message ?? ""}`));
}
