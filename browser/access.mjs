// What axe finds, on a page and on all looks of the viewer's.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { open, shot } from "./harness.mjs";

/** Faults of access that are serious or worse, with the first element that has them. @param {import("playwright-core").Page} page */
export async function seriousFaults(page) {
  await page.evaluate(readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8"));
  const { violations } = await page.evaluate(() => /** @type {any} */ (window).axe.run({ resultTypes: ["violations"] }));
  const serious = violations.filter((/** @type {{impact: string}} */ found) => ["serious", "critical"].includes(found.impact));
  return serious.map((/** @type {{id: string, nodes: {html: string}[]}} */ found) => `${found.id}: ${found.nodes[0].html}`);
}

/**
 * The viewer's page has no serious fault and fits the screen: dark and light, on a desk and, pane by pane, on a phone.
 * @param {import("playwright-core").Browser} browser
 * @param {string} address
 * @param {string} shots how the names of the pictures begin
 */
export async function everyLookIsAccessible(browser, address, shots) {
  const desk = { name: "desk", viewport: { width: 1440, height: 900 }, panes: ["all"] };
  const phone = { name: "phone", viewport: { width: 390, height: 844 }, panes: ["image", "radargram", "side"] };
  for (const colorScheme of /** @type {("dark" | "light")[]} */ (["light", "dark"])) {
    for (const { name, viewport, panes } of [desk, phone]) {
      const isPhone = name === "phone";
      const { page, complaints, close } = await open(browser, address, { viewport, colorScheme, hasTouch: isPhone, isMobile: isPhone });
      for (const pane of panes) {
        if (isPhone) await page.click(`.tabs [data-show=${pane}]`);
        await page.waitForTimeout(300);
        assert.deepEqual(await seriousFaults(page), [], `${name} ${colorScheme} ${pane}`);
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${name}: wider than the screen`);
        await shot(page, `${shots}${name}-${colorScheme}-${pane}`);
      }
      assert.deepEqual(complaints, []);
      await close();
    }
  }
}
