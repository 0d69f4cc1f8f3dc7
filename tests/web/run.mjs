// Runs the browser tests: `node tests/web/run.mjs [part-of-a-name]`; the last line counts them. With `--bench` before the
// name it runs the measurements (bench_*.mjs) instead, one after the other: they print figures and assert nothing of time.
// A test is an exported function of a test_*.mjs: its name is a sentence, it gets the rig and throws if it fails.
// Leaves to others: the rig (rig.mjs). A file may export `rig`, options of its rig.
// Invariant: every test runs, whatever the others did; files run side by side, the tests of one in their order. A test that
// failed among the others is run once more with the machine to itself; what went wrong at first is told either way, and the
// last line says how many tests passed at the second try only. WEB_TESTS names another directory of tests.

import { readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Unasked } from "./bidi.mjs";
import { createRig, endShared } from "./rig.mjs";

const HERE = process.env.WEB_TESTS ?? dirname(fileURLToPath(import.meta.url));
const bench = process.argv[2] === "--bench";
const wanted = (process.argv[bench ? 3 : 2] ?? "").replaceAll(" ", "_");
const LANES = bench ? 1 : Number(process.env.LANES ?? 3);
const FIRST = ["test_drawers.mjs", "test_docs.mjs", "test_hand.mjs"]; // what takes longest, so that no lane is left alone with it
const rank = (name) => (FIRST.includes(name) ? FIRST.indexOf(name) : FIRST.length);
const pattern = bench ? /^bench_.*\.mjs$/ : /^test_.*\.mjs$/;
const files = readdirSync(HERE).filter((name) => pattern.test(name)).sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
const again = []; // what failed among the others: {name, test, options}
let passed = 0;
let second = 0; // of those that passed, how many did so at the second try only
let failed = 0;
let unasked = 0; // what the browser cannot be asked (BROWSER=firefox)

function fail(name, error) {
  failed++;
  console.log(`FAIL  ${name}: ${error.stack}`);
}

/** Runs a test; onFailure gets its error. Answers whether it passed. */
async function run(name, test, rig, onFailure) {
  const begun = performance.now();
  let good = false;
  try {
    const note = await test(rig);
    passed++;
    good = true;
    console.log(`ok    ${name} (${Math.round(performance.now() - begun)} ms)${note ? `: ${note}` : ""}`);
  } catch (error) {
    if (error instanceof Unasked) {
      unasked++;
      console.log(`skip  ${name}: ${error.message}`);
    } else onFailure(error);
  }
  // a test that failed leaves neither its pages nor its trouble to the next one
  await rig.clear();
  return good;
}

/** The tests of a file, with a rig of their own; a file that cannot be read is a failure. */
async function runFile(file) {
  try {
    const tests = await import(pathToFileURL(join(HERE, file)));
    const chosen = Object.entries(tests).filter(([name, test]) => typeof test === "function" && `${file} ${name}`.includes(wanted));
    if (!chosen.length) return;
    const rig = await createRig(tests.rig);
    for (const [name, test] of chosen) {
      const said = name.replaceAll("_", " ");
      await run(said, test, rig, (error) => {
        again.push({ name: said, test, options: tests.rig });
        console.log(`again ${said}: ${error.stack}`);
      });
    }
    await rig.close();
  } catch (error) {
    fail(file, error);
  }
}

// what nobody waits for any more, a request of a test that has failed meanwhile, ends no other test
process.on("unhandledRejection", (error) => fail("what no test has waited for", error));

const lane = async () => {
  while (files.length) await runFile(files.shift());
};
await Promise.all(Array.from({ length: LANES }, lane));
for (const { name, test, options } of again) {
  const rig = await createRig(options);
  if (await run(name, test, rig, (error) => fail(name, error))) {
    second++;
    console.log(`second ${name} passed at the second try only`);
  }
  await rig.close();
}
await endShared();
console.log(`${passed} passed, ${failed} failed${second ? `, ${second} passed at the second try` : ""}${unasked ? `, ${unasked} skipped` : ""}`);
process.exit(failed || !(passed + unasked) ? 1 : 0);
