// The tests in Firefox as Debian has it (BROWSER=firefox), by WebDriver BiDi, the protocol of all browsers.
// Leaves to others: the rig (rig.mjs), the part of the tests that runs in Firefox every time (test_firefox.mjs).
// Invariant: what asks for Chromium's own protocol is told as not asked, never as passed.

import { mkdirSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

export const IN_FIREFOX = process.env.BROWSER === "firefox";
const PROGRAM = process.env.FIREFOX ?? "/usr/bin/firefox-esr";
/** Where Firefox puts what it saves. */
const SAVED = fileURLToPath(new URL("../../build/check/firefox", import.meta.url));
const TIMEOUT_MS = 180000;

/** A test asks for something that this browser's protocol does not have: it counts neither as passed nor as failed. */
export class Unasked extends Error {}

/** What the requests of a test carry: a list that is filled from now on; Firefox's protocol does not tell it. */
export function bodiesOf(page, which) {
  const all = [];
  if (IN_FIREFOX) throw new Unasked("what a request carries is of Chromium's protocol");
  page.on("request", (one) => which(one) && all.push(JSON.parse(one.postData())));
  return all;
}

/** A Firefox; what a person wants of motion and colours is set for all of its pages. */
export const launchFirefox = (playwright, { dark, still }) => playwright._bidiFirefox.launch({ executablePath: PROGRAM, timeout: TIMEOUT_MS,
  env: { ...process.env, HOME: tmpdir() }, firefoxUserPrefs: { "ui.systemUsesDarkTheme": Number(dark), "ui.prefersReducedMotion": Number(still),
    "browser.download.folderList": 2, "browser.download.dir": SAVED, "browser.download.always_ask_before_handling_new_types": false, "browser.download.alwaysOpenPanel": false } });

/** What Firefox saves next, as Chromium's own protocol would tell it. */
async function nextDownload() {
  rmSync(SAVED, { recursive: true, force: true });
  mkdirSync(SAVED, { recursive: true });
  for (let waited = 0; waited < TIMEOUT_MS; waited += 50) {
    const all = readdirSync(SAVED);
    const name = all.find((one) => !one.endsWith(".part") && !all.includes(`${one}.part`) && statSync(join(SAVED, one)).size > 0);
    if (name) return { suggestedFilename: () => name, path: async () => join(SAVED, name) };
    await new Promise((resolve) => { setTimeout(resolve, 50); });
  }
  throw new Error("nothing is saved");
}

/** A page whose tests find out when they ask for what it does not have. */
export function withoutProtocol(page) {
  const unasked = (what) => { throw new Unasked(`${what} is of Chromium's protocol`); };
  page.session = { send: unasked };
  page.context().setOffline = () => unasked("a line that is cut");
  page.pdf = () => unasked("what is printed");
  page.context().newCDPSession = () => unasked("a finger");
  page.emulateMedia = () => unasked("a wish of a page that is open");
  page.waitForEvent = (name) => (name === "download" ? nextDownload() : unasked(name));
}
