// Share: links that reproduce the scene to the bit, one that the server keeps and one that holds all itself, QR codes, files.
// Leaves to others: what a link holds (link.js), the codes (qrcode-generator).
// Invariant: a link that is shown stands for the document as it is now; one that does not is taken away.

import { createBag, h } from "../dom.js";
import { said } from "../client.js";
import { script } from "../files.js";
import { linkOf, sceneOf } from "../link.js";
import { request } from "../state.js";
import { aborted, button, copyButton, save, settled } from "./kit.js";

const LONGEST = 1200; // letters of a link that a camera still reads off a projector
const FILES = [
  { name: "CSV", type: "text/csv", ending: "csv" },
  { name: "NPZ", type: "application/x-npz", ending: "npz" },
  { name: "MAT", type: "application/x-matlab-data", ending: "mat" },
];
const SVG = "http://www.w3.org/2000/svg";

/** The code of some letters, black on white with the margin that cameras need, whatever the theme. */
export function qrOf(qrcode, letters, label) {
  const code = qrcode(0, letters.length > 300 ? "L" : "M");
  code.addData(letters);
  code.make();
  const count = code.getModuleCount();
  const parts = [];
  for (let row = 0; row < count; row++) {
    for (let column = 0; column < count; column++)
      if (code.isDark(row, column)) parts.push(`M${column + 4} ${row + 4}h1v1h-1z`);
  }
  const svg = document.createElementNS(SVG, "svg");
  const dark = document.createElementNS(SVG, "path");
  svg.setAttribute("viewBox", `0 0 ${count + 8} ${count + 8}`);
  svg.setAttribute("class", "qr");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", label);
  svg.setAttribute("shape-rendering", "crispEdges");
  dark.setAttribute("d", parts.join(""));
  svg.append(dark);
  return svg;
}

/** What is handed on: all but this drawer being open. */
const handedOn = (doc) => ({ ...doc, view: { ...doc.view, drawer: null } });

const whole = (hash) => `${location.origin}/${hash}`;

async function mount(element, app) {
  const { default: qrcode } = await script("lib/qrcode.js");
  const { store, client, text } = app;
  const bag = createBag();
  const status = h("p", { class: "quiet", role: "status" });
  const fileStatus = h("p", { class: "quiet", role: "status" });
  let shown = false;
  let kept = null; // the scene's text that the short link stands for

  const title = h("input", {
    type: "text",
    maxlength: 200,
    value: store.get().title,
    "data-title": "",
    on: {
      input: () => store.set({ title: title.value }, { label: "title", merge: "title" }),
      change: () => store.settle(),
    },
  });

  function linkField(id, label) {
    const field = h("input", {
      type: "text",
      readonly: true,
      "aria-label": label,
      "data-link": id,
      on: { focus: () => field.select() },
    });
    const qr = h("div", {});
    const place = h(
      "div",
      { class: "link" },
      h(
        "div",
        { class: "link-row" },
        field,
        copyButton(app, text("share.copy"), async () => {
          await follow();
          return field.value;
        }),
      ),
      qr,
    );
    return {
      place,
      field,
      set(link, words) {
        place.hidden = !link;
        field.value = link;
        qr.replaceChildren(
          ...(!link
            ? []
            : link.length > LONGEST
              ? [h("p", { class: "quiet" }, text("share.tooLong"))]
              : [qrOf(qrcode, link, words)]),
        );
      },
    };
  }

  const short = linkField("short", text("share.short"));
  const long = linkField("long", text("share.long"));
  short.set("");
  const make = button(text("share.make"), makeShort, {
    class: "button main",
    "data-share": "make",
  });

  async function makeShort() {
    const scene = sceneOf(handedOn(store.get()));
    make.disabled = true;
    status.textContent = text("kit.waiting");
    try {
      const { links } = await client.storeScene(scene);
      kept = JSON.stringify(scene);
      status.textContent = "";
      short.set(whole(links.page.replace(/^\//, "")), text("share.qrShort"));
      follow();
    } catch (error) {
      status.textContent = error.status === 404 ? text("share.noStore") : said(error, text);
    }
    make.disabled = false;
  }

  async function follow() {
    if (!shown) return;
    const doc = store.get();
    if (document.activeElement !== title) title.value = doc.title;
    if (kept !== null && JSON.stringify(sceneOf(handedOn(doc))) !== kept) {
      kept = null;
      short.set("");
      status.textContent = text("share.outdated");
    }
    const hash = await linkOf(handedOn(doc));
    if (doc === store.get()) long.set(whole(hash), text("share.qrLong"));
  }

  async function saveNumbers({ type, ending }) {
    fileStatus.textContent = text("kit.waiting");
    try {
      const { blob, name } = await client.file(
        "/v1/trajectories",
        { ...request(store.get()), output: ["phi", "phid", "lambda", "z", "energy"] },
        type,
      );
      save(blob, name || `pendulum.${ending}`);
      fileStatus.textContent = text("plots.saved", { name: name || `pendulum.${ending}` });
    } catch (error) {
      if (!aborted(error)) fileStatus.textContent = said(error, text);
    }
  }

  const saveScene = () =>
    save(
      new Blob([JSON.stringify(sceneOf(handedOn(store.get())), null, 1)], {
        type: "application/json",
      }),
      "scene.json",
    );

  element.append(
    h("h2", {}, text("drawer.share")),
    h("p", { class: "quiet" }, text("share.intro")),
    h("label", { class: "field wide" }, h("span", {}, text("share.title")), title),
    h(
      "section",
      {},
      h("h3", {}, text("share.short")),
      h("p", { class: "quiet" }, text("share.shortHint")),
      h("div", { class: "row" }, make),
      status,
      short.place,
    ),
    h(
      "section",
      {},
      h("h3", {}, text("share.long")),
      h("p", { class: "quiet" }, text("share.longHint")),
      long.place,
    ),
    h(
      "section",
      {},
      h("h3", {}, text("share.files")),
      h("p", { class: "quiet" }, text("share.filesHint")),
      h(
        "div",
        { class: "row" },
        button(text("share.scene"), saveScene, { "data-save": "json" }),
        ...FILES.map((file) =>
          button(file.name, () => saveNumbers(file), { "data-save": file.ending }),
        ),
      ),
      fileStatus,
    ),
  );

  const soon = settled(follow, 150);
  bag(soon.end);
  bag(store.subscribe(soon));

  return {
    show() {
      shown = true;
      follow();
    },
    hide() {
      shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

export default { id: "share", title: (text) => text("drawer.share"), mount };
