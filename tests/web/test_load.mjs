// The page opens: the paper's pendulum moves at once, in every window, light and dark, and nothing else is asked.

import assert from "node:assert/strict";
import { close } from "./rig.mjs";

export async function the_paper_s_pendulum_moves_when_the_page_is_opened(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => window.pendulumd.clock.time > 0.2);
  const before = await page.evaluate(() => window.pendulumd.clock.time);
  await page.waitForTimeout(200);
  assert.ok(await page.evaluate(() => window.pendulumd.clock.time) > before);
  await rig.shot(page, "load");
  await close(page);
}
