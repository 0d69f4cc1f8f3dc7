// Programs that use types of the OpenAPI document as a generator makes them (generated.ts): right ones that compile under `strict`
// without a cast, and wrong ones: where one of these compiles, tsc says that its @ts-expect-error is not used.
// Leaves to others: the JavaScript client's own types (tests/clients/types.ts). Invariant: each wrong line is wrong in one way.
import type { EnsembleRequest, ForcesRequest, ModesRequest, Pendulum, SectionRequest, State, Trajectory, TrajectoryRequest } from "./generated.js";

const lists: Pendulum = { length: [1, 1], mass: [1, 1], parent: [0, 1], damping: [0.1, null], body: [null, { mass: 1, center: [0.5, 0] }], pivot: { y: { harmonics: [{ amplitude: 0.02, omega: 100 }] } } };
const arms: Pendulum = { arms: [{ name: "a", length: 1, mass: 1 }, { parent: "a", length: 1, rod: 1, torque: { constant: 1 } }], gravity: 1.62 };
const paper: Pendulum = { L: [1], m: [1], S: [[1]] };
const single: Pendulum[] = [{ L: 1, m: 1, S: 1 }, { length: 1, mass: 1, parent: 0, damping: 0.1 }];
const starts: State[] = [{}, { phi: [1] }, { theta: 1 }, { theta: [1], thetad: [0], unit: "deg" }, { mode: 1, amplitude: 0.1 }, { cart: { x: 1 } }];
const motion: TrajectoryRequest = { pendulum: lists, initial: { theta: [2, 2.5] }, times: { stop: 5, step: 0.01 }, output: ["z", "energy"], events: [{ of: "theta", arm: 1, value: 0 }] };
const many: EnsembleRequest = { pendulum: arms, states: starts, duration: 5, observables: ["first_flip"] };
const grid: EnsembleRequest = { pendulum: paper, grid: [{ vary: "theta", arm: 1, start: 0, stop: 1, count: 3 }], initial: { theta: [1] }, times: [0, 1] };
const forces: ForcesRequest[] = [{ pendulum: paper }, { pendulum: paper, state: { phi: [0] } }, { pendulum: paper, states: starts }];
const modes: ModesRequest = { pendulum: paper, select: { slowest: 1 } };
const section: SectionRequest = { pendulum: paper, section: { arm: 1, theta: 0 }, duration: 5 };
export const tips = (answer: Trajectory): number => (answer.z?.re[0]?.[1] ?? 0) + answer.stats.steps;
export const right = [lists, arms, paper, single, starts, motion, many, grid, forces, modes, section];

export const wrong: unknown[] = [
  // @ts-expect-error 1: a start by theta and by phi at once
  { theta: [1], phi: [1] } satisfies State,
  // @ts-expect-error 2: a start by a mode and by angles at once
  { mode: 1, amplitude: 0.1, theta: [1] } satisfies State,
  // @ts-expect-error 3: rates of theta with angles phi
  { phi: [1], thetad: [0] } satisfies State,
  // @ts-expect-error 4: a pendulum in two forms at once
  { L: [1], m: [1], S: [[1]], length: [1], mass: [1], parent: [0] } satisfies Pendulum,
  // @ts-expect-error 5: lists of a real pendulum beside arms
  { arms: [{ length: 1, mass: 1 }], damping: [0.1] } satisfies Pendulum,
  // @ts-expect-error 6: instants by step and by count at once
  { pendulum: paper, times: { stop: 5, step: 0.1, count: 11 } } satisfies TrajectoryRequest,
  // @ts-expect-error 7: a method that there is not
  { pendulum: paper, times: [0, 1], method: "euler" } satisfies TrajectoryRequest,
  // @ts-expect-error 8: a field that is misspelt
  { pendulum: paper, times: [0, 1], rtoll: 1e-6 } satisfies TrajectoryRequest,
  // @ts-expect-error 9: members by states and by random draws at once
  { pendulum: paper, states: starts, random: { count: 3, draw: [] }, duration: 5 } satisfies EnsembleRequest,
  // @ts-expect-error 10: members by nothing
  { pendulum: paper, duration: 5 } satisfies EnsembleRequest,
  // @ts-expect-error 11: one state and many
  { pendulum: paper, state: {}, states: starts } satisfies ForcesRequest,
  // @ts-expect-error 12: the slowest modes and the fastest
  { pendulum: paper, select: { slowest: 1, fastest: 1 } } satisfies ModesRequest,
  // @ts-expect-error 13: a section by both angles
  { pendulum: paper, section: { arm: 1, theta: 0, phi: 0 }, duration: 5 } satisfies SectionRequest,
  // @ts-expect-error 14: a section of an arm and stroboscopic
  { pendulum: paper, section: { arm: 1, theta: 0, period: "drive" }, duration: 5 } satisfies SectionRequest,
  // @ts-expect-error 15: a text in place of a number
  { length: ["1"], mass: [1], parent: [0] } satisfies Pendulum,
  // @ts-expect-error 16: a body without its center
  { length: [1], mass: [1], parent: [0], body: [{ mass: 1 }] } satisfies Pendulum,
];
