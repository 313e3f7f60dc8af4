// The demonstration's second track flown by emulated instruments and imaged live.

import { spawn } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { createSocket } from "node:dgram";
import { join } from "node:path";
import { acerra, demo, folder } from "./harness.mjs";

/** Ports that were free a moment ago: the radio's and the receiver's. @returns {Promise<number[]>} */
async function freePorts() {
  const udp = createSocket("udp4");
  const tcp = createServer();
  await new Promise((done) => udp.bind(0, "127.0.0.1", () => done(null)));
  await new Promise((done) => tcp.listen(0, "127.0.0.1", () => done(null)));
  const ports = [udp.address().port, /** @type {import("node:net").AddressInfo} */ (tcp.address()).port];
  await new Promise((done) => udp.close(() => done(null)));
  await new Promise((done) => tcp.close(() => done(null)));
  return ports;
}

/** What a child says until a line satisfies. @param {import("node:child_process").ChildProcess} child @param {(text: string) => boolean} enough @returns {Promise<string>} */
function said(child, enough) {
  return new Promise((done, failed) => {
    let text = "";
    child.stdout?.on("data", (bytes) => {
      text += bytes;
      if (enough(text)) done(text);
    });
    child.on("exit", (code) => failed(new Error(`ended with ${code}: ${text}`)));
  });
}

/**
 * @param {string} name
 * @param {{speed: number, solutions?: string, more?: string[], intervalS?: number, scanIntervalS?: number, groundTimeS?: number, live?: string}} options
 */
export async function flyLive(name, options) {
  const at = join(folder, name);
  mkdirSync(at, { recursive: true });
  const own = readFileSync(join(demo()[1], "../scene.toml"), "utf8");
  // From take-off to landing, with less time on the ground and positions twice as often.
  const scene = `record = "flight"\n${own.replace(/^record = .*$/m, "")}`
    .replace(/^scan_interval_s = .*$/m, (line) => (options.scanIntervalS ? `scan_interval_s = ${options.scanIntervalS}` : line))
    .replace(/ground_time_s = [\d.]+/, `ground_time_s = ${options.groundTimeS ?? 20}`)
    .replace(/(\[gnss\.rover\]\n(?:[^[]*\n)?)interval_s = [\d.]+/, `$1interval_s = ${options.intervalS ?? 0.1}`);
  writeFileSync(join(at, "scene.toml"), scene);
  const [radio, receiver] = await freePorts();
  const emulator = spawn(acerra, ["emulate", join(at, "scene.toml"), "-o", join(at, "ground"), "--solutions", options.solutions ?? "fixed", "--speed", String(options.speed), "--radio", `127.0.0.1:${radio}`, "--receiver", `127.0.0.1:${receiver}`], { stdio: ["ignore", "pipe", "inherit"] });
  const session = await said(emulator, (text) => /origin_deg_m = .*\n/.test(text));
  writeFileSync(join(at, "session.toml"), `${session}\n${options.live ?? ""}`);
  const directory = join(at, "flight");
  const child = spawn(acerra, ["live", join(at, "session.toml"), "-o", directory, "--no-open", ...(options.more ?? [])], { stdio: ["ignore", "pipe", process.env.ACERRA_TOLD ? "inherit" : "ignore"] });
  const address = (await said(child, (text) => text.includes("\n"))).split("\n")[0];
  const over = new Promise((done) => emulator.on("exit", () => done(null)));
  return {
    address,
    directory,
    pid: /** @type {number} */ (child.pid),
    /** When everything is sent. */
    flown: () => over,
    /** Ends the recording. */
    stop: () => child.kill("SIGINT"),
    end: async () => {
      emulator.kill("SIGKILL");
      child.kill("SIGKILL");
      await new Promise((done) => (child.exitCode !== null || child.signalCode ? done(null) : child.on("exit", () => done(null))));
    },
  };
}
