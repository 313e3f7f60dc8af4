// Tables of colours, as the program's own pictures have them.

import { getBytes } from "./api.js";

/** Names and labels. */
export const PALETTES = /** @type {const} */ ([["inferno", "Inferno"], ["viridis", "Viridis"], ["cividis", "Cividis"], ["greys", "Greys"]]);

/** @type {Map<string, Promise<Uint8Array>>} */
const tables = new Map();

/** Red, green, blue and opacity of even steps. @param {string} name @returns {Promise<Uint8Array>} */
export function palette(name) {
  let table = tables.get(name);
  if (!table) {
    table = name === "phase" ? Promise.resolve(phase()) : getBytes(`api/palette/${name}`).then((bytes) => new Uint8Array(bytes));
    tables.set(name, table);
  }
  return table;
}

/** A circle of hues of even lightness, for phases: the end is the start. */
function phase() {
  const table = new Uint8Array(4 * 256);
  for (let k = 0; k < 256; k++) {
    const hue = (2 * Math.PI * k) / 255;
    // Oklab of lightness 0.72 and chroma 0.115.
    const [a, b] = [0.115 * Math.cos(hue), 0.115 * Math.sin(hue)];
    const [l, m, s] = [0.72 + 0.3963377774 * a + 0.2158037573 * b, 0.72 - 0.1055613458 * a - 0.0638541728 * b, 0.72 - 0.0894841775 * a - 1.291485548 * b].map((v) => v ** 3);
    const linear = [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s, -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s];
    linear.forEach((v, c) => {
      const x = Math.min(Math.max(v, 0), 1);
      table[4 * k + c] = Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
    });
    table[4 * k + 3] = 255;
  }
  return table;
}
