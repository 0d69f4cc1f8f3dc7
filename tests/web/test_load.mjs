// The page opens: a pendulum moves at once, in every window, and nothing else is asked.

import assert from "node:assert/strict";
import { close, drawn, moving } from "./rig.mjs";

export const rig = { sources: false };

/** Where the middle of an element lies in the window. */
const middleOf = (page, selector) => page.evaluate((at) => {
  const { left, right, top, bottom } = document.querySelector(at).getBoundingClientRect();
  return { x: (left + right) / 2, y: (top + bottom) / 2 };
}, selector);

export async function one_pendulum_moves_without_a_click_and_invites_to_be_dragged(rig) {
  const page = await rig.open({ path: "/", wait: false });
  await page.waitForFunction(() => window.pendulumd?.clock.playing && window.pendulumd.clock.time > 0);
  await moving(page);
  const { pendulum, initial, preset } = await page.evaluate(() => pendulumd.store.get());
  const single = await page.evaluate(() => pendulumd.client.preset("single"));
  assert.deepEqual([preset, pendulum.length, initial.phi], ["single", single.pendulum.length, single.initial.phi], "it is the server's first example");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await drawn(page);
  const { x, y } = await page.evaluate(() => pendulumd.stage.tip(1));
  const words = await middleOf(page, ".invite");
  const { left, top } = await page.evaluate(() => document.querySelector("#stage").getBoundingClientRect().toJSON());
  assert.ok(Math.hypot(words.x - left - x, words.y - top - y) < 50, "the words lie at the tip");
  await page.mouse.move(left + x, top + y);
  await page.mouse.down();
  await page.mouse.move(left + x - 30, top + y - 30, { steps: 3 });
  await page.mouse.up();
  await page.reload();
  await moving(page);
  assert.equal(await page.locator(".invite").count(), 0, "who has dragged it knows");
  await close(page);
}

export async function an_example_moves_under_the_pointer_and_is_told_in_every_language(rig) {
  const page = await rig.open({ path: "/" });
  await page.waitForSelector("[data-preset=kapitza]");
  const names = await page.evaluate(async () => { pendulumd.clock.pause(); return (await pendulumd.client.presets()).presets.map(({ name }) => name); });
  const shown = await page.locator(".preset").evaluateAll((cards) => cards.map((card) => card.dataset.preset));
  assert.deepEqual(shown.toSorted(), [...names, "side-by-side"].sort(), "every example of the server is shown, real pendulums too");
  assert.ok(names.length >= 21 && shown.indexOf("kapitza") < 6, "Kapitza's is within reach");
  const picture = (name) => page.evaluate((id) => document.querySelector(`[data-preset=${id}] canvas`).toDataURL(), name);
  for (const name of ["kapitza", "side-by-side"]) {
    const still = await picture(name);
    const { x, y } = await middleOf(page, `[data-preset=${name}] canvas`);
    await page.mouse.move(x, y);
    await page.waitForFunction(([id, before]) => document.querySelector(`[data-preset=${id}] canvas`).toDataURL() !== before, [name, still]);
    await page.mouse.move(2, 2);
  }
  for (const language of ["en", "de", "fr", "es", "nl", "tr"]) {
    await page.evaluate((id) => pendulumd.speak(id), language);
    await page.waitForSelector("[data-preset=mobile]");
    const words = await page.locator(".preset-words").evaluateAll((all) => all.map(({ textContent }) => textContent));
    assert.ok(words.length >= 22 && words.every((one) => one.length > 20) && new Set(words).size === words.length, `${language}: ${words}`);
  }
  await close(page);
}

export async function two_pendulums_side_by_side_have_lengths_and_masses_of_their_own(rig) {
  const page = await rig.open({ path: "/?example=side-by-side", width: 1366, height: 768 });
  const both = () => page.evaluate(() => { const { pendulum, ghosts } = pendulumd.store.get(); return [pendulum.length[0], ghosts[0].pendulum.length[0]]; });
  assert.deepEqual(await both(), [1, 0.25]);
  assert.equal(await page.title(), "Two side by side \u00b7 Pendulum Lab");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1); });
  await drawn(page);
  const tip = (other) => page.evaluate((second) => {
    const { left, top } = document.querySelector("#stage").getBoundingClientRect();
    const { x, y } = pendulumd.stage.tip(1, second);
    return { x: left + x, y: top + y };
  }, other);
  const [own, second] = [await tip(false), await tip(true)];
  assert.ok(second.x > own.x + 100 && second.y < own.y - 100, "the short one hangs to the right");
  const asked = page.asked.length;
  await page.mouse.click(second.x, second.y);
  assert.deepEqual(await both(), [0.25, 1], "a click chooses it for the tools");
  assert.deepEqual(await page.evaluate(() => [pendulumd.clock.time, pendulumd.motion.complete, pendulumd.motion.track.doc.pendulum === pendulumd.store.get().pendulum]), [1, true, true]);
  await drawn(page);
  const now = await tip(false);
  assert.ok(Math.hypot(now.x - second.x, now.y - second.y) < 1, "where it was");
  assert.equal(page.asked.slice(asked).filter((one) => one.url().includes("/v1/traj")).length, 0, "and nothing is computed anew");
  await page.evaluate(() => pendulumd.edits.setMass(1, 3));
  await page.click("[data-act=swap]");
  assert.deepEqual(await page.evaluate(() => [pendulumd.store.get().pendulum.mass[0], pendulumd.store.get().ghosts[0].pendulum.mass[0]]), [1, 3]);
  await moving(page);
  // another arm comes to both, and the second one goes as any ghost does
  await page.evaluate(() => pendulumd.edits.add(1));
  await moving(page);
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().ghosts[0].pendulum.parent), [0, 1]);
  await page.evaluate(() => pendulumd.edits.remove(2));
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().ghosts[0].pendulum.parent), [0]);
  await close(page);
}

export async function the_page_is_dark_where_the_system_is_and_the_switch_turns_it(rig) {
  const page = await rig.open({ dark: true });
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.equal(await paper(), "rgb(20, 23, 29)");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(5.5); });
  await page.waitForSelector('[data-preset="mobile"]:not([disabled])');
  await rig.shot(page, "dark");
  await page.click('[data-act="theme"]');
  assert.equal(await paper(), "rgb(250, 249, 246)");
  await page.reload();
  assert.equal(await paper(), "rgb(250, 249, 246)", "the choice is kept");
  await close(page);
}

export async function all_of_the_page_is_smaller_than_320_kB(rig) {
  // in one language: nobody asks for the others
  const page = await rig.open({ path: "/" });
  await page.waitForFunction(() => pendulumd.motion.stats);
  const sent = () => page.evaluate(() => [...performance.getEntriesByType("resource"), ...performance.getEntriesByType("navigation")]
    .filter(({ name }) => !name.includes("/v1/")).reduce((sum, { encodedBodySize }) => sum + encodedBodySize, 0));
  const opening = await sent();
  for (const tab of await page.locator("[data-tab]").all()) {
    await tab.click();
    const id = await tab.getAttribute("data-tab");
    await page.waitForFunction((which) => !document.querySelector(`[data-drawer="${which}"]`).hasAttribute("aria-busy"), id);
  }
  await page.waitForSelector('[data-drawer="equations"] .katex', { state: "attached" });
  const all = await sent();
  assert.ok(opening > 20000 && opening < 150000 && opening < all && all < 320000, `${opening} bytes at first, ${all} in all`);
  await close(page);
  return `${opening} bytes at first, ${all} with every drawer opened`;
}

export async function nothing_jumps_while_the_page_opens(rig) {
  for (const size of [{ width: 1280, height: 800 }, { width: 390, height: 844, isMobile: true, touch: true }]) {
    const page = await rig.open({ path: "/", ...size });
    await page.waitForFunction(() => pendulumd.motion.stats);
    await drawn(page);
    const shift = await page.evaluate(() => new Promise((resolve) => {
      const found = { sum: 0, what: [] };
      new PerformanceObserver((list) => list.getEntries().forEach((entry) => {
        found.sum += entry.value;
        found.what.push(...entry.sources.map(({ node }) => node?.outerHTML?.slice(0, 60)));
      })).observe({ type: "layout-shift", buffered: true });
      setTimeout(() => resolve(found), 100);
    }));
    assert.ok(shift.sum < 0.05, `layout shift ${shift.sum} of ${shift.what.join(" | ")}`);
    const head = await page.evaluate(() => ({ title: document.title, lang: document.documentElement.lang, viewport: !!document.querySelector("meta[name=viewport]"),
      description: document.querySelector("meta[name=description]").content.length }));
    assert.ok(head.title && head.lang === "en" && head.viewport && head.description > 20);
    const small = await page.evaluate(() => [...document.querySelectorAll("button, select, input, a")].filter((element) => {
      const { width, height } = element.getBoundingClientRect();
      return width && !element.closest(".unseen") && Math.min(width, height) < 22;
    }).map((element) => element.outerHTML.slice(0, 90)));
    assert.deepEqual(small, [], "targets large enough for a finger");
    await close(page);
  }
}

export async function a_first_visit_asks_at_most_four_times_until_the_pendulum_swings(rig) {
  for (const language of ["en", "de"]) {
    const page = await rig.open({ path: "/docs", wait: false, cold: true, language });
    await page.goto("about:blank");
    await page.session.send("Network.clearBrowserCache");
    const asked = [];
    page.on("request", (request) => request.url().startsWith("http") && asked.push(new URL(request.url()).pathname));
    await page.goto(rig.url);
    await page.waitForFunction(() => window.pendulumd?.clock.time > 0);
    await page.waitForSelector('[data-preset="mobile"]');
    await page.waitForFunction(() => pendulumd.motion.stats);
    await drawn(page);
    // what was asked before the motion was there, and how much it weighs; the examples and their words are asked for then
    const sent = await page.evaluate(() => [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
      .filter(({ name }) => !/engine|presets|examples/.test(name)).reduce((sum, { transferSize }) => sum + transferSize, 0));
    assert.ok(sent > 100000 && sent < 200000, `${sent} bytes are sent until the pendulum swings`);
    const needed = await page.evaluate(() => {
      const files = performance.getEntriesByType("resource");
      const motion = files.find(({ name }) => name.endsWith("/v1/trajectories"));
      return [location.href, ...files.filter(({ startTime }) => startTime < motion.responseEnd).map(({ name }) => name)];
    });
    // the words of another language than English are one more, asked for beside the page's script
    const most = language === "en" ? 3 : 4;
    assert.ok(needed.length >= 3 && needed.length <= most, `${needed.length} requests: ${needed.join(" ")}`);
    // so is the engine, where the server has it
    const engine = await page.evaluate(() => "engine" in document.documentElement.dataset);
    const more = asked.filter((path) => !/engine(_worker\.js|\.wasm)$/.test(path));
    assert.ok(more.length <= most + 2, `${more.length} requests with the examples: ${more.join(" ")}`);
    const motions = () => asked.filter((path) => path === "/v1/trajectories").length;
    assert.equal(motions(), 1, "no motion is computed twice");
    // the examples move for who comes near them, by the engine where it has come
    if (engine) await page.waitForFunction(() => pendulumd.client.engine.ready);
    await page.hover('[data-preset="double"]');
    while (!engine && motions() < 3) await page.waitForTimeout(20);
    await drawn(page);
    if (engine) assert.equal(motions(), 1, "no server is asked for a quick motion");
    await close(page);
  }
}
