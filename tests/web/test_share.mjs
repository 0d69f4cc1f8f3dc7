// Links: opened in another browser they show the same scene to the last pixel, whether the server keeps it or not.

import assert from "node:assert/strict";
import { openDrawer, pixels, saved, settledMotion } from "./drawers.mjs";
import { close, drawn, startDaemon } from "./rig.mjs";

export const rig = { store: true };

/** Another scene than the page begins with: other numbers, another method, a ghost, a view. */
const change = (page) => page.evaluate(() => {
  window.pendulumd.store.set({
    pendulum: { length: [1.1, 0.1 + 0.2, 0.7], mass: [1, 2 / 3, 0.5], parent: [0, 1, 1], gravity: 9.80665 },
    initial: { phi: [0.3, Math.PI / 7, -1], phid: [0, 1e-3, 0] }, span: { stop: 6, step: 0.02 },
    method: "rk8pd", rtol: 1e-7, atol: null, precision: "double", preset: null,
    ghosts: [{ phi: [0.3, 0.4, -1], phid: [0, 0, 0], apart: 1e-3 }],
    view: { trails: [2, 3], arrows: true, palette: "paper", speed: 0.5, loop: false, selected: 0 },
  });
});

/** The last picture of the motion, as its pixels. */
async function lastPixels(page) {
  await page.waitForFunction(() => window.pendulumd.motion.complete);
  await settledMotion(page);
  await page.waitForFunction(() => window.pendulumd.motion.stats);
  await page.evaluate(() => {
    window.pendulumd.clock.pause();
    window.pendulumd.clock.seek(window.pendulumd.clock.duration);
  });
  await drawn(page);
  return pixels(page);
}

const state = (page) => page.evaluate(() => {
  const { title, pendulum, initial, span, method, rtol, atol, precision, ghosts, view } = window.pendulumd.store.get();
  return { title, pendulum, initial, span, method, rtol, atol, precision, ghosts, view };
});

/** The link that holds all itself, once it is that of the scene as it is now. */
async function longLink(page) {
  const link = await page.evaluate(async () => {
    const { linkOf } = await import(new URL("link.js", document.querySelector("script[src$='early.js']").src));
    const doc = window.pendulumd.store.get();
    return linkOf({ ...doc, view: { ...doc.view, drawer: null } });
  });
  await page.waitForFunction((wanted) => document.querySelector("[data-link=long]").value.endsWith(wanted), link);
  return page.inputValue("[data-link=long]");
}

async function sameElsewhere(rig, page, link) {
  // the link shows the stage, without the drawer that it was made in
  await page.evaluate(() => window.pendulumd.store.set({ view: { drawer: null } }));
  assert.ok(link.startsWith(`${rig.url}/`), link);
  const other = await rig.open({ path: link.slice(rig.url.length) });
  await other.waitForFunction(() => window.pendulumd.store.get().method === "rk8pd");
  assert.deepEqual(await state(other), await state(page));
  const [here, there] = [await lastPixels(page), await lastPixels(other)];
  assert.ok(parseInt(here, 10) > 1000, "the picture is empty");
  assert.equal(there, here, "the pixels differ");
  const numbers = (at) => at.evaluate(() => [...window.pendulumd.motion.columns.phi.slice(-3)]);
  assert.deepEqual(await numbers(other), await numbers(page));
  await close(other);
}

export async function a_short_link_and_a_long_one_show_the_same_pixels_in_another_browser(rig) {
  const page = await rig.open();
  await change(page);
  await openDrawer(page, "share");
  await page.fill("[data-title]", "Ünter \u{1f600} “drei” <b>");
  await page.click("[data-share=make]");
  await page.waitForSelector("[data-link=short]", { state: "visible" });
  const short = await page.inputValue("[data-link=short]");
  assert.match(short, /\/#s=[0-9a-z]{20,}$/);
  await page.waitForFunction(() => document.querySelectorAll("[data-drawer=share] .link:not([hidden]) svg.qr").length === 3);
  await rig.shot(page, "share-links");
  await sameElsewhere(rig, page, short);
  await openDrawer(page, "share");
  const long = await longLink(page);
  assert.match(long, /\/\?title=%C3%9Cnter%20%F0%9F%98%80%20%E2%80%9Cdrei%E2%80%9D%20%3Cb%3E#d=/, "its title is read by people, and by sites that frame it");
  await sameElsewhere(rig, page, long);
  await openDrawer(page, "share");
  // a link that does not stand for what is shown goes away
  await page.evaluate(() => window.pendulumd.store.set({ rtol: 1e-6 }));
  await page.waitForSelector("[data-link=short]", { state: "hidden" });
  assert.match(await page.innerText("[data-drawer=share]"), /The scene has changed/);
  await close(page);
}

export async function a_server_without_a_store_says_so_and_the_long_link_works(rig) {
  const plain = await startDaemon(["--store", "none"]);
  const { front } = rig;
  const before = front.daemon;
  front.daemon = plain.url;
  try {
    const page = await rig.open();
    page.forgiven.push(/404/);
    await openDrawer(page, "share");
    await page.click("[data-share=make]");
    await page.waitForFunction(() => document.querySelector("[data-drawer=share]").innerText.includes("This server cannot make short links"));
    await page.waitForFunction(() => document.querySelector("[data-link=long]").value.includes("#d="));
    await close(page);
  } finally {
    front.daemon = before;
    await plain.stop();
  }
}

export async function who_chose_a_language_hands_it_on_in_links(rig) {
  const page = await rig.open({ language: "de" });
  await openDrawer(page, "share");
  const links = () => page.evaluate(() => ["plain", "long"].map((id) => document.querySelector(`[data-link=${id}]`).value));
  await page.waitForFunction(() => document.querySelector("[data-link=long]").value.includes("#d="));
  assert.ok((await links()).every((link) => !link.includes("lang=")), "what the browser prefers is not a choice");
  await page.selectOption(".tongue", "fr");
  await openDrawer(page, "share");
  await page.waitForFunction(() => document.querySelector("[data-link=long]")?.value.includes("&lang=fr#d="));
  const [plain] = await links();
  assert.match(plain, /\?length=[^#]*&lang=fr$/);
  await page.click("[data-share=make]");
  await page.waitForFunction(() => /\/\?lang=fr#s=/.test(document.querySelector("[data-link=short]").value));
  const other = await rig.open({ language: "en", path: plain.slice(rig.url.length) });
  await other.waitForFunction(() => document.documentElement.lang === "fr");
  assert.equal(await other.evaluate(() => pendulumd.store.get().pendulum.length.length), 4);
  for (const one of [page, other]) await close(one);
}

export async function the_scene_and_its_numbers_are_files(rig) {
  const page = await rig.open();
  await change(page);
  await settledMotion(page);
  await openDrawer(page, "share");
  const scene = JSON.parse((await saved(page, "[data-drawer=share] [data-save=json]")).bytes);
  assert.equal(scene.request.method, "rk8pd");
  assert.equal(scene.request.pendulum.length[1], 0.1 + 0.2);
  const csv = (await saved(page, "[data-drawer=share] [data-save=csv]")).bytes.toString().trimEnd().split("\n")
    .filter((line) => !line.startsWith("# ")); // words that may follow the numbers
  assert.equal(csv.length, 302);
  await close(page);
}
