// The report: the document on paper with its picture, numbers, plots, settings and link, by chromium's own print to PDF.

import assert from "node:assert/strict";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { openDrawer } from "./drawers.mjs";
import { ROOT, close, drawn } from "./rig.mjs";

/** Prints the page as it is: {pages, images, bytes} of the PDF, which is left beside the pictures. */
async function printed(page, name) {
  const bytes = await page.pdf({ format: "A4", preferCSSPageSize: false });
  const home = join(ROOT, "build/check/web");
  mkdirSync(home, { recursive: true });
  writeFileSync(join(home, `${name}.pdf`), bytes);
  const text = bytes.toString("latin1");
  const count = (pattern) => (text.match(pattern) ?? []).length;
  return { pages: count(/\/Type \/Page\b/g), images: count(/\/Subtype \/Image\b/g), bytes: bytes.length };
}

/** Asks for the report; the browser's own dialog is not there. */
async function asked(page) {
  await page.evaluate(() => { window.print = () => { window.dialogs = (window.dialogs ?? 0) + 1; }; });
  await page.click("[data-share=report]");
  await page.waitForFunction(() => window.dialogs === 1);
}

/** How bright the picture of the stage is, from 0 to 1: what most of it is. */
const brightness = (page) => page.evaluate(() => {
  const image = document.querySelector(".print-report figure img");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  let [light, dark] = [0, 0];
  for (let i = 0; i < data.length; i += 4) data[i] > 240 ? light++ : dark++;
  return { light: light / (light + dark), dark };
});

export async function a_report_has_picture_numbers_plots_settings_and_link(rig) {
  const page = await rig.open({ path: "/?length=1,0.5&theta=30,90", height: 1000, dark: true });
  await page.evaluate(() => {
    pendulumd.clock.pause();
    pendulumd.clock.seek(3);
    pendulumd.store.set({ title: "Our pendulum", view: { ruler: [0, 0, 0.3, 0.4] } });
  });
  await openDrawer(page, "share");
  await drawn(page);
  await asked(page);
  const found = await page.evaluate(() => {
    const paper = document.querySelector(".print-report");
    return { text: paper.textContent, rows: [...paper.querySelectorAll("tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent)),
      request: JSON.parse(paper.querySelector("pre").textContent), link: paper.querySelector(".report-link p").textContent,
      curves: paper.querySelector(".report-plots img").naturalHeight, code: Boolean(paper.querySelector("svg.qr")), body: pendulumd.store.get().pendulum.length };
  });
  assert.match(found.text, /Our pendulum.*The stage at 3\.00 s/s);
  assert.deepEqual(found.rows[0], ["Arm 1 at the pivot", "1 m", "1 kg", "30 °", "0 rad/s"]);
  assert.deepEqual(found.rows[1].slice(0, 4), ["Arm 2 on arm 1", "0.5 m", "1 kg", "90 °"]);
  assert.equal(found.rows[2][2], "–", "the formula is of a single arm");
  assert.match(found.rows[2][1], /^not periodic: \d+ swings of .* s$/, "swings that differ are no period");
  assert.match(found.text, /Ruler0\.500 m/);
  assert.deepEqual(found.request.pendulum.length, found.body, "the request is all of the settings");
  assert.equal(new URL(found.link).search, "?length=1,0.5&theta=30,90");
  assert.match(found.text, /cannot reach this address/);
  assert.ok(found.curves > 800 && found.code);
  const { light, dark } = await brightness(page);
  assert.ok(light > 0.9 && dark > 500, `black on white from a dark page: ${light}, ${dark} pixels`);
  const { pages, images, bytes } = await printed(page, "report");
  assert.ok(pages >= 2 && pages <= 4, `${pages} pages`);
  assert.ok(images >= 1 && bytes > 20000, `${images} images, ${bytes} bytes`);
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  const after = await page.evaluate(() => [document.querySelector(".print-report"), document.body.className, document.documentElement.dataset.theme]);
  assert.deepEqual(after, [null, "", "dark"], "the page is as it was");
  await close(page);
  return `${pages} pages, ${bytes} bytes`;
}

export async function the_browser_s_own_print_command_prints_a_report_a_worksheet_or_what_is_seen(rig) {
  const page = await rig.open({ path: "/?length=1,0.5&theta=30,90", dark: true });
  await page.evaluate(() => { window.print = () => { window.dialogs = (window.dialogs ?? 0) + 1; }; });
  await page.keyboard.press("Control+p");
  await page.waitForFunction(() => window.dialogs === 1 && document.querySelector(".print-report .report-link svg.qr"));
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  // the browser's menu tells nobody beforehand: the stage and what is open, on white, without the tools
  await openDrawer(page, "physics");
  await page.emulateMedia({ media: "print" });
  const seen = (selector) => page.evaluate((at) => [...document.querySelectorAll(at)].filter((one) => one.getClientRects().length).length, selector);
  assert.deepEqual([await seen("#timebar, .rail-row, .tools button, .card"), await seen(".canvas"), await seen(".arms-table tbody tr")], [0, 1, 2]);
  assert.equal(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), "rgb(250, 249, 246)");
  await page.emulateMedia({ media: null });
  await printed(page, "seen");
  await openDrawer(page, "worksheet");
  await page.click("[data-sheet=begin]");
  const steps = await page.locator(".steps li").count();
  await page.evaluate(() => window.dispatchEvent(new Event("beforeprint")));
  assert.equal(await seen(".print-sheet"), 0, "on the screen it is not seen");
  await page.emulateMedia({ media: "print" });
  assert.deepEqual([await seen(".print-sheet section"), await seen("#main")], [steps, 0]);
  await page.emulateMedia({ media: null });
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  const { pages } = await printed(page, "worksheet");
  assert.equal(await page.locator(".print-sheet").count(), 0, "the page is as it was");
  await close(page);
  return `a worksheet of ${steps} steps on ${pages} pages`;
}

export async function a_report_whose_files_do_not_come_is_told(rig) {
  const page = await rig.open();
  await openDrawer(page, "share");
  rig.front.fault = (request, reply) => {
    if (!request.url.includes("drawers/share/report.js")) return false;
    reply.writeHead(500).end();
    return true;
  };
  page.forgiven.push(/Failed to load resource/);
  await page.click("[data-share=report]");
  await page.waitForFunction(() => /could not be loaded/.test(document.querySelector(".notice").textContent));
  await close(page);
}
