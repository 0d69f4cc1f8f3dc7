// Files of measurements as text: text in any encoding, spreadsheets (.xlsx) and archives of tables,
// as phyphox writes them.
// Leaves to others: what the table means (the engine).
// Invariant: nothing is sent anywhere; a file that is none of these answers null.

const BINARY = /[\0-\x08\x0e-\x1f]/; // no text holds these
const [DIRECTORY, ENTRY] = [0x06054b50, 0x02014b50]; // ends of a zip archive, and its entries
const TABLE = /\.(csv|tsv|txt|dat)$/i;
const ABOUT = /(^|\/)(meta|__MACOSX)\//; // what phyphox and macOS add

/** Text in UTF-8, UTF-16 or, if it is neither, Windows-1252. @param {Uint8Array} bytes */
function decoded(bytes) {
  const wide = { "255,254": "utf-16le", "254,255": "utf-16be" }[bytes.slice(0, 2).join()];
  try {
    return new TextDecoder(wide ?? "utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/** The files of a zip archive: name, size, and the bytes. @param {Uint8Array} bytes */
function entriesOf(bytes) {
  const view = new DataView(bytes.buffer);
  const short = (/** @type {number} */ at) => view.getUint16(at, true);
  const long = (/** @type {number} */ at) => view.getUint32(at, true);
  let end = bytes.length - 22;
  while (end >= 0 && long(end) !== DIRECTORY) end--;
  const list = [];
  let at = end < 0 ? 0 : long(end + 16);
  for (let left = end < 0 ? 0 : short(end + 10); left && long(at) === ENTRY; left--) {
    const begin = long(at + 42);
    const from = begin + 30 + short(begin + 26) + short(begin + 28);
    const part = new Blob([bytes.slice(from, from + long(at + 20))]);
    const packed = short(at + 10);
    const read = async () => {
      const stream = part.stream().pipeThrough(new DecompressionStream("deflate-raw"));
      return decoded(new Uint8Array(await new Response(packed ? stream : part).arrayBuffer()));
    };
    const name = decoded(bytes.slice(at + 46, at + 46 + short(at + 28)));
    list.push({ name, size: long(at + 24), read });
    at += 46 + short(at + 28) + short(at + 30) + short(at + 32);
  }
  return list;
}

/** Elements of a file in an archive. @param {{read(): Promise<string>} | undefined} part
 * @param {string} name */
const elements = async (part, name) =>
  part
    ? [...new DOMParser().parseFromString(await part.read(), "text/xml").querySelectorAll(name)]
    : [];

/** The text in an element, without phonetic hints. @param {Element} element */
const wordsIn = (element) => [...element.querySelectorAll("t")].map((t) => t.textContent).join("");

/** The column of a cell, from 1: "AB12" is 28. @param {string | null} name */
const columnOf = (name) =>
  [...(/^[A-Z]*/.exec(name ?? "")?.[0] ?? "")].reduce((at, c) => at * 26 + parseInt(c, 36) - 9, 0);

/** The first sheet, cells between tabs. @param {ReturnType<typeof entriesOf>} entries */
async function sheetOf(entries) {
  const part = (/** @type {RegExp} */ like) => entries.find(({ name }) => like.test(name));
  const words = (await elements(part(/^xl\/sharedStrings/), "si")).map(wordsIn);
  const sheet = part(/^xl\/worksheets\/sheet1\./) ?? part(/^xl\/worksheets\//);
  const lines = (await elements(sheet, "row")).map((row) => {
    /** @type {string[]} */
    const cells = [];
    for (const cell of row.querySelectorAll("c")) {
      const value = cell.querySelector("v")?.textContent ?? wordsIn(cell);
      const own = cell.getAttribute("t") === "s" ? words[Number(value)] : value;
      cells[columnOf(cell.getAttribute("r")) - 1] = own.replaceAll(/[\t\r\n]/g, " ");
    }
    return cells.join("\t");
  });
  return lines.join("\n");
}

/** A file's table as text, of an archive its largest; null where it is none. @param {File} file */
export async function wordsOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const entries = bytes[0] === 0x50 && bytes[1] === 0x4b ? entriesOf(bytes) : [];
  if (entries.some(({ name }) => name.startsWith("xl/"))) return sheetOf(entries);
  const tables = entries.filter(({ name }) => TABLE.test(name) && !ABOUT.test(name));
  const [largest] = tables.sort((a, b) => b.size - a.size);
  const words = largest ? await largest.read() : decoded(bytes);
  return BINARY.test(words) ? null : words;
}
