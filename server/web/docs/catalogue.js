// The reference in order: an entry for each section, route and schema of the description, in
// groups.
// Leaves to others: contents, search, anchors (docs.js), fields (schema.js), a route's entry
// (operation.js).
// Invariant: whatever the description has gets a place here; nothing is known of any route.

import { h } from "../dom.js";
import { markdown } from "./markdown.js";
import { article, summaryOf } from "./operation.js";
import { fieldsOf } from "./schema.js";

const METHODS = ["get", "post", "put", "patch", "delete"];

/** @typedef {import("./schema.js").Reader} Reader */
/**
 * A place of the reference; label: its line in the contents, none where it has no line of its own.
 * @typedef {{id: string, label: string | Node[] | null, element: HTMLElement}} Entry
 */
/** @typedef {{title: string, entries: Entry[]}} Group */

/** @param {string} text */
const slug = (text) =>
  text
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-")
    .replace(/^-|-$/g, "");

/** @param {string} name */
const titled = (name) => name[0].toUpperCase() + name.slice(1);

/**
 * @param {string} id @param {string | Node[] | null} label @param {HTMLElement} element @returns
 * {Entry}
 */
function entry(id, label, element) {
  element.id = id;
  return { id, label, element };
}

/** A heading that leads to itself. @type {import("./operation.js").Heading} */
const heading = (tag, text, id) => {
  const anchor = { class: "doc-anchor", href: `#${id}`, "aria-label": `Link to ${text}` };
  return h(tag, {}, text, h("a", anchor, "#"));
};

/** The description's sections, the first without a title. @param {string} description */
function sectionsOf(description) {
  const [first, ...rest] = `\n${description}`.split(/\n## /);
  const sections = rest.map((part) => {
    const end = part.indexOf("\n");
    return { title: part.slice(0, end), text: part.slice(end) };
  });
  return { introduction: first, sections };
}

/** @param {Reader} reader @returns {Group} */
function overviewOf({ document }) {
  const { info } = document;
  const { introduction, sections } = sectionsOf(info.description);
  const name = h("h2", {}, info.summary ?? info.title);
  const first = h("section", {}, name, ...markdown(introduction));
  const others = sections.map(({ title, text }) => {
    const element = h("section", {}, heading("h2", title, slug(title)), ...markdown(text));
    return entry(slug(title), title, element);
  });
  return { title: "Overview", entries: [entry("introduction", "Introduction", first), ...others] };
}

/**
 * An operation with the parameters that its path has for all.
 * @param {any} item @param {any} operation
 */
const whole = ({ parameters = [] }, operation) => ({
  ...operation,
  parameters: [...parameters, ...(operation.parameters ?? [])],
});

/**
 * The routes of a tag.
 * @param {any} paths @param {string} tag @returns {import("./operation.js").Route[]}
 */
function routesOf(paths, tag) {
  return Object.entries(paths).flatMap(([path, item]) =>
    METHODS.filter((method) => item[method]?.tags?.includes(tag)).map((method) => {
      return { path, method, operation: whole(item, item[method]) };
    }),
  );
}

/** @param {Reader} reader @param {any} tag @returns {Group} */
function tagGroup(reader, { name, description = "" }) {
  const id = `tag-${name}`;
  const title = titled(name);
  const intro = h(
    "section",
    { class: "doc-tag" },
    heading("h2", title, id),
    ...markdown(description),
  );
  const routes = routesOf(reader.document.paths, name).map((route) =>
    entry(route.operation.operationId, summaryOf(route), article(route, reader, heading)),
  );
  return { title, entries: [entry(id, null, intro), ...routes] };
}

/** @param {Reader} reader @returns {Group} */
function schemasGroup(reader) {
  const { schemas = {} } = reader.document.components ?? {};
  const words = h("p", {}, "What the bodies of requests and answers are made of.");
  const intro = h("section", {}, heading("h2", "Schemas", "schemas"), words);
  const entries = Object.entries(schemas).map(([name, schema]) => {
    const id = `schema-${name}`;
    const fields = fieldsOf(/** @type {import("./schema.js").Schema} */ (schema), reader);
    const element = h("section", { class: "doc-schema" }, heading("h3", name, id), ...fields);
    return entry(id, name, element);
  });
  return { title: "Schemas", entries: [entry("schemas", null, intro), ...entries] };
}

/** @typedef {{name: string, text: string}} Guide */

/**
 * The guides; links between them stay, links to files of the source become text.
 * @param {Guide[]} guides @returns {Group}
 */
function guidesGroup(guides) {
  const entries = guides.map(({ name, text }) => {
    const [title, ...lines] = text.replace(/^# /, "").split("\n");
    const linked = lines
      .join("\n")
      .replace(/\]\(([\w-]+)\.md\)/g, "](#guide-$1)")
      .replace(/\[([^\]]+)\]\(\.\.[^)]*\)/g, "$1");
    const id = `guide-${name}`;
    return entry(id, title, h("section", {}, heading("h2", title, id), ...markdown(linked)));
  });
  return { title: "Guides", entries };
}

/**
 * All that the page shows, in order.
 * @param {Reader} reader @param {Guide[]} guides @returns {Group[]}
 */
export function groupsOf(reader, guides) {
  const { tags = [] } = reader.document;
  const routes = tags.map((/** @type {any} */ tag) => tagGroup(reader, tag));
  return [guidesGroup(guides), overviewOf(reader), ...routes, schemasGroup(reader)];
}
