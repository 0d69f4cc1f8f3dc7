// A pupil's page follows the class: scenes that everybody is shown, the teacher's clock and drawer,
// frozen stages, releases; the pupil's own pendulum waits meanwhile, and comes back.
// Leaves to others: how it looks (pupil_panel.js), what is sent to the room (sender.js).
// Invariant: what the teacher has said last holds; what is shown twice is shown once.

import { DRAWERS } from "../state.js";
import { bareScene, hanging, keyOf, stageScene, turned, wholeScene } from "./scenes.js";
import { createSender } from "./sender.js";

/**
 * What the class is to see; by: "push", "follow" (as the teacher's page goes on), "hand" (the
 * start is to be made by hand) or "spread".
 * @typedef {{scene: ClassScene, by: string, key: string, number: number, offset: number}} Target
 */

/**
 * @typedef {{
 *   room: Room, sender: import("./sender.js").Sender, frozen: boolean, follows: boolean, told:
 *   Record<string, string>,
 *   target: Target | null, queue: Promise<unknown>, listeners: Set<() => unknown>,
 * }} Pupil
 */

/** @param {Room} room @returns {Target | null} */
function targetOf({ session }) {
  /** @type {ClassStage} */
  const { scene, release, follow } = session.value("stages/class") ?? {};
  if (!scene) return null;
  const number = release?.number ?? 0;
  const together = release?.spread === undefined ? "hand" : "spread";
  const by = follow ? "follow" : release ? together : "push";
  const { pupil = 1 } = session.entry ?? {};
  const most = Math.max(session.pupils, pupil, 2);
  const offset = ((release?.spread ?? 0) * (pupil - 1)) / (most - 1);
  return { scene, by, number, offset, key: `${keyOf(scene)}.${number}` };
}

/** The scene as this pupil gets it. @param {Target} target */
function sceneFor({ scene, by, offset }) {
  if (by === "hand") return hanging(scene);
  return offset ? turned(scene, offset) : scene;
}

/** Does what a frozen stage forbids. @param {Pupil} pupil @param {() => Promise<unknown>} what */
async function past({ room: { app } }, what) {
  app.store.refuse(null);
  await what();
}

/**
 * Stages what the class is to see; the pupil's own waits.
 * @param {Pupil} pupil @param {Target} target
 */
async function stageTarget(pupil, target) {
  const { app, session, say, tell } = pupil.room;
  const { by, key, number } = target;
  const { seen = "", mine } = session.entry ?? {};
  session.note({ seen: key, mine: seen ? mine : wholeScene(app.store.get()) });
  app.edits.cancel();
  await past(pupil, () => stageScene(app, sceneFor(target), by !== "hand" && by !== "follow"));
  if (by === "spread") pupil.sender.mark(number);
  else if (by === "hand") open(pupil);
  if (by !== "follow") tell(say(`class.told.${by}`));
}

/** Whether another scene was staged. @param {Pupil} pupil */
async function followScene(pupil) {
  const { app, session, say, tell } = pupil.room;
  const target = targetOf(pupil.room);
  const { seen = "", mine } = session.entry ?? {};
  pupil.target = target;
  // after a reload the stage has the pupil's own, which the room knows, not the teacher's
  const again = target?.by === "follow" && pupil.told.clock === undefined;
  if ((target?.key ?? "") === seen && !again) return false;
  if (target) await stageTarget(pupil, target);
  else {
    session.note({ seen: "", mine: undefined });
    if (mine) await past(pupil, () => stageScene(app, mine));
    tell(say("class.told.own"));
  }
  return true;
}

/** What cannot be changed while the stage is frozen. */
const HELD =
  "#stage, #timebar, [data-drawer]:not([data-drawer=class]):not([data-drawer=worksheet])";

/**
 * Nothing on the stage can be changed, and why; "" ends that.
 * @param {Room} room @param {string} why
 */
function hold({ app, tell, say }, why) {
  /** @type {NodeListOf<HTMLElement>} */
  const parts = document.querySelectorAll(HELD);
  for (const part of parts) part.inert = why !== "";
  app.store.refuse(why ? () => tell(say(why)) : null);
}

/** @param {Pupil} pupil */
function followFrozen(pupil) {
  const { tell, say, session, app } = pupil.room;
  const frozen = session.value("stages/class")?.frozen === true;
  if (frozen !== pupil.frozen) tell(say(frozen ? "class.told.frozen" : "class.told.free"));
  if (pupil.frozen && !frozen) app.clock.play();
  pupil.frozen = frozen;
  const follows = pupil.target?.by === "follow" ? "class.told.follow" : "";
  hold(pupil.room, frozen ? "class.told.stillFrozen" : follows);
  if (frozen) app.clock.pause();
}

/**
 * Begins to follow the teacher's page, or ends it.
 * @param {Pupil} pupil @param {boolean} follows
 */
function turnFollowing(pupil, follows) {
  if (follows === pupil.follows) return;
  pupil.follows = follows;
  pupil.sender.rest(follows);
  if (follows) pupil.room.tell(pupil.room.say("class.told.follow"));
}

/** The teacher's time by now, s. @param {Room} room @param {ClassItem} item */
function timeOf({ app, session }, { changed, value }) {
  const { time = 0, playing } = value.follow;
  const { view, span } = app.store.get();
  const passed = playing ? Math.max(0, session.now() - Date.parse(changed)) / 1000 : 0;
  const there = time + passed * view.speed;
  return view.loop ? there % span.stop : Math.min(there, span.stop);
}

/**
 * The drawer that the teacher has opened, or "none".
 * @param {Pupil} pupil @param {string} [drawer]
 */
function followDrawer({ room: { app }, told }, drawer = "") {
  if (drawer && drawer !== told.drawer)
    app.store.set({ view: { drawer: DRAWERS.includes(drawer) ? drawer : null } });
  told.drawer = drawer;
}

/**
 * The teacher's clock and drawer, while the class follows them.
 * @param {Pupil} pupil @param {boolean} staged whether another motion is on its way
 */
function followClock(pupil, staged) {
  const { room, told } = pupil;
  const { clock } = room.app;
  const item = room.session.items.get("stages/class");
  const follow = pupil.target?.by === "follow" ? item?.value.follow : null;
  turnFollowing(pupil, Boolean(follow));
  const key = follow && !pupil.frozen ? String(item?.version) : "";
  const same = key === told.clock;
  told.clock = key;
  if (!item || !key || same) return;
  followDrawer(pupil, follow.drawer);
  const time = timeOf(room, item);
  if (staged || !clock.complete) clock.restart(time);
  else clock.seek(time);
  if (follow.playing) clock.play();
  else clock.pause();
}

/** Opens the drawer of the class: there is something to do. @param {Pupil} pupil */
function open({ room: { app } }) {
  app.store.set({ view: { drawer: "class" } });
}

/** What the class is asked, given and told. @param {Pupil} pupil */
function followRest(pupil) {
  const { tell, say, session } = pupil.room;
  /** @type {ClassStage} */
  const stage = session.value("stages/class") ?? {};
  const { told } = pupil;
  const question = stage.question && session.value(`questions/${stage.question}`);
  const sheet = stage.worksheet && session.value(`worksheets/${stage.worksheet}`);
  const now = {
    text: stage.text ?? "",
    question: question ? `${stage.question}` : "",
    worksheet: sheet ? `${stage.worksheet}` : "",
  };
  const words = { text: now.text, question: question?.text ?? "", worksheet: sheet?.title ?? "" };
  for (const [kind, value] of Object.entries(now)) {
    if (value === told[kind]) continue;
    told[kind] = value;
    if (!value) continue;
    tell(say(`class.told.${kind}`, { words: words[/** @type {"text"} */ (kind)] }));
    open(pupil);
  }
}

/** @param {Pupil} pupil */
async function follow(pupil) {
  if (pupil.room.session.state === "gone") return;
  const staged = await followScene(pupil);
  followFrozen(pupil);
  followClock(pupil, staged);
  followRest(pupil);
  pupil.listeners.forEach((listener) => listener());
}

/** The stage as it was before a reload. @param {Room} room */
async function restore({ app, session }) {
  const own = session.value(`stages/${session.entry?.pupil}`);
  if (own?.scene && location.hash.length <= 1) await stageScene(app, own.scene);
}

/** Follows the class until end(). @param {Room} room @param {boolean} back from a reload */
export async function followClass(room, back) {
  if (back) await restore(room);
  /** @type {Pupil} */
  const pupil = {
    room,
    sender: createSender(room),
    frozen: false,
    follows: false,
    told: {},
    target: null,
    queue: Promise.resolve(),
    listeners: new Set(),
  };
  const soon = () => {
    pupil.queue = pupil.queue.then(() => follow(pupil)).catch(() => {});
  };
  const ends = [room.session.subscribe(soon), () => hold(room, ""), pupil.sender.end];
  soon();
  return {
    sender: pupil.sender,
    get frozen() {
      return pupil.frozen;
    },
    get target() {
      return pupil.target;
    },
    /** The start that was made by hand is let go. */
    release() {
      const { app, session, tell, say } = room;
      if (!pupil.target) return;
      pupil.sender.mark(pupil.target.number);
      session.note({ released: pupil.target.number });
      app.clock.restart();
      app.clock.play();
      tell(say("class.told.letGo"));
    },
    get start() {
      return bareScene(room.app.store.get());
    },
    /** @param {() => unknown} fn after the class has been followed */
    subscribe(fn) {
      pupil.listeners.add(fn);
      return () => pupil.listeners.delete(fn);
    },
    end: () => ends.forEach((end) => end()),
  };
}

/** @typedef {Awaited<ReturnType<typeof followClass>>} Follower */
