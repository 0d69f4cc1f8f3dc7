// The board: the wall of a class with its counts and orders, over the whole screen where that is
// wanted; one pupil enlarged.
// Leaves to others: the wall (wall.js), the controls (teach.js).
// Invariant: there is one wall; it hangs in the drawer or on the whole screen.

import { createBag, h, iconButton } from "../dom.js";
import { button, choice, toggle } from "../drawers/kit/kit.js";
import { createMini } from "../drawers/kit/mini.js";
import { nameOf } from "./answers_table.js";
import { stageScene } from "./scenes.js";
import { anglesOver, createWall, poseOf } from "./wall.js";

const SORTS = ["name", "state", "came", "changed"];
const STATES = ["stuck", "working", "done", "silent", "away"];
const SPAN = { start: 0, stop: 20, step: 0.02 };

/**
 * A dialog over the page.
 * @param {Room} room @param {string} kind @param {string} title @param {...(Node | null)} children
 */
export function openDialog({ app }, kind, title, ...children) {
  /** @type {HTMLDialogElement} */
  const dialog = h(
    "dialog",
    { class: `class-dialog ${kind}`, "aria-label": title, on: { close: () => dialog.remove() } },
    h(
      "div",
      { class: "dialog-head" },
      h("h2", {}, title),
      iconButton("close", app.text("close"), () => dialog.close()),
    ),
    ...children,
  );
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/** What a pupil has answered and handed in. @param {Room} room @param {number} number */
function doneBy({ session, say }, number) {
  const rows = [];
  for (const { name, value } of session.items.values()) {
    const [kind, id, pupil] = name.split("/");
    if (Number(pupil) !== number) continue;
    if (kind === "handins") {
      const title = session.value(`worksheets/${id}`)?.title ?? id;
      rows.push(
        say.count(value.done ? "class.handedIn" : "class.worksOn", value.answers.length, {
          title,
        }),
      );
    }
  }
  return rows.length ? h("ul", {}, ...rows.map((row) => h("li", {}, row))) : null;
}

/**
 * Moves the enlarged pendulum until the dialog goes. @param {HTMLElement} dialog @param
 * {import("../drawers/kit/mini.js").Mini} mini @param {Float64Array} motion @param {number} n
 */
function swing(dialog, mini, motion, n) {
  const begun = performance.now();
  const frame = () => {
    if (!dialog.isConnected) return;
    const row = Math.floor((performance.now() - begun) / 1000 / SPAN.step) % (motion.length / n);
    mini.draw(motion.subarray(row * n, (row + 1) * n));
    requestAnimationFrame(frame);
  };
  frame();
}

/** @param {Room} room @param {number} number */
async function enlarge(room, number) {
  const { app, session, say } = room;
  const nickname = nameOf(room, number);
  const scene = session.value(`stages/${number}`)?.scene;
  const pose = await poseOf(app, scene);
  const side = Math.max(220, Math.min(innerWidth - 90, innerHeight - 240, 720));
  const mini = pose && createMini(pose.tree, { width: side, height: side, label: nickname });
  const stop = new AbortController();
  const onStage =
    scene &&
    button(
      say("class.onMyStage"),
      () => {
        stageScene(app, scene);
        dialog.close();
      },
      { "data-class": "take" },
    );
  const remove = button(
    say("class.removePupil"),
    async () => {
      if (!confirm(say("class.removePupil.sure", { nickname }))) return;
      await session.drop(`pupils/${number}`);
      dialog.close();
    },
    { "data-class": "remove" },
  );
  const dialog = openDialog(
    room,
    "pupil",
    nickname,
    mini?.canvas ?? h("p", {}, say("class.noPicture")),
    doneBy(room, number),
    h("div", { class: "row" }, onStage, remove),
  );
  dialog.addEventListener("close", () => stop.abort());
  if (!mini || !pose) return;
  mini.draw(pose.phi);
  anglesOver(app.client, scene, SPAN, stop.signal).then(
    (motion) => swing(dialog, mini, motion, pose.phi.length),
    () => {},
  );
}

/** Numbers as the server takes them: "3,7-12". @param {number[]} numbers in order */
function rangesOf(numbers) {
  /** @type {string[]} */
  const ranges = [];
  for (let i = 0, k; i < numbers.length; i = k) {
    for (k = i + 1; k < numbers.length && numbers[k] === numbers[k - 1] + 1; ) k++;
    ranges.push(k - i > 1 ? `${numbers[i]}-${numbers[k - 1]}` : String(numbers[i]));
  }
  return ranges.join(",");
}

/** Many pupils are chosen, by name or all at once, and removed. @param {Room} room */
function removeMany(room) {
  const { session, say } = room;
  const pupils = [...session.items.values()]
    .filter(({ name }) => name.startsWith("pupils/"))
    .map(({ name }) => Number(name.split("/")[1]))
    .sort((a, b) => a - b);
  const boxes = pupils.map((number) =>
    h("input", { type: "checkbox", value: number, "data-remove": number }),
  );
  const all = h("input", { type: "checkbox", "data-class": "removeAll" });
  all.addEventListener("change", () => boxes.forEach((box) => (box.checked = all.checked)));
  const remove = button(
    say("class.removeMany.go"),
    async () => {
      const gone = pupils.filter((_, i) => boxes[i].checked);
      if (gone.length) await session.drop(`pupils/${rangesOf(gone)}`);
      dialog.close();
    },
    { class: "button main", "data-class": "removeManyGo" },
  );
  const rows = pupils.map((number, i) =>
    h("li", {}, h("label", { class: "check" }, boxes[i], h("span", {}, nameOf(room, number)))),
  );
  const dialog = openDialog(
    room,
    "remove-many",
    say("class.removeMany"),
    h("label", { class: "check" }, all, h("span", {}, say("class.removeMany.all"))),
    h("ul", { class: "plain" }, ...rows),
    h("div", { class: "row" }, remove),
  );
}

/**
 * Hangs the wall and the controls over the whole screen, and back.
 * @param {Room} room @param {ReturnType<typeof createWall>} wall @param {HTMLElement} controls
 * @param {HTMLElement} place @param {HTMLElement} home
 */
function largeButton(room, wall, controls, place, home) {
  const { session, say } = room;
  return button(
    say("class.wholeScreen"),
    () => {
      const far = h("div", { class: "controls-place" });
      const back = controls.parentElement;
      const mark = controls.nextSibling;
      const dialog = openDialog(
        room,
        "wide",
        `${say("class.board")} \u00b7 ${session.entry?.code}`,
        far,
        home,
      );
      far.append(controls);
      wall.fill(() => {
        const { top, width } = wall.list.getBoundingClientRect();
        return { width, height: innerHeight - top - 20 };
      });
      dialog.addEventListener("close", () => {
        wall.fill(null);
        place.append(home);
        back?.insertBefore(controls, mark);
      });
    },
    { "data-class": "large" },
  );
}

/** @param {Room} room @param {HTMLElement} controls what stands on the whole screen as well */
export function mountBoard(room, controls) {
  const { session, say } = room;
  const bag = createBag();
  const wall = createWall(
    room,
    (number) => enlarge(room, number),
    () => show(),
  );
  const counts = h("p", { class: "counts", role: "status" });
  const nobody = h("p", { class: "quiet" }, say("class.nobody"));
  const sort = choice(
    say("class.sort"),
    SORTS.map((by) => ({ value: by, words: say(`class.sort.${by}`) })),
    "name",
    wall.sort,
  );
  const home = h("div", { class: "wall-place" });
  const place = h("section", { class: "board" });
  const large = largeButton(room, wall, controls, place, home);
  const many = button(say("class.removeMany"), () => removeMany(room), {
    "data-class": "removeMany",
  });
  const hide = (/** @type {boolean} */ on) => {
    room.anonymous = on;
    wall.rename();
  };
  const names = toggle(say("class.anonymous"), Boolean(room.anonymous), hide, {
    "data-class": "anonymous",
  });
  home.append(counts, h("div", { class: "row" }, sort.element, names), nobody, wall.list);
  place.append(h("h3", {}, say("class.board")), h("div", { class: "row" }, large, many), home);

  function show() {
    const cells = [...wall.cells.values()];
    nobody.hidden = cells.length > 0;
    many.hidden = cells.length < 2;
    const parts = STATES.map((state) => ({
      state,
      count: cells.filter((cell) => cell.state === state).length,
    }));
    const told = parts
      .filter(({ count }) => count)
      .map(({ state, count }) => say.count(`class.count.${state}`, count));
    const words = [say.count("class.pupils", cells.length), ...told].join(" \u00b7 ");
    if (counts.textContent !== words) counts.textContent = words;
  }
  bag(session.subscribe(show));
  bag(wall.end);
  show();
  return { place, destroy: bag.end };
}
