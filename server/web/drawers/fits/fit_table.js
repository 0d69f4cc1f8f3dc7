// A table of measurements as people have it, a file of Tracker's or of a spreadsheet: columns of
// numbers with their names, and what each of them is likely to be.
// Leaves to others: choosing (fits.js), the request (fit_request.js).
// Invariant: a fault names the line of the text, from 1; an empty cell was not measured.

const FAULTS = 5; // so many are told
const LINES = 50; // within so many lines the numbers begin
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;
const SEPARATORS = ["\t", ";", ",", " "];
const TIME = /^\s*(t|time|zeit|temps|tiempo|tijd|zaman)(?![\p{L}\d])/iu;
const ANGLE = /(θ|theta|winkel|angle|hoek|ángulo|angulo|açı)[ _]*θ?_?(\d*)/iu;
const PHI = /^\s*(φ|phi)_?(\d*)(?![\p{L}\d])/iu;
const PLACE = /^\s*([xy])_?(\d*)(?![\p{L}\d])/iu;
const RADIANS = 7; // angles that are larger are degrees

/** @typedef {{line: number, cell: string}} TableFault */

/** @typedef {{name: string, values: (number | null)[]}} FitColumn */

/** lines: of each row. @typedef {{columns: FitColumn[], lines: number[], faults: TableFault[]}}
 * FitTable */

/**
 * The cells of a line; in quotes a separator is a letter like any other.
 * @param {string} line @param {string} separator
 */
function cellsOf(line, separator) {
  if (separator === " ") return line.trim().split(/\s+/);
  /** @type {string[]} */
  const cells = [];
  let [cell, quoted] = ["", false];
  for (const letter of line) {
    if (letter === '"') quoted = !quoted;
    else if (letter === separator && !quoted) {
      cells.push(cell.trim());
      cell = "";
    } else cell += letter;
  }
  return [...cells, cell.trim()];
}

/** A number with a point or a comma; NaN if it is none. @param {string} cell */
function numberOf(cell) {
  const plain = cell.replace("\u2212", "-").replace(",", ".");
  return NUMBER.test(plain) ? Number(plain) : NaN;
}

/**
 * Whether a line is a row of at least two numbers.
 * @param {string} line @param {string} separator
 */
function isRow(line, separator) {
  const filled = cellsOf(line, separator).filter(Boolean);
  return filled.length > 1 && filled.every((cell) => !Number.isNaN(numberOf(cell)));
}

/** @param {string} line */
const bare = (line) => line.trim() === "" || line.trim().startsWith("#");

/**
 * What separates cells, and where the rows begin; null where there are no rows.
 * @param {string[]} lines
 */
function layoutOf(lines) {
  let found = null;
  for (const separator of SEPARATORS) {
    const first = lines.slice(0, LINES).findIndex((line) => !bare(line) && isRow(line, separator));
    if (first >= 0 && (!found || first < found.first)) found = { separator, first };
  }
  return found;
}

/**
 * Reads a table; null where there are no two columns of numbers.
 * @param {string} words @returns {FitTable | null}
 */
export function readTable(words) {
  const all = words.replace(/^\ufeff/, "").split(/\r\n|\r|\n/);
  const layout = layoutOf(all);
  if (!layout) return null;
  const { separator, first } = layout;
  const above = all.slice(0, first).findLast((line) => !bare(line));
  const names = above === undefined ? [] : cellsOf(above.replace(/^#/, ""), separator);
  const wide = Math.max(cellsOf(all[first], separator).length, names.length);
  /** @type {FitTable} */
  const table = { columns: [], lines: [], faults: [] };
  for (let i = 0; i < wide; i++) table.columns.push({ name: names[i] ?? "", values: [] });
  all.slice(first).forEach((line, i) => {
    if (!bare(line)) addRow(table, cellsOf(line, separator), first + i + 1);
  });
  table.columns = table.columns.filter(({ name, values }) => name || values.some(Number.isFinite));
  return table;
}

/** @param {FitTable} table @param {string[]} cells @param {number} line */
function addRow({ columns, lines, faults }, cells, line) {
  lines.push(line);
  columns.forEach(({ values }, k) => {
    const cell = cells[k] ?? "";
    const value = cell === "" ? null : numberOf(cell);
    if (Number.isNaN(value) && faults.length < FAULTS) faults.push({ line, cell });
    values.push(value);
  });
}

/** What columns can be: "t", "theta 1", "phi 1", "x 1", "y 1"; "" is nothing.
 * @typedef {string} Role */

/**
 * What an angle or a place is by its name; the i-th of a kind is of arm i, where none is named.
 * @param {string} name @param {number} n @param {Record<string, number>} seen @returns {Role}
 */
function roleOf(name, n, seen) {
  if (/rad\/s|ω|omega|°\/s|m\/s/i.test(name)) return "";
  const place = PLACE.exec(name);
  const phi = PHI.exec(name);
  const angle = ANGLE.exec(name);
  const kind = place ? place[1].toLowerCase() : phi ? "phi" : angle ? "theta" : "";
  if (!kind) return "";
  const arm = Number((place ?? phi ?? angle)?.[2]) || (seen[kind] ?? 0) + 1;
  seen[kind] = Math.max(seen[kind] ?? 0, arm);
  return arm <= n ? `${kind} ${arm}` : "";
}

/** @param {(number | null)[]} values */
const rises = (values) =>
  values.length > 1 && values.every((one, i) => one !== null && (!i || one > (values[i - 1] ?? 0)));

/**
 * What the columns are likely to be, of a pendulum of n arms.
 * @param {FitTable} table @param {number} n @returns {Role[]}
 */
export function guessRoles({ columns }, n) {
  const named = columns.findIndex(({ name }) => TIME.test(name));
  const time = named >= 0 ? named : columns.findIndex(({ values }) => rises(values));
  /** @type {Record<string, number>} */
  const seen = {};
  const roles = columns.map(({ name }, k) => (k === time ? "t" : roleOf(name, n, seen)));
  const bareOnes = roles.every((role) => role === "" || role === "t");
  // one column beside the time and no word of what it is: an angle
  if (!bareOnes || columns.length !== 2 || time < 0) return roles;
  return columns.map((_, k) => (k === time ? "t" : "theta 1"));
}

/** "deg" or "rad", by the names of the columns of angles, or by how large they are.
 * @param {FitTable} table @param {Role[]} roles */
export function guessAngle({ columns }, roles) {
  const angles = columns.filter((_, k) => /^(theta|phi)/.test(roles[k]));
  if (angles.some(({ name }) => /°|deg|grad\b/i.test(name))) return "deg";
  if (angles.some(({ name }) => /\brad/i.test(name))) return "rad";
  const large = angles.some(({ values }) => values.some((one) => Math.abs(one ?? 0) > RADIANS));
  return large ? "deg" : "rad";
}

/**
 * The unit of places by the names of their columns, or by how far they go, in parts of how far the
 * pendulum reaches: "m", "cm", "mm", or "px" for an unknown one.
 * @param {FitTable} table @param {Role[]} roles @param {number} reach m
 */
export function guessPlace({ columns }, roles, reach) {
  const places = columns.filter((_, k) => /^[xy]/.test(roles[k]));
  for (const unit of ["mm", "cm", "px", "m"])
    if (places.some(({ name }) => new RegExp(`\\b${unit}\\b`).test(name))) return unit;
  const sizes = places.flatMap(({ values }) => values.map((one) => Math.abs(one ?? 0)));
  const far = sizes.reduce((most, one) => Math.max(most, one), 0) / reach;
  if (far > 0.2 && far < 2) return "m";
  return far > 20 && far < 130 ? "cm" : "px";
}
