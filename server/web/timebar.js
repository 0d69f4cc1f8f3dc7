// The time bar: play, step, speed, loop, how long, and a scrubber; over it what is known of the time to come.
// Leaves to others: what is shown at a time.
// Invariant: shows the clock, keeps nothing of its own.

import { createBag, h, icon, iconButton } from "./dom.js";
import { createMarks } from "./marks.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const LONGEST = 3600;
const MOST_SAMPLES = 20000;

/** How finely a motion of so many seconds is sampled. */
const stepOf = (stop) => (stop <= MOST_SAMPLES / 100 ? 0.01 : stop / MOST_SAMPLES);

export function mountTimebar(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const play = iconButton("play", text("time.play"), clock.toggle, {
    class: "icon-button play",
    "data-act": "play",
  });
  const step = (sign) => () => {
    clock.pause();
    clock.seek(clock.time + sign * Math.max(motion.doc.span.step, 0.02));
  };
  const start = iconButton("start", text("time.start"), () => clock.seek(0), {
    "data-act": "start",
  });
  const back = iconButton("back", text("time.back"), step(-1), { "data-act": "back" });
  const forward = iconButton("forward", text("time.forward"), step(1), { "data-act": "forward" });
  const loop = iconButton(
    "loop",
    text("time.loop"),
    () => store.set({ view: { loop: !clock.loop } }),
    { "data-act": "loop" },
  );
  const speed = h(
    "select",
    {
      class: "speed",
      "aria-label": text("time.speed"),
      on: { change: () => store.set({ view: { speed: Number(speed.value) } }) },
    },
    ...SPEEDS.map((value) =>
      h("option", { value }, text("time.times", { factor: text.short(value) })),
    ),
  );
  const scrub = h("input", {
    type: "range",
    class: "scrub",
    min: 0,
    max: 1,
    step: "any",
    value: 0,
    "aria-label": text("time.scrub"),
    on: { input: () => clock.seek(Number(scrub.value)), keydown: nudge },
  });
  const marks = createMarks(app);
  const caption = h("p", { class: "caption" });
  const now = h("span", { class: "now" });
  const until = h("input", {
    type: "text",
    inputmode: "decimal",
    class: "until",
    autocomplete: "off",
    "aria-label": text("time.until"),
    on: { change: lengthen },
  });
  element.append(
    h("div", { class: "buttons" }, start, back, play, forward),
    h("div", { class: "track" }, marks.canvas, scrub, caption),
    h("div", { class: "times" }, now, until, h("span", {}, "s")),
    speed,
    loop,
  );
  let shown = "";

  /** Keys move by a fiftieth of a second, pages by a second: a range without steps would jump. */
  function nudge(event) {
    const by = {
      ArrowLeft: -0.02,
      ArrowDown: -0.02,
      ArrowRight: 0.02,
      ArrowUp: 0.02,
      PageDown: -1,
      PageUp: 1,
    }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    clock.pause();
    clock.seek(clock.time + by);
  }

  function lengthen() {
    const stop = text.read(until.value);
    const sound = stop >= 0.1 && stop <= LONGEST;
    until.setAttribute("aria-invalid", !sound);
    if (!sound) return app.announce(text("time.until.wrong", { most: LONGEST }));
    store.set({ span: { stop, step: stepOf(stop) } }, { label: "span" });
  }

  function showPlay() {
    const label = text(clock.playing ? "time.pause" : "time.play");
    if (play.getAttribute("aria-label") === label) return;
    play.setAttribute("aria-label", label);
    play.title = label;
    play.replaceChildren(icon(clock.playing ? "pause" : "play"));
  }

  function show() {
    showPlay();
    const time = text.number(clock.time, 2);
    if (shown === time) return;
    shown = time;
    scrub.max = clock.duration;
    scrub.value = clock.time;
    scrub.style.setProperty("--share", clock.duration ? clock.time / clock.duration : 0);
    scrub.setAttribute(
      "aria-valuetext",
      text("time.now", { time, duration: text.short(clock.duration) }),
    );
    now.textContent = `${time} /`;
  }

  function settings(doc) {
    if (clock.speed !== doc.view.speed) clock.setSpeed(doc.view.speed);
    if (clock.loop !== doc.view.loop) clock.setLoop(doc.view.loop);
    speed.value = doc.view.speed;
    loop.setAttribute("aria-pressed", doc.view.loop);
    until.defaultValue = text.short(doc.span.stop, 6);
    if (document.activeElement !== until) until.value = until.defaultValue;
    until.style.width = `calc(${until.defaultValue.length}ch + 12px)`;
  }

  function explain() {
    const keys = [];
    const { selected } = store.get().view;
    const horizon = motion.stats?.horizon;
    if (marks.count()) keys.push(selected ? "time.marks.arm" : "time.marks");
    if (horizon < clock.duration) keys.push("time.trust");
    const holes = { arm: selected, time: text.short(horizon ?? 0, 3) };
    caption.textContent = keys.map((key) => text(key, holes)).join(" \u00b7 ");
    caption.title = keys.map((key) => text(`${key}.long`, holes)).join("; ");
  }

  bag(clock.subscribe(show));
  bag(
    store.subscribe((doc, before) => {
      settings(doc);
      if (doc.view.selected !== before.view.selected) {
        marks.draw();
        explain();
      }
    }),
  );
  bag(
    motion.subscribe((_, what) => {
      shown = "";
      show();
      marks.follow(what);
      explain();
    }),
  );
  bag(marks.destroy);
  settings(store.get());
  show();
  explain();
  return {
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}
