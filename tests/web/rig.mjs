// What the browser tests stand on: a daemon, the page before it, a browser, and pages that notice every error.
// Leaves to others: what is tested (test_*.mjs), counting (run.mjs).
// Invariant: a page that writes an error on its console or asks another host fails its test; what was started is ended.

import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { servePage } from "./serve.mjs";

export const ROOT = fileURLToPath(new URL("../../", import.meta.url));
/** require() of the packages in package.json, which lie in build/ (tests/rules/web.sh fetches them). */
export const fetched = createRequire(join(ROOT, "build/webtest/package.json"));
const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const PROGRAM = process.env.PENDULUMD ?? join(ROOT, "build/release/pendulumd");
const PICTURES = join(ROOT, "build/check/web");
const ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--font-render-hinting=none"];

/** A daemon on a free port: {url, stop()}; options are added to its command line. */
export async function startDaemon(options = ["--store", "none"]) {
  const child = spawn(PROGRAM, ["--listen", "127.0.0.1:0", ...options], { stdio: ["ignore", "ignore", "pipe"] });
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
    async stop() {
      child.kill("SIGTERM");
      await gone;
    },
  };
}

/** Whether this daemon serves the page itself. */
async function servesPage(url) {
  const reply = await fetch(`${url}/`);
  return reply.ok && (reply.headers.get("Content-Type") ?? "").startsWith("text/html");
}

/** A new directory that goes with the rig, for a daemon's store. */
function directory() {
  const path = mkdtempSync(join(tmpdir(), "pendulumd-web-"));
  return { path, remove: () => rmSync(path, { recursive: true, force: true }) };
}

/**
 * {url, daemon, front, open(options), shot(page, name), close()}
 *
 * store    true: scenes are kept (a file that goes with the rig).
 * sources  true: the page comes from server/web through serve.mjs, whose `fault` can stand in for a server in trouble;
 *          false: from the daemon, if that serves it.
 */
export async function createRig({ store = false, sources = true, options = [] } = {}) {
  const home = directory();
  const daemon = await startDaemon(["--store", store ? `sqlite:${join(home.path, "store")}` : "none", ...options]);
  const own = !sources && await servesPage(daemon.url);
  const front = own ? null : await servePage(daemon.url);
  const url = own ? daemon.url : front.url;
  const browser = await fetched("playwright-core").chromium.launch({ executablePath: CHROMIUM, args: ARGUMENTS });
  mkdirSync(PICTURES, { recursive: true });

  /** A page of a browser of its own; page.faults lists what went wrong, allow(pattern) is forgiven. */
  async function open({ path = "/", width = 1280, height = 800, dark = false, still = false, touch = false, language = "en", wait = true, ...more } = {}) {
    const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? "dark" : "light", hasTouch: touch,
      reducedMotion: still ? "reduce" : "no-preference", locale: language, ...more });
    const page = await context.newPage();
    page.faults = [];
    page.forgiven = [];
    page.on("console", (message) => message.type() === "error" && page.faults.push(message.text()));
    page.on("pageerror", (error) => page.faults.push(String(error)));
    page.on("request", (asked) => {
      const { origin, protocol } = new URL(asked.url());
      if (protocol.startsWith("http") && origin !== url) page.faults.push(`asked ${asked.url()}`);
    });
    await page.goto(url + path);
    if (wait) await moving(page);
    return page;
  }

  return {
    url, daemon, front, browser, open,
    shot: (page, name, more = {}) => page.screenshot({ path: join(PICTURES, `${name}.png`), ...more }),
    async close() {
      await browser.close();
      front?.close();
      await daemon.stop();
      home.remove();
    },
  };
}

/** How many times slower a program runs here and now than it would alone: 1 on a quiet machine. */
export function crowd() {
  const begun = performance.now();
  const used = process.cpuUsage();
  let more = { user: 0, system: 0 };
  while (more.user + more.system < 25000) more = process.cpuUsage(used);
  return Math.max(1, (performance.now() - begun) * 1000 / (more.user + more.system));
}

/** Waits until the page has a whole motion. */
export const moving = (page) => page.waitForFunction(() => window.pendulumd?.motion.complete, null, { timeout: 15000 });

/** Throws if the page has seen an error that is not of the forgiven patterns; then closes it. */
export async function close(page) {
  const bad = page.faults.filter((fault) => !page.forgiven.some((pattern) => pattern.test(fault)));
  await page.context().close();
  if (bad.length) throw new Error(`the page is not clean: ${bad.join(" | ")}`);
}
