// The example of a route as it stands in the page: fields to change, a button that runs it, a
// button that copies it.
// Leaves to others: what a route can be asked for (example.js), showing an answer (answer.js).
// Invariant: asks this server alone.

import { h } from "../dom.js";
import { bearer } from "../keep.js";
import { isStatic, urlOf } from "../root.js";
import { showAnswer } from "./answer.js";
import { choicesOf } from "./example.js";

const MOST_ROWS = 16;
const SAID_MS = 2000;

/** @typedef {import("./schema.js").Reader} Reader */

/**
 * An example's fields; a body, a choice of it and a choice of the answer's form only where there is
 * one.
 * @typedef {{
 *   one: import("./operation.js").Route, bodies: [string, string, string][], parameters: any[],
 *   inputs: HTMLInputElement[], body: HTMLTextAreaElement | null, pick: HTMLSelectElement | null,
 *   accept: HTMLSelectElement | null, answer: HTMLElement, copied: HTMLElement,
 * }} Form
 */

/** @param {string} text */
const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** @param {string} text */
const rowsOf = (text) => Math.min(MOST_ROWS, text.split("\n").length + 1);

/**
 * A choice among words, null where there is none to make.
 * @param {string} label @param {string[]} words
 */
function selectOf(label, words) {
  if (words.length < 2) return null;
  return h("select", { "aria-label": label }, ...words.map((one) => h("option", {}, one)));
}

/** One of the route's example bodies into its field. @param {Form} form @param {number} number */
function fill({ body, bodies }, number) {
  if (!body) return;
  const [, , text] = bodies[number];
  body.value = text;
  body.rows = rowsOf(text);
}

/** The path with its parameters as they stand in the fields. @param {Form} form */
function targetOf({ one, parameters, inputs }) {
  return parameters.reduce((whole, parameter, i) => {
    const value = encodeURIComponent(inputs[i].value).replaceAll("%2F", "/");
    if (parameter.in === "path") return whole.replace(`{${parameter.name}}`, value);
    return `${whole}${whole.includes("?") ? "&" : "?"}${parameter.name}=${value}`;
  }, one.path);
}

/** @param {Form} form @returns {Record<string, string>} */
function headersOf({ accept, body }) {
  return {
    ...(accept ? { Accept: accept.value } : {}),
    ...(body ? { "Content-Type": "application/json" } : {}),
  };
}

/** @param {Form} form @param {HTMLButtonElement} run */
async function send(form, run) {
  const { one, body, answer } = form;
  run.disabled = true;
  const begun = performance.now();
  try {
    const headers = { ...headersOf(form), ...bearer() };
    const sent = body ? { body: body.value } : {};
    const reply = await fetch(urlOf(targetOf(form)), {
      method: one.method.toUpperCase(),
      headers,
      ...sent,
    });
    await showAnswer(reply, begun, answer);
  } catch (error) {
    const words = `There was no answer: ${/** @type {Error} */ (error).message}`;
    answer.replaceChildren(h("p", { class: "doc-status bad" }, words));
  }
  run.disabled = false;
}

/** The example as a command for a shell. @param {Form} form */
function commandOf(form) {
  const { one, body } = form;
  const fields = Object.entries(headersOf(form)).map(
    ([name, value]) => ` -H ${quoted(`${name}: ${value}`)}`,
  );
  const plain = one.method === "get" || one.method === "post";
  const verb = plain ? "" : ` -X ${one.method.toUpperCase()}`;
  const data = body ? ` -d ${quoted(body.value)}` : "";
  return `curl -s${verb} ${urlOf(targetOf(form))}${fields.join("")}${data}`;
}

/** @param {Form} form */
async function take(form) {
  await navigator.clipboard.writeText(commandOf(form));
  form.copied.textContent = "copied";
  setTimeout(() => {
    form.copied.textContent = "";
  }, SAID_MS);
}

/** A parameter's example; links are of this server. @param {any} parameter @returns {string} */
function exampleOf({ example = "", schema }) {
  if (schema?.format !== "uri") return String(example);
  const { pathname, search, hash } = new URL(example);
  return urlOf(pathname + search + hash);
}

/** @param {import("./operation.js").Route} one @param {Reader} reader @returns {Form} */
function formOf(one, reader) {
  const { operation } = one;
  const { bodies, types, parameters } = choicesOf(one, reader);
  const label = { spellcheck: "false", "aria-label": `Body of ${operation.summary}` };
  const inputs = parameters.map((parameter) => {
    const id = `${operation.operationId}-${parameter.name}`;
    return h("input", {
      type: "text",
      value: exampleOf(parameter),
      id,
      spellcheck: "false",
    });
  });
  return {
    one,
    bodies,
    parameters,
    inputs,
    body: bodies.length ? h("textarea", label) : null,
    pick: selectOf(
      `Example of ${operation.summary}`,
      bodies.map(([, summary]) => summary),
    ),
    accept: selectOf(`Form of the answer of ${operation.summary}`, types),
    answer: h("div", { class: "doc-answer", "aria-live": "polite" }),
    copied: h("span", { class: "doc-copied", role: "status" }),
  };
}

/**
 * The example of a route: fields to change, a button that runs it, the answer.
 * @param {import("./operation.js").Route} one @param {Reader} reader
 */
export function example(one, reader) {
  const form = formOf(one, reader);
  const { bodies, parameters, inputs, body, pick, accept, answer, copied } = form;
  const run = h("button", { type: "button", class: "button main" }, "Run");
  const copy = h("button", { type: "button", class: "button" }, "Copy as curl");
  run.addEventListener("click", () => send(form, run));
  copy.addEventListener("click", () => take(form));
  pick?.addEventListener("change", () => fill(form, pick.selectedIndex));
  if (bodies.length) fill(form, 0);
  if (isStatic) {
    run.disabled = true;
    answer.append("Examples run on a pendulumd server. This page is a folder without one.");
  }
  const fields = parameters.map((parameter, i) =>
    h("label", { class: "field" }, h("span", {}, parameter.name), inputs[i]),
  );
  const row = h("div", { class: "doc-row" }, run, copy, accept, copied);
  return h(
    "div",
    { class: "doc-example" },
    h("h4", {}, "Example"),
    pick,
    ...fields,
    body,
    row,
    answer,
  );
}
