// A class of students without browsers: each opens the page as a browser does, and asks for motions.
// Leaves to others: what is checked (test_class.mjs), what is measured (bench_page.mjs).
// Invariant: a student whose answer is not whole throws.

import { Agent, request } from "node:http";
import { Unasked } from "./bidi.mjs";

export const STUDENTS = 30;
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

/** The forces at one moment, as a page asks for them while an arm is dragged. */
export function forces(agent, url, token, phi) {
  const { pendulum } = JSON.parse(body(phi));
  const headers = { "Content-Type": "application/json", Authorization: `Bearer ${token}` };
  return ask(agent, `${url}/v1/forces`, { sent: JSON.stringify({ pendulum, state: { phi, phid: [0, 0, 0, 0] } }), headers });
}

/** Asks as the page does; the milliseconds until its first rows are here, and reads the rest. */
export async function motion(agent, url, phi) {
  const headers = { "Content-Type": "application/json", Accept: "application/octet-stream" };
  const { first, bytes } = await ask(agent, `${url}/v1/trajectories`, { sent: body(phi), headers });
  if (bytes !== 2001 * 16 * 8) throw new Error(`${bytes} bytes`);
  return first;
}

/** A student without a browser: the document, every file that it names, then the motion; the time until it could move. */
export async function visit(agent, url, phi) {
  const begun = performance.now();
  const html = (await ask(agent, url)).all.toString();
  const files = new Set([...html.matchAll(/(?:href|src)="(page\/[^"]+)"/g)].map(([, path]) => `/${path}`));
  await Promise.all([motion(agent, url, phi), ...[...files].map((path) => ask(agent, url + path, { headers: { "Accept-Encoding": "gzip" } }))]);
  return performance.now() - begun;
}

/** What a page has asked for, its requests of the rig: for students who ask the same without a browser. */
export const requestsOf = (page) => Promise.all(page.asked.filter((asked) => asked.url().startsWith("http")).map(async (asked) => {
  const sent = asked.postData();
  if (asked.method() === "POST" && sent === null) throw new Unasked("what a request carries is of Chromium's protocol");
  return { path: asked.url().slice(page.home.length), sent, headers: await asked.allHeaders() };
}));

/** A student without a browser, who asks for all that a page has asked for, as somebody of its own. */
export function repeat(agent, url, requests, token) {
  return Promise.all(requests.map(({ path, sent, headers }) => {
    const own = Object.fromEntries(Object.entries(headers).filter(([name]) => !name.startsWith(":") && !["host", "connection", "content-length"].includes(name)));
    if (own.authorization) own.authorization = `Bearer ${token}`;
    return ask(agent, url + path, { sent, headers: own });
  }));
}

export const start = (student) => [0, 1, 2, 3].map((arm) => 0.01 * student + 0.003 * arm);

/** A connection pool for each student, as a browser has one. */
export const agents = (count) => Array.from({ length: count }, () => new Agent({ keepAlive: true, maxSockets: 6 }));
