// The time bar: play, step, speed, loop, how long, and a scrubber; over it what is known of the
// time to come.
// Leaves to others: what is shown at a time.
// Invariant: shows the clock, keeps nothing of its own.

import { createBag, h, icon, iconButton } from "./dom.js";
import { createMarks } from "./marks.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const LONGEST = 3600;
const MOST_SAMPLES = 20000;
const STEP_SECONDS = 0.02;
const SELDOM_MS = 100; // while it plays: each change lays the page out anew

/**
 * By how many seconds keys move the scrubber: a range without steps would jump.
 * @type {Record<string, number>}
 */
const NUDGES = {
  ArrowLeft: -STEP_SECONDS,
  ArrowDown: -STEP_SECONDS,
  ArrowRight: STEP_SECONDS,
  ArrowUp: STEP_SECONDS,
  PageDown: -1,
  PageUp: 1,
};

/**
 * The bar's controls, and the time that they show, and since when.
 * @typedef {ReturnType<typeof controlsOf> & {app: App, marks: ReturnType<typeof createMarks>,
 * shown: string, told: number}} Bar
 */

/** How finely a motion of so many seconds is sampled. @param {number} stop */
const stepOf = (stop) => (stop <= MOST_SAMPLES / 100 ? 0.01 : stop / MOST_SAMPLES);

/** Stands still, at so many seconds from now. @param {Clock} clock @param {number} by */
function move(clock, by) {
  clock.pause();
  clock.seek(clock.time + by);
}

/** @param {Clock} clock @param {KeyboardEvent} event */
function nudge(clock, event) {
  const by = NUDGES[event.key];
  if (by === undefined) return;
  event.preventDefault();
  move(clock, by);
}

/** Another duration, as it has been typed. @param {App} app @param {HTMLInputElement} until */
function lengthen({ store, text, object }, until) {
  const { start } = store.get().span;
  const stop = text.read(until.value) - (start ?? 0);
  const sound = stop >= 0.1 && stop <= LONGEST;
  until.setAttribute("aria-invalid", String(!sound));
  if (!sound) return object(text("time.until.wrong", { most: LONGEST }));
  const span = { stop, step: stepOf(stop) };
  store.set({ span: start ? { start, ...span } : span }, { label: "span" });
}

/** The buttons that move the clock. @param {App} app */
function buttonsOf({ motion, clock, store, text }) {
  const step = (/** @type {number} */ sign) => () =>
    move(clock, sign * Math.max(motion.doc.span.step, STEP_SECONDS));
  const turn = () => store.set({ view: { loop: !clock.loop } });
  const look = { class: "icon-button play", "data-act": "play" };
  return {
    start: iconButton("start", text("time.start"), () => clock.seek(0), { "data-act": "start" }),
    back: iconButton("back", text("time.back"), step(-1), { "data-act": "back" }),
    play: iconButton("play", text("time.play"), clock.toggle, look),
    forward: iconButton("forward", text("time.forward"), step(1), { "data-act": "forward" }),
    loop: iconButton("loop", text("time.loop"), turn, { "data-act": "loop" }),
  };
}

/** @param {App} app */
function controlsOf(app) {
  const { clock, store, text } = app;
  const speeds = SPEEDS.map((value) =>
    h("option", { value }, text("time.times", { factor: text.short(value) })),
  );
  const change = () => store.set({ view: { speed: Number(speed.value) } });
  const speed = h(
    "select",
    { class: "speed", "aria-label": text("time.speed"), on: { change } },
    ...speeds,
  );
  const scrub = h("input", {
    type: "range",
    class: "scrub",
    min: 0,
    max: 1,
    step: "any",
    value: 0,
    "aria-label": text("time.scrub"),
    on: {
      input: () => clock.seek(Number(scrub.value)),
      keydown: (/** @type {KeyboardEvent} */ event) => nudge(clock, event),
    },
  });
  const until = h("input", {
    type: "text",
    inputmode: "decimal",
    class: "until",
    autocomplete: "off",
    "aria-label": text("time.until"),
    on: { change: () => lengthen(app, until) },
  });
  const caption = h("p", { class: "caption" });
  const now = new Text();
  return { ...buttonsOf(app), speed, scrub, until, caption, now };
}

/** @param {Bar} bar */
function showPlay({ app, play }) {
  const { playing } = app.clock;
  const label = app.text(playing ? "time.pause" : "time.play");
  if (play.getAttribute("aria-label") === label) return;
  play.setAttribute("aria-label", label);
  play.title = label;
  play.replaceChildren(icon(playing ? "pause" : "play"));
}

/** @param {Bar} bar */
function show(bar) {
  const { app, scrub, now } = bar;
  const { clock, text } = app;
  showPlay(bar);
  const { start = 0 } = app.motion.doc.span;
  const time = text.number(start + clock.time, 2);
  const instant = performance.now();
  if (bar.shown === time || (clock.framing && instant - bar.told < SELDOM_MS)) return;
  [bar.shown, bar.told] = [time, instant];
  scrub.max = String(clock.duration);
  scrub.value = String(clock.time);
  scrub.style.setProperty("--share", String(clock.duration ? clock.time / clock.duration : 0));
  const words = text("time.now", { time, duration: text.short(start + clock.duration) });
  scrub.setAttribute("aria-valuetext", words);
  now.data = `${time} /`;
}

/** The document's settings, for the clock and on the bar. @param {Bar} bar @param {Doc} doc */
function settings({ app, speed, loop, until }, doc) {
  const { clock, text } = app;
  if (clock.speed !== doc.view.speed) clock.setSpeed(doc.view.speed);
  if (clock.loop !== doc.view.loop) clock.setLoop(doc.view.loop);
  speed.value = String(doc.view.speed);
  loop.setAttribute("aria-pressed", String(doc.view.loop));
  until.defaultValue = text.short((doc.span.start ?? 0) + doc.span.stop, 6);
  if (document.activeElement !== until) until.value = until.defaultValue;
  until.style.width = `calc(${until.defaultValue.length}ch + 12px)`;
}

/** What the marks over the bar mean. @param {Bar} bar */
function explain({ app, marks, caption }) {
  const { store, motion, clock, text } = app;
  const keys = [];
  const { selected } = store.get().view;
  const horizon = motion.stats?.horizon;
  if (marks.count()) keys.push(selected ? "time.marks.arm" : "time.marks");
  if (horizon !== undefined && horizon < clock.duration) keys.push("time.trust");
  const holes = {
    arm: selected,
    time: text.short((motion.doc.span.start ?? 0) + (horizon ?? 0), 3),
  };
  caption.textContent = keys.map((key) => text(key, holes)).join(" \u00b7 ");
  caption.title = keys.map((key) => text(`${key}.long`, holes)).join("; ");
}

/** @param {HTMLElement} element @param {Bar} bar */
function lay(
  element,
  { start, back, play, forward, marks, scrub, caption, now, until, speed, loop },
) {
  element.append(
    h("div", { class: "buttons" }, start, back, play, forward),
    h("div", { class: "track" }, marks.canvas, scrub, caption),
    h("div", { class: "times" }, h("span", { class: "now" }, now), until, h("span", {}, "s")),
    speed,
    loop,
  );
}

/** @param {HTMLElement} element @param {App} app */
export function mountTimebar(element, app) {
  const { store, motion, clock } = app;
  const bag = createBag();
  const marks = createMarks(app, () => explain(bar));
  /** @type {Bar} */
  const bar = { ...controlsOf(app), app, marks, shown: "", told: 0 };
  lay(element, bar);
  bag(clock.subscribe(() => show(bar)));
  bag(
    store.subscribe((doc, before) => {
      settings(bar, doc);
      const same = doc.view.arrows === before.view.arrows;
      if (same && doc.view.selected === before.view.selected) return;
      marks.draw();
      explain(bar);
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      bar.shown = "";
      show(bar);
      marks.follow(what);
      explain(bar);
    }),
  );
  bag(marks.destroy);
  settings(bar, store.get());
  show(bar);
  explain(bar);
  return {
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}
