// The Markdown of the API's document and of the guides, as elements: paragraphs, lists, tables,
// headings, code, links.
// Leaves to others: where it stands.
// Invariant: text goes in as text; what is no mark is shown as it is.

import { h } from "../dom.js";

/**
 * The element of a heading, by how many signs it has in the text: below the page's own headings.
 * @type {Record<number, "h3" | "h4" | "h5">}
 */
const TITLES = { 2: "h3", 3: "h4", 4: "h5" };
const PIECE = /(`[^`]+`|\*\*[^*]+\*\*|\[[^\]]+\]\([^)\s]+\))/;

/** A line's `code`, **weight** and [links](to). @param {string} text */
export function inline(text) {
  return text
    .split(PIECE)
    .filter(Boolean)
    .map((piece) => {
      if (/^`.+`$/.test(piece)) return h("code", {}, piece.slice(1, -1));
      if (/^\*\*.+\*\*$/.test(piece)) return h("strong", {}, piece.slice(2, -2));
      const link = /^\[(.+)\]\((.+)\)$/.exec(piece);
      return link ? h("a", { href: link[2] }, link[1]) : piece;
    });
}

/** @param {string} line */
const cells = (line) =>
  line
    .trim()
    .replace(/^\||\|$/g, "")
    .split("|")
    .map((cell) => cell.trim());

/** @param {string[]} lines */
function table(lines) {
  const [names, , ...rows] = lines;
  return h(
    "div",
    {
      class: "doc-wide",
      tabindex: "0",
      role: "group",
      "aria-label": `Table: ${cells(names).join(", ")}`,
    },
    h(
      "table",
      {},
      h(
        "thead",
        {},
        h("tr", {}, ...cells(names).map((cell) => h("th", { scope: "col" }, ...inline(cell)))),
      ),
      h(
        "tbody",
        {},
        ...rows.map((row) =>
          h(
            "tr",
            // the type of a problem is a link to its row
            names.startsWith("| problem |")
              ? { id: `problem-${cells(row)[0].replace(/`/g, "")}` }
              : {},
            ...cells(row).map((cell) => h("td", {}, ...inline(cell))),
          ),
        ),
      ),
    ),
  );
}

/** @param {string[]} lines @returns {HTMLElement[]} */
function block(lines) {
  if (/^\s*\|/.test(lines[0]) && /^[\s|:-]+$/.test(lines[1] ?? "")) return [table(lines)];
  const start = lines.findIndex((line) => /^\s*\|/.test(line));
  if (start > 0) return [...block(lines.slice(0, start)), ...block(lines.slice(start))];
  if (lines.every((line) => /^\s*([-*] |\s{2})/.test(line)) && /^\s*[-*] /.test(lines[0])) {
    const items = lines
      .join("\n")
      .split(/^\s*[-*] /m)
      .filter(Boolean);
    return [
      h("ul", {}, ...items.map((item) => h("li", {}, ...inline(item.replace(/\s+/g, " ").trim())))),
    ];
  }
  const title = /^(#{2,4}) (.+)$/.exec(lines[0]);
  if (title)
    return [
      h(TITLES[title[1].length], {}, ...inline(title[2])),
      ...(lines.length > 1 ? block(lines.slice(1)) : []),
    ];
  return [h("p", {}, ...inline(lines.join(" ").trim()))];
}

/** A text as elements. @param {string} text @returns {HTMLElement[]} */
export function markdown(text) {
  // every second part is what stands between two fences, its first line the language
  return text.split(/^```/m).flatMap((part, k) => {
    if (k % 2)
      return [h("pre", { tabindex: "0" }, h("code", {}, part.slice(part.indexOf("\n") + 1)))];
    return part
      .split(/\n\s*\n/)
      .map((lines) => lines.split("\n").filter((line) => line.trim()))
      .filter((lines) => lines.length)
      .flatMap(block);
  });
}
