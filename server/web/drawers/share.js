// Share: links that reproduce the scene to the bit, one that the server keeps and one that holds
// all itself, QR codes, files.
// Leaves to others: what a link holds (link.js), the codes (qr.js).
// Invariant: a link that is shown stands for the document as it is now; one that does not is taken
// away.

import { addressOf, linkTo } from "../address.js";
import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { titleOf } from "../header.js";
import { handedOn, linkOf, sceneOf } from "../link.js";
import { numbersAsFiles } from "./kit/files_of_numbers.js";
import { button, copyButton, needsServer, save, settled } from "./kit/kit.js";
import { showProjector } from "./share/projector.js";
import { LONGEST, localOf, qrOf } from "./kit/qr.js";

/** A link with its code: set("") hides it. @typedef {ReturnType<typeof linkField>} LinkField */

/**
 * The drawer while it is there; kept: the scene's text that the short link stands for.
 * @typedef {{
 *   app: App, shown: boolean, kept: string | null, status: HTMLElement, fileStatus: HTMLElement,
 *   title: HTMLInputElement,
 *   short: LinkField, long: LinkField, plain: LinkField, plainPart: HTMLElement | null,
 *   projector: HTMLButtonElement, report: HTMLButtonElement, make: HTMLButtonElement,
 * }} View
 */

/**
 * A link to the pendulum, with its title where it has one.
 * @param {Text} text @param {string} rest what stands behind the host @param {Doc} doc
 */
function linkNamed(text, rest, doc) {
  const title = encodeURIComponent(titleOf(text, doc)).replace(/'/g, "%27");
  const [search, hash] = rest.split("#");
  const named = title && `${search ? `${search}&` : "?"}title=${title}`;
  return linkTo(text, `${named || search}${hash ? `#${hash}` : ""}`);
}

/**
 * @param {App} app @param {any} qrcode the library @param {string} id @param {string} label @param
 * {() => Promise<void>} follow
 */
function linkField(app, qrcode, id, label, follow) {
  const { text } = app;
  const focus = () => field.select();
  const field = h("input", {
    type: "text",
    readonly: true,
    "aria-label": label,
    "data-link": id,
    on: { focus },
  });
  const qr = h("div", {});
  const give = async () => {
    await follow();
    return field.value;
  };
  const row = h("div", { class: "link-row" }, field, copyButton(app, text("share.copy"), give));
  const place = h("div", { class: "link" }, row, qr);
  return {
    place,
    /** @param {string} link @param {string} words what its code is */
    set(link, words = "") {
      place.hidden = !link;
      field.value = link;
      qr.replaceChildren();
      if (link.length > LONGEST) qr.append(h("p", { class: "quiet" }, text("share.tooLong")));
      else if (link) qr.append(qrOf(qrcode, link, words));
    },
  };
}

/** @param {View} view */
async function makeShort(view) {
  const { app, make, status, short } = view;
  const { client, store, text } = app;
  const scene = sceneOf(handedOn(store.get()));
  make.disabled = true;
  status.textContent = text("kit.waiting");
  try {
    const { links } = await client.storeScene(scene);
    view.kept = JSON.stringify(scene);
    status.textContent = "";
    short.set(linkTo(text, links.page.replace(/^\//, "")), text("share.qrShort"));
    follow(view);
  } catch (error) {
    const away = /** @type {Failed} */ (error).status === 404;
    status.textContent = away ? text("share.noStore") : said(error, text);
  }
  make.disabled = false;
}

/** The links of the document as it is now. @param {View} view */
async function follow(view) {
  if (!view.shown) return;
  const { app, title, short, long, status } = view;
  const { store, text } = app;
  const doc = store.get();
  if (document.activeElement !== title) title.value = doc.title;
  if (view.kept !== null && JSON.stringify(sceneOf(handedOn(doc))) !== view.kept) {
    view.kept = null;
    short.set("");
    status.textContent = text("share.outdated");
  }
  const address = addressOf(doc);
  view.plain.set(address ? linkNamed(text, address, doc) : "", text("share.plain"));
  if (view.plainPart) view.plainPart.hidden = !address;
  const hash = await linkOf(handedOn(doc));
  if (doc === store.get()) long.set(linkNamed(text, hash, doc), text("share.qrLong"));
}

/** @param {Store} store */
function saveScene(store) {
  const scene = JSON.stringify(sceneOf(handedOn(store.get())), null, 1);
  save(new Blob([scene], { type: "application/json" }), "scene.json");
}

/** @param {Store} store */
function titleField(store) {
  const input = () => store.set({ title: title.value }, { label: "title", merge: "title" });
  const on = { input, change: () => store.settle() };
  const { title: value } = store.get();
  const title = h("input", { type: "text", maxlength: 200, value, "data-title": "", on });
  return title;
}

/** @param {App} app @param {any} qrcode the library @returns {View} */
function createView(app, qrcode) {
  const { store, text } = app;
  const update = () => follow(view);
  const main = { class: "button main", "data-share": "make" };
  /** @type {View} */
  const view = {
    app,
    shown: false,
    kept: null,
    status: h("p", { class: "quiet", role: "status" }),
    fileStatus: h("p", { class: "quiet", role: "status" }),
    title: titleField(store),
    short: linkField(app, qrcode, "short", text("share.short"), update),
    long: linkField(app, qrcode, "long", text("share.long"), update),
    plain: linkField(app, qrcode, "plain", text("share.plain"), update),
    plainPart: null,
    projector: button(text("share.projector"), () => project(app, qrcode), {
      "data-projector": "begin",
    }),
    report: button(text("share.report"), app.print, { "data-share": "report" }),
    make: button(text("share.make"), () => makeShort(view), main),
  };
  view.short.set("");
  return view;
}

/**
 * A part of the drawer with its title and what it is for.
 * @param {Text} text @param {string} id @param {...(HTMLElement)} children
 */
function section(text, id, ...children) {
  const intro = h("p", { class: "quiet" }, text(`share.${id}Hint`));
  return h("section", {}, h("h3", {}, text(`share.${id}`)), intro, ...children);
}

/** @param {App} app @param {any} qrcode the library */
async function project(app, qrcode) {
  const doc = app.store.get();
  const long = await linkOf(handedOn(doc));
  const link = linkTo(app.text, addressOf(doc) ?? long);
  showProjector(app, qrcode, link.length > LONGEST ? linkTo(app.text, "") : link);
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, view) {
  const { app, title, projector, make, status, short, long, plain, fileStatus } = view;
  const { store, text } = app;
  const scene = button(text("share.scene"), () => saveScene(store), { "data-save": "json" });
  view.plainPart = section(text, "plain", plain.place);
  element.append(
    h("h2", {}, text("drawer.share")),
    h("p", { class: "quiet" }, text("share.intro")),
    localOf(text) || "",
    h("label", { class: "field wide" }, h("span", {}, text("share.title")), title),
    needsServer(
      text,
      section(text, "short", h("div", { class: "row" }, make), status, short.place),
    ),
    view.plainPart,
    section(text, "long", long.place),
    section(text, "projector", h("div", { class: "row" }, projector)),
    section(text, "report", h("div", { class: "row" }, view.report)),
    section(text, "files", h("div", { class: "row" }, scene)),
    numbersAsFiles(app, fileStatus),
    fileStatus,
  );
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const { default: qrcode } = await app.files.script("lib/qrcode.js");
  const bag = createBag();
  const view = createView(app, qrcode);
  lay(element, view);
  const soon = settled(() => follow(view), 150);
  bag(soon.end);
  bag(app.store.subscribe(soon));
  return {
    show() {
      view.shown = true;
      follow(view);
    },
    hide() {
      view.shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "share", title: (text) => text("drawer.share"), mount };
