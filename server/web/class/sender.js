// What a pupil has on the stage, sent to the room: the newest, now and then; and a sign that the
// page is awake, for as long as it is seen.
// Leaves to others: what happens with it (board.js), who is silent (wall.js).
// Invariant: at most one write is under way, and they are PAUSE_MS apart; what is there already is
// not sent again but as such a sign, BEAT_MS after the last; nothing is sent before the room has
// been read.

import { createBag } from "../dom.js";
import { bareScene } from "./scenes.js";

const PAUSE_MS = 900; // the server takes 5 a second of a client, for long
const BEAT_MS = 20000; // from a sign to the next; a minute without one is a silence (wall.js)
const MOST_IDLE = 30 * 86400; // s that are told, as long as a room can be
const MOST_BYTES = 8000; // of one stage

/**
 * @typedef {{
 *   set(patch: Partial<OwnStage>): void, mark(release: number): void, rest(on: boolean): void,
 *   state: string, end: End,
 * }} Sender
 */

/**
 * more: what stands there beside the scene; released: the start that was let go, and of which
 * release it was; changed and wrote: when the pupil has last changed something, and when it was
 * last written, ms.
 * @typedef {{
 *   room: Room, more: Partial<OwnStage>, released: {number: number, scene: string}, sent: string,
 *   known: string, changed: number, wrote: number, timer: number, busy: boolean, rests: boolean,
 * }} Post
 */

/** What is to stand in the room now. @param {Post} post @returns {OwnStage} */
function ownStage({ room, more, released }) {
  const scene = bareScene(room.app.store.get());
  const text = JSON.stringify(scene);
  if (text.length > MOST_BYTES) return { ...more };
  const start = released.number > 0 && released.scene === text;
  return { ...more, scene, ...(start && { release: released.number }) };
}

/** The stage with how long it has been as it is. @param {Post} post @param {OwnStage} stage */
function sign(post, stage) {
  post.wrote = Date.now();
  const idle = Math.floor((post.wrote - post.changed) / 1000);
  return { ...stage, idle: Math.min(Math.max(idle, 0), MOST_IDLE) };
}

/** @param {Post} post @param {boolean} [beat] what is there already is sent again */
async function send(post, beat = false) {
  const { session } = post.room;
  clearTimeout(post.timer);
  post.timer = 0;
  const stage = ownStage(post);
  const text = JSON.stringify(stage);
  if (text !== post.known) [post.known, post.changed] = [text, Date.now()];
  if ((text === post.sent && !beat) || post.busy || !session.entry) return;
  post.busy = true;
  try {
    await session.put("stages/own", sign(post, stage));
    post.sent = text;
  } catch {
    // the stream of events finds out whether the room is gone; the next change is sent again
    post.sent = "";
  }
  post.busy = false;
  if (post.sent && JSON.stringify(ownStage(post)) !== post.sent) soon(post);
}

/** @param {Post} post @param {boolean} [beat] */
function soon(post, beat = false) {
  if (post.rests && !beat) return;
  // a class that comes back together does not write in one moment
  const pause = beat ? PAUSE_MS * (1 + Math.random()) : PAUSE_MS;
  post.timer ||= window.setTimeout(() => send(post, beat), pause);
}

/** Says that the page is awake, where that has not been said for a while. @param {Post} post */
function beat(post) {
  const seen = document.visibilityState === "visible";
  if (seen && Math.abs(Date.now() - post.wrote) > BEAT_MS / 2) send(post, true);
}

/** Who leaves the page says so; it may be the last that is heard. @param {Post} post */
function leave(post) {
  const { session } = post.room;
  const away = document.visibilityState === "hidden";
  if (!session.entry) return;
  const stage = { ...ownStage(post), ...(away && { state: "away" }) };
  post.sent = JSON.stringify(stage);
  session.put("stages/own", sign(post, stage), { keepalive: true }).catch(() => {
    post.sent = "";
  });
}

/** @param {Room} room @returns {Sender} */
export function createSender(room) {
  const { app, session } = room;
  const before = session.value(`stages/${session.entry?.pupil}`)?.state;
  const state = before && before !== "away" ? before : "working";
  const released = { number: 0, scene: "" };
  /** @type {Post} */
  const post = {
    room,
    more: { state },
    released,
    sent: "",
    known: "",
    changed: Date.now(),
    wrote: 0,
    timer: 0,
    busy: false,
    rests: false,
  };
  const bag = createBag();
  bag.on(document, "visibilitychange", () => leave(post));
  bag(app.store.subscribe(() => soon(post)));
  bag(session.subscribe((names) => names ?? (session.state === "live" && soon(post, true))));
  const timer = setInterval(() => beat(post), BEAT_MS);
  bag(() => clearInterval(timer));
  bag(() => clearTimeout(post.timer));
  send(post);
  return {
    set(patch) {
      post.more = { ...post.more, ...patch };
      send(post);
    },
    mark(number) {
      post.released = { number, scene: JSON.stringify(bareScene(app.store.get())) };
      send(post);
    },
    /** What is on the stage is the teacher's, who knows it. @param {boolean} on */
    rest(on) {
      post.rests = on;
      soon(post);
    },
    get state() {
      return post.more.state ?? "working";
    },
    end: bag.end,
  };
}
