// Times of the viewer in Chromium, rendered by the processor: first picture, panning, new images; and
// the memory of the server. Each figure is printed on a line of its own.

import { readFileSync, rmSync } from "node:fs";
import { join } from "node:path";
import { demo, folder, launch, serve, tidy } from "./harness.mjs";
import { writeRun } from "./synthetic.mjs";

/** @param {number[]} values */
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** @param {string} name @param {number} pid */
const memory = (name, pid) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(readFileSync(`/proc/${pid}/status`, "utf8"))?.[1]) / 1024;

const browser = await launch();
for (const side of [4000, 8000]) {
  const at = join(folder, `run-${side}`);
  writeRun(at, side);
  const server = await serve([at]);
  const first = [];
  for (let k = 0; k < 5; k++) {
    const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
    const start = performance.now();
    await page.goto(server.address, { waitUntil: "commit" });
    await page.waitForFunction(() => /** @type {any} */ (window).acerra?.image.own?.layer.complete, null, { polling: "raf" });
    first.push(performance.now() - start);
    if (k < 4) {
      await page.close();
      continue;
    }
    const frames = await page.evaluate(async () => {
      const { image } = /** @type {any} */ (window).acerra;
      const { camera, painter } = image.pane;
      const { grid } = image.own.meta;
      // A pixel of the image is one of the screen: the finest level, all of whose tiles are new.
      camera.kx = camera.ky = 1 / grid.pixel_m;
      const ends = [0.2, 0.8].map((share) => share * grid.nx * grid.pixel_m);
      const times = [];
      let complete = 0;
      const begin = performance.now();
      let last = begin;
      while (last - begin < 4000) {
        const share = (last - begin) / 4000;
        camera.x = ends[0] + share * (ends[1] - ends[0]);
        camera.y = camera.x;
        image.pane.draw();
        painter.gl.readPixels(0, 0, 1, 1, painter.gl.RGBA, painter.gl.UNSIGNED_BYTE, new Uint8Array(4));
        complete += image.own.layer.complete ? 1 : 0;
        await new Promise(requestAnimationFrame);
        const now = performance.now();
        times.push(now - last);
        last = now;
      }
      return { times, complete };
    });
    const seconds = frames.times.reduce((a, b) => a + b, 0) / 1000;
    const sorted = [...frames.times].sort((a, b) => a - b);
    console.log(`${side} × ${side}: panning ${(frames.times.length / seconds).toFixed(1)} frames/s, slowest twentieth ${sorted[Math.floor(0.95 * sorted.length)].toFixed(0)} ms, all tiles there in ${((100 * frames.complete) / frames.times.length).toFixed(0)} % of the frames`);
    await page.close();
  }
  const data = (8 * side * side) / 2 ** 20;
  const pid = /** @type {number} */ (server.pid);
  console.log(`${side} × ${side}: first picture ${median(first).toFixed(0)} ms (median of ${first.length})`);
  console.log(`${side} × ${side}: server ${memory("VmRSS", pid).toFixed(0)} MB, at most ${memory("VmHWM", pid).toFixed(0)} MB, for ${data.toFixed(0)} MB of image`);
  server.stop();
  rmSync(at, { recursive: true });
}

const server = await serve(demo().slice(0, 1));
const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
await page.goto(server.address);
await page.waitForFunction(() => document.documentElement.dataset.engine === "ready", null, { timeout: 120_000 });
const times = await page.evaluate(async () => {
  const { postImage } = await import(new URL("js/api.js", location.href).href);
  const view = { x0_m: 0, y0_m: -6.7, pixel_m: 0.0225, nx: 800, ny: 600 };
  /** @type {Record<string, number[]>} */
  const found = {};
  const one = async (/** @type {string} */ name, /** @type {object} */ edits, /** @type {number[] | null} */ pulses) => {
    const start = performance.now();
    const made = await postImage(0, { view, edits, pulses });
    (found[name] ??= []).push(performance.now() - start);
    (found[`${name}, imaging alone`] ??= []).push(made.imaging_ms);
  };
  for (let k = 0; k < 9; k++) {
    await one("all pulses", {}, null);
    await one("51 pulses", {}, [10 + k, 60 + k]);
    await one("gate", { gate_ns: [-6, 15 + k] }, null);
    await one("delay", { delay_change_ns: 0.01 * (k + 1) }, null);
    await one("height", { z_m: 0.01 * (k + 1) }, null);
    await one("speed of light", { light_speed_m_s: 2.9e8 + 1e5 * k }, null);
  }
  return found;
});
for (const [name, list] of Object.entries(times)) console.log(`800 × 600, ${name}: ${median(list).toFixed(0)} ms (least ${Math.min(...list).toFixed(0)})`);
server.stop();
await browser.close();
tidy();
