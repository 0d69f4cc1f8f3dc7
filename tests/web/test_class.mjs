// A class: thirty students at one server, all at once; first each with a start of its own, then all with the same example.

import assert from "node:assert/strict";
import { Agent, request } from "node:http";
import { close, crowd, moving } from "./rig.mjs";

export const rig = { sources: false };

const STUDENTS = 30;
const PAGES = 3; // of them in browsers
const COLUMNS = ["phi", "phid", "lambda", "energy"];

const body = (phi) => JSON.stringify({
  pendulum: { length: [2, 1.5, 0.75, 1.25], mass: [1, 1, 1, 0.1], parent: [0, 1, 2, 2], gravity: 9.81 },
  initial: { phi, phid: [0, 0, 0, 0] }, times: { start: 0, stop: 20, step: 0.01 }, method: "taylor", output: COLUMNS,
});

/** Sends and reads all of the answer: {first, bytes, text}, first the milliseconds until its first bytes. */
function ask(agent, url, { sent = null, headers = {} } = {}) {
  const begun = performance.now();
  return new Promise((resolve, reject) => {
    const asked = request(url, { agent, method: sent ? "POST" : "GET", headers }, (reply) => {
      const pieces = [];
      let first = 0;
      reply.on("data", (piece) => {
        first ||= performance.now() - begun;
        pieces.push(piece);
      });
      reply.on("end", () => {
        const all = Buffer.concat(pieces);
        reply.statusCode === 200 ? resolve({ first, bytes: all.length, all }) : reject(new Error(`${url} answered ${reply.statusCode}`));
      });
      reply.on("error", reject);
    });
    asked.on("error", reject);
    asked.end(sent);
  });
}

/** Asks as the page does; the milliseconds until its first rows are here, and reads the rest. */
async function motion(agent, url, phi) {
  const headers = { "Content-Type": "application/json", Accept: "application/octet-stream" };
  const { first, bytes } = await ask(agent, `${url}/v1/trajectories`, { sent: body(phi), headers });
  if (bytes !== 2001 * 16 * 8) throw new Error(`${bytes} bytes`);
  return first;
}

/** A student without a browser: the document, every file that it names, then the motion; the time until it could move. */
async function visit(agent, url, phi) {
  const begun = performance.now();
  const html = (await ask(agent, url)).all.toString();
  const files = new Set([...html.matchAll(/(?:href|src)="(\/page\/[^"]+)"/g)].map(([, path]) => path));
  await Promise.all([motion(agent, url, phi), ...[...files].map((path) => ask(agent, url + path, { headers: { "Accept-Encoding": "gzip" } }))]);
  return performance.now() - begun;
}

const start = (student) => [0, 1, 2, 3].map((arm) => 0.01 * student + 0.003 * arm);

function worst(times) {
  const sorted = [...times].sort((a, b) => a - b);
  return { median: Math.round(sorted[sorted.length >> 1]), p99: Math.round(sorted[Math.ceil(sorted.length * 0.99) - 1]) };
}

export async function thirty_students_see_motion_within_a_second(rig) {
  const pages = await Promise.all(Array.from({ length: PAGES }, () => rig.open()));
  const others = STUDENTS - PAGES;
  const agents = Array.from({ length: others }, () => new Agent({ keepAlive: true, maxSockets: 6 })); // as a browser has
  // drawing is work of the students' own machines
  for (const page of pages) await page.evaluate(() => pendulumd.clock.pause());
  const rounds = {};
  const all = (student, page) => Promise.all([...Array.from({ length: others }, (_, i) => student(i)), ...pages.map(page)]);
  const round = async (name, student, page) => {
    const before = crowd();
    const times = await all(student, page);
    const slower = Math.min(before, crowd());
    rounds[name] = { ...worst(times.filter((time) => time > 0)), slower };
  };
  await round("opening", (i) => visit(agents[i], rig.url, start(i)), () => 0);
  await round("distinct starts", (i) => motion(agents[i], rig.url, start(100 + i)), (page, i) => turned(page, -0.1 * (i + 1)));
  await round("the same example", (i) => motion(agents[i], rig.url, [0.5, 0.5, 0.5, 0.5]), (page) => turned(page, 0.5));
  for (const agent of agents) agent.destroy();
  const said = Object.entries(rounds).map(([name, { median, p99, slower }]) => `${name}: median ${median}, p99 ${p99} ms`
    + (slower > 1.2 ? ` on a machine ${slower.toFixed(1)} times slower than alone` : ""));
  for (const { p99, slower } of Object.values(rounds)) assert.ok(p99 / slower < 1000, said.join("; "));
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
