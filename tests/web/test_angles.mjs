// Angles as schoolbooks have them wherever they are read or typed: from hanging, in degrees, counterclockwise; tables of them
// for spreadsheets of both kinds.

import assert from "node:assert/strict";
import { openDrawer, saved } from "./drawers.mjs";
import { close, drawn, pause } from "./rig.mjs";


export async function ninety_degrees_are_horizontal_and_grow_against_the_clock(rig) {
  const page = await rig.open();
  await pause(page);
  await page.evaluate(() => pendulumd.edits.select(1));
  const field = page.locator("[data-field=angle]");
  for (const [typed, place] of [["90", [1, 0]], ["0", [0, -1]], ["30", [0.5, -Math.sqrt(3) / 2]], ["-90", [-1, 0]], ["180", [0, 1]]]) {
    await field.fill(typed);
    await field.press("Enter");
    await page.waitForFunction(() => pendulumd.motion.complete);
    await pause(page);
    await drawn(page);
    assert.equal(Number((await field.inputValue()).replace("−", "-")), Number(typed));
    const tip = await page.evaluate(() => {
      const { length } = pendulumd.store.get().pendulum;
      const [from, to] = [pendulumd.stage.tip(0), pendulumd.stage.tip(1)];
      const far = Math.hypot(to.x - from.x, to.y - from.y);
      return { x: (to.x - from.x) / far, y: (from.y - to.y) / far, length: length[0] };
    });
    assert.ok(Math.hypot(tip.x - place[0], tip.y - place[1]) < 1e-3, `${typed}°: ${JSON.stringify(tip)}`);
  }
  assert.match(await field.getAttribute("aria-label"), /from the downward vertical, counterclockwise/);
  assert.match(await page.textContent("button[data-arm='1']"), /starts at 180° from the vertical/);
  await field.fill("450");
  await field.press("Enter");
  assert.equal(await field.inputValue(), "90", "a full turn more is the same start");
  await page.evaluate(() => pendulumd.store.set({ initial: { ...pendulumd.store.get().initial, phi: pendulumd.store.get().initial.phi.map(() => 1e30) } }));
  const wanted = await page.evaluate(() => (Math.atan2(Math.cos(1e30), -Math.sin(1e30)) * 180) / Math.PI);
  const far = await page.evaluate((words) => pendulumd.text.read(words), await field.inputValue());
  assert.ok(Math.abs(far - wanted) < 0.01, `1e30 rad is shown as ${far} degrees: ${wanted}`);
  await field.fill("40");
  await field.press("Enter");
  await page.waitForFunction(() => pendulumd.motion.complete);
  await pause(page);
  await drawn(page);
  await rig.shot(page, "angle");
  await close(page);
}

/** A table's rows as a spreadsheet with these separators reads them. */
function rowsOf(bytes, decimal, between) {
  const text = bytes.toString("utf8");
  assert.equal(text.charCodeAt(0), 0xfeff, "a spreadsheet is told that it is UTF-8");
  const lines = text.slice(1).trimEnd().split("\r\n").map((line) => line.split(between));
  return { head: lines[0], rows: lines.slice(1).map((line) => line.map((cell) => Number(cell.replace(decimal, ".")))) };
}

export async function a_table_opens_in_a_german_and_in_an_english_spreadsheet(rig) {
  for (const [language, own, other] of [["en", [".", ","], ["comma", ",", ";"]], ["de-DE", [",", ";"], ["point", ".", ","]]]) {
    const page = await rig.open({ language, height: 1200 });
    await openDrawer(page, "plots");
    const first = rowsOf((await saved(page, "[data-save=table]")).bytes, ...own);
    assert.equal(first.rows.length, 2001);
    assert.match(first.head.join("|"), language === "en" ? /^time t in s\|angle θ1 in °\|/ : /^Zeit t in s\|Winkel θ1 in °\|/);
    const shown = await page.evaluate(() => {
      const { columns, t, n } = pendulumd.motion;
      const i = 777;
      return [t[i], ...[...columns.phi.subarray(i * n, i * n + n)].map((phi) => phi * 180 / Math.PI + 90), ...columns.phid.subarray(i * n, i * n + n)];
    });
    shown.forEach((value, k) => assert.ok(Math.abs(first.rows[777][k] - value) <= 1e-8 * Math.abs(value), `${first.head[k]}: ${first.rows[777][k]}, not ${value}`));
    const energy = first.rows.map((row) => row.at(-1));
    assert.ok(Math.max(...energy) - Math.min(...energy) < 1e-6, "the last column is the energy, which stays");
    // the height of the first tip from its angle: 0 of the pivot
    assert.ok(Math.abs(first.rows[777][9 + 4] + 2 * Math.cos(first.rows[777][1] * Math.PI / 180)) < 1e-7);
    await page.selectOption("[data-drawer=plots] .number-files select", other[0]);
    const second = rowsOf((await saved(page, "[data-save=table]")).bytes, other[1], other[2]);
    assert.deepEqual(second.rows, first.rows, "other separators, the same numbers");
    await page.locator(".number-files").scrollIntoViewIfNeeded();
    await rig.shot(page, `table-${language.slice(0, 2)}`);
    await close(page);
  }
}

export async function what_the_interface_has_is_said_where_requests_are_shown(rig) {
  const page = await rig.open({ height: 1200 });
  for (const id of ["plots", "share", "equations"]) {
    const drawer = await openDrawer(page, id);
    assert.match(await page.innerText(drawer), /θ = φ \+ 90°/, id);
  }
  await close(page);
}
