// The image: the run's own in tiles, or the one that the engine has just made, with what is marked.

import { Latest, getBytes, getJson, postImage } from "./api.js";
import { Basemap } from "./basemap.js";
import { axes, cross, label, line, ringMark } from "./drawing.js";
import { ChangingLayer, SingleLayer, TiledLayer, boundsOf } from "./layers.js";
import { palette } from "./palettes.js";
import { Pane } from "./pane.js";
import { number, readout } from "./readout.js";
import { CHOSEN, SURVEYED, statusColour } from "./store.js";
import { contoursOf, drawContours } from "./terrain.js";

/** Pixels of a live image, at most. */
const MOST_PIXELS = 480_000;
/** Nodes of the gain along each axis. */
const GAIN_NODES = 129;
const GAIN_OFF = null;

/** @typedef {{layer: TiledLayer, meta: import("./types.js").RunMeta, axes: import("./layers.js").Axes}} Shown */

/**
 * First position of each line of a track, and the one after its last: between lines nothing was measured.
 * @param {{position_m: unknown[], line_starts: number[]}} track @returns {[number, number][]}
 */
function lines(track) {
  const bounds = [0, ...track.line_starts, track.position_m.length];
  return bounds.slice(1).map((end, k) => [bounds[k], end]);
}

export class ImagePane {
  /**
   * @param {HTMLElement} box @param {HTMLElement} list @param {HTMLElement} state
   * @param {import("./store.js").Store} store @param {(error: Error) => void} failed
   */
  constructor(box, list, state, store, failed) {
    this.store = store;
    this.list = list;
    this.state = state;
    this.failed = failed;
    this.pane = new Pane(box, "Image. Arrows move, plus and minus zoom, Enter marks the middle.", { yUp: true, square: true, clear: store.runs.basemap !== null });
    this.pane.painter.foresee(0, false);
    void palette(store.look.palette);
    /** @type {Shown | null} */
    this.own = null;
    /** @type {Shown | null} */
    this.other = null;
    /** The slice shown of a volume. */
    this.slice = new ChangingLayer((index) => this.sliceLayer(index), () => this.pane.invalidate());
    /** @type {{layer: SingleLayer, zero_db: number, coherence: boolean, made: import("./types.js").Made} | null} */
    this.live = null;
    /** @type {WebGLTexture | null} */
    this.gain = GAIN_OFF;
    /** @type {WebGLTexture | null} */
    this.colours = null;
    this.blink = false;
    /** @type {Basemap | null} */
    this.basemap = null;
    this.imaging = new Latest();
    this.asking = new Latest();
    this.timer = 0;
    /** Contours of the ground. @type {ReturnType<typeof contoursOf> | null} */
    this.ground = null;
    /** @type {[number, number][]} */
    this.measured = [];
    /** @type {import("./types.js").Cursor | null} */
    this.cursor = null;
    const { pane } = this;
    pane.onField = (ratio) => this.drawField(ratio);
    pane.onOverlay = (context) => this.drawOverlay(context);
    pane.onMove = () => this.moved();
    pane.onHover = (x, y) => {
      this.ask(x, y);
      this.cut(x, y);
    };
    pane.onClick = (x, y) => this.click(x, y);
    pane.onDrag = (from, to) => this.drag(from, to);
    store.on(["look"], () => void this.recolour());
    store.on(["mark", "echo", "selection", "pulse", "chosen", "compare", "mode"], () => pane.invalidate());
    store.on(["chosen"], () => this.asked && this.ask(this.asked.x, this.asked.y, this.asked.slice));
    store.on(["selection", "edits"], () => this.changed());
    store.on(["slice"], () => {
      this.slice.show(store.sliceIndex);
      if (store.isLive) this.image();
    });
    window.setInterval(() => {
      if (store.compare.mode !== "blink") return;
      this.blink = !this.blink;
      pane.invalidate();
    }, 700);
  }

  /** Puts map tiles under the image. @param {string} template */
  underlay(template) {
    this.basemap = new Basemap(this.pane.box, template);
  }

  /** Shows a run. @param {number} run @param {import("./types.js").RunMeta} meta */
  async show(run, meta) {
    this.own?.layer.close();
    this.slice.show(null);
    this.dropLive();
    if (this.gain) this.pane.painter.forget(this.gain);
    this.gain = GAIN_OFF;
    this.own = this.layerOf(run, meta);
    this.pane.fit(boundsOf(this.own.axes));
    // The tiles come while colours and programs are made.
    if (this.pane.camera.width > 1) this.own.layer.ready(this.pane.camera, this.pane.ratio);
    await this.recolour();
    this.ground = null;
    if (this.store.hasTerrain) void this.contours(run, meta);
    if (meta.display.gain) {
      const nodes = new Float32Array(await getBytes(`api/run/${run}/gain`));
      this.gain = this.pane.painter.nodes(GAIN_NODES, nodes);
      this.pane.invalidate();
    }
  }

  /** Draws the ground under the image. @param {number} run @param {import("./types.js").RunMeta} meta */
  async contours(run, meta) {
    try {
      const terrain = await getJson(`api/run/${run}/terrain`);
      if (this.store.run === run) this.ground = contoursOf(terrain, meta.grid);
      this.pane.invalidate();
    } catch (error) {
      this.failed(/** @type {Error} */ (error));
    }
  }

  /** Sets another run beside it. @param {number} run @param {import("./types.js").RunMeta | null} meta */
  setOther(run, meta) {
    this.other?.layer.close();
    this.other = meta ? this.layerOf(run, meta) : null;
    this.pane.invalidate();
  }

  /** Whether a difference of the two runs means anything: the same pixels. */
  get comparable() {
    const [a, b] = [this.own?.axes, this.other?.axes];
    return !!a && !!b && a.nx === b.nx && a.ny === b.ny && Math.abs(a.x0 - b.x0) + Math.abs(a.y0 - b.y0) + Math.abs(a.dx - b.dx) < 1e-6;
  }

  /** @param {number} run @param {import("./types.js").RunMeta} meta @returns {Shown} */
  layerOf(run, meta) {
    const { grid } = meta;
    const own = { x0: grid.x0_m, dx: grid.pixel_m, nx: grid.nx, y0: grid.y0_m, dy: grid.pixel_m, ny: grid.ny };
    const path = (/** @type {number} */ level, /** @type {number} */ column, /** @type {number} */ row) => `api/run/${run}/image/${level}/${column}/${row}`;
    const source = { size: this.store.runs.tile, levels: meta.levels, half: true, path };
    return { meta, axes: own, layer: new TiledLayer(this.pane.painter, own, source, () => this.pane.invalidate(), this.failed) };
  }

  /** @param {number} index */
  sliceLayer(index) {
    const { store } = this;
    const { run } = store;
    const own = /** @type {Shown} */ (this.own);
    const path = (/** @type {number} */ level, /** @type {number} */ column, /** @type {number} */ row) => `api/run/${run}/volume/z/${index}/${level}/${column}/${row}`;
    const source = { size: store.runs.tile, levels: own.meta.volume?.levels.z ?? 1, half: true, path };
    return new TiledLayer(this.pane.painter, own.axes, source, () => this.pane.invalidate(), this.failed);
  }

  async recolour() {
    const { look } = this.store;
    const wanted = this.store.compare.mode === "difference" ? "bluered" : look.mode === "phase" ? "phase" : look.palette;
    const table = await palette(wanted);
    if (this.colours) this.pane.painter.forget(this.colours);
    this.colours = this.pane.painter.colours(table);
    this.pane.invalidate();
  }

  /** @param {import("./types.js").Display} display */
  zero(display) {
    return this.usesGain ? display.zero_db : display.maximum_db;
  }

  get usesGain() {
    // The gain is that of the image's own heights.
    return this.store.look.gain && this.gain !== null && this.store.sliceIndex === null;
  }

  /** @param {number} ratio */
  drawField(ratio) {
    const { own, colours, store, other } = this;
    if (!own || !colours) return;
    const { painter, camera } = this.pane;
    this.basemap?.draw(camera, own.meta.origin_deg_m);
    if (!store.look.layers.image) return;
    const { compare } = store;
    const mode = store.look.mode === "phase" ? 1 : 0;
    const liveMode = this.live?.coherence ? 4 : mode;
    const base = { mode, window: store.look.window, other_zero_db: 0, gain: this.usesGain ? this.gain : null, colours, opacity: this.basemap ? store.look.opacity : 1 };
    // Tiles hold values of another scale.
    const zero_db = this.zero(own.meta.display) - own.meta.display.half_db;
    const other_zero_db = other ? other.meta.display.maximum_db - other.meta.display.half_db : 0;
    if (compare.mode === "difference" && other && this.comparable && !this.live) {
      const span = -store.look.window[0] / 2;
      painter.look({ ...base, mode: 3, gain: null, window: [-span, span], zero_db: own.meta.display.maximum_db - own.meta.display.half_db, other_zero_db });
      own.layer.draw(camera, ratio, other.layer);
      return;
    }
    const showOther = other && (compare.mode === "swipe" || (compare.mode === "blink" && this.blink));
    painter.look({ ...base, zero_db, opacity: base.opacity * (this.live ? 0.25 : 1) });
    (store.sliceIndex === null ? own.layer : this.slice).draw(camera, ratio);
    if (this.live) {
      painter.look({ ...base, mode: liveMode, zero_db: this.live.zero_db });
      this.live.layer.draw(camera, own.axes);
    }
    if (showOther) {
      if (compare.mode === "swipe") painter.within(compare.share, 1);
      painter.look({ ...base, gain: null, zero_db: other_zero_db });
      other.layer.draw(camera, ratio);
    }
  }

  /** @param {CanvasRenderingContext2D} c */
  drawOverlay(c) {
    const { camera } = this.pane;
    const { store } = this;
    const at = (/** @type {number[]} */ p) => camera.toScreen(p[0], p[1]);
    if (this.ground && store.look.contours) drawContours(c, camera, this.ground.contours);
    const { layers } = store.look;
    if (layers.track) this.drawTrack(c);
    this.drawPlatform(c);
    if (store.echo) line(c, store.echo.places_m.map(at), CHOSEN, { width: 2 });
    (layers.targets ? (store.meta?.targets.targets ?? []) : []).forEach((target, k) => {
      const [x, y] = camera.toScreen(target.x_m, target.y_m);
      ringMark(c, x, y, 9, "#ffffff");
      label(c, `${k + 1}`, x + 13, y - 6);
    });
    for (const point of layers.surveyed ? (store.meta?.targets.surveyed ?? []) : []) {
      const [x, y] = camera.toScreen(point.x_m, point.y_m);
      cross(c, x, y, SURVEYED);
      label(c, point.name, x + 13, y + 14, { colour: SURVEYED });
    }
    if (store.mark) cross(c, ...camera.toScreen(store.mark.x, store.mark.y), "#ffe14d");
    if (this.measured.length === 2) this.drawMeasure(c);
    axes(c, camera, { x: "east x / m", y: "north y / m" });
    const { compare } = store;
    if (compare.mode === "swipe") {
      const x = compare.share * camera.width;
      line(c, [[x, 0], [x, camera.height]], "#ffffff");
      label(c, store.runs.runs[store.run]?.name ?? "", x - 8, 32, { align: "right" });
      label(c, store.runs.runs[compare.run]?.name ?? "", x + 8, 32);
    } else if (compare.mode === "blink") {
      label(c, store.runs.runs[this.blink ? compare.run : store.run]?.name ?? "", camera.width / 2, 32, { align: "center" });
    }
  }

  /** The track coloured by its fixes, the selected piece thick. @param {CanvasRenderingContext2D} c */
  drawTrack(c) {
    const { track, data, selection } = this.store;
    const { camera } = this.pane;
    const at = (/** @type {(number | null)[]} */ p) => (p[0] === null || p[1] === null ? [NaN, NaN] : camera.toScreen(p[0], p[1]));
    if (track) {
      const stride = Math.max(1, Math.ceil(track.position_m.length / 4000));
      for (const [first, end] of lines(track)) {
        let from = first;
        for (let k = first + stride; k < end + stride; k += stride) {
          const to = Math.min(k, end - 1);
          const last = k >= end - 1;
          if (!last && track.status[k] === track.status[from]) continue;
          const piece = [];
          for (let j = from; j < to; j += stride) piece.push(at(track.position_m[j]));
          piece.push(at(track.position_m[to]));
          line(c, piece, statusColour(track.status[from]), { width: 2 });
          if (last) break;
          from = k;
        }
      }
    }
    if (data && selection) {
      const [from, to] = selection;
      for (const [first, end] of lines(data)) {
        const piece = data.position_m.slice(Math.max(first, from), Math.max(first, Math.min(end, to + 1)));
        line(c, piece.map(at), "#ffffff", { width: 5 });
      }
    }
  }

  /** The platform at the pulse under the pointer and at the chosen one. @param {CanvasRenderingContext2D} c */
  drawPlatform(c) {
    const { data, pulse, chosen } = this.store;
    const { camera } = this.pane;
    for (const [one, colour] of /** @type {[number | null, string][]} */ ([[pulse, "#ffffff"], [chosen, CHOSEN]])) {
      const place = one === null ? null : data?.position_m[one];
      if (place) ringMark(c, ...camera.toScreen(place[0], place[1]), 5, colour, true);
    }
  }

  /** @param {CanvasRenderingContext2D} c */
  drawMeasure(c) {
    const [a, b] = this.measured;
    const [from, to] = [this.pane.camera.toScreen(...a), this.pane.camera.toScreen(...b)];
    line(c, [from, to], "#ffe14d");
    for (const p of [from, to]) ringMark(c, p[0], p[1], 3, "#ffe14d", true);
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const azimuth = ((Math.atan2(dx, dy) * 180) / Math.PI + 360) % 360;
    label(c, `${Math.hypot(dx, dy).toFixed(3)} m, azimuth ${azimuth.toFixed(1)}°`, (from[0] + to[0]) / 2 + 8, (from[1] + to[1]) / 2 - 8, { colour: "#ffe14d" });
  }

  /** @param {[number, number]} from @param {[number, number]} to */
  drag(from, to) {
    if (this.store.compare.mode === "swipe") {
      const [sx] = this.pane.camera.toScreen(...from);
      const share = this.store.compare.share;
      if (this.swiping || Math.abs(sx - share * this.pane.camera.width) < 14) {
        this.swiping = true;
        window.addEventListener("pointerup", () => (this.swiping = false), { once: true });
        this.store.compare.share = Math.min(Math.max(this.pane.camera.toScreen(...to)[0] / this.pane.camera.width, 0), 1);
        this.pane.invalidate();
        return true;
      }
    }
    if (this.store.mode !== "measure") return false;
    this.measured = [from, to];
    this.pane.invalidate();
    return true;
  }

  swiping = false;

  /** Marks a place, and asks for its echoes. @param {number} x @param {number} y */
  click(x, y) {
    this.ask(x, y);
    void this.mark(x, y);
  }

  /** @param {number} x @param {number} y */
  async mark(x, y) {
    const { store } = this;
    const mark = { x, y, hyperbola: /** @type {import("./types.js").Hyperbola | null} */ (null) };
    store.mark = mark;
    store.tell("mark");
    if (!store.data) return;
    try {
      const height = await this.height(x, y);
      mark.hyperbola = await getJson(`api/run/${store.run}/hyperbola?x_m=${x}&y_m=${y}${height === null ? "" : `&z_m=${height}`}`);
      if (store.mark === mark) store.tell("mark");
    } catch (error) {
      this.failed(/** @type {Error} */ (error));
    }
  }

  /** The height of what is shown of a volume at a place; none where it stands on the ground. @param {number} x @param {number} y @returns {Promise<number | null>} */
  async height(x, y) {
    const { store } = this;
    if (store.slice !== null) return store.slice;
    if (!store.meta?.volume) return null;
    return (await getJson(`api/run/${store.run}/cursor?x_m=${x}&y_m=${y}`)).place_m[2];
  }

  /** Cuts a volume at a place, unless one is marked. @param {number} x @param {number} y */
  cut(x, y) {
    const { store } = this;
    if (!store.meta?.volume || store.mark) return;
    store.cut = { x, y };
    store.tell("cut");
  }

  /** Asks for what is under the pointer. @param {number} x @param {number} y @param {number | null} [slice] of a volume */
  ask(x, y, slice = this.store.sliceIndex) {
    const { store } = this;
    this.asking.run(async () => {
      try {
        const height = slice !== null ? `&slice=${slice}` : store.slice !== null ? `&z_m=${store.slice}` : "";
        const pulse = store.chosen === null ? "" : `&pulse=${store.chosen}`;
        this.cursor = await getJson(`api/run/${store.run}/cursor?x_m=${x}&y_m=${y}${height}${pulse}`);
        this.asked = { x, y, slice };
        this.tellCursor();
      } catch (error) {
        this.failed(/** @type {Error} */ (error));
      }
    });
  }

  /** Where the cursor is. @type {{x: number, y: number, slice: number | null} | null} */
  asked = null;

  tellCursor() {
    const { cursor, live } = this;
    if (!cursor) return;
    const [x, y, z] = cursor.place_m;
    const place = cursor.place_deg_m;
    // A new image stands at one height: the run's, or that of the slice shown.
    const isShown = this.asked?.slice === this.store.sliceIndex;
    const value = (isShown && live?.layer.value(x, y)) || null;
    const coherence = value && live?.coherence ? Math.hypot(value[0], value[1]) : null;
    const level = coherence !== null ? null : value && live ? 20 * Math.log10(Math.hypot(value[0], value[1])) - live.zero_db : cursor.level_db;
    const phase = value ? (Math.atan2(value[1], value[0]) * 180) / Math.PI : cursor.phase_deg;
    readout(this.list, [
      ["x", number(x, 3, "m")],
      ["y", number(y, 3, "m")],
      ["z", number(z, 3, "m")],
      ["latitude", place && number(place[0], 8, "°")],
      ["longitude", place && number(place[1], 8, "°")],
      ["level", coherence === null ? number(level, 2, "dB") : null],
      ["coherence", coherence === null ? null : number(coherence, 3)],
      ["phase", number(phase, 1, "°")],
      ["range", cursor.seen && number(cursor.seen.range_m, 3, "m")],
      ["incidence", cursor.seen && number(cursor.seen.incidence_deg, 1, "°")],
      [this.store.chosen === null ? "nearest trace" : "chosen trace", cursor.seen && `${cursor.seen.trace}`],
    ]);
  }

  /** Settings or selection are others. */
  changed() {
    if (!this.store.isLive) {
      this.dropLive();
      this.state.textContent = "";
      this.pane.invalidate();
      this.restore();
      return;
    }
    this.image();
  }

  /** Brings the radargram back to the run's settings. */
  restore() {
    const { store } = this;
    this.imaging.run(async () => {
      if (store.isLive || !store.data || store.data.revision === 0) return;
      try {
        const view = { ...this.view(), nx: 1, ny: 1 };
        this.revision = (await postImage(store.run, { view, edits: {}, pulses: null })).revision;
        store.tell("live");
      } catch (error) {
        this.failed(/** @type {Error} */ (error));
      }
    });
  }

  /** The settings' number behind the engine's last answer. */
  revision = 0;

  moved() {
    if (!this.store.isLive) return;
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.image(), 120);
  }

  dropLive() {
    this.live?.layer.close();
    this.live = null;
  }

  /** The pixels in view. @returns {import("./types.js").View} */
  view() {
    const { camera } = this.pane;
    const { x, y } = camera.view();
    const coarse = Math.max(1, Math.sqrt((camera.width * camera.height) / MOST_PIXELS));
    const pixel_m = coarse / camera.kx;
    const count = (/** @type {number[]} */ v) => Math.max(1, Math.floor((v[1] - v[0]) / pixel_m));
    return { x0_m: x[0] + 0.5 * pixel_m, y0_m: y[0] + 0.5 * pixel_m, pixel_m, nx: count(x), ny: count(y), ...(this.store.slice === null ? {} : { z_m: this.store.slice }) };
  }

  /** Makes the image of what is in view. */
  image() {
    const { store } = this;
    if (!store.data || !this.own) return;
    this.imaging.run(async () => {
      if (!store.isLive || !store.meta) return;
      const view = this.view();
      const start = performance.now();
      this.state.textContent = "imaging …";
      try {
        const coherence = store.look.mode === "coherence";
        const made = await postImage(store.run, { view, edits: store.edits, pulses: store.selection, coherence });
        if (!store.isLive) return;
        const axesOf = { x0: view.x0_m, dx: view.pixel_m, nx: view.nx, y0: view.y0_m, dy: view.pixel_m, ny: view.ny };
        this.dropLive();
        this.live = { layer: new SingleLayer(this.pane.painter, axesOf, made.values), made, coherence, zero_db: this.zero(store.meta.display) };
        this.revision = made.revision;
        const ms = performance.now() - start;
        this.state.textContent = `${store.selection ? `pulses ${store.selection[0]}–${store.selection[1]}, ` : ""}${view.nx} × ${view.ny} pixels in ${ms.toFixed(0)} ms`;
        this.state.dataset.ms = ms.toFixed(0);
        store.tell("live");
        this.tellCursor();
      } catch (error) {
        this.state.textContent = "";
        this.failed(/** @type {Error} */ (error));
      }
      this.pane.invalidate();
    });
  }
}
