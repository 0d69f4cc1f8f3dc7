// A part of the tests in Firefox, where it is installed: the page opens and swings, every drawer comes, the period
// is read, arms and a ruler obey keys, axe finds nothing, the page is kept for a time without a server.

import assert from "node:assert/strict";
import { AXE } from "./axe.mjs";
import { firefoxIsHere, startFirefox } from "./firefox.mjs";
import { startDaemon } from "./rig.mjs";

const DRAWERS = ["presets", "physics", "measure", "plots", "modes", "compare", "method", "equations", "share", "worksheet", "class"];

/** What the page has said of itself since it began. */
const faults = (firefox) => firefox.run("return pendulumd.motion.complaint;");

async function opens(firefox, url) {
  await firefox.go(`${url}/?length=1&theta=90`);
  await firefox.until("window.pendulumd && pendulumd.motion.complete && pendulumd.clock.time > 0");
  assert.match(await firefox.run("return navigator.userAgent;"), /Firefox/);
  assert.equal(await firefox.run("return document.title;"), "Pendulum trees");
}

async function opensDrawers(firefox) {
  for (const id of DRAWERS) {
    await firefox.run(`if (pendulumd.store.get().view.drawer !== "${id}") document.querySelector('[data-tab="${id}"]').click();`);
    await firefox.until(`document.querySelector('[data-drawer="${id}"] h2') && !document.querySelector('[data-drawer="${id}"]').hasAttribute("aria-busy")`);
    assert.equal(await firefox.run(`return document.querySelectorAll('[data-drawer="${id}"] [data-again]').length;`), 0, id);
  }
}

/** Keys as hands press them: the tab key leads to the arm, arrows turn it and move the end of a ruler. */
async function obeysKeys(firefox) {
  await firefox.run("document.activeElement.blur(); pendulumd.clock.pause(); pendulumd.clock.seek(0);");
  for (let i = 0; i < 20 && !await firefox.run("return document.activeElement.dataset.arm === '1';"); i++) await firefox.press("Tab");
  const theta = () => firefox.run("return Math.round(pendulumd.store.get().initial.phi[0] * 180 / Math.PI + 90);");
  const before = await theta();
  await firefox.press("ArrowLeft", "ArrowLeft");
  assert.equal(await theta(), before + 10, "two times five degrees");
  await firefox.run("pendulumd.store.set({ view: { ruler: [0, 0, 0.3, 0.4] } });");
  await firefox.until('document.querySelector("[data-gauge=b]")');
  await firefox.run('document.querySelector("[data-gauge=b]").focus();');
  await firefox.press("ArrowRight");
  assert.ok(await firefox.run("return pendulumd.store.get().view.ruler[2];") > 0.3, "to the right");
  await firefox.run("pendulumd.store.set({ view: { ruler: null } });");
}

export async function firefox_shows_the_page_its_drawers_the_period_and_keeps_it() {
  if (!firefoxIsHere()) return "Firefox is not here";
  const daemon = await startDaemon();
  const firefox = await startFirefox();
  try {
    await opens(firefox, daemon.url);
    await firefox.run("document.querySelector('[data-tab=\"measure\"]').click();");
    await firefox.until('document.querySelector("[data-read=period]")');
    // 2.0061 s times 1.18034, of a swing of 90 degrees
    assert.equal(await firefox.run('return document.querySelector("[data-read=period]").textContent;'), "2.3678 s");
    await obeysKeys(firefox);
    await opensDrawers(firefox);
    await firefox.run(`${AXE}; window.axe = axe;`);
    await firefox.run("window.found = null; axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', 'wcag22aa'] }).then((all) => { window.found = all.violations.map(({ id }) => id); });");
    await firefox.until("window.found");
    assert.deepEqual(await firefox.run("return window.found;"), []);
    assert.equal(await faults(firefox), null);
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
