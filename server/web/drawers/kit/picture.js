// Charts as one picture for paper: SVG text, and PNG made of it.
// Leaves to others: what is in it; saving.
// Invariant: black on white whatever the theme; the same panels give the same text.

import { figure } from "./kit.js";

const WIDE = 900;
const LEFT = 92;
const RIGHT = 20;
const GAP = 46;

/**
 * A curve of a panel.
 * @typedef {{name: string, colour: string, dash?: number[] | null, xs: ArrayLike<number>, ys:
 * ArrayLike<number>}} PanelSeries
 */

/**
 * @typedef {{title: string, x?: [number, number], height?: number, series: PanelSeries[]}} Panel
 */

/** @param {string} words */
const escape = (words) => words.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);

/**
 * Round numbers between two, about `many` of them.
 * @param {number} low @param {number} high @param {number} many
 */
export function ticks(low, high, many = 5) {
  const raw = (high - low) / many;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((part) => part * power >= raw) ?? 10);
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++)
    list.push(i * step);
  return list;
}

/** @param {ArrayLike<number>[]} lists @returns {[number, number]} */
function bounds(lists) {
  let low = Infinity;
  let high = -Infinity;
  for (const list of lists) {
    for (let i = 0; i < list.length; i++) {
      if (list[i] < low) low = list[i];
      if (list[i] > high) high = list[i];
    }
  }
  if (!Number.isFinite(low)) return [0, 1];
  const room = low < high ? (high - low) * 0.05 : (Math.abs(low) || 1) * 0.1;
  return [low - room, high + room];
}

/**
 * @param {ArrayLike<number>} xs @param {ArrayLike<number>} ys @param {(x: number) => number} px
 * @param {(y: number) => number} py
 */
function path(xs, ys, px, py) {
  const parts = [];
  for (let i = 0; i < ys.length; i++)
    parts.push(`${i ? "L" : "M"}${px(xs[i]).toFixed(1)} ${py(ys[i]).toFixed(1)}`);
  return parts.join("");
}

/**
 * Where numbers lie in a panel.
 * @typedef {{x0: number, x1: number, y0: number, y1: number, px(x: number): number, py(y: number):
 * number}} Scale
 */

/** @param {Panel} panel @param {number} top @param {number} height @returns {Scale} */
function scaleOf(panel, top, height) {
  const [x0, x1] = panel.x ?? bounds(panel.series.map((one) => one.xs));
  const [y0, y1] = bounds(panel.series.map((one) => one.ys));
  return {
    x0,
    x1,
    y0,
    y1,
    px: (x) => LEFT + ((x - x0) / (x1 - x0)) * (WIDE - LEFT - RIGHT),
    py: (y) => top + height - ((y - y0) / (y1 - y0)) * height,
  };
}

/**
 * Lines and numbers of both axes.
 * @param {Scale} scale @param {number} top @param {number} height @param {Text} text
 */
function gridSvg({ x0, x1, y0, y1, px, py }, top, height, text) {
  const wide = WIDE - LEFT - RIGHT;
  const vertical = ticks(x0, x1, 8).map((x) => {
    const at = px(x).toFixed(1);
    const words = escape(figure(text, x));
    const label = `<text x="${at}" y="${top + height + 16}" text-anchor="middle">${words}</text>`;
    return `<path d="M${at} ${top}v${height}"/>${label}`;
  });
  const level = ticks(y0, y1, 4).map((y) => {
    const words = escape(figure(text, y));
    const label = `<text x="${LEFT - 8}" y="${(py(y) + 4).toFixed(1)}" text-anchor="end">${words}</text>`;
    return `<path d="M${LEFT} ${py(y).toFixed(1)}h${wide}"/>${label}`;
  });
  const all = [...vertical, ...level].join("").replaceAll("<text", '<text stroke="none"');
  return `<g stroke="#ddd" fill="#555"><g>${all}</g></g>`;
}

/** @param {PanelSeries} one */
const dashOf = ({ dash }) => (dash ? ` stroke-dasharray="${dash.join(" ")}"` : "");

/**
 * The curves' names with a bit of each curve, from the right.
 * @param {Panel} panel @param {number} top
 */
function namesSvg({ series }, top) {
  let at = WIDE - RIGHT;
  const names = [...series].reverse().map((one) => {
    at -= one.name.length * 7 + 34;
    const line = `<path d="M${at} ${top - 12}h18" stroke="${one.colour}" stroke-width="2.5"${dashOf(one)}/>`;
    return `${line}<text x="${at + 22}" y="${top - 8}">${escape(one.name)}</text>`;
  });
  return `<g fill="#333">${names.join("")}</g>`;
}

/** @param {Panel} panel @param {number} top @param {number} height @param {Text} text */
function panelSvg(panel, top, height, text) {
  const scale = scaleOf(panel, top, height);
  const lines = panel.series.map((one) => {
    const look = `stroke="${one.colour}" stroke-width="1.5" stroke-linejoin="round"${dashOf(one)}`;
    return `<path d="${path(one.xs, one.ys, scale.px, scale.py)}" fill="none" ${look}/>`;
  });
  const title = `<text x="${LEFT}" y="${top - 8}" font-weight="600">${escape(panel.title)}</text>`;
  return gridSvg(scale, top, height, text) + title + namesSvg(panel, top) + lines.join("");
}

/**
 * Panels, one below the other, as SVG.
 * @param {Panel[]} panels @param {string} title @param {Text} text
 */
export function svgOf(panels, title, text) {
  let top = 64;
  const parts = [];
  for (const panel of panels) {
    const height = panel.height ?? 150;
    parts.push(panelSvg(panel, top, height, text));
    top += height + GAP + 14;
  }
  const tall = top - 20;
  const size = `width="${WIDE}" height="${tall}" viewBox="0 0 ${WIDE} ${tall}"`;
  const font = `font-family="system-ui, sans-serif" font-size="12"`;
  const head = `<text x="${LEFT}" y="26" font-size="16" font-weight="600">${escape(title)}</text>`;
  const paper = `<rect width="100%" height="100%" fill="#fff"/>`;
  return `<svg xmlns="http://www.w3.org/2000/svg" ${size} ${font}>${paper}${head}${parts.join("")}</svg>\n`;
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
