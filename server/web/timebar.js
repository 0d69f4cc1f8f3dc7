// The time bar: play, step, speed, loop and a scrubber; the only hand on the clock besides the plots.
// Leaves to others: what is shown at a time.
// Invariant: shows the clock, keeps nothing of its own.

import { createBag, h, icon, iconButton } from "./dom.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export function mountTimebar(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const play = iconButton("play", text("time.play"), clock.toggle, { class: "icon-button play" });
  const step = (sign) => () => {
    clock.pause();
    clock.seek(clock.time + sign * Math.max(motion.doc.span.step, 0.02));
  };
  const back = iconButton("back", text("time.back"), step(-1));
  const forward = iconButton("forward", text("time.forward"), step(1));
  const loop = iconButton("loop", text("time.loop"), () => store.set({ view: { loop: !clock.loop } }), { "aria-pressed": "true" });
  const speed = h("select", { "aria-label": text("time.speed"), on: { change: () => store.set({ view: { speed: Number(speed.value) } }) } },
    ...SPEEDS.map((value) => h("option", { value }, text("time.times", { factor: text.short(value) }))));
  const scrub = h("input", { type: "range", class: "scrub", min: 0, max: 1, step: "any", value: 0, "aria-label": text("time.scrub"),
    on: { input: () => clock.seek(Number(scrub.value)) } });
  const now = h("output", { class: "now" });
  element.append(h("div", { class: "buttons" }, back, play, forward), h("div", { class: "track" }, scrub), now, speed, loop);

  function show() {
    const label = text(clock.playing ? "time.pause" : "time.play");
    if (play.getAttribute("aria-label") !== label) {
      play.setAttribute("aria-label", label);
      play.title = label;
      play.replaceChildren(icon(clock.playing ? "pause" : "play"));
    }
    scrub.max = clock.duration;
    scrub.value = clock.time;
    now.textContent = text("time.now", { time: text.number(clock.time, 2), duration: text.short(clock.duration) });
  }

  function settings(doc) {
    clock.setSpeed(doc.view.speed);
    clock.setLoop(doc.view.loop);
    speed.value = doc.view.speed;
    loop.setAttribute("aria-pressed", doc.view.loop);
  }

  bag(clock.subscribe(show));
  bag(store.subscribe(settings));
  settings(store.get());
  show();
  return { destroy: () => { bag.end(); element.replaceChildren(); } };
}
