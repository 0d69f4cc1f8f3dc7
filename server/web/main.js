// Puts the page together: the document, its motion, the clock, and the views of them.
// Leaves to others: everything else.
// Invariant: views know the app (types.d.ts), never each other; what fails of the page is told, and
// the rest goes on.

import { exampleIn } from "./address.js";
import { watchSleep } from "./asleep.js";
import { createClient, said } from "./client.js";
import { createClock } from "./clock.js";
import { mountDrawers } from "./drawers.js";
import { createEdits } from "./edits.js";
import * as files from "./files.js";
import { documentOf, exampleNamed } from "./gallery.js";
import { mountHeader, titleOf } from "./header.js";
import { beginJournal, beginning, yours } from "./journal.js";
import { bearer, keep } from "./keep.js";
import { choose } from "./language.js";
import { readLink } from "./link.js";
import { createLive } from "./live.js";
import { createMotion } from "./motion.js";
import { createOffline } from "./offline.js";
import { followForces } from "./preview.js";
import { enterRoom, hasRoom } from "./room.js";
import { mountStage } from "./stage.js";
import { createStore } from "./state.js";
import { still } from "./screen.js";
import { createText } from "./text.js";
import { theme } from "./theme.js";
import { mountTimebar } from "./timebar.js";
import { tried } from "./trouble.js";

const root = document.documentElement;
if ("begun" in root.dataset) throw new Error("the page has begun already");
root.dataset.begun = "";

const VIEWS = {
  header: mountHeader,
  stage: mountStage,
  timebar: mountTimebar,
  drawers: mountDrawers,
};
const CLASS_SPREAD_MS = 60000;
const TYPED = "input:not([type=range], [type=checkbox], [type=radio]), textarea";
const PRESSED = "input:not([type=range]), textarea, select, button, summary, a";

// in another page's frame: the stage and the time bar
const embedded = new URLSearchParams(location.search).get("embed") === "1";
if (embedded) root.dataset.embed = "";
const FRAMED = ["stage", "timebar"];
const shown = Object.entries(VIEWS).filter(([id]) => !embedded || FRAMED.includes(id));

const text = createText();
const client = createClient();
const clock = createClock();
// on a wide screen the examples lie open beside the stage
const first = beginning();
const named = location.hash.length > 1 || first.patch;
const wide = !embedded && matchMedia("(min-width: 861px)").matches && !named;
const store = createStore(first.patch ?? (wide ? { view: { drawer: "presets" } } : {}));
const motion = createMotion({ store, client, clock });
const offline = createOffline(text);
/** @type {{destroy: End}[]} */
let views = [];

const parts = {
  store,
  motion,
  clock,
  client,
  offline,
  text,
  theme,
  files,
  yours,
  /** Says it to those who listen instead of looking. @param {string} words */
  announce(words) {
    const live = document.getElementById("live");
    if (live) [live.textContent, live.className] = [words, "unseen"];
  },
  /** Says what is wrong with what was typed, to all, until they go on. @param {string} words */
  object(words) {
    app.announce(words);
    document.getElementById("live")?.classList.replace("unseen", "objection");
  },
  /** Says it on the stage, for all. @param {string} words */
  complain(words) {
    motion.note(words);
  },
  /** The report on paper. */
  async print() {
    try {
      await (await files.script("drawers/share/report.js")).default(app);
    } catch (error) {
      parts.complain(said(error, text));
    }
  },
  undo() {
    tell("undo", store.undo());
  },
  redo() {
    tell("redo", store.redo());
  },
  /** Another language: all views are built anew. @param {string} language */
  async speak(language) {
    try {
      await text.use(language);
      choose(language);
      offline.speak();
    } catch (error) {
      parts.complain(said(error, text));
    }
    mount();
  },
  /** The stage's own (card.js, stage.js), where it has come. */
  editArm() {},
  stage: {
    tip: () => ({ x: 0, y: 0 }),
    seen: () => ({ left: -1, right: 1, up: 1, down: -1 }),
  },
};

const app = /** @type {App} */ (/** @type {unknown} */ (parts));
app.edits = createEdits(app);
app.live = createLive(app);
followForces(app);

/** @param {string} direction @param {string | null} label */
function tell(direction, label) {
  if (label) app.announce(text(`said.${direction}`, { what: text(`step.${label}`) }));
}

/** The tab, and who shares the page, have the scene's name. */
function retitle() {
  document.title = [titleOf(text, store.get()), text("name")].filter(Boolean).join(" \u00b7 ");
}

function mount() {
  views.forEach((view) => view.destroy());
  retitle();
  views = shown.map(([id, view]) => {
    const place = /** @type {HTMLElement} */ (document.getElementById(id));
    return tried(app, () => view(place, app), place);
  });
}

/** A worksheet or a dialog that is seen is what the browser prints, and so is a frame. */
const printsItself = () =>
  embedded ||
  [...document.querySelectorAll(".sheet, dialog[open]")].some((one) => one.getClientRects().length);

/** @param {KeyboardEvent} event */
function keys(event) {
  const target = /** @type {Element} */ (event.target);
  const field = /** @type {HTMLInputElement | null} */ (target.closest(TYPED));
  // in a field whose text has changed, keys belong to the text
  const typing = field && field.value !== field.defaultValue;
  const key = event.key.toLowerCase();
  if ((event.ctrlKey || event.metaKey) && key === "z" && !typing) {
    event.preventDefault();
    if (event.shiftKey) app.redo();
    else app.undo();
  } else if (event.ctrlKey && key === "y" && !typing) {
    event.preventDefault();
    app.redo();
  } else if ((event.ctrlKey || event.metaKey) && key === "p" && !printsItself()) {
    event.preventDefault();
    app.print();
  } else if (plays(event)) {
    event.preventDefault();
    clock.toggle();
  }
}

// what a pointer has pressed last keeps the focus, not the space bar
let pointed = false;

/**
 * Whether a key is the space bar that plays: always, but where one types, or has come by keys to
 * something that the space bar presses.
 * @param {KeyboardEvent} event
 */
function plays(event) {
  const target = /** @type {Element} */ (event.target);
  if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey) return false;
  if (target.closest(TYPED)) return false;
  return pointed ? !target.closest("dialog") : !target.closest(PRESSED);
}

/** What the tab was left with, where it was, or what a readable address names. */
function goOn() {
  motion.begin();
  clock.restart(first.time);
}

/** What a link or an example's name stands for. @returns {Promise<Patch | null>} */
async function patchInAddress() {
  const example = location.hash.length > 1 ? null : exampleIn(location.search);
  return example
    ? documentOf(await exampleNamed(client, example))
    : readLink(location.hash, client);
}

async function open() {
  try {
    const patch = await patchInAddress();
    if (patch) store.set(patch, { label: "open" });
    else motion.begin();
  } catch {
    app.complain(text("failure.link"));
    motion.begin();
  }
}

/** What nobody has expected is told as well. @param {any} event */
function astray({ reason, error }) {
  const what = reason ?? error;
  if (!what || what.name === "AbortError") return;
  app.complain(text(what.kind === "file" ? "failure.file" : "failure.page"));
}

/** What the page does without, as soon as it is known. */
async function tellWithout() {
  bearer(); // whoever may keep nothing is told so before the first request has tried
  // a frame of another page is refused that by many browsers, and has nothing to keep
  const missed = keep.refused && !embedded ? [text("failure.storage")] : [];
  if (missed.length) app.complain(missed[0]);
  if (await files.dressed("page.css")) return;
  missed.push(text("failure.style"));
  app.complain(missed.join(" "));
}

window.pendulumd = app; // for the console, and for tests
window.addEventListener("unhandledrejection", astray);
window.addEventListener("error", astray);
document.addEventListener("keydown", keys);
// a button is pressed when the space bar is let go
document.addEventListener("keyup", (event) => plays(event) && event.preventDefault());
document.addEventListener("pointerdown", () => (pointed = true), true);
for (const type of ["pointerdown", "input"])
  document.addEventListener(type, () => {
    document.getElementById("live")?.classList.replace("objection", "unseen");
  });
document.addEventListener("keydown", ({ key }) => key === "Tab" && (pointed = false), true);
/**
 * When the whole document is there: a script that the browser has kept may run before the places of
 * the views have come.
 */
const parsed = new Promise((resolve) => {
  if (document.readyState === "loading")
    document.addEventListener("DOMContentLoaded", resolve, { once: true });
  else resolve(null);
});

/** In the reader's language, if its words come. */
async function begin() {
  await parsed;
  await text.use().catch((error) => app.complain(said(error, text)));
  mount();
  store.subscribe(retitle);
  document.getElementById("waiting")?.remove();
  if (first.patch) goOn();
  else open();
  if (first.fault) app.complain(text("failure.link.part", { part: first.fault }));
  if (!embedded) beginJournal(app, open);
  watchSleep(app);
  tellWithout();
  if (embedded) files.script("embed.js").then(({ default: frame }) => frame(app));
  else enterRoom(app).catch((error) => app.complain(said(error, text)));
  if (!still.matches && first.playing) clock.play();
}

/** The engine; who waits for a server that is gone asks it at once. */
async function beginEngine() {
  await client.engine.begin();
  if (client.engine.ready) client.hurry();
}

/**
 * When the first frames are seen and the browser has nothing to do; of a class, whose pages open
 * together and share a network, each within a minute.
 * @param {() => void} then
 */
function later(then) {
  const idle = window.requestIdleCallback ?? ((done) => setTimeout(done, 100));
  const wait = hasRoom() ? Math.random() * CLASS_SPREAD_MS : 0;
  const begin = () => setTimeout(() => idle(then, { timeout: 2000 }), wait);
  requestAnimationFrame(() => requestAnimationFrame(begin));
}

// the engine comes when the pendulum swings, or where no server answers; the page is kept then
const swings = motion.subscribe((_, what) => {
  if (what !== "stats" && what !== "failure") return;
  swings();
  later(() => {
    beginEngine();
    offline.begin();
  });
});
client.watch(({ kind }) => kind === "away" && beginEngine());

begin();
