// The reports of the demonstration's runs: valid HTML that needs no scripts, on a desk and on a phone.

import assert from "node:assert/strict";
import { readFileSync, statSync } from "node:fs";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { HtmlValidate } from "html-validate";
import { seriousFaults } from "./access.mjs";
import { chromiumPath, demo, launch, tidy } from "./harness.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";
const MOST_BYTES = 5e6;

/** @type {import("playwright-core").Browser} */
let browser;
/** @type {string[]} */
let pages;

before(async () => {
  if (skip) return;
  const runs = demo();
  pages = [...runs.map((run) => join(run, "report.html")), join(dirname(dirname(runs[0])), "index.html")];
  browser = await launch();
});
after(async () => {
  await browser?.close();
  tidy();
});

/**
 * Opens a page in a context of its own.
 * @param {string} file @param {import("playwright-core").BrowserContextOptions} options
 */
async function opened(file, options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  await page.goto(pathToFileURL(file).href);
  return { page, close: () => context.close() };
}

test("reports are valid HTML of moderate size", { skip }, async () => {
  const validator = new HtmlValidate({ extends: ["html-validate:standard"] });
  for (const file of pages) {
    const { results } = await validator.validateString(readFileSync(file, "utf8"));
    const said = results.flatMap((result) => result.messages).map((m) => `${m.line}:${m.column} ${m.ruleId}: ${m.message}`);
    assert.deepEqual(said, [], file);
    assert.ok(statSync(file).size < MOST_BYTES, `${file}: ${statSync(file).size} bytes`);
  }
});

test("reports need no scripts", { skip }, async () => {
  for (const file of pages) {
    const { page, close } = await opened(file, { javaScriptEnabled: false });
    assert.equal(await page.locator("script").count(), 0, file);
    const pictures = page.locator("img, svg[role=img]");
    assert.ok((await pictures.count()) > 0, file);
    for (const picture of await pictures.all()) {
      const told = (await picture.getAttribute("alt")) ?? (await picture.getAttribute("aria-label")) ?? (await picture.locator("title").first().textContent());
      assert.ok((told ?? "").length > 10, `${file}: a picture without words`);
    }
    await close();
  }
  const { page, close } = await opened(pages[0], { javaScriptEnabled: false });
  const folded = page.locator("details").first();
  const inside = folded.locator("table, ul, dl, p").first();
  assert.equal(await inside.isVisible(), false);
  await folded.locator("summary").click();
  assert.equal(await inside.isVisible(), true);
  await close();
});

test("reports fit phones and have no serious faults of access", { skip }, async () => {
  for (const file of pages) {
    for (const width of [390, 1280]) {
      const { page, close } = await opened(file, { viewport: { width, height: 844 } });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${file}: ${wide} px wide at ${width} px`);
      assert.deepEqual(await seriousFaults(page), [], file);
      await close();
    }
  }
});
