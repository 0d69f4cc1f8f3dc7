// Links: what is on the screen opens in another browser, to the bit; damaged and hostile ones do no harm.

import assert from "node:assert/strict";
import { deflateRawSync } from "node:zlib";
import { pixels } from "./drawers.mjs";
import { close, drawn, moving } from "./rig.mjs";

export const rig = { store: true };

const linkOf = (scene) => `/#d=${deflateRawSync(Buffer.from(JSON.stringify(scene))).toString("base64url")}`;


/** Stands at the end of the motion with the last frame drawn. */
async function end(page) {
  await page.waitForFunction(() => pendulumd.motion.complete && pendulumd.motion.stats);
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(pendulumd.clock.duration); });
  await drawn(page);
}

/** Asks the page's own module for something of its document. */
const linking = (page, ask) => page.evaluate(async (name) => {
  const link = await import(new URL("link.js", document.querySelector("script[src$='early.js']").src));
  return link[name](pendulumd.store.get());
}, ask);

/** A pendulum that nobody else has, at its end. */
async function unusual(rig) {
  const page = await rig.open();
  await page.evaluate(() => {
    const { edits, store } = pendulumd;
    edits.add(3);
    edits.setStart(5, "phi", 0.123456789);
    edits.setLength(1, 1.7);
    store.set({ title: "For the class", span: { stop: 3, step: 0.01 }, view: { trails: [5, 4], arrows: true, palette: "paper", drawer: null } });
  });
  await end(page);
  return page;
}

async function sameInAnotherBrowser(rig, page, path, picture) {
  const other = await rig.open({ path });
  await end(other);
  const phi = (where) => where.evaluate(() => [...pendulumd.motion.columns.phi]);
  assert.deepEqual(await phi(other), await phi(page));
  assert.equal(await pixels(other), await pixels(page));
  assert.equal(await other.textContent(".title"), "For the class");
  await rig.shot(other, picture);
  await close(other);
}

export async function a_link_without_a_store_shows_the_same_pixels_in_another_browser(rig) {
  const page = await unusual(rig);
  await sameInAnotherBrowser(rig, page, `/${await linking(page, "linkOf")}`, "link");
  await close(page);
}

export async function a_stored_scene_shows_the_same_pixels_in_another_browser(rig) {
  const page = await unusual(rig);
  const scene = await linking(page, "sceneOf");
  const { id } = await page.evaluate((kept) => pendulumd.client.storeScene(kept), scene);
  assert.match(id, /^\w{20,}$/);
  await sameInAnotherBrowser(rig, page, `/#s=${id}`, "scene");
  await close(page);
}

export async function a_browser_that_cannot_compress_makes_links_that_all_can_read(rig) {
  const page = await rig.open({ cold: true });
  await page.addInitScript(() => { delete window.CompressionStream; delete window.DecompressionStream; });
  await page.reload();
  await page.waitForFunction(() => window.pendulumd?.motion.stats);
  await page.evaluate(() => pendulumd.edits.setMass(2, 3.25));
  await page.click('[data-tab="share"]');
  await page.waitForFunction(() => document.querySelector('[data-link="long"]')?.value.includes("#j="));
  await page.waitForFunction(() => pendulumd.motion.complete);
  const link = await linking(page, "linkOf");
  const other = await rig.open({ path: `/${link}` });
  assert.equal(await other.evaluate(() => pendulumd.store.get().pendulum.mass[1]), 3.25);
  await close(other);
  await close(page);
}

export async function a_scene_of_another_client_opens_whatever_its_form(rig) {
  const request = { pendulum: { arms: [{ name: "a", length: 1, mass: 2 }, { name: "b", parent: "a", length: 0.5, mass: 1 }] },
    initial: { theta: [90, 45], unit: "deg" }, times: { start: 0, stop: 4, count: 201 } };
  const page = await rig.open({ path: linkOf({ request }) });
  const { pendulum, initial, span } = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual([pendulum.length, pendulum.mass, pendulum.parent], [[1, 0.5], [2, 1], [0, 1]]);
  assert.ok(Math.abs(initial.phi[0]) < 1e-15 && Math.abs(initial.phi[1] + Math.PI / 4) < 1e-15);
  assert.deepEqual(span, { stop: 4, step: 0.004 });
  await close(page);
}

export async function links_that_are_damaged_or_hostile_do_no_harm(rig) {
  const tree = { length: [1, 1], mass: [1, 1], parent: [0, 1] };
  const start = { phi: [0, 0], phid: [0, 0] };
  const times = { start: 0, stop: 5, step: 0.01 };
  const bad = ["/#d=%%%", "/#d=AAAA", "/#s=nosuchscene0000000000", "/#j=AAAA", linkOf({}), linkOf([]),
    `/#d=${deflateRawSync(Buffer.alloc(64 << 20, " ")).toString("base64url")}`, // much from little
    linkOf({ request: null }),
    linkOf({ request: { pendulum: { ...tree, damping: [1] }, initial: start, times } }),
    linkOf({ request: { pendulum: { ...tree, body: [5, null] }, initial: start, times } }),
    linkOf({ request: { pendulum: { ...tree, pivot: { x: { harmonics: [null] } } }, initial: start, times } }),
    linkOf({ request: { pendulum: { ...tree, parent: [2, 1] }, initial: start, times } }),
    linkOf({ request: { pendulum: tree, initial: { phi: ["<b>", 0], phid: [0, 0] }, times } }),
    linkOf({ request: { pendulum: tree, initial: start, times: { start: 0, stop: 1e9, step: 1e-9 } } })];
  const first = await rig.open({ path: bad[0] });
  first.forgiven.push(/Failed to load resource/);
  for (const path of bad) {
    await first.evaluate((hash) => { location.hash = hash; }, path.slice(1));
    await first.waitForSelector(".notice.bad:not([hidden])");
    await moving(first);
    assert.equal(await first.evaluate(() => pendulumd.motion.n), 1, `${path}: the first pendulum stays`);
    await first.click(".notice button");
  }
  await close(first);
  const view = { drawer: "constructor", speed: "fast", trails: [1, 99, "x"], palette: "__proto__", selected: 7, ghosts: [{ phi: [1] }, 5] };
  const title = "<img src=x onerror=alert(1)>";
  const page = await rig.open({ path: linkOf({ title, request: { pendulum: tree, initial: start, times }, view }) });
  const doc = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual([doc.view.speed, doc.view.trails, doc.view.palette, doc.view.selected, doc.ghosts], [1, [1], "safe", 0, []]);
  assert.equal(await page.textContent(".title"), title);
  await moving(page);
  await close(page);
}

export async function what_a_readable_link_cannot_say_is_told(rig) {
  const page = await rig.open({ path: "/?length=1&teta=90&mass=2&mass=3&lang=en" });
  const told = () => page.textContent(".notice span");
  assert.match(await told(), /part of the link cannot be read: teta=90, mass=3$/);
  assert.equal(await page.evaluate(() => pendulumd.motion.n), 1, "what it does say is shown");
  for (const [search, part] of [["?length=1,1&theta=90,45,30", "theta=90,45,30"], ["?theta=90", "length"], ["?Length=1&Theta=90", "Length=1, Theta=90"],
    ["?length=1&gravity=9.81,3", "gravity=9.81,3"], ["?length=1,x", "length=1,x"], ["?length=1&parent=1", "length=1&parent=1"]]) {
    await page.goto(rig.url + "/" + search);
    await moving(page);
    assert.ok((await told()).endsWith(`cannot be read: ${part}`), `${search}: ${await told()}`);
  }
  await page.goto(rig.url + "/?length=1,2&utm_source=mail&fbclid=x1");
  await moving(page);
  assert.equal(await page.evaluate(() => pendulumd.motion.n), 2);
  assert.equal(await page.locator(".notice span").allTextContents().then(String), "", "what mail appends is nobody's fault");
  await close(page);
}
