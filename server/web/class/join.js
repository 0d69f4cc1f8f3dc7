// The way into a room: by its code and a nickname, as before, or as the teacher of a new one.
// Leaves to others: the room (session.js), the page about what is kept (kept.js).
// Invariant: what is refused is said beside the form; what was typed stays.

import { said } from "../client.js";
import { h } from "../dom.js";
import { button, choice } from "../drawers/kit/kit.js";
import { codeInAddress } from "../room.js";
import { awayLine } from "./away.js";
import { keptLink } from "./kept.js";
import { keptRooms } from "./session.js";

const HOURS = [1, 2, 8, 24, 168, 720];
const CODE = /^[a-hj-np-z2-9]{6}$/i;

/** Why it was refused, in words. @param {Room} room @param {any} error @param {string} code */
function why({ app, say }, error, code) {
  if (error.status === 404) return say("class.join.none", { code });
  if (error.status === 403) return say("class.join.shut", { code });
  return said(error, app.text);
}

/** @param {string} label @param {Record<string, any>} attributes */
function fieldOf(label, attributes) {
  const input = h("input", { type: "text", autocomplete: "off", ...attributes });
  return { input, element: h("label", { class: "field" }, h("span", {}, label), input) };
}

/** @param {Room} room @param {HTMLElement} fault */
function joinForm(room, fault) {
  const { session, say } = room;
  const code = fieldOf(say("class.code"), {
    maxlength: 6,
    autocapitalize: "characters",
    spellcheck: "false",
    class: "code-input",
    "data-class": "code",
    value: codeInAddress() ?? "",
  });
  const name = fieldOf(say("class.nickname"), { maxlength: 32, "data-class": "nickname" });
  const go = h(
    "button",
    { type: "submit", class: "button main", "data-class": "join" },
    say("class.join"),
  );

  async function join() {
    const typed = code.input.value.trim();
    const nickname = name.input.value.trim();
    code.input.setAttribute("aria-invalid", String(!CODE.test(typed)));
    name.input.setAttribute("aria-invalid", String(!nickname));
    fault.textContent = "";
    if (!CODE.test(typed)) fault.textContent = say("class.join.code");
    else if (!nickname) fault.textContent = say("class.join.nickname");
    if (fault.textContent) return (CODE.test(typed) ? name : code).input.focus();
    go.disabled = true;
    try {
      await session.join(typed, nickname);
    } catch (error) {
      fault.textContent = why(room, error, typed.toUpperCase());
    }
    go.disabled = false;
  }
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    join();
  };
  const hint = h("p", { class: "quiet" }, say("class.nickname.hint"), " ", keptLink(room));
  return h(
    "form",
    { class: "join", novalidate: true, on: { submit } },
    code.element,
    name.element,
    hint,
    go,
  );
}

/** Rooms that this browser was in. @param {Room} room @param {HTMLElement} fault */
function backList(room, fault) {
  const { session, say, app } = room;
  const rooms = keptRooms();
  if (!rooms.length) return null;
  const rows = rooms.map(({ code, role, nickname }) => {
    const who = role === "teacher" ? say("class.teacher") : nickname;
    const back = () =>
      session.resume(code).catch((error) => {
        fault.textContent = said(error, app.text);
      });
    return h("li", {}, button(say("class.back", { code, who }), back, { "data-back": code }));
  });
  return h("section", {}, h("h3", {}, say("class.rooms")), h("ul", { class: "plain" }, ...rows));
}

/** @param {Room} room @param {HTMLElement} fault */
function makeForm({ app, session, say }, fault) {
  let hours = 2;
  const options = HOURS.map((value) => ({ value, words: say(`class.hours.${value}`) }));
  const length = choice(say("class.hours"), options, hours, (value) => {
    hours = Number(value);
  });
  const remember = h("input", { type: "checkbox", "data-class": "remember" });
  const make = button(
    say("class.make"),
    async () => {
      make.disabled = true;
      try {
        await session.make(hours, remember.checked);
      } catch (error) {
        const none = /** @type {Failed} */ (error).status === 404;
        fault.textContent = none ? say("class.noStore") : said(error, app.text);
      }
      make.disabled = false;
    },
    { "data-class": "make" },
  );
  return h(
    "section",
    {},
    h("h3", {}, say("class.forTeachers")),
    h("p", { class: "quiet" }, say("class.make.hint")),
    h("div", { class: "row" }, length.element, make),
    h("label", { class: "check" }, remember, h("span", {}, say("class.remember"))),
  );
}

/**
 * Who comes by the code of a room is asked for a nickname, and for nothing else.
 * @param {Room} room
 */
export function openJoinCard(room) {
  const { say, session, app } = room;
  const fault = h("p", { class: "fault", role: "alert" });
  const away = awayLine(app);
  const later = button(say("class.join.later"), () => card.close(), { class: "as-link" });
  const head = h("h2", { id: "join-head" }, say("class.joinHere"));
  const attributes = { class: "join-card", "aria-labelledby": "join-head" };
  const card = h("dialog", attributes, head, joinForm(room, fault), fault, away.place, later);
  const end = session.subscribe(() => session.state === "live" && card.close());
  card.addEventListener("close", () => {
    end();
    away.end();
    card.remove();
    app.store.set({ view: { drawer: "class" } });
  });
  document.body.append(card);
  card.showModal();
  /** @type {HTMLElement | null} */ (card.querySelector("[data-class=nickname]"))?.focus();
}

/** @param {HTMLElement} element @param {Room} room */
export function mountJoin(element, room) {
  const { say, session } = room;
  const fault = h("p", { class: "fault", role: "alert" });
  const away = awayLine(room.app);
  if (session.state === "gone") fault.textContent = say("class.gone");
  element.append(
    h("p", { class: "quiet" }, say("class.intro")),
    joinForm(room, fault),
    fault,
    away.place,
    ...[backList(room, fault)].filter((part) => part !== null),
    makeForm(room, fault),
  );
  return {
    destroy() {
      away.end();
      element.replaceChildren();
    },
  };
}
