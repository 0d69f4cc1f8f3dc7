// The embed view in another page's frame: the stage and the time bar, their state told and set; the rest is never framed.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { close } from "./rig.mjs";
import { checkStatement } from "./xapi.mjs";

export const rig = { sources: false };

/** A page of another origin with a frame of ours in it: {page, end()}. */
async function framing(rig, path) {
  const body = `<script>window.heard=[];addEventListener("message",(e)=>heard.push(e.data))</script><iframe src="${rig.url}${path}" width="700" height="480"></iframe>`;
  const host = createServer((_, reply) => reply.writeHead(200, { "Content-Type": "text/html" }).end(body));
  await new Promise((ready) => host.listen(0, "127.0.0.1", ready));
  const page = await rig.open({ cold: true, wait: false, path: "/docs" });
  page.forgiven.push(/^asked /, /frame-ancestors/, /Failed to load/);
  await page.goto(`http://127.0.0.1:${host.address().port}/`);
  return { page, end: async () => {
    await close(page);
    host.closeAllConnections();
    host.close();
  } };
}

export async function a_page_of_others_shows_the_stage_and_sets_it(rig) {
  const { page, end } = await framing(rig, "/?embed=1");
  await page.waitForFunction(() => window.heard.some((one) => one.pendulumd === "state"));
  const frame = page.frames()[1];
  await frame.waitForFunction(() => window.pendulumd?.motion.complete);
  assert.equal(await frame.locator("#drawers > *, #header > *").count(), 0, "the stage and the time bar alone");
  assert.ok(await frame.isVisible("#timebar button"));
  const scene = { request: { pendulum: { length: [1, 1], mass: [1, 1], parent: [0, 1] }, initial: { phi: [0.5, 0], phid: [0, 0] }, times: { start: 0, stop: 5, step: 0.01 } } };
  await page.evaluate((wanted) => { window.heard.length = 0; frames[0].postMessage({ pendulumd: "set", scene: wanted, time: 2, playing: false }, "*"); }, scene);
  await frame.waitForFunction(() => pendulumd.store.get().pendulum.length.length === 2 && !pendulumd.clock.playing && pendulumd.motion.complete && pendulumd.clock.time === 2);
  await page.evaluate(() => { window.heard.length = 0; frames[0].postMessage({ pendulumd: "get" }, "*"); });
  await page.waitForFunction(() => window.heard.some((one) => one.time === 2 && one.scene.request.pendulum.length.length === 2));
  await page.evaluate(() => { window.heard.length = 0; frames[0].postMessage({ pendulumd: "set", scene: { request: { pendulum: { length: [1], mass: [1], parent: [7] }, times: { stop: 1 } } } }, "*"); });
  await page.waitForFunction(() => window.heard.some((one) => one.pendulumd === "refused"));
  assert.match(await frame.getAttribute(".embed-link", "href"), /^\.\/#[dj]=/);
  await rig.shot(page, "embed");
  await end();
}

export async function nothing_but_the_embed_view_is_framed(rig) {
  const { page, end } = await framing(rig, "/");
  await page.waitForTimeout(1000);
  assert.equal(await page.frames()[1].evaluate(() => document.getElementById("stage")).catch(() => null), null);
  await end();
}

export async function a_worksheet_in_a_frame_tells_its_answers_as_statements(rig) {
  const { page, end } = await framing(rig, "/?embed=1&sheet=period");
  await page.waitForFunction(() => window.heard.some((one) => one.pendulumd === "state"));
  const frame = page.frames()[1];
  for (const [value, choice] of [["2.0"], ["4"], [null, 2], [null, 1], ["4.95"]]) {
    await frame.waitForSelector(value ? "#embed-sheet [data-answer]" : "#embed-sheet [data-choice]");
    const step = await frame.textContent(".step h3");
    if (value) await frame.fill("#embed-sheet [data-answer]", value);
    else await frame.click(`#embed-sheet [data-choice='${choice}']`);
    await frame.click("[data-sheet=answer]");
    await frame.waitForFunction((title) => document.querySelector(".step h3").textContent !== title || /Handed in/.test(document.querySelector(".sheet .mark").textContent), step);
  }
  await page.waitForFunction(() => window.heard.some((one) => /completed$/.test(one.statement?.verb.id)));
  await rig.shot(page, "embed-sheet");
  const bar = await frame.locator("#timebar").boundingBox();
  const held = await page.locator("iframe").boundingBox();
  assert.ok(bar.height > 20 && Math.abs(bar.y + bar.height - held.y - held.height) < 6, "the time bar ends the frame, however long the worksheet is");
  const told = await page.evaluate(() => heard.filter((one) => one.pendulumd === "statement").map(({ statement }) => statement));
  told.forEach(checkStatement);
  assert.equal(told.filter(({ verb }) => verb.id.endsWith("/answered")).length, 5, "one of each step");
  assert.equal(new Set(told.map(({ id }) => id)).size, 6);
  assert.equal(new Set(told.map(({ actor }) => actor.account.name)).size, 1);
  const last = told[told.length - 1];
  assert.deepEqual(last.result, { completion: true, score: { scaled: 1, raw: 5, min: 0, max: 5 } });
  assert.deepEqual([told[0].object.definition.interactionType, told[0].result], ["numeric", { response: "2", success: true }]);
  await end();
}
