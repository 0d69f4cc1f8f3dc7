// The equations: set without a fault, copied as the server wrote them, compact where the tree is large.

import assert from "node:assert/strict";
import { openDrawer } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const clipboard = (page) => page.evaluate(() => navigator.clipboard.readText());

async function copied(page, kind) {
  // the button says it for a moment only, what is read aloud stays
  await page.evaluate(() => pendulumd.announce(""));
  await page.click(`[data-copy=${kind}]`);
  await page.waitForFunction(() => document.getElementById("live").textContent === "Copied");
  return clipboard(page);
}

export async function equations_are_set_and_copied_as_the_server_wrote_them(rig) {
  const page = await rig.open({ height: 1200, permissions: ["clipboard-read", "clipboard-write"] });
  await openDrawer(page, "equations");
  await page.waitForSelector("[data-part=bbb] .katex");
  assert.equal(await page.locator(".katex-error").count(), 0);
  for (const part of ["S", "B", "z", "M", "aaa", "bbb"]) assert.ok(await page.locator(`[data-part=${part}] .katex-html`).count(), `${part} is missing`);
  const answer = await page.evaluate(() => {
    const { pendulum, initial } = window.pendulumd.store.get();
    return window.pendulumd.client.equations({ pendulum, initial });
  });
  const latex = await copied(page, "latex");
  for (const formula of Object.values(answer.latex)) assert.ok(latex.includes(formula));
  assert.equal(await copied(page, "matlab"), answer.code.matlab);
  assert.equal(await copied(page, "python"), answer.code.python);
  const curl = await copied(page, "curl");
  assert.ok(curl.startsWith(`curl -s ${rig.url}/v1/trajectories`), curl);
  await close(page);
}

export async function equations_follow_the_tree_and_are_compact_for_large_ones(rig) {
  const page = await rig.open();
  await openDrawer(page, "equations");
  await page.waitForSelector("[data-part=bbb] .katex");
  const chain = (n) => page.evaluate((count) => {
    const ones = Array(count).fill(1);
    window.pendulumd.store.set({ pendulum: { length: ones, mass: ones, parent: ones.map((_, k) => k), gravity: 9.81 },
      initial: { phi: ones.map(() => 0), phid: ones.map(() => 0) }, ghosts: [], view: { trails: [1], selected: 0 } });
  }, n);
  const rows = () => page.evaluate(() => document.querySelector("[data-part=S] annotation").textContent.split("\\\\").length);
  await chain(6);
  await page.waitForFunction(() => document.querySelector("[data-part=S] annotation")?.textContent.split("\\\\").length === 6);
  assert.equal(await page.inputValue("[data-form]"), "explicit");
  await page.selectOption("[data-form]", "compact");
  await page.waitForFunction(() => !document.querySelector("[data-part=aaa] annotation").textContent.includes("phi_{6}"));
  await chain(40);
  await page.waitForFunction(() => document.querySelector("[data-form]").disabled);
  assert.equal(await page.inputValue("[data-form]"), "compact");
  await page.waitForFunction(() => document.querySelector("[data-part=S] annotation").textContent.includes("39"));
  await drawn(page);
  assert.equal(await page.locator(".katex-error").count(), 0);
  assert.ok(await rows() <= 40);
  await close(page);
}
