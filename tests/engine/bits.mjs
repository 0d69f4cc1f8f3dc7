// The engine for browsers beside the same door as native code of the base instruction set: the
// paper's example and a thousand random requests, byte for byte.
// usage: node bits.mjs ENGINE.WASM NATIVE [COUNT]
// Leaves to others: building both (tests/rules/engine.sh).
// Invariant: a byte that differs is a failure, and its request is shown.
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";

import { createEngine } from "../../server/web/engine_module.js";
import { random, request } from "./trees.mjs";

const [file, native, count = "1000"] = process.argv.slice(2);
const engine = createEngine(new WebAssembly.Module(readFileSync(file)));
const shown = { passed: 0, failed: 0, here: 0, there: 0 };

/** The answer of the module: {status, bytes}. */
function here(asked) {
  const parts = [];
  let status = 0;
  for (const part of engine.answer({ ...asked, body: JSON.stringify(asked.body) })) {
    if (part instanceof Uint8Array) parts.push(part);
    else if (part) ({ status } = part);
  }
  return { status, bytes: Buffer.concat(parts) };
}

const child = spawn(native, { stdio: ["pipe", "pipe", "inherit"] });
const chunks = child.stdout[Symbol.asyncIterator]();
let rest = Buffer.alloc(0);
const read = async (bytes) => {
  while (rest.length < bytes) {
    const { value, done } = await chunks.next();
    if (done) throw new Error(`the native door ended before its answer: ${child.exitCode} ${child.signalCode}`);
    rest = Buffer.concat([rest, value]);
  }
  const taken = rest.subarray(0, bytes);
  rest = rest.subarray(bytes);
  return taken;
};

/** The answer of the native door. */
async function there({ operation, accept, body }) {
  const text = Buffer.from(`${operation}\0\0${accept}\0${JSON.stringify(body)}`);
  const size = Buffer.alloc(4);
  size.writeUInt32LE(text.length);
  child.stdin.write(Buffer.concat([size, text]));
  const head = await read(8);
  return { status: head.readUInt32LE(0), bytes: Buffer.from(await read(head.readUInt32LE(4))) };
}

/** The answer to a question about forces without places and energies: these take sines of the C library, whose last digits differ. */
const forces = (bytes) => JSON.stringify(JSON.parse(bytes), (key, value) => (/^z|^energy/.test(key) ? null : value));

/** Whether two answers are one. */
function same(ours, theirs, { operation }) {
  if (ours.status !== 200 || theirs.status !== 200) return false;
  return ours.bytes.equals(theirs.bytes) || (operation === "forces" && forces(ours.bytes) === forces(theirs.bytes));
}

async function compare(name, asked) {
  const begun = performance.now();
  const ours = here(asked);
  const between = performance.now();
  const theirs = await there(asked);
  shown.here += between - begun;
  shown.there += performance.now() - between;
  const good = same(ours, theirs, asked);
  shown[good ? "passed" : "failed"]++;
  if (good) return;
  console.log(`FAIL ${name}: ${ours.status}, ${theirs.status}; ${JSON.stringify(asked).slice(0, 400)}`);
  if (ours.status !== 200) console.log(`  ${ours.bytes}`.slice(0, 400));
}

const paper = {
  pendulum: { length: [2, 1.5, 0.75, 1.25], mass: [1, 1, 1, 0.1], parent: [0, 1, 2, 2], gravity: 9.81 },
  initial: { phi: [0, 0, 0, 0], phid: [0, 0, 0, 0] },
  times: { start: 0, stop: 20, step: 0.01 },
  output: ["phi", "phid", "lambda", "energy"],
};
await compare("the paper's example", { operation: "trajectories", accept: "application/octet-stream", body: paper });
// motions in pieces: a table, dry friction and a stop, a controller
const bar = { length: 0.5, mass: 0.2, rod: 0.3 };
const ruled = [
  { arms: [{ ...bar, torque: { table: { t: [0, 1, 2], value: [0, 0.5, -0.2], hold: "linear", outside: "zero" } } }] },
  { arms: [{ ...bar, friction: { torque: 0.05, static: 0.08 }, stop: { min: -0.2, restitution: 0.7 } }] },
  { arms: [bar], control: [{ joint: 1, period: 0.02, limit: [-1, 1], law: { pid: { p: 3, i: 1, d: 0.2, reference: 1 } } }] },
];
for (const [i, pendulum] of ruled.entries())
  await compare(`motion in pieces ${i}`, {
    operation: "trajectories",
    accept: "application/octet-stream",
    body: { pendulum, initial: { theta: [1.2] }, times: { stop: 5, step: 0.01 }, output: ["phi", "phid", "lambda"] },
  });
const draw = random(20);
for (let i = 0; i < Number(count); i++) await compare(`request ${i}`, request(i, draw));
child.stdin.end();
console.log(`  ${shown.here.toFixed(0)} ms as WebAssembly, ${shown.there.toFixed(0)} ms as native code`);
console.log(`${shown.passed} passed, ${shown.failed} failed`);
process.exit(shown.failed ? 1 : 0);
