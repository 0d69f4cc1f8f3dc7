// The JavaScript client against a live server: what comes back, rows, jobs, refusals, lines that break.
// usage: client.mjs FRONT CUTTING BROKEN OUT PAGES     (fronts that refuse twice, that cut downloads, that cut each line; a file for the doubles of the
// paper's example; a server of pages; perhaps a url that hears of a job's end)
// Leaves to others: counting (test_js.py), types (types.ts). Invariant: every check says ok or FAIL with its name.
import { getEventListeners } from "node:events";
import { writeFileSync } from "node:fs";
import { Client, Pendulum, Refusal, rowsOf } from "pendulumd";

const [front, cutting, broken, out, pages] = process.argv.slice(2);
const check = (name, good) => console.log(`${good ? "ok" : "FAIL"} ${name}`);
const refused = async (name, work, words) => {
  try {
    await work();
    check(name, false);
  } catch (error) {
    check(`${name}: ${String(error.message).replaceAll("\n", " ")}`, words ? error instanceof Refusal && error.message.includes(words) : true);
  }
};
const failed = async (name, work, words) => {
  const error = await work().catch((thrown) => thrown);
  check(`${name}: ${error.message}`, String(error.message).includes(words));
};
const FOUR = { L: [2, 1.5, 0.75, 1.25], m: [1, 1, 1, 0.1], S: [[1, 0, 0, 0], [1, 1, 0, 0], [1, 1, 1, 0], [1, 1, 0, 1]] };
const times = { start: 0, stop: 5, step: 0.01 };
const four = new Pendulum(FOUR);

const motion = await four.run({ times, output: ["phi", "z", "energy"] });
check("arrays", motion.phi.length === 501 && motion.phi[0].length === 4 && motion.stats.method === "taylor");
const rows = [];
for await (const row of four.rows({ times, output: ["phi", "z", "energy"] })) rows.push(row);
check("rows are the same doubles", rows.length === 501 && rows.every((row, i) => row.t === motion.t[i] && row.energy_total === motion.energy.total[i]
  && row.phi.every((angle, k) => angle === motion.phi[i][k]) && row.z_im.every((y, k) => y === motion.z.im[i][k])));
const floats = [];
for await (const row of four.rows({ times, output: ["phi", "z", "energy"], number: "float32" })) floats.push(row);
check("rows of floats are those doubles rounded", floats.length === 501 && floats.every((row, i) => row.phi instanceof Float32Array
  && row.t === Math.fround(motion.t[i]) && row.energy_total === Math.fround(motion.energy.total[i])
  && row.phi.every((angle, k) => angle === Math.fround(motion.phi[i][k])) && row.z_im.every((y, k) => y === Math.fround(motion.z.im[i][k]))));
check("routes", (await four.ask("modes", {})).omega.length === 4 && (await four.ask("forces", { state: { phi: [0, 0, 0, 0] } })).phidd.length === 4
  && (await four.ask("trees", {})).depth.join() === "1,2,3,3" && (await four.client.presets).presets.length > 3);
const damped = await new Pendulum({ length: [1, 1], mass: [1, 1], parent: [0, 1], damping: [0.1, 0.2] }).ask("trees", {});
check("fields of real pendulums", damped.arms[1].damping === 0.2);
const doubt = { times: { stop: 4000, step: 1 }, initial: { theta: [2, 2, 2, 2] } };
const heard = [];
const [warn, lost] = [console.warn, four.rows(doubt)];
console.warn = (text) => heard.push(text);
let last;
do last = await lost.next(); while (!last.done);
const sure = await four.run(doubt);
check("rows end with their warnings and stats", heard.join() === `pendulum: ${sure.warnings[0]}` && last.value.warnings.join() === sure.warnings.join()
  && last.value.stats.horizon === sure.stats.horizon && sure.stats.horizon > 0);
console.warn = warn;
let count = 0;
for await (const row of four.rows({ times: { stop: 4000, step: 0.001 } })) if (row.t >= 0 && ++count === 1000) break;
check("who stops listening ends the computation", count === 1000);

await refused("a field that nobody knows", () => four.run({ times }, { fruit: 3 }), "/fruit is not a known field");
await refused("a field of the pendulum that nobody knows", () => new Pendulum(FOUR, {}, { fruit: [1] }).run({ times }), "/pendulum/fruit");
// at once: who waits for it here waits for days
await failed("no server", () => new Pendulum(FOUR, { url: "http://127.0.0.1:1", patience: 1e6 }).run({ times }), "no server at http://127.0.0.1:1 (");
await failed("another server", () => new Pendulum(FOUR, { url: pages }).run({ times }), "answers with a web page");
const begin = performance.now();
const late = await new Pendulum(FOUR, { url: front }).run({ times });
check("refusals for the moment are repeated after Retry-After", late.phi[500][3] === motion.phi[500][3] && performance.now() - begin >= 1000);
await refused("rows that were cut off", async () => {
  for await (const row of new Pendulum(FOUR, { url: broken }).rows({ times: { stop: 5, step: 0.0001 } })) count += row.t;
});
const stop = new AbortController();
const long = new Pendulum(FOUR, { signal: stop.signal }).ask("ensembles", { random: { count: 100000, draw: [{ vary: "theta", arm: 1, distribution: "uniform", low: -3, high: 3 }] }, duration: 30 });
setTimeout(() => globalThis.gc(), 100);
setTimeout(() => stop.abort(), 200);
await refused("who aborts", () => long);

const steady = new AbortController();
const watched = new Pendulum(FOUR, { signal: steady.signal });
for (let k = 0; k < 5; k++) await watched.ask("modes", {});
// fetch itself may leave one each until garbage is collected
check("a signal keeps nothing of requests that have ended", getEventListeners(steady.signal, "abort").length <= 5);
check("typed arrays are lists", (await four.run({ initial: { theta: new Float64Array([1, 0, 0, 0]) }, times: { stop: 1, step: 1 } })).phi.length === 2);
await failed("numbers that are not finite", () => four.run({ initial: { theta: [NaN, 0, 0, 0] }, times: { stop: 1, step: 1 } }), "finite");

const job = await four.submit("trajectories", { times: { stop: 40, step: 0.001 } }, { key: "of-js" });
check("a key leads to the same job", (await four.submit("trajectories", { times: { stop: 40, step: 0.001 } }, { key: "of-js" })).id === job.id);
const looks = [];
for await (const state of job.progress()) looks.push(state.progress);
check("progress", looks.at(-1) === 100);
const answer = await job.result();
check("the answer of a job", answer.phi.length === 40001);
const whole = await job.bytes("application/octet-stream");
const pieces = await new Client({ url: cutting }).job(job.id).bytes("application/octet-stream");
check("a download goes on", whole.length === pieces.length && Buffer.compare(whole, pieces) === 0);
const members = { states: [{ theta: [0, 0, 0, 0] }, { theta: [3, 3, 3, 3] }], duration: 3, observables: ["first_flip", "final"] };
const form = { number: "float32", none: "nan", columns: ["member", "first_flip_time", "final_phi"] };
const small = await four.submit("ensembles", { ...members, ...form });
const usual = await (await four.submit("ensembles", members)).result();
const flips = [];
for await (const row of small.rows()) flips.push(row);
check("a job's rows are floats where it was asked for them", flips.length === 2 && flips.every((row, i) => Object.keys(row).join() === "member,final_phi,first_flip_time"
  && row.final_phi instanceof Float32Array && row.final_phi.every((angle, k) => angle === Math.fround(usual.final.phi[i][k])))
  && Number.isNaN(flips[0].first_flip_time) && flips[1].first_flip_time === Math.fround(usual.first_flip.time[1]));
const parquet = await small.bytes("application/vnd.apache.parquet");
check("a job's results as Parquet", Buffer.from(parquet.subarray(-4)).toString() === "PAR1");
const listed = [];
for await (const each of four.client.jobs({ status: undefined })) listed.push(each.id);
check("the list has it", listed.includes(job.id));
const named = await four.submit("forces", {}, { title: "zwölf % of it" });
const suiting = [];
for await (const each of four.client.jobs({ operation: "forces", title: "lf % OF" })) suiting.push([each.id, each.title].join());
check("a title finds its job alone", suiting.join() === [named.id, "zwölf % of it"].join());
const endless = await four.submit("trajectories", { times: { stop: 4000, step: 0.001 } });
check("cancel", (await endless.cancel()).status === "dismissed");
await refused("a dismissed job has no answer", () => endless.result(), "dismissed");

const doubles = [];
for await (const row of rowsOf(await four.client.open("POST", "/v1/trajectories", { Accept: "application/x-ndjson" }, { pendulum: FOUR, times })))
  doubles.push(row.t, ...row.phi, ...row.phid, ...row.lambda);
writeFileSync(out, new Float64Array(doubles));
