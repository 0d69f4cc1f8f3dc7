// Fits: a table of measurements as people have it is read, fitted, told with its errors, and set in motion.

import assert from "node:assert/strict";
import { deflateRawSync } from "node:zlib";
import { violations } from "./axe.mjs";
import { openDrawer, settledMotion } from "./drawers.mjs";
import { close, drawn } from "./rig.mjs";

const SHOWN = "[data-fit=answer] .fit-verdict";
const LONG = 0.62; // m
const DAMPED = 0.01; // N m s

/** Noise that is the same in every run: of about 1. */
function noise(seed) {
  let state = seed;
  const one = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648 - 0.5;
  return () => Math.sqrt(12 / 6) * (one() + one() + one() + one() + one() + one());
}

/** What the server's own motion looks like to a camera or a protractor: rows of numbers. */
async function measured(page, values, stop = 4) {
  const { t, phi } = await page.evaluate(([length, damping, end]) => pendulumd.client.trajectory({ pendulum: { length: [length], mass: [1], parent: [0], damping: [damping] },
    initial: { theta: [40], unit: "deg" }, times: { start: 0, stop: end, step: 0.05 }, output: ["phi"] }), [LONG, DAMPED, stop]);
  return t.map((time, i) => [time, ...values(phi[i][0])]);
}

async function opened(rig, options) {
  const page = await rig.open({ path: "/?length=0.8&theta=20", height: 1000, ...options });
  await page.evaluate(() => pendulumd.clock.pause());
  await openDrawer(page, "measure");
  return page;
}

/** The table in the field, once the engine has read it; answers what is said then. */
async function filled(page, words) {
  await page.fill(".fit-text", words);
  await page.waitForFunction(() => document.querySelector("p[data-fit=status]").textContent);
  return page.textContent("p[data-fit=status]");
}

const taken = (page) => page.locator("[data-column]").evaluateAll((list) => list.map(({ value }) => value));

const found = (page, id) => page.evaluate((name) => [...document.querySelectorAll(`[data-found="${name}"] td`)].slice(0, 2)
  .map((cell) => Number(cell.dataset.value)), id);

export async function a_table_of_angles_in_german_decimals_gives_length_and_friction_with_errors(rig) {
  const page = await opened(rig, { language: "de" });
  const random = noise(7);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90 + 0.2 * random()]);
  const lines = rows.map((row) => row.map((value) => value.toFixed(4).replace(".", ",")).join(";"));
  await page.click("[data-part=fits] summary");
  await filled(page, ["Zeit in s;Winkel θ1 in °", ...lines].join("\r\n"));
  assert.deepEqual(await taken(page), ["t", "theta 1"]);
  await page.click("[data-fit=run]");
  await page.waitForSelector(SHOWN);
  assert.equal(await page.getAttribute(SHOWN, "data-status"), "converged");
  for (const [id, truth] of [["length 1", LONG], ["damping 1", DAMPED]]) {
    const [value, error] = await found(page, id);
    assert.ok(error > 0 && Math.abs(value - truth) < 4 * error && error < 0.1 * truth, `${id}: ${value} ± ${error}, not ${truth}`);
  }
  await page.waitForSelector("[data-fit=answer] .plot svg");
  assert.equal(await page.locator("[data-fit=answer] .plot svg").count(), 2);
  const before = await page.evaluate(() => pendulumd.store.get().pendulum);
  await page.click("[data-fit=instead]");
  await settledMotion(page);
  const [long] = await found(page, "length 1");
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().pendulum.length), [long], "the pendulum of the stage is the fitted one");
  await page.evaluate(() => pendulumd.undo());
  assert.deepEqual(await page.evaluate(() => pendulumd.store.get().pendulum), before, "undo leads back");
  await page.click("[data-fit=beside]");
  await settledMotion(page);
  const ghost = await page.evaluate(() => pendulumd.motion.ghosts[0].doc.pendulum.length);
  assert.deepEqual([ghost, await page.evaluate(() => pendulumd.store.get().pendulum.length)], [[long], before.length], "beside it swings with its own length");
  await close(page);
}

export async function tracker_s_pixels_that_another_part_hands_over_give_length_scale_and_pivot(rig) {
  for (const [name, options] of Object.entries({ light: {}, dark: { dark: true }, phone: { width: 390, height: 844, touch: true } })) {
    const page = await opened(rig, options);
    const random = noise(3);
    const rows = await measured(page, (phi) => [310 + 230 * LONG * Math.cos(phi) + random(), 95 - 230 * LONG * Math.sin(phi) + random()]);
    const csv = ["mass_A,,", "t,x,y", ...rows.map((row) => row.map((value) => value.toFixed(3)).join(","))].join("\n");
    await page.evaluate(async (text) => {
      pendulumd.store.set({ view: { drawer: null } });
      const { openMeasurements } = await import("/page/sources/drawers/fits/measurements.js");
      openMeasurements(pendulumd, text);
    }, csv);
    await page.waitForSelector("[data-fit=down]");
    assert.equal(await page.inputValue("select[data-fit=place]"), "px", "hundreds of units are no metres");
    assert.ok(await page.isChecked("[data-fit=down]"), "that y counts downwards is seen in the table");
    await page.click("[data-fit=run]");
    await page.waitForSelector(SHOWN);
    assert.equal(await page.getAttribute(SHOWN, "data-status"), "converged");
    for (const [id, truth] of [["length 1", LONG], ["scale", 230], ["origin_x", 310], ["origin_y", -95]]) {
      const [value, error] = await found(page, id);
      assert.ok(error > 0 && Math.abs(value - truth) < 4 * error && error < 0.1 * Math.abs(truth), `${id}: ${value} ± ${error}, not ${truth}`);
    }
    await page.waitForSelector("[data-fit=answer] .plot svg");
    await page.evaluate(() => document.querySelector("[data-part=fits]").scrollIntoView({ block: "start" }));
    await drawn(page);
    await rig.shot(page, `fits-${name}`);
    await page.evaluate(() => document.querySelector("[data-fit=answer]").scrollIntoView({ block: "start" }));
    await drawn(page);
    await rig.shot(page, `fits-answer-${name}`);
    assert.deepEqual(await violations(page, { context: { include: ["[data-part=fits]"] } }), [], name);
    const wide = await page.evaluate(() => document.querySelector('[data-drawer="measure"]').scrollWidth - document.querySelector('[data-drawer="measure"]').clientWidth);
    assert.ok(wide <= 0, `${name}: ${wide} pixels too wide`);
    await close(page);
  }
}

export async function what_is_wrong_with_a_table_is_said_with_its_line_and_what_cannot_be_known_in_words(rig) {
  const page = await opened(rig);
  await page.click("[data-part=fits] summary");
  const said = async (words) => {
    await filled(page, words);
    if (await page.isVisible("[data-fit=run]")) await page.click("[data-fit=run]");
    return page.textContent("p[data-fit=status]");
  };
  await page.waitForSelector(".fit-text");
  page.forgiven.push(/422/); // what is no table
  assert.match(await said("nothing but words"), /not a table.*has no row of two or more numbers/);
  assert.match(await said("<?xml version='1.0'?>"), /not a table.*is XML/);
  assert.match(await said("t,theta_1\n0,20\n0.1,wet\n0.2,10"), /line 3: field 2 must be a number/);
  assert.match(await said("a,theta_1\n3,20\n1,21\n2,10"), /No column contains times/);
  assert.match(await said("t,colour\n0,20\n1,21\n2,10"), /No column contains angles/);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90]);
  await filled(page, ["t\ttheta_1", ...rows.map((row) => row.join("\t"))].join("\n"));
  await page.check('[data-unknown="gravity"]');
  await page.click("[data-fit=run]");
  await page.waitForSelector("[data-fit=answer] .fit-said");
  assert.match(await page.textContent("[data-fit=answer] .fit-said"), /do not distinguish .*Length of arm 1.*Gravity/);
  assert.match(await page.textContent('[data-found="gravity"]'), /not identifiable/);
  // what is no pendulum is said to be none, with the worst row, and the server's own words are there
  const wrong = rows.map(([t], i) => [t, ((i * 37) % 80) - 40].join("\t"));
  await filled(page, ["t\ttheta_1", ...wrong].join("\n"));
  await page.click("[data-fit=run]");
  await page.waitForSelector("[data-fit=message]");
  assert.match(await page.textContent("[data-fit=farthest]"), /angle θ of arm 1.*at t = [\d.]+ s/);
  assert.match(await page.textContent("[data-fit=message]"), /^The server reports: .*(minimum|model does not follow)/);
  // in another language all of it is still there
  await page.check('[data-unknown="gravity"]');
  await page.evaluate(() => pendulumd.speak("de"));
  await page.waitForSelector("html[lang=de]");
  await openDrawer(page, "measure");
  if (!(await page.isVisible(".fit-text"))) await page.click("[data-part=fits] summary");
  await page.waitForSelector("[data-fit=farthest]");
  assert.match(await page.textContent("[data-fit=farthest]"), /^Am weitesten daneben: .* s\.$/);
  assert.equal((await page.inputValue(".fit-text")).split("\n").length, rows.length + 1);
  assert.ok(await page.isChecked('[data-unknown="gravity"]'), "what was to be found is still ticked");
  await close(page);
}

/** A file in the field, as bytes. */
async function opens(page, bytes) {
  await page.setInputFiles("[data-part=fits] input[type=file]", { name: "swing.csv", mimeType: "text/csv", buffer: Buffer.from(bytes) });
  await page.waitForFunction(() => document.querySelector("p[data-fit=status]").textContent);
  return page.textContent("p[data-fit=status]");
}

export async function a_doubtful_table_shows_its_doubts_and_each_has_a_choice(rig) {
  const page = await opened(rig);
  await page.click("[data-part=fits] summary");
  await page.waitForSelector(".fit-text");
  // milliseconds without a word, an angle from the horizontal in UTF-16, no names
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90], 8);
  const lines = rows.map(([t, theta]) => `${1000 * t}\t${theta + 90}`).join("\r\n");
  assert.equal(await opens(page, Buffer.concat([Buffer.from([0xff, 0xfe]), Buffer.from(lines, "utf16le")])), `Rows read: ${rows.length}.`);
  assert.deepEqual(await taken(page), ["t (ms)", "theta 1"]);
  assert.deepEqual(await page.locator("[data-column]").evaluateAll((list) => list.map(({ dataset }) => dataset.sure)), ["false", "false"]);
  assert.match(await page.textContent("[data-fit=doubts]"), /columns marked.*swing about (89|90).*1: .*milliseconds.*2: .*the file has no column names/s);
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=fits]"] } }), []);
  assert.ok(await page.isChecked('[data-unknown="zero 1"]'), "a zero that is elsewhere is an unknown");
  await page.click("[data-fit=run]");
  await page.waitForSelector(SHOWN);
  const [zero] = await found(page, "zero 1");
  const [long] = await found(page, "length 1");
  assert.ok(Math.abs(zero - Math.PI / 2) < 1e-3 && Math.abs(long - LONG) < 1e-3, `${zero}, ${long}`);
  // a choice is asked of the engine: seconds, radians, another column
  await page.selectOption('[data-column="0"]', "t");
  await page.waitForFunction(() => document.querySelector('[data-column="0"]').dataset.sure === "true");
  await page.selectOption("[data-fit=angle]", "rad");
  await page.waitForFunction(() => document.querySelector("[data-fit=angle]").value === "rad");
  assert.deepEqual(await taken(page), ["t", "theta 1"]);
  // what the engine refuses is said, and the table stays
  await page.selectOption('[data-column="1"]', "");
  await page.waitForFunction(() => document.querySelector('[data-column="1"]').value === "");
  assert.match(await page.textContent("[data-fit=doubts]"), /left out by the request/);
  // a spreadsheet's own file is no text
  assert.match(await opens(page, Buffer.from("MATLAB 5.0 MAT-file\0")), /save a \.mat/);
  await close(page);
}

export async function a_gyroscope_and_angles_between_arms_are_fitted_and_drawn(rig) {
  const page = await opened(rig, { path: "/?length=0.5,0.4&theta=20,10" });
  await page.click("[data-part=fits] summary");
  await page.waitForSelector(".fit-text");
  const { t, phi, phid } = await page.evaluate(() => pendulumd.client.trajectory({ pendulum: { length: [0.52, 0.41], mass: [1, 1], parent: [0, 1] },
    initial: { theta: [20, 10], unit: "deg" }, times: { start: 0, stop: 3, step: 0.05 }, output: ["phi", "phid"] }));
  const rows = t.map((time, i) => [time, phid[i][0] + 0.03, (phi[i][1] - phi[i][0]) * 180 / Math.PI].join(";"));
  await filled(page, ["Zeit (s);thetad_1 (rad/s);joint_2 (deg)", ...rows].join("\n"));
  assert.deepEqual(await taken(page), ["t", "thetad 1", "joint 2"]);
  await page.check('[data-unknown="bias 1"]');
  for (const arm of [1, 2]) await page.uncheck(`[data-unknown="damping ${arm}"]`);
  await page.click("[data-fit=run]");
  await page.waitForSelector(SHOWN);
  for (const [id, truth] of [["length 1", 0.52], ["length 2", 0.41], ["bias 1", 0.03]]) {
    const [value] = await found(page, id);
    assert.ok(Math.abs(value - truth) < 1e-3, `${id}: ${value}, not ${truth}`);
  }
  await page.waitForSelector("[data-fit=answer] .plot svg");
  assert.equal(await page.locator("[data-fit=answer] .plot svg").count(), 4);
  await close(page);
}

const le = (...list) => Buffer.concat(list.map(([value, size = 2]) => Buffer.from(Array.from({ length: size }, (_, k) => (value >> (8 * k)) & 255))));

/** A zip archive of texts, as programs write it; nobody reads its checksums. */
function zipOf(files) {
  const [parts, directory] = [[], []];
  for (const [name, text] of Object.entries(files)) {
    const [packed, at] = [deflateRawSync(text), Buffer.concat(parts).length];
    const head = le([20], [0], [8], [0, 4], [0, 4], [packed.length, 4], [text.length, 4], [name.length], [0]);
    parts.push(Buffer.from("PK\x03\x04"), head, Buffer.from(name), packed);
    directory.push(Buffer.from("PK\x01\x02"), le([20]), head, le([0], [0], [0], [0, 4], [at, 4]), Buffer.from(name));
  }
  const end = le([0], [0], [0], [directory.length / 5], [Buffer.concat(directory).length, 4], [Buffer.concat(parts).length, 4], [0]);
  return Buffer.concat([...parts, ...directory, Buffer.from("PK\x05\x06"), end]);
}

/** Opens the file and presses the button: what a newcomer does with a file once the drawer is open. */
async function newcomer(page, name, bytes) {
  await page.setInputFiles("[data-part=fits] input[type=file]", { name, mimeType: "", buffer: Buffer.from(bytes) });
  await page.waitForSelector("[data-fit=run]:not([hidden])");
  await page.click("[data-fit=run]");
  await page.waitForSelector(SHOWN);
  const [long, error] = await found(page, "length 1");
  assert.ok(error > 0 && Math.abs(long - LONG) < Math.max(4 * error, 1e-3), `${name}: ${long} ± ${error}`);
}

export async function three_actions_lead_from_a_file_to_a_length_with_its_error(rig) {
  const page = await rig.open({ path: "/?length=0.5,0.4,0.3,0.2&theta=20,10,5,0", height: 1000 });
  const random = noise(5);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90 + 0.1 * random()], 8);
  await openDrawer(page, "measure");
  if (!(await page.isVisible(".fit-text"))) await page.click("[data-part=fits] summary");
  await page.waitForSelector(".fit-text");
  const lines = (between, change = (x) => x) => rows.map((row) => row.map((x, k) => change(x, k)).join(between)).join("\n");
  const cells = rows.map(([t, angle], i) => `<row r="${i + 2}"><c r="A${i + 2}"><v>${t}</v></c><c r="C${i + 2}"><v>${angle}</v></c></row>`);
  const sheet = `<worksheet><sheetData><row r="1"><c r="A1" t="s"><v>0</v></c><c r="C1" t="inlineStr"><is><t>Angle (deg)</t></is></c></row>${cells.join("")}</sheetData></worksheet>`;
  const rates = rows.slice(1).map(([t, angle], i) => [t - 0.025, 0.01, (angle - rows[i][1]) / 0.05 * Math.PI / 180].join(","));
  await newcomer(page, "comma.csv", `t,theta_1 (deg)\n${lines(",")}`);
  await newcomer(page, "german.txt", `Zeit (s);Winkel (\u00b0)\n${lines(";", (x) => String(x).replace(".", ","))}`);
  await newcomer(page, "horizontal.dat", lines("\t", (x, k) => x + 89.7 * k));
  assert.ok(await page.isChecked('[data-unknown="zero 1"]'));
  await newcomer(page, "book.xlsx", zipOf({ "[Content_Types].xml": "<Types/>", "xl/sharedStrings.xml": "<sst><si><t>Time (s)</t></si></sst>", "xl/worksheets/sheet1.xml": sheet }));
  await newcomer(page, "phone.zip", zipOf({ "meta/device.csv": "a,b\n".repeat(3000), "Gyroscope.csv": `"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)"\n${rates.join("\n")}` }));
  assert.deepEqual(await taken(page), ["t", "", "thetad 1"]);
  await page.click("[data-fit=arms] button");
  await page.waitForSelector('[data-unknown="length 2"]');
  await close(page);
}

export async function after_a_fit_residuals_are_described_and_paper_has_all(rig) {
  const page = await opened(rig);
  await page.click("[data-part=fits] summary");
  const random = noise(9);
  const rows = await measured(page, (phi) => [phi * 180 / Math.PI + 90 + 0.2 * random()], 8);
  const shown = async (change) => {
    await filled(page, ["t;theta_1 (deg)", ...rows.map(([t, angle]) => [t, angle + change(t)].join(";"))].join("\n"));
    await page.click("[data-fit=run]");
    await page.waitForSelector("[data-fit=answer] .plot svg");
    return page.locator("[data-fit=look]").allTextContents();
  };
  assert.match((await shown((t) => Math.sin(2 * Math.PI * 3 * t))).join(), /angle \u03b8 of arm 1.*period of 0\.33\d s \(3(\.\d+)? Hz\) is left over/);
  assert.match((await shown((t) => 0.3 * t - 1.2)).join(), /drift from \u22121\.\d+ to 1\.\d+ \u00b0/);
  assert.match((await shown((t) => 0.3 * t * random())).join(), /spread changes from/);
  assert.deepEqual(await shown(() => 0), [], "noise has no pattern");
  assert.deepEqual(await violations(page, { context: { include: ["[data-part=fits]"] } }), []);
  await page.evaluate(() => { window.print = () => { window.dialogs = 1; }; });
  await page.click("[data-fit=report]");
  await page.waitForFunction(() => window.dialogs === 1);
  assert.match(await page.textContent(".print-report"), /angle \u03b8 of arm 1.*0;.*Length of arm 1.*Residuals.*Meinsma/s);
  assert.equal(await page.locator(".print-report button").count(), 0);
  await rig.shot(page, "fits-after");
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  assert.equal(await page.locator(".print-report").count(), 0);
  await close(page);
}
