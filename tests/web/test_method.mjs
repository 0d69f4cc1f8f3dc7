// The method: what it took, how far it is from a reference, and the paper's ode23 beside it.

import assert from "node:assert/strict";
import { bodiesOf } from "./bidi.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

/** Short enough for doubles: after 15 s or so no method can follow this motion without more digits. */
async function opened(rig) {
  const page = await rig.open({ height: 1100 });
  await page.evaluate(() => window.pendulumd.store.set({ span: { stop: 8, step: 0.01 } }));
  await openDrawer(page, "method");
  await page.waitForSelector(".verdict");
  return page;
}

const fact = (page, name) => page.innerText(`[data-fact=${name}] td`);

export async function ode23_goes_wrong_where_the_page_says_and_a_tolerance_mends_it(rig) {
  const page = await opened(rig);
  assert.match(await page.innerText(".verdict"), /^taylor: error never above/, "the finest method is called wrong");
  await page.selectOption("[data-method]", "ode23");
  await page.waitForSelector(".verdict.wrong");
  const [, coarse] = /^ode23: error above 0\.1 rad after ([\d.]+) s/.exec(await page.innerText(".verdict"));
  const stats = await page.evaluate(async () => {
    const { pendulum, initial, span } = window.pendulumd.store.get();
    return (await window.pendulumd.client.trajectory({ pendulum, initial, times: { stop: span.stop, count: 2 }, method: "ode23" })).stats;
  });
  await page.waitForFunction(() => /^\d+$/.test(document.querySelector("[data-fact=steps] td").innerText));
  assert.equal(Number(await fact(page, "steps")), stats.steps);
  assert.equal(Number(await fact(page, "rejected")), stats.rejected);
  assert.ok(coarse > 1 && coarse < 6, `wrong from ${coarse} s on`);
  await page.selectOption("[data-rtol]", "1e-8");
  await page.selectOption("[data-atol]", "1e-9");
  await page.waitForFunction(() => /^ode23: error never above/.test(document.querySelector(".verdict")?.innerText ?? ""));
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().rtol), 1e-8);
  await close(page);
}

export async function the_paper_s_ode23_lies_over_the_motion_and_is_accounted_for(rig) {
  const page = await opened(rig);
  await page.check("[data-overlay]");
  await page.waitForFunction(() => document.querySelectorAll(".verdict").length === 2 && document.querySelectorAll("[data-fact=steps] td").length === 2);
  await page.waitForFunction(() => /^\d+$/.test(document.querySelectorAll("[data-fact=steps] td")[1].innerText));
  assert.equal(await page.locator(".verdict.wrong").count(), 1);
  const apart = await page.evaluate(() => {
    const { motion } = window.pendulumd;
    return motion.columns.phi.reduce((most, phi, i) => Math.max(most, Math.abs(phi - motion.ghosts[0].columns.phi[i])), 0);
  });
  assert.ok(apart > 1, `ode23 is ${apart} rad away`);
  await drawn(page);
  await rig.shot(page, "method-overlay");
  await page.uncheck("[data-overlay]");
  await page.waitForFunction(() => document.querySelectorAll(".verdict").length === 1);
  await close(page);
}

export async function the_page_asks_for_as_many_digits_as_were_chosen(rig) {
  const page = await opened(rig);
  const asked = bodiesOf(page, (request) => request.method() === "POST" && request.url().endsWith("/v1/trajectories"));
  await page.evaluate(() => window.pendulumd.store.set({ span: { stop: 2, step: 0.05 } }));
  assert.deepEqual(await page.locator("[data-precision] option").evaluateAll((all) => all.map(({ value }) => value)), ["double", "extended"]);
  await page.selectOption("[data-precision]", "extended");
  await page.waitForFunction(() => /^\d+$/.test(document.querySelector("[data-fact=steps] td")?.innerText ?? "") && document.querySelector(".verdict"));
  await page.waitForFunction(() => window.pendulumd.motion.complete && window.pendulumd.motion.doc.precision === "extended");
  assert.ok(asked.some((body) => body.precision === "extended" && body.output.includes("phi")), `no motion of 32 digits: ${JSON.stringify(asked)}`);
  assert.match(await page.innerText(".verdict"), /^taylor: error never above/);
  await page.selectOption("[data-precision]", "double");
  assert.equal(await page.evaluate(() => window.pendulumd.store.get().precision), "double");
  await close(page);
}
