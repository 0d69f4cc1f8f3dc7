// A film's pictures one by one: a video file of this computer, shown at a time, a picture onwards
// or back, with the time of the picture that is seen.
// Leaves to others: what is marked in it (film_marks.js), its motion in time (film_behind.js).
// Invariant: the file stays in the browser; `time` is that of the picture that is seen, where the
// browser tells it (requestVideoFrameCallback), else a multiple of the rate that is given; `twin`
// is then the time for which the browser showed the picture that is seen now, else NaN: Firefox has
// no way to the last picture before one that is kept whole.

import { h } from "../../dom.js";

const WAITS_MS = 400; // for a picture to be seen, after the video is there
const FIRST_GAP = 1 / 60; // s between pictures, before any was seen
const GAPS = 9; // of which the middle one is taken
const BEYOND = 1e7; // s: further than any film
const TELLS = "requestVideoFrameCallback" in HTMLVideoElement.prototype;
const ASKED = 0.381966; // of a film: no picture's own time
const SAME = 1e-5; // s
const TURNS = 5; // until a busy browser has told something

/**
 * The film while it is open. time, s: of the picture that is seen; gaps: between the last ones;
 * busy: the last thing asked of it; paper: where its pictures can be read.
 * @typedef {{
 *   video: HTMLVideoElement, time: number, duration: number, width: number, height: number,
 *   gaps: number[], busy: Promise<void>, tells: boolean, close: () => void, twin: number,
 *   paper: CanvasRenderingContext2D,
 * }} Film
 */

/** Resolves with an event. @param {HTMLVideoElement} video @param {string} name */
const heard = (video, name) =>
  new Promise((resolve, reject) => {
    const bad = () => reject(Object.assign(new Error("no film"), { kind: "film" }));
    video.addEventListener("error", bad, { once: true });
    video.addEventListener(
      name,
      (event) => {
        video.removeEventListener("error", bad);
        resolve(event);
      },
      { once: true },
    );
  });

/** The time of the next picture that is shown; NaN where none comes. @param {HTMLVideoElement}
 * video */
function presented(video) {
  let end = () => {};
  const told = new Promise((resolve) => {
    const id = video.requestVideoFrameCallback((_, { mediaTime }) => resolve(mediaTime));
    end = () => {
      video.cancelVideoFrameCallback(id);
      resolve(NaN);
    };
  });
  return { told, end: () => end() };
}

/**
 * Shows the picture at a time; resolves with the time that the browser tells of it, or with NaN.
 * @param {Film} film @param {number} time s
 */
async function show(film, time) {
  const { video, duration } = film;
  const frame = film.tells ? presented(video) : null;
  const seeked = heard(video, "seeked");
  video.currentTime = Math.min(Math.max(time, 0), duration);
  await seeked;
  film.time = video.currentTime;
  if (!frame) return NaN;
  const timer = setTimeout(frame.end, WAITS_MS);
  const seen = Number(await frame.told);
  clearTimeout(timer);
  if (!Number.isNaN(seen)) film.time = seen;
  return seen;
}

/** What is asked of a film is done in its order. @param {Film} film @param {() => Promise<void>}
 * what */
function inTurn(film, what) {
  film.busy = film.busy.then(what, what);
  return film.busy;
}

/** Shows the picture at a time. @param {Film} film @param {number} time s of the film */
export const seek = (film, time) =>
  inTurn(film, async () => {
    await show(film, time);
  });

/** The picture that is seen, in the film's own pixels. @param {Film} film */
export function pictureOf({ video, paper, width, height }) {
  paper.drawImage(video, 0, 0, width, height);
  return paper.getImageData(0, 0, width, height);
}

/** The picture that is seen, in numbers of four bytes. @param {Film} film */
const dots = (film) => new Uint32Array(pictureOf(film).data.buffer);

/** s between two pictures, as far as it is known. @param {Film} film */
function gapOf({ gaps }) {
  const sorted = [...gaps].sort((a, b) => a - b);
  return sorted[Math.floor(sorted.length / 2)] ?? FIRST_GAP;
}

/**
 * A picture onwards (1) or back (-1); without the browser's word for its time, by the rate.
 * @param {Film} film @param {1 | -1} way @param {number} rate pictures a second
 */
async function stepped(film, way, rate) {
  const from = film.time;
  if (!film.tells) {
    const next = Math.round(from * rate) + way;
    film.twin = NaN;
    if (next < 0 || next / rate >= film.duration) return;
    const before = dots(film);
    // in the middle of the time for which it is seen
    await show(film, (next + 0.5) / rate);
    film.time = next / rate;
    if (way > 0 && dots(film).every((dot, i) => dot === before[i])) film.twin = from;
    return;
  }
  const gap = gapOf(film);
  const last = way > 0 ? film.duration : 0;
  // the next picture may be nearer or further than the last ones were
  for (let far = way > 0 ? 1.25 * gap : 0.5 * gap; film.time === from; far += gap / 2) {
    const time = from + way * far;
    const end = way * (time - last) >= 0;
    await show(film, end ? last : time);
    if (end) break;
  }
  const passed = Math.abs(film.time - from);
  if (passed > 0 && passed < 3 * gap) film.gaps = [...film.gaps, passed].slice(-GAPS);
}

/**
 * Whether there was another picture.
 * @param {Film} film @param {1 | -1} way @param {number} rate
 */
export async function step(film, way, rate) {
  const from = film.time;
  await inTurn(film, () => stepped(film, way, rate));
  return film.time !== from;
}

/** Some films do not say how long they are (what a browser recorded): their end tells it.
 * @param {HTMLVideoElement} video */
async function measured(video) {
  if (Number.isFinite(video.duration)) return video.duration;
  const seeked = heard(video, "seeked");
  video.currentTime = BEYOND;
  await seeked;
  return Number.isFinite(video.duration) ? video.duration : video.currentTime;
}

/**
 * Whether the browser tells when a picture is: Firefox tells what was asked, whatever it shows.
 * @param {Film} film
 */
async function tellsOwn(film) {
  for (let turn = 0; film.tells && turn < TURNS; turn++) {
    const asked = (ASKED + 0.01 * turn) * film.duration;
    const told = await show(film, asked);
    if (!Number.isNaN(told)) return Math.abs(told - asked) > SAME;
  }
  return film.tells;
}

/**
 * Opens a video file; throws an error of the kind "film" where the browser cannot show it.
 * @param {File} file @returns {Promise<Film>}
 */
export async function openFilm(file) {
  const video = h("video", { playsinline: true, preload: "auto", tabindex: -1 });
  const address = URL.createObjectURL(file);
  const close = () => {
    video.removeAttribute("src");
    video.load();
    video.remove();
    URL.revokeObjectURL(address);
  };
  video.muted = true;
  try {
    const there = heard(video, "loadeddata");
    video.src = address;
    await there;
    const duration = await measured(video);
    const { videoWidth: width, videoHeight: height } = video;
    if (!width || !(duration > 0)) throw Object.assign(new Error("no pictures"), { kind: "film" });
    const size = { width, height, duration };
    const busy = Promise.resolve();
    const canvas = h("canvas", { width, height });
    const paper = /** @type {CanvasRenderingContext2D} */ (
      canvas.getContext("2d", { willReadFrequently: true })
    );
    const state = { time: 0, gaps: [], busy, tells: TELLS, twin: NaN };
    /** @type {Film} */
    const film = { video, ...size, ...state, paper, close };
    film.tells = await tellsOwn(film);
    await seek(film, 0);
    return film;
  } catch (error) {
    close();
    throw error;
  }
}

/**
 * Takes files that are dropped on an element.
 * @param {HTMLElement} element @param {(file: File | undefined) => void} take
 */
export function dropping(element, take) {
  const over = (/** @type {boolean} */ on) => (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    element.classList.toggle("dropping", on);
  };
  element.addEventListener("dragover", over(true));
  element.addEventListener("dragleave", over(false));
  element.addEventListener("drop", (event) => {
    over(false)(event);
    take(event.dataTransfer?.files[0]);
  });
}
