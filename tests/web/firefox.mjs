// Firefox as Debian has it, by its own protocol (Marionette): what the tests in another browser than Chromium need of it.
// Leaves to others: what is tested (test_firefox.mjs).
// Invariant: a profile of its own, in a directory that goes with it; what was started is ended.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

const PROGRAM = process.env.FIREFOX ?? "/usr/bin/firefox-esr";
const PATIENCE_MS = 30000;
/** Keys without a letter, as WebDriver has them. */
export const KEYS = { Tab: "\uE004", Enter: "\uE007", Escape: "\uE00C", ArrowLeft: "\uE012", ArrowUp: "\uE013", ArrowRight: "\uE014", ArrowDown: "\uE015" };

export const firefoxIsHere = () => existsSync(PROGRAM);

export const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/** The port that Firefox has chosen, which it writes into its profile. */
async function portOf(profile) {
  const file = join(profile, "MarionetteActivePort");
  for (let waited = 0; waited < PATIENCE_MS; waited += 50) {
    const port = existsSync(file) ? Number(readFileSync(file, "utf8")) : 0;
    if (port) return port;
    await pause(50);
  }
  throw new Error("Firefox does not answer");
}

/** Messages of Marionette: their length in bytes, a colon, JSON. */
function createTalk(socket) {
  const waiting = new Map();
  let [rest, last] = [Buffer.alloc(0), 0];
  socket.on("data", (piece) => {
    rest = Buffer.concat([rest, piece]);
    for (let colon = rest.indexOf(58); colon > 0; colon = rest.indexOf(58)) {
      const end = colon + 1 + Number(rest.subarray(0, colon));
      if (rest.length < end) return;
      const message = JSON.parse(rest.subarray(colon + 1, end));
      rest = rest.subarray(end);
      if (!Array.isArray(message)) continue; // the greeting
      const [, id, error, answer] = message;
      const { resolve, reject } = waiting.get(id);
      waiting.delete(id);
      if (error) reject(new Error(`${error.error}: ${error.message}`));
      else resolve(answer);
    }
  });
  return (name, parameters = {}) => new Promise((resolve, reject) => {
    const text = JSON.stringify([0, ++last, name, parameters]);
    waiting.set(last, { resolve, reject });
    socket.write(`${Buffer.byteLength(text)}:${text}`);
  });
}

/** A Firefox without a window: {go(url), run(script, ...values), until(script, ...values), press(...keys), stop()}. */
export async function startFirefox() {
  const profile = mkdtempSync(join(tmpdir(), "pendulumd-firefox-"));
  writeFileSync(join(profile, "user.js"), 'user_pref("marionette.port", 0);\nuser_pref("intl.accept_languages", "en");\nuser_pref("app.normandy.enabled", false);\n'
    + 'user_pref("network.captive-portal-service.enabled", false);\nuser_pref("network.connectivity-service.enabled", false);\n');
  const child = spawn(PROGRAM, ["--headless", "--marionette", "--no-remote", "--profile", profile], { stdio: "ignore", env: { ...process.env, HOME: profile } });
  const gone = new Promise((resolve) => { child.on("exit", resolve); });
  const socket = connect(await portOf(profile), "127.0.0.1");
  const ask = createTalk(socket);
  await ask("WebDriver:NewSession", { capabilities: { alwaysMatch: { timeouts: { script: PATIENCE_MS, pageLoad: PATIENCE_MS } } } });
  const run = async (script, ...values) => (await ask("WebDriver:ExecuteScript", { script, args: values, sandbox: null })).value;
  return {
    run,
    go: (url) => ask("WebDriver:Navigate", { url }),
    /** Waits until an expression of the page is true. */
    async until(expression) {
      for (let waited = 0; waited < PATIENCE_MS; waited += 50) {
        if (await run(`return Boolean(${expression});`)) return;
        await pause(50);
      }
      throw new Error(`this never comes: ${expression}`);
    },
    /** Presses keys, one after the other, as hands do: what has the focus gets them. */
    press: (...keys) => ask("WebDriver:PerformActions", { actions: [{ type: "key", id: "keyboard",
      actions: keys.flatMap((key) => [{ type: "keyDown", value: KEYS[key] ?? key }, { type: "keyUp", value: KEYS[key] ?? key }]) }] }),
    async stop() {
      socket.destroy();
      child.kill("SIGTERM");
      await gone;
      rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 100 });
    },
  };
}
