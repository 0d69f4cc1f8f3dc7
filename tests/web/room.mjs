// What the tests of classes share: a teacher's page with a room, pupils' pages in it, what stands there.
// Leaves to others: what is tested (test_room*.mjs), the thirty of them (lesson.mjs).
// Invariant: each page is a browser of its own; whoever waits, waits for what a person sees or for what the room has.

import { openDrawer } from "./drawers.mjs";

const BY_TIME = { polling: 100 }; // ms: of thirty windows on one machine some get no frames for a long while

/** A page with a room of its own, which only the tab knows unless it is remembered: {page, code}. */
export async function teach(rig, { remembered, ...options } = {}) {
  const page = await rig.open({ width: 1280, height: 900, ...options });
  await openDrawer(page, "class");
  if (remembered) await page.check("[data-class=remember]");
  await page.click("[data-class=make]");
  const code = await page.textContent(".room-code");
  return { page, code };
}

/** A pupil's page, joined. */
export async function join(rig, code, nickname, options = {}) {
  const page = await rig.open({ width: 900, height: 800, path: `/?room=${code}`, still: true, ...options });
  await page.waitForSelector("[data-class=nickname]");
  await page.fill("[data-class=nickname]", nickname);
  await page.press("[data-class=nickname]", "Enter");
  await page.waitForSelector(".class-now");
  return page;
}

/** Waits until the pupil's page says so, in the drawer or at the head. */
export const says = (page, words) => page.waitForFunction((source) => new RegExp(source).test(document.querySelector(".class-now")?.textContent ?? ""), words.source, BY_TIME);

/** The arms of the pendulum on a page's stage. */
export const arms = (page) => page.evaluate(() => pendulumd.store.get().pendulum.length.length);

/** Waits until the stage has so many arms. */
export const hasArms = (page, count) => page.waitForFunction((n) => pendulumd.store.get().pendulum.length.length === n, count, BY_TIME);

/** Puts a chain on a page's stage: lengths, and angles from hanging in degrees. */
export const setChain = (page, length, degrees) => page.evaluate(([lengths, angles]) => {
  const phi = angles.map((angle) => -Math.PI / 2 + angle * Math.PI / 180);
  pendulumd.store.set({ pendulum: { length: lengths, mass: lengths.map(() => 1), parent: lengths.map((_, k) => k), gravity: 9.81 },
    initial: { phi, phid: phi.map(() => 0) }, ghosts: [], view: { trails: [1], selected: 0 } });
}, [length, degrees]);

/** The cell of a pupil on the teacher's wall, once it says so. */
export const cell = (page, nickname) => page.locator(".cell", { has: page.locator(".cell-name", { hasText: nickname }) });
