// The ground under an image that stands on terrain.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { chromiumPath, demoWith, folder, launch, open, serve, shot, tidy } from "./harness.mjs";
import { colourAt, onScreen, readout } from "./look.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";
/** Rise of the ground towards the east. */
const SLOPE = 0.05;

/** @type {Awaited<ReturnType<typeof serve>>} */
let server;
/** @type {import("playwright-core").Browser} */
let browser;

before(async () => {
  if (skip) return;
  const terrain = join(folder, "slope.asc");
  const [side, cell, west, south] = [120, 0.5, -15, -30];
  const row = Array.from({ length: side }, (_, k) => (SLOPE * (west + k * cell)).toFixed(4)).join(" ");
  writeFileSync(terrain, `ncols ${side}\nnrows ${side}\nxllcenter ${west}\nyllcenter ${south}\ncellsize ${cell}\n${`${row}\n`.repeat(side)}`);
  const image = `band_ghz = [3.1, 4.8]\nx_m = [2.5, 9.5]\ny_m = [-3.0, 3.0]\nterrain = ${JSON.stringify(terrain)}\nterrain_crs = "local"\npixel_m = 0.02\n[checks]\ncontradictions = "warn"`;
  server = await serve([demoWith("terrain", image)]);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  server?.stop();
  tidy();
});

test("contours lie at their heights, which the cursor tells", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.image.ground);
  const { step_m, levels } = await page.evaluate(() => {
    const { step_m, contours } = /** @type {any} */ (window).acerra.image.ground;
    return { step_m, levels: contours.map((/** @type {any} */ one) => one.level_m) };
  });
  assert.equal(step_m, 0.05);
  levels.forEach((/** @type {number} */ level, /** @type {number} */ k) => assert.ok(Math.abs(level - 0.05 * (k + 3)) < 1e-9, `${levels}`));
  assert.equal(levels.length, 7);
  for (const x of [4, 6, 9]) {
    // Beside the labels, which stand a third along the lines.
    const at = async (/** @type {number} */ east) => (await colourAt(page, "image", east, -2.2, true)).slice(0, 4);
    const [r, g, b, a] = await at(x);
    // The line of one pixel may lie on two.
    assert.ok(Math.min(r, g, b) > 100 && a > 150, `contour at ${x} m: ${[r, g, b, a]}`);
    assert.equal((await at(x + 0.5))[3], 0, `between contours at ${x + 0.5} m`);
    await page.mouse.move(...(await onScreen(page, "image", x, -2.2)));
    await page.waitForFunction((east) => Math.abs((/** @type {any} */ (window).acerra.image.cursor?.place_m[0] ?? 0) - east) < 0.02, x);
    const told = await readout(page, "image-readout");
    assert.ok(Math.abs(told.z - SLOPE * told.x) < 1.5e-3, JSON.stringify(told));
  }
  await shot(page, "terrain");
  await page.getByLabel("Contours of the ground").uncheck();
  await page.waitForFunction(() => !/** @type {any} */ (window).acerra.store.look.contours);
  assert.equal((await colourAt(page, "image", 4, -2.2, true))[3], 0);
  assert.deepEqual(complaints, []);
  await close();
});

test("contours of round ground are circles", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  const off = await page.evaluate(async () => {
    const { contoursOf } = await import(new URL("js/terrain.js", location.href).href);
    const n = 81;
    const height_m = Array.from({ length: n * n }, (_, k) => (((k % n) - 40) ** 2 + (Math.floor(k / n) - 40) ** 2) / 16);
    const { contours } = contoursOf({ stride: 2, columns: n, rows: n, height_m }, { x0_m: -2000, y0_m: -2000, z_m: 0, pixel_m: 25, nx: 2 * n, ny: 2 * n, uneven: true });
    const c = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
    // Linear interpolation between nodes 50 m apart strays by up to 0.6 m.
    c.lineWidth = 4;
    const wrong = [];
    for (const { level_m, path } of contours) {
      const radius = 200 * Math.sqrt(level_m);
      if (radius < 500 || radius > 1900) continue;
      for (let k = 0; k < 90; k++) {
        const [x, y] = [Math.cos((k + 0.5) / 14.3), Math.sin((k + 0.5) / 14.3)];
        if (!c.isPointInStroke(path, radius * x, radius * y)) wrong.push([level_m, k]);
        if (c.isPointInStroke(path, (radius + 20) * x, (radius + 20) * y)) wrong.push([level_m, -k]);
      }
    }
    return { wrong, count: contours.length };
  });
  assert.deepEqual(off.wrong, []);
  assert.ok(off.count >= 8, `${off.count}`);
  await close();
});
