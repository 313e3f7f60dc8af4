// A live image in the browser: the demonstration's second track, flown by emulated instruments.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { seriousFaults } from "./access.mjs";
import { chromiumPath, folder, launch, run, shot, tidy } from "./harness.mjs";
import { flyLive } from "./live-flight.mjs";
import { readNpz } from "./npz.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";
/** Where the second track's reflectors stand (m). */
const REFLECTORS = [[4, 0], [14, 0]];

/** @type {import("playwright-core").Browser} */
let browser;
before(async () => {
  if (!skip) browser = await launch();
});
after(async () => {
  await browser?.close();
  tidy();
});

/** The strongest place about a reflector, by the picture itself. @param {import("playwright-core").Page} page @param {number[]} at */
const strongest = (page, at) =>
  page.evaluate(([x, y]) => {
    const { picture } = /** @type {any} */ (window).acerra;
    const { x0_m, y0_m, pixel_m, nx, ny } = picture.grid;
    let found = { level: -1, x_m: 0, y_m: 0, top: 0 };
    for (let j = 0; j < ny; j++) {
      for (let i = 0; i < nx; i++) {
        const level = picture.levels[j * nx + i];
        const [x_m, y_m] = [x0_m + i * pixel_m, y0_m + j * pixel_m];
        if (Math.hypot(x_m - x, y_m - y) < 2 && level > found.level) found = { ...found, level, x_m, y_m };
        found.top = Math.max(found.top, level);
      }
    }
    return found;
  }, at);

test("the image grows while it is recorded, targets stand where they are, and the final image is that of focus", { skip, timeout: 240_000 }, async () => {
  const live = await flyLive("live-test", { speed: 3.3 });
  try {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
    /** @type {string[]} */
    const complaints = [];
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
    page.on("pageerror", (error) => complaints.push(error.message));
    await page.goto(live.address);
    const imaged = () => page.evaluate(() => /** @type {any} */ (window).acerra?.state?.status.pulses.imaged ?? 0);
    await page.waitForFunction(() => /** @type {any} */ (window).acerra?.state?.status.pulses.imaged > 40, null, { timeout: 120_000 });
    const first = await imaged();
    await shot(page, "live-begun");
    await page.waitForFunction((n) => /** @type {any} */ (window).acerra?.state?.status.pulses.imaged > n + 150, first, { timeout: 120_000 });
    assert.match(await page.textContent("#image-state") ?? "", /pulses at positions of the receiver: \d+ RTK fixed/);
    await live.flown();
    await page.waitForTimeout(500);
    for (const at of REFLECTORS) {
      const found = await strongest(page, at);
      assert.ok(Math.hypot(found.x_m - at[0], found.y_m - at[1]) < 0.4, `${JSON.stringify(found)} about ${at}`);
      // Levels are of half a decibel: both stand out.
      assert.ok(found.top - found.level < 30, JSON.stringify(found));
    }
    const { status } = await page.evaluate(() => /** @type {any} */ (window).acerra?.state);
    assert.equal(status.pulses.missed_records, 0);
    assert.equal(status.pulses.too_many, 0);
    assert.ok(status.drawn.pulses > 100);
    await shot(page, "live-flown");

    await page.locator("#stop").click();
    await shot(page, "live-stop");
    await page.keyboard.press("Escape");
    await page.locator("#stop").click();
    await page.getByRole("button", { name: "Go on recording" }).click();
    await page.waitForTimeout(500);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.final), "recording");
    await page.locator("#stop").click();
    await page.getByRole("button", { name: "End the recording" }).click();
    await page.waitForFunction(() => document.documentElement.dataset.final === "made", null, { timeout: 120_000 });
    await page.waitForFunction(() => /** @type {HTMLImageElement} */ (document.getElementById("final-picture")).naturalWidth > 0, null, { timeout: 30_000 });
    await shot(page, "live-final");
    assert.equal(await page.textContent("#image-title"), "Final image");
    assert.ok(!(await page.locator("#stop").isVisible()));
    const middle = await page.locator("#image-box").boundingBox();
    assert.ok(middle);
    const top = await page.evaluate(([x, y]) => document.elementFromPoint(x, y)?.id, [middle.x + middle.width / 2, middle.y + middle.height / 2]);
    assert.equal(top, "final-picture");
    await page.locator("#which").click();
    assert.equal(await page.textContent("#image-title"), "Provisional image");
    assert.ok(!(await page.locator("#final-picture").isVisible()));
    const link = page.locator("#final");
    assert.ok(await link.isVisible());
    const campaign = join(live.directory, "campaign.toml");
    run("focus", campaign, "-o", join(folder, "live-again"));
    const [own, again] = [join(live.directory, "campaign-products"), join(folder, "live-again")].map((products) => readFileSync(join(products, "image.npz")));
    assert.ok(own.equals(again), "the final image is that of focus, byte for byte");
    assert.ok(readNpz(join(folder, "live-again", "image.npz")).has("image"));
    await link.click();
    await page.waitForFunction(() => /** @type {any} */ (window).acerra?.image?.own?.layer.complete, null, { timeout: 60_000 });
    assert.match(page.url(), /\/view\/$/);
    assert.deepEqual(complaints, []);
    await page.close();
  } finally {
    await live.end();
  }
});

test("positions that cannot focus are said to, on a phone as well", { skip, timeout: 180_000 }, async () => {
  const live = await flyLive("live-single", { speed: 6, solutions: "single", more: ["--no-final"] });
  try {
    const context = await browser.newContext({ viewport: { width: 390, height: 780 }, hasTouch: true, colorScheme: "dark" });
    const page = await context.newPage();
    await page.goto(live.address);
    await page.waitForFunction(() => /** @type {any} */ (window).acerra?.state?.status.pulses.imaged > 60, null, { timeout: 120_000 });
    await shot(page, "live-phone");
    await page.locator(".tabs button[data-show=side]").tap();
    assert.match(await page.textContent("#doubts") ?? "", /cannot focus/);
    assert.ok(await page.locator("#state").isVisible());
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    assert.ok(overflow <= 0, `${overflow} pixels too wide`);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "dark");
    await shot(page, "live-phone-state");
    await page.locator("#stop").tap();
    await shot(page, "live-phone-stop");
    assert.deepEqual(await seriousFaults(page), []);
    await page.getByRole("button", { name: "Go on recording" }).tap();
    live.stop();
    await page.waitForFunction(() => document.documentElement.dataset.final === "ended", null, { timeout: 30_000 });
    assert.ok(!(await page.locator("#final").isVisible()));
    await context.close();
  } finally {
    await live.end();
  }
});
