// An answer of the server, shown in the reference: status, time, size, header fields, body.
// Leaves to others: asking (run.js).
// Invariant: an answer of any size or kind is shown as far as it can be.

import { h } from "../dom.js";
import { pretty } from "./example.js";

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

/** @param {number} bytes */
function size(bytes) {
  if (bytes < 1000) return `${bytes} bytes`;
  return bytes < 1e6 ? `${(bytes / 1000).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}

/**
 * Shows an answer: status, time, size, header fields, body.
 * @param {Response} reply @param {number} begun @param {HTMLElement} place
 */
export async function showAnswer(reply, begun, place) {
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

/** @param {Uint8Array<ArrayBuffer>} bytes @param {string} type @param {Blob} blob */
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
