// Shapes over a field: axes, lines, marks; legible on any colour by a dark edge.

const EDGE = "rgba(8, 11, 15, 0.75)";
const FONT = '12px system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif';

/** Steps of 1, 2 or 5 times a power of ten, about so many over a span. @param {number} span @param {number} count */
export function step(span, count) {
  const raw = Math.max(span / Math.max(count, 1), 1e-12);
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5, 10].find((m) => m * power >= raw) ?? 10);
}

/** @param {CanvasRenderingContext2D} c @param {string} text @param {number} x @param {number} y @param {{align?: CanvasTextAlign, colour?: string, baseline?: CanvasTextBaseline}} [style] */
export function label(c, text, x, y, style = {}) {
  c.font = FONT;
  c.textAlign = style.align ?? "left";
  c.textBaseline = style.baseline ?? "alphabetic";
  c.lineWidth = 3.5;
  c.lineJoin = "round";
  c.strokeStyle = EDGE;
  c.strokeText(text, x, y);
  c.fillStyle = style.colour ?? "#fff";
  c.fillText(text, x, y);
}

/**
 * A line through points of the screen; not finite ones break it.
 * @param {CanvasRenderingContext2D} c @param {Iterable<number[]>} points @param {string} colour @param {{width?: number, dash?: number[]}} [style]
 */
export function line(c, points, colour, style = {}) {
  c.beginPath();
  let pen = false;
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) pen = false;
    else if (pen) c.lineTo(x, y);
    else {
      c.moveTo(x, y);
      pen = true;
    }
  }
  c.lineJoin = "round";
  c.setLineDash(style.dash ?? []);
  const width = style.width ?? 2;
  for (const [ink, w] of /** @type {[string, number][]} */ ([[EDGE, width + 2], [colour, width]])) {
    c.strokeStyle = ink;
    c.lineWidth = w;
    c.stroke();
  }
  c.setLineDash([]);
}

/** @param {CanvasRenderingContext2D} c @param {number} x @param {number} y @param {number} radius @param {string} colour @param {boolean} [filled] */
export function ringMark(c, x, y, radius, colour, filled = false) {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.strokeStyle = EDGE;
  c.lineWidth = 4;
  c.stroke();
  if (filled) {
    c.fillStyle = colour;
    c.fill();
  }
  c.strokeStyle = colour;
  c.lineWidth = 2;
  c.stroke();
}

/** @param {CanvasRenderingContext2D} c @param {number} x @param {number} y @param {string} colour */
export function cross(c, x, y, colour) {
  const arm = 9;
  for (const [ink, w] of /** @type {[string, number][]} */ ([[EDGE, 4.5], [colour, 2]])) {
    c.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      c.moveTo(x + 3 * dx, y + 3 * dy);
      c.lineTo(x + arm * dx, y + arm * dy);
    }
    c.strokeStyle = ink;
    c.lineWidth = w;
    c.stroke();
  }
}

/** @typedef {{value: (place: number) => number, place: (value: number) => number}} Numbers what an axis counts, where that is not the place itself */

/**
 * Ticks along the left and lower edges, and along the right one where another scale is given for it.
 * @param {CanvasRenderingContext2D} c @param {import("./camera.js").Camera} camera @param {{x: string, y: string}} names
 * @param {Numbers} [numbers] of the x axis @param {{name: string, numbers: Numbers}} [right]
 */
export function axes(c, camera, names, numbers = { value: (x) => x, place: (value) => value }, right = undefined) {
  const view = camera.view();
  const digits = (/** @type {number} */ s) => Math.max(0, -Math.floor(Math.log10(s) + 1e-9));
  const [first, last] = view.x.map(numbers.value);
  const sx = step(last - first, camera.width / 90);
  const sy = step(view.y[1] - view.y[0], camera.height / 60);
  const bottom = camera.height;
  c.font = FONT;
  const end = camera.width - 20 - c.measureText(names.x).width;
  for (let k = Math.ceil(first / sx); k * sx <= last; k++) {
    const [x] = camera.toScreen(numbers.place(k * sx), 0);
    if (x < 56 || x > end - 16) continue;
    line(c, [[x, bottom], [x, bottom - 6]], "#fff", { width: 1.2 });
    label(c, (k * sx).toFixed(digits(sx)), x, bottom - 9, { align: "center" });
  }
  for (let k = Math.ceil(view.y[0] / sy); k * sy <= view.y[1]; k++) {
    const [, y] = camera.toScreen(0, k * sy);
    if (y < 22 || y > bottom - 22) continue;
    line(c, [[0, y], [6, y]], "#fff", { width: 1.2 });
    label(c, (k * sy).toFixed(digits(sy)), 9, y, { baseline: "middle" });
  }
  label(c, names.x, camera.width - 8, bottom - 9, { align: "right" });
  label(c, names.y, 9, 15);
  if (!right) return;
  const [top, low] = view.y.map(right.numbers.value);
  const sr = step(low - top, camera.height / 60);
  const edge = camera.width;
  for (let k = Math.ceil(top / sr); k * sr <= low; k++) {
    const [, y] = camera.toScreen(0, right.numbers.place(k * sr));
    if (y < 22 || y > bottom - 28) continue;
    line(c, [[edge - 6, y], [edge, y]], "#fff", { width: 1.2 });
    label(c, (k * sr).toFixed(digits(sr)), edge - 9, y, { align: "right", baseline: "middle" });
  }
  label(c, right.name, edge - 9, 15, { align: "right" });
}
