// How fast the page is, in figures: first paint and first motion, frames of few and many arms, what is drawn when nobody looks,
// memory, thirty students at once.
// Leaves to others: that what it shows is right (test_*.mjs). `make bench-page` runs it.
// Invariant: asserts nothing of time; a measurement fails only where an answer is missing or wrong.

import { createServer } from "node:http";
import { STUDENTS, agents, motion, start, visit } from "./class.mjs";
import { close, drawn, moving } from "./rig.mjs";

export const rig = { sources: false };

const ROUNDS = 9;
const MINUTES = Number(process.env.MINUTES ?? 1); // of memory: make bench-page MINUTES=10
const PAGES = 3; // of the students, in browsers

const ms = (times) => {
  const sorted = [...times].sort((a, b) => a - b);
  return { best: Math.round(sorted[0]), median: Math.round(sorted[sorted.length >> 1]), p99: Math.round(sorted[Math.ceil(sorted.length * 0.99) - 1]) };
};

/** In the page, from its first line on: when the first frame was shown at which `moves` told true. */
function watch(moves) {
  const { port1, port2 } = new MessageChannel(); // a message comes when the frame has been made
  const look = () => {
    port2.postMessage(null);
    requestAnimationFrame(look);
  };
  port1.onmessage = () => {
    window.moved ??= moves() ? performance.now() : undefined;
  };
  requestAnimationFrame(look);
}

const seen = (page) => page.evaluate(() => ({ paint: performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? window.moved, moved: window.moved }));

/** A page as it is opened first, without any of its files: milliseconds from the navigation's start to its first paint, to motion. */
async function opening(rig, url, moves) {
  const page = await rig.openAt("about:blank", { path: "", wait: false, cold: true });
  page.home = new URL(url).origin;
  await page.addInitScript(`(${watch})(${moves})`);
  await page.goto(url);
  await page.waitForFunction(() => window.moved);
  const times = await seen(page);
  await page.waitForFunction(() => !("begun" in document.documentElement.dataset) || window.pendulumd.motion.stats);
  await close(page);
  return times;
}

/** The browser's own part: a document of one line, and as its motion the second frame of a script of one line. */
const EMPTY = `<!doctype html><html lang="en"><link rel="icon" href="data:,"><title>empty</title><p>One line of text.
<script>requestAnimationFrame(() => requestAnimationFrame(() => { document.body.dataset.second = ""; }))</script>`;

export async function the_page_opens(rig) {
  const empty = createServer((_, answer) => answer.setHeader("Content-Type", "text/html").end(EMPTY));
  await new Promise((resolve) => empty.listen(0, "127.0.0.1", resolve));
  const pages = [["", rig.url, "() => window.pendulumd?.clock.time > 0"],
    ["an empty page: ", `http://127.0.0.1:${empty.address().port}`, "() => 'second' in document.body.dataset"]];
  const rounds = pages.map(() => []);
  for (let i = 0; i < ROUNDS; i++) for (const [which, [, url, moves]] of pages.entries()) rounds[which].push(await opening(rig, url, moves));
  empty.close();
  return pages.map(([name], which) => {
    const [paint, moved] = ["paint", "moved"].map((key) => ms(rounds[which].map((round) => round[key])));
    return `${name}first paint: best ${paint.best}, median ${paint.median} ms; first motion: best ${moved.best}, median ${moved.median} ms of ${ROUNDS}`;
  }).join("; ");
}

/** A comb of so many arms, half of them a chain. */
const comb = (page, n) => page.evaluate((arms) => {
  const half = arms >> 1;
  const parent = Array.from({ length: arms }, (_, k) => (k < half ? k : k - half + 1));
  const phi = parent.map((_, k) => -Math.PI / 2 + 0.4 * Math.cos(k));
  pendulumd.store.set({ pendulum: { length: phi.map(() => 0.2), mass: phi.map(() => 1), parent, gravity: 9.81 },
    initial: { phi, phid: phi.map(() => 0) }, span: { stop: 5, step: 0.01 }, ghosts: [], view: { trails: [arms], selected: 0, drawer: null } });
}, n);

/** Frames while it swings: from one to the next the median and what 95 of 100 stay below, and what the page's own thread works for each, ms. */
async function framesOf(page) {
  const session = await page.context().newCDPSession(page);
  // what the page's own thread uses of a processor, which a busy machine does not change
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const busy = async () => (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
  await page.evaluate(() => { pendulumd.clock.seek(1); pendulumd.clock.play(); });
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
  return { gap: gaps[gaps.length >> 1], late: gaps[Math.ceil(gaps.length * 0.95) - 1], used };
}

export async function frames_of_4_50_and_200_arms(rig) {
  const page = await rig.open();
  const said = [];
  for (const n of [4, 50, 200]) {
    await comb(page, n);
    await page.waitForFunction((arms) => pendulumd.motion.n === arms && pendulumd.motion.complete && pendulumd.motion.stats, n);
    const { gap, used } = await framesOf(page);
    said.push(`${n} arms: median frame ${gap.toFixed(1)} ms, of which ${used.toFixed(1)} ms are the page's thread`);
  }
  await close(page);
  return said.join("; ");
}

export async function frames_of_50_arms_with_plots_on_a_slow_machine(rig) {
  const page = await rig.open({ width: 1366, height: 768 });
  await comb(page, 50);
  await page.waitForFunction(() => pendulumd.motion.n === 50 && pendulumd.motion.complete && pendulumd.motion.stats);
  await page.evaluate(() => pendulumd.store.set({ view: { drawer: "plots" } }));
  await page.waitForSelector("[data-chart=drift] path");
  await page.session.send("Emulation.setCPUThrottlingRate", { rate: 4 });
  const rounds = [];
  for (let i = 0; i < ROUNDS; i++) rounds.push(await framesOf(page));
  await page.session.send("Emulation.setCPUThrottlingRate", { rate: 1 });
  await close(page);
  const list = (key) => rounds.map((round) => round[key].toFixed(1)).join(" ");
  return `four times slower: median ${list("gap")}; 95 of 100 below ${list("late")}; the page's thread ${list("used")} ms`;
}

/** A browser without a window tells no page that another tab is before it: told so by hand, its frames go on. */
const HIDE = () => {
  Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
  document.dispatchEvent(new Event("visibilitychange"));
  window.counts.frames = window.counts.pictures = 0;
};

/** Counts what the page does from now on: frames that it asks for, pictures of the stage, requests. */
const counting = (page) => page.evaluate(() => {
  window.counts = { frames: 0, pictures: 0, asked: performance.getEntriesByType("resource").length };
  const native = window.requestAnimationFrame;
  window.requestAnimationFrame = (fn) => { window.counts.frames++; return native(fn); };
  const { prototype } = CanvasRenderingContext2D;
  const { clearRect } = prototype;
  prototype.clearRect = function (...box) { window.counts.pictures++; return clearRect.apply(this, box); };
});
const counted = (page) => page.evaluate(() => {
  const { frames, pictures, asked } = window.counts;
  const now = performance.getEntriesByType("resource").length;
  Object.assign(window.counts, { frames: 0, pictures: 0, asked: now });
  return `${frames} frames, ${pictures} pictures, ${now - asked} requests`;
});

export async function nothing_is_drawn_for_nobody(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => pendulumd.motion.stats && pendulumd.client.engine.ready);
  await counting(page);
  const said = [];
  const during = async (what, seconds, does = () => {}) => {
    await page.waitForTimeout(300);
    await counted(page);
    await does();
    await page.waitForTimeout(seconds * 1000);
    said.push(`${what}: ${await counted(page)}`);
  };
  await during("swinging for 2 s", 2);
  await page.evaluate(() => pendulumd.clock.pause());
  await during("paused for 2 s", 2);
  const tip = await page.evaluate(() => pendulumd.stage.tip(1));
  const { x, y } = await page.locator("#stage").boundingBox();
  await during("an arm dragged over 40 places", 0, async () => {
    await page.mouse.move(x + tip.x, y + tip.y);
    await page.mouse.down();
    for (let i = 0; i < 40; i++) await page.mouse.move(x + tip.x - 2 * i, y + tip.y + i);
  });
  await page.mouse.up();
  await page.evaluate(() => pendulumd.clock.play());
  await page.waitForFunction(() => pendulumd.motion.stats && pendulumd.clock.time > 0);
  await drawn(page);
  await during("playing in a tab that is hidden, for 2 s", 2, () => page.evaluate(HIDE));
  await close(page);
  return said.join("; ");
}

/** Bytes of the heap after the garbage has been collected. */
async function heap(page) {
  await page.session.send("HeapProfiler.collectGarbage");
  return (await page.session.send("Runtime.getHeapUsage")).usedSize;
}

export async function memory_over_minutes(rig) {
  const page = await rig.open();
  await page.waitForFunction(() => pendulumd.motion.stats);
  await comb(page, 50);
  await page.waitForFunction(() => pendulumd.motion.n === 50 && pendulumd.motion.complete && pendulumd.motion.stats);
  await page.evaluate(() => { pendulumd.store.set({ view: { drawer: "plots" } }); pendulumd.clock.play(); });
  await page.waitForTimeout(3000);
  const sizes = [await heap(page)];
  for (let minute = 0; minute < MINUTES; minute++) {
    await page.waitForTimeout(60000);
    sizes.push(await heap(page));
  }
  await close(page);
  return `MB of heap, minute by minute with fifty arms and plots open: ${sizes.map((size) => (size / 1e6).toFixed(2)).join(" ")}`;
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
