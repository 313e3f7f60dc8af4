// Tiles of a field: fetched as they come into view, kept while there is room.

import { getBytes } from "./api.js";
import { Coloured } from "./coloured.js";

/** Tiles kept in graphics memory; each takes at most half a mebibyte, and half of that once coloured. */
const MOST_KEPT = 240;

/** @typedef {{texture: WebGLTexture | null, values: Float32Array | null, columns: number, rows: number, used: number, abort: AbortController | null, coloured: import("./coloured.js").Coloured}} Tile */

export class Tiles {
  /**
   * @param {import("./gl.js").Painter} painter
   * @param {{size: number, nx: number, ny: number, levels: number, half?: boolean, path: (level: number, column: number, row: number) => string}} source `half`: in half precision, of which no values are kept
   * @param {() => void} changed is called when a tile has come
   * @param {(error: Error) => void} failed
   */
  constructor(painter, source, changed, failed) {
    this.painter = painter;
    this.source = source;
    this.changed = changed;
    this.failed = failed;
    /** @type {Map<string, Tile>} */
    this.kept = new Map();
    this.clock = 0;
    this.pending = 0;
  }

  /** Columns and rows of a level. @param {number} level @returns {[number, number]} */
  extent(level) {
    const part = 2 ** level;
    return [Math.ceil(this.source.nx / part), Math.ceil(this.source.ny / part)];
  }

  /** A tile, if it is here; fetched otherwise. @param {number} level @param {number} column @param {number} row */
  get(level, column, row) {
    const key = `${level}/${column}/${row}`;
    const found = this.kept.get(key);
    if (found) {
      found.used = this.clock;
      return found.texture ? found : null;
    }
    const [nx, ny] = this.extent(level);
    const { size } = this.source;
    const tile = {
      texture: null,
      values: null,
      columns: Math.min(size, nx - column * size),
      rows: Math.min(size, ny - row * size),
      used: this.clock,
      abort: new AbortController(),
      coloured: new Coloured(this.painter),
    };
    this.kept.set(key, tile);
    this.pending += 1;
    void this.fetch(key, tile, `${this.source.path(level, column, row)}${this.source.half ? "?half=true" : ""}`);
    return null;
  }

  /** @param {string} key @param {Tile} tile @param {string} path */
  async fetch(key, tile, path) {
    try {
      const bytes = await getBytes(path, tile.abort?.signal);
      if (this.source.half) {
        tile.texture = this.painter.halfField(tile.columns, tile.rows, new Uint16Array(bytes));
      } else {
        tile.values = new Float32Array(bytes);
        tile.texture = this.painter.field(tile.columns, tile.rows, tile.values);
      }
      tile.abort = null;
    } catch (error) {
      if (error instanceof DOMException && error.name === "AbortError") {
        this.kept.delete(key);
      } else {
        // It stays empty: the same request would fail again with every picture.
        tile.abort = null;
        this.failed(/** @type {Error} */ (error));
      }
    }
    this.pending -= 1;
    this.changed();
  }

  /** The value at a column and a row of level 0, if its tile is here. @param {number} i @param {number} j */
  value(i, j) {
    const { size } = this.source;
    const tile = this.kept.get(`0/${Math.floor(i / size)}/${Math.floor(j / size)}`);
    if (!tile?.values) return null;
    const at = 2 * ((j % size) * tile.columns + (i % size));
    return [tile.values[at], tile.values[at + 1]];
  }

  /** Ends a picture: gives up what is out of view, and the oldest tiles. */
  sweep() {
    for (const [key, tile] of this.kept) {
      if (tile.abort && tile.used < this.clock) {
        tile.abort.abort();
        this.kept.delete(key);
      }
    }
    if (this.kept.size > MOST_KEPT) {
      const old = [...this.kept].filter(([, tile]) => tile.used < this.clock).sort((a, b) => a[1].used - b[1].used);
      for (const [key, tile] of old.slice(0, this.kept.size - MOST_KEPT)) {
        this.forget(tile);
        this.kept.delete(key);
      }
    }
    this.clock += 1;
  }

  /** Frees all of it. */
  close() {
    for (const tile of this.kept.values()) {
      tile.abort?.abort();
      this.forget(tile);
    }
    this.kept.clear();
  }

  /** @param {Tile} tile */
  forget(tile) {
    if (tile.texture) this.painter.forget(tile.texture);
    tile.coloured.forget();
  }
}
