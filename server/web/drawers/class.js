// The drawer of a class: the way into a room, and what one does there, as a pupil or as the
// teacher, whose part is loaded only for teachers.
// Leaves to others: the room (class/session.js), its parts (class/).
// Invariant: one room at a time; it goes on while other drawers are open and languages change.

import { awayLine } from "../class/away.js";
import { createBanner } from "../class/banner.js";
import { mountChip } from "../class/chip.js";
import { mountJoin, openJoinCard } from "../class/join.js";
import { createSession } from "../class/session.js";
import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { codeInAddress, leadInAddress } from "../room.js";
import { isStatic } from "../root.js";
import { serverless } from "./kit/kit.js";

/** @typedef {import("../class/pupil.js").Follower} Follower */

/**
 * What lives as long as the page: the room, and a pupil who follows the class in it.
 * @typedef {{
 *   room: Room, follower: Follower | null, coming: Promise<unknown> | null, back: boolean,
 *   listeners: Set<() => unknown>, mountPupil: any,
 * }} Life
 */

/** @type {Life | null} */
let life = null;

/**
 * What pupils do is loaded, and begins. @param {Life} one @param {boolean}
 * back
 */
async function learn(one, back) {
  const { room } = one;
  const { default: part } = await room.app.files.script("class/learn.js");
  one.mountPupil = part.mountPupil;
  one.follower = await part.followClass(room, back);
  one.listeners.forEach((listener) => listener());
}

/** A pupil's page follows the class while there is a room. @param {Life} one */
function look(one) {
  const { session } = one.room;
  const here = session.state === "live" || session.state === "away";
  if (here && session.entry?.role === "pupil" && !one.coming) {
    const { back } = one;
    one.coming = learn(one, back).catch((error) => {
      one.coming = null;
      one.room.app.complain(said(error, one.room.app.text));
    });
  } else if (!here && session.state !== "coming" && one.coming) {
    one.coming.then(() => {
      one.follower?.end();
      one.follower = null;
      one.coming = null;
    });
  }
}

/** @param {App} app */
function lifeOf(app) {
  if (life) return life;
  app.files.style("class/class.css").catch(() => {});
  const session = createSession(app.client);
  /** @type {Room} */
  const room = { app, session, say: app.text, tell: () => {} };
  const banner = createBanner(room);
  room.tell = (words) => {
    app.announce(words);
    if (session.entry?.role === "pupil") banner.show(words);
  };
  /** @type {Life} */
  const one = {
    room,
    follower: null,
    coming: null,
    back: false,
    listeners: new Set(),
    mountPupil: null,
  };
  life = one;
  session.subscribe((names) => names ?? look(one));
  mountChip(room);
  return one;
}

/**
 * Leads the room of a teacher's link; the token leaves the address, which the class may see.
 * @param {Life} one @param {string} token
 */
async function lead({ room: { session, app } }, token) {
  const code = codeInAddress() ?? "";
  history.replaceState(history.state, "", location.pathname + location.search);
  const known = await session.lead(code, token);
  if (!known) app.complain(app.text("class.lead.none", { code }));
  app.store.set({ view: { drawer: "class" } });
}

/** Comes back to the room that the address names, or the last one; else asks for a nickname. */
export async function resume(/** @type {App} */ app) {
  await app.text.part("class");
  const one = lifeOf(app);
  const token = leadInAddress();
  if (token) return lead(one, token);
  one.back = true;
  const found = await one.room.session.resume(codeInAddress());
  one.back = false;
  if (found && one.room.session.entry?.role === "pupil") await one.coming;
  if (!found && codeInAddress()) openJoinCard(one.room);
  else app.store.set({ view: { drawer: "class" } });
}

/** Which of its faces the drawer has now. @param {Life} one */
function faceOf({ room: { session }, follower }) {
  const { state, entry } = session;
  if (state === "none" || state === "gone" || !entry) return `join ${state}`;
  if (state === "coming") return "coming";
  if (entry.role === "teacher") return `teacher ${entry.code}`;
  return follower ? `pupil ${entry.code}` : "coming";
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  if (isStatic) {
    element.append(h("h2", {}, app.text("drawer.class")), serverless(app.text));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  }
  const one = lifeOf(app);
  const { room } = one;
  const bag = createBag();
  const body = h("div", { class: "class-body" });
  element.append(h("h2", {}, app.text("drawer.class")), body);
  let face = "";
  /** @type {{destroy: End} | null} */
  let part = null;

  /** @param {string} wanted */
  async function partOf(wanted) {
    if (wanted.startsWith("join")) return mountJoin(body, room);
    if (wanted.startsWith("pupil") && one.follower) return one.mountPupil(body, room, one.follower);
    if (wanted.startsWith("teacher")) {
      const { default: mountTeacher } = await app.files.script("class/teach.js");
      return face === wanted ? mountTeacher(body, room) : null;
    }
    const away = awayLine(app);
    const coming = h("p", { class: "quiet", role: "status" }, room.say("class.state.coming"));
    body.replaceChildren(coming, away.place);
    return { destroy: away.end };
  }
  async function show() {
    const wanted = faceOf(one);
    if (wanted === face) return;
    face = wanted;
    part?.destroy();
    part = null;
    body.replaceChildren();
    const made = await partOf(wanted);
    if (face === wanted) part = made;
    else made?.destroy();
  }
  bag(room.session.subscribe((names) => names ?? show()));
  one.listeners.add(show);
  bag(() => one.listeners.delete(show));
  show();
  return {
    show() {},
    hide() {},
    destroy() {
      bag.end();
      part?.destroy();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "class", title: (text) => text("drawer.class"), mount };
