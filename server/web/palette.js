// The colours of a canvas: those of the forces' scale, of ghosts and trails, as the page's style
// names them.
// Leaves to others: the colours themselves (style.css), strokes (paint.js).
// Invariant: made anew when the theme or the palette changes, never in a frame.

export const BINS = 49; // odd: the middle one is no force
export const MIDDLE = (BINS - 1) / 2;

/** @type {Record<string, string[]>} */
const NAMES = {
  safe: ["--tension", "--no-force", "--compression"],
  paper: ["--paper-tension", "--no-force", "--paper-compression"],
};
const PLAIN = "#808080"; // where the style has not come
// of the arms' colours, those least like tension and compression first
const GHOSTS = [4, 3, 5, 7, 6, 8];

/** @param {number[]} a @param {number[]} b @param {number} share */
function mix(a, b, share) {
  return a.map((value, i) => Math.round(value + share * (b[i] - value)));
}

/** @param {string} hex "#rrggbb" */
function rgb(hex) {
  const digits = (hex.trim() || PLAIN).slice(1);
  return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16));
}

/**
 * The property that holds the colour of the `i`th ghost, on the stage and wherever it is marked.
 * @param {number} i
 */
export const ghostColour = (i) => `--arm-${GHOSTS[i % GHOSTS.length]}`;

/**
 * The colours of the page's style, as a canvas takes them.
 * @param {string} palette @returns {Colours}
 */
export function readColours(palette) {
  const style = getComputedStyle(document.documentElement);
  /** @param {string} name */
  const value = (name) => style.getPropertyValue(name).trim();
  const family = getComputedStyle(document.body).fontFamily;
  const [low, none, high] = NAMES[palette].map((name) => rgb(value(name)));
  const bins = Array.from({ length: BINS }, (_, i) => {
    const share = (i - MIDDLE) / MIDDLE;
    // soon away from grey, so that small forces show their sign
    const strong = Math.sqrt(Math.abs(share));
    return `rgb(${mix(none, share < 0 ? low : high, strong).join(",")})`;
  });
  return {
    bins,
    font: `${"projector" in document.documentElement.dataset ? 24 : 13}px ${family}`,
    ink: value("--ink"),
    quiet: value("--quiet"),
    glass: value("--glass"),
    accent: value("--accent"),
    paper: value("--stage"),
    mass: value("--mass"),
    ghosts: GHOSTS.map((_, i) => value(ghostColour(i))),
    trails: [1, 2, 3, 4, 5].map((i) => value(`--trail-${i}`)),
  };
}

/**
 * The colour's place, 0 ... BINS-1, of a force, `most` being the end of the scale.
 * @param {number} force @param {number} most
 */
export function bin(force, most) {
  const share = most > 0 ? Math.max(-1, Math.min(1, force / most)) : 0;
  return Math.round(MIDDLE + share * MIDDLE);
}
