// Follow me: the class has the stage, the clock and the drawer of the teacher's device that
// presents.
// Leaves to others: the pupils' side (pupil.js), the stage of the class (teach.js).
// Invariant: one device presents, the one whose teacher has said so last; what is written is what
// has changed, and PAUSE_MS apart.

import { createBag } from "../dom.js";
import { keyOf, wholeScene } from "./scenes.js";

const PAUSE_MS = 400; // the server takes 5 writes a second of a client, for long
const JUMP = 0.15; // s by which the clock leaves its course
const OWN = ["class", "worksheet"]; // drawers that are the teacher's alone

/**
 * The presenter while the panel is there; sent: what was written last, and the course of the clock
 * since then.
 * @typedef {{
 *   room: Room, desk: import("./teach.js").Desk, key: string, time: number, at: number,
 *   timer: number,
 * }} Presenter
 */

/** @param {Room} room */
const presents = ({ session }) =>
  Boolean(session.entry?.presents && session.value("stages/class")?.follow);

/** What the class is to have, but for the clock's time. @param {App} app */
function stateOf({ store, clock }) {
  const doc = store.get();
  const { drawer } = doc.view;
  const own = drawer !== null && OWN.includes(drawer);
  const follow = { ...(!own && { drawer: drawer ?? "none" }), playing: clock.playing };
  return { scene: wholeScene(doc), follow };
}

/** Whether the clock runs as it did when it was written last. @param {Presenter} presenter */
function onCourse({ room: { app }, time, at }) {
  const { clock } = app;
  const passed = clock.playing ? ((performance.now() - at) / 1000) * clock.speed : 0;
  const there = time + passed;
  const far = Math.abs(
    (clock.loop && clock.duration ? there % clock.duration : there) - clock.time,
  );
  return Math.min(far, Math.abs(clock.duration - far)) < JUMP * Math.max(1, clock.speed);
}

/** @param {Presenter} presenter */
async function send(presenter) {
  presenter.timer = 0;
  const { room, desk } = presenter;
  if (!presents(room)) return;
  const { clock } = room.app;
  const { scene, follow } = stateOf(room.app);
  presenter.key = keyOf([scene, follow]);
  [presenter.time, presenter.at] = [clock.time, performance.now()];
  await desk.change({ scene, follow: { ...follow, time: clock.time }, release: undefined });
}

/** @param {Presenter} presenter */
function look(presenter) {
  const { room } = presenter;
  const { entry } = room.session;
  // another device has ended it
  if (entry?.presents && !room.session.value("stages/class")?.follow)
    room.session.note({ presents: false });
  if (presenter.timer || !presents(room)) return;
  if (room.app.clock.framing ? onCourse(presenter) : isSent(presenter)) return;
  const wait = Math.max(0, presenter.at + PAUSE_MS - performance.now());
  presenter.timer = window.setTimeout(() => send(presenter), wait);
}

/** Whether the class has all of it. @param {Presenter} presenter */
function isSent(presenter) {
  const { scene, follow } = stateOf(presenter.room.app);
  return keyOf([scene, follow]) === presenter.key && onCourse(presenter);
}

/** @param {Room} room @param {import("./teach.js").Desk} desk */
export function createPresenter(room, desk) {
  const { app, session } = room;
  const bag = createBag();
  /** @type {Presenter} */
  const presenter = { room, desk, key: "", time: 0, at: -PAUSE_MS, timer: 0 };
  const soon = () => look(presenter);
  bag(app.store.subscribe(soon));
  bag(app.clock.subscribe(soon));
  bag(app.motion.subscribe((_, what) => what === "complete" && soon()));
  bag(session.subscribe(soon));
  bag(() => clearTimeout(presenter.timer));
  soon();
  return {
    /** Begins to present from this device, or ends it for the class. @param {boolean} on */
    async turn(on) {
      if (!on) return desk.change({ follow: undefined });
      await desk.change({ follow: { playing: false }, frozen: false });
      session.note({ presents: true });
      presenter.key = "";
      await send(presenter);
    },
    end: bag.end,
  };
}
