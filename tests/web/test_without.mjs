// A page without one of its modules, its style sheet or the browser's storage: it says so in words and goes on.
// Leaves to others: a server in trouble, files that come at a second try (test_trouble.mjs).

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, refuseStorage } from "./rig.mjs";

const FORGIVEN = /Failed to load resource|net::ERR|cannot be made|did not come/;

/** A first visit; answer(path) is what stands for a file: a script's text, "" for a refusal, null for the file itself. */
async function visit(rig, answer, options = {}) {
  rig.front.bundles = false; // each module by itself
  rig.front.fault = (asked, reply) => {
    const text = answer(new URL(asked.url, "http://page").pathname);
    if (text === null) return false;
    if (text) reply.writeHead(200, { "Content-Type": "text/javascript; charset=utf-8" }).end(text);
    else reply.writeHead(500).end();
    return true;
  };
  const page = await rig.open({ wait: false, cold: true, ...options });
  page.forgiven.push(FORGIVEN);
  return page;
}

/** The module's file by another text. */
const broken = (file, name) => (path) =>
  path.endsWith(`/${file}`) ? `export function ${name}() { throw new Error("cannot be made"); }` : null;

const swings = (page) => page.waitForFunction(() => window.pendulumd?.clock.time > 0 && pendulumd.motion.complete);

const told = (page, words) =>
  page.waitForFunction((source) => {
    const bubble = document.querySelector(".notice");
    return bubble && !bubble.hidden && new RegExp(source).test(bubble.textContent);
  }, words.source);

export async function a_view_that_cannot_be_made_says_so_in_its_place_and_the_others_go_on(rig) {
  const page = await visit(rig, broken("timebar.js", "mountTimebar"));
  await swings(page);
  assert.match(await page.innerText("#timebar"), /part of the page could not be built/);
  assert.equal(await page.locator("#waiting").count(), 0);
  await openDrawer(page, "method");
  await rig.shot(page, "without_timebar");
  // another language builds all views anew
  await page.selectOption(".tongue", "de");
  await page.waitForFunction(() => /Ein Teil der Seite/.test(document.getElementById("timebar").innerText));
  await close(page);
}

export async function a_page_without_its_stage_has_its_words_and_its_drawers(rig) {
  const page = await visit(rig, broken("stage.js", "mountStage"));
  await swings(page);
  assert.match(await page.innerText("#stage"), /part of the page could not be built/);
  await openDrawer(page, "plots");
  await page.waitForSelector('[data-drawer="plots"] .chart-area');
  await close(page);
}

export async function a_part_of_the_stage_that_cannot_be_made_is_told_and_the_stage_goes_on(rig) {
  const page = await visit(rig, broken("legend.js", "mountLegend"));
  await swings(page);
  await told(page, /part of the page could not be built/);
  const before = await page.evaluate(() => pendulumd.stage.tip(4));
  await page.waitForFunction((was) => pendulumd.stage.tip(4).x !== was.x, before);
  await page.evaluate(() => pendulumd.edits.select(2));
  await page.waitForSelector(".card:not([hidden])");
  await rig.shot(page, "without_legend");
  await close(page);
}

export async function a_drawer_whose_module_does_not_come_says_so_and_the_others_come(rig) {
  const page = await visit(rig, (path) => (path.endsWith("/drawers/modes.js") ? "" : null));
  await swings(page);
  await page.click('[data-tab="modes"]');
  await page.waitForSelector('[data-again="modes"]');
  assert.match(await page.innerText('[data-drawer="modes"]'), /could not be loaded/);
  await rig.shot(page, "without_modes");
  await openDrawer(page, "method");
  rig.front.fault = null;
  await openDrawer(page, "modes");
  await page.waitForSelector('[data-drawer="modes"] .mode-card');
  await close(page);
}

export async function a_page_whose_style_never_comes_says_so_and_swings(rig) {
  const page = await visit(rig, (path) => (path.endsWith(".css") ? "" : null));
  await swings(page);
  await told(page, /style sheet could not be loaded/);
  const tall = () => page.evaluate(() => document.querySelector(".canvas").getBoundingClientRect().height);
  const before = await tall();
  await page.evaluate(() => new Promise((resolve) => { setTimeout(resolve, 300); }));
  const after = await tall();
  assert.ok(before > 100 && before < 2000 && after === before, `the stage is ${before}, then ${after} pixels high`);
  await rig.shot(page, "without_style");
  await close(page);
}

export async function a_browser_that_keeps_nothing_is_told_and_the_page_goes_on(rig) {
  const page = await rig.open({ cold: true });
  await refuseStorage(page);
  await page.reload();
  await swings(page);
  await told(page, /stores nothing/);
  await rig.shot(page, "without_storage");
  await page.click(".notice button");
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function storage_that_is_full_is_told_too(rig) {
  const page = await rig.open({ cold: true });
  await page.addInitScript(() => {
    Storage.prototype.setItem = () => { throw new DOMException("full", "QuotaExceededError"); };
  });
  await page.evaluate(() => localStorage.clear());
  await page.reload();
  await swings(page);
  await told(page, /stores nothing/);
  await close(page);
}

export async function the_reference_without_style_or_storage_says_what_it_has(rig) {
  const page = await visit(rig, (path) => (path.endsWith(".css") ? "" : null), { path: "/docs" });
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
  await page.waitForFunction(() => /style sheet of this page did not come/.test(document.body.innerText));
  rig.front.fault = null;
  await refuseStorage(page);
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
  await page.click('.tools button');
  assert.ok(await page.locator(".doc-operation").count() > 5);
  assert.match(await page.innerText("body"), /stores nothing/);
  await rig.shot(page, "docs_without_storage");
  await close(page);
}

/** The document up to its first place, and the rest when it is let go. */
async function heldDocument(rig) {
  const html = await (await fetch(`${rig.url}/`)).text();
  const cut = html.indexOf('<header id="header">');
  assert.ok(cut > 0);
  let rest = null;
  rig.front.fault = (asked, reply) => {
    if (asked.url !== "/") return false;
    reply.writeHead(200, { "Content-Type": "text/html; charset=utf-8" });
    reply.write(html.slice(0, cut));
    rest = () => reply.end(html.slice(cut));
    return true;
  };
  return () => rest();
}

export async function a_script_that_runs_before_the_document_is_whole_waits_for_its_places(rig) {
  const page = await rig.open();
  const goOn = await heldDocument(rig);
  await page.goto(`${rig.url}/`, { waitUntil: "commit" });
  await page.waitForFunction(() => "begun" in document.documentElement.dataset && window.pendulumd);
  assert.equal(await page.evaluate(() => document.getElementById("header")), null);
  goOn();
  await page.waitForSelector("#header .title");
  await page.waitForSelector("#stage canvas");
  await page.waitForFunction(() => window.pendulumd.clock.time > 0 && !document.getElementById("waiting"));
  await close(page);
}
