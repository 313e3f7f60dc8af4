// The image of a live flight: levels kept as they come, coloured, drawn under axes and track.

import { Camera } from "./camera.js";
import { axes, ringMark } from "./drawing.js";
import { listen } from "./gestures.js";
import { palette } from "./palettes.js";

/** Half a decibel a step. */
const STEP_DB = 0.5;
/** Colours of positions by their kind. @type {Record<string, string>} */
export const KINDS = { fixed: "#6fd39a", external: "#6fd39a", float: "#f0c35b" };
const OTHER = "#ff8a80";

export class LivePicture {
  /** @param {HTMLElement} box @param {(place: {x_m: number, y_m: number, db: number | null} | null) => void} told */
  constructor(box, told) {
    this.box = box;
    this.told = told;
    this.canvas = document.createElement("canvas");
    this.surface = document.createElement("div");
    this.surface.className = "surface";
    this.surface.tabIndex = 0;
    this.surface.setAttribute("role", "application");
    this.surface.setAttribute("aria-label", "Provisional image: drag or arrows move, plus and minus zoom");
    box.append(this.canvas, this.surface);
    // Pixels come from the processor: a canvas of the graphics processor would fetch them again each time.
    // Levels are coloured by the processor: a canvas kept by the graphics processor fetches all of them again each time.
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d", { willReadFrequently: true }));
    this.camera = new Camera({ yUp: true, square: true });
    this.field = document.createElement("canvas");
    this.paper = /** @type {CanvasRenderingContext2D} */ (this.field.getContext("2d", { willReadFrequently: true }));
    /** @type {import("./live-link.js").LiveGrid | null} */
    this.grid = null;
    this.levels = new Uint8Array(0);
    /** @type {ImageData | null} */
    this.pixels = null;
    this.colours = new Uint32Array(256);
    /** @type {Uint8Array | null} */
    this.table = null;
    this.baseDb = 0;
    this.maximumDb = -Infinity;
    this.rangeDb = 30;
    /** @type {[number[], string][]} */
    this.track = [];
    this.fitted = true;
    this.frame = 0;
    palette("inferno").then((table) => {
      this.table = table;
      this.recolour();
    });
    listen(this.surface, this.camera, {
      hover: (sx, sy) => this.hover(sx, sy),
      leave: () => told(null),
      click: (sx, sy) => this.hover(sx, sy),
      drag: () => false,
      moved: () => {
        this.fitted = false;
        this.invalidate();
      },
    });
    new ResizeObserver(() => this.resize()).observe(box);
  }

  /** Forgets everything: it comes again. */
  begin() {
    this.grid = null;
    this.track = [];
    this.maximumDb = -Infinity;
  }

  resize() {
    const { clientWidth, clientHeight } = this.box;
    if (!clientWidth || !clientHeight) return;
    [this.camera.width, this.camera.height] = [clientWidth, clientHeight];
    if (this.fitted) this.fit();
    this.invalidate();
  }

  fit() {
    if (!this.grid) return;
    const { x0_m, y0_m, pixel_m, nx, ny } = this.grid;
    const half = pixel_m / 2;
    this.camera.fit({ x: [x0_m - half, x0_m + nx * pixel_m - half], y: [y0_m - half, y0_m + ny * pixel_m - half] });
    this.fitted = true;
    this.invalidate();
  }

  /** @param {import("./live-link.js").LiveGrid} grid */
  setGrid(grid) {
    if (this.grid && this.grid.nx === grid.nx && this.grid.ny === grid.ny && this.grid.x0_m === grid.x0_m && this.grid.y0_m === grid.y0_m) return;
    this.grid = grid;
    this.levels = new Uint8Array(grid.nx * grid.ny);
    [this.field.width, this.field.height] = [grid.nx, grid.ny];
    this.pixels = new ImageData(grid.nx, grid.ny);
    if (this.fitted) this.fit();
  }

  /** @param {import("./live-link.js").LiveTiles} news */
  take(news) {
    if (!this.grid) return;
    const { nx } = this.grid;
    for (const { x, y, columns, rows, levels } of news.tiles) {
      for (let row = 0; row < rows; row++) this.levels.set(levels.subarray(row * columns, (row + 1) * columns), (y + row) * nx + x);
    }
    // The colours follow the maximum by whole steps: each change colours all pixels again.
    const isSame = news.baseDb === this.baseDb && Math.abs(news.maximumDb - this.maximumDb) < 2 * STEP_DB;
    if (isSame) {
      for (const tile of news.tiles) this.colour(tile.x, tile.y, tile.columns, tile.rows);
    } else {
      [this.baseDb, this.maximumDb] = [news.baseDb, news.maximumDb];
      this.recolour();
    }
    this.invalidate();
  }

  /** Colours all levels by the range in view. */
  recolour() {
    if (!this.table || !this.grid) return;
    const top = (this.maximumDb - this.baseDb) / STEP_DB;
    const bytes = new Uint8Array(this.colours.buffer);
    for (let level = 0; level < 256; level++) {
      const share = level === 0 ? 0 : 1 - (top - level) * (STEP_DB / this.rangeDb);
      const k = 4 * Math.round(255 * Math.min(Math.max(share, 0), 1));
      bytes.set(this.table.subarray(k, k + 4), 4 * level);
    }
    this.colour(0, 0, this.grid.nx, this.grid.ny);
    this.invalidate();
  }

  /** Rows are turned over: the first one is the lowest. @param {number} x @param {number} y @param {number} columns @param {number} rows */
  colour(x, y, columns, rows) {
    if (!this.pixels || !this.grid) return;
    const { nx, ny } = this.grid;
    const words = new Uint32Array(this.pixels.data.buffer);
    for (let row = y; row < y + rows; row++) {
      const from = row * nx + x;
      const to = (ny - 1 - row) * nx + x;
      for (let k = 0; k < columns; k++) words[to + k] = this.colours[this.levels[from + k]];
    }
    this.paper.putImageData(this.pixels, 0, 0, x, ny - y - rows, columns, rows);
  }

  /** @param {number} sx @param {number} sy */
  hover(sx, sy) {
    if (!this.grid) return;
    const [x_m, y_m] = this.camera.toWorld(sx, sy);
    const { x0_m, y0_m, pixel_m, nx, ny } = this.grid;
    const [i, j] = [Math.round((x_m - x0_m) / pixel_m), Math.round((y_m - y0_m) / pixel_m)];
    const level = i >= 0 && i < nx && j >= 0 && j < ny ? this.levels[j * nx + i] : 0;
    this.told({ x_m, y_m, db: level ? this.baseDb + STEP_DB * level - this.maximumDb : null });
  }

  invalidate() {
    this.frame ||= requestAnimationFrame(() => this.draw());
  }

  /** Draws what is known now. */
  draw() {
    this.frame = 0;
    const { camera, context, canvas, grid } = this;
    if (camera.width <= 1) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [w, h] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    if (!grid) return;
    const half = grid.pixel_m / 2;
    const [left, top] = camera.toScreen(grid.x0_m - half, grid.y0_m + grid.ny * grid.pixel_m - half);
    context.imageSmoothingEnabled = camera.kx * grid.pixel_m < 1;
    context.drawImage(this.field, left, top, grid.nx * grid.pixel_m * camera.kx, grid.ny * grid.pixel_m * camera.ky);
    for (const [[x, y], kind] of this.track) {
      const [sx, sy] = camera.toScreen(x, y);
      context.fillStyle = KINDS[kind] ?? OTHER;
      context.fillRect(sx - 1, sy - 1, 2.5, 2.5);
    }
    const last = this.track.at(-1);
    if (last) {
      const [sx, sy] = camera.toScreen(last[0][0], last[0][1]);
      ringMark(context, sx, sy, 6, KINDS[last[1]] ?? OTHER);
    }
    axes(context, camera, { x: "east (m)", y: "north (m)" });
  }
}
