// The reference page as the daemon serves it: all of the document is there, examples run, it is found, linked, read aloud.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { close, drawn } from "./rig.mjs";

export const rig = { sources: false, store: true };

async function open(rig, more = {}) {
  const page = await rig.open({ path: "/docs", wait: false, ...more });
  await page.waitForSelector("html[data-ready]");
  return page;
}

const documentOf = async (rig) => (await fetch(`${rig.daemon.url}/openapi.json`)).json();

const operations = (api) => Object.entries(api.paths).flatMap(([path, item]) =>
  Object.entries(item).filter(([, one]) => one.operationId).map(([method, operation]) => ({ path, method, operation })));

/** Every name of a property, and every word of a list, in a schema and below. */
function* words(schema) {
  if (Array.isArray(schema)) for (const one of schema) yield* words(one);
  if (!schema || typeof schema !== "object" || Array.isArray(schema)) return;
  // a field that is false is one that another form has
  if (schema.properties && typeof schema.properties === "object")
    for (const [name, one] of Object.entries(schema.properties)) if (one !== false) yield name;
  if (Array.isArray(schema.enum)) yield* schema.enum.map(String);
  for (const [key, one] of Object.entries(schema)) if (!["example", "examples", "default", "enum"].includes(key)) yield* words(one);
}

export async function the_reference_has_every_route_field_limit_status_and_media_type(rig) {
  const page = await open(rig);
  const api = await documentOf(rig);
  const texts = await page.$$eval('article[id], [id^="schema-"]', (all) => Object.fromEntries(all.map(({ id, textContent }) => [id, textContent])));
  for (const { path, operation } of operations(api)) {
    const text = texts[operation.operationId];
    assert.ok(text.includes(path) && text.includes(operation.summary), path);
    for (const status of Object.keys(operation.responses)) assert.ok(text.includes(status), `${path} lacks ${status}`);
    for (const response of Object.values(operation.responses))
      for (const type of Object.keys(response.content ?? {})) assert.ok(text.includes(type), `${path} lacks ${type}`);
  }
  let count = 0;
  for (const [name, schema] of Object.entries(api.components.schemas)) {
    const text = texts[`schema-${name}`];
    for (const word of new Set(words(schema))) {
      count++;
      assert.ok(text.includes(word), `${name} lacks ${word}`);
    }
  }
  assert.ok(count > 150, `${count} words`);
  const all = await page.evaluate(() => document.body.textContent);
  const limits = api.info.description.match(/`max-[a-z-]+`/g);
  assert.ok(limits.length > 15 && limits.every((limit) => all.includes(limit.slice(1, -1))));
  const broken = await page.$$eval('a[href^="#"]', (links) => links.map((link) => link.getAttribute("href").slice(1)).filter((id) => !document.getElementById(id)));
  assert.deepEqual(broken, []);
  await rig.shot(page, "docs");
  await close(page);
}

export async function the_guides_stand_before_the_reference_with_their_programs(rig) {
  const page = await open(rig);
  const guides = await page.$$eval('[id^="guide-"]', (all) => all.map(({ id, textContent }) => ({ id, text: textContent, code: document.querySelectorAll(`#${id} pre`).length })));
  assert.ok(guides.length >= 9 && guides.every(({ code }) => code > 0), JSON.stringify(guides.map(({ id, code }) => [id, code])));
  assert.match(guides.find(({ id }) => id === "guide-motions").text, /Differentiate it/);
  assert.ok(!guides.some(({ text }) => /```|\]\(/.test(text)), "marks of Markdown are shown");
  const contents = await page.$$eval("#contents h2", (all) => all.map((one) => one.textContent));
  assert.equal(contents[0], "Guides");
  await close(page);
}

export async function every_example_runs_and_shows_what_came_back(rig) {
  const page = await open(rig);
  const api = await documentOf(rig);
  let ran = 0;
  for (const { path, method, operation } of operations(api)) {
    if (/\{(digest|id|code)\}/.test(path) && !path.startsWith("/v1/scenes")) continue; // no such id or code is known
    if (path.startsWith("/v1/clients")) continue; // whoever asks without a token is nobody
    const entry = page.locator(`article[id="${operation.operationId}"]`);
    await entry.locator("button:text-is('Run')").click();
    const status = entry.locator(".doc-status");
    await status.waitFor();
    const text = await status.textContent();
    const right = method === "delete" ? /^204 / : method === "post" && ["/v1/scenes", "/v1/classes"].includes(path) ? /^201 / : /^200 /;
    assert.match(text, right, `${method} ${path}: ${text}`);
    if (method !== "delete") await entry.locator(".doc-headers summary").click();
    if (method !== "delete") assert.match(await entry.locator(".doc-headers dl").textContent(), /content-type/);
    ran++;
  }
  assert.ok(ran > 12, `${ran} examples`);
  await page.locator('article:has(.doc-route code:text-is("/v1/trees"))').scrollIntoViewIfNeeded();
  await rig.shot(page, "docs-example");
  await close(page);
}

export async function an_example_that_is_spoilt_shows_the_problem(rig) {
  const page = await open(rig);
  const entry = page.locator('article:has(.doc-route code:text-is("/v1/trees"))');
  const field = entry.locator("textarea");
  await field.fill('{"pendulum": {"length": [1], "mass": [-1], "parent": [0]}}');
  await entry.locator("button:text-is('Run')").click();
  await entry.locator(".doc-status.bad").waitFor();
  assert.match(await entry.locator(".doc-answer pre").textContent(), /\/pendulum\/mass\/0/);
  page.forgiven.push(/422/);
  await close(page);
}

export async function a_search_leaves_what_has_the_words_and_escape_brings_all_back(rig) {
  const page = await open(rig);
  await page.keyboard.press("/");
  await page.keyboard.type("flip_time");
  const shown = () => page.$$eval("#content > article", (all) => all.filter((one) => !one.hidden).map((one) => one.id));
  const found = await shown();
  assert.ok(found.length > 0 && found.length < 4, found.join());
  assert.match(await page.locator(".doc-found").textContent(), /^\d+ places?$/);
  await rig.shot(page, "docs-search");
  await page.keyboard.press("Escape");
  assert.ok((await shown()).length > 15);
  await close(page);
}

export async function a_link_to_an_anchor_opens_there(rig) {
  const page = await open(rig, { path: "/docs#schema-Times" });
  const box = await page.locator("#schema-Times").boundingBox();
  assert.ok(box.y >= 0 && box.y < 400, `at ${box.y}`);
  await page.locator('#contents a[href="#getPreset"]').click();
  await page.waitForFunction(() => Math.abs(document.getElementById("getPreset").getBoundingClientRect().top - 56) < 20);
  await close(page);
}

export async function the_reference_can_be_read_in_the_dark_on_a_phone_and_by_keyboard(rig) {
  const page = await open(rig);
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.textContent), "To the text");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement.id), "content");
  const looks = [["dark", 1280, 800], ["phone", 390, 844], ["phone-dark", 390, 844], ["wide", 1920, 1080]];
  for (const [name, width, height] of looks) {
    await page.emulateMedia({ colorScheme: name.includes("dark") ? "dark" : "light" });
    await page.setViewportSize({ width, height });
    const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(over <= 0, `${name} is ${over} px too wide`);
    await page.evaluate(() => scrollTo(0, 0));
    await rig.shot(page, `docs-${name}`);
    await page.locator("article .doc-example").nth(1).scrollIntoViewIfNeeded();
    await rig.shot(page, `docs-${name}-example`);
  }
  await close(page);
}

export async function axe_finds_nothing_in_the_reference(rig) {
  const page = await open(rig, { bypassCSP: true });
  await page.locator('article:has(.doc-route code:text-is("/v1/trees"))').locator("button:text-is('Run')").click();
  await page.locator(".doc-answer pre").waitFor();
  // every kind of thing is in these, and open there
  const part = { include: ["header", "nav", "#content > :nth-child(-n+5)", "article:has(.doc-answer pre)", "[id='schema-Times']"].map((one) => [one]) };
  await page.evaluate((places) => places.flatMap((one) => [...document.querySelectorAll(`${one} details`)]).forEach((one) => { one.open = true; }), part.include.flat());
  assert.deepEqual(await violations(page, { shapes: true }), []);
  assert.deepEqual(await violations(page, { context: part, colours: true }), []);
  const paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  await page.emulateMedia({ colorScheme: "dark" });
  await page.waitForFunction((light) => getComputedStyle(document.body).backgroundColor !== light, paper);
  await drawn(page);
  assert.deepEqual(await violations(page, { context: part, colours: true }), []);
  await close(page);
}

export async function a_server_that_is_away_is_said(rig) {
  const page = await rig.open({ path: "/healthz", wait: false });
  await page.route("**/openapi.json", (route) => route.abort());
  await page.goto(`${rig.url}/docs`);
  await page.getByRole("alert").waitFor();
  await page.unroute("**/openapi.json");
  await page.getByRole("button", { name: "Try again" }).click();
  await page.waitForSelector("article");
  page.forgiven.push(/Failed to load resource/, /favicon/);
  await close(page);
}
