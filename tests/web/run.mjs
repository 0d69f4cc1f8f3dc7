// Runs the browser tests: `node tests/web/run.mjs [part-of-a-name]`; the last line counts them.
// A test is an exported function of a test_*.mjs: its name is a sentence, it gets the rig and throws if it fails.
// Leaves to others: the rig (rig.mjs). A file may export `rig`, options of a rig of its own.
// Invariant: every test runs, whatever the others did.

import { readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { createRig } from "./rig.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const wanted = (process.argv[2] ?? "").replaceAll(" ", "_");
const files = readdirSync(HERE).filter((name) => /^test_.*\.mjs$/.test(name)).sort();
const rigs = new Map();
let passed = 0;
let failed = 0;

async function run(name, test, rig) {
  const begun = performance.now();
  try {
    const note = await test(rig);
    passed++;
    console.log(`ok    ${name} (${Math.round(performance.now() - begun)} ms)${note ? `: ${note}` : ""}`);
  } catch (error) {
    failed++;
    console.log(`FAIL  ${name}: ${error.stack}`);
  }
  // a test that failed leaves neither its pages nor its trouble to the next one
  if (rig.front) rig.front.fault = null;
  for (const context of rig.browser.contexts()) await context.close();
}

/** The tests of a file; one that cannot be read is a failure. */
async function read(file) {
  try {
    return await import(pathToFileURL(join(HERE, file)));
  } catch (error) {
    failed++;
    console.log(`FAIL  ${file}: ${error.stack}`);
    return {};
  }
}

/** Files that want the same rig share one. */
async function rigFor(options) {
  const key = JSON.stringify(options ?? {});
  if (!rigs.has(key)) rigs.set(key, await createRig(options));
  return rigs.get(key);
}

for (const file of files) {
  const tests = await read(file);
  const chosen = Object.entries(tests).filter(([name, test]) => typeof test === "function" && `${file} ${name}`.includes(wanted));
  if (!chosen.length) continue;
  const rig = await rigFor(tests.rig);
  for (const [name, test] of chosen) await run(name.replaceAll("_", " "), test, rig);
}
for (const rig of rigs.values()) await rig.close();
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed || !passed ? 1 : 0);
