// The engine in the browser: asked first, so that nothing goes over the network while a hand moves; alone where no server answers;
// missed in silence where it does not come.

import assert from "node:assert/strict";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { close, drawn, moving, ROOT } from "./rig.mjs";

const FILE = join(ROOT, "build/web/engine.wasm");
const FORGIVEN = /Failed to load resource|net::ERR/;
const there = () => existsSync(FILE) && statSync(FILE).size > 0;

/** A page with an engine, that is ready unless `fault` keeps it away; asked() lists what the server is asked since. */
async function withEngine(rig, fault = null) {
  const asked = [];
  rig.front.engine = true;
  rig.front.fault = (request, reply) => {
    if (request.url.startsWith("/v1/")) asked.push(request.url);
    return fault?.(request, reply) ?? false;
  };
  const page = await rig.open({ width: 800, cold: true });
  if (!fault) await page.waitForFunction(() => pendulumd.client.engine.ready);
  await page.waitForFunction(() => pendulumd.motion.stats);
  asked.length = 0;
  return { page, asked };
}

/** Ends what withEngine has begun. */
async function end(rig, page) {
  rig.front.engine = false;
  await close(page);
}

export async function a_class_does_not_fetch_the_engine_at_once(rig) {
  rig.front.engine = true;
  const page = await rig.open({ path: "/docs", cold: true, wait: false });
  page.forgiven.push(FORGIVEN);
  await page.addInitScript(() => { Math.random = () => Number(new URLSearchParams(location.search).get("utm_chance")); });
  for (const [search, comes] of [["?room=PK7TRA&utm_chance=0.5", false], ["?room=PK7TRA&utm_chance=0", true], ["?utm_chance=0.5", true]]) {
    await page.goto(`${rig.url}/${search}`);
    await moving(page);
    if (comes) await page.waitForFunction(() => pendulumd.client.engine.ready);
    else await page.waitForTimeout(4000);
    assert.equal(await page.evaluate(() => performance.getEntriesByType("resource").some(({ name }) => name.includes("engine"))), comes, search);
  }
  await end(rig, page);
}

export async function a_pendulum_that_is_dragged_asks_no_server(rig) {
  if (!there()) return "there is no engine here";
  const { page, asked } = await withEngine(rig);
  await page.evaluate(() => {
    pendulumd.clock.pause();
    pendulumd.clock.seek(0);
  });
  await drawn(page);
  const { x, y } = await page.evaluate(() => {
    const box = document.querySelector("#stage canvas").getBoundingClientRect();
    const tip = pendulumd.stage.tip(4);
    return { x: box.x + tip.x, y: box.y + tip.y };
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(x - 6 * i, y - 4 * i);
  await page.waitForFunction(() => pendulumd.motion.held && pendulumd.motion.track.preview);
  await page.mouse.up();
  await moving(page);
  await page.waitForFunction(() => pendulumd.motion.stats);
  assert.deepEqual(asked, [], "the server is asked nothing");
  assert.ok(await page.evaluate(() => Number.isFinite(pendulumd.motion.stats.energy_drift)));
  await end(rig, page);
}

export async function the_engine_gives_the_motion_that_the_server_gives(rig) {
  if (!there()) return "there is no engine here";
  const { page } = await withEngine(rig);
  const apart = await page.evaluate(async () => {
    const { pendulum, initial } = pendulumd.store.get();
    const body = JSON.stringify({ pendulum, initial, times: { start: 0, stop: 1, step: 0.01 }, output: ["phi", "lambda"] });
    const headers = { "Content-Type": "application/json", Accept: "application/octet-stream" };
    const options = { method: "POST", headers, body };
    const replies = [await pendulumd.client.engine.answer("/v1/trajectories", options, false), await fetch("/v1/trajectories", options)];
    if (replies[0].headers.get("X-Columns") !== replies[1].headers.get("X-Columns")) return "columns";
    const [here, far] = (await Promise.all(replies.map((reply) => reply.arrayBuffer()))).map((bytes) => new Float64Array(bytes));
    return here.length === far.length ? Math.max(...here.map((x, i) => Math.abs(x - far[i]))) : "length";
  });
  // the server computes with every instruction of its processor
  assert.ok(apart >= 0 && apart < 1e-9, `they are ${apart} apart`);
  await end(rig, page);
}

export async function without_a_server_a_long_motion_is_computed_in_the_browser(rig) {
  if (!there()) return "there is no engine here";
  const { page } = await withEngine(rig);
  page.forgiven.push(FORGIVEN);
  rig.front.fault = (request, reply) => {
    if (!request.url.startsWith("/v1/")) return false;
    reply.destroy();
    return true;
  };
  // what the server computes while it is there: its method is not the engine's first choice
  await page.evaluate(() => pendulumd.store.set({ method: "ode23" }, { label: "method" }));
  await moving(page);
  assert.equal(await page.evaluate(() => pendulumd.motion.count), await page.evaluate(() => pendulumd.motion.total));
  await end(rig, page);
}

export async function an_engine_that_does_not_come_is_not_missed(rig) {
  const gone = (request, reply) => {
    if (!request.url.endsWith("engine.wasm")) return false;
    reply.writeHead(404).end();
    return true;
  };
  const { page, asked } = await withEngine(rig, gone);
  page.forgiven.push(FORGIVEN);
  await page.evaluate(() => pendulumd.edits.setMass(2, 3));
  await moving(page);
  assert.ok(asked.includes("/v1/trajectories"), "the server is asked");
  assert.equal(await page.evaluate(() => pendulumd.client.engine.ready), false);
  await end(rig, page);
}

export async function a_frame_that_is_refused_a_worker_is_not_troubled(rig) {
  const page = await rig.open();
  await page.addInitScript(() => { window.Worker = class { constructor() { throw new DOMException("refused", "SecurityError"); } }; });
  await page.goto(rig.url);
  await moving(page);
  await page.evaluate(() => pendulumd.client.engine.begin().then(() => pendulumd.edits.setMass(2, 3)));
  await moving(page);
  assert.deepEqual(await page.locator(".notice").evaluateAll((list) => list.map((one) => one.hidden)), [true]);
  await page.context().close();
}
