// The page behind a proxy that gives it a path of its own (https://school/pendulum/): it swings, its drawers come, what it links
// leads back to it, the reference and its examples come, and it is kept for a time without a server.

import assert from "node:assert/strict";
import { createServer, request } from "node:http";
import { openDrawer } from "./drawers.mjs";
import { close, moving } from "./rig.mjs";

export const rig = { sources: false, store: true };

const PATH = "/pendulum";

/** A proxy that knows the daemon under a path and nothing else: {url, strayed, stop()}; strayed: what was asked beside it. */
async function startProxy(daemon) {
  const strayed = [];
  const { hostname, port } = new URL(daemon);
  const server = createServer((asked, reply) => {
    if (!asked.url.startsWith(`${PATH}/`)) {
      strayed.push(asked.url);
      reply.writeHead(404).end();
      return;
    }
    const onward = request({ hostname, port, method: asked.method, path: asked.url.slice(PATH.length), headers: asked.headers }, (answer) => {
      const { trailer, ...headers } = answer.headers;
      reply.writeHead(answer.statusCode, headers);
      answer.pipe(reply);
    });
    onward.on("error", () => reply.destroy());
    reply.on("close", () => onward.destroy());
    asked.pipe(onward);
  });
  await new Promise((ready) => { server.listen(0, "127.0.0.1", ready); });
  return {
    strayed, url: `http://127.0.0.1:${server.address().port}`,
    stop() {
      server.closeAllConnections();
      server.close();
    },
  };
}

export async function the_page_works_under_a_path_that_a_proxy_gives_it(rig) {
  const proxy = await startProxy(rig.daemon.url);
  const page = await rig.openAt(proxy.url, { path: `${PATH}/?length=1,1&theta=90,45`, cold: true, serviceWorkers: "allow" });
  page.forgiven.push(/Failed to load resource|net::ERR/); // when the proxy has ended
  await page.waitForFunction(() => pendulumd.clock.time > 0);
  for (const id of ["plots", "modes", "equations", "share"]) await openDrawer(page, id);
  await page.waitForSelector("[data-drawer=share] svg.qr");
  const shared = await page.evaluate(() => document.querySelector("[data-drawer=share]").innerHTML.match(/http:[^"&?]+/g));
  assert.ok(shared === null || shared.every((link) => link.startsWith(`${proxy.url}${PATH}/`)), String(shared));
  await page.waitForFunction(() => pendulumd.offline.kind === "kept" && navigator.serviceWorker.controller);
  await page.click(".docs-link");
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
  assert.equal(page.url(), `${proxy.url}${PATH}/docs`);
  await page.goto(`${proxy.url}${PATH}/`);
  await moving(page);
  // no room has this code: the page opens all the same, and says so
  await page.goto(`${proxy.url}${PATH}/PK7TRA`);
  assert.equal(page.url(), `${proxy.url}${PATH}/?room=PK7TRA`);
  await moving(page);
  assert.deepEqual(proxy.strayed, [], "nothing is asked for beside the path");
  proxy.stop();
  await page.goto(`${proxy.url}${PATH}/?length=1&theta=45`);
  await page.waitForFunction(() => window.pendulumd?.clock.time > 0);
  await close(page);
}

export async function what_is_handed_on_under_a_path_leads_back_below_it(rig) {
  const proxy = await startProxy(rig.daemon.url);
  const home = `${proxy.url}${PATH}/`;
  const page = await rig.openAt(proxy.url, { path: `${PATH}/?length=1,1&theta=90,45`, cold: true });
  await moving(page);
  await openDrawer(page, "share");
  await page.click("[data-share=make]");
  await page.waitForFunction(() => document.querySelector("[data-link=short]")?.value);
  for (const name of ["plain", "long", "short"]) {
    const link = await page.inputValue(`[data-link=${name}]`);
    assert.ok(link.startsWith(home), `${name}: ${link}`);
    const other = await rig.openAt(proxy.url, { path: link.slice(proxy.url.length), cold: true });
    await moving(other);
    assert.deepEqual(await other.evaluate(() => pendulumd.store.get().pendulum.length), [1, 1], name);
    await close(other);
  }
  await openDrawer(page, "class");
  await page.click("[data-class=make]");
  const code = await page.textContent(".room-code");
  await page.click("[data-class=showCode]");
  const told = await page.textContent("dialog.code .address, dialog .address");
  assert.equal(`http://${told}`, home + code, "the address that a class types");
  const pupil = await rig.openAt(proxy.url, { path: `${PATH}/${code}`, cold: true, wait: false });
  await pupil.waitForSelector("[data-class=nickname]");
  assert.deepEqual(proxy.strayed, []);
  await close(pupil);
  await close(page);
  proxy.stop();
}
