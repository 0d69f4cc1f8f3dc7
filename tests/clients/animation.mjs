// Opens a page in a browser and sees whether what it draws moves.
// usage: animation.mjs URL     Leaves to others: the page (the README of the JavaScript client). Invariant: the browser ends with it.
import { createRequire } from "node:module";

const { chromium } = createRequire(process.env.PACKAGES + "/package.json")("playwright-core");
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
try {
  const page = await browser.newPage();
  page.on("pageerror", (error) => console.log(`FAIL the page says: ${error}`));
  await page.goto(process.argv[2]);
  const picture = () => page.evaluate(() => document.querySelector("canvas").toDataURL());
  const blank = await picture();
  const seen = new Set();
  for (let tries = 0; tries < 1200 && seen.size < 3; tries++) {
    await page.waitForTimeout(50);
    const now = await picture();
    if (now !== blank) seen.add(now);
  }
  console.log(`${seen.size >= 3 ? "ok" : "FAIL"} the animation moves: ${seen.size} pictures`);
} finally {
  await browser.close();
}
