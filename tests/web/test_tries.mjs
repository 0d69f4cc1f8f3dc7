// A browser test that passes at the second try only is counted, in the tests' own last line and in the sum of `make check`.
// Leaves to others: what is tried (the other test_*.mjs).

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { ROOT } from "./rig.mjs";

const RUN = join(ROOT, "tests/web/run.mjs");
const JOB = join(ROOT, "tests/harness/job.sh");

/** {status, last, text}: how a program ended and what it said. */
function said(program, words, options) {
  return new Promise((resolve) => {
    execFile(program, words, options, (error, text) => {
      resolve({ status: error?.code ?? 0, last: text.trimEnd().split("\n").at(-1), text });
    });
  });
}

/** A directory that is gone when `use` is done with it. */
async function within(use) {
  const home = mkdtempSync(join(tmpdir(), "pendulumd-tries-"));
  try {
    await use(home);
  } finally {
    rmSync(home, { recursive: true, force: true });
  }
}

const THREE = `
let tried = 0;
export async function this_passes() {}
export async function this_passes_when_it_is_tried_again() {
  if (++tried === 1) throw new Error("not at once");
}
`;

export async function what_passes_at_the_second_try_only_is_counted_and_named() {
  await within(async (home) => {
    const env = { ...process.env, WEB_TESTS: home };
    writeFileSync(join(home, "test_three.mjs"), THREE);
    const good = await said(process.execPath, [RUN], { env });
    assert.equal(good.last, "2 passed, 0 failed, 1 passed at the second try");
    assert.match(good.text, /^second this passes when it is tried again /m);
    assert.equal(good.status, 0);
    writeFileSync(join(home, "test_three.mjs"), `${THREE}export async function this_fails() { throw new Error("never"); }\n`);
    const bad = await said(process.execPath, [RUN], { env });
    assert.equal(bad.last, "2 passed, 1 failed, 1 passed at the second try");
    assert.equal(bad.status, 1);
  });
}

export async function the_sum_of_all_jobs_says_what_took_a_second_try() {
  await within(async (home) => {
    const job = (...words) => said(JOB, words, { cwd: home });
    mkdirSync(join(home, "build/check"), { recursive: true });
    writeFileSync(join(home, "build/check/jobs"), "one two three\n");
    const words = "second a sentence passed at the second try only\n7 passed, 0 failed, 2 skipped, 1 passed at the second try\n";
    const first = await job("one", "printf", words);
    assert.match(first.text, /ok +one +7 passed, 0 failed, 2 skipped, 1 passed at the second try/);
    assert.match(first.text, /second a sentence/);
    await job("two", "printf", "3 passed, 0 failed\n");
    await job("three", "printf", "1 passed, 0 failed, 4 skipped\n");
    assert.deepEqual(await job("--sum"), { status: 0, last: "11 passed, 0 failed, 6 skipped, 1 passed at the second try",
      text: "11 passed, 0 failed, 6 skipped, 1 passed at the second try\n" });
    await job("three", "sh", "-c", "echo 1 passed, 0 failed, 2 passed at the second try; exit 3");
    const sum = await job("--sum");
    assert.equal(sum.last, "11 passed, 1 failed, 2 skipped, 3 passed at the second try");
    assert.equal(sum.status, 1);
  });
}
