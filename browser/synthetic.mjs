// A run of any size, made up: speckle with a few bright points, over a straight track.

import { closeSync, mkdirSync, openSync, writeFileSync, writeSync } from "node:fs";
import { join } from "node:path";
import zlib from "node:zlib";

/** @param {string} folder @param {number} side pixels along each axis */
export function writeRun(folder, side) {
  mkdirSync(folder, { recursive: true });
  const pixel = 0.01;
  const values = new Float32Array(2 * side * side);
  let state = 12345;
  for (let k = 0; k < values.length; k++) {
    state = (1664525 * state + 1013904223) >>> 0;
    values[k] = state / 2 ** 32 - 0.5;
  }
  for (let n = 1; n < 8; n++) values[2 * (Math.floor((side * n) / 8) * (side + 1))] = 1000;
  const axis = Float64Array.from({ length: side }, (_, k) => k * pixel);
  writeNpz(join(folder, "image.npz"), [
    ["image.npy", "<c8", [side, side], new Uint8Array(values.buffer)],
    ["x_m.npy", "<f8", [side], new Uint8Array(axis.buffer)],
    ["y_m.npy", "<f8", [side], new Uint8Array(axis.buffer)],
    ["z_m.npy", "<f8", [], new Uint8Array(new Float64Array(1).buffer)],
  ]);
  const image = { band_ghz: [3.1, 4.8], light_speed_m_s: 299792458, z_m: 0 };
  const record = { version: "0", configuration: { image, preprocess: {} }, frame: { kind: "local" }, inputs: [], evidence: [] };
  writeFileSync(join(folder, "run.json"), JSON.stringify(record));
  writeFileSync(join(folder, "targets.json"), '{"targets": []}');
  const lines = Array.from({ length: 200 }, (_, k) => `${k},${0.1 * k},${(k * side * pixel) / 200},${(side * pixel) / 2},20,fixed,ok`);
  writeFileSync(join(folder, "trajectory.csv"), `trace,time_s,x_m,y_m,z_m,status,flag\n${lines.join("\n")}\n`);
}

/** @param {string} path @param {[string, string, number[], Uint8Array][]} arrays */
function writeNpz(path, arrays) {
  const file = openSync(path, "w");
  let at = 0;
  const put = (/** @type {Uint8Array} */ bytes) => {
    for (let from = 0; from < bytes.length; ) from += writeSync(file, bytes, from, Math.min(bytes.length - from, 1 << 28));
    at += bytes.length;
  };
  const directory = [];
  for (const [name, kind, shape, body] of arrays) {
    const tuple = shape.length === 1 ? `(${shape[0]},)` : `(${shape.join(", ")})`;
    const text = `{'descr': '${kind}', 'fortran_order': False, 'shape': ${tuple}, }`;
    const padded = `${text.padEnd(64 * Math.ceil((text.length + 11) / 64) - 11)}\n`;
    const head = Buffer.concat([Buffer.from("\x93NUMPY\x01\x00", "latin1"), Buffer.from([padded.length & 255, padded.length >> 8]), Buffer.from(padded)]);
    const crc = /** @type {any} */ (zlib).crc32(body, /** @type {any} */ (zlib).crc32(head));
    const size = head.length + body.length;
    const fields = (/** @type {Buffer} */ b, /** @type {number} */ o) => {
      b.writeUInt16LE(20, o);
      b.writeUInt32LE(crc, o + 10);
      b.writeUInt32LE(size, o + 14);
      b.writeUInt32LE(size, o + 18);
      b.writeUInt16LE(name.length, o + 22);
    };
    const local = Buffer.alloc(30);
    local.write("PK\x03\x04", "latin1");
    fields(local, 4);
    const central = Buffer.alloc(46);
    central.write("PK\x01\x02", "latin1");
    fields(central, 6);
    central.writeUInt32LE(at, 42);
    directory.push(central, Buffer.from(name));
    for (const part of [local, Buffer.from(name), head, body]) put(part);
  }
  const list = Buffer.concat(directory);
  const end = Buffer.alloc(22);
  end.write("PK\x05\x06", "latin1");
  end.writeUInt16LE(arrays.length, 8);
  end.writeUInt16LE(arrays.length, 10);
  end.writeUInt32LE(list.length, 12);
  end.writeUInt32LE(at, 16);
  put(list);
  put(end);
  closeSync(file);
}
