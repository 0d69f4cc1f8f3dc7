// A part of the tests in Firefox, where it is installed: what every browser is asked, and the page is kept for a time without a
// server. The whole suite in Firefox: tests/rules/web.sh with BROWSER=firefox.

import assert from "node:assert/strict";
import { shows } from "./anywhere.mjs";
import { firefoxIsHere, startFirefox } from "./firefox.mjs";
import { startDaemon } from "./rig.mjs";

export async function firefox_shows_the_page_its_drawers_the_period_and_keeps_it() {
  if (!firefoxIsHere()) return "Firefox is not here";
  const daemon = await startDaemon();
  const firefox = await startFirefox();
  try {
    await shows(firefox, daemon.url);
    assert.match(await firefox.run("return navigator.userAgent;"), /Firefox/);
    await firefox.until('pendulumd.offline.kind === "kept" && navigator.serviceWorker.controller');
    await daemon.stop();
    await firefox.go(`${daemon.url}/?length=1&theta=45`);
    await firefox.until("window.pendulumd && pendulumd.clock.time > 0.2");
    return await firefox.run("return navigator.userAgent.replace(/.* /, '') + (pendulumd.client.engine.ready ? ', by the engine without a server' : '');");
  } finally {
    await firefox.stop();
    await daemon.stop();
  }
}
