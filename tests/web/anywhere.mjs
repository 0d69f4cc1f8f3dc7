// The part of the tests that every browser runs: the page opens and swings, the period is read, arms and a ruler obey keys, every
// drawer comes, axe finds nothing.
// Leaves to others: the browsers (firefox.mjs, webkit.mjs), what one of them alone is asked (test_firefox.mjs, test_webkit.mjs).
// Invariant: a browser is {go(url), run(script, ...values), until(expression), press(...keys)} and nothing more.

import assert from "node:assert/strict";
import { AXE } from "./axe.mjs";
import { DRAWERS } from "../../server/web/state.js";

/** What the page has said of itself since it began. */
const faults = (browser) => browser.run("return pendulumd.motion.complaint;");

export async function opens(browser, url) {
  await browser.go(`${url}/?length=1&theta=90`);
  await browser.until("window.pendulumd && pendulumd.motion.complete && pendulumd.clock.time > 0");
  assert.match(await browser.run("return document.title;"), /Pendulum Lab$/);
}

async function opensDrawers(browser) {
  for (const id of DRAWERS) {
    await browser.run(`if (pendulumd.store.get().view.drawer !== "${id}") document.querySelector('[data-tab="${id}"]').click();`);
    await browser.until(`document.querySelector('[data-drawer="${id}"] h2') && !document.querySelector('[data-drawer="${id}"]').hasAttribute("aria-busy")`);
    assert.equal(await browser.run(`return document.querySelectorAll('[data-drawer="${id}"] [data-again]').length;`), 0, id);
  }
}

/** Keys as hands press them: the tab key leads to the arm, arrows turn it and move the end of a ruler. */
async function obeysKeys(browser) {
  await browser.run("document.activeElement.blur(); pendulumd.clock.pause(); pendulumd.clock.seek(0);");
  for (let i = 0; i < 20 && !await browser.run("return document.activeElement.dataset.arm === '1';"); i++) await browser.press("Tab");
  const theta = () => browser.run("return Math.round(pendulumd.store.get().initial.phi[0] * 180 / Math.PI + 90);");
  const before = await theta();
  await browser.press("ArrowLeft", "ArrowLeft");
  assert.equal(await theta(), before + 10, "two times five degrees");
  await browser.run("pendulumd.store.set({ view: { ruler: [0, 0, 0.3, 0.4] } });");
  await browser.until('document.querySelector("[data-gauge=b]")');
  await browser.run('document.querySelector("[data-gauge=b]").focus();');
  await browser.press("ArrowRight");
  assert.ok(await browser.run("return pendulumd.store.get().view.ruler[2];") > 0.3, "to the right");
  await browser.run("pendulumd.store.set({ view: { ruler: null } });");
}

/** All of it, from the address of a server. */
export async function shows(browser, url) {
  await opens(browser, url);
  await browser.run("document.querySelector('[data-tab=\"measure\"]').click();");
  await browser.until('document.querySelector("[data-read=period]")');
  // 2.0061 s times 1.18034, of a swing of 90 degrees
  assert.equal(await browser.run('return document.querySelector("[data-read=period]").textContent;'), "2.3678 s");
  await obeysKeys(browser);
  await opensDrawers(browser);
  await browser.run(`${AXE}; window.axe = axe;`);
  await browser.run("window.found = null; axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', 'wcag22aa'] }).then((all) => { window.found = all.violations.map(({ id }) => id); });");
  await browser.until("window.found");
  assert.deepEqual(await browser.run("return window.found;"), []);
  assert.equal(await faults(browser), null);
}
