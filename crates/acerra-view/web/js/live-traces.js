// The latest traces as they come, fast time downwards, the newest at the right edge.

import { label } from "./drawing.js";
import { palette } from "./palettes.js";

const KEPT = 512;
const RANGE_STEPS = 80;

export class LiveTracesPane {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Latest traces, fast time downwards");
    box.append(this.canvas);
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d", { willReadFrequently: true }));
    this.field = document.createElement("canvas");
    /** @type {Uint8Array[]} */
    this.traces = [];
    /** @type {[number, number]} */
    this.axis = [0, 1];
    /** @type {Uint32Array | null} */
    this.table = null;
    this.frame = 0;
    palette("greys").then((table) => {
      this.table = new Uint32Array(table.slice().buffer);
      this.invalidate();
    });
    new ResizeObserver(() => this.invalidate()).observe(box);
  }

  begin() {
    this.traces = [];
  }

  /** @param {import("./live-link.js").LiveTraces} news @param {[number, number]} axis first fast time and step (ns) */
  take(news, axis) {
    this.traces.push(...news.traces);
    this.traces.splice(0, Math.max(0, this.traces.length - KEPT));
    this.axis = axis;
    this.invalidate();
  }

  invalidate() {
    this.frame ||= requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.frame = 0;
    const { clientWidth, clientHeight } = this.box;
    if (!clientWidth || !clientHeight || !this.table) return;
    [this.canvas.width, this.canvas.height] = [clientWidth, clientHeight];
    const bins = this.traces.at(-1)?.length ?? 0;
    if (!bins) return;
    [this.field.width, this.field.height] = [KEPT, bins];
    const paper = /** @type {CanvasRenderingContext2D} */ (this.field.getContext("2d", { willReadFrequently: true }));
    const image = new ImageData(KEPT, bins);
    let top = 1;
    for (const trace of this.traces) for (let bin = 0; bin < bins; bin++) if (trace[bin] > top) top = trace[bin];
    const words = new Uint32Array(image.data.buffer);
    const table = this.table;
    const colours = Uint32Array.from({ length: 256 }, (_, level) => table[Math.round(255 * Math.min(Math.max(0, 1 - (top - level) / RANGE_STEPS), 1))]);
    this.traces.forEach((trace, k) => {
      const x = KEPT - this.traces.length + k;
      for (let bin = 0; bin < bins; bin++) words[bin * KEPT + x] = colours[trace[bin]];
    });
    paper.putImageData(image, 0, 0);
    const { context } = this;
    context.imageSmoothingEnabled = false;
    context.drawImage(this.field, 0, 0, clientWidth, clientHeight);
    const [start, step] = this.axis;
    for (const share of [0.02, 0.25, 0.5, 0.75, 0.95]) label(context, `${(start + share * bins * step).toFixed(0)} ns`, 8, 12 + share * (clientHeight - 16), { baseline: "middle" });
  }
}
