// Charts as one picture for paper: SVG text, and PNG made of it.
// Leaves to others: what is in it; the curves (plot.js); saving.
// Invariant: black on white whatever the theme; the same panels give the same text.

import { svg } from "../../dom.js";
import { drawn, longest, nameWidth } from "./plot.js";

const WIDE = 900;
const LEFT = 92;
const GAP = 60;
const TYPE = 12;

/**
 * A curve of a panel.
 * @typedef {{name: string, colour: string, dash?: number[] | null, xs: ArrayLike<number>, ys:
 * ArrayLike<number>}} PanelSeries
 */

/**
 * @typedef {{title: string, x?: [number, number], degrees?: string, height?: number,
 * series: PanelSeries[]}} Panel
 */

/**
 * Panels, one below the other, as SVG.
 * @param {Panel[]} panels @param {string} title @param {Text} text
 */
export function svgOf(panels, title, text) {
  let top = 64;
  const bold = { x: LEFT, "font-weight": 600 };
  const right = 20 + Math.max(0, ...panels.map(({ series }) => nameWidth(longest(series), TYPE)));
  const parts = panels.flatMap(({ x: from, degrees, series: curves, height = 150, ...panel }) => {
    const y = top;
    const box = { x: LEFT, y, wide: WIDE - LEFT - right, tall: height };
    top += height + GAP;
    const picture = { from, degrees, curves };
    const all = drawn(picture, box, text, TYPE, "#ddd", "#555").parts;
    return [...all, svg("text", { ...bold, y: y - 8 }, panel.title)];
  });
  const tall = top - 20;
  const paper = svg("rect", { width: "100%", height: "100%", fill: "#fff" });
  const head = svg("text", { ...bold, y: 26, "font-size": 16 }, title);
  const size = { width: WIDE, height: tall, viewBox: `0 0 ${WIDE} ${tall}` };
  const font = { "font-family": "system-ui, sans-serif", "font-size": TYPE };
  const all = svg("svg", { ...size, ...font }, paper, head, ...parts);
  return `${new XMLSerializer().serializeToString(all)}\n`;
}

/** The picture of an SVG text, twice as fine. @param {string} svg @returns {Promise<Blob>} */
export async function pngOf(svg) {
  const url = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  const image = new Image();
  image.src = url;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth * 2;
  canvas.height = image.naturalHeight * 2;
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(url);
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no picture"))), "image/png");
  });
}
