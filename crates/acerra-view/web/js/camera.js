// Which part of a field is in view. Screen coordinates are CSS pixels from the upper left corner.

export class Camera {
  /** @param {{yUp: boolean, square: boolean}} options axes: y upwards or downwards, one scale or two */
  constructor(options) {
    this.yUp = options.yUp;
    this.square = options.square;
    this.x = 0;
    this.y = 0;
    /** CSS pixels per unit. */
    this.kx = 1;
    this.ky = 1;
    this.width = 1;
    this.height = 1;
    /** Greatest and least scale against that of the whole field. */
    this.bounds = { x: [0, 1], y: [0, 1] };
  }

  /** @param {number} x @param {number} y @returns {[number, number]} */
  toScreen(x, y) {
    const down = this.yUp ? -1 : 1;
    return [this.width / 2 + (x - this.x) * this.kx, this.height / 2 + down * (y - this.y) * this.ky];
  }

  /** @param {number} sx @param {number} sy @returns {[number, number]} */
  toWorld(sx, sy) {
    const down = this.yUp ? -1 : 1;
    return [this.x + (sx - this.width / 2) / this.kx, this.y + (down * (sy - this.height / 2)) / this.ky];
  }

  /** Shows all of a field. @param {{x: number[], y: number[]}} bounds */
  fit(bounds) {
    this.bounds = bounds;
    const wide = Math.max(bounds.x[1] - bounds.x[0], 1e-9);
    const high = Math.max(bounds.y[1] - bounds.y[0], 1e-9);
    this.x = (bounds.x[0] + bounds.x[1]) / 2;
    this.y = (bounds.y[0] + bounds.y[1]) / 2;
    this.kx = (0.98 * this.width) / wide;
    this.ky = (0.98 * this.height) / high;
    if (this.square) this.kx = this.ky = Math.min(this.kx, this.ky);
  }

  /** @param {number} dx @param {number} dy moves the field by CSS pixels */
  pan(dx, dy) {
    const down = this.yUp ? -1 : 1;
    const within = (/** @type {number} */ v, /** @type {number[]} */ [a, b]) => Math.min(Math.max(v, a), b);
    this.x = within(this.x - dx / this.kx, this.bounds.x);
    this.y = within(this.y - (down * dy) / this.ky, this.bounds.y);
  }

  /** @param {number} sx @param {number} sy @param {number} factor scales about a point of the screen */
  zoomAt(sx, sy, factor) {
    const least = 0.3 * Math.min(this.width / (this.bounds.x[1] - this.bounds.x[0]), this.height / (this.bounds.y[1] - this.bounds.y[0]));
    const before = this.toWorld(sx, sy);
    const k = Math.max(Math.min(this.kx, this.ky) * factor, least) / Math.min(this.kx, this.ky);
    if (Math.max(this.kx, this.ky) * k > 1e6) return;
    this.kx *= k;
    this.ky *= k;
    const after = this.toWorld(sx, sy);
    this.x += before[0] - after[0];
    this.y += before[1] - after[1];
  }

  /** The part in view. @returns {{x: [number, number], y: [number, number]}} */
  view() {
    const [x0, ya] = this.toWorld(0, 0);
    const [x1, yb] = this.toWorld(this.width, this.height);
    return { x: [x0, x1], y: [Math.min(ya, yb), Math.max(ya, yb)] };
  }
}
