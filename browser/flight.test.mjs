// Along the flight: the slider that moves the platform, the satellites of the GNSS log, the layers of the image.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { seriousFaults } from "./access.mjs";
import { chromiumPath, demo, launch, open, serve, shot, tidy } from "./harness.mjs";
import { colourAt, near, zoomTo } from "./look.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";
/** Colour of the chosen pulse. */
const CHOSEN = [124, 242, 156];

/** @type {Awaited<ReturnType<typeof serve>>} */
let server;
/** @type {import("playwright-core").Browser} */
let browser;
/** @type {string[]} */
let runs;

before(async () => {
  if (skip) return;
  runs = demo();
  server = await serve(runs);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  server?.stop();
  tidy();
});

/** @param {import("playwright-core").Page} page @param {string} path */
const state = (page, path) => page.evaluate((p) => p.split(".").reduce((/** @type {any} */ o, key) => o?.[key], /** @type {any} */ (window).acerra.store), path);

/** Strengths (dB-Hz) by satellite, and GPS time (ms), of every epoch of a RINEX 2 log with the observations C1 L1 D1 S1. @param {string} file */
function epochsOf(file) {
  const lines = readFileSync(file, "utf8").split("\n");
  const epochs = [];
  for (let at = lines.findIndex((line) => line.includes("END OF HEADER")) + 1; at < lines.length && lines[at].trim(); ) {
    const [year, month, day, hour, minute, second] = lines[at].slice(0, 26).trim().split(/\s+/).map(Number);
    const names = lines[at].slice(32).trim().match(/[A-Z]\d\d/g) ?? [];
    assert.ok(names.length <= 12, "one line of satellites");
    const strengths = new Map(names.map((name, k) => [name, Number(lines[at + 1 + k].slice(48, 62))]));
    epochs.push({ ms: Date.UTC(2000 + year, month - 1, day, hour, minute) + 1000 * second, strengths });
    at += 1 + names.length;
  }
  return epochs;
}

test("the slider moves the platform on the map and its trace in the radargram, by keys as well", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const slider = page.getByRole("slider", { name: "Flight" });
  await slider.focus();
  await page.keyboard.press("End");
  const pulses = await state(page, "trackMeta.pulses");
  assert.equal(await state(page, "chosen"), pulses - 1);
  await page.keyboard.press("Home");
  await page.keyboard.press("ArrowRight");
  assert.equal(await state(page, "chosen"), 1);
  await page.$eval("#scrubber", (input) => {
    /** @type {HTMLInputElement} */ (input).value = "120";
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  const [x, y, z] = await state(page, "data.position_m.120");
  const [trace, time] = [await state(page, "data.trace.120"), await state(page, "data.time_s.120")];
  const told = (await page.textContent("#scrubber-at")) ?? "";
  assert.ok(told.startsWith(`trace ${trace}, ${time.toFixed(3)} s: x ${x.toFixed(2).replace("-", "−")}, `) && told.endsWith(`z ${z.toFixed(2)} m`), told);
  assert.equal(await slider.getAttribute("aria-valuetext"), told);
  near((await colourAt(page, "image", x, y, true)).slice(0, 3), CHOSEN, 12, "platform on the map");
  near((await colourAt(page, "radargram", 120, 40, true)).slice(0, 3), CHOSEN, 20, "trace in the radargram");
  await shot(page, "flight");
  // Outside the slider, two keys do the same; a trace beyond the view is brought into it.
  await page.focus("#image-box .surface");
  await page.keyboard.press(".");
  assert.equal(await state(page, "chosen"), 121);
  await page.keyboard.press(",");
  await page.keyboard.press(",");
  assert.equal(await state(page, "chosen"), 119);
  assert.equal(await slider.inputValue(), "119");
  await page.evaluate(() => Object.assign(/** @type {any} */ (window).acerra.radargram.pane.camera, { x: 10, kx: 30 }));
  await page.keyboard.press(".");
  assert.equal(await page.evaluate(() => /** @type {any} */ (window).acerra.radargram.pane.camera.x), 120);
  await page.keyboard.press("Escape");
  assert.equal(await page.textContent("#scrubber-at"), "");
  assert.deepEqual(complaints, []);
  await close();
});

test("satellites have the strengths of the log, at their directions in the plot", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address, { viewport: { width: 1280, height: 800 } });
  await page.click("#sky summary");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.sky.satellites.length > 0);
  await page.evaluate(() => /** @type {any} */ (window).acerra.store.choose(120));
  /** @type {{name: string, time_s: number[], direction_deg: ([number, number] | null)[], cn0_db_hz: (number | null)[][]}[]} */
  const satellites = await page.evaluate(() => /** @type {any} */ (window).acerra.sky.satellites);
  const epochs = epochsOf(join(runs[0], "../rover.obs"));
  assert.deepEqual(satellites.map(({ name }) => name), [...new Set(epochs.flatMap(({ strengths }) => [...strengths.keys()]))].sort());
  // The radar's clock is tied to GPS time by the table of the traces.
  const [head, ...rows] = readFileSync(join(runs[0], "trajectory.csv"), "utf8").trim().split("\n").map((line) => line.split(","));
  const trace = await state(page, "data.trace.120");
  const row = rows.find((cells) => Number(cells[head.indexOf("trace")]) === trace);
  assert.ok(row);
  const gpst = Date.parse(`${row[head.indexOf("gpst")].replaceAll("/", "-").replace(" ", "T")}Z`);
  const zero = gpst - 1000 * (await state(page, "data.time_s.120"));
  let compared = 0;
  for (const { name, time_s, cn0_db_hz, direction_deg } of satellites) {
    time_s.forEach((time, k) => {
      const epoch = epochs.find(({ ms }) => Math.abs(ms - (zero + 1000 * time)) < 60);
      assert.equal(cn0_db_hz[k][0], epoch?.strengths.get(name), `${name} at ${time} s`);
      assert.ok((direction_deg[k]?.[1] ?? -1) > 5, `${name} is above the horizon`);
      compared += 1;
    });
  }
  assert.ok(compared > 100, `${compared} samples`);
  // A point lies where its azimuth and elevation say.
  await page.waitForTimeout(100);
  const strongest = await page.evaluate(() => {
    const { sky } = /** @type {any} */ (window).acerra;
    const plot = /** @type {HTMLCanvasElement} */ (sky.plot);
    const [w, h] = [plot.clientWidth, plot.clientHeight];
    const at = (/** @type {any} */ one) => one.time_s.findIndex((/** @type {number} */ t) => Math.abs(t - sky.time) <= 0.5);
    const seen = sky.satellites.filter((/** @type {any} */ one) => at(one) >= 0);
    const best = seen.reduce((/** @type {any} */ a, /** @type {any} */ b) => (b.cn0_db_hz[at(b)][0] > a.cn0_db_hz[at(a)][0] ? b : a));
    const [azimuth, elevation] = best.direction_deg[at(best)];
    const [angle, radius] = [(azimuth * Math.PI) / 180, ((Math.min(w, h) / 2 - 18) * (90 - elevation)) / 90];
    const ratio = plot.width / w;
    const [x, y] = [w / 2 + radius * Math.sin(angle), h / 2 - radius * Math.cos(angle)].map((v) => Math.round(v * ratio));
    return { name: best.name, count: seen.length, colour: [...(plot.getContext("2d")?.getImageData(x, y, 1, 1).data ?? [])] };
  });
  near(strongest.colour.slice(0, 3), [61, 143, 217], 3, `point of ${strongest.name}`);
  assert.equal(await page.locator("#sky tbody tr").count(), strongest.count);
  assert.deepEqual(await seriousFaults(page), []);
  await page.locator("#sky").scrollIntoViewIfNeeded();
  await shot(page, "sky");
  assert.deepEqual(complaints, []);
  await close();
});

test("the layers of the image can be taken away one by one", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const target = await state(page, "meta.targets.targets.0");
  const platform = await state(page, "data.position_m.60");
  await zoomTo(page, target.x_m, target.y_m);
  const bright = await colourAt(page, "image", target.x_m, target.y_m);
  assert.ok(bright[0] + bright[1] > 200, `${bright}`);
  // The ring about a target, nine pixels of the screen to its right.
  const ring = async () => (await colourAt(page, "image", target.x_m + 9 / 1200, target.y_m, true))[3];
  assert.ok((await ring()) > 200);
  const layer = (/** @type {string} */ name) => page.locator("fieldset").getByLabel(name, { exact: true });
  await layer("targets").uncheck();
  assert.equal(await ring(), 0);
  await layer("image").uncheck();
  near(await colourAt(page, "image", target.x_m, target.y_m), [0, 0, 0, 255], 0, "no image");
  await layer("image").check();
  near(await colourAt(page, "image", target.x_m, target.y_m), bright, 0, "the image again");
  await zoomTo(page, platform[0], platform[1]);
  const track = async () => (await colourAt(page, "image", platform[0], platform[1], true))[3];
  assert.ok((await track()) > 200);
  await layer("track").uncheck();
  assert.equal(await track(), 0);
  // The run has no surveyed points: there is nothing to take away.
  assert.equal(await layer("surveyed points").count(), 0);
  assert.deepEqual(complaints, []);
  await close();
});
