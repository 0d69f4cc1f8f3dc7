// How fast the page is, in figures: first paint and first motion, frames of fifty arms, thirty students at once.
// Leaves to others: that what it shows is right (test_*.mjs). `make bench-page` runs it.
// Invariant: asserts nothing of time; a measurement fails only where an answer is missing or wrong.

import { COMB } from "./comb.mjs";
import { STUDENTS, agents, motion, start, visit } from "./class.mjs";
import { close, moving } from "./rig.mjs";

export const rig = { sources: false };

const ROUNDS = 7;
const PAGES = 3; // of the students, in browsers

const ms = (times) => {
  const sorted = [...times].sort((a, b) => a - b);
  return { best: Math.round(sorted[0]), median: Math.round(sorted[sorted.length >> 1]), p99: Math.round(sorted[Math.ceil(sorted.length * 0.99) - 1]) };
};

/** Milliseconds from the navigation's start to the first paint, and to the first frame of another instant than the first. */
async function opening(rig) {
  const page = await rig.open({ wait: false, cold: true });
  const times = await page.evaluate(() => new Promise((resolve) => {
    const look = () => {
      if (!(window.pendulumd?.clock.time > 0)) return requestAnimationFrame(look);
      const moved = performance.now();
      resolve({ paint: performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? moved, moved });
    };
    look();
  }));
  await page.waitForFunction(() => window.pendulumd.motion.stats);
  await close(page);
  return times;
}

export async function the_page_opens(rig) {
  const rounds = [];
  for (let i = 0; i < ROUNDS; i++) rounds.push(await opening(rig));
  const [paint, moved] = ["paint", "moved"].map((key) => ms(rounds.map((round) => round[key])));
  return `first paint: best ${paint.best}, median ${paint.median} ms; first motion: best ${moved.best}, median ${moved.median} ms of ${ROUNDS}`;
}

export async function fifty_arms_are_drawn(rig) {
  const page = await rig.open();
  await page.evaluate(COMB);
  await page.waitForFunction(() => pendulumd.motion.n === 50 && pendulumd.motion.complete && pendulumd.motion.stats);
  const session = await page.context().newCDPSession(page);
  // what the page's own thread uses of a processor, which a busy machine does not change
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const busy = async () => (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
  await page.evaluate(() => { pendulumd.clock.seek(2); pendulumd.clock.play(); });
  await page.waitForTimeout(600);
  const before = await busy();
  const gaps = await page.evaluate(() => new Promise((resolve) => {
    const times = [];
    const look = (now) => {
      times.push(now);
      times.length > 150 ? resolve(times.slice(1).map((time, i) => time - times[i])) : requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  }));
  const used = ((await busy()) - before) * 1000 / gaps.length;
  gaps.sort((a, b) => a - b);
  await close(page);
  return `median frame ${gaps[gaps.length >> 1].toFixed(1)} ms, of which ${used.toFixed(1)} ms are the page's thread`;
}

export async function thirty_students_come_at_once(rig) {
  const pages = await Promise.all(Array.from({ length: PAGES }, () => rig.open()));
  const pools = agents(STUDENTS - PAGES);
  // drawing is work of the students' own machines
  for (const page of pages) await page.evaluate(() => pendulumd.clock.pause());
  const said = [];
  const round = async (name, student, page) => {
    const { median, p99 } = ms(await Promise.all([...pools.map(student), ...pages.map(page)]));
    said.push(`${name}: median ${median}, p99 ${p99} ms`);
  };
  const opened = ms(await Promise.all(pools.map((agent, i) => visit(agent, rig.url, start(i)))));
  said.push(`opening: median ${opened.median}, p99 ${opened.p99} ms`);
  await round("distinct starts", (agent, i) => motion(agent, rig.url, start(100 + i)), (page, i) => turned(page, -0.1 * (i + 1)));
  await round("the same example", (agent) => motion(agent, rig.url, [0.5, 0.5, 0.5, 0.5]), (page) => turned(page, 0.5));
  for (const agent of pools) agent.destroy();
  for (const page of pages) {
    await moving(page);
    await close(page);
  }
  return said.join("; ");
}

/** All arms of a page turned to an angle: milliseconds until its first rows are here. */
function turned(page, angle) {
  return page.evaluate((phi) => new Promise((resolve) => {
    const { motion, store } = window.pendulumd;
    const begun = performance.now();
    const end = motion.subscribe((_, what) => {
      if (what !== "rows") return;
      end();
      resolve(performance.now() - begun);
    });
    store.set({ initial: { phi: [phi, phi, phi, phi], phid: [0, 0, 0, 0] } });
  }), angle);
}
