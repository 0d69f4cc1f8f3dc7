// The wall of a class: each pupil's pendulum, live and small, who needs help, who is done.
// Leaves to others: where it hangs (board.js), drawing a tree (drawers/kit/mini.js).
// Invariant: what a pupil's browser sent is drawn only where it is a tree; only what can be seen is
// drawn and asked for; the motions are the server's.

import { createBag, h } from "../dom.js";
import { aborted, fetchTable } from "../drawers/kit/kit.js";
import { createMini } from "../drawers/kit/mini.js";
import { readScene } from "../link.js";
import { still } from "../screen.js";
import { nameOf } from "./answers_table.js";
import { createSigns } from "./signs.js";

const FRAME_MS = 45;
const SPAN = { start: 0, stop: 10, step: 0.04 };
const AT_ONCE = 2; // motions that are asked for
const MOST_ARMS = 64;
const QUIET_MS = 180000; // without a change, from which on that is told
const LOOK_MS = 5000; // from one look for who is silent to the next
const SAME_MS = 5000; // a change that two signs put so far apart is one
const TILE = { width: 132, height: 112, top: 0.42 }; // pixels of a picture, where its pivot is
const LARGEST = 640; // pixels across
const BESIDE = { width: 18, height: 66 }; // pixels of a tile beside its picture, with the gap
const RANK = { stuck: 0, silent: 1, working: 2, done: 3, away: 4 };

/** @typedef {{tree: Tree, phi: number[]}} Pose */

/**
 * A pupil on the wall; motion: rows of angles, once they are here.
 * @typedef {{
 *   number: number, element: HTMLElement, button: HTMLElement, canvas: HTMLElement | null, name:
 *   HTMLElement,
 *   note: HTMLElement, pose: Pose | null, key: string, scene: ClassScene | null,
 *   mini: import("../drawers/kit/mini.js").Mini | null, motion: Float64Array | null,
 *   wants: boolean,
 *   seen: boolean, state: string, nickname: string, changed: number, silence: number,
 * }} Cell
 */

/**
 * @typedef {{
 *   room: Room, list: HTMLElement, cells: Map<number, Cell>, sight: IntersectionObserver, sort:
 *   string, loading: number, stop: AbortController, begun: number, frame: number, drawn: number,
 *   open: (number: number) => unknown, size: {width: number, height: number, top: number},
 *   signs: ReturnType<typeof createSigns>, told: () => unknown,
 *   place: (() => {width: number, height: number}) | null,
 * }} Wall
 */

/**
 * What can be drawn of a scene; null where it is not sound, whoever has sent it.
 * @param {App} app @param {ClassScene | null | undefined} scene @returns {Promise<Pose | null>}
 */
export async function poseOf({ client }, scene) {
  if (!scene) return null;
  try {
    const { pendulum, initial } = await readScene(scene, client);
    if (!pendulum || !initial || pendulum.length.length > MOST_ARMS) return null;
    return { tree: pendulum, phi: initial.phi };
  } catch {
    return null;
  }
}

/**
 * The angles of a motion, row by row. @param {Client} client @param {ClassScene} scene @param
 * {object} times @param {AbortSignal} signal
 */
export async function anglesOver(client, scene, times, signal) {
  const body = { ...scene.request, times, output: ["phi"] };
  const { columns } = await fetchTable(client, "/v1/trajectories", body, { signal });
  return columns.phi;
}

/** @param {Wall} wall */
async function loadNext(wall) {
  const { room, cells, stop } = wall;
  const cell = [...cells.values()].find(({ wants, seen }) => wants && seen);
  if (!cell?.scene || wall.loading >= AT_ONCE || still.matches) return;
  cell.wants = false;
  wall.loading++;
  const { key, scene } = cell;
  try {
    const motion = await anglesOver(room.app.client, scene, SPAN, stop.signal);
    if (cell.key === key) cell.motion = motion;
  } catch (error) {
    // a pupil's pendulum that the server refuses is shown as it starts
    if (!aborted(error) && !(/** @type {Failed} */ (error).kind)) throw error;
  }
  wall.loading--;
  if (!stop.signal.aborted) loadNext(wall);
}

/** @param {Wall} wall @param {Cell} cell */
function drawCell(wall, cell) {
  const { pose, motion, mini } = cell;
  if (!pose || !mini) return;
  const n = pose.phi.length;
  if (!motion) return mini.draw(pose.phi);
  const rows = motion.length / n;
  const row = Math.floor((performance.now() - wall.begun) / 1000 / SPAN.step) % rows;
  mini.draw(motion.subarray(row * n, (row + 1) * n));
}

/** @param {Wall} wall */
function turn(wall) {
  wall.frame = requestAnimationFrame(() => turn(wall));
  if (performance.now() - wall.drawn < FRAME_MS || !wall.list.isConnected) return;
  wall.drawn = performance.now();
  for (const cell of wall.cells.values()) if (cell.seen && cell.motion) drawCell(wall, cell);
}

/**
 * How far a pupil is with what the class is asked or given.
 * @param {Room} room @param {number} number
 */
function workOf({ session, say }, number) {
  const { question, worksheet } = session.value("stages/class") ?? {};
  if (question)
    return session.value(`answers/${question}/${number}`) ? say("class.is.answered") : "";
  /** @type {Sheet | null} */
  const sheet = worksheet ? session.value(`worksheets/${worksheet}`) : null;
  const count = sheet?.steps.filter((step) => step.question).length;
  if (!count) return "";
  const { done = false, answers = [] } = session.value(`handins/${worksheet}/${number}`) ?? {};
  return done ? say("sheet.in") : say("class.is.at", { done: answers.length, count });
}

/** What is told below a pupil's name. @param {Wall} wall @param {Cell} cell */
function noteOf({ room }, { number, state, changed, scene, silence }) {
  const { say } = room;
  const quiet = Date.now() - changed;
  if (state === "silent")
    return say("class.is.silent", { minutes: Math.max(1, Math.floor(silence / 60000)) });
  if (state !== "working") return say(`class.is.${state}`);
  if (!scene) return say("class.is.coming");
  const work = workOf(room, number);
  if (work) return work;
  return quiet > QUIET_MS ? say("class.is.quiet", { minutes: Math.floor(quiet / 60000) }) : "";
}

/** @param {Wall} wall @param {Cell} cell @param {ClassScene | null} scene */
async function restage(wall, cell, scene) {
  const key = JSON.stringify(scene);
  if (key === cell.key) return;
  cell.key = key;
  cell.scene = scene;
  cell.motion = null;
  const pose = await poseOf(wall.room.app, scene);
  if (cell.key !== key) return;
  const same = JSON.stringify(pose?.tree) === JSON.stringify(cell.pose?.tree);
  cell.pose = pose;
  cell.wants = pose !== null;
  if (!same || !cell.mini) frame(wall, cell);
  drawCell(wall, cell);
  loadNext(wall);
}

/** A new picture of a cell's tree. @param {Wall} wall @param {Cell} cell */
function frame({ size }, cell) {
  cell.mini = cell.pose && createMini(cell.pose.tree, size);
  const canvas = cell.mini?.canvas ?? h("span", { class: "no-picture" }, "?");
  cell.canvas?.replaceWith(canvas);
  cell.canvas = canvas;
}

/**
 * The widest pictures with which so many tiles fill a place. @param {number} count
 * @param {{width: number, height: number}} place
 */
function widthFor(count, place) {
  const wide = (/** @type {number} */ columns) => {
    const tall = place.height / Math.ceil(count / columns) - BESIDE.height;
    const across = place.width / columns - BESIDE.width;
    return Math.min(across, (tall * TILE.width) / TILE.height, LARGEST);
  };
  const widths = Array.from({ length: count }, (_, i) => wide(i + 1));
  return Math.floor(Math.max(TILE.width, ...widths));
}

/** Pictures as large as there is place for all. @param {Wall} wall */
function resize(wall) {
  const { cells, place, list } = wall;
  const width = place ? widthFor(cells.size, place()) : TILE.width;
  if (width === wall.size.width) return;
  wall.size = { ...TILE, width, height: Math.round((width * TILE.height) / TILE.width) };
  list.style.setProperty("--tile", `${width}px`);
  for (const cell of cells.values()) {
    if (!cell.pose) continue;
    frame(wall, cell);
    drawCell(wall, cell);
  }
}

/** @param {Wall} wall @param {number} number @returns {Cell} */
function cellOf(wall, number) {
  const known = wall.cells.get(number);
  if (known) return known;
  const canvas = h("span", { class: "no-picture" }, "\u2026");
  const name = h("span", { class: "cell-name" });
  const note = h("span", { class: "cell-note" });
  const click = () => wall.open(number);
  const button = h(
    "button",
    { type: "button", class: "cell", "data-pupil": number, on: { click } },
    canvas,
    name,
    note,
  );
  const element = h("li", {}, button);
  /** @type {Cell} */
  const cell = {
    number,
    element,
    button,
    canvas,
    name,
    note,
    pose: null,
    key: "",
    scene: null,
    mini: null,
    motion: null,
    wants: false,
    seen: false,
    state: "working",
    nickname: "",
    changed: 0,
    silence: 0,
  };
  wall.cells.set(number, cell);
  wall.sight.observe(button);
  return cell;
}

/** @param {Wall} wall */
function sorted({ cells, sort }) {
  const byName = (/** @type {Cell} */ a, /** @type {Cell} */ b) =>
    a.nickname.localeCompare(b.nickname, undefined, { numeric: true }) || a.number - b.number;
  const rank = (/** @type {Cell} */ { state }) => RANK[/** @type {"done"} */ (state)] ?? 2;
  const orders = {
    name: byName,
    state: (/** @type {Cell} */ a, /** @type {Cell} */ b) => rank(a) - rank(b) || byName(a, b),
    came: (/** @type {Cell} */ a, /** @type {Cell} */ b) => a.number - b.number,
    changed: (/** @type {Cell} */ a, /** @type {Cell} */ b) => b.changed - a.changed,
  };
  return [...cells.values()].sort(orders[/** @type {"name"} */ (sort)]);
}

/** Puts the cells in order, moving as few as are out of it. @param {Wall} wall */
function arrange(wall) {
  let place = wall.list.firstElementChild;
  for (const { element } of sorted(wall)) {
    if (element === place) place = place.nextElementSibling;
    else wall.list.insertBefore(element, place);
  }
}

/**
 * How a pupil gets on, and since when; who is done may sleep.
 * @param {Wall} wall @param {Cell} cell @param {ClassItem | undefined} stage
 */
function judge({ signs }, cell, stage) {
  const told = stage?.value.state ?? "working";
  const changed = stage ? signs.changed(stage) : Date.now();
  cell.silence = stage ? signs.silence(stage) : 0;
  cell.state = cell.silence && told !== "done" ? "silent" : told;
  if (Math.abs(changed - cell.changed) > SAME_MS) cell.changed = changed;
  if (cell.button.dataset.state !== cell.state) cell.button.dataset.state = cell.state;
}

/** Time has passed, and nothing else. @param {Wall} wall */
function look(wall) {
  const { items } = wall.room.session;
  for (const cell of wall.cells.values()) {
    judge(wall, cell, items.get(`stages/${cell.number}`));
    const note = noteOf(wall, cell);
    if (cell.note.textContent !== note) cell.note.textContent = note;
  }
  if (wall.sort === "state") arrange(wall);
  wall.told();
}

/** @param {Wall} wall @param {Cell} cell */
function christen({ room }, cell) {
  cell.nickname = nameOf(room, cell.number);
  if (cell.name.textContent !== cell.nickname) cell.name.textContent = cell.nickname;
}

/** @param {Wall} wall */
function follow(wall) {
  const { items } = wall.room.session;
  wall.signs.hear();
  /** @type {Set<number>} */
  const there = new Set();
  for (const name of items.keys()) {
    const [kind, id] = name.split("/");
    if (kind !== "pupils") continue;
    const number = Number(id);
    const stage = items.get(`stages/${id}`);
    const cell = cellOf(wall, number);
    there.add(number);
    christen(wall, cell);
    judge(wall, cell, stage);
    restage(wall, cell, stage?.value.scene ?? null);
    cell.note.textContent = noteOf(wall, cell);
  }
  for (const [number, { element }] of wall.cells) {
    if (there.has(number)) continue;
    element.remove();
    wall.cells.delete(number);
  }
  arrange(wall);
  resize(wall);
  loadNext(wall);
}

/**
 * @param {Room} room @param {(number: number) => unknown} open @param {() => unknown} told when
 * somebody's state may be another, because time has passed
 */
export function createWall(room, open, told) {
  const bag = createBag();
  const list = h("ul", { class: "wall", "aria-label": room.say("class.board") });
  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const cell = wall.cells.get(Number(/** @type {HTMLElement} */ (target).dataset.pupil));
      if (cell) cell.seen = isIntersecting;
      if (cell && isIntersecting) drawCell(wall, cell);
    }
    for (let i = 0; i < AT_ONCE; i++) loadNext(wall);
  });
  /** @type {Wall} */
  const wall = {
    room,
    list,
    cells: new Map(),
    sight,
    sort: "name",
    loading: 0,
    stop: new AbortController(),
    begun: performance.now(),
    frame: 0,
    drawn: 0,
    open,
    signs: createSigns(room.session),
    told,
    size: TILE,
    place: null,
  };
  const recolour = () => {
    for (const cell of wall.cells.values()) {
      cell.mini?.recolour();
      drawCell(wall, cell);
    }
  };
  bag(
    room.session.subscribe(
      (names) =>
        (!names || [...names].some((name) => /^(pupils|stages|answers|handins)\//.test(name))) &&
        follow(wall),
    ),
  );
  bag(room.app.theme.subscribe(recolour));
  const timer = setInterval(() => look(wall), LOOK_MS);
  bag(() => clearInterval(timer));
  bag(() => sight.disconnect());
  bag(() => wall.stop.abort());
  bag(() => cancelAnimationFrame(wall.frame));
  follow(wall);
  turn(wall);
  return { list, cells: wall.cells, ...verbs(wall), end: bag.end };
}

/** @param {Wall} wall */
function verbs(wall) {
  return {
    /** @param {string} by */
    sort(by) {
      wall.sort = by;
      arrange(wall);
    },
    /** Fills a place; null: as in the drawer. @param {Wall["place"]} place */
    fill(place) {
      wall.place = place;
      resize(wall);
    },
    /** Names have come, or have gone. */
    rename() {
      for (const cell of wall.cells.values()) christen(wall, cell);
      arrange(wall);
    },
  };
}
