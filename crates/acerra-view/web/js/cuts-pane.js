// Vertical cuts through a volume: x–z and y–z through the place marked, or under the pointer.

import { axes, label, line } from "./drawing.js";
import { ChangingLayer, TiledLayer, boundsOf } from "./layers.js";
import { palette } from "./palettes.js";
import { Pane } from "./pane.js";
import { number } from "./readout.js";

const MARK = "#ffe14d";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {{hover: (x: number, y: number, slice: number) => void, failed: (error: Error) => void}} Listener */

/** A cut normal to x or to y. */
class Cut {
  /** @param {HTMLElement} box @param {"x" | "y"} normal @param {Store} store @param {Listener} listener */
  constructor(box, normal, store, listener) {
    this.store = store;
    this.normal = normal;
    this.along = normal === "y" ? /** @type {const} */ ("x") : /** @type {const} */ ("y");
    const pane = new Pane(box, `Vertical cut of the volume along ${this.along}. Arrows move, plus and minus zoom, Enter moves slice and cut to the middle.`, { yUp: true, square: false });
    this.pane = pane;
    this.layer = new ChangingLayer((index) => this.tiles(index, listener.failed), () => pane.invalidate());
    /** @type {WebGLTexture | null} */
    this.colours = null;
    pane.onField = (ratio) => this.drawField(ratio);
    pane.onOverlay = (context) => this.drawOverlay(context);
    pane.onHover = (s, z) => {
      const at = this.place(s, z);
      if (at) listener.hover(at.x, at.y, at.slice);
    };
    pane.onClick = (s, z) => this.click(s, z);
  }

  get grid() {
    return /** @type {import("./types.js").RunMeta} */ (this.store.meta).grid;
  }

  get volume() {
    return /** @type {import("./types.js").Volume} */ (this.store.meta?.volume);
  }

  /** Coordinates of the cut: along it, and height. @returns {import("./layers.js").Axes} */
  get axes() {
    const { grid, volume, along } = this;
    const [x0, nx] = along === "x" ? [grid.x0_m, grid.nx] : [grid.y0_m, grid.ny];
    return { x0, dx: grid.pixel_m, nx, y0: volume.z0_m, dy: volume.step_m, ny: volume.slices };
  }

  /** @param {number} index @param {(error: Error) => void} failed */
  tiles(index, failed) {
    const { store, normal } = this;
    const { run } = store;
    const path = (/** @type {number} */ level, /** @type {number} */ column, /** @type {number} */ row) => `api/run/${run}/volume/${normal}/${index}/${level}/${column}/${row}`;
    const source = { size: store.runs.tile, levels: this.volume.levels[normal], half: true, path };
    return new TiledLayer(this.pane.painter, this.axes, source, () => this.pane.invalidate(), failed);
  }

  /** Where a point of the cut is in the volume; none beyond it. @param {number} s @param {number} z */
  place(s, z) {
    const { cut } = this.store;
    const slice = Math.round((z - this.volume.z0_m) / this.volume.step_m);
    if (!cut || slice < 0 || slice >= this.volume.slices) return null;
    return this.along === "x" ? { x: s, y: cut.y, slice } : { x: cut.x, y: s, slice };
  }

  /** The index of the cut through the place in force; the nearest within the volume. */
  get index() {
    const { cut } = this.store;
    if (!cut) return null;
    const { grid } = this;
    const [v, first, n] = this.normal === "y" ? [cut.y, grid.y0_m, grid.ny] : [cut.x, grid.x0_m, grid.nx];
    return Math.min(Math.max(Math.round((v - first) / grid.pixel_m), 0), n - 1);
  }

  follow() {
    this.layer.show(this.index);
    this.pane.invalidate();
  }

  /** Moves slice and cuts to a point. @param {number} s @param {number} z */
  click(s, z) {
    const at = this.place(s, z);
    if (!at) return;
    const { store } = this;
    store.mark = { x: at.x, y: at.y, hyperbola: null };
    store.showSlice(at.slice);
    store.tell("mark");
  }

  async recolour() {
    const { look } = this.store;
    const table = await palette(look.mode === "phase" ? "phase" : look.palette);
    if (this.colours) this.pane.painter.forget(this.colours);
    this.colours = this.pane.painter.colours(table);
    this.pane.invalidate();
  }

  /** @param {number} ratio */
  drawField(ratio) {
    const { store, colours } = this;
    if (!colours || !store.meta) return;
    const mode = store.look.mode === "phase" ? 1 : 0;
    this.pane.painter.look({ mode, window: store.look.window, zero_db: store.meta.display.maximum_db - store.meta.display.half_db, other_zero_db: 0, gain: null, colours, opacity: 1 });
    this.layer.draw(this.pane.camera, ratio);
  }

  /** @param {CanvasRenderingContext2D} c */
  drawOverlay(c) {
    const { store, along } = this;
    const { camera } = this.pane;
    if (!store.meta?.volume) return;
    if (store.slice !== null) {
      const [, y] = camera.toScreen(0, store.slice);
      line(c, [[0, y], [camera.width, y]], "#ffffff", { width: 1, dash: [5, 5] });
    }
    axes(c, camera, { x: `${along} / m`, y: "z / m" });
    const { cut } = store;
    if (!cut) return;
    const [x] = camera.toScreen(cut[along], 0);
    line(c, [[x, 0], [x, camera.height]], MARK, { width: 1 });
    label(c, `${along}–z at ${this.normal} = ${number(cut[this.normal], 3, "m")}`, camera.width - 8, 15, { align: "right" });
  }
}

export class CutsPane {
  /** @param {HTMLElement} root @param {Store} store @param {Listener} listener */
  constructor(root, store, listener) {
    this.root = root;
    this.store = store;
    this.listener = listener;
    /** Made for the first run that has a volume. @type {Cut[]} */
    this.cuts = [];
    /** The run whose cuts are shown. @type {import("./types.js").RunMeta | null} */
    this.shown = null;
    store.on(["run"], () => this.show());
    store.on(["look"], () => this.recolour());
    store.on(["slice"], () => this.cuts.forEach((cut) => cut.pane.invalidate()));
    store.on(["mark", "cut"], () => this.follow());
  }

  /** Shows the cuts of the run, if it has a volume. */
  show() {
    const { store, root } = this;
    if (this.shown === store.meta) return;
    this.shown = store.meta;
    const volume = store.meta?.volume ?? null;
    root.hidden = !volume;
    for (const cut of this.cuts) cut.layer.show(null);
    if (!volume) return;
    if (!this.cuts.length) {
      this.cuts = /** @type {("y" | "x")[]} */ (["y", "x"]).map((normal) => {
        const box = document.createElement("div");
        box.className = "canvas-box";
        box.dataset.cut = normal;
        root.append(box);
        return new Cut(box, normal, store, this.listener);
      });
    }
    for (const cut of this.cuts) cut.pane.fit(boundsOf(cut.axes));
    this.recolour();
    this.follow();
  }

  recolour() {
    for (const cut of this.cuts) void cut.recolour();
  }

  /** Cuts at the place marked, or under the pointer; at first through the strongest target. */
  follow() {
    const { store } = this;
    if (!store.meta?.volume) return;
    const { mark, meta } = store;
    const [target] = meta.targets.targets;
    const { grid } = meta;
    const middle = { x: grid.x0_m + (grid.nx * grid.pixel_m) / 2, y: grid.y0_m + (grid.ny * grid.pixel_m) / 2 };
    if (mark) store.cut = { x: mark.x, y: mark.y };
    else store.cut ??= target ? { x: target.x_m, y: target.y_m } : middle;
    for (const cut of this.cuts) cut.follow();
  }
}
