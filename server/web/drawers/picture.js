// Charts as one picture for paper: SVG text, and PNG made of it.
// Leaves to others: what is in it; saving.
// Invariant: black on white whatever the theme; the same panels give the same text.

import { figure } from "./kit.js";

const WIDE = 900;
const LEFT = 92;
const RIGHT = 20;
const GAP = 46;

const escape = (words) => words.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);

/** Round numbers between two, about `many` of them. */
export function ticks(low, high, many = 5) {
  const raw = (high - low) / many;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((part) => part * power >= raw) ?? 10);
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++)
    list.push(i * step);
  return list;
}

function bounds(lists) {
  let low = Infinity;
  let high = -Infinity;
  for (const list of lists) {
    for (const value of list) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low < high))
    return Number.isFinite(low)
      ? [low - (Math.abs(low) || 1) * 0.1, low + (Math.abs(low) || 1) * 0.1]
      : [0, 1];
  const room = (high - low) * 0.05;
  return [low - room, high + room];
}

function path(xs, ys, px, py) {
  const parts = [];
  for (let i = 0; i < ys.length; i++)
    parts.push(`${i ? "L" : "M"}${px(xs[i]).toFixed(1)} ${py(ys[i]).toFixed(1)}`);
  return parts.join("");
}

function panelSvg(panel, top, height, text) {
  const [x0, x1] = panel.x ?? bounds(panel.series.map((one) => one.xs));
  const [y0, y1] = bounds(panel.series.map((one) => one.ys));
  const px = (x) => LEFT + ((x - x0) / (x1 - x0)) * (WIDE - LEFT - RIGHT);
  const py = (y) => top + height - ((y - y0) / (y1 - y0)) * height;
  const grid = [
    ...ticks(x0, x1, 8).map(
      (x) =>
        `<path d="M${px(x).toFixed(1)} ${top}v${height}"/><text x="${px(x).toFixed(1)}" y="${top + height + 16}" text-anchor="middle">${escape(figure(text, x))}</text>`,
    ),
    ...ticks(y0, y1, 4).map(
      (y) =>
        `<path d="M${LEFT} ${py(y).toFixed(1)}h${WIDE - LEFT - RIGHT}"/><text x="${LEFT - 8}" y="${(py(y) + 4).toFixed(1)}" text-anchor="end">${escape(figure(text, y))}</text>`,
    ),
  ];
  const lines = panel.series.map(
    (one) =>
      `<path d="${path(one.xs, one.ys, px, py)}" fill="none" stroke="${one.colour}" stroke-width="1.5" stroke-linejoin="round"${one.dash ? ` stroke-dasharray="${one.dash.join(" ")}"` : ""}/>`,
  );
  let at = WIDE - RIGHT;
  const names = [...panel.series].reverse().map((one) => {
    at -= one.name.length * 7 + 34;
    return `<path d="M${at} ${top - 12}h18" stroke="${one.colour}" stroke-width="2.5"${one.dash ? ` stroke-dasharray="${one.dash.join(" ")}"` : ""}/><text x="${at + 22}" y="${top - 8}">${escape(one.name)}</text>`;
  });
  return (
    `<g stroke="#ddd" fill="#555"><g>${grid.join("").replaceAll("<text", '<text stroke="none"')}</g></g>` +
    `<text x="${LEFT}" y="${top - 8}" font-weight="600">${escape(panel.title)}</text><g fill="#333">${names.join("")}</g>${lines.join("")}`
  );
}

/** panels [{title, x: [from, to] or none, height, series: [{name, colour, dash, xs, ys}]}] as SVG. */
export function svgOf(panels, title, text) {
  let top = 64;
  const parts = [];
  for (const panel of panels) {
    const height = panel.height ?? 150;
    parts.push(panelSvg(panel, top, height, text));
    top += height + GAP + 14;
  }
  return (
    `<svg xmlns="http://www.w3.org/2000/svg" width="${WIDE}" height="${top - 20}" viewBox="0 0 ${WIDE} ${top - 20}" font-family="system-ui, sans-serif" font-size="12">` +
    `<rect width="100%" height="100%" fill="#fff"/><text x="${LEFT}" y="26" font-size="16" font-weight="600">${escape(title)}</text>${parts.join("")}</svg>\n`
  );
}

/** The picture of an SVG text, twice as fine. */
export async function pngOf(svg) {
  const url = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  const image = new Image();
  image.src = url;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth * 2;
  canvas.height = image.naturalHeight * 2;
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(url);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
