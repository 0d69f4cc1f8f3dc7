// What a screen reader says of the stage: its picture in words, the arms as buttons, what keys and pointers have done.
// Leaves to others: colours and rules (test_axe.mjs), what the keys do (test_keys.mjs).
// Invariant: the words are those of the browser's own accessibility tree.

import assert from "node:assert/strict";
import { close, moving } from "./rig.mjs";

/** The lines of an element's accessibility tree. */
const heard = async (page, selector) => (await page.locator(selector).ariaSnapshot()).split("\n").map((line) => line.trim().replace(/^- '(.*)'$/, "- $1").replace(/^(- text: )"(.*)"$/, "$1$2"));
const said = (page) => page.textContent("#live");

export async function the_stage_is_told_in_words(rig) {
  const page = await rig.open({ path: "/", still: true, width: 1366, height: 768 });
  assert.deepEqual(await heard(page, "#stage"), [
    '- img "A pendulum of one arm in motion. Its arm is a button, next in the order of the tab key."',
    '- group "Arms of the pendulum":',
    '- button "Arm 1 at the pivot: 1 m, 1 kg, starts at 40° from the vertical"',
    '- group "Forces in the arms":',
    "- text: −15 −7.5 0 7.5 15 N tension: pulls the tip towards the joint compression: pushes the tip away from the joint",
    '- button "Forces as arrows"',
    '- button "Red and blue, as in the paper"',
  ]);
  await page.focus("[data-arm='1']");
  for (const [key, words] of [["ArrowLeft", /^Arm 1 at the pivot: 1 m, 1 kg, starts at 45° from the vertical$/], ["Shift+ArrowUp", /1\.05 m, 1 kg/], ["+", /1\.05 m, 1\.1 kg/],
    ["a", /^Arm 2 added to arm 1$/], ["t", /^Trail of arm 2 (shown|hidden)$/], ["Delete", /^Arm 2 deleted$/], ["Delete", /^The last arm cannot be deleted/], ["Control+z", /^Undone: deleting an arm$/]]) {
    await page.keyboard.press(key);
    assert.match(await said(page), words, key);
  }
  await moving(page);
  assert.ok((await heard(page, "#stage")).includes('- img "A pendulum of 2 arms in motion. Its arms are buttons, next in the order of the tab key."'));
  await page.evaluate(() => pendulumd.edits.select(2));
  const card = await heard(page, ".card");
  for (const part of ['- group "Selected arm":', "- strong: Arm 2", '- button "Close"', '- textbox "Length in m": "1.05"', '- button "Add an arm"'])
    assert.ok(card.some((line) => line.startsWith(part)), `${part} in ${card.join(" | ")}`);
  await page.evaluate(() => pendulumd.edits.addBeside());
  await moving(page);
  assert.ok((await heard(page, "#stage")).includes('- button "Select the other pendulum"'));
  await page.click("[data-act=swap]");
  assert.match(await said(page), /^The other pendulum is selected: 0\.525 m$/);
  await page.evaluate(() => pendulumd.complain("This link cannot be read."));
  assert.ok((await heard(page, "#stage .notice")).some((line) => line.includes("This link cannot be read.")));
  await close(page);
}
