// What the browser tests stand on: a daemon, the page before it, a browser, and pages that notice every error.
// Leaves to others: what is tested (test_*.mjs), counting (run.mjs).
// Invariant: a page that writes an error on its console or asks another host fails its test; what was started is ended.

import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { IN_FIREFOX, launchFirefox, withoutProtocol } from "./bidi.mjs";
import { bundlesAreNew, servePage } from "./serve.mjs";

export const ROOT = fileURLToPath(new URL("../../", import.meta.url));
/** require() of the packages in package.json, which lie in build/ (tests/rules/web.sh fetches them). */
export const fetched = createRequire(join(ROOT, "build/webtest/package.json"));
const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const PROGRAM = process.env.PENDULUMD ?? join(ROOT, "build/release/pendulumd");
const PICTURES = join(ROOT, "build/check/web");
/** The address of the paper's four arms, with which pages open unless a test names another. */
export const PAPER = "/?example=paper-four-arms";
const FRAME_MS = 60; // a test's page is drawn no more often
const BENCH = process.argv.includes("--bench"); // what is measured is drawn as often as it can be
const TIMEOUT_MS = 180000; // for what a browser does at once: the machine may be slow, and busy with others
// a daemon that gives up on nobody because time passes
const PATIENT = ["--max-wait-seconds", "3600", "--header-seconds", "3600", "--body-seconds", "3600", "--send-seconds", "3600", "--idle-seconds", "86400",
  "--max-classes", "2000"]; // a tenth of them for one address
export const CHROMIUM_ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--font-render-hinting=none"];

/** A daemon: {url, stop(signal)}; options are added to its command line; port: 0 for a free one. */
export async function startDaemon(options = ["--store", "none"], port = 0) {
  const child = spawn(PROGRAM, ["--listen", `127.0.0.1:${port}`, ...PATIENT, ...options], {
    stdio: ["ignore", "ignore", "pipe"], env: { PENDULUMD_ALLOW_ROOT: "on", ...process.env },
  });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  const url = await new Promise((resolve, reject) => {
    let said = "";
    child.on("error", reject);
    child.on("exit", (code) => reject(new Error(`the daemon ended with ${code}: ${said}`)));
    child.stderr.on("data", (piece) => {
      said = (said + piece).slice(-4000);
      const found = /listening on (http:\S+)/.exec(said);
      if (found) resolve(found[1]);
    });
  });
  return {
    url,
    async stop(signal = "SIGTERM") {
      child.kill(signal);
      await gone;
    },
  };
}

/** A PostgreSQL of its own: {url, restart(), crash(), stop()}; null where it is not installed. */
export async function startPostgres() {
  const child = spawn("/usr/bin/python3", ["-B", join(ROOT, "tests/drill/store.py")], { stdio: ["pipe", "pipe", "pipe"] });
  let said = "";
  child.stderr.on("data", (piece) => { said += piece; });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  const line = () => new Promise((resolve) => {
    child.stdout.once("data", (piece) => resolve(String(piece).trim()));
    gone.then(() => resolve(""));
  });
  const url = await line();
  if (!url && said.includes("is not installed")) return null;
  if (!url) throw new Error(`PostgreSQL did not start: ${said}`);
  const told = async (word) => {
    child.stdin.write(`${word}\n`);
    if (await line() !== "back") throw new Error(`PostgreSQL did not come back: ${said}`);
  };
  return {
    url, restart: () => told("restart"), crash: () => told("crash"),
    async stop() {
      child.stdin.end();
      await gone;
    },
  };
}

/** nginx as it is shipped before a daemon: {url, stop()}; null where nginx is not installed. */
export async function startNginx(daemon) {
  const child = spawn("/usr/bin/python3", ["-B", join(ROOT, "tests/rules/front.py"), new URL(daemon.url).port], { stdio: ["pipe", "pipe", "pipe"] });
  let said = "";
  child.stderr.on("data", (piece) => { said += piece; });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  const port = await new Promise((resolve) => {
    child.stdout.once("data", (piece) => resolve(Number(piece)));
    gone.then(() => resolve(0));
  });
  if (!port && said.includes("is not installed")) return null;
  if (!port) throw new Error(`nginx did not start: ${said}`);
  return {
    url: `http://127.0.0.1:${port}`,
    async stop() {
      child.stdin.end();
      await gone;
    },
  };
}

const bundled = bundlesAreNew();

/** Whether this daemon serves the page itself. */
async function servesPage(url) {
  const reply = await fetch(`${url}/`);
  return reply.ok && (reply.headers.get("Content-Type") ?? "").startsWith("text/html");
}

const shared = new Map(); // what all rigs use together, by name: promises of {..., stop()}

function share(name, make) {
  if (!shared.has(name)) shared.set(name, make());
  return shared.get(name);
}

const chromium = () => fetched("playwright-core").chromium.launch({ executablePath: CHROMIUM, args: CHROMIUM_ARGUMENTS, timeout: TIMEOUT_MS });
const sharedBrowser = (wants) => share(IN_FIREFOX ? `browser ${wants.dark} ${wants.still}` : "browser", async () => {
  const browser = await (IN_FIREFOX ? launchFirefox(fetched("playwright-core"), wants) : chromium());
  return { browser, stop: () => browser.close() };
});

/** One daemon that keeps scenes, in a file that goes with it, and one that does not. */
const sharedDaemon = (store) => share(`daemon ${store}`, async () => {
  if (!store) return startDaemon();
  const home = mkdtempSync(join(tmpdir(), "pendulumd-web-"));
  const daemon = await startDaemon(["--store", `sqlite:${join(home, "store")}`]);
  const stop = async () => {
    await daemon.stop();
    rmSync(home, { recursive: true, force: true });
  };
  return { ...daemon, stop };
});

/** Ends what the rigs have shared. */
export async function endShared() {
  for (const one of shared.values()) await (await one).stop();
}

/** Frames no more often than every so many milliseconds: a pendulum that swings beside what is tested is half of the work. */
function seldom(least) {
  const native = window.requestAnimationFrame.bind(window);
  let [waiting, due, asked, last, id] = [new Map(), new Map(), false, 0, 0];
  const run = (now) => {
    [asked, last, due, waiting] = [false, performance.now(), waiting, new Map()];
    // one that throws ends no other, as a browser has it
    for (const [key, fn] of due) if (due.has(key)) try { fn(now); } catch (error) { reportError(error); }
  };
  window.requestAnimationFrame = (fn) => {
    waiting.set(++id, fn);
    if (!asked) {
      asked = true;
      const rest = last + least - performance.now();
      if (rest > 4) setTimeout(() => native(run), rest);
      else native(run);
    }
    return id;
  };
  window.cancelAnimationFrame = (key) => waiting.delete(key) || due.delete(key);
}

const unused = new Map(); // pages that tests have left, empty, by what cannot be changed of them

/** A page that nobody uses, of a browser of its own (a context). A window takes long to make, so it is used again. */
async function emptyPage(options, cold) {
  const key = cold ? null : JSON.stringify(options);
  const page = unused.get(key)?.pop() ?? await newPage(options, key);
  Object.assign(page, { faults: [], forgiven: [], asked: [] });
  return page;
}

async function newPage({ frames, wants, ...options }, key) {
  const { browser } = await sharedBrowser(wants);
  if (IN_FIREFOX) for (const name of ["isMobile", "permissions"]) delete options[name]; // a narrow window; a click permits what it asks for
  const context = await browser.newContext(options);
  context.setDefaultTimeout(TIMEOUT_MS);
  if (!frames) await context.addInitScript(seldom, FRAME_MS);
  const page = await context.newPage();
  page.key = key;
  if (IN_FIREFOX) withoutProtocol(page);
  else page.session = await context.newCDPSession(page);
  page.on("console", (message) => message.type() === "error" && page.faults.push(message.text()));
  page.on("pageerror", (error) => page.faults.push(String(error)));
  page.on("request", (asked) => {
    const { origin, protocol } = new URL(asked.url());
    page.asked?.push(asked);
    if (protocol.startsWith("http") && origin !== page.home) page.faults.push(`asked ${asked.url()}`);
  });
  return page;
}

/** As one who wants these colours and this motion, and has kept nothing here; a Firefox is begun so. */
async function wishFor(page, home, { dark, still }) {
  if (IN_FIREFOX) return;
  await page.emulateMedia({ colorScheme: dark ? "dark" : "light", reducedMotion: still ? "reduce" : "no-preference" });
  await page.session.send("Storage.clearDataForOrigin", { origin: home, storageTypes: "local_storage" });
}

/**
 * A page as a browser opens it that has never been here (its cache may hold the page's files, unless `cold`); it is not kept for
 * a time without a server unless serviceWorkers is "allow". It is drawn as on a slow machine, unless `frames`.
 * page.faults lists what went wrong; what fits the patterns in page.forgiven is not held against it. page.asked lists its requests.
 */
async function openPage(home, used, { path = PAPER, width = 1280, height = 800, dark = false, still = false, touch = false, language = "en", wait = true, cold = false, ...more } = {}) {
  const page = await emptyPage({ hasTouch: touch, locale: language, serviceWorkers: "block", frames: BENCH, wants: IN_FIREFOX ? { dark, still } : {}, ...more }, cold || IN_FIREFOX);
  page.home = home;
  page.used = used.add(page);
  await page.setViewportSize({ width, height });
  await wishFor(page, home, { dark, still });
  await page.goto(home + path);
  if (wait) await moving(page);
  return page;
}

/**
 * {url, daemon, front, open(options), openAt(home, options), shot(page, name), clear(), close()}; the browser and the daemons are every rig's.
 *
 * store    true: scenes are kept.
 * sources  true: the page comes from server/web through serve.mjs, whose `fault` can stand in for a server in trouble;
 *          false: from the daemon, if that serves it.
 *          Its scripts are bundled, where the build has made that; `front.bundles = false` before a page is opened serves each
 *          module by itself, until the test ends.
 */
export async function createRig({ store = false, sources = true } = {}) {
  const daemon = await sharedDaemon(store);
  const own = !sources && await servesPage(daemon.url);
  const front = own ? null : await servePage(daemon.url, 0, bundled);
  const url = own ? daemon.url : front.url;
  mkdirSync(PICTURES, { recursive: true });

  const used = new Set(); // the pages that a test has

  return {
    url, daemon, front,
    open: (options) => openPage(url, used, options),
    /** A page at another address of the same daemon. */
    openAt: (home, options) => openPage(home, used, options),
    shot: (page, name, more = {}) => page.screenshot({ path: join(PICTURES, `${name}.png`), ...more }),
    /** Closes what a test has left open, and ends the trouble that it made. */
    async clear() {
      if (front) Object.assign(front, { fault: null, bundles: bundled });
      for (const page of used) await page.context().close();
      used.clear();
    },
    close: () => front?.close(),
  };
}

/** The document that the page shows. */
export const doc = (page) => page.evaluate(() => pendulumd.store.get());

/** Stands at the start. */
export const pause = (page) => page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });

/** Waits for words in the notice. */
export const told = (page, words) => page.waitForFunction((source) => new RegExp(source).test(document.querySelector(".notice:not([hidden])")?.textContent ?? ""), words.source);

/** From the next load on the browser keeps nothing for the page, or for all of a context. */
export const refuseStorage = (where) => where.addInitScript(() => {
  Object.defineProperty(window, "localStorage", { get() { throw new DOMException("refused", "SecurityError"); } });
});

/** Waits until the page has a whole motion. */
export const moving = (page) => page.waitForFunction(() => window.pendulumd?.motion.complete);

/** Waits until what has changed is drawn: the motion is here, the view has come to where it goes, and every transition has ended. */
export const drawn = (page) => page.evaluate(async () => {
  const frame = () => new Promise((resolve) => { requestAnimationFrame(resolve); });
  while (window.pendulumd?.motion.loading) await frame();
  // the pivot, and a tip where the clock stands, move with the view alone
  const view = () => (window.pendulumd ? JSON.stringify([pendulumd.stage.tip(0), pendulumd.clock.playing || pendulumd.stage.tip(1)]) : "");
  await frame();
  for (let same = 0, before = null; same < 3; await frame()) {
    const now = view();
    same = now === before ? same + 1 : 0;
    before = now;
  }
  const ending = document.getAnimations().filter((one) => one.effect.getComputedTiming().endTime < Infinity);
  await Promise.all(ending.map((one) => one.finished.catch(() => {})));
});

/** Throws if the page has seen an error that is not of the forgiven patterns; else empties it for the next test. */
export async function close(page) {
  const bad = page.faults.filter((fault) => !page.forgiven.some((pattern) => pattern.test(fault)));
  if (bad.length) throw new Error(`the page is not clean: ${bad.join(" | ")}`);
  page.used.delete(page);
  if (!page.key) return page.context().close();
  // the next test's page is not to be pointed at, and answers its questions itself
  await page.mouse.move(0, 0);
  page.removeAllListeners("dialog");
  await page.goto("about:blank");
  unused.set(page.key, [...unused.get(page.key) ?? [], page]);
}
