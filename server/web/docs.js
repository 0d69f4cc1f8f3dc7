// The API's reference, made from /openapi.json: contents, search, anchors around what the
// description has.
// Leaves to others: the words (the description), their order (docs/catalogue.js), examples that run
// (docs/run.js).
// Invariant: a reference that cannot be made says why, and offers to try again.

import { groupsOf } from "./docs/catalogue.js";
import { createReader } from "./docs/schema.js";
import { h, icon, iconButton } from "./dom.js";
import { dressed } from "./files.js";
import { keep } from "./keep.js";
import { theme } from "./theme.js";

const SMALL = "(max-width: 860px)";

/** @typedef {import("./docs/catalogue.js").Group} Group */
/** @typedef {ReturnType<typeof contentsOf>} Contents */

/** The contents; returns {element, show(entry, found)}. @param {Group[]} groups */
function contentsOf(groups) {
  /** @type {Map<string, HTMLElement>} */
  const places = new Map();
  const lists = groups.map((group) => {
    const items = group.entries
      .filter((one) => one.label)
      .map((one) => {
        const item = h("li", {}, h("a", { href: `#${one.id}` }, ...[one.label ?? ""].flat()));
        places.set(one.id, item);
        return item;
      });
    return h("section", {}, h("h2", {}, group.title), h("ul", {}, ...items));
  });
  const element = h(
    "details",
    { open: !matchMedia(SMALL).matches },
    h("summary", {}, "Contents"),
    ...lists,
  );
  return {
    element,
    item: (/** @type {string} */ id) => places.get(id),
    tidy: () =>
      lists.forEach((list) => {
        list.hidden = !list.querySelector("li:not([hidden])");
      }),
  };
}

/**
 * The search field: what does not have the words is hidden, in the text and in the contents.
 * @param {Group[]} groups @param {Contents} contents
 */
function search(groups, contents) {
  const entries = groups.flatMap((group) => group.entries);
  const texts = new Map(
    entries.map((one) => [one.id, (one.element.textContent ?? "").toLowerCase()]),
  );
  const said = h("span", { class: "doc-found", role: "status", "aria-live": "polite" });
  const field = h("input", {
    type: "search",
    placeholder: "Search",
    "aria-label": "Search the reference",
    "aria-keyshortcuts": "/",
    spellcheck: "false",
    on: { input: find, keydown: leave },
  });

  function find() {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    for (const one of entries) {
      const found = words.every((word) => texts.get(one.id)?.includes(word));
      one.element.hidden = !found || (words.length > 0 && !one.label);
      const item = contents.item(one.id);
      if (item) item.hidden = !found;
      count += found && one.label ? 1 : 0;
    }
    contents.tidy();
    const places = count === 1 ? "1 place" : `${count} places`;
    said.textContent = words.length ? places : "";
  }

  /** @param {KeyboardEvent} event */
  function leave(event) {
    if (event.key !== "Escape") return;
    field.value = "";
    find();
  }

  document.addEventListener("keydown", (event) => {
    const target = /** @type {Element} */ (event.target);
    const typing = target.closest?.("input, textarea, select");
    if (event.key !== "/" || typing || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    field.focus();
  });
  return {
    element: h("div", { class: "doc-search" }, field, said),
    clear: () => {
      field.value = "";
      find();
    },
  };
}

/** Marks in the contents what is being read. @param {Group[]} groups @param {Contents} contents */
function follow(groups, contents) {
  const watcher = new IntersectionObserver(
    (changes) => {
      for (const { target, isIntersecting } of changes) {
        const link = contents.item(target.id)?.firstElementChild;
        if (!link) continue;
        if (isIntersecting) link.setAttribute("aria-current", "true");
        else link.removeAttribute("aria-current");
      }
    },
    { rootMargin: "-80px 0px -70% 0px" },
  );
  for (const one of groups.flatMap((group) => group.entries)) watcher.observe(one.element);
}

/** @param {any} document_ */
function head(document_) {
  const shade = iconButton("dark", "Light or dark", () => theme.toggle());
  const look = () => shade.replaceChildren(icon(theme.dark ? "light" : "dark"));
  theme.subscribe(look);
  look();
  const name = h(
    "h1",
    {},
    h("a", { href: "./" }, "pendulumd"),
    " ",
    h("span", {}, `guides and reference, version ${document_?.info.version ?? "?"}`),
  );
  return {
    name,
    tools: h("div", { class: "tools" }, h("a", { href: "openapi.json" }, "openapi.json"), shade),
  };
}

/**
 * Goes where the address says: what comes later than the page is scrolled to here.
 * @param {{clear(): void}} finder
 */
function goThere(finder) {
  const id = decodeURIComponent(location.hash.slice(1));
  const target = id && document.getElementById(id);
  if (!target) return;
  if (target.closest("[hidden]")) finder.clear();
  for (let outer = target.closest("details"); outer; ) {
    outer.open = true;
    outer = outer.parentElement?.closest("details") ?? null;
  }
  target.scrollIntoView();
}

/** A part of the document, which always has it. @param {string} id */
const placeOf = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** Says what the page does without: the browser's storage, its style sheet. */
async function tellWithout() {
  if (keep.refused) {
    const words =
      "This browser stores nothing for this page: light or dark lasts as long as this tab.";
    placeOf("content").prepend(h("p", { role: "status" }, words));
  }
  if (await dressed("docs.css")) return;
  const words =
    "The style sheet of this page did not come: all is here, but bare. Reload it to try again.";
  placeOf("content").prepend(h("p", { role: "alert" }, words));
}

/** The JSON at an address. @param {string} address */
async function brought(address) {
  const reply = await fetch(address);
  if (!reply.ok) throw new Error(`it was answered ${reply.status}`);
  return reply.json();
}

async function open() {
  const main = placeOf("content");
  const bar = placeOf("head");
  try {
    const { page } = document.documentElement.dataset;
    // the reference is whole without the guides
    const coming = brought(`${page}/guides.json`).catch(() => []);
    const [api, guides] = await Promise.all([brought("openapi.json"), coming]);
    const reader = createReader(api);
    const groups = groupsOf(reader, guides);
    const contents = contentsOf(groups);
    const finder = search(groups, contents);
    const { name, tools } = head(reader.document);
    bar.replaceChildren(name, finder.element, tools);
    placeOf("contents").replaceChildren(contents.element);
    main.replaceChildren(...groups.flatMap((group) => group.entries.map((one) => one.element)));
    follow(groups, contents);
    goThere(finder);
    addEventListener("hashchange", () => goThere(finder));
    matchMedia(SMALL).addEventListener("change", (small) => {
      contents.element.open = !small.matches;
    });
  } catch (error) {
    const { name, tools } = head(null);
    bar.replaceChildren(name, tools);
    main.replaceChildren(
      h(
        "p",
        { role: "alert" },
        `The description could not be read: ${/** @type {Error} */ (error).message}. `,
        h("button", { class: "button", on: { click: open } }, "Try again"),
      ),
    );
  }
  document.documentElement.dataset.ready = "yes";
}

open().then(tellWithout);
