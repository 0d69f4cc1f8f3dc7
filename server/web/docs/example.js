// The example of a route in words: the bodies that the description has for it, the forms of its
// answer, its parameters.
// Leaves to others: running it (run.js).
// Invariant: what is shown is the description's, laid out for a reader.

/** JSON on one line, with blanks where a reader wants them. @param {any} value @returns {string} */
function flat(value) {
  if (Array.isArray(value)) return `[${value.map(flat).join(", ")}]`;
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value)
    .map(([key, one]) => `${JSON.stringify(key)}: ${flat(one)}`)
    .join(", ")}}`;
}

/**
 * JSON with a line for each member; lists of numbers, and what is short, in one.
 * @param {any} value @param {string} indent @returns {string}
 */
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

/**
 * What a route can be asked for: {bodies: [[name, summary, text]], types, parameters}.
 * @param {import("./operation.js").Route} route @param {import("./schema.js").Reader} reader
 * @returns {{bodies: [string, string, string][], types: string[], parameters: any[]}}
 */
export function choicesOf({ path, operation }, reader) {
  const examples =
    reader.resolve(operation.requestBody)?.content?.["application/json"]?.examples ?? {};
  const success = Object.entries(operation.responses).find(([status]) => status.startsWith("2"));
  const types = Object.keys(reader.resolve(success?.[1])?.content ?? {});
  const parameters = (operation.parameters ?? [])
    .map(reader.resolve)
    .filter(
      (/** @type {any} */ one) =>
        (one.in === "path" && path.includes(`{${one.name}}`)) ||
        (one.in === "query" && one.required),
    );
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
