// What runs first: the first request, then the page's own script and style and the words of its
// language, asked for again where they are refused.
// Leaves to others: the page (main.js), which takes away the words of index.html that stand there
// meanwhile.
// Invariant: whatever is refused, there are words on the page.

import { dressed, script } from "./files.js";
import "./first.js";
import { beginWords } from "./language.js";

const waiting = () => document.getElementById("waiting");

/** The words that stand there get a button; they show themselves at once. */
function giveUp() {
  const place = waiting();
  if (!place || place.querySelector("button")) return;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "button";
  button.textContent = "\u21bb";
  button.setAttribute("aria-label", "Reload, neu laden");
  button.addEventListener("click", () => location.reload());
  place.classList.add("failed");
  place.append(button);
}

// the document names main.js as well, so that either of the two is enough; a page that has begun
// does not begin twice
beginWords();
script("main.js").catch(giveUp);
dressed("page.css").then((there) => there || giveUp());
