// Nothing is lost: every change is kept, reload, back and forward lead to what was there, with the browser's storage refused as
// well; readable links; the list of what was made here.

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, doc, drawn, moving, refuseStorage } from "./rig.mjs";

export const rig = { store: true, sources: false };

/** Waits until the tab's history has a length of the first arm. */
const kept = (page, length) => page.waitForFunction((meters) => history.state?.["pendulumd.entry"]?.scene.request.pendulum.length[0] === meters, length);
const lengthen = (page, length) => page.evaluate((meters) => pendulumd.edits.setLength(1, meters), length);
const has = (page, length) => page.waitForFunction((meters) => window.pendulumd?.motion.complete && pendulumd.store.get().pendulum.length[0] === meters, length);

async function a_reload_goes_on(page) {
  await lengthen(page, 1.7);
  await page.evaluate(() => { pendulumd.edits.setStart(2, "phi", 0.25); pendulumd.store.set({ view: { speed: 0.25, drawer: "physics" } }); });
  await page.waitForFunction(() => pendulumd.motion.complete);
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(3.25); });
  await kept(page, 1.7);
  const before = await doc(page);
  await page.reload();
  await moving(page);
  await page.waitForFunction(() => Math.abs(pendulumd.clock.time - 3.25) < 1e-9);
  const after = await doc(page);
  assert.deepEqual([after.pendulum, after.initial, after.span, after.view], [before.pendulum, before.initial, before.span, before.view]);
  assert.equal(await page.evaluate(() => pendulumd.clock.playing), false, "what stood still stands still");
  assert.equal(new URL(page.url()).hash, "");
}

export async function a_reload_leads_to_what_was_there(rig) {
  const page = await rig.open();
  await a_reload_goes_on(page);
  await close(page);
}

export async function a_reload_leads_there_with_storage_refused_too(rig) {
  const page = await rig.open({ cold: true, wait: false });
  await refuseStorage(page.context());
  await page.goto(rig.url);
  await moving(page);
  await a_reload_goes_on(page);
  await close(page);
}

export async function back_and_forward_lead_to_what_was_there(rig) {
  const page = await rig.open();
  await lengthen(page, 1.9);
  await page.waitForSelector('[data-preset="double"]:not([disabled])');
  await page.click('[data-preset="double"]');
  await page.waitForFunction(() => pendulumd.motion.n === 2 && pendulumd.motion.complete);
  await lengthen(page, 0.8);
  await page.goBack();
  await has(page, 1.9);
  assert.equal((await doc(page)).pendulum.length.length, 4);
  await page.goForward();
  await has(page, 0.8);
  await page.goBack();
  await has(page, 1.9);
  await close(page);
}

export async function edits_of_a_shared_link_are_the_pupil_s_own(rig) {
  const page = await rig.open({ path: "/?length=1,0.5&theta=90,45&mass=2" });
  const shared = await doc(page);
  assert.deepEqual([shared.pendulum.length, shared.pendulum.mass, shared.pendulum.parent], [[1, 0.5], [2, 2], [0, 1]]);
  assert.ok(Math.abs(shared.initial.phi[0]) < 1e-15 && Math.abs(shared.initial.phi[1] + Math.PI / 4) < 1e-15);
  const hash = await page.evaluate(async () => {
    const { store, client } = pendulumd;
    const { pendulum, initial, span } = store.get();
    const { id } = await client.storeScene({ request: { pendulum, initial, times: { stop: span.stop, step: span.step }, method: "taylor" } });
    return `#s=${id}`;
  });
  for (const link of [`/${hash}`, "/?length=1,0.5&theta=90,45&mass=2&lang=en"]) {
    await page.goto("about:blank");
    await page.goto(rig.url + link);
    await has(page, 1);
    await lengthen(page, 1.25);
    await kept(page, 1.25);
    assert.equal(new URL(page.url()).hash, "", "the address no longer names the shared scene");
    assert.equal(new URL(page.url()).searchParams.has("length"), false);
    assert.equal(new URL(page.url()).searchParams.get("lang"), link.includes("lang") ? "en" : null, "what else the address says stays");
    await page.reload();
    await has(page, 1.25);
    await page.goBack();
    await has(page, 1);
    assert.ok(page.url().endsWith(link), "back leads to the link as it was shared");
    await page.evaluate(() => { setTimeout(() => history.forward()); }); // Firefox tells of no load when it brings a page back
    await has(page, 1.25);
  }
  await close(page);
}

export async function a_readable_link_is_written_and_read(rig) {
  const page = await rig.open({ height: 1300 });
  await page.evaluate(() => pendulumd.edits.begin());
  await openDrawer(page, "share");
  await page.evaluate(() => pendulumd.store.set({ pendulum: { length: [1, 1], mass: [1, 0.5], parent: [0, 1], gravity: 1.62 }, initial: { phi: [0, -Math.PI / 4], phid: [0, 0] } }));
  await page.waitForFunction(() => document.querySelector("[data-link=plain]").value.endsWith("?length=1,1&mass=1,0.5&theta=90,45&gravity=1.62"));
  await rig.shot(page, "readable-link");
  const link = await page.inputValue("[data-link=plain]");
  const other = await rig.open({ path: link.slice(rig.url.length), cold: true });
  const { pendulum } = await doc(other);
  assert.deepEqual(pendulum, { length: [1, 1], mass: [1, 0.5], parent: [0, 1], gravity: 1.62 });
  await close(other);
  // one that is not sound is told, and the page goes on
  for (const bad of ["?length=1,x", "?length=1,1&parent=2,1", "?theta=45"]) {
    const odd = await rig.open({ path: `/${bad}` });
    await odd.waitForSelector(".notice:not([hidden])");
    assert.equal((await doc(odd)).pendulum.length.length, 1, bad);
    await close(odd);
  }
  await close(page);
}

export async function what_was_made_here_is_listed_and_can_be_forgotten(rig) {
  const page = await rig.open();
  await lengthen(page, 1.11);
  await page.evaluate(() => pendulumd.store.set({ title: "<b>Mine</b>" }, { label: "title" }));
  await kept(page, 1.11);
  await page.evaluate(() => pendulumd.edits.begin());
  await has(page, 1);
  await lengthen(page, 0.77);
  await kept(page, 0.77);
  const other = await page.context().newPage();
  await other.goto(rig.url);
  await other.waitForSelector("[data-yours]");
  assert.equal(await other.locator("[data-yours]").count(), 2);
  assert.match(await other.innerText(".yours"), /<b>Mine<\/b>/);
  await other.click("[data-yours] >> nth=1");
  await has(other, 1.11);
  await other.evaluate(() => { pendulumd.clock.pause(); });
  await drawn(other);
  await rig.shot(other, "yours");
  await other.click(".yours-card .icon-button >> nth=0");
  assert.equal(await other.locator("[data-yours]").count(), 1);
  await other.click("[data-act=forget]");
  assert.equal(await other.locator("[data-yours]").count(), 0);
  assert.equal(await other.evaluate(() => localStorage.getItem("pendulumd.yours")), "[]");
  await other.close();
  await close(page);
}
