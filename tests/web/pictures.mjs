// The pictures of README.md and the guides, made from the real page: `make pictures`.
// Leaves to others: the daemon, the browser's package (rig.mjs); tests of the page (test_*.mjs).
// Invariant: every frame is drawn at a chosen instant, so that a slow machine makes the same film.

import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { CHROMIUM_ARGUMENTS, ROOT, fetched, startDaemon } from "./rig.mjs";

const TO = join(ROOT, "api/guide/pictures");
const SIZE = { width: 1100, height: 640 };
const FRAMES = 100;
const FRAME_SECONDS = 0.05;

const home = mkdtempSync(join(tmpdir(), "pendulumd-pictures-"));
mkdirSync(TO, { recursive: true });
const daemon = await startDaemon();
const browser = await fetched("playwright-core").chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: CHROMIUM_ARGUMENTS });

/** A page with its motion computed, paused. */
async function open(path = "/") {
  const page = await (await browser.newContext({ viewport: SIZE, colorScheme: "light" })).newPage();
  await page.goto(daemon.url + path);
  await page.waitForFunction(() => window.pendulumd?.clock?.complete);
  await page.evaluate(() => window.pendulumd.clock.pause());
  return page;
}

/** A still of the page, as a WebP. */
async function still(page, name) {
  const png = join(home, `${name}.png`);
  await page.screenshot({ path: png });
  execFileSync("cwebp", ["-quiet", "-q", "75", "-m", "6", png, "-o", join(TO, `${name}.webp`)]);
}

/** Which starts of a double pendulum flip, and when. */
async function map() {
  const page = await open("/?length=1,1&theta=120,150");
  await openDrawer(page, "compare");
  await page.selectOption("[data-map=count]", "240");
  await page.click("[data-map=compute]");
  await page.waitForSelector("[data-map=png]:not([hidden])");
  await page.locator(".map").scrollIntoViewIfNeeded();
  await still(page, "map");
}

/** Angles of a film with noise, and the pendulum that was found from them. */
async function fit() {
  const page = await open("/?length=0.8&theta=20");
  const { t, theta } = await page.evaluate(() => window.pendulumd.client.trajectory({ pendulum: { length: [0.62], mass: [1], parent: [0], damping: [0.01] },
    initial: { theta: [40], unit: "deg" }, times: { start: 0, stop: 4, step: 0.05 }, output: ["theta"] }));
  await openDrawer(page, "measure");
  await page.click("[data-part=fits] summary");
  await page.fill(".fit-text", ["t;theta (deg)", ...t.map((time, k) => `${time.toFixed(2)};${(theta[k][0] * 180 / Math.PI + Math.sin(k * k)).toFixed(2)}`)].join("\n"));
  await page.click("[data-fit=run]");
  await page.waitForSelector("[data-fit=answer] .plot svg");
  await page.locator("[data-fit=answer]").scrollIntoViewIfNeeded();
  await still(page, "fit");
}

/** The swinging page, as an animated WebP. */
async function film() {
  const page = await open("/?example=paper-four-arms");
  await openDrawer(page, "plots");
  await settledMotion(page);
  const files = [];
  for (let k = 0; k < FRAMES; k++) {
    await page.evaluate((t) => new Promise((drawn) => {
      window.pendulumd.clock.seek(t);
      requestAnimationFrame(() => requestAnimationFrame(drawn));
    }), k * FRAME_SECONDS);
    files.push(join(home, `${String(k).padStart(3, "0")}.png`));
    await page.screenshot({ path: files[k] });
  }
  execFileSync("img2webp", ["-loop", "0", "-mixed", "-min_size", "-q", "60", "-m", "6", "-d", String(1000 * FRAME_SECONDS), ...files, "-o", join(TO, "page.webp")], { stdio: "ignore" });
}

try {
  for (const make of [film, map, fit]) if (make.name.includes(process.argv[2] ?? "")) await make();
} finally {
  await browser.close();
  await daemon.stop();
  rmSync(home, { recursive: true });
}
