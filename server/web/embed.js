// The embed view's talk with the page that has it in a frame: the state is told and set by
// postMessage; a link leads to the whole page.
// A worksheet that the address names stands beside the stage; what is answered there is told as
// xAPI statements.
// Leaves to others: who may have it in a frame (the server's --frame-ancestors), scenes (link.js).
// Invariant: what is set is checked as a link is; nothing but what is on the stage is told.

import { linkOf, readScene, sceneOf } from "./link.js";
import { h, icon } from "./dom.js";
import { titleOf } from "./header.js";
import { statementsOf } from "./class/statements.js";
import { said } from "./client.js";
import { fresh } from "./keep.js";
import { namesSheet, sheetInAddress } from "./room.js";
import { ROOT } from "./root.js";

const PAUSE_MS = 200;

/** What is told: the scene and where the clock stands. @param {App} app */
function stateOf({ store, clock }) {
  const doc = store.get();
  const scene = sceneOf({ ...doc, view: { ...doc.view, drawer: null } });
  return { pendulumd: "state", scene, time: clock.time, playing: clock.playing };
}

/** @param {App} app @param {any} message */
async function set({ store, clock, client }, { scene, time, playing }) {
  if (scene) {
    const patch = await readScene(scene, client);
    store.set({ ...patch, view: { ...patch.view, drawer: null } }, { label: "open" });
    clock.restart(Number.isFinite(time) ? Math.max(0, time) : 0);
  } else if (Number.isFinite(time)) clock.seek(time);
  if (playing === true) clock.play();
  if (playing === false) clock.pause();
}

/** The height in which nothing has to be scrolled, at the width that the frame has, pixels. */
function sizeOf() {
  const width = document.documentElement.clientWidth;
  // the bar is a little higher in a higher frame
  const bar = (document.getElementById("timebar")?.offsetHeight ?? 0) + 8;
  const sheet = document.getElementById("embed-sheet");
  const stage = Math.round(Math.min((2 * width) / 3, 420));
  if (!sheet) return { pendulumd: "size", width, height: stage + bar };
  const beside = sheet.offsetTop < bar + 1;
  const height = beside ? Math.max(stage, sheet.scrollHeight) : stage + sheet.scrollHeight;
  return { pendulumd: "size", width, height: height + bar };
}

/** @param {App} app @param {MessageEvent} event */
async function heard(app, { data, source, origin }) {
  const from = /** @type {Window | null} */ (source);
  if (from !== window.parent || typeof data?.pendulumd !== "string") return;
  // a page of a file has no origin to be answered at
  const at = { targetOrigin: origin === "null" ? "*" : origin };
  if (data.pendulumd === "get") from.postMessage(stateOf(app), at);
  if (data.pendulumd === "size") from.postMessage(sizeOf(), at);
  if (data.pendulumd !== "set") return;
  try {
    await set(app, data);
    from.postMessage(stateOf(app), at);
  } catch {
    from.postMessage({ pendulumd: "refused" }, at);
  }
}

/** What was answered, to the page around. @param {string} name a number of this visit */
function tellAnswers(name, /** @type {any} */ { id, sheet, before, given }) {
  const home = `${ROOT}worksheets/${sheetInAddress() ?? id}`;
  const actor = { homePage: ROOT, name };
  const about = { actor, home, sheet, when: new Date().toISOString() };
  for (const statement of statementsOf(about, given, before))
    window.parent.postMessage({ pendulumd: "statement", statement }, "*");
}

/** The worksheet beside the stage. @param {App} app */
async function mountSheet(app) {
  const place = h("section", { id: "embed-sheet", "data-drawer": "worksheet" });
  document.documentElement.dataset.embed = "sheet";
  document.getElementById("main")?.append(place);
  const name = fresh();
  place.addEventListener("pendulumd-handin", (event) =>
    tellAnswers(name, /** @type {CustomEvent} */ (event).detail),
  );
  try {
    const [{ default: part }] = await Promise.all([
      app.files.script("drawers/worksheet.js"),
      app.files.style("class/class.css"),
      ...["drawers", "class"].map((words) => app.text.part(words)),
    ]);
    await part.mount(place, app);
  } catch (error) {
    place.replaceChildren(h("p", { class: "fault", role: "alert" }, said(error, app.text)));
  }
}

/** @param {App} app */
export default function beginEmbed(app) {
  const { store, text, clock } = app;
  const words = text("embed.open");
  const attributes = { class: "embed-link", target: "_blank", rel: "noopener", title: words };
  const link = h("a", attributes, icon("arrows"), h("span", {}, words));
  const heading = h("h1", { class: "unseen" });
  document.getElementById("stage")?.append(heading, link);
  const tell = () => window.parent.postMessage(stateOf(app), "*");
  let timer = 0;
  let playing = clock.playing;
  async function follow() {
    timer = 0;
    heading.textContent = titleOf(text, store.get()) || text("name");
    link.setAttribute("href", `./${await linkOf(store.get())}`);
    tell();
  }
  const soon = () => {
    timer ||= window.setTimeout(follow, PAUSE_MS);
  };
  store.subscribe(soon);
  clock.subscribe(() => {
    if (clock.playing !== playing) soon();
    ({ playing } = clock);
  });
  window.addEventListener("message", (event) => heard(app, event));
  follow();
  if (namesSheet()) mountSheet(app);
}
