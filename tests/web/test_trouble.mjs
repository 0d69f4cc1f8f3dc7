// A server that is away, slow or refuses: the page says so in words, and goes on when it is over.

import assert from "node:assert/strict";
import { close, moving, refuseStorage } from "./rig.mjs";

const FORGIVEN = /Failed to load resource|net::ERR/;

/**
 * A page whose next requests for motions end so, answer(reply, asked, times); over() ends the trouble.
 * It is narrow, so that nobody but the stage asks: on a wide one the examples' pictures do.
 */
async function troubled(rig, answer) {
  const page = await rig.open({ width: 800 });
  await page.waitForFunction(() => pendulumd.motion.stats);
  page.forgiven.push(FORGIVEN);
  let times = 0;
  rig.front.fault = (asked, reply) => {
    if (!asked.url.startsWith("/v1/traj")) return false;
    answer(reply, asked, ++times);
    return true;
  };
  return { page, over: () => { rig.front.fault = null; }, times: () => times };
}

const problem = (status, retry) => (reply) => {
  reply.writeHead(status, { "Content-Type": "application/problem+json", "Retry-After": String(retry) });
  reply.end(JSON.stringify({ type: "about:blank", title: "Busy", status, detail: "server is busy" }));
};

// while it asks again, the page says that; so the words are waited for
const told = (page, words, kind = ".bad") => page.waitForFunction(
  ([where, source]) => new RegExp(source).test(document.querySelector(where)?.textContent ?? ""),
  [`.notice${kind}:not([hidden]) span`, words.source]);
const change = (page) => page.evaluate(() => pendulumd.edits.setMass(2, 3));

async function refusesAndRecovers(rig, status) {
  const refuse = problem(status, 1);
  let [first, waited, second] = [0, 0, null];
  // refused at once; the second time when the page has been looked at
  const { page, over, times } = await troubled(rig, (reply, _, time) => {
    if (time === 1) {
      first = performance.now();
      refuse(reply);
    } else {
      waited = performance.now() - first;
      second = reply;
    }
  });
  await change(page);
  await told(page, /server is busy\. Trying.*[12] s/);
  while (!second) await page.waitForTimeout(20);
  await told(page, /server is busy\. Trying.*[12] s/);
  await rig.shot(page, `refused_${status}`);
  assert.ok(times() === 2 && waited > 990, `it waits a second as it was told: ${times()} requests, ${waited} ms apart`);
  over();
  refuse(second);
  await moving(page);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function a_server_over_quota_is_waited_for(rig) { await refusesAndRecovers(rig, 429); }
export async function a_server_without_room_is_waited_for(rig) { await refusesAndRecovers(rig, 503); }

export async function a_server_that_is_away_is_missed_and_found_again(rig) {
  // no connection, a proxy's own page, the problem of the proxy that is shipped (nginx.conf)
  const away = [(reply) => reply.destroy(), (reply) => reply.writeHead(503, { "Content-Type": "text/html" }).end("<h1>503</h1>"),
    (reply) => reply.writeHead(503, { "Content-Type": "application/problem+json" }).end('{"status":503,"detail":"gone","reachable":false}')];
  let kind = 0;
  const { page, over, times } = await troubled(rig, (reply) => away[kind](reply));
  for (; kind < away.length - 1; kind++) {
    await change(page);
    await told(page, /does not answer/);
    await page.evaluate(() => pendulumd.undo());
  }
  await change(page);
  await told(page, /does not answer/);
  await rig.shot(page, "away");
  const before = times();
  await page.click(".notice button");
  while (times() === before) await page.waitForTimeout(20);
  over();
  await page.evaluate(() => pendulumd.client.hurry());
  await moving(page);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function an_answer_that_breaks_off_is_told_and_asked_for_again(rig) {
  const { page, over } = await troubled(rig, (reply, asked) => asked.resume().on("end", () => {
    reply.writeHead(200, { "Content-Type": "application/octet-stream", "X-Columns": "t,phi[4],phid[4],lambda[4],energy_kinetic,energy_potential,energy_total" });
    reply.write(Buffer.alloc(1600), () => reply.socket.end());
  }));
  await change(page);
  await told(page, /was cut off/);
  over();
  await page.click(".notice button");
  await moving(page);
  await close(page);
}

export async function a_refusal_is_told_in_the_server_s_words_and_undone(rig) {
  const page = await rig.open();
  page.forgiven.push(FORGIVEN);
  await page.evaluate(() => pendulumd.store.set({ rtol: 5 }));
  await told(page, /^tolerance: must be /);
  await rig.shot(page, "refused_422");
  await page.click(".notice button");
  await moving(page);
  assert.equal(await page.evaluate(() => pendulumd.store.get().rtol), null);
  await page.waitForSelector(".notice", { state: "hidden" });
  await close(page);
}

export async function a_slow_server_is_told_and_waited_for(rig) {
  const { page, over } = await troubled(rig, () => {});
  await change(page);
  await told(page, /Computing: 0 %/, "");
  over();
  // who changes something else does not wait for what was asked before
  await page.evaluate(() => pendulumd.edits.setMass(2, 2));
  await moving(page);
  await close(page);
}

export async function the_page_opens_although_the_server_is_busy_at_first(rig) {
  let times = 0;
  rig.front.fault = (asked, reply) => {
    if (asked.url !== "/v1/trajectories" || ++times > 2) return false;
    problem(503, 1)(reply);
    return true;
  };
  const page = await rig.open({ wait: false });
  page.forgiven.push(FORGIVEN);
  await moving(page);
  await page.waitForFunction(() => pendulumd.clock.time > 0);
  rig.front.fault = null;
  await close(page);
}

// --- files and storage that are refused

/** A first visit with trouble at files; fault(path, times) says whether this request is refused. */
async function visited(rig, refused) {
  const counts = new Map();
  rig.front.fault = (asked, reply) => {
    const { pathname } = new URL(asked.url, "http://page");
    const times = (counts.get(pathname) ?? 0) + 1;
    counts.set(pathname, times);
    if (!refused(pathname, times)) return false;
    reply.writeHead(429, { "Content-Type": "application/problem+json", "Retry-After": "1" }).end("{}");
    return true;
  };
  const page = await rig.open({ wait: false, cold: true });
  page.forgiven.push(FORGIVEN, /could not be loaded/);
  return { page, counts };
}

export async function the_page_s_own_script_and_style_that_are_refused_are_asked_for_again(rig) {
  const { page } = await visited(rig, (path, times) => /\/(main\.js|page\.css)$/.test(path) && times <= 2);
  await moving(page);
  await page.waitForFunction(() => getComputedStyle(document.body).margin === "0px");
  assert.equal(await page.locator("#waiting").count(), 0);
  await close(page);
}

export async function the_page_comes_without_what_runs_first(rig) {
  const { page } = await visited(rig, (path) => path.endsWith("/early.js"));
  await moving(page);
  await close(page);
}

export async function a_page_whose_script_does_not_come_says_so_and_offers_to_reload(rig) {
  const { page } = await visited(rig, (path) => path.endsWith("/main.js"));
  await page.waitForSelector("#waiting button", { state: "visible" });
  assert.match(await page.innerText("#waiting"), /reload it[^]*neu laden/);
  await rig.shot(page, "script_refused");
  rig.front.fault = null;
  await page.click("#waiting button");
  await moving(page);
  await close(page);
}

export async function a_page_of_which_nothing_comes_but_the_document_has_words(rig) {
  const { page } = await visited(rig, (path) => path.startsWith("/page/"));
  await page.waitForSelector("#waiting", { state: "visible" });
  assert.match(await page.innerText("body"), /reload it[^]*neu laden/);
  await rig.shot(page, "nothing_but_the_document");
  await close(page);
}

export async function a_drawer_whose_library_is_refused_says_so_and_comes_later(rig) {
  const page = await rig.open();
  page.forgiven.push(FORGIVEN);
  rig.front.fault = (asked, reply) => {
    if (!asked.url.includes("/lib/")) return false;
    reply.destroy();
    return true;
  };
  const drawers = ["share", "equations"];
  for (const id of drawers) await page.click(`[data-tab="${id}"]`);
  for (const id of drawers) {
    await page.waitForSelector(`[data-drawer="${id}"] [data-again]`, { state: "attached" });
    assert.match(await page.textContent(`[data-drawer="${id}"]`), /could not be loaded/);
  }
  await rig.shot(page, "library_refused");
  rig.front.fault = null;
  await page.click('[data-again="equations"]');
  await page.waitForSelector('[data-drawer="equations"] .katex');
  // opened again, a drawer tries by itself
  await page.click('[data-tab="share"]');
  await page.waitForSelector('[data-drawer="share"] .qr');
  await close(page);
}

export async function a_browser_that_refuses_storage_shows_the_page(rig) {
  const page = await rig.open({ cold: true });
  await refuseStorage(page);
  const holders = new Set();
  page.on("request", (asked) => asked.url().includes("/v1/") && holders.add(asked.headers().authorization));
  await page.reload();
  await moving(page);
  await page.waitForFunction(() => pendulumd.motion.stats);
  const dark = () => page.evaluate(() => document.documentElement.dataset.theme);
  const before = await dark();
  await page.click('[data-act="theme"]');
  assert.notEqual(await dark(), before);
  await page.selectOption(".tongue", "de");
  await page.click('[data-tab="worksheet"]');
  await page.click("[data-sheet=begin]");
  await page.waitForSelector('[data-drawer="worksheet"] .steps');
  assert.equal(holders.size, 1, "one token for the tab");
  await close(page);
}

export async function a_browser_is_somebody_by_a_token_of_its_own(rig) {
  const holders = [];
  for (let visit = 0; visit < 2; visit++) {
    const page = await rig.open({ cold: true });
    const sent = new Set();
    page.on("request", (asked) => asked.url().includes("/v1/") && sent.add(asked.headers().authorization));
    for (let again = 0; again < 2; again++) {
      await page.reload();
      await page.waitForFunction(() => window.pendulumd?.motion.stats);
    }
    assert.equal(sent.size, 1, "the same for every request, and after a reload");
    holders.push(...sent);
    await close(page);
  }
  for (const holder of holders) assert.match(holder, /^Bearer [\w-]{43}$/);
  assert.notEqual(holders[0], holders[1]);
}
