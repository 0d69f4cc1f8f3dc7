// The page in every language that it offers: chosen by the address, by a choice that is kept, by the browser; asked for alone.
// Leaves to others: whether a language says all (words.mjs).

import assert from "node:assert/strict";
import { ARABIC, arabic } from "./arabic.mjs";
import { close, drawn } from "./rig.mjs";
import { openDrawer } from "./drawers.mjs";
import { LANGUAGES } from "../../server/web/text/languages.js";

const wordsOf = async (language, part = "page") => (await import(`../../server/web/text/${language}/${part}.js`)).default;
const asked = (page) => page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => new URL(name).pathname).filter((path) => path.includes("/text/")));
const speaks = async (page, language) => {
  const { name } = await wordsOf(language);
  await page.waitForFunction(([tongue, words]) => document.documentElement.lang === tongue && document.querySelector("h1")?.textContent === words, [language, name]);
};

export async function the_page_speaks_each_of_its_languages_and_asks_for_no_other(rig) {
  for (const language of Object.keys(LANGUAGES)) {
    const page = await rig.open({ language });
    await speaks(page, language);
    await openDrawer(page, "plots");
    assert.ok((await asked(page)).every((path) => path.includes(`/text/${language}/`) || path.endsWith("/text/languages.js") || path.endsWith("/text/en/page.js")), (await asked(page)).join(" "));
    await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(3.3); pendulumd.edits.select(1); });
    await drawn(page);
    const seen = await page.evaluate(() => [document.body.innerText, ...[...document.querySelectorAll("[aria-label], [title]")]
      .flatMap((element) => [element.ariaLabel, element.title])].join("\n"));
    const bare = seen.match(/\b(?:arm|time|legend|drawer|preset|presets|plots|kit|help|said|step|failure)\.[a-z.]+/g);
    assert.equal(bare, null, `${language}: keys are shown: ${bare}`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${language}: ${wide} pixels too wide`);
    await rig.shot(page, `language-${language}`);
    await close(page);
  }
}

export async function a_language_that_is_chosen_is_kept_and_stands_in_the_address(rig) {
  const page = await rig.open({ language: "de-DE" });
  await speaks(page, "de");
  await page.selectOption(".tongue", "en");
  await speaks(page, "en");
  assert.equal(new URL(page.url()).searchParams.get("lang"), "en");
  await page.goto(rig.url);
  await speaks(page, "en");
  await page.goto(`${rig.url}/?lang=de`);
  await speaks(page, "de");
  await page.goto(`${rig.url}/?lang=xx`);
  await speaks(page, "en");
  await close(page);
}

export async function words_that_do_not_come_are_told_and_the_page_speaks_english(rig) {
  rig.front.fault = (request, reply) => {
    if (!request.url.includes("/text/de/page.js")) return false;
    reply.writeHead(500).end();
    return true;
  };
  const page = await rig.open({ language: "de", wait: false, cold: true });
  page.forgiven.push(/Failed to load resource/);
  await page.waitForSelector(".notice.bad:not([hidden])");
  await speaks(page, "en");
  assert.match(await page.innerText(".notice"), /could not be loaded/);
  rig.front.fault = null;
  await page.selectOption(".tongue", "de");
  await speaks(page, "de");
  await close(page);
}

export async function what_the_server_refuses_is_told_in_the_page_s_language(rig) {
  const page = await rig.open({ language: "fr" });
  const words = await wordsOf("fr");
  const said = async (change) => {
    await page.evaluate(change);
    await page.waitForSelector(".notice.bad:not([hidden])");
    return page.innerText(".notice.bad span");
  };
  page.forgiven.push(/422/);
  const number = await said(() => pendulumd.store.set({ pendulum: { ...pendulumd.store.get().pendulum, mass: [1, 1, 0, 1] } }));
  const what = words["problem.arm"].replace("{what}", words["arm.mass"]).replace("{arm}", "3");
  assert.equal(number, words["arm.wrong.positive"].replace("{what}", what));
  await page.evaluate(() => pendulumd.undo());
  const limit = await said(() => pendulumd.store.set({ rtol: 5 }));
  assert.equal(limit, words["problem.value"].replace("{what}", words["step.tolerance"]));
  await close(page);
}

export async function a_language_from_right_to_left_turns_the_page_and_has_its_own_plurals(rig) {
  arabic(rig, { page: await wordsOf("en"), drawers: await wordsOf("en", "drawers") });
  for (const [name, size] of [["wide", {}], ["phone", { width: 390, height: 844, touch: true }]]) {
    const page = await rig.open({ path: "/?lang=ar", cold: true, ...size });
    await page.waitForFunction((words) => document.querySelector("h1")?.textContent === words, ARABIC.name);
    assert.deepEqual(await page.evaluate(() => [document.documentElement.lang, document.documentElement.dir]), ["ar", "rtl"]);
    await openDrawer(page, "presets");
    await page.waitForSelector('[data-preset="mobile"]:not([disabled])');
    await page.evaluate(() => { pendulumd.clock.pause(); pendulumd.clock.seek(3.3); pendulumd.edits.select(1); });
    await drawn(page);
    await rig.shot(page, `language-rtl-${name}`);
    assert.equal(await page.textContent('[data-preset="single"] .quiet'), ARABIC["presets.arms.one"]);
    assert.equal(await page.textContent('[data-preset="double"] .quiet'), ARABIC["presets.arms.two"]);
    assert.equal(await page.textContent('[data-preset="triple"] .quiet'), ARABIC["presets.arms.few"].replace("{count}", "3"));
    const box = (selector) => page.evaluate((what) => document.querySelector(what).getBoundingClientRect().toJSON(), selector);
    const [title, tools, play, slider] = [await box("h1"), await box("#header .tools"), await box("#timebar button"), await box("#timebar input[type=range]")];
    assert.ok(title.left > tools.left, "the head begins at the right");
    assert.ok(play.left < slider.left, "time runs from left to right, as in every plot");
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth - innerWidth, document.querySelector("#drawers .panels").getBoundingClientRect().left]);
    assert.ok(wide[0] <= 0 && wide[1] >= 0, `${name}: ${wide} pixels beside the screen`);
    await openDrawer(page, "plots");
    await drawn(page);
    await rig.shot(page, `language-rtl-plots-${name}`);
    await close(page);
  }
}

export async function a_number_that_is_shown_as_nothing_has_no_sign(rig) {
  const page = await rig.open();
  const shown = await page.evaluate(() => [-1e-14, -0, -0.04, -0.05, 0.04, NaN].map((value) => pendulumd.text.number(value, 1)));
  assert.deepEqual(shown, ["0.0", "0.0", "0.0", "\u22120.1", "0.0", "NaN"]);
  await close(page);
}

export async function numbers_are_written_as_each_language_has_them(rig) {
  const page = await rig.open();
  const odd = await page.evaluate(async (languages) => {
    const { text } = pendulumd;
    const values = [0, 1, -1, 0.5, -12.25, 1234567.891, 9.81, 1e-3, 4e-6, 3.2e-9, -7.5e-12, 6.02e23, Infinity, 0.1 + 0.2, 99.996, 2e-5];
    const found = [];
    for (const language of languages) {
      await text.use(language);
      const by = (options) => new Intl.NumberFormat(`${language}-u-nu-latn`, { useGrouping: false, ...options });
      for (const value of values) for (const digits of [1, 2, 3, 4, 6]) {
        const pairs = [[text.short(value, digits), by({ maximumSignificantDigits: digits }).format(value)],
          [text.number(value, digits), by({ minimumFractionDigits: digits, maximumFractionDigits: digits }).format(Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value)]];
        for (const [got, wanted] of pairs) if (got !== wanted.replace("-", "\u2212")) found.push([language, value, digits, got, wanted]);
        if (Number.isFinite(value) && Math.abs(text.read(text.short(value, 6)) - value) > 1e-5 * Math.abs(value)) found.push([language, "read", value]);
      }
    }
    const typed = ["\u200e\u221245", "\u0664\u0665\u066b\u0665", " 1,5 ", "\u06f1\u06f2", "", "1 000", "x", "90\u00b0", "\u00b0", "90\u00b0 ", "- 5", "1 2", "1 234 567,5", "1.234,5"].map((words) => text.read(words));
    await text.use("en");
    const far = [1e-320, -1e-320, 1e30, -1.23456e300].map((value) => [text.short(value, 4), text.read(text.short(value, 4)), text.number(value, 2)]);
    return { found, typed, far };
  }, Object.keys(LANGUAGES));
  assert.deepEqual(odd.found, []);
  assert.deepEqual(odd.typed, [-45, 45.5, 1.5, 12, NaN, 1000, NaN, 90, NaN, 90, -5, NaN, 1234567.5, NaN]);
  assert.deepEqual(odd.far, [["1e\u2212320", 1e-320, "0.00"], ["\u22121e\u2212320", -1e-320, "0.00"], ["1e+30", 1e30, "1e+30"],
    ["\u22121.235e+300", -1.235e300, "\u22121.23456e+300"]]);
  await close(page);
}
