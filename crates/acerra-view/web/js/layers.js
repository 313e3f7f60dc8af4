// Fields on a pane: tiled ones, and single ones that the engine has just made.

import { Tiles } from "./tiles.js";

/** @typedef {{x0: number, dx: number, nx: number, y0: number, dy: number, ny: number}} Axes centres of the first column and row, and steps */
/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./gl.js").Painter} Painter */
/** @typedef {import("./gl.js").Rectangle} Rectangle */

/**
 * Where columns i0 to i1 and rows j0 to j1 (edges, counted from the first's lower edge) lie in clip coordinates.
 * @param {Camera} camera @param {Axes} axes @param {Rectangle} cells @returns {Rectangle}
 */
function clip(camera, axes, [i0, j0, i1, j1]) {
  const [ax, ay] = camera.toScreen(axes.x0 + (i0 - 0.5) * axes.dx, axes.y0 + (j0 - 0.5) * axes.dy);
  const [bx, by] = camera.toScreen(axes.x0 + (i1 - 0.5) * axes.dx, axes.y0 + (j1 - 0.5) * axes.dy);
  const x = (/** @type {number} */ s) => (2 * s) / camera.width - 1;
  const y = (/** @type {number} */ s) => 1 - (2 * s) / camera.height;
  return [x(ax), y(ay), x(bx), y(by)];
}

/** The whole of a field. @param {Axes} axes */
export function boundsOf(axes) {
  return {
    x: [axes.x0 - 0.5 * axes.dx, axes.x0 + (axes.nx - 0.5) * axes.dx],
    y: [axes.y0 - 0.5 * axes.dy, axes.y0 + (axes.ny - 0.5) * axes.dy],
  };
}

/** A field in tiles. */
export class TiledLayer {
  /**
   * @param {Painter} painter @param {Axes} axes
   * @param {{size: number, levels: number, half?: boolean, path: (level: number, column: number, row: number) => string}} source
   * @param {() => void} changed @param {(error: Error) => void} failed
   */
  constructor(painter, axes, source, changed, failed) {
    this.painter = painter;
    this.axes = axes;
    this.levels = source.levels;
    this.size = source.size;
    this.tiles = new Tiles(painter, { ...source, nx: axes.nx, ny: axes.ny }, changed, failed);
    /** Whether the last picture showed all tiles at their level. */
    this.complete = false;
  }

  /** The level of which one value is about one pixel of the screen. @param {Camera} camera @param {number} ratio */
  level(camera, ratio) {
    const cells = 1 / (ratio * Math.max(camera.kx * this.axes.dx, camera.ky * this.axes.dy));
    return Math.min(Math.max(Math.floor(Math.log2(Math.max(cells, 1))), 0), this.levels - 1);
  }

  /** Asks for the tiles in view; whether all of them are here. @param {Camera} camera @param {number} ratio */
  ready(camera, ratio) {
    const level = this.level(camera, ratio);
    const tiles = this.visible(camera, level).map((at) => this.tiles.get(level, ...at));
    this.tiles.sweep();
    return tiles.every((tile) => tile !== null);
  }

  /** @param {Camera} camera @param {number} ratio @param {TiledLayer | null} [other] */
  draw(camera, ratio, other = null) {
    const level = this.level(camera, ratio);
    const coarsest = this.levels - 1;
    this.complete = true;
    const wanted = this.visible(camera, level).map((at) => ({ at, tile: this.tiles.get(level, ...at), pair: other?.tiles.get(level, ...at) ?? null }));
    if (wanted.some(({ tile }) => !tile)) {
      this.complete = false;
      for (const at of this.visible(camera, coarsest)) {
        const tile = this.tiles.get(coarsest, ...at);
        const pair = other?.tiles.get(coarsest, ...at) ?? null;
        if (tile && (!other || pair)) this.drawTile(camera, coarsest, at, tile, pair);
      }
    }
    for (const { at, tile, pair } of wanted) {
      if (tile && (!other || pair)) this.drawTile(camera, level, at, tile, pair);
    }
    // Those around are fetched too, behind those in view: a move finds them there.
    for (const at of this.visible(camera, level, 1)) this.tiles.get(level, ...at);
    this.tiles.sweep();
    other?.tiles.sweep();
  }

  /**
   * Tiles in view, and so many around it; the nearest to the middle first.
   * @param {Camera} camera @param {number} level @param {number} [margin] @returns {[number, number][]}
   */
  visible(camera, level, margin = 0) {
    const { axes, size } = this;
    const view = camera.view();
    const cell = 2 ** level * size;
    const [nx, ny] = this.tiles.extent(level);
    const range = (/** @type {number[]} */ v, /** @type {number} */ first, /** @type {number} */ step, /** @type {number} */ n) => {
      const from = Math.floor(((v[0] - first) / step + 0.5) / cell);
      const to = Math.floor(((v[1] - first) / step + 0.5) / cell);
      return [Math.max(from - margin, 0), Math.min(to + margin, Math.ceil(n / size) - 1)];
    };
    const [c0, c1] = range(view.x, axes.x0, axes.dx, nx);
    const [r0, r1] = range(view.y, axes.y0, axes.dy, ny);
    /** @type {[number, number][]} */
    const list = [];
    for (let row = r0; row <= r1; row++) for (let column = c0; column <= c1; column++) list.push([column, row]);
    const middle = [(c0 + c1) / 2, (r0 + r1) / 2];
    return list.sort((a, b) => Math.hypot(a[0] - middle[0], a[1] - middle[1]) - Math.hypot(b[0] - middle[0], b[1] - middle[1]));
  }

  /**
   * @param {Camera} camera @param {number} level @param {[number, number]} at
   * @param {import("./tiles.js").Tile} tile @param {import("./tiles.js").Tile | null} pair
   */
  drawTile(camera, level, [column, row], tile, pair) {
    if (!tile.texture) return;
    const { axes } = this;
    const cell = 2 ** level;
    const [i0, j0] = [column * this.size * cell, row * this.size * cell];
    // The last values of a level may stand for fewer than their share.
    const i1 = Math.min(i0 + tile.columns * cell, axes.nx);
    const j1 = Math.min(j0 + tile.rows * cell, axes.ny);
    const [u, v] = [(i1 - i0) / (tile.columns * cell), (j1 - j0) / (tile.rows * cell)];
    /** @type {Rectangle} */
    const place = [i0 / axes.nx, j0 / axes.ny, i1 / axes.nx, j1 / axes.ny];
    /** @type {import("./gl.js").At} */
    const at = { clip: clip(camera, axes, [i0, j0, i1, j1]), part: [0, 0, u, v], place };
    if (pair) {
      this.painter.draw(tile.texture, pair.texture, at);
      return;
    }
    // The tile's whole texture lies further out than the values that count, where these end early.
    const whole = /** @type {Rectangle} */ ([place[0], place[1], place[0] + (place[2] - place[0]) / u, place[1] + (place[3] - place[1]) / v]);
    tile.coloured.draw(tile.texture, [tile.columns, tile.rows], whole, at);
  }

  close() {
    this.tiles.close();
  }
}

/** One of many fields over the same pixels: it is shown until the next wanted is here. */
export class ChangingLayer {
  /** @param {(index: number) => TiledLayer} make @param {() => void} changed is called when there is another to draw */
  constructor(make, changed) {
    this.make = make;
    this.changed = changed;
    /** @type {number | null} */
    this.wanted = null;
    /** @type {{index: number, layer: TiledLayer} | null} */
    this.shown = null;
    /** @type {{index: number, layer: TiledLayer} | null} */
    this.next = null;
  }

  /** Shows a field, or none. @param {number | null} index */
  show(index) {
    this.wanted = index;
    if (index === null) {
      this.shown?.layer.close();
      this.next?.layer.close();
      this.shown = this.next = null;
    } else if (!this.next) {
      this.begin(index);
    }
    this.changed();
  }

  /** @param {number} index */
  begin(index) {
    if (this.shown?.index !== index) this.next = { index, layer: this.make(index) };
  }

  /** Whether the one wanted has been drawn with all its tiles. */
  get complete() {
    return this.shown !== null && this.shown.index === this.wanted && this.shown.layer.complete;
  }

  /** @param {Camera} camera @param {number} ratio */
  draw(camera, ratio) {
    if (this.next?.layer.ready(camera, ratio)) {
      this.shown?.layer.close();
      this.shown = this.next;
      this.next = null;
      if (this.wanted !== null) this.begin(this.wanted);
      if (this.next) this.changed();
    }
    this.shown?.layer.draw(camera, ratio);
  }
}

/** A field in one piece. */
export class SingleLayer {
  /** @param {Painter} painter @param {Axes} axes @param {Float32Array} values */
  constructor(painter, axes, values) {
    this.painter = painter;
    this.axes = axes;
    this.values = values;
    this.texture = painter.field(axes.nx, axes.ny, values);
  }

  /** @param {Camera} camera @param {Axes} [whole] the axes on which a gain is sampled */
  draw(camera, whole = this.axes) {
    const { axes } = this;
    const place = (/** @type {number} */ v, /** @type {number} */ first, /** @type {number} */ step, /** @type {number} */ n) => ((v - first) / step + 0.5) / n;
    const [b, w] = [boundsOf(axes), whole];
    this.painter.draw(this.texture, null, {
      clip: clip(camera, axes, [0, 0, axes.nx, axes.ny]),
      part: [0, 0, 1, 1],
      place: [place(b.x[0], w.x0, w.dx, w.nx), place(b.y[0], w.y0, w.dy, w.ny), place(b.x[1], w.x0, w.dx, w.nx), place(b.y[1], w.y0, w.dy, w.ny)],
    });
  }

  /** The value nearest to (x, y). @param {number} x @param {number} y @returns {[number, number] | null} */
  value(x, y) {
    const { axes } = this;
    const [i, j] = [Math.round((x - axes.x0) / axes.dx), Math.round((y - axes.y0) / axes.dy)];
    if (i < 0 || j < 0 || i >= axes.nx || j >= axes.ny) return null;
    const at = 2 * (j * axes.nx + i);
    return [this.values[at], this.values[at + 1]];
  }

  close() {
    this.painter.forget(this.texture);
  }
}
