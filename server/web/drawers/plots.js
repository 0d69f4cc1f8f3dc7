// Plots: small multiples on one time axis (angles, velocities, forces, energies, their drift), a phase portrait, and exports.
// Leaves to others: the charts (chart.js), the phase portrait (portrait.js), pictures for paper (picture.js).
// Invariant: every number shown is a sample of the server's; files of numbers are asked from the server.

import { createBag, h, iconButton } from "../dom.js";
import { request } from "../state.js";
import { theme } from "../theme.js";
import { said } from "../client.js";
import { createGroup } from "./chart.js";
import {
  aborted,
  armLook,
  button,
  choice,
  cssValue,
  figure,
  later,
  save,
  swatch,
  toggle,
} from "./kit.js";
import { pngOf, svgOf } from "./picture.js";
import { createPortrait } from "./portrait.js";

const FEW = 8; // so many arms are shown at first
const PER_ARM = [
  { id: "angles", column: "phi" },
  { id: "rates", column: "phid" },
  { id: "forces", column: "lambda" },
];
const ENERGIES = [
  { id: "kinetic", column: "energy_kinetic", colour: "--arm-2" },
  { id: "potential", column: "energy_potential", colour: "--arm-1" },
  { id: "total", column: "energy_total", colour: "--ink" },
];
const FILES = [
  { name: "CSV", type: "text/csv", ending: "csv" },
  { name: "NPZ", type: "application/x-npz", ending: "npz" },
  { name: "MAT", type: "application/x-matlab-data", ending: "mat" },
];

/** Column k of a row-major table, of `count` rows. */
function columnOf(values, width, k, count) {
  const list = new Float64Array(count);
  for (let i = 0; i < count; i++) list[i] = values[i * width + k];
  return list;
}

const driftOf = (total, count) => total.slice(0, count).map((energy) => energy - total[0]);

async function mount(element, app) {
  const { store, motion, clock, client, text } = app;
  const bag = createBag();
  const inner = createBag(); // what depends on the number of arms and the theme
  const group = await createGroup({ clock, text, key: "plots" });
  const charts = h("div", { class: "charts" });
  const legend = h("div", { class: "chips", role: "group", "aria-label": text("plots.arms") });
  const portraitPlace = h("div", {});
  const status = h("p", { class: "quiet", role: "status" });
  const numbers = h(
    "details",
    { class: "numbers" },
    h("summary", {}),
    h("div", { class: "scroll", tabindex: 0, role: "region" }),
  );
  let shown = false;
  let stale = true;
  let arms = 0;
  let hidden = new Set();
  let chosen = 1;
  let perArm = [];
  let energy = null;
  let drift = null;
  let portrait = null;

  const toolbar = h(
    "div",
    { class: "row" },
    iconButton("plus", text("plots.zoomIn"), () => group.magnify(0.5)),
    button("\u2212", () => group.magnify(2), {
      class: "icon-button",
      "aria-label": text("plots.zoomOut"),
      title: text("plots.zoomOut"),
    }),
    button(text("plots.zoomAll"), () => group.zoom()),
  );

  function chartPlace(id) {
    const host = h("div", {
      class: "chart",
      role: "img",
      "aria-label": text("plots.label", { what: text(`plots.${id}`) }),
      "data-chart": id,
    });
    charts.append(h("h3", { class: "chart-title" }, text(`plots.${id}`)), host);
    return host;
  }

  function chips() {
    legend.replaceChildren(
      ...Array.from({ length: arms }, (_, k) => {
        const { name, dash } = armLook(k + 1);
        const label = text("plots.arm", { arm: k + 1 });
        const chip = toggle(
          swatch(name, dash),
          !hidden.has(k),
          (on) => {
            on ? hidden.delete(k) : hidden.add(k);
            for (const chart of perArm) chart.show(k, on);
          },
          { "data-arm": k + 1, title: label, "aria-label": label },
        );
        chip.append(String(k + 1));
        return chip;
      }),
    );
  }

  function energyChips() {
    const row = h("div", { class: "chips", role: "group", "aria-label": text("plots.energies") });
    ENERGIES.forEach(({ id, colour }, i) => {
      const chip = toggle(swatch(colour), true, (on) => energy.show(i, on), { "data-energy": id });
      chip.append(text(`plots.${id}`));
      row.append(chip);
    });
    return row;
  }

  /** All charts anew: another number of arms, another theme. */
  function build() {
    inner.end();
    charts.replaceChildren();
    portraitPlace.replaceChildren();
    const more = motion.n;
    if (more !== arms) {
      arms = more;
      hidden = new Set(Array.from({ length: arms }, (_, k) => k).filter((k) => k >= FEW));
      chosen = Math.min(store.get().view.selected || chosen, arms);
    }
    chips();
    const series = Array.from({ length: arms }, (_, k) => ({
      ...armLook(k + 1),
      shown: !hidden.has(k),
    }));
    perArm = PER_ARM.map(({ id }) => group.add(chartPlace(id), { series }));
    const energyPlace = chartPlace("energy");
    energyPlace.before(energyChips());
    energy = group.add(energyPlace, {
      series: ENERGIES.map(({ colour }) => ({ colour: cssValue(colour) })),
    });
    drift = group.add(chartPlace("drift"), {
      series: [{ colour: cssValue("--ink") }],
      times: true,
      height: 124,
    });
    charts.append(h("p", { class: "axis-name" }, text("plots.time")));
    portrait = createPortrait(text);
    const pick = choice(
      text("plots.portraitArm"),
      Array.from({ length: arms }, (_, k) => ({
        value: k + 1,
        words: text("plots.arm", { arm: k + 1 }),
      })),
      chosen,
      (value) => {
        chosen = Number(value);
        fillPortrait();
        follow();
      },
    );
    pick.select.dataset.portrait = "";
    portraitPlace.append(
      pick.element,
      h("p", { class: "quiet small" }, text("plots.portraitAxes")),
      portrait.element,
    );
    for (const chart of [...perArm, energy, drift]) inner(() => group.remove(chart));
    inner(portrait.destroy);
  }

  function fillPortrait() {
    const { columns, count, n } = motion;
    if (!count) return;
    const xs = columnOf(columns.phi, n, chosen - 1, count);
    const ys = columnOf(columns.phid, n, chosen - 1, count);
    portrait.set(xs, ys, armLook(chosen).colour, text("plots.portrait", { arm: chosen }));
  }

  function fill() {
    if (!shown) {
      stale = true;
      return;
    }
    stale = false;
    if (arms !== motion.n) build();
    const { columns, count, n } = motion;
    if (!count) return;
    const t = motion.t.slice(0, count);
    PER_ARM.forEach(({ column }, i) =>
      perArm[i].set([
        t,
        ...Array.from({ length: n }, (_, k) => columnOf(columns[column], n, k, count)),
      ]),
    );
    energy.set([t, ...ENERGIES.map(({ column }) => columns[column].slice(0, count))]);
    drift.set([t, driftOf(columns.energy_total, count)]);
    fillPortrait();
    follow();
  }

  function table(now) {
    const cell = (value) => h("td", {}, figure(text, value, 5));
    return h(
      "table",
      {},
      h(
        "thead",
        {},
        h(
          "tr",
          {},
          ...["", "\u03c6, rad", "\u03c6\u2032, rad/s", "\u03bb, N"].map((words) =>
            words ? h("th", { scope: "col" }, words) : h("td", {}),
          ),
        ),
      ),
      h(
        "tbody",
        {},
        ...Array.from({ length: motion.n }, (_, k) =>
          h(
            "tr",
            {},
            h("th", { scope: "row" }, text("plots.arm", { arm: k + 1 })),
            cell(now.phi[k]),
            cell(now.phid[k]),
            cell(now.lambda[k]),
          ),
        ),
      ),
    );
  }

  let told = 0;
  function follow() {
    if (!shown || !motion.count || !portrait) return;
    const now = motion.at(clock.time);
    portrait.at(now.phi[chosen - 1], now.phid[chosen - 1]);
    // numbers that change faster cannot be read
    if (clock.playing && performance.now() - told < 120) return;
    told = performance.now();
    numbers.firstChild.textContent = text("plots.numbers", { time: text.number(clock.time, 2) });
    if (numbers.open) numbers.lastChild.replaceChildren(table(now));
  }

  /** The panels as they are seen: the same arms, the same time. */
  function panels() {
    const { columns, count, n } = motion;
    const t = motion.t.slice(0, count);
    const x = group.zoomed ?? [0, clock.duration];
    const first = t.findIndex((time) => time >= x[0]);
    const last = t.findLastIndex((time) => time <= x[1]) + 1;
    const cut = (list) => list.slice(first, last);
    const style = getComputedStyle(document.documentElement);
    const paper = (name) =>
      style.getPropertyValue(name.replace("--arm", "--print-arm")).trim() || "#1c2330";
    const seen = Array.from({ length: n }, (_, k) => k).filter((k) => !hidden.has(k));
    const lines = (column) =>
      seen.map((k) => ({
        name: String(k + 1),
        colour: paper(armLook(k + 1).name),
        dash: armLook(k + 1).dash,
        xs: cut(t),
        ys: cut(columnOf(columns[column], n, k, count)),
      }));
    return [
      ...PER_ARM.map(({ id, column }) => ({
        title: text(`plots.${id}`),
        x,
        series: lines(column),
      })),
      {
        title: text("plots.energy"),
        x,
        series: ENERGIES.map(({ id, column, colour }) => ({
          name: text(`plots.${id}`),
          colour: paper(colour),
          xs: cut(t),
          ys: cut(columns[column].slice(0, count)),
        })),
      },
      {
        title: text("plots.drift"),
        x,
        series: [
          {
            name: "",
            colour: "#1c2330",
            xs: cut(t),
            ys: cut(driftOf(columns.energy_total, count)),
          },
        ],
      },
      {
        title: `${text("plots.portrait", { arm: chosen })}: ${text("plots.portraitAxes")}`,
        height: 300,
        series: [
          {
            name: "",
            colour: paper(armLook(chosen).name),
            xs: columnOf(columns.phi, n, chosen - 1, count),
            ys: columnOf(columns.phid, n, chosen - 1, count),
          },
        ],
      },
    ].filter(({ series }) => series.length);
  }

  function done(blob, name) {
    save(blob, name);
    status.textContent = text("plots.saved", { name });
  }

  async function savePicture(ending) {
    const svg = svgOf(
      panels(),
      `${store.get().title || text("name")}. ${text("plots.title")}`,
      text,
    );
    done(
      ending === "svg" ? new Blob([svg], { type: "image/svg+xml" }) : await pngOf(svg),
      `pendulum.${ending}`,
    );
  }

  async function saveNumbers({ type, ending }) {
    status.textContent = text("kit.waiting");
    try {
      const body = { ...request(store.get()), output: ["phi", "phid", "lambda", "z", "energy"] };
      const { blob, name } = await client.file("/v1/trajectories", body, type);
      done(blob, name || `pendulum.${ending}`);
    } catch (error) {
      if (!aborted(error)) status.textContent = said(error, text);
    }
  }

  element.append(
    h("h2", {}, text("drawer.plots")),
    h("p", { class: "quiet" }, text("plots.hint")),
    toolbar,
    legend,
    charts,
    portraitPlace,
    numbers,
    h(
      "div",
      { class: "row", role: "group", "aria-label": text("kit.save") },
      h("span", { class: "quiet" }, text("plots.picture")),
      ...["png", "svg"].map((ending) =>
        button(ending.toUpperCase(), () => savePicture(ending), { "data-save": ending }),
      ),
    ),
    h(
      "div",
      { class: "row", role: "group", "aria-label": text("kit.save") },
      h("span", { class: "quiet" }, text("plots.values")),
      ...FILES.map((file) =>
        button(file.name, () => saveNumbers(file), { "data-save": file.ending }),
      ),
    ),
    status,
  );
  numbers.lastChild.setAttribute("aria-label", text("plots.values"));

  const soon = later(fill);
  bag(soon.end);
  bag(
    motion.subscribe((_, what) => {
      if (what === "begin" && group.zoomed) group.zoom();
      if (what === "rows" || what === "complete") soon();
    }),
  );
  bag(clock.subscribe(follow));
  bag(
    theme.subscribe(() => {
      arms = 0;
      stale = true;
      if (shown) soon();
    }),
  );
  bag.on(numbers, "toggle", () => {
    told = 0;
    follow();
  });

  return {
    show() {
      shown = true;
      if (stale) fill();
      follow();
    },
    hide() {
      shown = false;
    },
    destroy() {
      bag.end();
      inner.end();
      group.destroy();
      element.replaceChildren();
    },
  };
}

export default { id: "plots", title: (text) => text("drawer.plots"), mount };
