// Programs of the JavaScript client that compile, under `strict` and without a cast, and some that must not: where one of these
// does, tsc says that its @ts-expect-error is not used.
// Leaves to others: running them (client.mjs). Invariant: each wrong line is wrong in one way.
import { Client, Pendulum, Refusal, type Job } from "pendulumd";

const client = new Client({ url: "http://127.0.0.1:8080", token: "x", patience: 5, signal: new AbortController().signal });
const pendulum = new Pendulum({ length: [1, 1], mass: [1, 1], parent: [0, 1] }, client, { friction: [0.1] });
new Pendulum({ arms: [{ name: "a", length: 1, mass: 1 }, { parent: "a", length: 1, mass: 1 }], gravity: 1.62 });
new Pendulum({ length: [1, 1], mass: [1, 1], parent: [0, 1], damping: [0.1, 0.2], pivot: { y: { harmonics: [{ amplitude: 0.02, omega: 100 }] } } });
new Pendulum({ L: [1], m: [1], S: [[1]] }, { url: "http://127.0.0.1:8080" });

export async function right(): Promise<number> {
  const motion = await pendulum.run({ initial: { theta: [2, 2.5], unit: "deg" }, times: { stop: 5, count: 11 }, method: "ode23", rtol: 1e-6, output: ["z", "energy"] });
  const total: number = (motion.energy.total[0] ?? 0) + (motion.z.re[0]?.[1] ?? 0) + motion.stats.steps;
  const usual = await pendulum.run({ times: [0, 1] }, { drag: 3 });
  const angle: number | undefined = usual.phi[1]?.[0];
  for await (const row of pendulum.rows({ times: { stop: 5, step: 0.1 }, initial: { mode: 1, amplitude: 0.1 }, output: ["theta", "z", "energy"] })) {
    const parts: Float64Array[] = [row.theta, row.z_re, row.z_im];
    if (row.t + row.energy_total + parts.length > 1000) break;
  }
  for await (const row of pendulum.rows({ times: [0, 1], output: ["theta"], number: "float32" })) {
    const narrow: Float32Array = row.theta;
    if (narrow.length > 1000) break;
  }
  const job = await pendulum.submit("ensembles", { states: [{ theta: [1, 2] }], duration: 5, observables: ["first_flip"], number: "float32", none: "nan", columns: ["first_flip_time"] }, { key: "mine" });
  for await (const state of job.progress()) if (state.status === "failed") return 0;
  const flips: (number | null)[] | undefined = (await job.result()).first_flip?.time;
  const found: Job = await job.state();
  const modes = await pendulum.ask("modes", { select: { slowest: 1 } });
  const section = await pendulum.ask("sections", { initial: { phi: [0, 0] }, section: { arm: 1, theta: 0 }, duration: 5 });
  try {
    await pendulum.ask("forces", { state: { phi: [0, 0] } });
  } catch (error) {
    if (error instanceof Refusal) return error.status + (error.problem.errors?.length ?? 0);
  }
  return total + (angle ?? 0) + (flips?.length ?? 0) + found.progress + (modes.omega[0] ?? 0) + section.t.length;
}

export async function wrong(): Promise<void> {
  // @ts-expect-error 1: a start by theta and by phi at once
  await pendulum.run({ initial: { theta: [1, 2], phi: [1, 2] }, times: [0, 1] });
  // @ts-expect-error 2: a field that is misspelt
  await pendulum.run({ times: [0, 1], rtoll: 1e-6 });
  // @ts-expect-error 3: no instants
  await pendulum.run({ initial: { theta: [1, 2] } });
  // @ts-expect-error 4: instants by step and by count at once
  await pendulum.run({ times: { stop: 5, step: 0.1, count: 11 } });
  // @ts-expect-error 5: a method that there is not
  await pendulum.run({ times: [0, 1], method: "euler" });
  // @ts-expect-error 6: an output that was not asked for
  for await (const row of pendulum.rows({ times: [0, 1], output: ["phi"] })) console.log(row.lambda);
  // @ts-expect-error 7: a pendulum in two forms at once
  new Pendulum({ L: [1], m: [1], S: [[1]], length: [1], mass: [1], parent: [0] });
  // @ts-expect-error 8: members by states and by random draws at once
  await pendulum.ask("ensembles", { states: [{ theta: [1, 2] }], random: { count: 3, draw: [] }, duration: 5 });
  // @ts-expect-error 9: a text in place of a number
  new Pendulum({ length: ["1"], mass: [1], parent: [0] });
  // @ts-expect-error 10: a route that there is not
  await pendulum.ask("trajectory", { times: [0, 1] });
  // @ts-expect-error 11: of a trajectory without z its tips
  (await pendulum.run({ times: [0, 1], output: ["phi"] })).z.re;
  // @ts-expect-error 12: a kind of number that there is not
  await pendulum.submit("ensembles", { states: [{ theta: [1, 2] }], duration: 5, number: "float16" });
  // @ts-expect-error 13: rows of doubles are no floats
  for await (const row of pendulum.rows({ times: [0, 1], output: ["phi"] })) ((floats: Float32Array) => floats)(row.phi);
}
