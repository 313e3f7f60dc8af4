// Contours of the ground under the image.

import { label, step } from "./drawing.js";

/** Contours, about so many. */
const LEVELS = 12;
const LEAST_STEP_M = 0.001;
const INK = "rgba(255, 255, 255, 0.8)";
const EDGE = "rgba(8, 11, 15, 0.6)";

/** @typedef {{level_m: number, path: Path2D, place: [number, number]}} Contour a line at a height, in metres, and a place on it */

/**
 * The ends, in columns and rows, of the pieces of a contour within a cell of four heights, by linear
 * interpolation along its sides. Where two pieces cross a cell, the mean height tells which sides they join.
 * @param {number[]} z heights at (0, 0), (1, 0), (1, 1) and (0, 1) @param {number} level
 * @returns {[number, number][]}
 */
function pieces([a, b, c, d], level) {
  const part = (/** @type {number} */ from, /** @type {number} */ to) => (level - from) / (to - from);
  const crosses = (/** @type {number} */ from, /** @type {number} */ to) => from < level !== to < level;
  /** @type {([number, number] | null)[]} */
  const sides = [
    crosses(a, b) ? [part(a, b), 0] : null,
    crosses(b, c) ? [1, part(b, c)] : null,
    crosses(d, c) ? [part(d, c), 1] : null,
    crosses(a, d) ? [0, part(a, d)] : null,
  ];
  const ends = sides.filter((end) => end !== null);
  if (ends.length < 4) return ends;
  const [south, east, north, west] = ends;
  return (a + b + c + d) / 4 < level === a < level ? [south, east, north, west] : [south, west, north, east];
}

/** @param {import("./types.js").Terrain} terrain @param {import("./types.js").Grid} grid @returns {{step_m: number, contours: Contour[]}} */
export function contoursOf(terrain, grid) {
  const { columns, rows, stride, height_m } = terrain;
  const [low, high] = height_m.reduce(([a, b], z) => [Math.min(a, z), Math.max(b, z)], [Infinity, -Infinity]);
  const step_m = Math.max(step(high - low, LEVELS), LEAST_STEP_M);
  const side = stride * grid.pixel_m;
  const at = (/** @type {number} */ i, /** @type {number} */ j) => height_m[j * columns + i];
  /** @type {Contour[]} */
  const contours = [];
  for (let k = Math.ceil(low / step_m); k * step_m <= high; k++) {
    const level_m = k * step_m;
    const path = new Path2D();
    /** @type {[number, number][]} */
    const places = [];
    for (let j = 0; j + 1 < rows; j++) {
      for (let i = 0; i + 1 < columns; i++) {
        const ends = pieces([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], level_m);
        ends.forEach(([u, v], n) => {
          const place = /** @type {[number, number]} */ ([grid.x0_m + (i + u) * side, grid.y0_m + (j + v) * side]);
          if (n % 2) path.lineTo(...place);
          else {
            path.moveTo(...place);
            places.push(place);
          }
        });
      }
    }
    if (places.length) contours.push({ level_m, path, place: places[Math.floor(places.length / 3)] });
  }
  return { step_m, contours };
}

/** @param {CanvasRenderingContext2D} c @param {import("./camera.js").Camera} camera @param {Contour[]} contours */
export function drawContours(c, camera, contours) {
  const [x, y] = camera.toScreen(0, 0);
  const screen = new DOMMatrix([camera.kx, 0, 0, -camera.ky, x, y]);
  const all = new Path2D();
  for (const { path } of contours) all.addPath(path, screen);
  for (const [ink, width] of /** @type {[string, number][]} */ ([[EDGE, 3], [INK, 1]])) {
    c.strokeStyle = ink;
    c.lineWidth = width;
    c.stroke(all);
  }
  for (const { level_m, place } of contours) label(c, `${Number(level_m.toPrecision(6))} m`, ...camera.toScreen(...place));
}
