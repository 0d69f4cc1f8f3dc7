// A part of the tests in WebKit, where it is installed with its driver: what every browser is asked, on a system without a
// language ("C", at which Intl throws), and the page goes on by its own engine when the server has ended.

import assert from "node:assert/strict";
import { shows } from "./anywhere.mjs";
import { startDaemon } from "./rig.mjs";
import { startWebkit, webkitIsHere } from "./webkit.mjs";

export async function webkit_shows_the_page_its_drawers_and_the_period_on_a_system_without_a_language() {
  if (!webkitIsHere()) return "WebKit, its driver or Xvfb is not here";
  const daemon = await startDaemon();
  const webkit = await startWebkit();
  try {
    await shows(webkit, daemon.url);
    const [agent, language] = await webkit.run("return [navigator.userAgent, navigator.language];");
    assert.match(agent, /AppleWebKit/);
    assert.equal(language, "en", "a language that Intl knows");
    const engine = await webkit.run("return pendulumd.client.engine.ready;");
    if (engine) {
      await daemon.stop();
      await webkit.run("pendulumd.edits.setStart(1, 'phi', -1); pendulumd.clock.seek(0); pendulumd.clock.play();");
      await webkit.until("pendulumd.motion.complete && pendulumd.motion.doc.initial.phi[0] === -1 && pendulumd.clock.time > 0.2");
    }
    return `${agent.replace(/.* \(.*?\) /, "")}${engine ? ", by the engine without a server" : ""}`;
  } finally {
    await webkit.stop();
    await daemon.stop();
  }
}
