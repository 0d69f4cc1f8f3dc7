// Method: how the motion is integrated, what that took, and how far it is from a reference that can be believed.
// Leaves to others: integrating (the server), the overlaid ghost's motion (motion.js).
// Invariant: the reference is the server's taylor series of the same start at the same instants, finer than the run itself.

import { createBag, h } from "../dom.js";
import { said } from "../client.js";
import { ghostColour } from "../paint.js";
import { request, sameMotion } from "../state.js";
import { theme } from "../theme.js";
import { createGroup } from "./chart.js";
import { distances, logarithmic } from "./compare.js";
import {
  aborted,
  choice,
  cssValue,
  fetchTable,
  figure,
  later,
  settled,
  swatch,
  tick,
} from "./kit.js";

const METHODS = {
  taylor: { rtol: 1e-12, finest: 1e-16, divisor: Infinity },
  ode23: { rtol: 1e-3, finest: 1e-13, divisor: 1000 },
  rkf45: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  rk8pd: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  msadams: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  symplectic: null,
  linear: null,
};
const TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-13, 1e-14, 1e-16];
const ABSOLUTE = [0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18];
const WRONG = 0.1;
const DIGITS = { double: {}, extended: { rtol: 1e-28 }, quad: { rtol: 1e-56, loosest: 1e-16 } }; // what taylor computes in
const QUAD_ARMS = 256;
const QUAD_REFERENCE = 1e-50; // finer than a run in 62 digits is hardly possible, but another order tells where it parts
const FINE_ARMS = 20; // what 32 digits are cheap for
const FINE_SECONDS = 120;

const EXACT_ARMS = 20; // what the exact bound of the digits is cheap for
const EXACT_SECONDS = 120;

const isPaper = (ghost) => ghost.method === "ode23";
const paperOf = (doc) => ({ ...doc, method: "ode23", rtol: null, atol: null, precision: "double" });

/** {words, way}: 32 digits where they are cheap, else a tolerance that is finer than the run's. */
function referenceOf(doc) {
  if (doc.precision === "quad" && doc.method === "taylor")
    return { words: "method.referenceQuad", way: { rtol: QUAD_REFERENCE } };
  if (doc.pendulum.length.length <= FINE_ARMS && doc.span.stop <= FINE_SECONDS)
    return { words: "method.referenceFine", way: { precision: "extended", rtol: null } };
  const fine =
    doc.method === "taylor" && (doc.precision === "extended" || (doc.rtol ?? 1e-12) <= 1e-12);
  return fine
    ? { words: "method.referenceFiner", way: { precision: "double", rtol: 1e-15 } }
    : { words: "method.reference", way: { precision: "double", rtol: 1e-12 } };
}

async function mount(element, app) {
  const { store, motion, clock, client, text } = app;
  const bag = createBag();
  const way = h("div", { class: "method-fields" });
  const facts = h("div", {
    class: "scroll",
    tabindex: 0,
    role: "region",
    "aria-label": text("method.stats"),
  });
  const referenceWords = h("p", { class: "quiet" });
  const verdicts = h("div", { role: "status" });
  const legend = h("div", { class: "row small" });
  const host = h("div", { class: "chart", role: "img", "aria-label": text("method.error") });
  const overlay = tick(text("method.overlay"), false, setOverlay);
  overlay.box.dataset.overlay = "";
  let shown = false;
  let stop = null;
  let reference = null; // {doc, table}
  let known = []; // {doc, stats} of the last motions that were asked about
  let group = null;
  let chart = null;
  let lines = "";

  function setOverlay(on) {
    const others = store.get().ghosts.filter((ghost) => !isPaper(ghost));
    const { phi, phid } = store.get().initial;
    store.set(
      { ghosts: on ? [...others, { phi, phid, apart: 0, method: "ode23" }] : others },
      { label: "ghosts" },
    );
  }

  function fields(doc) {
    const known = METHODS[doc.method] && {
      ...METHODS[doc.method],
      ...(doc.method === "taylor" && DIGITS[doc.precision]),
    };
    const method = choice(
      text("method.method"),
      Object.keys(METHODS).map((value) => ({ value, words: text(`method.${value}`) })),
      doc.method,
      (value) =>
        store.set(
          { method: value, rtol: null, atol: null, precision: "double" },
          { label: "method" },
        ),
    );
    method.select.dataset.method = "";
    const rows = [method.element];
    if (known) {
      const asNumber = (value) => (value === "" ? null : Number(value));
      const list = (values, fallback) => [
        { value: "", words: text("method.default", { value: figure(text, fallback, 2) }) },
        ...values.map((value) => ({ value, words: figure(text, value, 2) })),
      ];
      const own = (values, value) =>
        value === null || values.includes(value)
          ? values
          : [...values, value].sort((a, b) => b - a);
      const rtol = choice(
        text("method.rtol"),
        list(
          own(
            TOLERANCES.filter((value) => value >= known.finest && value <= (known.loosest ?? 1)),
            doc.rtol,
          ),
          known.rtol,
        ),
        doc.rtol ?? "",
        (value) => store.set({ rtol: asNumber(value) }, { label: "tolerance" }),
      );
      const usual = (doc.rtol ?? known.rtol) / known.divisor;
      const atol = choice(
        text("method.atol"),
        list(
          own(
            ABSOLUTE.filter((value) => value <= (known.loosest ?? 1)),
            doc.atol,
          ),
          usual,
        ),
        doc.atol ?? "",
        (value) => store.set({ atol: asNumber(value) }, { label: "tolerance" }),
      );
      rtol.select.dataset.rtol = "";
      atol.select.dataset.atol = "";
      rows.push(rtol.element, atol.element);
    } else rows.push(h("p", { class: "quiet" }, text("method.none")));
    if (doc.method === "taylor") {
      const some = Object.keys(DIGITS).filter(
        (value) =>
          value !== "quad" || doc.pendulum.length.length <= QUAD_ARMS || doc.precision === "quad",
      );
      const fine = choice(
        text("method.precision"),
        some.map((value) => ({ value, words: text(`method.${value}`) })),
        doc.precision,
        (value) => store.set({ precision: value, rtol: null, atol: null }, { label: "method" }),
      );
      fine.select.dataset.precision = "";
      rows.push(fine.element);
    }
    const focused = way.contains(document.activeElement)
      ? Object.keys(document.activeElement.dataset)[0]
      : null;
    way.replaceChildren(...rows);
    if (focused) way.querySelector(`[data-${focused}]`)?.focus();
  }

  function trust({ trust_until: exact, horizon }, stopAt) {
    const time = exact ?? horizon;
    return time >= stopAt
      ? text("method.trustAll")
      : text("method.trustValue", { time: text.number(time, 2) });
  }

  function factRows(stats, distance, stopAt) {
    if (!stats) return ["\u2026", "\u2026", "\u2026", "\u2026", "\u2026", "\u2026", "\u2026"];
    return [
      text.short(stats.steps, 9),
      text.short(stats.rejected, 9),
      text.short(stats.evaluations, 9),
      figure(text, stats.energy_drift, 2),
      trust(stats, stopAt),
      distance?.length ? figure(text, distance.at(-1), 2) : "\u2026",
      text("method.computeValue", { time: figure(text, stats.compute_seconds * 1000, 2) }),
    ];
  }

  function showFacts(runs) {
    const names = ["steps", "rejected", "evaluations", "drift", "trust", "atEnd", "compute"];
    const columns = runs.map(({ stats, distance }) =>
      factRows(stats, distance, motion.doc.span.stop),
    );
    facts.replaceChildren(
      h(
        "table",
        {},
        h(
          "thead",
          {},
          h("tr", {}, h("td", {}), ...runs.map(({ name }) => h("th", { scope: "col" }, name))),
        ),
        h(
          "tbody",
          {},
          ...names.map((name, i) =>
            h(
              "tr",
              { "data-fact": name },
              h("th", { scope: "row" }, text(`method.${name}`)),
              ...columns.map((column) => h("td", {}, column[i])),
            ),
          ),
        ),
      ),
    );
  }

  const factsOf = (doc) => known.find((one) => sameMotion(one.doc, doc))?.stats ?? null;

  function runsNow() {
    const believed = reference && sameMotion(reference.doc, motion.doc) ? reference.table : null;
    const far = (track) =>
      believed && track.complete
        ? distances(track, { count: believed.count, columns: believed.columns })
        : null;
    const list = [
      {
        name: motion.doc.method,
        colour: "--arm-1",
        stats: factsOf(motion.doc),
        distance: far(motion.track),
      },
    ];
    const paper = motion.ghosts.find(
      ({ doc, initial }) =>
        doc.method === "ode23" && initial.phi.every((phi, k) => phi === motion.doc.initial.phi[k]),
    );
    if (paper)
      list.push({
        name: text("method.overlaid"),
        colour: ghostColour(motion.ghosts.indexOf(paper)),
        stats: factsOf(paperOf(motion.doc)),
        distance: far(paper),
      });
    return list;
  }

  async function showChart(runs) {
    if (!group) {
      const made = await createGroup({ clock, text, key: "method" });
      group ??= made;
    }
    const look = runs.map(({ colour }) => cssValue(colour)).join();
    if (look !== lines) {
      if (chart) group.remove(chart);
      lines = look;
      chart = group.add(host, {
        series: runs.map(({ colour }) => ({ colour: cssValue(colour) })),
        times: true,
        log: true,
        height: 180,
      });
    }
    const drawn = runs.filter(({ distance }) => distance).length === runs.length;
    if (drawn)
      chart.set([
        motion.t.slice(0, motion.count),
        ...runs.map(({ distance }) => logarithmic(distance)),
      ]);
    else chart.set([new Float64Array(0), ...runs.map(() => [])]);
  }

  function showVerdicts(runs) {
    if (!runs.some(({ distance }) => distance))
      return verdicts.replaceChildren(h("p", { class: "quiet" }, text("kit.waiting")));
    verdicts.replaceChildren(
      ...runs
        .filter(({ distance }) => distance)
        .map(({ name, distance }) => {
          const at = distance.findIndex((value) => value > WRONG);
          const most = distance.reduce((all, value) => Math.max(all, value), 0);
          return h(
            "p",
            { class: at < 0 ? "verdict" : "verdict wrong" },
            at < 0
              ? text("method.staysRight", { name, most: figure(text, most, 2) })
              : text("method.goesWrong", { name, time: text.number(motion.t[at], 2) }),
          );
        }),
    );
  }

  function show() {
    if (!shown) return;
    overlay.box.checked = store.get().ghosts.some(isPaper);
    referenceWords.textContent = text(referenceOf(motion.doc).words);
    const runs = runsNow();
    showFacts(runs);
    showVerdicts(runs);
    legend.replaceChildren(
      ...runs.map(({ name, colour }) => h("span", { class: "name" }, swatch(colour), " ", name)),
    );
    showChart(runs);
  }

  /** Asks what a motion took, once; with the exact bound of its digits where that is cheap. */
  async function fetchFacts(doc, signal) {
    if (factsOf(doc)) return;
    const exact =
      doc.pendulum.length.length <= EXACT_ARMS &&
      doc.span.stop <= EXACT_SECONDS &&
      doc.precision === "double";
    const body = {
      ...request(doc),
      times: { start: 0, stop: doc.span.stop, count: 201 },
      output: ["energy"],
      digits: 4,
      ...(exact && { trust: true }),
    };
    const { stats } = await client.trajectory(body, { signal });
    known = [{ doc, stats }, ...known].slice(0, 2);
    show();
  }

  /** The reference of the present run, once that is here itself. */
  async function load() {
    if (!shown || !motion.complete) return;
    const { doc } = motion;
    stop?.abort();
    stop = new AbortController();
    const { signal } = stop;
    try {
      await fetchFacts(doc, signal);
      if (store.get().ghosts.some(isPaper)) await fetchFacts(paperOf(store.get()), signal);
      if (reference && sameMotion(reference.doc, doc)) return;
      const body = {
        ...request({ ...doc, method: "taylor", atol: null, ...referenceOf(doc).way }),
        output: ["phi"],
      };
      reference = { doc, table: await fetchTable(client, "/v1/trajectories", body, { signal }) };
      show();
    } catch (error) {
      if (!aborted(error)) verdicts.replaceChildren(h("p", { class: "fault" }, said(error, text)));
    }
  }

  element.append(
    h("h2", {}, text("drawer.method")),
    h("p", { class: "quiet" }, text("method.intro")),
    way,
    h("div", { class: "row" }, overlay.element),
    h("p", { class: "quiet" }, text("method.overlayHint")),
    h("h3", {}, text("method.stats")),
    facts,
    h("h3", { class: "chart-title" }, text("method.error")),
    legend,
    host,
    verdicts,
    referenceWords,
  );

  const soon = later(show);
  const loadSoon = settled(load, 60);
  bag(soon.end);
  bag(loadSoon.end);
  bag(
    store.subscribe((doc, before) => {
      if (!sameMotion(doc, before) || doc.ghosts !== before.ghosts) fields(doc);
      if (doc.ghosts !== before.ghosts) loadSoon();
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      if (!shown) return;
      soon();
      if (what === "complete") loadSoon();
    }),
  );
  bag(theme.subscribe(soon));
  bag(() => {
    stop?.abort();
    group?.destroy();
  });
  fields(store.get());

  return {
    show() {
      shown = true;
      show();
      load();
    },
    hide() {
      shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

export default { id: "method", title: (text) => text("drawer.method"), mount };
