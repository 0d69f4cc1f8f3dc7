// Puts the page together: the document, its motion, the clock, and the views of them.
// Leaves to others: everything else.
// Invariant: views know the app {store, motion, clock, client, text, announce}, never each other.

import { createClient } from "./client.js";
import { createClock } from "./clock.js";
import { createEdits } from "./edits.js";
import { mountDrawers } from "./drawers.js";
import { mountHeader } from "./header.js";
import { readLink } from "./link.js";
import { createMotion } from "./motion.js";
import { followForces } from "./preview.js";
import { mountStage } from "./stage.js";
import { createStore } from "./state.js";
import { createText } from "./text.js";
import { still } from "./theme.js";
import { mountTimebar } from "./timebar.js";

const root = document.documentElement;
if ("begun" in root.dataset) throw new Error("the page has begun already");
root.dataset.begun = "";

const VIEWS = {
  header: mountHeader,
  stage: mountStage,
  timebar: mountTimebar,
  drawers: mountDrawers,
};

const text = createText();
const client = createClient();
const clock = createClock();
// on a wide screen the examples lie open beside the stage
const wide = matchMedia("(min-width: 861px)").matches && location.hash.length <= 1;
const store = createStore(wide ? { view: { drawer: "presets" } } : {});
const motion = createMotion({ store, client, clock });
const live = document.getElementById("live");
let views = [];

const app = {
  store,
  motion,
  clock,
  client,
  text,
  /** Says it to those who listen instead of looking. */
  announce(words) {
    live.textContent = words;
  },
  /** Says it on the stage, for all. */
  complain(words) {
    motion.note(words);
  },
  undo() {
    tell("undo", store.undo());
  },
  redo() {
    tell("redo", store.redo());
  },
  /** Another language: all views are built anew. */
  speak(language) {
    text.use(language, true);
    mount();
  },
};

app.edits = createEdits(app);
followForces(app);

function tell(direction, label) {
  if (label) app.announce(text(`said.${direction}`, { what: text(`step.${label}`) }));
}

function mount() {
  views.forEach((view) => view.destroy());
  document.title = text("name");
  views = Object.entries(VIEWS).map(([id, view]) => view(document.getElementById(id), app));
}

function keys(event) {
  const field = event.target.closest("input:not([type=range]), textarea");
  // in a field whose text has changed, keys belong to the text
  const typing = field && field.value !== field.defaultValue;
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !typing) {
    event.preventDefault();
    event.shiftKey ? app.redo() : app.undo();
  } else if (event.ctrlKey && event.key.toLowerCase() === "y" && !typing) {
    event.preventDefault();
    app.redo();
  } else if (
    event.key === " " &&
    !event.target.closest("input:not([type=range]), textarea, select, button, summary, a")
  ) {
    event.preventDefault();
    clock.toggle();
  }
}

async function open() {
  try {
    const patch = await readLink(location.hash, client);
    if (patch) store.set(patch, { label: "open" });
    else motion.begin();
  } catch (error) {
    app.complain(text("failure.link"));
    motion.begin();
  }
}

/** What nobody has expected is told as well. */
function astray({ reason, error }) {
  const what = reason ?? error;
  if (what && what.name !== "AbortError")
    app.complain(text(what.kind === "file" ? "failure.file" : "failure.page"));
}

window.pendulumd = app; // for the console, and for tests
window.addEventListener("unhandledrejection", astray);
window.addEventListener("error", astray);
document.addEventListener("keydown", keys);
window.addEventListener("hashchange", open);
text.use();
mount();
document.getElementById("waiting")?.remove();
open();
if (!still.matches) clock.play();
