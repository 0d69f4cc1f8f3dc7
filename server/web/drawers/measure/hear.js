// The motion for those who do not see it: told in words when they are asked for, and as a tone
// whose pitch follows an arm's angle.
// Leaves to others: reading swings (periods.js), which arm (measure.js).
// Invariant: silent until asked for; a tone sounds only while the motion runs and the drawer is
// open; the words tell the instant at which they were asked for.

import { foldedTheta } from "../../angles.js";
import { createBag, h } from "../../dom.js";
import { button, tick } from "../kit/kit.js";
import { periodOf, swingsOf } from "./periods.js";

const MOST_ARMS = 4;
const MIDDLE = 330; // Hz, of an arm that hangs
const OCTAVE = 90; // degrees
const VOLUME = 0.08;
const GLIDE = 0.015; // s, in which the pitch follows
const STILL = 0.02; // rad/s

/** Hz of an angle from hanging, degrees in (-180, 180]. @param {number} theta */
export const pitchOf = (theta) => MIDDLE * 2 ** (theta / OCTAVE);

/** One arm at an instant, and its swings, in words. @param {App} app @param {number} arm */
function armInWords({ motion, clock, text }, arm) {
  const { phi, phid } = motion.at(clock.time);
  const theta = foldedTheta(phi[arm - 1]);
  const rate = phid[arm - 1];
  const { times, amplitude, over } = swingsOf(motion.track, arm);
  const period = periodOf(times);
  const regular = period?.periodic && !over;
  const side = Math.abs(theta) < 0.5 ? "middle" : theta > 0 ? "right" : "left";
  const moves = Math.abs(rate) < STILL ? "rest" : rate > 0 ? "cc" : "cw";
  const holes = {
    arm,
    angle: text.number(Math.abs(theta), 0),
    side: text(`measure.hear.${side}`),
    moves: text(`measure.hear.${moves}`),
    most: text.number(amplitude, 0),
  };
  const swing = regular
    ? text("measure.hear.period", { time: text.number(period.mean, 2) })
    : text("measure.hear.noPeriod");
  return `${text("measure.hear.arm", holes)} ${swing}`;
}

/** The motion at this instant in words. @param {App} app */
function inWords(app) {
  const { motion, clock, text } = app;
  const told = Math.min(motion.n, MOST_ARMS);
  const arms = Array.from({ length: told }, (_, k) => armInWords(app, k + 1));
  const time = text.number((motion.doc.span.start ?? 0) + clock.time, 2);
  const more = motion.n - told;
  return [
    text("measure.hear.at", { time }),
    ...arms,
    ...(more ? [text.count("measure.hear.more", more)] : []),
  ].join(" ");
}

/** A tone that can be heard, or null where there is none. */
function createTone() {
  if (!("AudioContext" in window)) return null;
  const context = new AudioContext();
  const tone = context.createOscillator();
  const volume = context.createGain();
  volume.gain.value = 0;
  tone.connect(volume).connect(context.destination);
  tone.start();
  return {
    /** @param {number} pitch Hz @param {boolean} loud */
    set(pitch, loud) {
      tone.frequency.setTargetAtTime(pitch, context.currentTime, GLIDE);
      volume.gain.setTargetAtTime(loud ? VOLUME : 0, context.currentTime, GLIDE);
    },
    end: () => context.close(),
  };
}

/** @param {App} app @param {() => number} armOf the arm that is heard */
export function createHearing(app, armOf) {
  const { motion, clock, text } = app;
  const bag = createBag();
  const words = h("p", { class: "quiet", role: "status", "data-hear": "words" });
  /** @type {ReturnType<typeof createTone>} */
  let tone = null;
  let shown = true;
  function sound() {
    if (!tone) return;
    const arm = Math.min(armOf(), motion.n);
    const loud = clock.playing && shown && !document.hidden;
    tone.set(pitchOf(foldedTheta(motion.at(clock.time).phi[arm - 1])), loud);
  }
  const silence = () => {
    tone?.end();
    tone = null;
  };
  const heard = tick(text("measure.hear.sound"), false, (on) => {
    silence();
    tone = on ? createTone() : null;
    if (on && !tone) words.textContent = text("measure.hear.noSound");
    sound();
  });
  heard.box.dataset.hear = "sound";
  const tell = () => {
    const share = motion.total ? Math.floor((100 * motion.count) / motion.total) : 0;
    words.textContent = motion.complete ? inWords(app) : text("loading", { share });
  };
  const ask = button(text("measure.hear.tell"), tell, { "data-hear": "tell" });
  bag(clock.subscribe(sound));
  bag.on(document, "visibilitychange", sound);
  bag(silence);
  return {
    element: h("div", {}, h("div", { class: "row" }, ask), words, heard.element),
    /** @param {boolean} on whether the drawer is open */
    show(on) {
      shown = on;
      sound();
    },
    destroy: bag.end,
  };
}
