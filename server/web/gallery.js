// The examples: the server's presets, each as a small picture; a click puts one on the stage.
// Leaves to others: which there are (GET /v1/presets).
// Invariant: one request brings all of them; a picture moves, with the one clock, once somebody has come near the examples, and
// asks for its motion when it can be seen; only what can be seen is drawn.

import { farthest } from "./edits.js";
import { createBag, h } from "./dom.js";
import { anglesAt } from "./motion.js";
import { fromRequest } from "./state.js";
import { theme } from "./theme.js";
import { order, reach, tips } from "./tree.js";

const SECONDS = 6;
const STEP = 0.04;
const SHORTEST_SPAN = 20;
const FRAME_MS = 30;

/** The document of a preset. */
function documentOf(preset) {
  const patch = fromRequest(preset);
  return {
    ...patch,
    span: { ...patch.span, stop: Math.max(patch.span.stop, SHORTEST_SPAN) },
    title: preset.title,
    preset: preset.name,
    view: { selected: 0, trails: [farthest(patch.pendulum)] },
  };
}

/** A preset's first seconds, coarsely: a track as motion.js has them. */
async function load(preset, client, signal) {
  const { pendulum, initial } = preset;
  const n = pendulum.length.length;
  const track = {
    doc: { pendulum, span: { step: STEP } },
    initial,
    n,
    count: 0,
    columns: { phi: null, phid: null },
  };
  const total = Math.round(SECONDS / STEP) + 1;
  track.columns.phi = new Float64Array(total * n);
  track.columns.phid = new Float64Array(total * n);
  const body = {
    pendulum,
    initial,
    times: { start: 0, stop: SECONDS, step: STEP },
    rtol: 1e-6,
    output: ["phi", "phid"],
  };
  const width = 1 + 2 * n;
  await client.table("/v1/trajectories", body, {
    signal,
    begin() {},
    rows(values, count) {
      for (let i = 0; i < count; i++) {
        track.columns.phi.set(
          values.subarray(i * width + 1, i * width + 1 + n),
          (track.count + i) * n,
        );
        track.columns.phid.set(
          values.subarray(i * width + 1 + n, (i + 1) * width),
          (track.count + i) * n,
        );
      }
      track.count += count;
    },
  });
  return track;
}

/** How far around its pivot a track goes: {side, up, down} in metres. */
function extent(track, rows, x, y) {
  const box = { side: 0.1, up: 0, down: 0.1 };
  for (let i = 0; i < track.count; i += 3) {
    tips(track.doc.pendulum, rows, track.columns.phi, i * track.n, x, y);
    for (let k = 0; k < track.n; k++) {
      box.side = Math.max(box.side, Math.abs(x[k]));
      box.up = Math.max(box.up, y[k]);
      box.down = Math.max(box.down, -y[k]);
    }
  }
  return box;
}

/** A preset as it starts, for a picture that does not move. */
function pose({ pendulum, initial }) {
  return {
    doc: { pendulum, span: { step: STEP } },
    initial,
    n: pendulum.length.length,
    count: 1,
    columns: { phi: Float64Array.from(initial.phi), phid: Float64Array.from(initial.phid) },
  };
}

/** Draws a track on a small canvas at a time; forth and back, since a motion may be run backwards. */
function createPicture(canvas, track) {
  const context = canvas.getContext("2d");
  const moves = track.count > 1;
  const tree = track.doc.pendulum;
  const rows = order(tree.parent);
  const array = () => new Float64Array(track.n);
  const [phi, x, y] = [array(), array(), array()];
  const place = { index: 0, fraction: 0 };
  const box = track.count
    ? extent(track, rows, x, y)
    : { side: reach(tree), up: reach(tree), down: reach(tree) };
  const last = (track.count - 1) * STEP;
  const ratio = Math.min(devicePixelRatio, 2);
  const heaviest = Math.max(...tree.mass);

  return (time, colours) => {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (canvas.width !== Math.round(width * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const turn = moves ? time % (2 * last) : 0;
    anglesAt(track, turn > last ? 2 * last - turn : turn, place, phi);
    tips(tree, rows, phi, 0, x, y);
    const scale = Math.min((width / 2 - 10) / box.side, (height - 20) / (box.up + box.down));
    const top = (height - scale * (box.up + box.down)) / 2 + scale * box.up;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.beginPath();
    context.moveTo(width / 2 - 9, top);
    context.lineTo(width / 2 + 9, top);
    context.strokeStyle = colours.pivot;
    context.lineWidth = 1.2;
    context.stroke();
    context.beginPath();
    for (let k = 0; k < track.n; k++) {
      const from = tree.parent[k] - 1;
      context.moveTo(
        width / 2 + (from < 0 ? 0 : scale * x[from]),
        top - (from < 0 ? 0 : scale * y[from]),
      );
      context.lineTo(width / 2 + scale * x[k], top - scale * y[k]);
    }
    context.strokeStyle = colours.line;
    context.lineWidth = 1.6;
    context.lineCap = "round";
    context.stroke();
    context.beginPath();
    for (let k = 0; k < track.n; k++) {
      const r = Math.max(1.2, 3.4 * Math.cbrt(tree.mass[k] / heaviest));
      context.moveTo(width / 2 + scale * x[k] + r, top - scale * y[k]);
      context.arc(width / 2 + scale * x[k], top - scale * y[k], r, 0, 2 * Math.PI);
    }
    context.fillStyle = colours.mass;
    context.fill();
  };
}

export default {
  id: "presets",
  title: (text) => text("drawer.presets"),
  mount(element, app) {
    const { store, clock, client, text } = app;
    const bag = createBag();
    const stop = new AbortController();
    const cards = new Map(); // name -> {preset, button, canvas, picture, seen, moves}
    const grid = h("div", { class: "gallery" });
    element.append(
      h("h2", {}, text("presets.title")),
      h("p", { class: "quiet" }, text("presets.words")),
      grid,
    );
    let colours = null;
    let shown = false;
    let drawn = 0;
    let near = false; // somebody has pointed at the examples, touched them or come there by keys
    let animating = false;

    const sight = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries)
        cards.get(target.dataset.preset).seen = isIntersecting;
      draw();
      animate();
    });

    function choose(preset) {
      store.set(documentOf(preset), { label: "preset" });
      app.announce(text("said.preset", { name: named(preset) }));
      clock.play();
    }

    const named = ({ name, title }) =>
      text.has(`preset.${name}`) ? text(`preset.${name}`) : title;

    function card(preset) {
      const { name, title, n } = preset;
      const canvas = h("canvas", { "aria-hidden": "true" });
      const button = h(
        "button",
        {
          type: "button",
          class: "preset",
          "data-preset": name,
          on: { click: () => choose(preset) },
        },
        canvas,
        h("span", { class: "preset-name" }, named({ name, title })),
        h("span", { class: "quiet" }, text(n === 1 ? "presets.arm" : "presets.arms", { n })),
      );
      grid.append(button);
      cards.set(name, {
        preset,
        button,
        canvas,
        picture: createPicture(canvas, pose(preset)),
        seen: false,
        moves: false,
      });
      sight.observe(button);
    }

    /** The stage comes first. */
    function stageMoves() {
      if (app.motion.complete) return Promise.resolve();
      return new Promise((resolve) => {
        bag(
          app.motion.subscribe(
            (_, what) => (what === "complete" || what === "failure") && resolve(),
          ),
        );
      });
    }

    async function fill() {
      await stageMoves();
      const { presets } = await client.presets({ signal: stop.signal });
      presets.forEach(card);
      mark();
      draw();
    }

    /** One motion after the other, of what can be seen. */
    async function animate() {
      if (!near || animating || stop.signal.aborted) return;
      animating = true;
      try {
        for (let entry; (entry = [...cards.values()].find(({ seen, moves }) => seen && !moves)); ) {
          entry.moves = true;
          entry.picture = createPicture(
            entry.canvas,
            await load(entry.preset, client, stop.signal),
          );
          draw();
        }
      } catch (error) {
        if (error.name !== "AbortError" && !error.kind) throw error; // a picture that does not move is a picture
      } finally {
        animating = false;
      }
    }

    function approach() {
      near = true;
      animate();
    }

    function nothing(error) {
      if (error.name === "AbortError") return;
      const again = h(
        "button",
        { type: "button", class: "button", on: { click: begin } },
        text("again"),
      );
      grid.replaceChildren(h("p", { class: "quiet" }, text("presets.none")), again);
    }

    function begin() {
      grid.replaceChildren();
      fill().catch(nothing);
    }

    function draw() {
      if (!shown) return;
      drawn = performance.now();
      for (const { picture, seen } of cards.values())
        if (seen && picture) picture(clock.time, colours);
    }

    function mark() {
      for (const [name, { button }] of cards)
        button.setAttribute("aria-pressed", name === store.get().preset);
    }

    function recolour() {
      const style = getComputedStyle(document.documentElement);
      colours = {
        pivot: style.getPropertyValue("--faint"),
        line: style.getPropertyValue("--quiet"),
        mass: style.getPropertyValue("--mass"),
      };
      draw();
    }

    bag(clock.subscribe(() => (!clock.playing || performance.now() - drawn > FRAME_MS) && draw()));
    bag(store.subscribe(mark));
    bag(theme.subscribe(recolour));
    for (const event of ["pointerenter", "focusin", "touchstart"])
      bag.on(grid, event, approach, { passive: true });
    recolour();
    begin();
    return {
      show() {
        shown = true;
        draw();
      },
      hide() {
        shown = false;
      },
      destroy() {
        stop.abort();
        sight.disconnect();
        bag.end();
        element.replaceChildren();
      },
    };
  },
};
