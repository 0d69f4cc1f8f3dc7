// Scenes as a class hands them about: what is on the stage as one, one onto the stage, and the
// starts of a release.
// Leaves to others: reading scenes (link.js), who hands them to whom.
// Invariant: what another browser wrote is shown only where it is sound, and opens no drawer.

import { readScene, sceneOf } from "../link.js";
import { request } from "../state.js";
import { still } from "../screen.js";

export const HANGING = -Math.PI / 2;
export const DEGREE = Math.PI / 180;

/** The pendulum and start on the stage, without the view. @param {Doc} doc @returns {ClassScene} */
export const bareScene = (doc) => ({ request: request(doc) });

/** What is on the stage, as it is seen there. @param {Doc} doc @returns {ClassScene} */
export function wholeScene(doc) {
  const { request: body, view } = sceneOf({ ...doc, view: { ...doc.view, drawer: null } });
  return { request: body, view };
}

/** A short name of a scene: two that differ have different ones. @param {unknown} scene */
export function keyOf(scene) {
  let [a, b] = [0x811c9dc5, 0x1000193];
  for (const letter of JSON.stringify(scene)) {
    a = Math.imul(a ^ (letter.codePointAt(0) ?? 0), 0x01000193);
    b = Math.imul(b ^ (letter.codePointAt(0) ?? 0), 0x5bd1e995) ^ (b >>> 15);
  }
  return `${(a >>> 0).toString(36)}-${(b >>> 0).toString(36)}`;
}

/**
 * Puts a scene on the stage; false where this page cannot show it.
 * @param {App} app @param {ClassScene} scene @param {boolean} moves whether it swings at once
 */
export async function stageScene(app, scene, moves = true) {
  let patch;
  try {
    patch = await readScene(scene, app.client);
  } catch (error) {
    if (/** @type {Failed} */ (error).kind === "away") throw error;
    app.complain(app.text("failure.link"));
    return false;
  }
  const view = { ...patch.view, drawer: app.store.get().view.drawer };
  app.store.set({ ...patch, view }, { label: "open" });
  app.clock.restart();
  if (moves && !still.matches) app.clock.play();
  else app.clock.pause();
  return true;
}

/** The scene at rest, all arms hanging. @param {ClassScene} scene @returns {ClassScene} */
export function hanging(scene) {
  const phid = scene.request.pendulum.length.map(() => 0);
  const initial = { phi: phid.map(() => HANGING), phid };
  return { ...scene, request: { ...scene.request, initial } };
}

/**
 * The scene with its first arm turned by so much, in rad.
 * @param {ClassScene} scene @param {number} by @returns {ClassScene}
 */
export function turned(scene, by) {
  const { initial } = scene.request;
  const phi = initial.phi.map((/** @type {number} */ angle, /** @type {number} */ k) =>
    k === 0 ? angle + by : angle,
  );
  return { ...scene, request: { ...scene.request, initial: { ...initial, phi } } };
}

/** An angle from hanging, in (-180, 180] degrees. @param {number} phi */
export function fromHanging(phi) {
  const turn = (phi - HANGING) / (2 * Math.PI);
  return -360 * (Math.ceil(turn - 0.5) - turn);
}
