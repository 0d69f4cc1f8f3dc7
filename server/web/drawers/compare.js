// Compare: ghosts of other starts and how far they are from the pendulum, and the map of flips (flipmap.js).
// Leaves to others: the ghosts' motions (motion.js), drawing them (the stage).
// Invariant: the ghosts are the document's; what is shown of their distance is of the server's samples.

import { createBag, h, iconButton } from "../dom.js";
import { ghostColour } from "../paint.js";
import { theme } from "../theme.js";
import { createGroup } from "./chart.js";
import { button, choice, cssValue, figure, later, swatch } from "./kit.js";
import { mountFlipMap } from "./flipmap.js";

const OFF = [1e-2, 1e-4, 1e-6, 1e-9, 1e-12];
const MOST = 6;
const PARTED = 0.1;
const DEGREE = 180 / Math.PI;

/** The largest difference of an angle at each instant that both tracks have. */
export function distances(track, other) {
  const n = track.n;
  const count = Math.min(track.count, other.count);
  const list = new Float64Array(count);
  const { phi } = track.columns;
  const { phi: beside } = other.columns;
  for (let i = 0; i < count; i++) {
    let most = 0;
    for (let k = i * n; k < (i + 1) * n; k++) most = Math.max(most, Math.abs(phi[k] - beside[k]));
    list[i] = most;
  }
  return list;
}

/** As a list for an axis of powers of ten: 0 has no place there. */
export const logarithmic = (list, count = list.length) =>
  Array.from({ length: count }, (_, i) => list[i] || null);

/** What a ghost is, in words. */
export function ghostName(ghost, text) {
  if (ghost.method) return text("compare.ghostMethod", { method: ghost.method });
  if (ghost.apart !== undefined)
    return text("compare.ghostOff", { amount: figure(text, ghost.apart, 2) });
  const few = ghost.phi
    .slice(0, 4)
    .map((phi) => `${text.short(Math.round((phi * DEGREE + 90) * 10) / 10)}\u00b0`);
  return text("compare.ghostStart", {
    angles: few.join(", ") + (ghost.phi.length > 4 ? ", \u2026" : ""),
  });
}

async function mount(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const list = h("ul", { class: "ghosts" });
  const verdict = h("p", { class: "quiet", role: "status" });
  const title = h("h3", { class: "chart-title" }, text("compare.distance"));
  const host = h("div", { class: "chart", role: "img", "aria-label": text("compare.distance") });
  const chartPlace = h("div", { hidden: true }, title, host);
  let shown = false;
  let off = 1e-6;
  let chart = null;
  let lines = -1;
  let group = null;

  const amount = choice(
    text("compare.off"),
    OFF.map((value) => ({
      value,
      words: text("compare.offAmount", { amount: figure(text, value, 2) }),
    })),
    off,
    (value) => {
      off = Number(value);
    },
  );
  const start = () => {
    const { phi, phid } = store.get().initial;
    return { phi, phid };
  };
  const add = (ghost) =>
    store.get().ghosts.length < MOST &&
    store.set({ ghosts: [...store.get().ghosts, ghost] }, { label: "ghosts" });
  const addOff = button(text("compare.add"), () => add({ ...start(), apart: off }), {
    "data-add": "off",
  });
  const keep = button(text("compare.keep"), () => add(start()), { "data-add": "keep" });
  const clear = button(
    text("compare.clear"),
    () => store.set({ ghosts: [] }, { label: "ghosts" }),
    { hidden: true },
  );

  function remove(i) {
    store.set({ ghosts: store.get().ghosts.filter((_, at) => at !== i) }, { label: "ghosts" });
    addOff.focus();
  }

  function showList() {
    const { ghosts } = store.get();
    addOff.disabled = keep.disabled = ghosts.length >= MOST;
    clear.hidden = ghosts.length < 2;
    list.replaceChildren(
      ...ghosts.map((ghost, i) => {
        const name = ghostName(ghost, text);
        return h(
          "li",
          {},
          swatch(ghostColour(i)),
          h("span", {}, name),
          iconButton("close", text("compare.remove", { what: name }), () => remove(i)),
        );
      }),
    );
    if (!ghosts.length) list.append(h("li", { class: "quiet" }, text("compare.none")));
  }

  async function showDistance() {
    const { ghosts } = motion;
    chartPlace.hidden = !ghosts.length;
    if (!ghosts.length) verdict.textContent = "";
    if (!shown || !ghosts.length || !ghosts[0].count || !motion.count) return;
    if (!group) {
      const made = await createGroup({ clock, text, key: "compare" });
      group ??= made;
    }
    if (lines !== ghosts.length) {
      if (chart) group.remove(chart);
      lines = ghosts.length;
      chart = group.add(host, {
        series: ghosts.map((_, i) => ({ colour: cssValue(ghostColour(i)) })),
        times: true,
        log: true,
        height: 170,
      });
    }
    const all = ghosts.map((ghost) =>
      ghost.count ? distances(motion.track, ghost) : new Float64Array(0),
    );
    const count = Math.max(...all.map((one) => one.length));
    chart.set([motion.t.slice(0, count), ...all.map((one) => logarithmic(one, count))]);
    verdict.replaceChildren(
      ...all.map((one, i) => {
        const at = one.findIndex((distance) => distance > PARTED);
        const words =
          at < 0
            ? text("compare.together")
            : text("compare.parted", { time: text.number(motion.t[at], 2) });
        return h(
          "span",
          { class: "parted" },
          ...(all.length > 1 ? [swatch(ghostColour(i)), " "] : []),
          words,
        );
      }),
    );
  }

  const map = mountFlipMap(app);
  element.append(
    h("h2", {}, text("drawer.compare")),
    h("p", { class: "quiet" }, text("compare.intro")),
    h("div", { class: "row" }, amount.element, addOff),
    h("div", { class: "row" }, keep, h("span", { class: "quiet" }, text("compare.keepHint"))),
    list,
    clear,
    chartPlace,
    verdict,
    map.element,
  );

  const soon = later(showDistance);
  bag(soon.end);
  bag(
    store.subscribe((doc, before) => {
      if (doc.ghosts !== before.ghosts || doc.pendulum !== before.pendulum) {
        showList();
        soon();
      }
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      if (what === "ghosts" || what === "complete" || what === "begin") soon();
    }),
  );
  bag(
    theme.subscribe(() => {
      lines = -1;
      soon();
    }),
  );
  showList();

  return {
    show() {
      shown = true;
      soon();
      map.show();
    },
    hide() {
      shown = false;
      map.hide();
    },
    destroy() {
      bag.end();
      map.destroy();
      group?.destroy();
      element.replaceChildren();
    },
  };
}

export default { id: "compare", title: (text) => text("drawer.compare"), mount };
