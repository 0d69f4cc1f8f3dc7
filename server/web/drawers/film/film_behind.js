// A film behind the motion: as large as the pendulum, with its pivot at the pivot, and at the time
// of the clock.
// Leaves to others: the film's pictures (film_frames.js), where things are in it (film_marks.js).
// Invariant: the clock leads, the film follows; what is drawn over it stays as it is.

import { createBag, h } from "../../dom.js";

const APART = 0.12; // s, from which on the film leaps to where it should be
const CLOSE = 1e-3; // s, that a film which stands may be away
const HASTE = 2; // of its speed, a second that it is late
const SPEEDS = [0.0625, 16]; // that browsers play at

/**
 * The film on the stage; how: a + b (across - i down), m from where the pendulum's places count;
 * slow: seconds of the film a second.
 * @typedef {{
 *   app: App, film: import("./film_frames.js").Film, place: HTMLElement, how: {a:
 *   import("./film_marks.js").Complex, b: import("./film_marks.js").Complex} | null, slow: number,
 * }} View
 */

/** Lays the film so that its pixels are where the pendulum's places are. @param {View} view */
function lay({ app, film, how, place }) {
  if (!how) return;
  const { x, y, scale } = app.stage.camera;
  const [re, im] = how.b.map((part) => part * scale);
  const shift = [x + scale * how.a[0], y - scale * how.a[1]];
  film.video.style.transform = `matrix(${[re, -im, im, re, ...shift].map((part) => part.toFixed(9)).join()})`;
  place.hidden = false;
}

/** Where the film should be, s of its own. @param {View} view */
const wantedOf = ({ app, slow }) =>
  ((app.motion.track.doc.span.start ?? 0) + app.clock.time) * slow;

/** Leads the film to the time of the clock. @param {View} view */
function follow(view) {
  const { app, film, how, slow } = view;
  const { video, duration } = film;
  const { clock } = app;
  if (!how) return;
  const wanted = wantedOf(view);
  const late = wanted - video.currentTime;
  const inside = wanted >= 0 && wanted < duration;
  if (!clock.playing || clock.waiting || !inside) {
    if (!video.paused) video.pause();
    const goal = Math.min(Math.max(wanted, 0), duration);
    if (!video.seeking && Math.abs(goal - video.currentTime) > CLOSE) video.currentTime = goal;
    return;
  }
  if (video.seeking) return;
  const speed = clock.speed * slow;
  if (Math.abs(late) > APART * Math.max(1, speed)) video.currentTime = wanted;
  const haste = 1 + Math.max(-0.25, Math.min(0.25, (HASTE * late) / Math.max(speed, 0.1)));
  video.playbackRate = Math.min(Math.max(speed * haste, SPEEDS[0]), SPEEDS[1]);
  // a browser that refuses shows single pictures
  if (video.paused) video.play().catch(() => {});
}

/**
 * Puts the film behind the stage: {show(how, slow), hide, destroy}.
 * @param {App} app @param {import("./film_frames.js").Film} film
 */
export function createBehind(app, film) {
  const bag = createBag();
  const place = h("div", { class: "film-behind", "aria-hidden": "true" }, film.video);
  document.getElementById("stage")?.prepend(place);
  film.video.style.width = `${film.width}px`;
  film.video.style.height = `${film.height}px`;
  /** @type {View} */
  const view = { app, film, place, how: null, slow: 1 };
  bag(app.stage.join({ follow: () => lay(view) }));
  bag(app.clock.subscribe(() => follow(view)));
  bag.on(film.video, "seeked", () => follow(view));
  return {
    /** @param {NonNullable<View["how"]>} how @param {number} slow */
    show(how, slow) {
      Object.assign(view, { how, slow });
      place.classList.add("seen");
      lay(view);
      follow(view);
    },
    hide() {
      view.how = null;
      place.classList.remove("seen");
      film.video.pause();
    },
    destroy() {
      bag.end();
      place.remove();
    },
  };
}
