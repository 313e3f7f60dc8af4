// What the viewer shows, asserted on the demonstration's runs.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { everyLookIsAccessible } from "./access.mjs";
import { chromiumPath, demo, launch, open, serve, shot, tidy } from "./harness.mjs";
import { colourAt, near, onScreen, readout, zoomTo } from "./look.mjs";
import { readNpz } from "./npz.mjs";

const C = 299792458;
const skip = chromiumPath() ? false : "no Chromium is installed here";

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

/** The image of run `k` as its file holds it. @param {number} k */
function imageOf(k) {
  const arrays = readNpz(join(runs[k], "image.npz"));
  const take = (/** @type {string} */ name) => /** @type {import("./npz.mjs").Named} */ (arrays.get(name));
  const { shape, values } = take("image");
  const [x, y] = [take("x_m").values, take("y_m").values];
  let greatest = 0;
  for (let n = 0; n < values.length; n += 2) greatest = Math.max(greatest, Math.hypot(values[n], values[n + 1]));
  const at = (/** @type {number} */ i, /** @type {number} */ j) => [values[2 * (j * shape[1] + i)], values[2 * (j * shape[1] + i) + 1]];
  const level = (/** @type {number} */ i, /** @type {number} */ j) => 20 * Math.log10(Math.hypot(...at(i, j)) / greatest);
  return { nx: shape[1], ny: shape[0], x, y, at, level };
}

/** @param {number} k */
const json = (k, /** @type {string} */ name) => JSON.parse(readFileSync(join(runs[k], name), "utf8"));

/** Positions of run `k`. @param {number} k @returns {number[][]} */
function positions(k) {
  const [head, ...lines] = readFileSync(join(runs[k], "trajectory.csv"), "utf8").trim().split("\n");
  const columns = ["x_m", "y_m", "z_m"].map((name) => head.split(",").indexOf(name));
  return lines.map((line) => columns.map((c) => Number(line.split(",")[c])));
}

test("the image shows the values of image.npz, in the colours of the palette, and the cursor tells them", { skip }, async () => {
  const { page, complaints, hosts, close } = await open(browser, server.address);
  await shot(page, "desktop");
  const image = imageOf(0);
  const table = await page.evaluate(async () => [...new Uint8Array(await (await fetch("api/palette/inferno")).arrayBuffer())]);
  const [floor, top] = await page.evaluate(() => /** @type {any} */ (window).acerra.store.look.window);
  for (const [i, j] of [[401, 890], [1000, 900], [1398, 885], [700, 1200]]) {
    const [x, y] = [image.x[i], image.y[j]];
    await zoomTo(page, x, y);
    const share = Math.min(Math.max((image.level(i, j) - floor) / (top - floor), 0), 1);
    const found = await colourAt(page, "image", x, y);
    const index = Math.round(255 * share);
    near(found.slice(0, 3), table.slice(4 * index, 4 * index + 3), 8, `colour at pixel ${i}, ${j}`);
    await page.mouse.move(...(await onScreen(page, "image", x, y)));
    await page.waitForFunction(([a, b]) => {
      const { cursor } = /** @type {any} */ (window).acerra.image;
      return cursor && cursor.pixel?.[0] === a && cursor.pixel?.[1] === b;
    }, [i, j]);
    const told = await readout(page, "image-readout");
    const [re, im] = image.at(i, j);
    assert.ok(Math.abs(told.x - x) < 2e-3 && Math.abs(told.y - y) < 2e-3, JSON.stringify(told));
    assert.ok(Math.abs(told.level - image.level(i, j)) < 0.006, `${told.level} dB, ${image.level(i, j)}`);
    assert.ok(Math.abs(told.phase - (Math.atan2(im, re) * 180) / Math.PI) < 0.06, `${told.phase}`);
    const ranges = positions(0).map(([px, py, pz]) => Math.hypot(px - told.x, py - told.y, pz));
    assert.ok(Math.abs(told.range - Math.min(...ranges)) < 2e-3);
    const across = Math.acos(positions(0)[ranges.indexOf(Math.min(...ranges))][2] / Math.min(...ranges));
    assert.ok(Math.abs(told.incidence - (across * 180) / Math.PI) < 0.1);
  }
  const target = json(0, "targets.json").targets[0];
  await page.evaluate(([x, y]) => /** @type {any} */ (window).acerra.image.ask(x, y), [target.x_m, target.y_m]);
  await page.waitForFunction((x) => Math.abs(/** @type {any} */ (window).acerra.image.cursor.place_m[0] - x) < 1e-9, target.x_m);
  const told = await readout(page, "image-readout");
  assert.ok(Math.abs(told.latitude - target.place_deg_m[0]) < 2e-8 && Math.abs(told.longitude - target.place_deg_m[1]) < 2e-8);
  assert.deepEqual([...new Set(hosts)], [new URL(server.address).origin], "nothing is loaded from elsewhere");
  assert.deepEqual(complaints, []);
  await close();
});

test("phase is shown by a circle of hues", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  const image = imageOf(0);
  await page.keyboard.press("p");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.look.mode === "phase");
  await zoomTo(page, image.x[401], image.y[890]);
  await page.waitForTimeout(200);
  const pixels = [[401, 890], [403, 891], [398, 889]];
  /** @type {number[][]} */
  const found = [];
  for (const [i, j] of pixels) found.push(await colourAt(page, "image", image.x[i], image.y[j]));
  const table = await page.evaluate(async () => {
    const { palette } = await import(new URL("js/palettes.js", location.href).href);
    return [...(await palette("phase"))];
  });
  pixels.forEach(([i, j], k) => {
    const [re, im] = image.at(i, j);
    const index = Math.round((Math.atan2(im, re) / (2 * Math.PI) + 0.5) * 255);
    near(found[k].slice(0, 3), table.slice(4 * index, 4 * index + 3), 8, `phase at ${i}, ${j}`);
  });
  await close();
});

test("a click on a pixel draws its hyperbola, whose apex lies on the echo", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  const target = json(0, "targets.json").targets[0];
  await page.mouse.click(...(await onScreen(page, "image", target.x_m, target.y_m)));
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.mark?.hyperbola);
  const { mark, step } = await page.evaluate(() => {
    const { store } = /** @type {any} */ (window).acerra;
    return { mark: store.mark, step: store.trackMeta.radargram.fast_time_step_ns };
  });
  const expected = positions(0).map(([x, y, z]) => (2e9 * Math.hypot(x - mark.x, y - mark.y, z)) / C);
  const apex = expected.indexOf(Math.min(...expected));
  assert.ok(Math.abs(mark.hyperbola.apex - apex) <= 1, `${mark.hyperbola.apex}, ${apex}`);
  mark.hyperbola.incidence_deg.forEach((/** @type {number} */ deg, /** @type {number} */ k) => {
    const [px, py, pz] = positions(0)[k];
    assert.ok(Math.abs(deg - (Math.atan2(Math.hypot(px - mark.x, py - mark.y), pz) * 180) / Math.PI) < 0.02, `pulse ${k}`);
  });
  mark.hyperbola.fast_time_ns.forEach((/** @type {number} */ t, /** @type {number} */ k) => assert.ok(Math.abs(t - expected[k]) < step, `pulse ${k}`));
  // It is drawn there, and the strongest sample about it is part of the wavelet at the apex.
  const [r, g, b] = await colourAt(page, "radargram", mark.hyperbola.apex, mark.hyperbola.fast_time_ns[mark.hyperbola.apex], true);
  near([r, g, b], [255, 225, 77], 12, "colour of the apex");
  // Under the pointer on the radargram, the pulse's time and angle of the mark.
  for (const pulse of [30, 97, 160]) {
    await page.mouse.move(...(await onScreen(page, "radargram", pulse, 30)));
    const told = await readout(page, "radargram-readout");
    assert.ok(Math.abs(told["echo of the mark"] - mark.hyperbola.fast_time_ns[pulse]) < 1e-3, JSON.stringify(told));
    assert.ok(Math.abs(told["its incidence"] - mark.hyperbola.incidence_deg[pulse]) < 0.06, JSON.stringify(told));
  }
  await shot(page, "hyperbola");
  await close();
});

test("range and incidence under the cursor are those of the pulse chosen, as the engine has them", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const [x, y] = [8, 2.5];
  const engine = await page.evaluate(async ([wx, wy]) => (await fetch(`api/run/0/hyperbola?x_m=${wx}&y_m=${wy}`)).json(), [x, y]);
  const range = (/** @type {number} */ pulse) => (engine.fast_time_ns[pulse] * 1e-9 * C) / 2;
  const pointed = async () => {
    await page.evaluate(([wx, wy]) => /** @type {any} */ (window).acerra.image.ask(wx, wy), [x, y]);
    await page.waitForFunction((wx) => {
      const { image } = /** @type {any} */ (window).acerra;
      return !image.asking.busy && image.cursor?.place_m[0] === wx;
    }, x);
    return readout(page, "image-readout");
  };
  // None is chosen: the nearest.
  const nearest = await pointed();
  assert.ok(Math.abs(nearest.range - Math.min(...engine.fast_time_ns.map((/** @type {any} */ _, /** @type {number} */ k) => range(k)))) < 2e-3, JSON.stringify(nearest));
  const traces = await page.evaluate(() => /** @type {any} */ (window).acerra.store.data.trace);
  const check = (/** @type {Record<string, number>} */ told, /** @type {number} */ pulse) => {
    assert.equal(told["chosen trace"], traces[pulse]);
    assert.ok(Math.abs(told.range - range(pulse)) < 6e-4, `${told.range}, ${range(pulse)}`);
    assert.ok(Math.abs(told.incidence - engine.incidence_deg[pulse]) < 0.06, `${told.incidence}, ${engine.incidence_deg[pulse]}`);
    assert.ok(told.phase >= -180 && told.phase <= 180);
  };
  // By a click on the radargram; the readout follows without a move.
  await page.mouse.click(...(await onScreen(page, "radargram", 60, 33)));
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.chosen === 60);
  await page.waitForFunction((trace) => document.querySelector("#image-readout [data-value='chosen trace']")?.textContent === `${trace}`, traces[60]);
  check(await readout(page, "image-readout"), 60);
  // By a click on the strip of the track.
  const strip = await page.locator("#track-strip canvas").boundingBox();
  assert.ok(strip);
  await page.mouse.click(strip.x + 0.8 * strip.width, strip.y + 50);
  const chosen = await page.evaluate(() => /** @type {any} */ (window).acerra.store.chosen);
  assert.ok(Math.abs(chosen - 0.8 * traces.length) <= 1, `${chosen}`);
  check(await pointed(), chosen);
  assert.equal(await page.evaluate(() => /** @type {any} */ (window).acerra.store.selection), null);
  await page.keyboard.press("Escape");
  assert.ok("nearest trace" in (await pointed()));
  assert.deepEqual(complaints, []);
  await close();
});

test("a click on an echo draws its range ring on the image", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  const [pulse, time] = [60, 33];
  await page.mouse.click(...(await onScreen(page, "radargram", pulse, time)));
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.echo);
  const { echo, clicked } = await page.evaluate(() => {
    const { store, radargram } = /** @type {any} */ (window).acerra;
    return { echo: store.echo, clicked: radargram.echoTime };
  });
  assert.equal(echo.pulse, pulse);
  const position = positions(0)[pulse];
  for (const place of echo.places_m) {
    const range = Math.hypot(...place.map((/** @type {number} */ v, /** @type {number} */ i) => v - position[i]));
    assert.ok(Math.abs(range - (C * clicked * 1e-9) / 2) < 1e-3, `${range}`);
  }
  const place = echo.places_m[90];
  near((await colourAt(page, "image", place[0], place[1], true)).slice(0, 3), [124, 242, 156], 14, "colour of the ring");
  const told = await readout(page, "radargram-readout");
  assert.ok(Math.abs(told["fast time"] - clicked) < 1e-3 && Math.abs(told.range - (C * clicked * 1e-9) / 2) < 1e-3);
  assert.equal(told.trace, pulse);
  await shot(page, "ring");
  await close();
});

test("a piece of the radargram, or of the track, makes an image of its pulses alone", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  await page.keyboard.press("s");
  await page.mouse.move(...(await onScreen(page, "radargram", 20, 35)));
  await page.mouse.down();
  await page.mouse.move(...(await onScreen(page, "radargram", 30, 36)), { steps: 4 });
  await page.mouse.move(...(await onScreen(page, "radargram", 45, 36)), { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.image.live?.made.pulses === 26 && !/** @type {any} */ (window).acerra.image.imaging.busy);
  assert.deepEqual(await page.evaluate(() => /** @type {any} */ (window).acerra.store.selection), [20, 45]);
  // What is shown is the engine's answer, and with the other pulses' images it makes that of all.
  const off = await page.evaluate(async () => {
    const { image, store } = /** @type {any} */ (window).acerra;
    const { postImage } = await import(new URL("js/api.js", location.href).href);
    const view = image.view();
    const of = async (/** @type {number[] | null} */ pulses) => (await postImage(0, { view, edits: {}, pulses })).values;
    const last = store.data.trace.length - 1;
    const [before, own, behind, all] = [await of([0, 19]), await of([20, 45]), await of([46, last]), await of(null)];
    let [power, rest, shown] = [0, 0, 0];
    for (let k = 0; k < all.length; k++) {
      power += all[k] ** 2;
      rest += (before[k] + own[k] + behind[k] - all[k]) ** 2;
      shown += (own[k] - image.live.layer.values[k]) ** 2;
    }
    return { sum: Math.sqrt(rest / power), shown: Math.sqrt(shown / power) };
  });
  assert.ok(off.sum < 2e-3, `parts against the whole: ${off.sum}`);
  assert.ok(off.shown < 1e-6, `shown against the engine: ${off.shown}`);
  await shot(page, "selection");
  // By the track: a drag over the strip below.
  const strip = await page.locator("#track-strip canvas").boundingBox();
  assert.ok(strip);
  await page.mouse.move(strip.x + 0.5 * strip.width, strip.y + 50);
  assert.ok(Math.abs((await page.evaluate(() => /** @type {any} */ (window).acerra.store.pulse)) - 125) <= 1);
  await page.mouse.down();
  await page.mouse.move(strip.x + 0.75 * strip.width, strip.y + 50, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction(() => Math.abs((/** @type {any} */ (window).acerra.image.live?.made.pulses ?? 0) - 63) <= 2);
  // The table of the selection.
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#export-csv")]);
  const lines = readFileSync(await download.path(), "utf8").trim().split("\n");
  assert.match(lines[0], /^pulse,trace,time_s,x_m,y_m,z_m/);
  assert.ok(Math.abs(lines.length - 1 - 63) <= 2);
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => !/** @type {any} */ (window).acerra.image.live);
  assert.deepEqual(complaints, []);
  await close();
});

test("the coherence of two looks is shown from 0 to 1", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  await page.selectOption("#mode", "coherence");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.image.live?.coherence);
  const target = json(0, "targets.json").targets[0];
  const { at, all } = await page.evaluate(([x, y]) => {
    const { layer } = /** @type {any} */ (window).acerra.image.live;
    /** @type {number[]} */
    const moduli = [];
    for (let k = 0; k < layer.values.length; k += 2) moduli.push(Math.hypot(layer.values[k], layer.values[k + 1]));
    return { at: Math.hypot(...layer.value(x, y)), all: moduli };
  }, [target.x_m, target.y_m]);
  assert.ok(all.every((v) => v >= 0 && v <= 1.00001));
  assert.ok(all.some((v) => v > 0.5) && all.some((v) => v < 0.2));
  const table = await page.evaluate(async () => [...new Uint8Array(await (await fetch("api/palette/inferno")).arrayBuffer())]);
  const index = Math.round(255 * Math.min(at, 1));
  near((await colourAt(page, "image", target.x_m, target.y_m)).slice(0, 3), table.slice(4 * index, 4 * index + 3), 8, "coherence");
  await shot(page, "coherence");
  await page.keyboard.press("p");
  await page.waitForFunction(() => !/** @type {any} */ (window).acerra.image.live);
  assert.deepEqual(complaints, []);
  await close();
});

test("the radargram has a scale of range, and a gain that grows with fast time", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.radargram.layer?.complete);
  const axis = await page.evaluate(() => {
    const { radargram } = /** @type {any} */ (window).acerra;
    const { name, numbers } = radargram.rangeAxis();
    return { name, at: numbers.value(20), back: numbers.place(numbers.value(20)) };
  });
  assert.equal(axis.name, "range / m");
  near([axis.at, axis.back], [2.99792458, 20], 1e-9, "range after 20 ns");
  const brightness = async () => (await colourAt(page, "radargram", 60, 34)).slice(0, 3).reduce((a, b) => a + b);
  const before = await brightness();
  await page.evaluate(() => {
    const { store } = /** @type {any} */ (window).acerra;
    store.look.radargramGain = 60;
    store.tell("look");
  });
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.radargram.gainTexture() !== null);
  const after = await brightness();
  assert.ok(after > before, `late samples are brighter: ${before}, ${after}`);
  assert.deepEqual(complaints, []);
  await close();
});

test("the gate shown is the one in force, and the radargram's axis counts as its readout does", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const gateOf = () => page.evaluate(() => /** @type {any} */ (window).acerra.store.data.tracks[0].radargram.gate_ns);
  const inForce = await gateOf();
  const sliders = await page.$$eval("#gate-from, #gate-to", (all) => all.map((one) => Number(/** @type {HTMLInputElement} */ (one).value)));
  inForce.forEach((/** @type {number} */ ns, /** @type {number} */ k) => assert.ok(Math.abs(ns - sliders[k]) <= 0.25, `${inForce} ${sliders}`));
  const toggle = page.getByLabel("Gate about 2h/c", { exact: true });
  assert.equal(await toggle.isChecked(), true);
  await toggle.uncheck();
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.data.tracks[0].radargram.gate_ns === null);
  assert.equal(await page.locator("#gate-from").isDisabled(), true);
  await toggle.check();
  await page.waitForFunction((wanted) => /** @type {any} */ (window).acerra.store.data.tracks[0].radargram.gate_ns?.[1].toFixed(3) === wanted, inForce[1].toFixed(3));
  const numbers = await page.evaluate(() => {
    const { radargram, store } = /** @type {any} */ (window).acerra;
    const count = radargram.traceNumbers(store.trackMeta, store.data.trace);
    return [0, 7, 120].map((k) => [count.value(k), store.data.trace[store.trackMeta.first_pulse + k], count.place(count.value(k)), k]);
  });
  for (const [told, trace, place, column] of numbers) assert.deepEqual([told, place], [trace, column]);
  assert.ok((await page.locator(".legend .ticks span").count()) >= 3);
  assert.deepEqual(complaints, []);
  await close();
});

test("settings change the image in view, the radargram and the campaign file", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const set = (/** @type {string} */ id, /** @type {number} */ value) =>
    page.$eval(`#${id}`, (input, v) => {
      /** @type {HTMLInputElement} */ (input).value = String(v);
      input.dispatchEvent(new Event("input", { bubbles: true }));
    }, value);
  await set("height", 0.25);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.image.live?.made.revision >= 1 && /** @type {any} */ (window).acerra.store.data.settings.image.z_m === 0.25);
  await set("gate-to", 12);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.data.tracks[0].radargram.gate_ns[1].toFixed(6) === "12.000000");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.radargram.layer?.complete);
  // What the gate no longer lets through is black in the radargram.
  assert.deepEqual((await colourAt(page, "radargram", 60, 45)).slice(0, 3), [0, 0, 4]);
  await set("delay", 0.1);
  await set("clock", 0.01);
  await set("speed", 290000000);
  await page.selectOption("#background", "median");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.data.settings.preprocess.background === "median");
  await shot(page, "settings");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-campaign")]);
  const text = readFileSync(await download.path(), "utf8");
  for (const line of [/^z_m = 0.25$/m, /^light_speed_m_s = 290000000.0$/m, /^background = "median"$/m, /^gate_ns = \[\s*-6.0,\s*12.0,?\s*\]$/m, /^delay_ns = \d/m]) assert.match(text, line);
  await page.click("#reset");
  await page.waitForFunction(() => !/** @type {any} */ (window).acerra.image.live && /** @type {any} */ (window).acerra.store.data.revision === 0);
  assert.equal((await page.evaluate(() => /** @type {any} */ (window).acerra.store.data.tracks[0].radargram.gate_ns[1])).toFixed(6), "24.000000");
  assert.deepEqual(complaints, []);
  await close();
});

test("two runs are compared by swipe, blink and difference", { skip }, async () => {
  const { page, complaints, close } = await open(browser, server.address);
  const [one, other] = [imageOf(0), imageOf(1)];
  const table = await page.evaluate(async () => [...new Uint8Array(await (await fetch("api/palette/inferno")).arrayBuffer())]);
  const [floor, top] = await page.evaluate(() => /** @type {any} */ (window).acerra.store.look.window);
  const expected = (/** @type {number} */ level) => {
    const index = Math.round(255 * Math.min(Math.max((level - floor) / (top - floor), 0), 1));
    return table.slice(4 * index, 4 * index + 3);
  };
  await page.evaluate(() => (/** @type {HTMLDetailsElement} */ (document.querySelector("#compare")?.closest("details")).open = true));
  await page.selectOption("#compare", "swipe");
  const [i, j] = [900, 890];
  await zoomTo(page, one.x[i], one.y[j]);
  await page.waitForFunction(() => {
    const { image } = /** @type {any} */ (window).acerra;
    image.pane.draw();
    return image.other?.layer.complete;
  });
  near((await colourAt(page, "image", one.x[i - 20], one.y[j])).slice(0, 3), expected(one.level(i - 20, j)), 8, "left of the line");
  near((await colourAt(page, "image", one.x[i + 20], one.y[j])).slice(0, 3), expected(other.level(i + 20, j)), 8, "right of the line");
  await shot(page, "swipe");
  await page.selectOption("#compare", "difference");
  const blueRed = await page.evaluate(async () => [...new Uint8Array(await (await fetch("api/palette/bluered")).arrayBuffer())]);
  await page.waitForTimeout(400);
  const span = -floor / 2;
  const share = 0.5 + 0.5 * Math.min(Math.max((one.level(i, j) - other.level(i, j)) / span, -1), 1);
  const index = Math.round(255 * share);
  near((await colourAt(page, "image", one.x[i], one.y[j])).slice(0, 3), blueRed.slice(4 * index, 4 * index + 3), 10, "difference");
  await shot(page, "difference");
  await page.selectOption("#compare", "blink");
  await page.waitForTimeout(200);
  assert.deepEqual(complaints, []);
  await close();
});

test("distances are measured, views are saved, keys do what the pointer does", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  await page.keyboard.press("m");
  const [a, b] = [await onScreen(page, "image", 4, -2), await onScreen(page, "image", 7, 2)];
  await page.mouse.move(...a);
  await page.mouse.down();
  await page.mouse.move(...b, { steps: 3 });
  await page.mouse.up();
  const [from, to] = await page.evaluate(() => /** @type {any} */ (window).acerra.image.measured);
  assert.ok(Math.abs(Math.hypot(to[0] - from[0], to[1] - from[1]) - 5) < 0.03);
  await page.keyboard.press("m");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#export-png")]);
  const bytes = readFileSync(await download.path());
  assert.equal(bytes.toString("latin1", 1, 4), "PNG");
  assert.ok(bytes.length > 50_000, `${bytes.length} bytes`);
  const camera = () => page.evaluate(() => ({ ...(/** @type {any} */ (window).acerra.image.pane.camera) }));
  await page.focus("#image-box .surface");
  const start = await camera();
  for (const key of ["+", "ArrowRight", "ArrowUp"]) await page.keyboard.press(key);
  const moved = await camera();
  assert.ok(moved.kx > start.kx && moved.x > start.x && moved.y > start.y);
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.mark?.hyperbola);
  await page.keyboard.press("0");
  assert.ok(Math.abs((await camera()).kx - start.kx) < 1e-9);
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  const before = await theme();
  await page.keyboard.press("d");
  assert.notEqual(await theme(), before);
  await close();
});

test("evidence and targets are those of the run", { skip }, async () => {
  const { page, close } = await open(browser, server.address);
  const record = json(0, "run.json");
  const shown = await page.$$eval(".findings b", (list) => list.map((one) => one.textContent));
  for (const { name } of record.evidence) assert.ok(shown.includes(name), name);
  for (const { setting } of record.unchecked) assert.ok(shown.includes(setting), setting);
  const rows = page.locator("tbody tr.pick");
  assert.equal(await rows.count(), json(0, "targets.json").targets.length);
  await rows.nth(1).click();
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.mark?.hyperbola);
  const mark = await page.evaluate(() => /** @type {any} */ (window).acerra.store.mark);
  const target = json(0, "targets.json").targets[1];
  assert.equal(mark.x, target.x_m);
  // Its widths beside those of a point that shines alike in all directions: Eqs. (6) and (9) of the paper.
  await page.waitForFunction(() => document.querySelector("#target-spread")?.textContent?.includes("by this flight"));
  const widths = [...(await page.textContent("#target-spread") ?? "").matchAll(/([0-9.]+) cm/g)].map((m) => Number(m[1]));
  assert.ok(Math.abs(widths[0] - 100 * target.along.rayleigh_m) < 0.06, `${widths}`);
  const seen = positions(0).map((p) => ({ along: p[0] - target.x_m, range: Math.hypot(p[0] - target.x_m, p[1] - target.y_m, p[2]) }));
  const sines = seen.map(({ along, range }) => along / range);
  const along = C / (2 * 3.95e9) / (Math.max(...sines) - Math.min(...sines));
  // Eq. (6) weights all pulses alike; 1/R² widens the lobe by up to a third.
  assert.ok(widths[2] > 99 * along && widths[2] < 133 * along, `${widths}, Eq. (6): ${100 * along} cm`);
  const cell = C / (2 * 1.7e9);
  const across = Math.sqrt(cell ** 2 + 2 * cell * Math.min(...seen.map(({ range }) => range)));
  assert.ok(Math.abs(widths[3] / (100 * across) - 1) < 0.2, `${widths}, Eq. (9): ${100 * across} cm`);
  await close();
});

test("the page is accessible, dark and light, on a desk and on a phone", { skip }, () => everyLookIsAccessible(browser, server.address, ""));

test("touch moves, pinches and marks", { skip }, async () => {
  const { page, close } = await open(browser, server.address, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const session = await page.context().newCDPSession(page);
  const box = await page.locator("#image-box .surface").boundingBox();
  assert.ok(box);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const touch = (/** @type {"touchStart" | "touchMove" | "touchEnd"} */ type, /** @type {number[][]} */ points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
  const camera = () => page.evaluate(() => ({ ...(/** @type {any} */ (window).acerra.image.pane.camera) }));
  const start = await camera();
  await touch("touchStart", [[x - 40, y], [x + 40, y]]);
  await touch("touchMove", [[x - 80, y], [x + 80, y]]);
  await touch("touchEnd", []);
  const zoomed = await camera();
  assert.ok(Math.abs(zoomed.kx / start.kx - 2) < 0.1, `${zoomed.kx / start.kx}`);
  await touch("touchStart", [[x, y]]);
  await touch("touchMove", [[x + 60, y]]);
  await touch("touchEnd", []);
  assert.ok(Math.abs((zoomed.x - (await camera()).x) * zoomed.kx - 60) < 2);
  await page.touchscreen.tap(x, y);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra.store.mark?.hyperbola);
  await close();
});
