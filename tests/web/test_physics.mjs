// Physics: sliders that change the pendulum while it moves; what they show is what is asked of the server and what it answers.

import assert from "node:assert/strict";
import { violations } from "./axe.mjs";
import { bodiesOf } from "./bidi.mjs";
import { openDrawer } from "./drawers.mjs";
import { close, doc, drawn, moving } from "./rig.mjs";

const TURN = 2 * Math.PI;
/** Until nothing waits and the motion is the document's. */
const settled = (page) => page.waitForFunction(() => !pendulumd.live.waiting() && !pendulumd.motion.loading && pendulumd.motion.complete
  && pendulumd.motion.doc === pendulumd.store.get());

async function open(rig, preset, options) {
  const page = await rig.open(options);
  if (preset) {
    await openDrawer(page, "presets");
    await page.click(`[data-preset="${preset}"]`);
    await page.waitForFunction((name) => pendulumd.store.get().preset === name && pendulumd.motion.complete, preset);
  }
  await openDrawer(page, "physics");
  return page;
}

async function type(page, name, value) {
  await page.fill(`[data-number="${name}"]`, String(value));
  await page.press(`[data-number="${name}"]`, "Enter");
  await settled(page);
}

/** The start of the document as the server has it for an earlier one at that time: the largest difference. */
const startOff = (page, before) => page.evaluate(async (earlier) => {
  const now = pendulumd.store.get();
  const { phi, phid } = await pendulumd.client.trajectory({ pendulum: earlier.pendulum, initial: earlier.initial, output: ["phi", "phid"],
    times: { start: earlier.span.start ?? 0, stop: now.span.start, step: earlier.span.step } });
  const last = phi.length - 1;
  return Math.max(...now.initial.phi.map((angle, k) => Math.max(Math.abs(angle - phi[last][k]), Math.abs(now.initial.phid[k] - phid[last][k]))));
}, before);

export async function a_slider_changes_the_motion_that_goes_on_from_where_it_is(rig) {
  const page = await open(rig, "double");
  await page.waitForFunction(() => pendulumd.clock.time > 0.5);
  const before = await doc(page);
  const times = await page.evaluate(async () => {
    const slider = document.querySelector('[data-slider="damping"]');
    const list = [];
    const forget = pendulumd.clock.subscribe(({ time }) => list.push((pendulumd.motion.doc.span.start ?? 0) + time));
    slider.value = 600;
    slider.dispatchEvent(new Event("input"));
    slider.dispatchEvent(new Event("change"));
    while (list.at(-1) < 1.5 || pendulumd.motion.loading) await new Promise((done) => { setTimeout(done, 30); });
    forget();
    return list;
  });
  const after = await doc(page);
  assert.ok(after.pendulum.damping.every((c) => c > 0) && after.span.start > 0.5);
  assert.ok(await startOff(page, before) < 1e-9, "it goes on from the state of that time");
  const back = times.filter((time, i) => i && time < times[i - 1] - 1e-9);
  assert.deepEqual(back, [], "time does not go back");
  const most = Math.max(...times.map((time, i) => (i ? time - times[i - 1] : 0)));
  assert.ok(most < 0.11, `time goes on by at most a frame, not by ${most} s`);
  await page.keyboard.press("Control+z");
  assert.deepEqual((await doc(page)).pendulum, before.pendulum, "one hand's way is one step");
  assert.deepEqual((await doc(page)).initial, before.initial);
  await close(page);
}

export async function a_drag_asks_seldom_and_ends_with_what_the_slider_shows(rig) {
  const page = await open(rig, "double");
  let asked = 0;
  page.on("request", (one) => { asked += one.url().endsWith("/v1/trajectories"); });
  const took = await page.evaluate(async () => {
    const slider = document.querySelector('[data-slider="dry"]');
    const begun = performance.now();
    for (let i = 1; i <= 120; i++) {
      slider.value = 5 * i;
      slider.dispatchEvent(new Event("input"));
      await new Promise((done) => { setTimeout(done, 8); });
    }
    slider.dispatchEvent(new Event("change"));
    return performance.now() - begun;
  });
  await settled(page);
  assert.ok(asked >= 2 && asked <= took / 120 + 3, `${asked} requests in ${Math.round(took)} ms`);
  const { pendulum } = await doc(page);
  const shown = Number(await page.inputValue('[data-number="dry"]'));
  assert.deepEqual(pendulum.friction, [{ torque: shown, speed: 0.05 }, { torque: shown, speed: 0.05 }]);
  assert.ok(shown > 0);
  await close(page);
  return `${asked} requests in ${Math.round(took)} ms of dragging`;
}

/** What each number that is typed becomes in the pendulum, and that the server's motion of it is what the page has. */
export async function every_number_is_the_request_s_and_the_motion_the_server_s(rig) {
  const page = await open(rig, "double");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await page.selectOption("[data-scope]", "2");
  const typed = { gravity: 1.62, damping: 0.3, dry: 0.2, drag: 0.1, quadratic: 0.4, everywhere: 0.05, stiffness: 3, rest: 30, rod: 0.7, tip: 0.2,
    motor: 1.5, motorRate: 0.5, constant: -0.25, up: 0.1, upRate: 2, aside: 0.05, asideRate: 3 };
  for (const [name, value] of Object.entries(typed)) await type(page, name, value);
  const { pendulum } = await doc(page);
  assert.deepEqual({ ...pendulum, rest: null }, { length: [1, 1], mass: [1, 0.2], parent: [0, 1], gravity: 1.62, damping: [null, 0.3],
    friction: [null, { torque: 0.2, speed: 0.05 }], drag: [null, { linear: 0.1, quadratic: 0.4 }], drag_per_mass: 0.05, stiffness: [null, 3], rest: null,
    rod: [null, 0.7], torque: [null, { constant: -0.25, harmonics: [{ amplitude: 1.5, omega: 0.5 * TURN, phase: 0 }] }],
    pivot: { x: { harmonics: [{ amplitude: 0.05, omega: 3 * TURN, phase: 0 }] }, y: { harmonics: [{ amplitude: 0.1, omega: 2 * TURN, phase: 0 }] } } });
  assert.ok(Math.abs(pendulum.rest[1] - Math.PI / 6) < 1e-15);
  for (const [name, value] of Object.entries(typed)) assert.equal(Number((await page.inputValue(`[data-number="${name}"]`)).replace("\u2212", "-")), value, name);
  const off = await page.evaluate(async () => {
    const { store, client, motion } = pendulumd;
    const { pendulum: tree, initial, span } = store.get();
    const { phi, exchange } = await client.trajectory({ pendulum: tree, initial, times: { start: 0, stop: 2, step: span.step }, output: ["phi", "exchange"] });
    return Math.max(...phi.map((row, i) => Math.max(...row.map((angle, k) => Math.abs(angle - motion.columns.phi[2 * i + k])),
      Math.abs(exchange.heat[i] - motion.columns.exchange_heat[i]))));
  });
  assert.equal(off, 0, "to the bit");
  await page.click("[data-clear]");
  await settled(page);
  assert.deepEqual((await doc(page)).pendulum, { length: [1, 1], mass: [1, 0.2], parent: [0, 1], gravity: 1.62, rod: [null, 0.7] });
  await type(page, "rod", 0);
  await type(page, "tip", 0);
  assert.deepEqual((await doc(page)).pendulum.mass, [1, 0.001], "an arm has some mass");
  await page.click('[data-place="jupiter"]');
  await settled(page);
  assert.equal((await doc(page)).pendulum.gravity, 24.79);
  assert.equal(await page.getAttribute('[data-place="jupiter"]', "aria-pressed"), "true");
  await page.fill('[data-number="damping"]', "-1");
  await page.press('[data-number="damping"]', "Enter");
  assert.equal(await page.getAttribute('[data-number="damping"]', "aria-invalid"), "true");
  await close(page);
}

export async function carts_bodies_and_pivots_that_go_faster_are_the_request_s_and_move_as_the_server_says(rig) {
  const page = await open(rig, "double", { height: 1000 });
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(0); });
  await page.selectOption("[data-scope]", "2");
  assert.ok(await page.isDisabled('[data-number="rail"]') && await page.isDisabled('[data-number="inertia"]'), "nothing to be a number of");
  const typed = { cart: 2, rail: 10, cartDamping: 0.5, cartStiffness: 4, cartForce: -1, cartPush: 3, cartRate: 0.8,
    body: 0.7, along: 0.4, across: -0.1, inertia: 0.02, hangsAlong: 0.5, hangsAcross: 0.2 };
  for (const [name, value] of Object.entries(typed)) await type(page, name, value);
  const { pendulum } = await doc(page);
  const { angle, ...cart } = pendulum.pivot.cart;
  assert.ok(Math.abs(angle - Math.PI / 18) < 1e-15);
  assert.deepEqual(cart, { mass: 2, damping: 0.5, stiffness: 4, force: { constant: -1, harmonics: [{ amplitude: 3, omega: 0.8 * TURN, phase: 0 }] } });
  assert.deepEqual([pendulum.body, pendulum.at], [[null, { mass: 0.7, center: [0.4, -0.1], inertia: 0.02 }], [null, [0.5, 0.2]]]);
  for (const [name, value] of Object.entries(typed)) assert.equal(Number((await page.inputValue(`[data-number="${name}"]`)).replace("\u2212", "-")), value, name);
  const off = await page.evaluate(async () => {
    const { store, client, motion } = pendulumd;
    const { pendulum: tree, initial, span } = store.get();
    const { cart: told } = await client.trajectory({ pendulum: tree, initial, times: { start: 0, stop: 2, step: span.step }, output: ["cart"] });
    return Math.max(...told.x.map((x, i) => Math.abs(x - motion.columns.cart_x[i])));
  });
  assert.equal(off, 0, "to the bit");
  await page.evaluate(() => { pendulumd.clock.seek(1.2); document.querySelector("[data-group=cart]").scrollIntoView({ block: "start" }); });
  await drawn(page);
  await rig.shot(page, "physics-cart");
  assert.deepEqual(await violations(page, { context: { include: ['[data-drawer="physics"]'] } }), []);
  assert.ok(await page.isDisabled('[data-number="fasterUp"]'), "a cart is not drawn away");
  await page.evaluate(() => pendulumd.clock.seek(0));
  for (const name of ["cart", "body"]) await type(page, name, 0);
  await type(page, "fasterUp", -9.81);
  const bare = (await doc(page)).pendulum;
  assert.deepEqual([bare.pivot, bare.body], [{ acceleration: [0, -9.81] }, undefined]);
  await close(page);
}

export async function another_frequency_in_the_midst_of_the_motion_moves_the_pivot_by_nothing(rig) {
  const page = await open(rig, "kapitza");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(1.234); });
  await drawn(page);
  const pivot = () => page.evaluate(() => pendulumd.stage.tip(0));
  const before = await pivot();
  const { x, y } = await page.evaluate(() => pendulumd.stage.tip(1));
  await type(page, "upRate", 25);
  await drawn(page);
  const after = await pivot();
  assert.ok(Math.hypot(after.x - before.x, after.y - before.y) < 0.01, "the pivot stays");
  const tip = await page.evaluate(() => pendulumd.stage.tip(1));
  assert.ok(Math.hypot(tip.x - x, tip.y - y) < 0.01, "the tip stays");
  const { span, pendulum } = await doc(page);
  assert.equal(span.start, 1.234);
  assert.ok(Math.abs(pendulum.pivot.y.harmonics[0].omega - 50 * Math.PI) < 1e-12);
  await close(page);
}

/** What the bars say, J. */
const bars = (page) => page.evaluate(() => Object.fromEntries([...document.querySelectorAll("[data-energy]")].map((row) => {
  const [front, power = ""] = row.querySelector(".energy-value").textContent.replace(" J", "").replaceAll("\u2212", "-").split("\u00b710");
  const digits = [...power].map((letter) => "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079".indexOf(letter));
  return [row.dataset.energy, Number(front) * 10 ** Number(digits.map((digit) => (digit ? digit - 1 : "-")).join(""))];
})));

export async function the_bars_of_energy_are_the_server_s_and_their_balance_stays(rig) {
  const page = await open(rig, null);
  await page.evaluate(() => pendulumd.store.set({ ghosts: [], pendulum: { length: [0.5, 0.4], mass: [0.2, 0], parent: [0, 1], gravity: 9.81, rod: [null, 0.3],
    damping: [0.01, 0.02], stiffness: [null, 0.6], torque: [{ constant: 0.1, harmonics: [{ amplitude: 0.5, omega: 6 }] }, null] }, initial: { phi: [-0.6, -1], phid: [0, 0] } }));
  await settled(page);
  const times = [0, 1.5, 6];
  const told = await page.evaluate(async () => {
    const { pendulum, initial, span } = pendulumd.store.get();
    const { energy, exchange } = await pendulumd.client.trajectory({ pendulum, initial, times: { start: 0, stop: 6, step: span.step }, output: ["energy", "exchange"] });
    return { kinetic: energy.kinetic, heat: exchange.heat, work: exchange.work };
  });
  const rows = [];
  for (const time of times) {
    await page.evaluate((t) => { pendulumd.clock.pause(); pendulumd.clock.seek(t); }, time);
    await drawn(page);
    const shown = await bars(page);
    for (const [kind, values] of Object.entries(told)) {
      const value = values[Math.round(time * 100)];
      assert.ok(Math.abs(shown[kind] - value) <= 6e-3 * Math.abs(value), `${kind} at ${time} s: ${shown[kind]}, the server has ${value}`);
    }
    rows.push(shown);
  }
  assert.ok(rows[2].heat > rows[1].heat && rows[1].heat > 0.01 && rows.some(({ springs }) => springs > 0.01) && rows.every(({ height }) => height >= 0));
  assert.ok(rows.every(({ balance }) => balance > 0.1 && balance === rows[0].balance), JSON.stringify(rows));
  await close(page);
}

export async function potential_energy_is_0_at_the_lowest_position_wherever_it_is_shown(rig) {
  const page = await open(rig, null);
  // damping takes a pendulum whose parts hang off their arms' lines to its lowest position, where the server counts from the pivot
  await page.evaluate(() => pendulumd.store.set({ ghosts: [], span: { stop: 40, step: 0.01 }, pendulum: { length: [0.5, 0.4], mass: [0.2, 0.1], parent: [0, 1], gravity: 9.81,
    rod: [0.3, null], body: [null, { mass: 0.4, inertia: 0.002, center: [0.1, 0.07] }], at: [null, [0.3, -0.1]], damping: [0.3, 0.3] }, initial: { phi: [-0.6, -1], phid: [0, 0] } }));
  await settled(page);
  const { potential, server, sums } = await page.evaluate(async () => {
    const [{ energiesIn }, { energiesOf, scaleOf }] = await Promise.all(["kit/plot_data", "physics/energy_bars"].map((name) => import(`/page/sources/drawers/${name}.js`)));
    const { motion } = pendulumd;
    const [, potential, total] = energiesIn(motion);
    const end = motion.count - 1;
    const bars = (i) => energiesOf(motion.track, i, scaleOf(motion.track).zero).slice(0, 3).reduce((a, b) => a + b);
    return { potential: potential[end], server: motion.columns.energy_potential[end], sums: [0, 500, end].map((i) => [total[i], bars(i)]) };
  });
  assert.ok(Math.abs(potential) < 1e-7 && server < -1, `${potential} J, the server's ${server} J`);
  for (const [plot, bars] of sums) assert.ok(Math.abs(plot - bars) < 1e-9, `the plot has ${plot} J, the bars have ${bars} J`);
  await close(page);
}

export async function sliders_obey_keys_and_axe_finds_nothing_in_light_dark_and_on_a_phone(rig) {
  for (const [name, options] of Object.entries({ light: { height: 1000 }, dark: { height: 1000, dark: true, language: "de" }, phone: { width: 390, height: 844, touch: true } })) {
    const page = await open(rig, name === "phone" ? null : "coupled", options);
    await page.evaluate(() => pendulumd.clock.pause());
    await page.focus('[data-slider="damping"]');
    for (let i = 0; i < 3; i++) await page.keyboard.press("ArrowRight");
    await settled(page);
    const { pendulum } = await doc(page);
    assert.ok(pendulum.damping?.[0] > 0, "a key moves the slider");
    const said = await page.getAttribute('[data-slider="damping"]', "aria-valuetext");
    assert.match(said, /N·m·s$/);
    await page.evaluate(() => document.querySelector('[data-drawer="physics"]').scrollIntoView({ block: "start" }));
    await drawn(page);
    await rig.shot(page, `physics-${name}`);
    assert.deepEqual(await violations(page, { context: { include: ['[data-drawer="physics"]'] } }), [], name);
    const wide = await page.evaluate(() => document.querySelector('[data-drawer="physics"]').scrollWidth - document.querySelector('[data-drawer="physics"]').clientWidth);
    assert.ok(wide <= 0, `${name}: ${wide} pixels too wide`);
    await close(page);
  }
}

export async function a_change_that_the_server_refuses_is_said_and_can_be_undone(rig) {
  const page = await open(rig, "single");
  await page.evaluate(() => pendulumd.live.change("bad", (tree) => ({ ...tree, damping: [-1] })));
  page.forgiven.push(/422/);
  await page.waitForSelector(".notice.bad:not([hidden])");
  await page.evaluate(() => pendulumd.undo());
  await moving(page);
  await settled(page);
  assert.equal(await page.evaluate(() => pendulumd.motion.failure), null);
  await close(page);
}

/** The values of the map and of its own answers asked alone: the largest difference over some points. */
export async function a_map_of_two_numbers_is_the_server_s_and_a_point_of_it_starts_its_pendulum(rig) {
  const page = await open(rig, "driven-damped", { height: 1000 });
  await page.evaluate(() => pendulumd.clock.pause());
  await page.selectOption("[data-map=across]", "motor");
  await page.selectOption("[data-map=up]", "damping");
  await page.selectOption("[data-map=what]", "chaos");
  const asked = bodiesOf(page, (one) => one.url().endsWith("/v1/ensembles"));
  await page.click("[data-map=compute]");
  await page.waitForFunction(() => /900/.test(document.querySelector('[data-drawer="physics"] section:last-of-type [role=status]').textContent)
    && document.querySelector("[data-drawer=physics] progress").hidden);
  assert.equal(asked.length, 1);
  assert.deepEqual(asked[0].grid, [{ vary: "torque_amplitude", start: 0, stop: 3, count: 30, arm: 1 }, { vary: "damping", start: 0, stop: 1, count: 30, arm: 1 }]);
  await page.evaluate(() => document.querySelector('[data-drawer="physics"] .map').scrollIntoView({ block: "center" }));
  await drawn(page);
  await rig.shot(page, "physics-map");
  await page.focus('[data-drawer="physics"] .map');
  await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("ArrowUp");
  const words = await page.textContent("#map-point-end");
  await page.keyboard.press("Enter");
  await moving(page);
  const { pendulum, initial, span } = await doc(page);
  const amplitude = pendulum.torque[0].harmonics[0].amplitude;
  assert.ok(amplitude > 2 && pendulum.damping[0] > 0.5 && span.start === undefined, JSON.stringify(pendulum));
  const alone = await page.evaluate(async ([tree, start]) => {
    const { lyapunov } = await pendulumd.client.ensembles({ pendulum: tree, states: [start], duration: 30, observables: ["lyapunov"] });
    return lyapunov[0];
  }, [pendulum, { phi: initial.phi, phid: initial.phid }]);
  const shown = Number(/separate at (\S+)/.exec(words)?.[1].replace("\u2212", "-"));
  assert.ok(Math.abs(shown - alone) < 6e-3 * Math.abs(alone) + 1e-9, `${words}: alone it is ${alone}`);
  await close(page);
}

export async function a_map_shows_where_a_shaken_pendulum_stands_on_its_head(rig) {
  const page = await open(rig, "kapitza", { height: 1000, dark: true });
  await page.evaluate(() => pendulumd.clock.pause());
  await page.selectOption("[data-map=across]", "upRate");
  await page.selectOption("[data-map=up]", "up");
  await page.selectOption("[data-map=duration]", "10");
  // well damped, so that ten seconds decide
  await type(page, "damping", 0.05);
  await page.click("[data-map=compute]");
  await page.waitForFunction(() => /900/.test(document.querySelector('[data-drawer="physics"] section:last-of-type [role=status]').textContent)
    && document.querySelector("[data-drawer=physics] progress").hidden);
  await page.evaluate(() => document.querySelector('[data-drawer="physics"] .map').scrollIntoView({ block: "center" }));
  await drawn(page);
  await rig.shot(page, "physics-kapitza-map");
  // amplitude times frequency over the root of 2 g l holds it up, from the middle of the map (32 Hz, 20 mm) to the right; and not below
  const end = async (moves) => {
    await page.focus('[data-drawer="physics"] .map');
    for (const move of moves) await page.keyboard.press(move);
    return Number(/ends (\S+)\u00b0/.exec(await page.textContent("#map-point-end"))?.[1]);
  };
  assert.ok(await end(["ArrowRight"]) > 150, "it stands on its head");
  assert.ok(await end(["Shift+ArrowDown", "Shift+ArrowLeft"]) < 60, "it has fallen");
  await close(page);
}

export async function the_route_to_chaos_has_one_point_two_points_and_a_cloud_where_the_books_have_them(rig) {
  const page = await rig.open({ height: 1000 });
  await page.click('[data-preset="driven-damped"]');
  await page.waitForFunction(() => pendulumd.store.get().preset === "driven-damped" && pendulumd.motion.complete);
  await page.evaluate(() => pendulumd.clock.pause());
  await openDrawer(page, "physics");
  assert.equal(await page.evaluate(() => document.querySelector(".panels").scrollTop), 0, "a drawer begins at its top, wherever the last one was");
  await page.click("[data-part=route] summary");
  await page.waitForSelector("[data-part=route] path[stroke-width='1.4']");
  const columns = await page.evaluate(() => {
    const dots = [...document.querySelector("[data-part=route] path[stroke-width='1.4']").getAttribute("d").matchAll(/M([\d.]+) ([\d.]+)/g)];
    const byPlace = new Map();
    for (const [, x, y] of dots) byPlace.set(Number(x), new Set([...byPlace.get(Number(x)) ?? [], Number(y)]));
    const sorted = [...byPlace].sort(([a], [b]) => a - b).map(([, places]) => [...places].sort((a, b) => a - b));
    // places of a pixel or less apart are one
    return sorted.map((places) => places.filter((y, i) => !i || y - places[i - 1] > 1).length);
  });
  const ends = await page.locator("input[data-route]").evaluateAll((list) => list.map(({ value }) => Number(value)));
  assert.deepEqual([ends, columns.length], [[0.9, 1.3], 180]);
  const at = (strength) => columns[Math.round((strength - ends[0]) / (ends[1] - ends[0]) * 179)];
  assert.deepEqual([at(0.95), at(1.07)], [1, 2], "with the drive, and of twice its period");
  assert.ok(at(1.15) > 8, `${at(1.15)} places in chaos`);
  await page.locator("[data-part=route] .plot").scrollIntoViewIfNeeded();
  await drawn(page);
  await rig.shot(page, "route");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=route]"] } }), []);
  const box = await page.locator("[data-part=route] .plot").boundingBox();
  await page.mouse.click(box.x + 120, box.y + 80);
  await page.waitForFunction(() => pendulumd.store.get().pendulum.torque[0].harmonics[0].amplitude !== 1.15);
  const strength = await page.evaluate(() => pendulumd.store.get().pendulum.torque[0].harmonics[0].amplitude);
  assert.ok(strength > 0.95 && strength < 1.1, `${strength} where it was clicked`);
  await close(page);
}

export async function the_length_has_a_slider_and_all_arms_a_table(rig) {
  const page = await rig.open({ path: "/?length=2&theta=30" });
  await openDrawer(page, "physics");
  await page.fill('[data-cell="length-1"]', "1.25");
  await page.press('[data-cell="length-1"]', "Tab");
  await page.press('[data-cell="angle-1"]', "ArrowUp");
  assert.deepEqual(await page.evaluate(() => { const { pendulum, initial } = pendulumd.store.get(); return [pendulum.length[0], Math.round((initial.phi[0] + Math.PI / 2) * 180 / Math.PI)]; }), [1.25, 35]);
  await page.evaluate(() => {
    const slider = document.querySelector("[data-slider=length]");
    slider.value = "250";
    for (const type of ["input", "change"]) slider.dispatchEvent(new Event(type, { bubbles: true }));
  });
  await page.waitForFunction(() => pendulumd.store.get().pendulum.length[0] === 0.5);
  assert.equal(await page.inputValue('[data-cell="length-1"]'), "0.5");
  await page.evaluate(() => pendulumd.edits.add(1));
  const { pendulum } = await page.evaluate(() => pendulumd.store.get());
  assert.deepEqual(pendulum.length, [0.5, 0.5], "a new arm is as long as its carrier");
  const angles = await page.evaluate(() => [1, 2].map((arm) => Number(document.querySelector(`[data-cell=angle-${arm}]`).value.replace("\u2212", "-"))));
  assert.equal(angles[1], Math.round(angles[0]) + 30, "at a round angle");
  await page.fill('[data-cell="mass-2"]', "heavy");
  await page.press('[data-cell="mass-2"]', "Enter");
  await page.waitForSelector(".objection");
  await close(page);
}

/** How many tips and pivots the chosen arm's card lies over. */
const hidden = (page, count) => page.evaluate((arms) => {
  const card = document.querySelector(".card").getBoundingClientRect();
  const stage = document.querySelector("#stage").getBoundingClientRect();
  return Array.from({ length: arms + 1 }, (_, arm) => pendulumd.stage.tip(arm)).filter(({ x, y }) =>
    x + stage.left > card.left && x + stage.left < card.right && y + stage.top > card.top && y + stage.top < card.bottom).length;
}, count);

export async function the_card_of_an_arm_hides_no_arm_whether_it_moves_or_stands(rig) {
  const page = await rig.open({ path: "/?length=1,1&theta=120,-90", width: 1366, height: 768 });
  await openDrawer(page, "physics");
  await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.edits.select(1); });
  const moves = [];
  for (const time of [0, 2.5, 5, 7.5, 10, 12.5, 15, 19.5]) {
    await page.evaluate((at) => pendulumd.clock.seek(at), time);
    await drawn(page);
    assert.equal(await hidden(page, 2), 0, `it stands at ${time} s`);
  }
  await page.evaluate(() => { pendulumd.clock.seek(0); pendulumd.clock.play(); });
  await page.waitForTimeout(600); // until the camera has made room
  for (let i = 0; i < 8; i++) {
    moves.push(await hidden(page, 2));
    await page.waitForTimeout(150);
  }
  assert.deepEqual(moves, moves.map(() => 0), "it moves");
  await close(page);
}
