// The widget of notebooks in a page that keeps its traits as anywidget does: what Python sets is shown, what is dragged is saved.
// usage: widget.mjs URL     Leaves to others: the stage (tests/web), anywidget. Invariant: the browser ends with it.
import { createRequire } from "node:module";

const { chromium } = createRequire(process.env.PACKAGES + "/package.json")("playwright-core");
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
const request = (n) => ({ pendulum: { length: Array(n).fill(1), mass: Array(n).fill(1), parent: [...Array(n).keys()] }, initial: { phi: Array(n).fill(-Math.PI / 2), phid: Array(n).fill(0) }, times: { start: 0, stop: 10, step: 0.01 } });
try {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  page.on("pageerror", (error) => console.log(`FAIL the page says: ${error}`));
  await page.goto(process.argv[2]);
  await page.evaluate(async ([url, scene]) => {
    const { default: widget } = await import("./widget.js");
    const traits = { url, height: 420, scene, time: 0, playing: false };
    const heard = {};
    window.model = {
      get: (name) => traits[name],
      set(name, value) {
        traits[name] = value;
        for (const hear of heard[`change:${name}`] ?? []) hear();
      },
      save_changes: () => (window.saved = structuredClone(traits)),
      on: (event, hear) => (heard[event] ??= new Set()).add(hear),
      off: (event, hear) => heard[event].delete(hear),
    };
    window.close_widget = widget.render({ model: window.model, el: document.body });
    window.listeners = () => Object.values(heard).reduce((sum, hears) => sum + hears.size, 0);
  }, [process.argv[3], { request: request(2) }]);
  const arms = (n) => page.waitForFunction((count) => window.saved?.scene.request.pendulum.length.length === count, n, { timeout: 60000 });
  await arms(2);
  console.log("ok the frame reports the pendulum that Python set");
  await page.evaluate((scene) => window.model.set("scene", scene), { request: request(3) });
  await arms(3);
  console.log("ok another pendulum is shown");
  const angle = () => page.evaluate(() => Math.max(...window.saved.scene.request.initial.phi.map((phi) => Math.abs(phi + Math.PI / 2))));
  for (let y = 60; y < 420 && !((await angle()) > 0.1); y += 12) {
    await page.mouse.move(320, y);
    await page.mouse.down();
    await page.mouse.move(420, y, { steps: 5 });
    await page.mouse.up();
    await page.waitForTimeout(400);
  }
  console.log(`${(await angle()) > 0.1 ? "ok" : "FAIL"} a drag is saved as the new start: ${await angle()} rad`);
  const left = await page.evaluate(() => (window.close_widget(), window.listeners()));
  console.log(`${left ? "FAIL" : "ok"} closed, it hears nothing more`);
} finally {
  await browser.close();
}
