// The page as a folder (make site), served by a web host that knows files alone: it swings and answers to hands in this browser, its
// drawers come, and what needs a server says so in every language.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { join } from "node:path";
import { openDrawer } from "./drawers.mjs";
import { drawn, moving, ROOT } from "./rig.mjs";

/** The folder, in a folder of a host: {url, stop()}. */
async function startHost() {
  const home = join(ROOT, "build/check/site");
  const python = (...words) => execFileSync("/usr/bin/python3", ["-B", ...words], { cwd: ROOT, maxBuffer: 1 << 26 });
  execFileSync("mkdir", ["-p", home]);
  execFileSync("/bin/sh", ["-c", `/usr/bin/python3 -B api/call/openapi_embed.py --json api/call/openapi.yaml > ${home}/openapi.json`], { cwd: ROOT });
  python("server/http/assets_embed.py", "server/web", "build/web/bundles", "build/web/engine.wasm", "api/guide", `${home}/demo`, `${home}/openapi.json`);
  const child = spawn("/usr/bin/python3", ["-u", "-m", "http.server", "0", "--bind", "127.0.0.1", "-d", home], { stdio: ["ignore", "pipe", "ignore"] });
  const gone = new Promise((resolve) => child.on("exit", resolve));
  const port = await new Promise((resolve) => {
    let said = "";
    child.stdout.on("data", (piece) => {
      said += piece;
      const found = / port (\d+) /.exec(said);
      if (found) resolve(found[1]);
    });
  });
  return { url: `http://127.0.0.1:${port}`, stop: () => { child.kill(); return gone; } };
}

export async function a_folder_on_any_web_host_is_a_demonstration(rig) {
  const host = await startHost();
  try {
    const page = await rig.openAt(host.url, { path: "/demo/?lang=en" });
    const asked = [];
    page.on("request", (request) => asked.push(new URL(request.url()).pathname));
    await moving(page);
    await page.waitForFunction(() => pendulumd.clock.time > 0.2);
    // a tip is dragged
    const start = await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); return JSON.stringify(pendulumd.store.get().initial); });
    await drawn(page);
    const from = await page.evaluate(() => {
      const place = document.querySelector(".canvas").getBoundingClientRect();
      const spot = pendulumd.stage.tip(1);
      return { x: place.left + spot.x, y: place.top + spot.y };
    });
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    await page.mouse.move(from.x - 30, from.y + 40, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction((before) => JSON.stringify(pendulumd.store.get().initial) !== before, start);
    await moving(page);
    for (const id of ["presets", "plots", "modes", "equations", "method"]) await openDrawer(page, id);
    assert.ok(await page.locator("[data-drawer=presets] .preset").count() > 10);
    // what needs a server
    await openDrawer(page, "measure");
    await page.click("[data-part=fits] summary");
    await page.waitForSelector("[data-part=fits] [data-serverless]");
    await openDrawer(page, "compare");
    assert.ok(await page.evaluate(() => document.querySelector("[data-map=compute]").closest("[inert]") !== null));
    const said = new Set();
    for (const language of ["en", "de", "fr", "es", "nl", "tr"]) {
      await page.evaluate((name) => pendulumd.speak(name), language);
      await openDrawer(page, "class");
      said.add(await page.textContent("[data-drawer=class] [data-serverless]"));
    }
    assert.equal(said.size, 6);
    assert.ok([...said].every((words) => words.includes("pendulumd")), [...said].join("\n"));
    assert.equal(await page.locator(".notice:not([hidden])").count(), 0);
    await page.evaluate(() => pendulumd.speak("en"));
    await page.click(".docs-link");
    await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
    assert.ok(await page.locator("text=Fit a pendulum").count() + await page.locator("a[href*=fits]").count() > 0);
    assert.equal(await page.locator(".doc-example .button.main:not([disabled])").count(), 0);
    assert.deepEqual(asked.filter((path) => !path.startsWith("/demo/") || path.includes("/v1/")), []);
  } finally {
    await host.stop();
  }
}
