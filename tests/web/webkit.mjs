// WebKit as Debian has it (webkit2gtk-driver with its MiniBrowser), by WebDriver, in a screen of its own (Xvfb): what the tests in
// a third browser need of it.
// Leaves to others: what is tested (anywhere.mjs, test_webkit.mjs).
// Invariant: a home of its own, in a directory that goes with it; what was started is ended.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { KEYS, pause } from "./firefox.mjs";

const DRIVER = process.env.WEBKIT_DRIVER ?? "/usr/bin/WebKitWebDriver";
const SCREEN = process.env.XVFB ?? "/usr/bin/Xvfb";
const PATIENCE_MS = 60000;

/** The browser that the driver drives; "" where it is not installed. */
function miniBrowser() {
  for (const folder of existsSync("/usr/lib") ? readdirSync("/usr/lib") : [])
    for (const version of ["webkit2gtk-4.1", "webkit2gtk-4.0", "webkitgtk-6.0"]) {
      const file = join("/usr/lib", folder, version, "MiniBrowser");
      if (existsSync(file)) return file;
    }
  return "";
}

export const webkitIsHere = () => existsSync(DRIVER) && existsSync(SCREEN) && miniBrowser() !== "";

/** A port that nobody has now. */
const freePort = () => new Promise((resolve) => {
  const server = createServer().listen(0, "127.0.0.1", () => {
    const { port } = server.address();
    server.close(() => resolve(port));
  });
});

/** A screen that nobody sees: {name, stop()}; the server chooses its number. */
async function startScreen() {
  const child = spawn(SCREEN, ["-displayfd", "3", "-screen", "0", "1280x1000x24", "-nolisten", "tcp"], { stdio: ["ignore", "ignore", "ignore", "pipe"] });
  const gone = new Promise((resolve) => { child.on("exit", resolve); });
  const number = await new Promise((resolve, reject) => {
    child.stdio[3].once("data", (piece) => resolve(String(piece).trim()));
    gone.then(() => reject(new Error("Xvfb did not start")));
  });
  return { name: `:${number}`, async stop() { child.kill("SIGTERM"); await gone; } };
}

/** A WebKit on a screen of its own, with a language's settings: {go(url), run(script, ...values), until(expression), press(...keys), stop()}. */
export async function startWebkit(locale = "C.UTF-8") {
  const home = mkdtempSync(join(tmpdir(), "pendulumd-webkit-"));
  const screen = await startScreen();
  const port = await freePort();
  const env = { ...process.env, HOME: home, XDG_RUNTIME_DIR: home, XDG_DATA_HOME: home, XDG_CACHE_HOME: home, XDG_CONFIG_HOME: home, DISPLAY: screen.name,
    LC_ALL: locale, LANGUAGE: "", GDK_BACKEND: "x11", LIBGL_ALWAYS_SOFTWARE: "1", WEBKIT_DISABLE_COMPOSITING_MODE: "1", WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS: "1", GTK_A11Y: "none", NO_AT_BRIDGE: "1" };
  const child = spawn(DRIVER, [`--port=${port}`], { stdio: "ignore", env });
  const gone = new Promise((resolve) => { child.on("exit", resolve); });
  const ask = async (method, path, body) => {
    const reply = await fetch(`http://127.0.0.1:${port}${path}`, { method, headers: { "Content-Type": "application/json" }, body: body && JSON.stringify(body) });
    const { value } = await reply.json();
    if (!reply.ok) throw new Error(`${value.error}: ${value.message}`);
    return value;
  };
  for (let waited = 0; waited < PATIENCE_MS; waited += 50) {
    if (await ask("GET", "/status").then(() => true, () => false)) break;
    await pause(50);
  }
  const options = { binary: miniBrowser(), args: ["--automation"] };
  const { sessionId } = await ask("POST", "/session", { capabilities: { alwaysMatch: { "webkitgtk:browserOptions": options, timeouts: { script: PATIENCE_MS, pageLoad: PATIENCE_MS } } } });
  const session = (method, path, body) => ask(method, `/session/${sessionId}${path}`, body);
  const run = (script, ...values) => session("POST", "/execute/sync", { script, args: values });
  return {
    run,
    session,
    go: (url) => session("POST", "/url", { url }),
    async until(expression) {
      for (let waited = 0; waited < PATIENCE_MS; waited += 50) {
        if (await run(`return Boolean(${expression});`)) return;
        await pause(50);
      }
      throw new Error(`this never comes: ${expression}`);
    },
    press: (...keys) => session("POST", "/actions", { actions: [{ type: "key", id: "keyboard",
      actions: keys.flatMap((key) => [{ type: "keyDown", value: KEYS[key] ?? key }, { type: "keyUp", value: KEYS[key] ?? key }]) }] }),
    async stop() {
      await session("DELETE", "").catch(() => {});
      child.kill("SIGTERM");
      await gone;
      await screen.stop();
      rmSync(home, { recursive: true, force: true, maxRetries: 5, retryDelay: 100 });
    },
  };
}
