// A link as a QR code, and a word where nobody else can follow it.
// Leaves to others: the code itself (qrcode-generator), which links there are (share.js).
// Invariant: black on white with the margin that cameras need, whatever the theme.

import { h, svg } from "../../dom.js";

const OWN = /^(localhost|127\.|\[::1\])/;
export const LONGEST = 1200; // letters of a link that a camera still reads off a projector
const MARGIN = 4;
const LONG = 300; // letters, from which on a code corrects fewer errors

/** That other machines cannot reach this address, false where they can. @param {Text} text */
export const localOf = (text) =>
  OWN.test(location.hostname) && h("p", { class: "fault", role: "alert" }, text("share.local"));

/** The dark squares as a path. @param {any} code */
function squares(code) {
  const count = code.getModuleCount();
  const parts = [];
  for (let row = 0; row < count; row++) {
    for (let column = 0; column < count; column++) {
      if (code.isDark(row, column)) parts.push(`M${column + MARGIN} ${row + MARGIN}h1v1h-1z`);
    }
  }
  return parts.join("");
}

/**
 * The code of some letters.
 * @param {any} qrcode the library @param {string} letters @param {string} label
 */
export function qrOf(qrcode, letters, label) {
  const code = qrcode(0, letters.length > LONG ? "L" : "M");
  code.addData(letters);
  code.make();
  const side = code.getModuleCount() + 2 * MARGIN;
  const attributes = {
    viewBox: `0 0 ${side} ${side}`,
    class: "qr",
    role: "img",
    "aria-label": label,
    "shape-rendering": "crispEdges",
  };
  return svg("svg", attributes, svg("path", { d: squares(code) }));
}
