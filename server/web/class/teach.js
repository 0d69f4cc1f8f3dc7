// The teacher's part of the drawer: the code, what the class is shown, asked and given, the board,
// and the room's end.
// Leaves to others: its parts (board.js, ask.js, present.js, together.js, sheets.js), writing
// (session.js).
// Invariant: what holds is what stands in the room; a second tab of the teacher sees the same.

import { linkTo } from "../address.js";
import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import { button, copyButton, save, toggle } from "../drawers/kit/kit.js";
import { localOf, qrOf } from "../drawers/kit/qr.js";
import { ROOT } from "../root.js";
import { mountAsk } from "./ask.js";
import { answersText } from "./answers_table.js";
import { mountBoard, openDialog } from "./board.js";
import { keptLink } from "./kept.js";
import { createPresenter } from "./present.js";
import { wholeScene } from "./scenes.js";
import { statementsOfRoom } from "./statements.js";
import { mountSheets } from "./sheets.js";
import { togetherPart } from "./together.js";

/**
 * The stage of the class, and the change of it.
 * @typedef {{stage(): ClassStage, change(patch: Partial<ClassStage>): Promise<void>,
 * attempt(what: () => Promise<unknown>): Promise<boolean>}} Desk
 */

/**
 * Does it, or says why not. @param {Room} room @param {HTMLElement} fault @param {() =>
 * Promise<unknown>} what
 */
async function attempt({ app }, fault, what) {
  fault.textContent = "";
  try {
    await what();
    return true;
  } catch (error) {
    fault.textContent = said(error, app.text);
    return false;
  }
}

/** @param {Room} room @param {HTMLElement} fault @returns {Desk} */
function deskOf(room, fault) {
  const { session } = room;
  const stage = () => session.value("stages/class") ?? {};
  // one after the other: each is made of what the one before has left
  let queue = Promise.resolve();
  return {
    stage,
    change(patch) {
      queue = queue.then(async () => {
        const next = JSON.parse(JSON.stringify({ ...stage(), ...patch }));
        await attempt(room, fault, async () => {
          const { version } = await session.put("stages/class", next);
          // what is written is known here before the stream tells it
          session.items.set("stages/class", {
            name: "stages/class",
            version,
            changed: new Date().toISOString(),
            value: next,
          });
        });
      });
      return queue;
    },
    attempt: (what) => attempt(room, fault, what),
  };
}

/**
 * An address as a picture, over the page. @param {Room} room @param {string} kind @param {string}
 * title @param {string} address @param {...(Node | null)} more above the picture
 */
async function showAddress(room, kind, title, address, ...more) {
  const { app, session, say } = room;
  const { default: qrcode } = await app.files.script("lib/qrcode.js");
  const picture = qrOf(qrcode, address, say("class.qr", { code: session.entry?.code }));
  openDialog(room, kind, title, ...more, picture, localOf(app.text) || null);
}

/** @param {Room} room */
function codePart(room) {
  const { app, session, say } = room;
  const code = session.entry?.code ?? "";
  const address = linkTo(app.text, code);
  const plain = `${ROOT.replace(/^\w+:\/\//, "")}${code}`;
  const show = () => {
    const parts = [h("p", { class: "huge" }, code), h("p", { class: "address" }, plain)];
    showAddress(room, "code", say("class.joinHere"), address, ...parts);
  };
  const large = button(say("class.showCode"), show, {
    class: "button main",
    "data-class": "showCode",
  });
  return h(
    "section",
    { class: "code-part" },
    h(
      "p",
      { class: "room-code", "aria-label": say("class.codeIs", { code: [...code].join(" ") }) },
      code,
    ),
    h(
      "div",
      { class: "row" },
      large,
      copyButton(app, say("class.copyLink"), () => address),
    ),
  );
}

/**
 * The link by which another device, or another teacher, leads the room as well.
 * @param {Room} room
 */
function leadButton(room) {
  const { app, session, say } = room;
  const address = () => linkTo(app.text, `${session.entry?.code}#teach=${session.entry?.token}`);
  const show = () => {
    const warning = h("p", { class: "fault" }, say("class.lead.warning"));
    const copying = copyButton(app, say("class.copyLink"), address);
    copying.dataset.class = "copyLead";
    showAddress(room, "lead", say("class.lead"), address(), warning, copying);
  };
  return button(say("class.lead"), show, { "data-class": "lead" });
}

/**
 * The class follows this page, until it no longer does. @param {Room} room
 * @param {ReturnType<typeof createPresenter>} presenter
 */
function followKey({ say, tell }, presenter) {
  const turn = async (/** @type {boolean} */ on) => {
    await presenter.turn(on);
    tell(say(on ? "class.did.follow" : "class.did.push"));
  };
  return toggle(say("class.follow"), false, turn, { "data-class": "follow" });
}

/** What the class is shown. @param {Room} room @param {Desk} desk */
function showPart(room, desk) {
  const { app, session, say, tell } = room;
  const presenter = createPresenter(room, desk);
  const follow = followKey(room, presenter);
  const push = button(
    say("class.push"),
    async () => {
      const scene = wholeScene(app.store.get());
      await desk.change({ scene, release: undefined, follow: undefined });
      tell(say("class.did.push"));
    },
    { class: "button main", "data-class": "push" },
  );
  const own = button(
    say("class.own"),
    async () => {
      const nothing = { scene: undefined, release: undefined, follow: undefined };
      await desk.change({ ...nothing, frozen: false });
      tell(say("class.did.own"));
    },
    { "data-class": "own" },
  );
  const freeze = toggle(
    say("class.freeze"),
    false,
    async (frozen) => {
      await desk.change({ frozen });
      tell(say(frozen ? "class.did.freeze" : "class.did.free"));
    },
    { "data-class": "freeze" },
  );
  const now = h("p", { class: "class-now" });
  const place = h(
    "section",
    { class: "show-part" },
    now,
    h("div", { class: "row" }, push, follow, freeze, own),
  );
  return {
    place,
    end: presenter.end,
    show() {
      /** @type {ClassStage} */
      const { scene, frozen, release, follow: leads } = session.value("stages/class") ?? {};
      const has = leads ? "follow" : release ? "release" : "push";
      const shown = scene ? `class.desk.${has}` : "class.desk.own";
      follow.setAttribute("aria-pressed", String(Boolean(leads)));
      now.textContent = say(frozen ? `${shown}.frozen` : shown);
      freeze.setAttribute("aria-pressed", String(Boolean(frozen)));
      own.disabled = !scene && !frozen;
    },
  };
}

/** Words for all. @param {Room} room @param {Desk} desk */
function wordsPart({ session, say }, desk) {
  const field = h("input", { type: "text", maxlength: 500, "data-class": "words" });
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    desk.change({ text: field.value.trim() || undefined });
  };
  const label = h("label", { class: "field wide" }, h("span", {}, say("class.words")), field);
  const give = h("button", { type: "submit", class: "button" }, say("class.words.send"));
  const place = h("form", { class: "words-part", on: { submit } }, label, give);
  return {
    place,
    show() {
      const { text = "" } = session.value("stages/class") ?? {};
      field.defaultValue = text;
    },
  };
}

/** All answers as a file of xAPI statements. @param {Room} room */
function statementsButton({ session, say }) {
  const give = () => {
    const all = JSON.stringify(statementsOfRoom(session), null, 1);
    save(new Blob([all], { type: "application/json" }), `class-${session.entry?.code}.json`);
  };
  return button(say("class.statements"), give, { "data-class": "statements" });
}

/** How many pupils may come from one address. @param {Room} room @param {Desk} desk */
function shareField({ say }, desk) {
  const field = h("input", {
    type: "number",
    min: 1,
    max: 100000,
    placeholder: say("class.share.usual"),
    "data-class": "share",
    on: {
      change: () => {
        const most = Math.round(Number(field.value));
        if (most >= 1) desk.change({ address_share: most });
      },
    },
  });
  return field;
}

/** All answers, as a spreadsheet of the browser's language opens them. @param {Room} room */
function tableButton(room) {
  const { session, say } = room;
  const give = () => {
    const table = new Blob([answersText(room)], { type: "text/csv" });
    save(table, `class-${session.entry?.code}.csv`);
  };
  return button(say("class.table"), give, { "data-class": "table" });
}

/** @param {Room} room @param {Desk} desk */
function endPart(room, desk) {
  const { session, say } = room;
  const table = tableButton(room);
  const door = toggle(
    say("class.shut"),
    false,
    (shut) => desk.change({ open: shut ? false : undefined }),
    { "data-class": "shut" },
  );
  const share = shareField(room, desk);
  const erase = button(
    say("class.erase"),
    () => {
      if (confirm(say("class.erase.sure"))) desk.attempt(() => session.erase());
    },
    { "data-class": "erase" },
  );
  const leave = button(
    say("class.leaveTeacher"),
    () => {
      if (confirm(say("class.leave.sure"))) session.leave();
    },
    { "data-class": "leave" },
  );
  const ends = new Date(session.entry?.ends ?? 0).toLocaleString(room.app.text.language, {
    dateStyle: "medium",
    timeStyle: "short",
  });
  const place = h(
    "section",
    {},
    h("h3", {}, say("class.end")),
    h("p", { class: "quiet" }, say("class.ends", { ends }), " ", keptLink(room)),
    h("div", { class: "row" }, table, statementsButton(room), leadButton(room)),
    h("div", { class: "row" }, door, erase, leave),
    h("label", { class: "field" }, h("span", {}, say("class.share")), share),
  );
  return {
    place,
    show() {
      const { open, address_share: most } = session.value("stages/class") ?? {};
      door.setAttribute("aria-pressed", String(open === false));
      share.defaultValue = most ? String(most) : "";
    },
  };
}

/** @param {HTMLElement} element @param {Room} room */
export default function mountTeacher(element, room) {
  const { session, say } = room;
  const bag = createBag();
  const fault = h("p", { class: "fault", role: "alert" });
  const away = h("p", { class: "fault", role: "status", hidden: true }, say("class.now.away"));
  const desk = deskOf(room, fault);
  const shown = showPart(room, desk);
  const parts = [shown, wordsPart(room, desk)];
  const end = endPart(room, desk);
  const together = togetherPart(room, desk);
  const ask = mountAsk(room, desk);
  const sheets = mountSheets(room, desk);
  const controls = h("div", { class: "controls" }, away, fault, ...parts.map(({ place }) => place));
  const board = mountBoard(room, controls);
  element.append(
    codePart(room),
    controls,
    board.place,
    ask.place,
    sheets.place,
    together.place,
    end.place,
  );
  function show() {
    away.hidden = session.state !== "away";
    parts.forEach((part) => part.show());
    together.show();
    end.show();
  }
  bag(session.subscribe(show));
  bag(shown.end);
  bag(board.destroy);
  bag(ask.destroy);
  bag(sheets.destroy);
  show();
  return {
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}
