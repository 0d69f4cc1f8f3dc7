// Worksheet: five steps that set the stage, ask a question, and see when it is done.
// Leaves to others: all that is done in a step is done with the stage and the other drawers.
// Invariant: a step is done when the page is in the state it asks for; what was done stays done (kept in the browser).

import { createBag, h } from "../dom.js";
import { keep as browser } from "../keep.js";
import { PAPER } from "../state.js";
import { still } from "../theme.js";
import { button } from "./kit.js";

const KEPT = "pendulumd.worksheet";
const HANGING = -Math.PI / 2;
const at = (...degrees) => ({
  phi: degrees.map((angle) => HANGING + (angle * Math.PI) / 180),
  phid: degrees.map(() => 0),
});
const chain = (...mass) => ({
  length: mass.map(() => 1),
  mass,
  parent: mass.map((_, k) => k),
  gravity: 9.81,
});
const span = { stop: 20, step: 0.01 };

const STEPS = [
  {
    id: "single",
    drawer: "modes",
    set: { pendulum: chain(1), initial: at(20), span },
    done: ({ doc }) =>
      doc.pendulum.length.length === 1 && Math.abs(doc.pendulum.length[0] - 4) < 0.2,
  },
  {
    id: "double",
    drawer: "plots",
    set: { pendulum: chain(1, 1), initial: at(90, 90), span },
    done: ({ doc }) =>
      doc.pendulum.mass.length === 2 &&
      doc.pendulum.mass[1] <= 0.1 * doc.pendulum.mass[0] * (1 + 1e-9),
  },
  {
    id: "chaos",
    drawer: "compare",
    set: { pendulum: chain(1, 1), initial: at(120, 120), span },
    done: ({ doc }) => doc.ghosts.some((ghost) => !ghost.method),
  },
  {
    id: "modes",
    drawer: "modes",
    set: { pendulum: chain(1, 1), initial: at(12, -4), span },
    done: ({ cause }) => cause?.label === "mode",
  },
  {
    id: "forces",
    drawer: "plots",
    set: { pendulum: PAPER.pendulum, initial: PAPER.initial, span },
    done: ({ doc, clock, motion }) =>
      doc.pendulum === PAPER.pendulum &&
      !clock.playing &&
      clock.time > 0 &&
      motion.count > 0 &&
      motion.at(clock.time).lambda.some((force) => force > 0),
  },
];

function readKept() {
  try {
    const { step = 0, done = [] } = JSON.parse(browser.get(KEPT)) ?? {};
    return {
      step: STEPS[step] ? step : 0,
      done: new Set(done.filter((id) => STEPS.some((one) => one.id === id))),
    };
  } catch {
    return { step: 0, done: new Set() };
  }
}

async function mount(element, app) {
  const { store, motion, clock, text } = app;
  const bag = createBag();
  const kept = readKept();
  const list = h("ol", { class: "steps" });
  const body = h("div", { class: "step" });
  const mark = h("p", { class: "mark", role: "status" });
  let staged = false; // whether the present step has set the stage

  const keep = () => browser.set(KEPT, JSON.stringify({ step: kept.step, done: [...kept.done] }));

  function stage() {
    const { set } = STEPS[kept.step];
    store.set(
      {
        ...set,
        title: "",
        preset: null,
        method: "taylor",
        rtol: null,
        atol: null,
        precision: "double",
        ghosts: [],
        view: { trails: [set.pendulum.length.length], selected: 0 },
      },
      { label: "worksheet" },
    );
    staged = true;
    if (!still.matches) clock.play();
  }

  function go(step, focus) {
    kept.step = Math.max(0, Math.min(STEPS.length - 1, step));
    keep();
    stage();
    show();
    if (focus) list.children[kept.step].firstChild.focus();
  }

  function showList() {
    list.replaceChildren(
      ...STEPS.map(({ id }, i) =>
        h(
          "li",
          {},
          h(
            "button",
            {
              type: "button",
              "data-step": i + 1,
              class: kept.done.has(id) ? "step-key done" : "step-key",
              "aria-current": i === kept.step ? "step" : null,
              on: { click: () => go(i, true) },
            },
            h(
              "span",
              { class: "step-number", "aria-hidden": "true" },
              kept.done.has(id) ? "\u2713" : String(i + 1),
            ),
            text(`worksheet.${id}.name`),
            kept.done.has(id)
              ? h("span", { class: "unseen" }, `, ${text("worksheet.done")}`)
              : null,
          ),
        ),
      ),
    );
  }

  function showMark() {
    const done = kept.done.has(STEPS[kept.step].id);
    mark.textContent = done ? `\u2713 ${text("worksheet.done")}` : text("worksheet.open");
    mark.classList.toggle("done", done);
  }

  function show() {
    const { id, drawer } = STEPS[kept.step];
    const words = (part) => text(`worksheet.${id}.${part}`);
    showList();
    showMark();
    const first = kept.step === 0;
    const last = kept.step === STEPS.length - 1;
    body.replaceChildren(
      h(
        "p",
        { class: "quiet" },
        text("worksheet.step", { step: kept.step + 1, count: STEPS.length }),
      ),
      h("h3", {}, words("title")),
      h("p", {}, words("text")),
      h(
        "div",
        { class: "row" },
        button(text("worksheet.stage"), stage, { class: "button main", "data-worksheet": "stage" }),
      ),
      h("h4", {}, text("worksheet.question")),
      h("p", {}, words("question")),
      h("h4", {}, text("worksheet.do")),
      h("p", {}, words("do")),
      h(
        "div",
        { class: "row" },
        button(
          text("worksheet.openDrawer", { drawer: text(`drawer.${drawer}`) }),
          () => store.set({ view: { drawer } }),
          { "data-worksheet": "open" },
        ),
      ),
      mark,
      h("details", {}, h("summary", {}, text("worksheet.answer")), h("p", {}, words("answer"))),
      h(
        "div",
        { class: "row ends" },
        button(text("worksheet.back"), () => go(kept.step - 1), {
          disabled: first,
          "data-worksheet": "back",
        }),
        button(text("worksheet.next"), () => go(kept.step + 1), {
          disabled: last,
          "data-worksheet": "next",
        }),
      ),
    );
  }

  /** Looks whether the present step is done now. */
  function look(cause = null) {
    const { id, done } = STEPS[kept.step];
    if (
      !staged ||
      kept.done.has(id) ||
      cause?.label === "worksheet" ||
      !done({ doc: store.get(), clock, motion, cause })
    )
      return;
    kept.done.add(id);
    keep();
    showList();
    showMark();
    app.announce(text("worksheet.said", { step: kept.step + 1 }));
  }

  bag.on(list, "keydown", (event) => {
    const move = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!move) return;
    event.preventDefault();
    event.stopPropagation();
    const keys = [...list.querySelectorAll("button")];
    keys[(keys.indexOf(document.activeElement) + move + keys.length) % keys.length].focus();
  });
  bag(store.subscribe((doc, before, cause) => look(cause)));
  let playing = clock.playing;
  bag(
    clock.subscribe(() => {
      // what it needs to stand still for
      if (clock.playing !== playing || !clock.playing) look();
      playing = clock.playing;
    }),
  );

  element.append(
    h("h2", {}, text("drawer.worksheet")),
    h("p", { class: "quiet" }, text("worksheet.intro")),
    h("nav", { "aria-label": text("worksheet.steps") }, list),
    body,
  );
  show();
  return {
    show() {},
    hide() {},
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}

export default { id: "worksheet", title: (text) => text("drawer.worksheet"), mount };
