// The resonance curve: how far and how late an arm swings when the pivot is shaken or a joint is
// turned to and fro, over the frequency.
// Leaves to others: the modes (modes.js), the plot (plot.js).
// Invariant: amplitudes and phases are the server's, of small swings; where nothing damps a mode
// its peak has no top and is a gap.

import { said } from "../../client.js";
import { DEGREE } from "../../angles.js";
import { createBag, h } from "../../dom.js";
import { pendulumOf } from "../../terms.js";
import { aborted, choice, settled } from "../kit/kit.js";
import { createPlot } from "../kit/plot.js";

const COUNT = 600; // frequencies
const BEYOND = 1.3; // parts of the fastest mode
const TALL = 25; // medians: what is higher is cut off
const SMALL = 0.01; // m, that the pivot is shaken by

/** What a drive is in the request. @param {string} drive */
function driveOf(drive) {
  const [kind, arm] = drive.split(" ");
  if (kind === "joint") return { torque: { arm: Number(arm), amplitude: 1 } };
  if (kind === "cart") return { cart: { amplitude: 1 } };
  return { pivot: { [kind]: SMALL } };
}

/** The drives that there are. @param {Tree} tree @param {Text} text */
function drivesOf({ length, pivot }, text) {
  const moved = pivot?.cart ? ["cart"] : ["x", "y"];
  const joints = length.map((_, k) => ({
    value: `joint ${k + 1}`,
    words: text("resonance.joint", { arm: k + 1 }),
  }));
  return [...moved.map((value) => ({ value, words: text(`resonance.${value}`) })), ...joints];
}

/** Amplitudes in degrees, without what is too high to be seen. @param {(number | null)[]} list */
function seen(list) {
  const sizes = list.flatMap((one) => (one === null ? [] : [one])).sort((a, b) => a - b);
  const most = TALL * (sizes[Math.floor(sizes.length / 2)] || Infinity);
  return list.map((one) => (one === null || one > most ? null : one / DEGREE));
}

/** Phases in degrees, broken where they pass half a turn. @param {number[]} list */
const broken = (list) =>
  list.map((one, i) => (i && Math.abs(one - list[i - 1]) > Math.PI ? null : one / DEGREE));

/**
 * Asks for the curves of an arm and draws them.
 * @param {App} app @param {string} drive @param {number} arm @param {AbortSignal} signal
 * @param {ReturnType<typeof createPlot>[]} plots
 */
async function drawCurves({ store, client, text }, drive, arm, signal, [far, late]) {
  const pendulum = pendulumOf(store.get().pendulum);
  const ask = async (/** @type {object} */ more) => {
    const body = { pendulum, drive: driveOf(drive), ...more };
    return (await client.post("/v1/response", body, { signal })).json();
  };
  const { poles } = await ask({ omega: [1], poles: true });
  const fastest = Math.max(...poles.omega, 1e-3);
  const range = { start: fastest / COUNT, stop: BEYOND * fastest, count: COUNT };
  const { frequency, phi } = await ask({ omega: range });
  const column = (/** @type {any[][]} */ rows) => rows.map((row) => row[arm - 1]);
  const colour = `--arm-${((arm - 1) % 8) + 1}`;
  const x = text("resonance.frequency");
  const unit = /^[xy]$/.test(drive) ? "cm" : drive === "cart" ? "N" : "Nm";
  const sizes = [{ xs: frequency, ys: seen(column(phi.amplitude)), colour }];
  far.set({ x, y: text(`resonance.per.${unit}`), curves: sizes, low: 0 }, text("resonance.far"));
  const phases = [{ xs: frequency, ys: broken(column(phi.phase)), colour }];
  late.set({ x, y: "\u00b0", curves: phases }, text("resonance.late"));
}

/** The part of the drawer Modes, which is loaded when it is opened. @param {App} app */
export default async function mountResonance(app) {
  const { store, text, files } = app;
  await Promise.all([text.part("resonance"), files.style("drawers/kit/curves.css")]);
  const bag = createBag();
  const picks = h("div", { class: "fit-options" });
  const status = h("p", { class: "quiet", role: "status", "data-resonance": "status" });
  const [far, late] = [createPlot(text, 200), createPlot(text, 140)];
  let drive = "";
  let arm = 1;
  /** @type {AbortController | null} */
  let stop = null;

  async function draw() {
    stop?.abort();
    stop = new AbortController();
    try {
      await drawCurves(app, drive, arm, stop.signal, [far, late]);
      status.textContent = "";
    } catch (error) {
      if (!aborted(error)) status.textContent = said(error, text);
    }
  }

  function choose() {
    const { pendulum } = store.get();
    const drives = drivesOf(pendulum, text);
    if (!drives.some(({ value }) => value === drive)) drive = drives[0].value;
    arm = Math.min(arm, pendulum.length.length);
    const arms = pendulum.length.map((_, k) => ({ value: k + 1, words: String(k + 1) }));
    const what = choice(text("resonance.drive"), drives, drive, (value) => {
      drive = value;
      draw();
    });
    const whose = choice(text("modes.chartArm"), arms, arm, (value) => {
      arm = Number(value);
      draw();
    });
    what.select.dataset.resonance = "drive";
    whose.select.dataset.resonance = "arm";
    picks.replaceChildren(what.element, whose.element);
    draw();
  }

  const soon = settled(choose, 200);
  bag(soon.end);
  bag(store.subscribe((doc, before) => doc.pendulum !== before.pendulum && soon()));
  bag(() => stop?.abort());
  for (const plot of [far, late]) bag(plot.destroy);
  choose();
  const element = h("div", {});
  const title = (/** @type {string} */ words) => h("h4", {}, words);
  element.append(h("p", { class: "quiet" }, text("resonance.intro")), picks, status);
  element.append(title(text("resonance.far")), far.element);
  element.append(title(text("resonance.late")), late.element);
  return { element, destroy: bag.end };
}
