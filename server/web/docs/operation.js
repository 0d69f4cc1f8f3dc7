// A route of the reference: what it does, what it takes, what it answers, and an example that runs.
// Leaves to others: fields (schema.js), running (example.js).
// Invariant: every parameter, body, status, media type and header field of the route is shown.

import { h } from "../dom.js";
import { example } from "./run.js";
import { inline, markdown } from "./markdown.js";
import { fieldsOf, parametersOf } from "./schema.js";

/** A route of the description. @typedef {{method: string, path: string, operation: any}} Route */
/**
 * Makes a title that leads to itself.
 * @typedef {(tag: "h2" | "h3", text: string, id: string) => HTMLElement} Heading
 */
/** @typedef {import("./schema.js").Reader} Reader */

/** @param {string} method */
const badge = (method) => h("span", { class: `doc-method ${method}` }, method.toUpperCase());

/** The route's line in the contents. @param {Route} route */
export const summaryOf = ({ method, operation }) => [
  badge(method),
  h("span", {}, operation.summary ?? operation.operationId),
];

/** @param {string} title @param {...(Node | null)} children */
const part = (title, ...children) => [h("h4", {}, title), ...children];

/**
 * The forms that an answer has, each with its schema: by name where it has one, else with its
 * fields.
 * @param {Record<string, any>} content @param {Reader} reader
 */
function contentOf(content, reader) {
  const types = Object.entries(content);
  /** @param {any} one */
  const link = ({ schema }) =>
    schema?.$ref
      ? [
          ": ",
          h("a", { href: `#schema-${schema.$ref.split("/").pop()}` }, schema.$ref.split("/").pop()),
        ]
      : [];
  return [
    h(
      "p",
      { class: "doc-kind" },
      ...types.flatMap(([type, one], i) => [i ? " · " : "", h("code", {}, type), ...link(one)]),
    ),
    ...types.flatMap(([, { schema }]) =>
      schema && !schema.$ref && schema.properties ? fieldsOf(schema, reader) : [],
    ),
  ];
}

/** @param {[string, any]} response @param {Reader} reader */
function responseOf([status, given], reader) {
  const response = reader.resolve(given);
  const headers = Object.entries(response.headers ?? {}).map(([name, one]) => ({
    name,
    ...reader.resolve(one),
  }));
  return h(
    "details",
    { class: "doc-response" },
    h(
      "summary",
      {},
      h("strong", {}, status),
      " ",
      h("span", {}, ...inline((response.description ?? "").split("\n")[0])),
    ),
    ...markdown((response.description ?? "").split("\n").slice(1).join("\n")),
    ...(response.content ? contentOf(response.content, reader) : []),
    ...(headers.length ? [h("p", {}, "Header fields:"), parametersOf(headers, reader)] : []),
  );
}

/**
 * The entry of a route; heading(tag, text, id, ...children) makes its title.
 * @param {Route} one @param {Reader} reader @param {Heading} heading
 */
export function article(one, reader, heading) {
  const { method, path, operation } = one;
  const parameters = (operation.parameters ?? []).map(reader.resolve);
  const body = reader.resolve(operation.requestBody)?.content ?? {};
  const schema = body["application/json"]?.schema;
  const name = schema?.$ref?.split("/").pop();
  return h(
    "article",
    { class: "doc-operation" },
    h(
      "div",
      { class: "doc-told" },
      heading("h3", operation.summary, operation.operationId),
      h("p", { class: "doc-route" }, badge(method), " ", h("code", {}, path)),
      ...markdown(operation.description ?? ""),
      ...(parameters.length ? part("Parameters", parametersOf(parameters, reader)) : []),
      ...(schema
        ? part(
            "Body",
            name
              ? h(
                  "p",
                  { class: "doc-kind" },
                  h("code", {}, "application/json"),
                  ": ",
                  h("a", { href: `#schema-${name}` }, name),
                )
              : null,
            ...fieldsOf(schema, reader),
          )
        : []),
      ...part(
        "Answers",
        ...Object.entries(operation.responses).map((response) => responseOf(response, reader)),
      ),
    ),
    example(one, reader),
  );
}
