// Where the energy is, as bars: motion, height, springs, heat, what drives have given; their
// balance stays the same.
// Leaves to others: the energies themselves (the server's; springs by their law from its angles).
// Invariant: the sum shown is that of the bars shown; what the method does not tell is a dash.

import { createBag, h } from "../../dom.js";
import { exchanges, springEnergy } from "../../terms.js";
import { locate } from "../../track.js";
import { lowest } from "../../tree.js";
import { figure } from "../kit/kit.js";

const KINDS = ["kinetic", "height", "springs", "heat", "work", "balance"];
const READABLE_MS = 150;

/**
 * A motion's energies: of which track; zero: the energy of height at the lowest position; most: the
 * end of the scale, J.
 * @typedef {{track: Track | null, count: number, zero: number, most: number}} Scale
 */

/**
 * The energies of a sample, J, in the order of KINDS; NaN where they are not told.
 * @param {Track} track @param {number} i @param {number} zero
 */
export function energiesOf(track, i, zero) {
  const { columns, n, doc } = track;
  const springs = springEnergy(doc.pendulum, columns.phi, i * n, columns.cart_x?.[i]);
  const kinetic = columns.energy_kinetic[i];
  const height = columns.energy_potential[i] - springs - zero;
  const told = "exchange_heat" in columns || !exchanges(doc.pendulum);
  const heat = told ? (columns.exchange_heat?.[i] ?? 0) : NaN;
  const work = told ? (columns.exchange_work?.[i] ?? 0) : NaN;
  return [kinetic, height, springs, heat, work, kinetic + height + springs + heat - work];
}

/** The scale of what is here of a track. @param {Track} track @returns {Scale} */
export function scaleOf(track) {
  const { doc, count } = track;
  const zero = lowest(doc.pendulum);
  let most = 0;
  for (let i = 0; i < count; i++) {
    for (const energy of energiesOf(track, i, zero))
      if (Math.abs(energy) > most) most = Math.abs(energy);
  }
  return { track, count, zero, most };
}

/** @param {Text} text @param {string} kind */
function barOf(text, kind) {
  const fill = h("span", { class: "energy-fill" });
  const value = h("span", { class: "energy-value" });
  const element = h(
    "div",
    { class: "energy-row", "data-energy": kind },
    h("span", {}, text(`physics.energy.${kind}`)),
    h("span", { class: "energy-track", "aria-hidden": "true" }, fill),
    value,
  );
  return { element, fill, value };
}

/**
 * The energies of now between two samples, as those of the two.
 * @param {Scale} scale @param {Track} track @param {number} time
 */
function between(scale, track, time) {
  const place = { index: 0, fraction: 0 };
  locate(track, time, place);
  const next = Math.min(place.index + 1, track.count - 1);
  const from = energiesOf(track, place.index, scale.zero);
  const to = energiesOf(track, next, scale.zero);
  return from.map((energy, i) => energy + place.fraction * (to[i] - energy));
}

/** @param {App} app */
export function createEnergyBars({ motion, clock, text }) {
  const bag = createBag();
  const bars = KINDS.map((kind) => barOf(text, kind));
  const unknown = h("p", { class: "quiet", hidden: true }, text("physics.energy.unknown"));
  const label = text("physics.energy");
  const element = h(
    "section",
    { class: "energies", "aria-label": label },
    h("h3", {}, label),
    ...bars.map((bar) => bar.element),
    h("p", { class: "quiet small" }, text("physics.energy.words")),
    unknown,
  );
  /** @type {Scale} */
  let scale = { track: null, count: 0, zero: 0, most: 0 };
  let shown = false;
  let told = 0;

  function draw() {
    const { track } = motion;
    if (!shown || !track.count || !track.columns.energy_kinetic) return;
    if (scale.track !== track || (scale.count < track.count && track.complete))
      scale = scaleOf(track);
    const now = between(scale, track, clock.time);
    const words = !clock.playing || performance.now() - told > READABLE_MS;
    if (words) told = performance.now();
    bars.forEach(({ fill, value }, i) => {
      const share = scale.most > 0 ? Math.min(1, Math.abs(now[i]) / scale.most) : 0;
      fill.style.transform = `scaleX(${Number.isFinite(share) ? share : 0})`;
      fill.classList.toggle("negative", now[i] < 0);
      // what is left of the difference of large numbers is none
      const rounded = Math.abs(now[i]) < 1e-9 * scale.most ? 0 : now[i];
      if (words) value.textContent = `${figure(text, rounded)} J`;
    });
    unknown.hidden = Number.isFinite(now[KINDS.length - 1]);
  }

  bag(clock.subscribe(draw));
  bag(motion.subscribe(draw));
  return {
    element,
    show() {
      shown = true;
      told = 0;
      draw();
    },
    hide() {
      shown = false;
    },
    destroy: bag.end,
  };
}
