// Real pendulums on the stage: bars, springs, friction and drives come in by links and examples, and what is seen is what
// the server computes.

import assert from "node:assert/strict";
import { deflateRawSync } from "node:zlib";
import { violations } from "./axe.mjs";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { close, drawn, moving } from "./rig.mjs";

const linkOf = (scene) => `/#d=${deflateRawSync(JSON.stringify(scene)).toString("base64url")}`;

/** A pendulum with a term of every kind, drawn in places that only the terms explain. */
const EVERYTHING = {
  length: [1, 0.5, 0.6], mass: [0.5, 0, 0.2], parent: [0, 1, 1], gravity: 1.62,
  rod: [null, 0.3, null], body: [{ mass: 0.4, center: [-0.2, 0.1], inertia: 0.01 }, null, null], at: [null, [0.4, 0.3], -0.2],
  damping: [0.05, null, 0.01], stiffness: [null, 0.8, null], rest: [null, 0.5, null], friction: [null, null, { torque: 0.01, speed: 0.1 }],
  torque: [null, { constant: 0.1, harmonics: [{ amplitude: 0.3, omega: 3, phase: 1 }] }, null], drag: [null, null, { linear: 0.02, quadratic: 0.1 }],
  drag_per_mass: 0.01, pivot: { x: { harmonics: [{ amplitude: 0.1, omega: 5, phase: 0.2 }] }, y: { harmonics: [{ amplitude: 0.05, omega: 9 }] } },
};
const REQUEST = { pendulum: EVERYTHING, initial: { phi: [-1, 0.2, -2], phid: [0, 1, 0] }, times: { start: 1.5, stop: 5.5, step: 0.01 } };

/** What the page has drawn at a time, in metres, and what the server says of the same instant. */
async function tipsAt(page, time) {
  await page.evaluate((t) => { pendulumd.clock.pause(); pendulumd.clock.seek(t); }, time);
  await drawn(page);
  return page.evaluate(async () => {
    const { stage, store, clock, client, motion } = pendulumd;
    const doc = store.get();
    const { z } = await client.trajectory({ pendulum: doc.pendulum, initial: doc.initial, output: ["z"],
      times: [doc.span.start ?? 0, (doc.span.start ?? 0) + clock.time] });
    const last = z.re.length - 1;
    const pixels = z.re[last].map((_, k) => stage.tip(k + 1));
    return { pixels, z: z.re[last].map((x, k) => ({ x, y: z.im[last][k] })), t: motion.t[1] };
  });
}

/** The largest difference in metres between what is drawn and z, the scale being that of two tips. */
function apart({ pixels, z }) {
  const far = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);
  const scale = far(pixels[0], pixels[1]) / far(z[0], z[1]);
  return Math.max(...z.map((tip, k) => Math.hypot((pixels[k].x - pixels[0].x) / scale - (tip.x - z[0].x), -(pixels[k].y - pixels[0].y) / scale - (tip.y - z[0].y))));
}

export async function a_link_with_every_term_opens_as_what_it_is_and_the_stage_shows_its_motion(rig) {
  const page = await rig.open({ path: linkOf({ request: REQUEST }) });
  const { pendulum, span } = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual([pendulum, span], [EVERYTHING, { start: 1.5, stop: 4, step: 0.01 }]);
  for (const time of [0.01, 2]) {
    const seen = await tipsAt(page, time);
    const off = apart(seen);
    assert.ok(off < 1e-9, `at ${time} s the tips are ${off} m from where the server has them`);
    assert.ok(Math.abs(seen.t - 0.01) < 1e-12, "samples are counted from the start");
  }
  assert.equal(await page.textContent(".now"), "3.50 /", "the time bar shows the request's own time");
  const again = await page.evaluate(async () => {
    const link = await import(new URL("link.js", document.querySelector("script[src$='early.js']").src));
    return link.linkOf(pendulumd.store.get());
  });
  const other = await rig.open({ path: `/${again}` });
  const parts = (seen) => seen.evaluate(() => {
    const { pendulum: tree, initial, span: when, method } = pendulumd.store.get();
    return { tree, initial, when, method };
  });
  assert.deepEqual(await parts(other), await parts(page));
  await close(other);
  await close(page);
}

export async function a_scene_by_arms_keeps_its_terms(rig) {
  const request = { pendulum: { arms: [{ name: "a", length: 1, rod: 2, damping: 0.1 }, { parent: "a", length: 0.5, mass: 1, at: 0.5, torque: 0.2 }], drag_per_mass: 0.1,
    pivot: { acceleration: [1, 0] } }, initial: { theta: [90, 45], unit: "deg" }, times: { stop: 4, step: 0.01 } };
  const page = await rig.open({ path: linkOf({ request }) });
  const { pendulum } = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual([pendulum.rod, pendulum.damping, pendulum.at, pendulum.torque], [[2, null], [0.1, null], [null, 0.5], [null, 0.2]]);
  assert.deepEqual([pendulum.drag_per_mass, pendulum.pivot.acceleration, pendulum.mass], [0.1, [1, 0], [0, 1]]);
  await close(page);
}

/** The pivot is drawn where the server has the cart. */
async function cartMoves(page) {
  const { x, scale, cart, arm } = await page.evaluate(() => {
    const { stage, clock, motion, store } = pendulumd;
    const [from, to] = [stage.tip(0), stage.tip(1)];
    return { x: from.x, scale: Math.hypot(to.x - from.x, to.y - from.y), cart: motion.at(clock.time).cart, arm: store.get().pendulum.length[0] };
  });
  await page.evaluate(() => pendulumd.clock.seek(0));
  await drawn(page);
  const rest = await page.evaluate(() => pendulumd.stage.tip(0).x);
  assert.ok(Math.abs(cart) > 1e-3 && Math.abs((x - rest) * (arm / scale) - cart) < 1e-9, `the cart is at ${cart} m`);
}

export async function a_link_with_a_cart_opens_with_its_place_and_speed(rig) {
  const request = { pendulum: { length: [1, 0.5], mass: [1, 0.5], parent: [0, 0], pivot: { cart: { mass: 2, angle: 0.3, stiffness: 5, damping: 0.4 } } },
    initial: { phi: [-1, -2.5], phid: [0, 0], cart: { x: 0.2, v: -0.5 } }, times: { start: 0, stop: 5, step: 0.01 } };
  const page = await rig.open({ path: linkOf({ request }) });
  assert.deepEqual((await page.evaluate(() => pendulumd.store.get())).initial, request.initial);
  const off = apart(await tipsAt(page, 2.5));
  assert.ok(off < 1e-9, `the tips are ${off} m from where the server has them`);
  await rig.shot(page, "real-cart");
  await page.evaluate(() => { pendulumd.live.change("gravity", (tree) => ({ ...tree, gravity: 1.62 })); });
  await page.waitForFunction(() => pendulumd.motion.doc.pendulum.gravity === 1.62 && pendulumd.motion.complete);
  const { initial } = await page.evaluate(() => pendulumd.store.get());
  assert.ok(Math.abs(initial.cart.x) > 1e-3 && initial.cart.x !== 0.2, "it goes on from where the cart is");
  await close(page);
  const arms = { arms: [{ length: 1, mass: 1 }], pivot: { cart: { mass: 2 } } };
  const other = await rig.open({ path: linkOf({ request: { pendulum: arms, initial: { theta: [40], unit: "deg", cart: { x: 0.1 } }, times: { stop: 5, step: 0.01 } } }) });
  const opened = await other.evaluate(() => pendulumd.store.get());
  assert.deepEqual([opened.initial.cart, opened.pendulum.pivot.cart.mass], [{ x: 0.1, v: 0 }, 2]);
  await close(other);
}

export async function every_real_example_moves_on_the_stage_as_the_server_has_it(rig) {
  const page = await rig.open();
  await page.waitForSelector('[data-preset="laboratory-double"]');
  for (const name of ["kapitza", "double-bars", "driven-damped", "coupled", "laboratory-double", "metronome-cart"]) {
    await page.click(`[data-preset="${name}"]`);
    await page.waitForFunction((which) => pendulumd.store.get().preset === which && pendulumd.motion.complete && pendulumd.motion.doc === pendulumd.store.get(), name);
    const seen = await tipsAt(page, 1.7);
    if (name === "metronome-cart") await cartMoves(page);
    if (seen.z.length > 1) assert.ok(apart(seen) < 1e-7, `${name}: ${apart(seen)} m off`);
    await rig.shot(page, `real-${name}`);
  }
  await close(page);
}

export async function arms_come_and_go_with_their_terms(rig) {
  const page = await rig.open({ path: linkOf({ request: REQUEST }) });
  await page.evaluate(() => pendulumd.edits.remove(2));
  let { pendulum } = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual([pendulum.rod, pendulum.stiffness, pendulum.torque], [undefined, undefined, undefined], "what no arm has is not there");
  assert.deepEqual([pendulum.at, pendulum.damping], [[null, -0.2], [0.05, 0.01]]);
  await page.evaluate(() => pendulumd.edits.add(2));
  ({ pendulum } = await page.evaluate(() => pendulumd.store.get()));
  assert.deepEqual([pendulum.at, pendulum.damping, pendulum.mass], [[null, -0.2, null], [0.05, 0.01, 0.01], [0.5, 0.2, 0.2]]);
  await moving(page);
  assert.equal(await page.evaluate(() => pendulumd.motion.failure), null);
  await close(page);
}

export async function modes_of_a_real_pendulum_are_told_with_their_damping_swing_and_are_begun(rig) {
  const pendulum = { length: [1, 0.5], mass: [1, 0], parent: [0, 1], gravity: 9.81, rod: [null, 0.4], damping: [0.6, 0.05], stiffness: [null, 2], rest: [null, 0.5] };
  const page = await rig.open({ height: 1000, path: linkOf({ request: { pendulum, initial: { phi: [-1, -1], phid: [0, 0] }, times: { start: 0, stop: 5, step: 0.01 } } }) });
  await openDrawer(page, "modes");
  await page.waitForSelector('[data-drawer="modes"] [data-mode="2"]');
  const told = await page.evaluate((tree) => pendulumd.client.modes({ pendulum: tree }), pendulum);
  const shown = await page.locator('[data-drawer="modes"] .mode-card').evaluateAll((cards) => cards.map((card) => [...card.querySelectorAll("dd")].map((cell) => parseFloat(cell.textContent))));
  const numbers = told.mode.map((_, k) => [told.omega[k], told.frequency[k], 1 / told.frequency[k], told.decay[k], told.damping_ratio[k]]);
  assert.ok(told.decay.every((decay) => decay > 0) && shown.length === 2);
  shown.forEach((row, k) => row.forEach((value, i) => assert.ok(Math.abs(value - numbers[k][i]) <= 6e-4 * Math.max(1, numbers[k][i]), `${value} for ${numbers[k][i]}`)));
  const rest = await page.textContent('[data-drawer="modes"] [role=status]');
  told.equilibrium.forEach((phi) => assert.ok(rest.includes(`${(phi * 180 / Math.PI + 90).toFixed(1).replace("-", "\u2212")}°`), rest));
  await page.evaluate(() => pendulumd.clock.pause());
  const picture = async (time) => {
    await page.evaluate((at) => pendulumd.clock.seek(at), time);
    await drawn(page);
    return page.evaluate(() => document.querySelector("[data-mode='1'] canvas").toDataURL());
  };
  assert.notEqual(await picture(0), await picture(1 / told.frequency[0]), "after a swing it is smaller");
  assert.deepEqual(await violations(page, { context: { include: ['[data-drawer="modes"]'] } }), []);
  await rig.shot(page, "real-modes");
  // the motion that begins in a mode turns and dies away as the server's root says
  for (const mode of [1, 2]) {
    await page.locator(`[data-amplitude='${mode}']`).fill("1");
    await page.click(`[data-start='${mode}']`);
    await settledMotion(page);
    const far = await page.evaluate(([{ equilibrium, omega, decay, vectors: { re, im } }, k]) => {
      const { columns, t } = pendulumd.motion;
      const part = Math.PI / 180;
      let [most, least] = [0, Infinity];
      t.forEach((time, i) => equilibrium.forEach((phi, arm) => {
        const size = part * Math.exp(-decay[k] * time);
        const there = phi + size * (re[k][arm] * Math.cos(omega[k] * time) - im[k][arm] * Math.sin(omega[k] * time));
        most = Math.max(most, Math.abs(columns.phi[i * 2 + arm] - there));
        least = Math.min(least, size);
      }));
      return [most / part, least / part];
    }, [told, mode - 1]);
    assert.ok(far[0] < 0.02 && far[0] > 1e-7 && far[1] < 0.7, `mode ${mode}: ${far[0]} of its amplitude beside the linear motion`);
  }
  await close(page);
}
