// The motion for those who do not see it: in words when they are asked for, and as a tone; and what a page says whose tab was
// asleep or whose machine's clock jumped.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, drawn, moving, told } from "./rig.mjs";


export async function the_motion_is_told_in_words_when_they_are_asked_for(rig) {
  const page = await rig.open({ path: "/?length=1,1,1,1,1&theta=30,30,30,30,30", height: 1200 });
  await openDrawer(page, "measure");
  assert.equal(await page.textContent("[data-hear=words]"), "", "nothing is said unasked");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await page.focus("[data-hear=tell]");
  await page.keyboard.press("Enter");
  assert.equal(await page.getAttribute("[data-hear=words]", "role"), "status");
  const words = await page.textContent("[data-hear=words]");
  assert.match(words, /^At 0\.00 s\. Arm 1 is at 30° from the vertical, to the right, and is at rest;.* Arm 4 is at .* One more arm is not described\.$/);
  await page.evaluate(() => pendulumd.store.set({ pendulum: { length: [1], mass: [1], parent: [0], gravity: 9.81 }, initial: { phi: [-Math.PI / 3], phid: [0] } }));
  await moving(page);
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0.3); });
  await page.keyboard.press("Enter");
  // 2 pi sqrt(l / g) = 2.006 s, of 30 degrees 1.7 % longer
  assert.match(await page.textContent("[data-hear=words]"), /^At 0\.30 s\. Arm 1 is at 1\d° from the vertical, to the right, and swings clockwise; its largest angle in this motion is 30°\. It swings once in 2\.04 s\.$/);
  assert.deepEqual(await violations(page), []);
  await close(page);
}

/** Notes what a tone is set to: [name, value] in window.heard. */
const listen = (page) => page.addInitScript(() => {
  window.heard = [];
  const set = AudioParam.prototype.setTargetAtTime;
  AudioParam.prototype.setTargetAtTime = function note(value, ...more) {
    window.heard.push([this.maxValue > 1e30 ? "volume" : "pitch", value]);
    return set.call(this, value, ...more);
  };
});

export async function a_tone_follows_the_angle_and_is_silent_unless_it_is_wanted(rig) {
  const page = await rig.open({ cold: true, path: "/?length=1&theta=90" });
  await listen(page);
  await page.reload();
  await moving(page);
  await openDrawer(page, "measure");
  assert.equal(await page.evaluate(() => window.heard.length), 0, "off by default");
  await page.check("[data-hear=sound]");
  await page.evaluate(() => { window.heard.length = 0; pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  const last = (name) => page.evaluate((which) => window.heard.filter(([one]) => one === which).at(-1)[1], name);
  // an octave above hanging at 90 degrees
  assert.ok(Math.abs(await last("pitch") - 660) < 1e-6);
  assert.equal(await last("volume"), 0, "silent while it stands");
  await page.evaluate(() => pendulumd.clock.play());
  await page.waitForFunction(() => pendulumd.clock.time > 0.2);
  assert.ok(await last("volume") > 0 && await last("pitch") < 660);
  await page.click('[data-tab="share"]');
  await page.waitForFunction(() => window.heard.at(-1)[0] === "volume" && window.heard.at(-1)[1] === 0);
  await close(page);
}

/** A page whose clocks can be moved by seconds: window.wall, window.steady. */
async function withClocks(rig) {
  const page = await rig.open({ cold: true, width: 800 });
  await page.addInitScript(() => {
    Object.assign(window, { wall: 0, steady: 0 });
    const [date, performed] = [Date.now.bind(Date), performance.now.bind(performance)];
    Date.now = () => date() + 1000 * window.wall;
    performance.now = () => performed() + 1000 * window.steady;
  });
  await page.reload();
  await moving(page);
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1.5); });
  return page;
}

export async function clocks_that_jump_and_a_tab_that_slept_are_told_and_the_motion_goes_on_where_it_was(rig) {
  const page = await withClocks(rig);
  for (const [wall, steady, words] of [[3600, 0, /set forward by 60 minutes/], [-7200, 0, /set back by 120 minutes/], [3600, 3600, /asleep for 60 minutes/]]) {
    await page.evaluate(([a, b]) => {
      window.wall += a;
      window.steady += b;
      document.dispatchEvent(new Event("visibilitychange"));
    }, [wall, steady]);
    await told(page, words);
    assert.equal(await page.evaluate(() => pendulumd.clock.time), 1.5);
    await page.click(".notice button");
  }
  // what is asked for afterwards comes
  await page.evaluate(() => pendulumd.edits.setMass(2, 3));
  await moving(page);
  await close(page);
}

export async function nothing_is_drawn_while_the_clock_stands(rig) {
  const page = await rig.open({ cold: true, width: 800 });
  await page.evaluate(() => {
    window.strokes = 0;
    const { clearRect } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.clearRect = function counted(...place) {
      window.strokes++;
      return clearRect.apply(this, place);
    };
  });
  const drawnIn = async (ms) => {
    await page.evaluate(() => { window.strokes = 0; });
    await page.waitForTimeout(ms);
    return page.evaluate(() => window.strokes);
  };
  assert.ok(await drawnIn(300) > 3, "while it runs it is drawn");
  await page.evaluate(() => pendulumd.clock.pause());
  await drawn(page);
  assert.equal(await drawnIn(400), 0, "while it stands nothing is");
  await close(page);
}
