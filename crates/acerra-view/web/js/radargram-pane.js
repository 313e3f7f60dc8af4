// The radargram of a track: a column a pulse, fast time downwards.

import { Latest, getJson } from "./api.js";
import { axes, cross, line, ringMark } from "./drawing.js";
import { TiledLayer, boundsOf } from "./layers.js";
import { palette } from "./palettes.js";
import { Pane } from "./pane.js";
import { depthOf, opticalOf } from "./depth.js";
import { number, readout } from "./readout.js";
import { CHOSEN } from "./store.js";

/** Lowest levels shown, as in the run's own pictures. */
const FLOOR_DB = { clean: -50, raw: -80 };

export class RadargramPane {
  /**
   * @param {HTMLElement} box @param {HTMLElement} list @param {import("./store.js").Store} store
   * @param {(error: Error) => void} failed
   */
  constructor(box, list, store, failed) {
    this.store = store;
    this.list = list;
    this.failed = failed;
    this.empty = document.createElement("p");
    this.empty.className = "empty";
    this.pane = new Pane(box, "Radargram. Arrows move, plus and minus zoom, Enter marks the echo in the middle.", { yUp: false, square: false });
    box.append(this.empty);
    /** @type {TiledLayer | null} */
    this.layer = null;
    /** @type {"clean" | "raw"} */
    this.stage = "clean";
    /** What the layer shows: run, track, stage and settings. */
    this.shown = "";
    /** @type {WebGLTexture | null} */
    this.colours = null;
    /** @type {WebGLTexture | null} */
    this.gain = null;
    this.gainShown = 0;
    this.selecting = new Latest();
    this.asking = new Latest();
    const { pane } = this;
    pane.onField = (ratio) => this.drawField(ratio);
    pane.onOverlay = (context) => this.drawOverlay(context);
    pane.onHover = (x, y) => this.hover(x, y);
    pane.onLeave = () => this.point(null);
    pane.onClick = (x, y) => this.click(x, y);
    pane.onDrag = (from, to, done) => this.drag(from, to, done);
    store.on(["engine"], () => this.refresh());
    store.on(["look"], () => void this.recolour());
    store.on(["chosen"], () => this.reveal());
    store.on(["mark", "echo", "selection", "pulse", "chosen"], () => pane.invalidate());
  }

  get meta() {
    return this.store.trackMeta?.radargram ?? null;
  }

  /** Shows the radargram of the settings in force. */
  refresh() {
    const { store, meta } = this;
    const told = { idle: "", reading: "Reading the logs of the run …", ready: "The log of this track holds spectra: there is no radargram.", failed: `No radargram: ${store.engine.reason ?? ""}` };
    this.empty.textContent = meta ? "" : told[store.engine.state];
    const wanted = meta ? [store.run, store.trackNumber, this.stage, store.data?.revision].join("/") : "";
    if (wanted === this.shown) return;
    const same = this.shown.split("/").slice(0, 2).join() === wanted.split("/").slice(0, 2).join() && this.layer;
    this.shown = wanted;
    this.layer?.close();
    this.layer = null;
    if (meta) {
      const own = { x0: 0, dx: 1, nx: meta.traces, y0: meta.fast_time_start_ns, dy: meta.fast_time_step_ns, ny: meta.samples };
      const path = (/** @type {number} */ level, /** @type {number} */ column, /** @type {number} */ row) => `api/run/${store.run}/radargram/${store.trackNumber}/${this.stage}/${level}/${column}/${row}`;
      const source = { size: store.runs.tile, levels: meta.levels, path };
      this.layer = new TiledLayer(this.pane.painter, own, source, () => this.pane.invalidate(), this.failed);
      if (!same) this.pane.fit(this.interesting());
    }
    void this.recolour();
  }

  /** The whole radargram; of a gated one what the gate lets through. */
  interesting() {
    const { layer, meta, store } = this;
    if (!layer || !meta) return { x: [0, 1], y: [0, 1] };
    const all = boundsOf(layer.axes);
    const track = store.trackMeta;
    if (!meta.gate_ns || this.stage !== "clean" || !track || !store.data) return all;
    const own = store.data.height_m.slice(track.first_pulse, track.first_pulse + track.pulses);
    const ns = (/** @type {number} */ h) => (2e9 * h) / (store.data?.light_speed_m_s ?? 299792458);
    const [low, high] = own.reduce(([a, b], h) => [Math.min(a, h), Math.max(b, h)], [Infinity, -Infinity]);
    return { x: all.x, y: [Math.max(all.y[0], ns(low) + meta.gate_ns[0] - 2), Math.min(all.y[1], ns(high) + meta.gate_ns[1] + 2)] };
  }

  async recolour() {
    const { look } = this.store;
    if (!this.layer) return;
    const table = await palette(look.radargram === "signed" ? "bluered" : look.palette);
    if (this.colours) this.pane.painter.forget(this.colours);
    this.colours = this.pane.painter.colours(table);
    this.pane.invalidate();
  }

  get maximum() {
    const { meta } = this;
    return (meta && (this.stage === "raw" ? meta.maximum_raw : meta.maximum_clean)) || 1;
  }

  /** @param {number} ratio */
  drawField(ratio) {
    const { layer, colours, store } = this;
    if (!layer || !colours) return;
    const signed = store.look.radargram === "signed";
    /** @type {[number, number]} */
    const window = signed ? [0, 0.25 * this.maximum] : [FLOOR_DB[this.stage], 0];
    this.pane.painter.look({ mode: signed ? 2 : 0, window, zero_db: 20 * Math.log10(this.maximum), other_zero_db: 0, gain: this.gainTexture(), colours, opacity: 1 });
    layer.draw(this.pane.camera, ratio);
  }

  /** The gain that the display adds from the first sample to the last, if any. */
  gainTexture() {
    const { painter } = this.pane;
    const { radargramGain } = this.store.look;
    if (this.gainShown !== radargramGain) {
      if (this.gain) painter.forget(this.gain);
      this.gain = radargramGain > 0 ? painter.nodes(2, new Float32Array([0, 0, radargramGain, radargramGain])) : null;
      this.gainShown = radargramGain;
    }
    return this.gain;
  }

  /** @param {CanvasRenderingContext2D} c */
  drawOverlay(c) {
    const { store, layer } = this;
    const { camera } = this.pane;
    const track = store.trackMeta;
    if (!layer || !track || !store.data) return;
    const { first_pulse: first, pulses } = track;
    const column = (/** @type {number} */ pulse) => pulse - first;
    this.drawSurface(c);
    if (store.selection) {
      const [a, b] = store.selection.map((p) => camera.toScreen(column(p), 0)[0]);
      c.fillStyle = "rgba(8, 11, 15, 0.55)";
      c.fillRect(0, 0, Math.max(0, a), camera.height);
      c.fillRect(b, 0, Math.max(0, camera.width - b), camera.height);
      for (const x of [a, b]) line(c, [[x, 0], [x, camera.height]], "#ffffff", { width: 1.5 });
    }
    const echoes = store.mark?.hyperbola;
    if (echoes) {
      const own = echoes.fast_time_ns.slice(first, first + pulses);
      line(c, own.map((t, k) => camera.toScreen(k, t)), "#ffe14d");
      if (echoes.apex !== null && echoes.apex >= first && echoes.apex < first + pulses) {
        ringMark(c, ...camera.toScreen(column(echoes.apex), echoes.fast_time_ns[echoes.apex]), 5, "#ffe14d", true);
      }
    }
    if (store.echo && this.echoTime !== null) cross(c, ...camera.toScreen(column(store.echo.pulse), this.echoTime), "#7cf29c");
    for (const [pulse, colour] of /** @type {[number | null, string][]} */ ([[store.pulse, "rgba(255,255,255,0.5)"], [store.chosen, CHOSEN]])) {
      if (pulse === null) continue;
      const [x] = camera.toScreen(column(pulse), 0);
      line(c, [[x, 0], [x, camera.height]], colour, { width: 1 });
    }
    axes(c, camera, { x: "trace", y: "fast time / ns" }, this.traceNumbers(track, store.data.trace), this.rangeAxis());
  }

  /** Range from the antenna, or with ground the depth below the median height of the track. */
  rangeAxis() {
    const { trackMeta: track, data } = this.store;
    if (!track || !data) return undefined;
    const perNs = 0.5e-9 * data.light_speed_m_s;
    if (!data.soil.length) return { name: "range / m", numbers: { value: (/** @type {number} */ y) => y * perNs, place: (/** @type {number} */ r) => r / perNs } };
    const heights = data.height_m.slice(track.first_pulse, track.first_pulse + track.pulses).sort((a, b) => a - b);
    const height = heights[heights.length >> 1] ?? 0;
    const numbers = {
      value: (/** @type {number} */ y) => depthOf(y * perNs - height, data.soil),
      place: (/** @type {number} */ depth) => (height + opticalOf(depth, data.soil)) / perNs,
    };
    return { name: `depth / m from ${number(height, 2, "m")} height`, numbers };
  }

  /**
   * The numbers of the traces in the log, which the readout has as well, for columns of the radargram.
   * @param {import("./types.js").TrackMeta} track @param {number[]} trace
   */
  traceNumbers({ first_pulse: first, pulses }, trace) {
    const at = (/** @type {number} */ column) => trace[first + Math.min(Math.max(Math.round(column), 0), pulses - 1)];
    return {
      // Beyond the radargram the count goes on.
      value: (/** @type {number} */ x) => at(x) + (x < 0 ? x : Math.max(0, x - (pulses - 1))),
      place: (/** @type {number} */ value) => {
        if (value < at(0)) return value - at(0);
        if (value > at(pulses - 1)) return pulses - 1 + value - at(pulses - 1);
        let [low, high] = [0, pulses - 1];
        while (low < high) {
          const middle = (low + high) >> 1;
          if (at(middle) < value) low = middle + 1;
          else high = middle;
        }
        return low;
      },
    };
  }

  /** Two-way time to the ground below. @param {CanvasRenderingContext2D} c */
  drawSurface(c) {
    const { store } = this;
    const track = store.trackMeta;
    if (!track || !store.data) return;
    const own = store.data.height_m.slice(track.first_pulse, track.first_pulse + track.pulses);
    const speed = store.data.light_speed_m_s;
    const stride = Math.max(1, Math.floor(own.length / 2000));
    const points = own.map((h, k) => [k, (2e9 * h) / speed]).filter((_, k) => k % stride === 0);
    line(c, points.map(([k, t]) => this.pane.camera.toScreen(k, t)), "rgba(255,255,255,0.75)", { width: 1, dash: [5, 5] });
  }

  /** @type {number | null} */
  echoTime = null;

  /** The pulse of a column, if there is one. @param {number} x */
  pulseAt(x) {
    const track = this.store.trackMeta;
    const k = Math.round(x);
    return track && k >= 0 && k < track.pulses ? track.first_pulse + k : null;
  }

  /** Brings the chosen pulse into view. */
  reveal() {
    const { chosen, trackMeta } = this.store;
    const { camera } = this.pane;
    if (chosen === null || !trackMeta) return;
    const column = chosen - trackMeta.first_pulse;
    const [x] = camera.toScreen(column, 0);
    if (column >= 0 && column < trackMeta.pulses && (x < 0 || x > camera.width)) camera.x = column;
  }

  /** @param {number | null} pulse */
  point(pulse) {
    if (this.store.pulse === pulse) return;
    this.store.pulse = pulse;
    this.store.tell("pulse");
  }

  /** @param {number} x @param {number} y */
  hover(x, y) {
    const pulse = this.pulseAt(x);
    this.point(pulse);
    const { data } = this.store;
    const { meta, layer } = this;
    if (pulse === null || !data || !meta || !layer) return;
    const sample = Math.round((y - meta.fast_time_start_ns) / meta.fast_time_step_ns);
    const within = sample >= 0 && sample < meta.samples;
    const value = within ? layer.tiles.value(Math.round(x), sample) : null;
    const range = (y * 1e-9 * data.light_speed_m_s) / 2;
    const depth = depthOf(range - data.height_m[pulse], data.soil);
    const echoes = this.store.mark?.hyperbola ?? null;
    const modulus = value ? Math.hypot(value[0], value[1]) : null;
    readout(this.list, [
      ["trace", `${data.trace[pulse]}`],
      ["time", number(data.time_s[pulse], 3, "s")],
      ["fast time", number(y, 3, "ns")],
      ["range", number(range, 3, "m")],
      ["below ground", number(depth, 3, "m")],
      ["amplitude", value ? value[0].toPrecision(4) : "–"],
      ["level", modulus ? number(20 * Math.log10(modulus / this.maximum), 1, "dB") : "–"],
      ["echo of the mark", echoes && number(echoes.fast_time_ns[pulse], 3, "ns")],
      ["its incidence", echoes && number(echoes.incidence_deg[pulse], 1, "°")],
    ]);
  }

  /** Marks an echo, and asks for its places. @param {number} x @param {number} y */
  click(x, y) {
    const pulse = this.pulseAt(x);
    if (pulse === null) return;
    this.hover(x, y);
    const { store } = this;
    store.choose(pulse);
    this.asking.run(async () => {
      try {
        store.echo = await getJson(`api/run/${store.run}/ring?pulse=${pulse}&fast_time_ns=${y}`);
        this.echoTime = y;
        store.tell("echo");
      } catch (error) {
        this.failed(/** @type {Error} */ (error));
      }
    });
  }

  /** @param {[number, number]} from @param {[number, number]} to @param {boolean} done */
  drag(from, to, done) {
    const track = this.store.trackMeta;
    if (this.store.mode !== "select" || !track) return false;
    const last = track.first_pulse + track.pulses - 1;
    const within = (/** @type {number} */ x) => Math.min(Math.max(track.first_pulse + Math.round(x), track.first_pulse), last);
    this.select([within(Math.min(from[0], to[0])), within(Math.max(from[0], to[0]))], done);
    return true;
  }

  /** @param {[number, number]} pulses @param {boolean} done */
  select(pulses, done) {
    const before = this.store.selection;
    if (!done && before && before[0] === pulses[0] && before[1] === pulses[1]) return;
    this.store.selection = pulses;
    this.store.tell("selection");
  }
}
