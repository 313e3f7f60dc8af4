// Slices of a volume and cuts through it, asserted against volume.npz.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { everyLookIsAccessible } from "./access.mjs";
import { chromiumPath, demoWith, launch, open, serve, shot, tidy } from "./harness.mjs";
import { colourAt, near, onScreen, readout } from "./look.mjs";
import { readNpz } from "./npz.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";

/** @type {Awaited<ReturnType<typeof serve>>} */
let server;
/** @type {import("playwright-core").Browser} */
let browser;
/** @type {ReturnType<typeof volumeOf>} */
let volume;

before(async () => {
  if (skip) return;
  // Wider than a tile, so that slices and cuts consist of several.
  const run = demoWith("volume", "band_ghz = [3.1, 4.8]\nx_m = [2.0, 10.0]\ny_m = [-3.0, 3.0]\nz_m = [0.0, 0.6]\npixel_m = 0.025\npixel_z_m = 0.05");
  volume = volumeOf(run);
  server = await serve([run]);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  server?.stop();
  tidy();
});

/** The volume as its file holds it. @param {string} run */
function volumeOf(run) {
  const arrays = readNpz(join(run, "volume.npz"));
  const take = (/** @type {string} */ name) => /** @type {import("./npz.mjs").Named} */ (arrays.get(name));
  const { shape, values } = take("volume");
  const [nz, ny, nx] = shape;
  let greatest = 0;
  for (let n = 0; n < values.length; n += 2) greatest = Math.max(greatest, Math.hypot(values[n], values[n + 1]));
  const at = (/** @type {number[]} */ [i, j, k]) => {
    const n = 2 * ((k * ny + j) * nx + i);
    return [values[n], values[n + 1]];
  };
  const level = (/** @type {number[]} */ place) => 20 * Math.log10(Math.hypot(...at(place)) / greatest);
  const phase = (/** @type {number[]} */ place) => (Math.atan2(at(place)[1], at(place)[0]) * 180) / Math.PI;
  return { nx, ny, nz, x: take("x_m").values, y: take("y_m").values, z: take("z_m").values, level, phase };
}

/** Waits until slice and cuts shown are those of a place. @param {import("playwright-core").Page} page @param {number[]} place */
async function shown(page, [i, j, k]) {
  await page.waitForFunction(([a, b, c]) => {
    const { image, cuts } = /** @type {any} */ (window).acerra;
    const layers = [image.slice, cuts.cuts[0].layer, cuts.cuts[1].layer];
    for (const pane of [image, ...cuts.cuts]) pane.pane.draw();
    return layers.every((layer, n) => layer.complete && layer.shown.index === [c, b, a][n]);
  }, [i, j, k]);
}

/** Zooms a pane until a value takes several pixels of the screen. @param {import("playwright-core").Page} page @param {string} pane @param {number} x @param {number} y @param {number} kx @param {number} ky */
async function zoom(page, pane, x, y, kx, ky) {
  await page.evaluate(([path, view]) => {
    const shown = path.split(".").reduce((/** @type {any} */ o, key) => o[key], /** @type {any} */ (window).acerra);
    Object.assign(shown.pane.camera, view);
  }, /** @type {[string, object]} */ ([pane, { x, y, kx, ky }]));
}

/** What is told under the pointer at a point of a pane. @param {import("playwright-core").Page} page @param {string} pane @param {number} x @param {number} y @param {number[]} place */
async function told(page, pane, x, y, [i, j, k]) {
  await page.mouse.move(...(await onScreen(page, pane, x, y)));
  await page.waitForFunction(([a, b, c]) => {
    const { cursor, asked } = /** @type {any} */ (window).acerra.image;
    return cursor?.pixel?.[0] === a && cursor.pixel[1] === b && asked.slice === c;
  }, [i, j, k]);
  return readout(page, "image-readout");
}

test("slices and cuts show the values of volume.npz, and the cursor tells them", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const { x, y, z } = volume;
  const table = await page.evaluate(async () => [...new Uint8Array(await (await fetch("api/palette/inferno")).arrayBuffer())]);
  const [floor, top] = await page.evaluate(() => /** @type {any} */ (window).acerra.store.look.window);
  const colour = (/** @type {number[]} */ place) => {
    const index = Math.round(255 * Math.min(Math.max((volume.level(place) - floor) / (top - floor), 0), 1));
    return table.slice(4 * index, 4 * index + 3);
  };
  // At first the strongest along each vertical; the slider shows slices.
  assert.equal(await page.evaluate(() => /** @type {any} */ (window).acerra.image.slice.shown), null);
  for (const place of [[120, 119, 0], [281, 120, 3], [37, 200, 12]]) {
    const [i, j, k] = place;
    await page.keyboard.press("Escape");
    await page.$eval("#slice", (input, v) => {
      /** @type {HTMLInputElement} */ (input).value = String(v);
      input.dispatchEvent(new Event("input", { bubbles: true }));
    }, k);
    await zoom(page, "image", x[i], y[j], 800, 800);
    // The cuts follow the pointer.
    const here = await told(page, "image", x[i], y[j], place);
    await shown(page, place);
    near([here.x, here.y, here.z], [x[i], y[j], z[k]], 2e-3, "place");
    near([here.level], [volume.level(place)], 0.006, `level at ${place}`);
    near([here.phase], [volume.phase(place)], 0.06, `phase at ${place}`);
    near(await colourAt(page, "image", x[i], y[j]), colour(place), 8, `slice at ${place}`);
    // Held there by a click, the pointer goes to the cuts: a value beside the place, higher up.
    await page.mouse.click(...(await onScreen(page, "image", x[i], y[j])));
    const up = (k + 5) % 13;
    for (const [cut, s, beside] of /** @type {[string, number, number[]][]} */ ([["cuts.cuts.0", x[i + 2], [i + 2, j, up]], ["cuts.cuts.1", y[j - 1], [i, j - 1, up]]])) {
      await zoom(page, cut, s, z[up], 800, 400);
      await shown(page, place);
      near(await colourAt(page, cut, s, z[up]), colour(beside), 8, `${cut} at ${beside}`);
      const there = await told(page, cut, s, z[up], beside);
      near([there.x, there.y, there.z], [x[beside[0]], y[beside[1]], z[up]], 2e-3, "place");
      near([there.level], [volume.level(beside)], 0.006, `level at ${beside}`);
      near([there.phase], [volume.phase(beside)], 0.06, `phase at ${beside}`);
    }
  }
  assert.deepEqual(complaints, []);
  await close();
});

test("a click on a cut moves slice and cuts there; keys step through the slices", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const { x, y, z } = volume;
  await page.mouse.click(...(await onScreen(page, "image", x[100], y[110])));
  await page.keyboard.press("PageUp");
  await shown(page, [100, 110, 0]);
  await page.mouse.click(...(await onScreen(page, "cuts.cuts.0", x[200], z[6])));
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.sliceIndex === 6);
  const mark = await page.evaluate(() => /** @type {any} */ (window).acerra.store.mark);
  near([mark.x, mark.y], [x[200], y[110]], 0.03, "mark");
  const cut = await page.evaluate(() => /** @type {any} */ (window).acerra.cuts.cuts.map((/** @type {any} */ c) => c.index));
  await shown(page, [cut[1], cut[0], 6]);
  await shot(page, "volume");
  await page.keyboard.press("PageDown");
  await shown(page, [cut[1], cut[0], 5]);
  assert.match((await page.textContent("output[for=slice]")) ?? "", /^0\.250 m$/);
  // The echoes of a place in a slice are those of its height.
  await page.mouse.click(...(await onScreen(page, "image", x[150], y[120])));
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.mark?.hyperbola);
  assert.ok(Math.abs((await page.evaluate(() => /** @type {any} */ (window).acerra.store.mark.hyperbola.place_m[2])) - 0.25) < 1e-9);
  await page.selectOption("#volume-shows", "strongest");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.image.slice.shown === null);
  assert.deepEqual(complaints, []);
  await close();
});

test("cuts fit a phone", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const boxes = await page.$$eval("#cuts .canvas-box", (list) => list.map((one) => one.getBoundingClientRect().toJSON()));
  assert.equal(boxes.length, 2);
  for (const box of boxes) assert.ok(box.width > 150 && box.height > 100 && box.right <= 390 && box.bottom <= 844, JSON.stringify(box));
  await shot(page, "volume-phone");
  assert.deepEqual(complaints, []);
  await close();
});

test("slices and cuts are accessible, dark and light, on a desk and on a phone", { skip }, () => everyLookIsAccessible(browser, server.address, "cuts-"));
