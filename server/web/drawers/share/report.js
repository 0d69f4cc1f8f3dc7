// A report on paper: the stage as it stands, the pendulum's numbers, what is read from its motion,
// its plots, the settings, the link with its code. Loaded when it is asked for.
// Leaves to others: the paper (the browser), the look (report.css), the plots' picture
// (picture.js).
// Invariant: light whatever the theme; every number is of the motion that is shown; the page is as
// it was when the printing is over.

import { thetaOf } from "../../angles.js";
import { h } from "../../dom.js";
import { request } from "../../state.js";
import { NUMBERS } from "../measure/gauge_numbers.js";
import { readings } from "../measure/gauge_words.js";
import { figure } from "../kit/kit.js";
import { addressOf, linkTo } from "../../address.js";
import { handedOn, linkOf } from "../../link.js";
import { panelOf } from "../kit/any_chart.js";
import { svgOf } from "../kit/picture.js";
import { panelsOf } from "../kit/plot_data.js";
import { farthestOf, formulaOf, periodOf, periodWords, swingsOf } from "../measure/periods.js";
import { LONGEST, localOf, qrOf } from "../kit/qr.js";

const MOST_ARMS = 12; // rows of a table; the request at the end has all
const DASH = "\u2013";

/** @typedef {import("../measure/gauge_numbers.js").Gauge} Gauge */

/** @param {string[]} heads @param {string[][]} rows */
const tableOf = (heads, rows) =>
  h(
    "table",
    {},
    h("thead", {}, h("tr", {}, ...heads.map((words) => h("th", { scope: "col" }, words)))),
    h("tbody", {}, ...rows.map((cells) => h("tr", {}, ...cells.map((cell) => h("td", {}, cell))))),
  );

/** Names with their values. @param {[string, string][]} list */
const namedOf = (list) =>
  h("dl", {}, ...list.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));

/** An image that is there. @param {Blob} blob @param {string} words @param {string[]} urls */
async function imageOf(blob, words, urls) {
  const url = URL.createObjectURL(blob);
  urls.push(url);
  const image = h("img", { src: url, alt: words });
  await image.decode();
  return image;
}

/** The stage as it stands, on white. @returns {Promise<Blob>} */
function stagePicture() {
  const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector("#stage .canvas"));
  const paper = h("canvas", { width: canvas.width, height: canvas.height });
  const context = /** @type {CanvasRenderingContext2D} */ (paper.getContext("2d"));
  context.fillStyle = "#fff";
  context.fillRect(0, 0, paper.width, paper.height);
  context.drawImage(canvas, 0, 0);
  return new Promise((resolve, reject) => {
    paper.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no picture"))), "image/png");
  });
}

/** Arms by their numbers. @param {App} app */
function pendulumOf({ store, text }) {
  const { pendulum, initial } = store.get();
  const heads = ["arm.length", "arm.mass", "arm.angle", "arm.rate"].map((key) => text(key));
  const units = ["m", "kg", "\u00b0", "rad/s"];
  const rows = pendulum.length.slice(0, MOST_ARMS).map((length, k) => {
    const carrier = pendulum.parent[k];
    const on = carrier ? text("arm.on", { carrier }) : text("arm.on.pivot");
    const { phi, phid } = initial;
    const values = [length, pendulum.mass[k], Number(thetaOf(phi[k]).toFixed(6)), phid[k]];
    const cells = values.map((value, i) => `${figure(text, value, 6)} ${units[i]}`);
    return [`${text("arm.name", { arm: k + 1 })} ${on}`, ...cells];
  });
  const gravity = `${figure(text, pendulum.gravity, 6)} m/s\u00b2`;
  return [tableOf(["", ...heads], rows), namedOf([[text("arm.gravity"), gravity]])];
}

/** Periods of all arms, and what the ruler and the protractor read. @param {App} app */
function readOf({ store, motion, text }) {
  const { view } = store.get();
  const seconds = (/** @type {number | undefined} */ time) =>
    Number.isFinite(time) ? text("seconds", { time: text.number(Number(time), 4) }) : DASH;
  const arms = Math.min(motion.n, MOST_ARMS);
  const rows = Array.from({ length: arms }, (_, k) => {
    const swings = swingsOf(motion.track, k + 1);
    const found = periodOf(swings.times);
    const words = found && periodWords(found, text);
    const period = words ? `${words.period}${words.swings && ` (${words.swings})`}` : DASH;
    const formula = formulaOf(motion.doc.pendulum);
    const name = text("arm.name", { arm: k + 1 });
    return [name, period, seconds(formula), farthestOf(swings, text)];
  });
  const heads = ["measure.true", "measure.formula", "measure.amplitude"].map((key) => text(key));
  const gauges = /** @type {Gauge[]} */ (Object.keys(NUMBERS)).filter(
    (gauge) => view[gauge]?.length,
  );
  /** @type {[string, string][]} */
  const read = gauges.map((gauge) => [
    text(`measure.${gauge}`),
    readings(text, gauge, view[gauge] ?? []),
  ]);
  return [tableOf(["", ...heads], rows), namedOf(read)];
}

/** How it is computed. @param {App} app */
function settingsOf({ store, motion, text }) {
  const doc = store.get();
  const { stats } = motion;
  const metres = (/** @type {number} */ time) => `${figure(text, time, 6)} s`;
  /** @type {[string, string][]} */
  const list = [
    [text("drawer.method"), text(`method.${doc.method}`)],
    [text("time.until"), metres((doc.span.start ?? 0) + doc.span.stop)],
  ];
  if (doc.rtol !== null) list.push([text("method.rtol"), figure(text, doc.rtol)]);
  if (doc.atol !== null) list.push([text("method.atol"), figure(text, doc.atol)]);
  list.push([text("method.precision"), text(`method.${doc.precision}`)]);
  if (stats) list.push([text("method.drift"), figure(text, stats.energy_drift ?? NaN)]);
  const horizon = stats?.horizon;
  if (horizon !== undefined) list.push([text("method.trust"), metres(horizon)]);
  return [
    namedOf(list),
    h("h3", {}, text("report.request")),
    h("pre", {}, JSON.stringify(request(doc))),
  ];
}

/**
 * @param {App} app @param {string} link @param {any} qrcode the library, null where the link is too
 * long for a code @param {string[]} urls
 */
async function paperOf(app, link, qrcode, urls) {
  const { store, motion, clock, text } = app;
  const title = store.get().title || text("name");
  const time = text.number((motion.doc.span.start ?? 0) + clock.time, 2);
  const at = text("report.at", { time });
  const hidden = new Set(Array.from({ length: motion.n }, (_, k) => k).filter((k) => k >= 8));
  const arm = store.get().view.selected || 1;
  const portrait = panelOf(motion, text, [`theta_${arm}`, `omega_${arm}`], true);
  const panels = panelsOf(motion, text, [0, clock.duration], hidden, true, portrait);
  const svg = svgOf(panels, title, text);
  const plots = new Blob([svg], { type: "image/svg+xml" });
  const made = new Date().toLocaleString(text.language, { dateStyle: "long", timeStyle: "short" });
  const stage = await imageOf(await stagePicture(), at, urls);
  const curves = await imageOf(plots, text("plots.title"), urls);
  const code = qrcode ? qrOf(qrcode, link, text("report.link")) : "";
  return h(
    "article",
    { class: "print-report", lang: text.language },
    h("h1", {}, title),
    h("p", { class: "report-made" }, made),
    h("figure", {}, stage, h("figcaption", {}, at)),
    h("section", {}, h("h2", {}, text("report.pendulum")), ...pendulumOf(app)),
    h("section", {}, h("h2", {}, text("report.read")), ...readOf(app)),
    h("section", { class: "report-plots" }, h("h2", {}, text("plots.title")), curves),
    h("section", {}, h("h2", {}, text("report.settings")), ...settingsOf(app)),
    h(
      "section",
      { class: "report-link" },
      h("h2", {}, text("report.link")),
      code,
      h("p", {}, link),
      localOf(text),
    ),
  );
}

/** Two frames later, when what has changed is drawn. */
const drawn = () =>
  new Promise((resolve) => {
    requestAnimationFrame(() => requestAnimationFrame(resolve));
  });

/** Prints the document as a report, with the readable link if there is one; or what `make` makes.
 * @param {App} app @param {() => HTMLElement} [make] */
export default async function printReport(app, make) {
  const { theme, files, text, store } = app;
  const doc = store.get();
  const link = linkTo(text, addressOf(doc) ?? (await linkOf(handedOn(doc))));
  const { default: qrcode } = await files.script("lib/qrcode.js");
  /** @type {string[]} */
  const urls = [];
  const words = ["drawers", "measure"].map((name) => text.part(name));
  await Promise.all([files.style("drawers/share/report.css"), ...words]);
  app.clock.pause();
  theme.paper(true);
  /** @type {HTMLElement | null} */
  let paper = null;
  const end = () => {
    paper?.remove();
    document.body.classList.remove("reporting");
    urls.forEach((url) => URL.revokeObjectURL(url));
    theme.paper(false);
  };
  try {
    await drawn();
    const code = link.length > LONGEST ? null : qrcode;
    paper = make?.() ?? (await paperOf(app, link, code, urls));
  } catch (error) {
    end();
    throw error;
  }
  document.body.append(paper);
  document.body.classList.add("reporting");
  window.addEventListener("afterprint", end, { once: true });
  window.print();
}
