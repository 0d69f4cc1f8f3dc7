// Modes: a card each with its frequency and a little tree that swings, starts in one or in a sum of them, the linear motion
// beside the full one, and the identity sum 1/omega^2 = l_tot/g.
// Leaves to others: the modes (the server's), the motion; the curves (chart.js).
// Invariant: shapes and frequencies are the server's; the thumbnails swing with the page's clock.

import { createBag, h } from "../dom.js";
import { said } from "../client.js";
import { ghostColour } from "../paint.js";
import { theme } from "../theme.js";
import { createGroup } from "./chart.js";
import { aborted, button, choice, cssValue, figure, later, settled, tick } from "./kit.js";
import { createMini } from "./mini.js";

const HANGING = -Math.PI / 2;
const ALL = 300; // so many arms are asked for all of their modes
const SLOWEST = 48;
const PAGE = 12;
const DEGREE = Math.PI / 180;
const FIRST = 25; // degrees
const STEEPEST = 60;

const hang = (theta) => theta.map((angle) => HANGING + angle);
const isLinear = (ghost) => ghost.method === "linear";

async function mount(element, app) {
  const { store, motion, clock, client, text } = app;
  const bag = createBag();
  const status = h("p", { class: "quiet", role: "status" });
  const cards = h("ul", { class: "mode-cards" });
  const more = button(
    "",
    () => {
      many += PAGE;
      build();
    },
    { hidden: true },
  );
  const identity = h("div", { class: "identity" });
  const sumWords = h("p", {});
  const sumPlace = h("div", { class: "sum-picture" });
  const chartPlace = h("div", { hidden: true });
  let shown = false;
  let stop = null;
  let tree = null; // whose modes these are
  let modes = null;
  let many = PAGE;
  let views = []; // {mini, k}
  let sum = null;
  let angles = []; // amplitude of every mode, degrees
  let chosen = new Set([0, 1]);

  const startSum = button(text("modes.sumStart"), () => begin(sumOf(1), "sum"), {
    class: "button main",
    "data-start": "sum",
  });
  const linear = tick(text("modes.linear"), false, (on) => setLinear(on));
  linear.box.dataset.linear = "";

  /** theta of every arm: the chosen modes added up, each at its phase of a time. */
  function sumOf(phase, time = 0) {
    const theta = new Float64Array(tree.length.length);
    for (const k of chosen) {
      if (k >= modes.omega.length) continue;
      const part = angles[k] * DEGREE * (phase === 1 ? 1 : Math.cos(modes.omega[k] * time));
      modes.vectors[k].forEach((value, arm) => {
        theta[arm] += part * value;
      });
    }
    return theta;
  }

  const oneOf = (k, part) => Float64Array.from(modes.vectors[k], (value) => value * part);

  function begin(theta, label, words = null) {
    const phi = Array.from(theta, (angle) => HANGING + angle);
    store.set({ initial: { phi, phid: phi.map(() => 0) } }, { label });
    clock.seek(0);
    if (words) app.announce(words);
  }

  function setLinear(on) {
    const others = store.get().ghosts.filter((ghost) => !isLinear(ghost));
    const { phi, phid } = store.get().initial;
    store.set(
      { ghosts: on ? [...others, { phi, phid, apart: 0, method: "linear" }] : others },
      { label: "ghosts" },
    );
  }

  function card(k) {
    const mode = modes.mode[k];
    const mini = createMini(tree, {
      width: 124,
      height: 132,
      top: 0.06,
      label: text("modes.picture", { mode }),
    });
    const said = h("output", {}, text("modes.degrees", { angle: text.short(angles[k]) }));
    const slider = h("input", {
      type: "range",
      min: 0,
      max: STEEPEST,
      step: 1,
      value: angles[k],
      "aria-label": text("modes.amplitude", { mode }),
      "data-amplitude": mode,
      on: {
        input: () => {
          angles[k] = Number(slider.value);
          said.textContent = text("modes.degrees", { angle: text.short(angles[k]) });
          slider.setAttribute("aria-valuetext", said.textContent);
          sumChanged();
          draw();
        },
      },
    });
    const part = tick(text("modes.inSum"), chosen.has(k), (on) => {
      on ? chosen.add(k) : chosen.delete(k);
      sumChanged();
      draw();
    });
    part.box.dataset.part = mode;
    const facts = [
      ["omega", modes.omega[k]],
      ["frequency", modes.frequency[k]],
      ["period", modes.period[k]],
    ];
    mini.fit(hang(oneOf(k, STEEPEST * DEGREE)));
    views.push({ mini, k });
    return h(
      "li",
      { class: "mode-card", "data-mode": mode },
      mini.canvas,
      h(
        "div",
        { class: "mode-body" },
        h("h3", {}, text("modes.title", { mode })),
        h(
          "dl",
          {},
          ...facts.flatMap(([id, value]) => [
            h("dt", {}, text(`modes.${id}`)),
            h(
              "dd",
              {},
              text(`modes.${id}Value`, {
                value: value > 0.01 && value < 1e5 ? text.number(value, 3) : figure(text, value, 4),
              }),
            ),
          ]),
        ),
        h("div", { class: "amplitude" }, slider, said),
        part.element,
        button(
          text("modes.start"),
          () => begin(oneOf(k, angles[k] * DEGREE), "mode", text("modes.started", { mode })),
          { "data-start": mode },
        ),
      ),
    );
  }

  function build() {
    views = [];
    const count = Math.min(many, modes.omega.length);
    cards.replaceChildren(...Array.from({ length: count }, (_, k) => card(k)));
    more.hidden = count === modes.omega.length;
    more.textContent = text("modes.more", { count: Math.min(PAGE, modes.omega.length - count) });
    sum = createMini(tree, { width: 150, height: 160, top: 0.06, label: text("modes.sumPicture") });
    sumPlace.replaceChildren(sum.canvas);
    sumChanged();
    showIdentity();
    draw();
  }

  function sumChanged() {
    const list = [...chosen].filter((k) => k < modes.omega.length).sort((a, b) => a - b);
    startSum.disabled = !list.length;
    sum?.fit(
      hang(
        Float64Array.from(tree.length, (_, arm) =>
          list.reduce((all, k) => all + Math.abs(angles[k] * DEGREE * modes.vectors[k][arm]), 0.05),
        ),
      ),
    );
    sumWords.textContent = list.length
      ? list
          .map((k) => text("modes.part", { mode: modes.mode[k], angle: text.short(angles[k]) }))
          .join(" + ")
      : text("modes.sumNone");
  }

  function showIdentity() {
    const found = modes.identity;
    identity.hidden = !found;
    if (!found) return;
    const length = tree.length.reduce((all, one) => all + one, 0);
    identity.replaceChildren(
      h("h3", {}, text("modes.identity")),
      h("p", { class: "quiet" }, text("modes.identityText")),
      h(
        "p",
        { class: "number" },
        text("modes.identitySum", { sum: figure(text, found.sum_inverse_omega_squared, 8) }),
      ),
      h(
        "p",
        { class: "number" },
        text("modes.identityLength", {
          length: figure(text, length, 6),
          gravity: figure(text, tree.gravity, 6),
          quotient: figure(text, found.length_total_over_g, 8),
        }),
      ),
      h(
        "p",
        { class: "quiet" },
        text("modes.identityDifference", {
          difference: figure(text, found.relative_difference, 2),
        }),
      ),
    );
  }

  function draw() {
    if (!shown || !modes) return;
    for (const { mini, k } of views) {
      const part = angles[k] * DEGREE;
      mini.draw(hang(oneOf(k, part * Math.cos(modes.omega[k] * clock.time))), [
        hang(oneOf(k, part)),
        hang(oneOf(k, -part)),
      ]);
    }
    sum.draw(hang(sumOf(0, clock.time)), [hang(sumOf(1))]);
  }

  async function load() {
    const doc = store.get();
    if (tree === doc.pendulum) return;
    stop?.abort();
    stop = new AbortController();
    tree = doc.pendulum;
    const n = tree.length.length;
    if (!(tree.gravity > 0)) return refuse(text("modes.noGravity"));
    status.textContent = text("kit.waiting");
    try {
      const body = { pendulum: tree, normalize: "max" };
      if (n > ALL) body.select = { slowest: SLOWEST };
      const got = await client.modes(body, { signal: stop.signal });
      status.textContent = n > ALL ? text("modes.many", { count: got.omega.length, all: n }) : "";
      if (modes?.omega.length !== got.omega.length) {
        angles = got.omega.map(() => FIRST);
        chosen = new Set(got.omega.length > 1 ? [0, 1] : [0]);
        many = PAGE;
      }
      modes = got;
      build();
    } catch (error) {
      if (aborted(error)) return;
      tree = null;
      refuse(said(error, text));
    }
  }

  function refuse(words) {
    modes = null;
    views = [];
    cards.replaceChildren();
    sumPlace.replaceChildren();
    identity.hidden = more.hidden = true;
    startSum.disabled = true;
    status.textContent = words;
  }

  // linear beside non-linear: a curve of each
  let curves = null;
  async function openCurves() {
    const group = await createGroup({ clock, text, key: "modes" });
    let arm = 1;
    const title = h("h3", { class: "chart-title" });
    const host = h("div", { class: "chart", role: "img" });
    const pick = choice(
      text("modes.chartArm"),
      motion.doc.pendulum.length.map((_, k) => ({ value: k + 1, words: String(k + 1) })),
      arm,
      (value) => {
        arm = Number(value);
        fill();
      },
    );
    const pale = ghostColour(store.get().ghosts.findIndex(isLinear));
    const names = [
      ["--ink", "modes.nonlinear"],
      [pale, "modes.linearName"],
    ].map(([name, key]) => {
      const line = h("span", { class: "stroke" });
      line.style.setProperty("--colour", `var(${name})`);
      return h("span", { class: "name" }, line, " ", text(key));
    });
    chartPlace.replaceChildren(
      h("p", { class: "quiet" }, text("modes.linearHint")),
      title,
      h("div", { class: "row small" }, ...names, pick.element),
      host,
    );
    const chart = group.add(host, {
      series: [{ colour: cssValue("--ink") }, { colour: cssValue(pale), dash: [6, 3] }],
      times: true,
      height: 150,
    });
    const n = motion.n;
    const theta = (track) =>
      Array.from(
        { length: track.count },
        (_, i) => (track.columns.phi[i * n + arm - 1] - HANGING) / DEGREE,
      );
    function fill() {
      const ghost = motion.ghosts.find(({ doc }) => doc.method === "linear");
      title.textContent = text("modes.chart", { arm });
      host.setAttribute("aria-label", title.textContent);
      if (!ghost?.count || !motion.count || motion.n !== n) return;
      const count = Math.min(ghost.count, motion.count);
      chart.set([
        motion.t.slice(0, count),
        theta(motion.track).slice(0, count),
        theta(ghost).slice(0, count),
      ]);
    }
    fill();
    return {
      n,
      fill,
      destroy: () => {
        group.destroy();
        chartPlace.replaceChildren();
      },
    };
  }

  let opening = null;
  async function followLinear() {
    const on = store.get().ghosts.some(isLinear);
    linear.box.checked = on;
    chartPlace.hidden = !on;
    if (curves && (!on || curves.n !== motion.n)) {
      curves.destroy();
      curves = null;
    }
    if (!on || !shown) return;
    if (curves) return curves.fill();
    opening ??= openCurves();
    curves = await opening;
    opening = null;
  }

  element.append(
    h("h2", {}, text("drawer.modes")),
    h("p", { class: "quiet" }, text("modes.intro")),
    status,
    cards,
    more,
    h("h3", {}, text("modes.sum")),
    h(
      "div",
      { class: "sum" },
      sumPlace,
      h("div", {}, sumWords, h("div", { class: "row" }, startSum)),
    ),
    h("div", { class: "row" }, linear.element),
    chartPlace,
    identity,
  );

  const soon = later(draw);
  const loadSoon = settled(load, 120);
  const linearSoon = later(followLinear);
  for (const one of [soon, loadSoon, linearSoon]) bag(one.end);
  bag(clock.subscribe(soon));
  bag(
    store.subscribe((doc, before) => {
      if (!shown) return;
      if (doc.pendulum !== before.pendulum) loadSoon();
      if (doc.ghosts !== before.ghosts) linearSoon();
    }),
  );
  bag(
    motion.subscribe(
      (_, what) => shown && (what === "ghosts" || what === "complete") && linearSoon(),
    ),
  );
  bag(
    theme.subscribe(() => {
      for (const { mini } of views) mini.recolour();
      sum?.recolour();
      curves?.destroy();
      curves = null;
      linearSoon();
      soon();
    }),
  );
  bag(() => {
    stop?.abort();
    curves?.destroy();
  });

  return {
    show() {
      shown = true;
      load();
      followLinear();
      draw();
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

export default { id: "modes", title: (text) => text("drawer.modes"), mount };
