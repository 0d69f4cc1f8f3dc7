// The page without its server: kept by the browser, opened from a cold start, moved by the engine; a newer version is told and
// taken at the next load; where the browser keeps nothing the page goes on.

import assert from "node:assert/strict";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { ROOT, close, moving, startDaemon, told } from "./rig.mjs";
import { servePage } from "./serve.mjs";

const FILE = join(ROOT, "build/web/engine.wasm");
const FORGIVEN = /Failed to load resource|net::ERR|fetching the script/;
const there = () => existsSync(FILE) && statSync(FILE).size > 0;

/** All is kept, the words and worksheets of the language too: they are the last. */
const kept = async (page) => {
  await page.waitForFunction(() => window.pendulumd?.offline.kind === "kept" && navigator.serviceWorker.controller);
  await page.waitForFunction(async () => (await Promise.all(["text/LANGUAGE/class.js", "text/LANGUAGE/drawers.js", "sheets/period.json", "sheets/five.json"]
    .map((file) => caches.match(`${document.documentElement.dataset.page}/${file.replace("LANGUAGE", document.documentElement.lang)}`)))).every(Boolean));
};
const visit = async (rig, home, more = {}) => {
  const page = await rig.openAt(home, { cold: true, serviceWorkers: "allow", ...more });
  page.forgiven.push(FORGIVEN);
  return page;
};

/** What is kept: paths without a digest, by the names of the caches. */
const listed = (page) => page.evaluate(async () => Object.fromEntries(await Promise.all((await caches.keys()).map(async (name) => [name,
  (await (await caches.open(name)).keys()).map(({ url }) => url.slice(location.origin.length).replace(/^\/page\/\w+\//, ""))]))));

/** The help's words of what is kept. */
async function saidInHelp(page) {
  await page.click('[data-act="help"]');
  const words = await page.textContent("[data-offline]");
  await page.keyboard.press("Escape");
  return words;
}

export async function a_page_whose_server_has_ended_opens_and_swings_by_the_engine(rig) {
  if (!there()) return "there is no engine here";
  const daemon = await startDaemon();
  const page = await visit(rig, daemon.url, { language: "de" });
  await kept(page);
  const caches = Object.entries(await listed(page));
  assert.equal(caches.length, 1);
  assert.ok(caches[0][1].includes("/") && caches[0][1].includes("/?embed=1") && caches[0][1].includes("engine.wasm") && caches[0][1].includes("drawers/plots.js"));
  assert.deepEqual(caches[0][1].filter((path) => /v1|room|class\//.test(path)), [], "no answer of the interface, nothing of a class");
  await daemon.stop();
  // a cold start: another tab, at another address of the page
  const again = await page.context().newPage();
  await again.goto(`${daemon.url}/?length=1,1&theta=90,45`);
  await moving(again);
  await again.waitForFunction(() => pendulumd.clock.time > 0.2 && pendulumd.client.engine.ready);
  assert.deepEqual(await again.evaluate(() => pendulumd.store.get().pendulum.length), [1, 1]);
  await told(again, /Server antwortet nicht.*rechnet selbst/);
  await again.click('[data-tab="plots"]');
  await again.waitForSelector('[data-drawer="plots"] .chart-area');
  await again.click('[data-tab="presets"]');
  await again.click('[data-preset="octopus"]');
  await again.waitForFunction(() => pendulumd.motion.n === 17 && pendulumd.motion.complete);
  await rig.shot(again, "offline");
  // the embed view has a document of its own
  await again.goto(`${daemon.url}/?embed=1`);
  await moving(again);
  assert.equal(await again.evaluate(() => document.documentElement.dataset.embed), "");
  await close(page);
}

/** A page from the sources, in a version of its own, before a daemon of all. */
async function versioned(rig) {
  const front = await servePage(rig.daemon.url);
  Object.assign(front, { worker: true, home: "/page/one" });
  return front;
}

export async function a_newer_version_is_told_taken_at_the_next_load_and_the_old_one_erased(rig) {
  const front = await versioned(rig);
  const page = await visit(rig, front.url);
  await kept(page);
  assert.match(await saidInHelp(page), /works offline/);
  assert.deepEqual(Object.keys(await listed(page)), ["pendulumd / page/one"]);
  front.home = "/page/two";
  // another window takes it at once; this one is told
  const other = await page.context().newPage();
  await other.goto(front.url);
  await told(page, /newer version/);
  assert.equal(await other.evaluate(() => document.documentElement.dataset.page), "page/two");
  assert.equal(await other.isVisible(".notice"), false);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.page), "page/one");
  // a drawer of the old version comes although the server has it no more
  await page.click('[data-tab="method"]');
  await page.waitForSelector('[data-drawer="method"] select, [data-drawer="method"] input');
  await other.close();
  await page.click(".notice button");
  await page.waitForFunction(() => document.documentElement.dataset.page === "page/two" && window.pendulumd?.offline.kind === "kept");
  await page.waitForFunction(async () => (await caches.keys()).join() === "pendulumd / page/two");
  assert.equal(await page.isVisible(".notice"), false);
  await close(page);
  front.close();
}

export async function a_server_without_the_worker_ends_it(rig) {
  const front = await versioned(rig);
  const page = await visit(rig, front.url);
  await kept(page);
  front.worker = false;
  await page.reload();
  await page.waitForFunction(async () => !(await navigator.serviceWorker.getRegistration()) && !(await caches.keys()).length);
  await page.reload();
  await moving(page);
  assert.match(await saidInHelp(page), /cannot be opened offline/);
  await close(page);
  front.close();
}

export async function a_browser_that_has_no_room_for_the_page_goes_on_and_says_so(rig) {
  const front = await versioned(rig);
  // as a cache that refuses: one of its files does not come
  const refused = new Promise((resolve) => {
    front.fault = (asked, reply) => {
      if (!asked.url.endsWith("/drawers/plots.js")) return false;
      reply.writeHead(500).end(resolve);
      return true;
    };
  });
  const page = await visit(rig, front.url);
  await page.waitForFunction(() => pendulumd.motion.stats);
  await refused;
  await page.waitForFunction(() => pendulumd.offline.kind === "none");
  assert.match(await saidInHelp(page), /cannot be opened offline/);
  assert.deepEqual(Object.keys(await listed(page)).length <= 1, true);
  await page.evaluate(() => pendulumd.edits.setMass(2, 3));
  await moving(page);
  await close(page);
  front.close();
}

export async function the_page_can_be_installed(rig) {
  const daemon = rig.daemon.url;
  const html = await (await fetch(`${daemon}/`)).text();
  const address = new URL(/rel="manifest" href="([^"]+)"/.exec(html)[1], daemon);
  const reply = await fetch(address);
  assert.match(reply.headers.get("Content-Type"), /^application\/manifest\+json/);
  const manifest = await reply.json();
  const where = [manifest.start_url, manifest.scope].map((one) => new URL(one, address).pathname);
  assert.deepEqual([...where, manifest.display], ["/", "/", "standalone"]);
  // one would be read below the origin, not below where the page is: without, it is start_url
  assert.equal(manifest.id, undefined);
  for (const { src, sizes, type } of manifest.icons) {
    const bytes = Buffer.from(await (await fetch(new URL(src, address))).arrayBuffer());
    if (type === "image/png") assert.equal(`${bytes.readUInt32BE(16)}x${bytes.readUInt32BE(20)}`, sizes, src);
    else assert.match(bytes.toString(), /^<svg/);
  }
  const worker = await fetch(`${daemon}/sw.js`);
  assert.deepEqual(["Service-Worker-Allowed", "Cache-Control", "Content-Type"].map((name) => worker.headers.get(name)), ["/", "no-cache", "text/javascript; charset=utf-8"]);
  // what a browser finds missing, by its own word
  const page = await visit(rig, daemon);
  const { installabilityErrors } = await page.session.send("Page.getInstallabilityErrors");
  assert.deepEqual(installabilityErrors.filter(({ errorId }) => errorId !== "in-incognito"), []);
  await close(page);
}
