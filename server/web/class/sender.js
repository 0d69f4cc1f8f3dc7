// What a pupil has on the stage, sent to the room: the newest, now and then.
// Leaves to others: what happens with it (board.js).
// Invariant: at most one write is under way, and they are PAUSE_MS apart; what is there already is
// not sent again; nothing is sent before the room has been read.

import { createBag } from "../dom.js";
import { bareScene } from "./scenes.js";

const PAUSE_MS = 900; // the server takes 5 a second of a client, for long
const MOST_BYTES = 8000; // of one stage

/**
 * @typedef {{
 *   set(patch: Partial<OwnStage>): void, mark(release: number): void, state: string, end: End,
 * }} Sender
 */

/**
 * more: what stands there beside the scene; released: the start that was let go, and of which
 * release it was.
 * @typedef {{
 *   room: Room, more: Partial<OwnStage>, released: {number: number, scene: string}, sent: string,
 *   timer: number, busy: boolean,
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

/** @param {Post} post */
async function send(post) {
  const { session } = post.room;
  clearTimeout(post.timer);
  post.timer = 0;
  const stage = ownStage(post);
  const text = JSON.stringify(stage);
  if (text === post.sent || post.busy || !session.entry) return;
  post.busy = true;
  try {
    await session.put("stages/own", stage);
    post.sent = text;
  } catch {
    // the stream of events finds out whether the room is gone; the next change is sent again
    post.sent = "";
  }
  post.busy = false;
  if (post.sent && JSON.stringify(ownStage(post)) !== post.sent) soon(post);
}

/** @param {Post} post */
function soon(post) {
  post.timer ||= window.setTimeout(() => send(post), PAUSE_MS);
}

/** Who leaves the page says so; it may be the last that is heard. @param {Post} post */
function leave(post) {
  const { session } = post.room;
  const away = document.visibilityState === "hidden";
  if (!session.entry) return;
  const stage = { ...ownStage(post), ...(away && { state: "away" }) };
  post.sent = JSON.stringify(stage);
  session.put("stages/own", stage, { keepalive: true }).catch(() => {
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
  const post = { room, more: { state }, released, sent: "", timer: 0, busy: false };
  const bag = createBag();
  bag.on(document, "visibilitychange", () => leave(post));
  bag(app.store.subscribe(() => soon(post)));
  bag(session.subscribe((names) => names ?? (session.state === "live" && soon(post))));
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
    get state() {
      return post.more.state ?? "working";
    },
    end: bag.end,
  };
}
