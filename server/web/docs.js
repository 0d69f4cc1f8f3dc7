// The API's reference, made from /openapi.json: an entry for each section, route and schema, contents, search, anchors.
// Leaves to others: the words (the document), fields (docs/schema.js), examples that run (docs/example.js), Markdown.
// Invariant: whatever the document has gets a place here; nothing is known of any route.

import { article, summaryOf } from "./docs/operation.js";
import { markdown } from "./docs/markdown.js";
import { createReader, fieldsOf } from "./docs/schema.js";
import { h, icon, iconButton } from "./dom.js";
import { theme } from "./theme.js";

const METHODS = ["get", "post", "put", "patch", "delete"];
const SMALL = "(max-width: 860px)";

const slug = (text) =>
  text
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-")
    .replace(/^-|-$/g, "");

/** The description's sections: {title, text}, the first without a title. */
function sectionsOf(description) {
  const [first, ...rest] = `\n${description}`.split(/\n## /);
  return [
    { title: "", text: first },
    ...rest.map((part) => ({
      title: part.slice(0, part.indexOf("\n")),
      text: part.slice(part.indexOf("\n")),
    })),
  ];
}

/** An operation with the parameters that its path has for all. */
const whole = ({ parameters = [] }, operation) => ({
  ...operation,
  parameters: [...parameters, ...(operation.parameters ?? [])],
});

/** [{title, entries: [{id, label, element}]}]: all that the page shows, in order. */
function groupsOf(reader) {
  const { info, paths, tags = [], components = {} } = reader.document;
  const [introduction, ...sections] = sectionsOf(info.description);
  const first = h(
    "section",
    { id: "introduction" },
    h("h2", {}, info.summary ?? info.title),
    ...markdown(introduction.text),
  );
  const groups = [
    {
      title: "Overview",
      entries: [
        { id: "introduction", label: "Introduction", element: first },
        ...sections.map(({ title, text }) =>
          entry(
            slug(title),
            title,
            h("section", {}, heading("h2", title, slug(title)), ...markdown(text)),
          ),
        ),
      ],
    },
  ];
  for (const tag of tags) {
    const found = Object.entries(paths).flatMap(([path, item]) =>
      METHODS.filter((method) => item[method]?.tags?.includes(tag.name)).map((method) => ({
        path,
        method,
        operation: whole(item, item[method]),
      })),
    );
    const intro = entry(
      `tag-${tag.name}`,
      null,
      h(
        "section",
        { class: "doc-tag" },
        heading("h2", title(tag.name), `tag-${tag.name}`),
        ...markdown(tag.description ?? ""),
      ),
    );
    groups.push({
      title: title(tag.name),
      entries: [
        intro,
        ...found.map((one) =>
          entry(one.operation.operationId, summaryOf(one), article(one, reader, heading)),
        ),
      ],
    });
  }
  const schemas = Object.entries(components.schemas ?? {}).map(([name, schema]) =>
    entry(
      `schema-${name}`,
      name,
      h(
        "section",
        { class: "doc-schema" },
        heading("h3", name, `schema-${name}`),
        ...fieldsOf(schema, reader),
      ),
    ),
  );
  const intro = entry(
    "schemas",
    null,
    h(
      "section",
      {},
      heading("h2", "Schemas", "schemas"),
      h("p", {}, "What the bodies of requests and answers are made of."),
    ),
  );
  groups.push({ title: "Schemas", entries: [intro, ...schemas] });
  return groups;
}

const title = (name) => name[0].toUpperCase() + name.slice(1);

function entry(id, label, element) {
  element.id = id;
  return { id, label, element };
}

/** A heading that leads to itself. */
function heading(tag, text, id, ...more) {
  return h(
    tag,
    {},
    ...(more.length ? more : [text]),
    h("a", { class: "doc-anchor", href: `#${id}`, "aria-label": `Link to ${text}` }, "#"),
  );
}

/** The contents; returns {element, show(entry, found)}. */
function contentsOf(groups) {
  const places = new Map();
  const lists = groups.map((group) => {
    const items = group.entries
      .filter((one) => one.label)
      .map((one) => {
        const item = h("li", {}, h("a", { href: `#${one.id}` }, ...[one.label].flat()));
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
    item: (id) => places.get(id),
    tidy: () =>
      lists.forEach((list) => {
        list.hidden = !list.querySelector("li:not([hidden])");
      }),
  };
}

/** The search field: what does not have the words is hidden, in the text and in the contents. */
function search(groups, contents) {
  const entries = groups.flatMap((group) => group.entries);
  const texts = new Map(entries.map((one) => [one.id, one.element.textContent.toLowerCase()]));
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
      const found = words.every((word) => texts.get(one.id).includes(word));
      one.element.hidden = !found || (words.length > 0 && !one.label);
      const item = contents.item(one.id);
      if (item) item.hidden = !found;
      count += found && one.label ? 1 : 0;
    }
    contents.tidy();
    said.textContent = !words.length ? "" : count === 1 ? "1 place" : `${count} places`;
  }

  function leave(event) {
    if (event.key !== "Escape") return;
    field.value = "";
    find();
  }

  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest?.("input, textarea, select");
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

/** Marks in the contents what is being read. */
function follow(groups, contents) {
  const watcher = new IntersectionObserver(
    (changes) => {
      for (const { target, isIntersecting } of changes) {
        const link = contents.item(target.id)?.firstChild;
        if (!link) continue;
        if (isIntersecting) link.setAttribute("aria-current", "true");
        else link.removeAttribute("aria-current");
      }
    },
    { rootMargin: "-80px 0px -70% 0px" },
  );
  for (const one of groups.flatMap((group) => group.entries)) watcher.observe(one.element);
}

function head(document_) {
  const shade = iconButton("dark", "Light or dark", () => theme.toggle());
  const look = () => shade.replaceChildren(icon(theme.dark ? "light" : "dark"));
  theme.subscribe(look);
  look();
  const name = h(
    "h1",
    {},
    h("a", { href: "/" }, "pendulumd"),
    " ",
    h("span", {}, `reference, version ${document_?.info.version ?? "?"}`),
  );
  return {
    name,
    tools: h("div", { class: "tools" }, h("a", { href: "/openapi.json" }, "openapi.json"), shade),
  };
}

/** Goes where the address says: what comes later than the page is scrolled to here. */
function goThere(finder) {
  const id = decodeURIComponent(location.hash.slice(1));
  const target = id && document.getElementById(id);
  if (!target) return;
  if (target.closest("[hidden]")) finder.clear();
  for (let outer = target.closest("details"); outer; outer = outer.parentElement.closest("details"))
    outer.open = true;
  target.scrollIntoView();
}

async function open() {
  const main = document.getElementById("content");
  const bar = document.getElementById("head");
  try {
    const reply = await fetch("/openapi.json");
    if (!reply.ok) throw new Error(`it was answered ${reply.status}`);
    const reader = createReader(await reply.json());
    const groups = groupsOf(reader);
    const contents = contentsOf(groups);
    const finder = search(groups, contents);
    const { name, tools } = head(reader.document);
    bar.replaceChildren(name, finder.element, tools);
    document.getElementById("contents").replaceChildren(contents.element);
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
        `The description could not be read: ${error.message}. `,
        h("button", { class: "button", on: { click: open } }, "Try again"),
      ),
    );
  }
  document.documentElement.dataset.ready = "yes";
}

open();
