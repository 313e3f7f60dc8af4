// Reads the arrays of `image.npz`: an archive of uncompressed NPY members.

import { readFileSync } from "node:fs";

/** @typedef {{shape: number[], values: Float32Array | Float64Array}} Named */

/** @param {string} path @returns {Map<string, Named>} */
export function readNpz(path) {
  const file = readFileSync(path);
  const end = file.lastIndexOf(Buffer.from("PK\x05\x06", "latin1"));
  const count = file.readUInt16LE(end + 10);
  let at = file.readUInt32LE(end + 16);
  const arrays = new Map();
  for (let k = 0; k < count; k++) {
    const [nameLength, extra, comment] = [28, 30, 32].map((o) => file.readUInt16LE(at + o));
    const name = file.toString("latin1", at + 46, at + 46 + nameLength);
    const local = file.readUInt32LE(at + 42);
    const start = local + 30 + file.readUInt16LE(local + 26) + file.readUInt16LE(local + 28);
    arrays.set(name.replace(/\.npy$/, ""), readNpy(file, start));
    at += 46 + nameLength + extra + comment;
  }
  return arrays;
}

/** @param {Buffer} file @param {number} start @returns {Named} */
function readNpy(file, start) {
  const wide = file[start + 6] > 1;
  const length = wide ? file.readUInt32LE(start + 8) : file.readUInt16LE(start + 8);
  const head = start + (wide ? 12 : 10);
  const text = file.toString("latin1", head, head + length);
  const shape = (/'shape': \(([^)]*)\)/.exec(text)?.[1] ?? "").split(",").map((s) => s.trim()).filter(Boolean).map(Number);
  const items = shape.reduce((a, b) => a * b, 1);
  const body = file.buffer.slice(file.byteOffset + head + length);
  const kind = /'descr': '([^']*)'/.exec(text)?.[1];
  if (kind === "<c8") return { shape, values: new Float32Array(body, 0, 2 * items) };
  if (kind === "<f8") return { shape, values: new Float64Array(body, 0, items) };
  throw new Error(`an array of ${kind} is not foreseen`);
}
