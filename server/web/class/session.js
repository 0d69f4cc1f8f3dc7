// A room as this browser is in it: made, joined, come back to after a reload; its items, which
// events keep up to date, and what this browser writes.
// Leaves to others: what items mean (pupil.js, teach.js), what the server keeps (/v1/classes).
// Invariant: a stream that breaks is asked for again where it was; the token of a room is random,
// of that room alone, and kept by this browser only; a teacher's by this tab only, unless the
// teacher has asked to be remembered.

import { gaveUp } from "../client.js";
import { fresh, keep } from "../keep.js";
import { readEvents } from "./events.js";

const KEPT = "pendulumd.rooms";
const TAB = "pendulumd.rooms.tab";
const MOST_ROOMS = 8;
const PAUSES_MS = [500, 1000, 2000, 4000];
const LONGEST_WAIT = 4; // s: a class does not wait for long once the server is back

/**
 * The session while the page is there; ahead: by how much the server's clock is ahead of this
 * page's, or less, where nothing new came, ms.
 * @typedef {{
 *   client: Client, entry: RoomEntry | null, state: string, items: Map<string, ClassItem>,
 *   pupils: number, seen: number, stop: AbortController | null, ahead: number,
 *   listeners: Set<(names: Set<string> | null) => unknown>,
 * }} Seat
 */

/** What the browser keeps: its rooms, the present one first. @returns {RoomEntry[]} */
export function keptRooms() {
  try {
    // where storage is refused the tab's own history has it: a reload keeps that
    const tab = keep.ofTab(TAB) ?? history.state?.[TAB] ?? "[]";
    const text = keep.get(KEPT) ?? history.state?.[KEPT] ?? "[]";
    const rooms = [...JSON.parse(tab), ...JSON.parse(text)];
    const alive = (/** @type {RoomEntry} */ { code, token, ends }) =>
      typeof code === "string" && typeof token === "string" && Date.parse(ends) > Date.now();
    return rooms.filter(alive);
  } catch {
    return [];
  }
}

/** @param {RoomEntry[]} rooms */
function keepRooms(rooms) {
  /** @param {RoomEntry} room */
  const ofTab = ({ role, remembered }) => role === "teacher" && !remembered;
  const tab = JSON.stringify(rooms.filter(ofTab).slice(0, MOST_ROOMS));
  const text = JSON.stringify(rooms.filter((room) => !ofTab(room)).slice(0, MOST_ROOMS));
  keep.setForTab(TAB, tab);
  keep.set(KEPT, text);
  if (keep.refused) history.replaceState({ ...history.state, [KEPT]: text, [TAB]: tab }, "");
}

/** @param {Seat} seat @param {Set<string> | null} names */
function notify(seat, names) {
  for (const listener of [...seat.listeners]) listener(names);
}

/** @param {Seat} seat @param {string} state */
function become(seat, state) {
  if (seat.state === state) return;
  seat.state = state;
  notify(seat, null);
}

/**
 * @param {Seat} seat @param {RoomEntry} entry @param {string} path @param {RequestInit} options
 * @param {number} [longest] that one waits between two tries, s
 */
function ask({ client }, entry, path, options = {}, longest = undefined) {
  const headers = { ...options.headers, "Class-Token": entry.token };
  return client.ask(`/v1/classes/${entry.code}${path}`, { ...options, headers }, longest);
}

/** @param {string} method @param {object} body @returns {RequestInit} */
const sending = (method, body) => ({
  method,
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body),
});

/** Takes in what has changed. @param {Seat} seat @param {ClassItem[]} items */
function take(seat, items) {
  if (!items.length) return;
  for (const item of items) {
    if (item.value === null) seat.items.delete(item.name);
    else seat.items.set(item.name, item);
    seat.seen = Math.max(seat.seen, item.version);
    const at = Date.parse(item.changed);
    if (at) seat.ahead = Math.max(seat.ahead, at - performance.now());
  }
  notify(seat, new Set(items.map(({ name }) => name)));
}

/** The room as it is, page by page. @param {Seat} seat @param {RoomEntry} entry */
async function load(seat, entry) {
  let told;
  for (let path = ""; ; path = `?${told.next.split("?")[1]}`) {
    told = await (await ask(seat, entry, path)).json();
    seat.pupils = told.pupils;
    take(seat, told.items ?? []);
    if (!told.next) break;
  }
  seat.seen = Math.max(seat.seen, told.version);
}

/** @param {Seat} seat */
function gone(seat) {
  if (seat.entry) keepRooms(keptRooms().filter(({ code }) => code !== seat.entry?.code));
  seat.stop?.abort();
  become(seat, "gone");
}

/**
 * Hears of changes for as long as the room is there. @param {Seat} seat @param {RoomEntry} entry
 */
async function listen(seat, entry, /** @type {AbortSignal} */ signal) {
  for (let tried = 0; !signal.aborted; tried++) {
    const begun = performance.now();
    try {
      const ended = await readEvents({
        open: (stop) =>
          ask(
            seat,
            entry,
            "/events",
            {
              headers: { "Last-Event-ID": String(seat.seen), Accept: "text/event-stream" },
              signal: stop,
            },
            LONGEST_WAIT,
          ),
        live() {
          // what waits to be written need not wait any longer
          if (seat.state === "away") seat.client.hurry();
          become(seat, "live");
        },
        items: (items) => take(seat, items),
        signal,
      });
      if (ended) return gone(seat);
    } catch (error) {
      if (signal.aborted) return;
      if (/** @type {Failed} */ (error).kind === "refused") return gone(seat);
    }
    become(seat, "away");
    if (performance.now() - begun > 10000) tried = 0;
    const pause = PAUSES_MS[Math.min(tried, PAUSES_MS.length - 1)] * (1 + Math.random() / 2);
    await new Promise((resolve) => {
      setTimeout(resolve, pause);
    });
  }
}

/** Begins to be in a room. @param {Seat} seat @param {RoomEntry} entry */
async function enter(seat, entry) {
  seat.stop?.abort();
  seat.stop = new AbortController();
  seat.entry = entry;
  seat.items = new Map();
  seat.seen = 0;
  keepRooms([entry, ...keptRooms().filter(({ code }) => code !== entry.code)]);
  become(seat, "coming");
  await load(seat, entry);
  become(seat, "live");
  listen(seat, entry, seat.stop.signal);
}

/**
 * Leads a room from this device as well, by the token of its teacher's link; true if the room knows
 * it as its teacher's.
 * @param {Seat} seat @param {string} code @param {string} token
 */
async function lead(seat, code, token) {
  const entry = { code, role: "teacher", token, ends: "" };
  const { role, ends } = await (await ask(seat, entry, "")).json();
  if (role === "teacher") await enter(seat, { ...entry, ends });
  return role === "teacher";
}

/** @param {Seat} seat */
function ways(seat) {
  return {
    /**
     * A new room, whose teacher is this tab, or this browser where it is to remember that.
     * @param {number} hours @param {boolean} [remembered]
     */
    async make(hours, remembered = false) {
      const token = fresh();
      const options = sending("POST", { hours });
      const headers = { ...options.headers, "Class-Token": token, "Idempotency-Key": token };
      const made = await seat.client.ask("/v1/classes", { ...options, headers });
      const { code, ends } = await made.json();
      await enter(seat, { code, role: "teacher", token, ends, remembered });
    },
    /** @param {string} typed @param {string} nickname */
    async join(typed, nickname) {
      const code = typed.toUpperCase();
      const before = keptRooms().find((one) => one.code === code && one.role === "pupil");
      const token = before?.token ?? fresh();
      const entry = { ...before, code, role: "pupil", token, nickname, ends: "" };
      const reply = await ask(seat, entry, "/pupils", sending("POST", { nickname }));
      const { pupil, ends } = await reply.json();
      await enter(seat, { ...entry, pupil, ends });
    },
    /**
     * Comes back to a room that the browser has kept; false where there is none.
     * @param {string | null} code null: the last one
     */
    async resume(code) {
      const kept = keptRooms();
      const entry = code ? kept.find((one) => one.code === code.toUpperCase()) : kept[0];
      if (!entry) return false;
      try {
        await enter(seat, entry);
      } catch (error) {
        if (gaveUp(error)) return true;
        if (/** @type {Failed} */ (error).kind !== "refused") throw error;
        gone(seat);
      }
      return true;
    },
    /** @param {string} code @param {string} token of the teacher's link */
    lead: (code, token) => lead(seat, code, token),
    /** Forgets the room in this browser. */
    leave() {
      seat.stop?.abort();
      keepRooms(keptRooms().filter(({ code }) => code !== seat.entry?.code));
      seat.entry = null;
      seat.items = new Map();
      become(seat, "none");
    },
  };
}

/** @param {Seat} seat */
function verbs(seat) {
  const entry = () => {
    if (!seat.entry) throw new Error("in no room");
    return seat.entry;
  };
  return {
    /** @param {Partial<RoomEntry>} patch */
    note(patch) {
      seat.entry = { ...entry(), ...patch };
      keepRooms([seat.entry, ...keptRooms().filter(({ code }) => code !== seat.entry?.code)]);
    },
    /** The server's clock, ms. */
    now: () => (Number.isFinite(seat.ahead) ? performance.now() + seat.ahead : Date.now()),
    /** @param {string} name */
    value: (name) => seat.items.get(name)?.value ?? null,
    /** @param {string} path @param {object} value @param {RequestInit} options */
    async put(path, value, options = {}) {
      const reply = await ask(seat, entry(), `/${path}`, { ...sending("PUT", value), ...options });
      return reply.json();
    },
    /** @param {string} path */
    drop: (path) => ask(seat, entry(), `/${path}`, { method: "DELETE" }),
    async erase() {
      await ask(seat, entry(), "", { method: "DELETE" });
      gone(seat);
    },
    /** @param {(names: Set<string> | null) => unknown} fn */
    subscribe(fn) {
      seat.listeners.add(fn);
      return () => seat.listeners.delete(fn);
    },
  };
}

/** @param {Client} client @returns {Session} */
export function createSession(client) {
  /** @type {Seat} */
  const seat = {
    client,
    entry: null,
    state: "none",
    items: new Map(),
    pupils: 0,
    seen: 0,
    ahead: -Infinity,
    stop: null,
    listeners: new Set(),
  };
  return {
    get entry() {
      return seat.entry;
    },
    get state() {
      return seat.state;
    },
    get items() {
      return seat.items;
    },
    get pupils() {
      return seat.pupils;
    },
    ...ways(seat),
    ...verbs(seat),
  };
}
