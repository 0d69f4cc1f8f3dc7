// A class: thirty students at one server, all at once; first each with a start of its own, then all with the same example.
// Leaves to others: how long that takes (bench_page.mjs).

import { STUDENTS, agents, motion, start, visit } from "./class.mjs";

export const rig = { sources: false };

export async function thirty_students_at_once_all_get_their_motions(rig) {
  const pools = agents(STUDENTS);
  await Promise.all(pools.map((agent, i) => visit(agent, rig.url, start(i))));
  await Promise.all(pools.map((agent, i) => motion(agent, rig.url, start(100 + i))));
  await Promise.all(pools.map((agent) => motion(agent, rig.url, [0.5, 0.5, 0.5, 0.5])));
  for (const agent of pools) agent.destroy();
}
