// Latency of a live image in Chromium at 50 pulses/s and a million pixels, of the latest 500 pulses: those before them
// are caught up with when the imaging begins. Each figure on a line of its own.
// Fails where half of the pulses take 200 ms or more to the screen.

import { flyLive } from "./live-flight.mjs";
import { launch, tidy } from "./harness.mjs";

const browser = await launch();
// Fifty pulses and ten positions a second, the flight at its own pace.
const live = await flyLive("live-bench", { speed: 1, intervalS: 0.1, scanIntervalS: 0.02, groundTimeS: 5, more: ["--no-final"], live: "[live]\nmax_pixels = 1000000\n" });
const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
await page.goto(live.address);
await page.waitForFunction(() => /** @type {any} */ (window).acerra?.state?.status.pulses.imaged > 1250, null, { timeout: 180_000 });
const { status, grid } = await page.evaluate(() => /** @type {any} */ (window).acerra?.state);
const text = (/** @type {{median_ms: number, p95_ms: number, most_ms: number, pulses: number}} */ f) => `median ${f.median_ms.toFixed(0)} ms, 95 % within ${f.p95_ms.toFixed(0)} ms, most ${f.most_ms.toFixed(0)} ms, of ${f.pulses} pulses`;
console.log(`live ${grid.nx} × ${grid.ny}, 50 pulses/s: pulse to screen ${text(status.drawn)}`);
console.log(`live ${grid.nx} × ${grid.ny}, 50 pulses/s: pulse to picture ${text(status.latency)}`);
console.log(`live ${grid.nx} × ${grid.ny}, 50 pulses/s: of it until its imaging began ${text(status.waiting)}`);
console.log(`live: ${status.pulses.imaged} imaged, ${status.pulses.too_many} too many, ${status.pulses.missed_records} records missed`);
live.stop();
await live.end();
await browser.close();
tidy();
if (!(status.drawn.median_ms < 200)) process.exitCode = 1;
