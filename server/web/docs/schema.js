// Schemas as lists of fields: name, type, bounds, default, meaning; what has a name of its own is a
// link.
// Leaves to others: where they stand (operation.js, docs.js).
// Invariant: every property, alternative, bound and word of a list is shown.

import { h } from "../dom.js";
import { inline, markdown } from "./markdown.js";

/** A schema of the description, as JSON. @typedef {Record<string, any>} Schema */
/**
 * The description, and what a reference in it stands for.
 * @typedef {{document: any, resolve(thing: any): any}} Reader
 */
/** @typedef {import("../dom.js").Child} Child */

const PREFIX = "#/components/schemas/";

/**
 * {document, resolve(thing)}: the document, and what a reference in it stands for.
 * @param {any} document @returns {Reader}
 */
export function createReader(document) {
  /** @param {string} pointer */
  const at = (pointer) =>
    pointer
      .slice(2)
      .split("/")
      .reduce((value, key) => value[key.replaceAll("~1", "/").replaceAll("~0", "~")], document);
  return {
    document,
    resolve: (thing) => (thing?.$ref ? { ...at(thing.$ref), ...thing, $ref: undefined } : thing),
  };
}

/** @param {string} ref */
const link = (ref) =>
  h("a", { href: `#schema-${ref.slice(PREFIX.length)}` }, ref.slice(PREFIX.length));

/** @param {Child[][]} lists @param {string} word @returns {Child[]} */
const join = (lists, word) => lists.flatMap((list, i) => (i ? [word, ...list] : list));

/** @param {unknown} thing */
const value = (thing) => h("code", {}, JSON.stringify(thing));

/** What kind of value it is, in words and links. @param {Schema} schema @returns {Child[]} */
function typeOf(schema) {
  if (schema.$ref) return [link(schema.$ref)];
  if (schema.const !== undefined) return [value(schema.const)];
  const several = schema.oneOf ?? schema.anyOf;
  if (several) return join(several.map(typeOf), " or ");
  if (schema.allOf) return join(schema.allOf.map(typeOf), " and ");
  if (schema.type === "array")
    return [
      "array of ",
      ...(schema.items
        ? typeOf(schema.items)
        : schema.prefixItems
          ? join(schema.prefixItems.map(typeOf), ", ")
          : ["anything"]),
    ];
  if (Array.isArray(schema.type)) return [schema.type.join(" or ")];
  return [schema.type ?? (schema.enum ? "one of" : schema.properties ? "object" : "anything")];
}

/** Bounds and the like: [["at least", 0], ...]. @param {Schema} schema @returns {Child[][]} */
function boundsOf(schema) {
  const words = [
    ["minimum", "at least"],
    ["exclusiveMinimum", "greater than"],
    ["maximum", "at most"],
    ["exclusiveMaximum", "less than"],
    ["multipleOf", "a multiple of"],
    ["minItems", "items: at least"],
    ["maxItems", "items: at most"],
    ["minLength", "characters: at least"],
    ["maxLength", "characters: at most"],
    ["minProperties", "members: at least"],
    ["maxProperties", "members: at most"],
    ["pattern", "matches"],
    ["format", "format"],
  ];
  /** @type {Child[][]} */
  const bounds = words
    .filter(([key]) => schema[key] !== undefined)
    .map(([key, word]) => [`${word} `, h("code", {}, String(schema[key]))]);
  if (schema.uniqueItems) bounds.push(["no item twice"]);
  if (schema.enum)
    bounds.push(
      join(
        schema.enum.map((/** @type {unknown} */ one) => [value(one)]),
        ", ",
      ),
    );
  if (schema.default !== undefined) bounds.push(["default ", value(schema.default)]);
  if (schema.items && !schema.items.$ref)
    bounds.push(...boundsOf(schema.items).map((bound) => ["each ", ...bound]));
  return bounds;
}

/** @param {string} name @param {Schema} schema @param {boolean} needed @param {Reader} reader */
function field(name, schema, needed, reader) {
  const inner = nested(schema, reader);
  return h(
    "div",
    { class: "doc-field-row" },
    h(
      "dt",
      {},
      h("code", {}, name),
      needed ? h("span", { class: "doc-needed" }, "required") : null,
    ),
    h(
      "dd",
      {},
      h(
        "div",
        { class: "doc-kind" },
        ...typeOf(schema),
        ...boundsOf(schema).flatMap((bound) => [
          h("span", { class: "doc-dot", "aria-hidden": "true" }, " · "),
          ...bound,
        ]),
      ),
      ...markdown(schema.description ?? ""),
      ...inner,
    ),
  );
}

/**
 * The fields of an object without a name, or of the items of an array.
 * @param {Schema} schema @param {Reader} reader @returns {HTMLElement[]}
 */
function nested(schema, reader) {
  if (schema.$ref) return [];
  if (schema.type === "array" && schema.items) return nested(schema.items, reader);
  if (schema.properties) return [list(schema, reader)];
  // an object whose names are not known before: the fields of each of its values
  if (typeof schema.additionalProperties === "object")
    return nested(schema.additionalProperties, reader);
  return [...(schema.oneOf ?? []), ...(schema.anyOf ?? []), ...(schema.allOf ?? [])].flatMap(
    (one) => nested(one, reader),
  );
}

/** @param {Schema} schema @param {Reader} reader */
function list(schema, reader) {
  const needed = new Set(schema.required ?? []);
  return h(
    "dl",
    { class: "doc-fields" },
    ...Object.entries(schema.properties)
      .filter(([, one]) => one !== false) // what must not be there, as it makes another form
      .map(([name, one]) => field(name, one, needed.has(name), reader)),
  );
}

/**
 * A schema as its description and its fields; of a reference, those of what it stands for.
 * @param {Schema} given @param {Reader} reader
 */
export function fieldsOf(given, reader) {
  const schema = reader.resolve(given);
  const said = markdown(schema.description ?? "");
  if (schema.properties) return [...said, list(schema, reader)];
  const bounds = boundsOf(schema).flatMap((bound) => [
    h("span", { class: "doc-dot", "aria-hidden": "true" }, " · "),
    ...bound,
  ]);
  return [
    h("p", { class: "doc-kind" }, ...typeOf({ ...schema, $ref: undefined }), ...bounds),
    ...said,
    ...nested(schema, reader),
  ];
}

/**
 * Parameters and header fields: like fields of an object.
 * @param {any[]} parameters @param {Reader} reader
 */
export function parametersOf(parameters, reader) {
  return h(
    "dl",
    { class: "doc-fields" },
    ...parameters.map((one) => {
      const { name, in: place, required, schema = {}, description = "" } = reader.resolve(one);
      return h(
        "div",
        { class: "doc-field-row" },
        h(
          "dt",
          {},
          h("code", {}, name),
          place ? h("span", { class: "doc-place" }, place) : null,
          required ? h("span", { class: "doc-needed" }, "required") : null,
        ),
        h(
          "dd",
          {},
          h(
            "div",
            { class: "doc-kind" },
            ...typeOf(schema),
            ...boundsOf(reader.resolve(schema)).flatMap((bound) => [" · ", ...bound]),
          ),
          h("p", {}, ...inline(description)),
        ),
      );
    }),
  );
}
