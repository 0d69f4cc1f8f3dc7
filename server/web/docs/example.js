// An example of a route: its request, to be changed and sent to this server, and what came back.
// Leaves to others: where it stands (operation.js).
// Invariant: asks this server alone; an answer of any size or kind is shown as far as it can be.

import { h } from "../dom.js";
import { bearer } from "../keep.js";

const SHOWN = 20000;
const KEPT = [
  "content-type",
  "content-length",
  "content-encoding",
  "etag",
  "location",
  "retry-after",
  "allow",
  "x-columns",
  "x-request-id",
  "cache-control",
];

/** JSON on one line, with blanks where a reader wants them. */
function flat(value) {
  if (Array.isArray(value)) return `[${value.map(flat).join(", ")}]`;
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value)
    .map(([key, one]) => `${JSON.stringify(key)}: ${flat(one)}`)
    .join(", ")}}`;
}

/** JSON with a line for each member; lists of numbers, and what is short, in one. */
export function pretty(value, indent = "") {
  const list = Array.isArray(value);
  const whole =
    value === null ||
    typeof value !== "object" ||
    (list && value.every((one) => typeof one === "number"));
  const deep =
    !whole && Object.values(value).some((one) => one !== null && typeof one === "object");
  if (whole || (flat(value).length < 70 && (list || !deep))) return flat(value);
  const inner = `${indent}  `;
  const parts = list
    ? value.map((one) => inner + pretty(one, inner))
    : Object.entries(value).map(
        ([key, one]) => `${inner}${JSON.stringify(key)}: ${pretty(one, inner)}`,
      );
  return `${list ? "[" : "{"}\n${parts.join(",\n")}\n${indent}${list ? "]" : "}"}`;
}

const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

const size = (bytes) =>
  bytes < 1000
    ? `${bytes} bytes`
    : bytes < 1e6
      ? `${(bytes / 1000).toFixed(1)} kB`
      : `${(bytes / 1e6).toFixed(2)} MB`;

/** What a route can be asked for: {bodies: [[name, summary, text]], types, parameters}. */
function choices({ path, operation }, reader) {
  const examples =
    reader.resolve(operation.requestBody)?.content?.["application/json"]?.examples ?? {};
  const success = Object.entries(operation.responses).find(([status]) => status.startsWith("2"));
  const types = Object.keys(reader.resolve(success?.[1])?.content ?? {});
  const parameters = (operation.parameters ?? [])
    .map(reader.resolve)
    .filter((one) => one.in === "path" && path.includes(`{${one.name}}`));
  return {
    bodies: Object.entries(examples).map(([name, one]) => [
      name,
      one.summary ?? name,
      pretty(one.value),
    ]),
    types,
    parameters,
  };
}

/** Shows an answer: status, time, size, header fields, body. */
async function show(reply, begun, place) {
  const bytes = new Uint8Array(await reply.arrayBuffer());
  const took = Math.round(performance.now() - begun);
  const type = reply.headers.get("Content-Type") ?? "";
  const blob = new Blob([bytes], { type });
  const headers = [...reply.headers].filter(([name]) => KEPT.includes(name)).sort();
  place.replaceChildren(
    h(
      "p",
      { class: reply.ok ? "doc-status good" : "doc-status bad" },
      h("strong", {}, `${reply.status} ${reply.statusText}`.trim()),
      ` · ${took} ms · ${size(bytes.length)}`,
    ),
    h(
      "details",
      { class: "doc-headers" },
      h("summary", {}, "Header fields"),
      h("dl", {}, ...headers.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
    ),
    ...bodyOf(bytes, type, blob),
  );
}

function bodyOf(bytes, type, blob) {
  if (!bytes.length) return [];
  const save = h("a", { href: URL.createObjectURL(blob), download: "answer" }, "Save the answer");
  if (type.startsWith("image/"))
    return [
      h("img", {
        src: save.href,
        alt: "The picture that was answered",
        class: "doc-answer-picture",
      }),
      save,
    ];
  if (!/json|text|csv|svg/.test(type))
    return [h("p", {}, `${size(bytes.length)} that are no text. `, save)];
  let text = new TextDecoder().decode(bytes.subarray(0, SHOWN));
  if (/json$/.test(type.split(";")[0]) && bytes.length <= SHOWN && !type.includes("ndjson")) {
    try {
      text = pretty(JSON.parse(text));
    } catch {
      // shown as it is
    }
  }
  const cut =
    bytes.length > SHOWN
      ? [h("p", {}, `The first ${size(SHOWN)} of ${size(bytes.length)}. `, save)]
      : [];
  return [h("pre", { tabindex: "0", "aria-label": "The answer's body" }, text), ...cut];
}

/** The example of a route: fields to change, a button that runs it, the answer. */
export function example(one, reader) {
  const { method, path, operation } = one;
  const { bodies, types, parameters } = choices(one, reader);
  const id = operation.operationId;
  const answer = h("div", { class: "doc-answer", "aria-live": "polite" });
  const body = bodies.length
    ? h("textarea", {
        spellcheck: "false",
        "aria-label": `Body of ${operation.summary}`,
        rows: String(Math.min(16, bodies[0][2].split("\n").length + 1)),
      })
    : null;
  const pick =
    bodies.length > 1
      ? h(
          "select",
          {
            "aria-label": `Example of ${operation.summary}`,
            on: { change: () => fill(pick.selectedIndex) },
          },
          ...bodies.map(([, summary]) => h("option", {}, summary)),
        )
      : null;
  const accept =
    types.length > 1
      ? h(
          "select",
          { "aria-label": `Form of the answer of ${operation.summary}` },
          ...types.map((type) => h("option", {}, type)),
        )
      : null;
  const inputs = parameters.map((parameter) =>
    h("input", {
      type: "text",
      value: String(parameter.example ?? ""),
      id: `${id}-${parameter.name}`,
      spellcheck: "false",
    }),
  );
  const copied = h("span", { class: "doc-copied", role: "status" });
  const run = h("button", { type: "button", class: "button main", on: { click: send } }, "Run");
  const copy = h(
    "button",
    { type: "button", class: "button", on: { click: take } },
    "Copy as curl",
  );

  function fill(number) {
    body.value = bodies[number][2];
    body.rows = Math.min(16, body.value.split("\n").length + 1);
  }

  const target = () =>
    parameters.reduce(
      (whole, parameter, i) =>
        whole.replace(
          `{${parameter.name}}`,
          encodeURIComponent(inputs[i].value).replaceAll("%2F", "/"),
        ),
      path,
    );

  function headers() {
    return {
      ...(accept ? { Accept: accept.value } : {}),
      ...(body ? { "Content-Type": "application/json" } : {}),
    };
  }

  async function send() {
    run.disabled = true;
    const begun = performance.now();
    try {
      await show(
        await fetch(target(), {
          method: method.toUpperCase(),
          headers: { ...headers(), ...bearer() },
          ...(body ? { body: body.value } : {}),
        }),
        begun,
        answer,
      );
    } catch (error) {
      answer.replaceChildren(
        h("p", { class: "doc-status bad" }, `There was no answer: ${error.message}`),
      );
    }
    run.disabled = false;
  }

  async function take() {
    const fields = Object.entries(headers())
      .map(([name, value]) => ` -H ${quoted(`${name}: ${value}`)}`)
      .join("");
    const verb = method === "get" || method === "post" ? "" : ` -X ${method.toUpperCase()}`;
    const data = body ? ` -d ${quoted(body.value)}` : "";
    await navigator.clipboard.writeText(
      `curl -s${verb} ${location.origin}${target()}${fields}${data}`,
    );
    copied.textContent = "copied";
    setTimeout(() => {
      copied.textContent = "";
    }, 2000);
  }

  if (body) fill(0);
  return h(
    "div",
    { class: "doc-example" },
    h("h4", {}, "Example"),
    pick,
    ...parameters.map((parameter, i) =>
      h("label", { class: "field" }, h("span", {}, parameter.name), inputs[i]),
    ),
    body,
    h("div", { class: "doc-row" }, run, copy, accept, copied),
    answer,
  );
}
