// A pane: a field drawn by WebGL2, and a drawing over it; redrawn once a frame at most.

import { Camera } from "./camera.js";
import { listen } from "./gestures.js";
import { Painter } from "./gl.js";

export class Pane {
  /**
   * @param {HTMLElement} box @param {string} label what the pane shows, for readers of the screen
   * @param {{yUp: boolean, square: boolean, clear?: boolean}} axes directions and scales; whether what lies under the pane is seen
   */
  constructor(box, label, axes) {
    this.box = box;
    this.camera = new Camera(axes);
    this.clear = axes.clear ?? false;
    /** @type {{painter: Painter, drawing: HTMLCanvasElement, context: CanvasRenderingContext2D} | null} */
    this.made = null;
    this.surface = document.createElement("div");
    this.surface.className = "surface";
    this.surface.tabIndex = 0;
    this.surface.setAttribute("role", "application");
    this.surface.setAttribute("aria-label", label);
    box.append(this.surface);
    /** @type {(() => void)[]} */
    this.drawn = [];
    this.frame = 0;
    /** @type {{x: number[], y: number[]} | null} */
    this.bounds = null;
    /** @type {(context: CanvasRenderingContext2D) => void} */
    this.onOverlay = () => {};
    /** @type {(ratio: number) => void} */
    this.onField = () => {};
    /** @type {() => void} */
    this.onMove = () => {};
    /** @type {(x: number, y: number) => void} */
    this.onHover = () => {};
    /** @type {() => void} */
    this.onLeave = () => {};
    /** @type {(x: number, y: number) => void} */
    this.onClick = () => {};
    /** @type {(from: [number, number], to: [number, number], done: boolean) => boolean} */
    this.onDrag = () => false;
    new ResizeObserver(() => this.resize()).observe(box);
    listen(this.surface, this.camera, {
      hover: (sx, sy) => this.onHover(...this.camera.toWorld(sx, sy)),
      leave: () => this.onLeave(),
      click: (sx, sy) => this.onClick(...this.camera.toWorld(sx, sy)),
      drag: (from, to, done) => this.onDrag(this.camera.toWorld(...from), this.camera.toWorld(...to), done),
      moved: () => {
        this.invalidate();
        this.onMove();
      },
    });
  }

  /** What draws; made when there is something to draw, as that takes its time. */
  get tools() {
    if (this.made) return this.made;
    const field = document.createElement("canvas");
    const drawing = document.createElement("canvas");
    const painter = new Painter(field, this.clear);
    const context = drawing.getContext("2d", { willReadFrequently: painter.isSoftware });
    if (!context) throw new Error("this browser draws no pictures");
    // Where a processor draws, the drawing is laid over the field before the page is put together.
    this.surface.before(field, ...(painter.isSoftware ? [] : [drawing]));
    this.made = { painter, drawing, context };
    return this.made;
  }

  get painter() {
    return this.tools.painter;
  }

  get context() {
    return this.tools.context;
  }

  /** Device pixels a CSS pixel. */
  get ratio() {
    return Math.min(window.devicePixelRatio || 1, 2);
  }

  resize() {
    const { clientWidth, clientHeight } = this.box;
    if (!clientWidth || !clientHeight) return;
    const first = this.camera.width <= 1;
    const all = this.bounds && Math.abs(this.camera.kx - this.fitted) < 1e-9 * this.camera.kx;
    [this.camera.width, this.camera.height] = [clientWidth, clientHeight];
    if (this.bounds && (first || all)) this.fit(this.bounds);
    this.invalidate();
    this.onMove();
  }

  fitted = 0;

  /** Shows all of a field. @param {{x: number[], y: number[]}} bounds */
  fit(bounds) {
    this.bounds = bounds;
    this.camera.fit(bounds);
    this.fitted = this.camera.kx;
    this.invalidate();
    this.onMove();
  }

  /** Draws again with the next frame. */
  invalidate() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  draw() {
    const { camera, ratio, made } = this;
    if (camera.width <= 1 || !made) return;
    const { painter, drawing, context } = made;
    painter.begin(camera.width, camera.height, ratio);
    this.onField(ratio);
    const [w, h] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    if (drawing.width !== w || drawing.height !== h) [drawing.width, drawing.height] = [w, h];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    this.onOverlay(context);
    if (painter.isSoftware) painter.over(drawing);
    for (const done of this.drawn.splice(0)) done();
  }

  /** The picture as it stands, field and drawing. @returns {Promise<Blob>} */
  picture() {
    this.draw();
    const { painter, drawing } = this.tools;
    const sheet = document.createElement("canvas");
    [sheet.width, sheet.height] = [drawing.width, drawing.height];
    const context = sheet.getContext("2d");
    if (!context) return Promise.reject(new Error("this browser draws no pictures"));
    context.fillStyle = getComputedStyle(this.box).backgroundColor;
    context.fillRect(0, 0, sheet.width, sheet.height);
    context.drawImage(painter.canvas, 0, 0);
    if (!painter.isSoftware) context.drawImage(drawing, 0, 0);
    return new Promise((done, failed) => sheet.toBlob((blob) => (blob ? done(blob) : failed(new Error("no picture"))), "image/png"));
  }
}
