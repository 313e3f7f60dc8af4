// The viewer in Chromium: started once for all tests, stopped at their end.

import { spawn, spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

/** The program; `ACERRA` names it. */
export const acerra = process.env.ACERRA ?? "acerra";

/** Chromium, where there is one: `CHROMIUM` names it. */
export function chromiumPath() {
  const known = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
  return known.find((path) => path && existsSync(path)) ?? null;
}

/** Runs the program to its end. @param {string[]} args */
export function run(...args) {
  const done = spawnSync(acerra, args, { encoding: "utf8" });
  if (done.status !== 0) throw new Error(`acerra ${args.join(" ")}: ${done.stderr}`);
  return done.stdout;
}

/** A folder for this run of the tests. */
export const folder = mkdtempSync(join(tmpdir(), "acerra-browser-"));

/**
 * Runs of the demonstration's tracks, recorded from one end of the track to the other with the clock offset told:
 * made again, unless `ACERRA_DEMO` names a directory that holds them.
 */
export function demo() {
  const at = process.env.ACERRA_DEMO ?? join(folder, "demo");
  const tracks = ["track-1", "track-2"];
  if (!existsSync(join(at, "track-2/products/run.json"))) {
    const whole = join(folder, "from-take-off");
    run("demo", "-o", whole);
    for (const track of tracks) {
      const own = readFileSync(join(whole, track, "scene.toml"), "utf8");
      const scene = join(folder, `${track}.toml`);
      writeFileSync(scene, own.replace(/^record = .*$/m, 'record = "track"').replace(/^time_offset = .*$/m, 'time_offset = "exact"'));
      run("simulate", scene, "-o", join(at, track));
      run("focus", join(at, track, "campaign.toml"), "-o", join(at, track, "products"));
    }
    copyFileSync(join(whole, "index.html"), join(at, "index.html"));
  }
  return tracks.map((track) => join(at, track, "products"));
}

/**
 * The first track of the demonstration with another `[image]` section: the run's directory.
 * @param {string} name @param {string} image
 */
export function demoWith(name, image) {
  const logs = join(demo()[0], "..");
  const text = readFileSync(join(logs, "campaign.toml"), "utf8");
  const other = `${text.slice(0, text.indexOf("[image]"))}[image]\n${image}\n`;
  const named = other.replace(/"([\w-]+\.(?:mrm|obs|nav|ubx))"/g, (_, file) => JSON.stringify(join(logs, file)));
  const campaign = join(folder, `${name}.toml`);
  writeFileSync(campaign, named);
  run("focus", campaign, "-o", join(folder, name));
  return join(folder, name);
}

/** Serves runs. @param {string[]} directories @param {string[]} [more] */
export async function serve(directories, more = []) {
  const child = spawn(acerra, ["view", ...directories, "--no-open", ...more], { stdio: ["ignore", "pipe", "inherit"] });
  /** @type {string} */
  const address = await new Promise((done, failed) => {
    let text = "";
    child.stdout.on("data", (bytes) => {
      text += bytes;
      if (text.includes("\n")) done(text.trim());
    });
    child.on("exit", (code) => failed(new Error(`acerra view ended with ${code}`)));
  });
  return { address, pid: child.pid, stop: () => child.kill("SIGTERM") };
}

export function launch() {
  const executablePath = chromiumPath() ?? undefined;
  const args = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
  return chromium.launch({ executablePath, args });
}

/**
 * Opens the page and waits for the image, and for the logs.
 * @param {import("playwright-core").Browser} browser @param {string} address
 * @param {import("playwright-core").BrowserContextOptions} [options]
 */
export async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  /** @type {string[]} */
  const complaints = [];
  /** @type {string[]} */
  const hosts = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall") && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => !request.url().startsWith("blob:") && hosts.push(new URL(request.url()).origin));
  await page.goto(address);
  await page.waitForFunction(() => /** @type {any} */ (window).acerra?.image.own?.layer.complete);
  await page.waitForFunction(() => ["ready", "failed"].includes(document.documentElement.dataset.engine ?? ""), null, { timeout: 120_000 });
  await page.waitForFunction(() => {
    const { radargram } = /** @type {any} */ (window).acerra;
    return radargram.layer?.complete || !radargram.pane.box.clientWidth;
  });
  return { page, complaints, hosts, close: () => context.close() };
}

/** A picture for whoever looks at the artefacts; `ACERRA_SHOTS` names their folder. @param {import("playwright-core").Page} page @param {string} name */
export async function shot(page, name) {
  const at = process.env.ACERRA_SHOTS;
  if (!at) return;
  mkdirSync(at, { recursive: true });
  await page.screenshot({ path: join(at, `${name}.png`) });
}

export function tidy() {
  rmSync(folder, { recursive: true, force: true });
}
