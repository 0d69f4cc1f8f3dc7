// Let go together: the whole class starts the same pendulum, by hand or a hair apart; all of them
// in one picture, and how far they are apart over time beside the exponent.
// Leaves to others: the pupils' side (pupil.js), motions and exponents (the server), charts.
// Invariant: what is drawn are the starts that pupils have sent for this release, each as the
// server moves it.

import { createClock } from "../clock.js";
import { h } from "../dom.js";
import { createGroup } from "../drawers/kit/chart.js";
import { aborted, button, choice, cssValue, figure } from "../drawers/kit/kit.js";
import { createSpots, order, reach, tips } from "../tree.js";
import { openDialog } from "./board.js";
import { wholeScene } from "./scenes.js";
import { anglesOver, poseOf } from "./wall.js";

/** @typedef {import("./teach.js").Desk} Desk */

const SPREADS = ["hand", "0.001", "0.000001"];
const SPAN = { start: 0, stop: 20, step: 0.02 };
const AT_ONCE = 3;
const APART = 0.1; // rad, from which on starts are said to have parted
const FOLLOWED = 60; // s, for the exponent

/**
 * The picture while it is open; motions: by the pupil's number, rows of angles.
 * @typedef {{
 *   room: Room, number: number, tree: Tree | null, scene: ClassScene | null, motions: Map<number,
 *   Float64Array>,
 *   loading: Set<number>, stop: AbortController, canvas: HTMLCanvasElement, clock: Clock, words:
 *   HTMLElement, exponent: number | null, chart: Chart | null, group: ChartGroup | null, spread:
 *   Float64Array,
 * }} Picture
 */

/** Who has sent a start for this release. @param {Picture} picture */
function startsOf({ room: { session }, number, tree }) {
  /** @type {{number: number, scene: ClassScene}[]} */
  const starts = [];
  for (const { name, value } of session.items.values()) {
    const [kind, id] = name.split("/");
    if (kind !== "stages" || value.release !== number || !value.scene) continue;
    if (value.scene.request.pendulum.parent?.length === tree?.length.length)
      starts.push({ number: Number(id), scene: value.scene });
  }
  return starts;
}

/**
 * The largest difference of an angle between any two, instant by instant. @param {Picture} picture
 */
function spreadOf({ motions, tree }) {
  const n = tree?.length.length ?? 1;
  const all = [...motions.values()];
  const rows = Math.min(...all.map((motion) => motion.length / n));
  return Float64Array.from({ length: rows }, (_, row) => {
    let most = 0;
    for (let k = row * n; k < (row + 1) * n; k++) {
      const values = all.map((motion) => motion[k]);
      most = Math.max(most, Math.max(...values) - Math.min(...values));
    }
    return most;
  });
}

/** @param {Picture} picture */
function tell({ room: { say, app }, motions, spread, words, exponent }) {
  const parts = [say.count("class.together.starts", motions.size)];
  if (spread.length) {
    const row = spread.findIndex((far) => far > APART);
    parts.push(say("class.together.first", { far: figure(app.text, spread[0]) }));
    if (row > 0)
      parts.push(say("class.together.apart", { time: app.text.number(row * SPAN.step, 1) }));
  }
  if (exponent !== null)
    parts.push(say("class.together.exponent", { exponent: app.text.short(exponent, 3) }));
  words.textContent = parts.join(" ");
}

/** @param {Picture} picture */
function follow(picture) {
  const { motions, chart, exponent, clock } = picture;
  picture.spread = motions.size > 1 ? spreadOf(picture) : new Float64Array(0);
  const { spread } = picture;
  tell(picture);
  const t = Float64Array.from(spread, (_, row) => row * SPAN.step);
  const line = Array.from(t, (time) => {
    const far = exponent === null ? NaN : spread[0] * Math.exp(exponent * time);
    return far > 0 && far < 2 * Math.PI ? far : null;
  });
  chart?.set([t, Array.from(spread, (far) => (far > 0 ? far : null)), line]);
  const first = clock.duration === 0;
  clock.extent(SPAN.stop, SPAN.stop, true);
  if (first) clock.play();
  draw(picture);
}

/** @param {Picture} picture */
async function load(picture) {
  const { room, motions, loading, stop } = picture;
  const next = startsOf(picture).find(({ number }) => !motions.has(number) && !loading.has(number));
  if (!next || stop.signal.aborted) return;
  loading.add(next.number);
  try {
    motions.set(next.number, await anglesOver(room.app.client, next.scene, SPAN, stop.signal));
    follow(picture);
  } catch (error) {
    if (!aborted(error) && !(/** @type {Failed} */ (error).kind)) throw error;
  }
  load(picture);
}

/** How fast neighbours part, from the class's start. @param {Picture} picture */
async function loadExponent(picture) {
  const { room, scene, stop } = picture;
  if (!scene) return;
  const { pendulum, initial } = scene.request;
  const options = { signal: stop.signal };
  try {
    const body = { pendulum, initial, duration: FOLLOWED, samples: 1 };
    const reply = await room.app.client.post("/v1/lyapunov", body, options);
    picture.exponent = (await reply.json()).exponents.at(-1)[0];
    follow(picture);
  } catch (error) {
    // a pendulum whose exponent the server does not tell has none here
    if (!aborted(error) && !(/** @type {Failed} */ (error).kind)) throw error;
  }
}

/** @param {Picture} picture */
function draw({ canvas, tree, motions, clock }) {
  if (!tree || !canvas.isConnected) return;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const rows = order(tree.parent);
  const n = rows.length;
  const spots = createSpots(n);
  const { x, y, fromX, fromY } = spots;
  const scale = (Math.min(canvas.width, canvas.height) / 2 - 12) / reach(tree);
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.translate(canvas.width / 2, canvas.height / 2);
  context.lineWidth = Math.max(1.5, canvas.width / 300);
  context.globalAlpha = Math.max(0.3, 1 / Math.sqrt(motions.size || 1));
  for (const [number, motion] of motions) {
    const row = Math.min(Math.floor(clock.time / SPAN.step), motion.length / n - 1);
    tips(tree, rows, motion, row * n, spots, row * SPAN.step);
    context.strokeStyle = context.fillStyle = cssValue(`--arm-${((number - 1) % 8) + 1}`);
    context.beginPath();
    for (const k of rows) {
      context.moveTo(scale * fromX[k], -scale * fromY[k]);
      context.lineTo(scale * x[k], -scale * y[k]);
    }
    context.stroke();
    for (const k of rows) {
      context.beginPath();
      context.arc(scale * x[k], -scale * y[k], 2.5 * context.lineWidth, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

/** @param {Picture} picture @param {HTMLElement} host */
function addChart(picture, host) {
  const { room, clock } = picture;
  picture.group = createGroup({ ...room.app, clock });
  const series = [
    { colour: "--arm-1", width: 2 },
    { colour: "--arm-2", dash: [6, 4] },
  ];
  picture.chart = picture.group.add(host, { series, log: true, height: 200 });
  follow(picture);
}

/** @param {Room} room @returns {Promise<Picture>} */
async function createPicture(room) {
  const { app, session, say } = room;
  /** @type {ClassStage} */
  const { scene, release } = session.value("stages/class") ?? {};
  const side = Math.max(240, Math.min(innerWidth - 80, innerHeight - 330, 640));
  const size = { width: 2 * side, height: 2 * side };
  const label = { role: "img", "aria-label": say("class.together.picture") };
  const canvas = h("canvas", { class: "overlay", ...size, ...label });
  canvas.style.width = canvas.style.height = `${side}px`;
  return {
    room,
    number: release?.number ?? 0,
    tree: (await poseOf(app, scene))?.tree ?? null,
    scene: scene ?? null,
    motions: new Map(),
    loading: new Set(),
    stop: new AbortController(),
    canvas,
    clock: createClock(),
    words: h("p", { class: "class-now", role: "status" }),
    exponent: null,
    chart: null,
    group: null,
    spread: new Float64Array(0),
  };
}

/** All starts of the release in one picture. @param {Room} room */
async function openPicture(room) {
  const { session, say } = room;
  const picture = await createPicture(room);
  const { clock, canvas, words } = picture;
  const host = h("div", { class: "chart", role: "img", "aria-label": say("class.together.chart") });
  const again = button(say("class.together.again"), () => {
    clock.seek(0);
    clock.play();
  });
  const title = h("p", { class: "chart-title" }, say("class.together.chart"));
  const line = h("p", { class: "quiet" }, say("class.together.line"));
  const beside = h("div", { class: "overlay-side" }, title, host, line, again);
  const row = h("div", { class: "overlay-row" }, canvas, beside);
  const dialog = openDialog(room, "together", say("class.together"), words, row);
  const ends = [session.subscribe(() => load(picture)), clock.subscribe(() => draw(picture))];
  dialog.addEventListener("close", () => {
    picture.stop.abort();
    clock.pause();
    picture.group?.destroy();
    ends.forEach((end) => end());
  });
  addChart(picture, host);
  loadExponent(picture);
  for (let i = 0; i < AT_ONCE; i++) load(picture);
}

/** @param {Room} room @param {Desk} desk */
export function togetherPart(room, desk) {
  const { app, session, say, tell: speak } = room;
  let spread = "hand";
  const options = SPREADS.map((value) => ({ value, words: say(`class.spread.${value}`) }));
  const spreads = choice(say("class.spread"), options, spread, (value) => {
    spread = value;
  });
  spreads.select.dataset.class = "spread";
  const go = button(
    say("class.release"),
    async () => {
      const number = (desk.stage().release?.number ?? Math.floor(Date.now() / 1000) % 900000) + 1;
      const release = spread === "hand" ? { number } : { number, spread: Number(spread) };
      const scene = wholeScene(app.store.get());
      await desk.change({ scene, frozen: false, release, follow: undefined });
      speak(say("class.did.release"));
    },
    { "data-class": "release" },
  );
  const look = button(say("class.together.look"), () => openPicture(room), {
    "data-class": "together",
  });
  const place = h(
    "section",
    { class: "together-part" },
    h("h3", {}, say("class.together")),
    h("p", { class: "quiet" }, say("class.together.hint")),
    h("div", { class: "row" }, spreads.element, go, look),
  );
  return {
    place,
    show() {
      look.disabled = !session.value("stages/class")?.release;
    },
  };
}
