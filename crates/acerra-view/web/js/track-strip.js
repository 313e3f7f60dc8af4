// Height and deviation of the positions along the track, coloured by solution status: for scrubbing and
// for selecting a piece.

import { CHOSEN, statusColour } from "./store.js";

export class TrackStrip {
  /** @param {HTMLElement} box @param {import("./store.js").Store} store */
  constructor(box, store) {
    this.store = store;
    this.box = box;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Height and standard deviation of the positions along the track");
    box.append(this.canvas);
    /** @type {number | null} */
    this.start = null;
    new ResizeObserver(() => this.draw()).observe(box);
    store.on(["run", "engine", "pulse", "selection", "chosen"], () => this.draw());
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.start = this.pulse(event);
    });
    this.canvas.addEventListener("pointerup", (event) => {
      // A click chooses the pulse from which places are looked at.
      if (store.data && this.start !== null && this.pulse(event) === this.start) store.choose(this.start);
      this.start = null;
    });
    this.canvas.addEventListener("pointerleave", () => {
      store.pulse = null;
      store.tell("pulse");
    });
  }

  /** Rows of the table that are imaged: those of the engine's traces, all until it is ready. */
  rows() {
    const { track, trackMeta, data } = this.store;
    if (!track) return [];
    if (!data || !trackMeta) return track.position_m.map((_, k) => k);
    // The table lists the logs one after another; traces count again in each.
    const starts = track.trace.flatMap((t, k) => (k === 0 || t < track.trace[k - 1] ? [k] : []));
    const start = starts[this.store.trackNumber] ?? 0;
    const own = data.trace.slice(trackMeta.first_pulse, trackMeta.first_pulse + trackMeta.pulses);
    return own.map((trace) => start + trace - (track.trace[start] ?? 0));
  }

  /** @param {PointerEvent} event */
  pulse(event) {
    const box = this.canvas.getBoundingClientRect();
    const count = this.rows().length;
    const k = Math.floor(((event.clientX - box.left) / box.width) * count);
    return (this.store.trackMeta?.first_pulse ?? 0) + Math.min(Math.max(k, 0), count - 1);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const { store } = this;
    if (!store.data) return;
    const pulse = this.pulse(event);
    store.pulse = pulse;
    store.tell("pulse");
    if (this.start !== null && Math.abs(pulse - this.start) > 1) {
      store.selection = [Math.min(pulse, this.start), Math.max(pulse, this.start)];
      store.tell("selection");
    }
  }

  draw() {
    const { track, selection, pulse, chosen, trackMeta } = this.store;
    const [w, h] = [this.box.clientWidth, this.box.clientHeight];
    const context = this.canvas.getContext("2d");
    if (!context || !w || !h) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    [this.canvas.width, this.canvas.height] = [w * ratio, h * ratio];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const rows = this.rows();
    if (!track || rows.length < 2) return;
    const ink = getComputedStyle(this.box);
    const muted = ink.getPropertyValue("--muted");
    const x = (/** @type {number} */ k) => (k / (rows.length - 1)) * w;
    const z = rows.map((r) => track.position_m[r]?.[2] ?? NaN);
    const s = rows.map((r) => Math.hypot(...(track.sigma_m[r] ?? []).map((v) => v ?? NaN)));
    const finite = z.filter(Number.isFinite);
    const [low, high] = finite.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    const top = s.filter(Number.isFinite).reduce((a, b) => Math.max(a, b), 0);
    const yz = (/** @type {number} */ v) => h - 16 - ((v - low) / Math.max(high - low, 0.05)) * (h - 36);
    const ys = (/** @type {number} */ v) => h - 4 - (v / Math.max(top, 1e-3)) * 0.35 * (h - 20);
    context.fillStyle = muted;
    context.globalAlpha = 0.35;
    if (top > 0) {
      context.beginPath();
      context.moveTo(0, h - 4);
      s.forEach((v, k) => Number.isFinite(v) && context.lineTo(x(k), ys(v)));
      context.lineTo(w, h - 4);
      context.fill();
    }
    context.globalAlpha = 1;
    context.lineWidth = 2;
    for (let k = 1; k < rows.length; k++) {
      if (!Number.isFinite(z[k]) || !Number.isFinite(z[k - 1])) continue;
      context.strokeStyle = document.documentElement.dataset.theme === "dark" ? statusColour(track.status[rows[k]]) : `color-mix(in srgb, ${statusColour(track.status[rows[k]])} 55%, #00324a)`;
      context.beginPath();
      context.moveTo(x(k - 1), yz(z[k - 1]));
      context.lineTo(x(k), yz(z[k]));
      context.stroke();
    }
    const first = trackMeta?.first_pulse ?? 0;
    const accent = ink.getPropertyValue("--accent");
    if (selection) {
      context.fillStyle = accent;
      context.globalAlpha = 0.2;
      context.fillRect(x(selection[0] - first), 0, Math.max(2, x(selection[1] - first) - x(selection[0] - first)), h);
      context.globalAlpha = 1;
    }
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = muted;
    context.textAlign = "left";
    const statuses = [...new Set(rows.map((r) => track.status[r]).filter(Boolean))].join(", ");
    context.fillText(`height ${low.toFixed(2)} to ${high.toFixed(2)} m${top > 0 ? `, σ up to ${(1e3 * top).toFixed(0)} mm (shaded)` : ""}; ${statuses}`, 8, 14);
    if (chosen !== null) {
      context.strokeStyle = document.documentElement.dataset.theme === "dark" ? CHOSEN : `color-mix(in srgb, ${CHOSEN} 45%, #003018)`;
      context.beginPath();
      context.moveTo(x(chosen - first), 0);
      context.lineTo(x(chosen - first), h);
      context.stroke();
    }
    if (pulse !== null) {
      const k = pulse - first;
      context.strokeStyle = accent;
      context.beginPath();
      context.moveTo(x(k), 0);
      context.lineTo(x(k), h);
      context.stroke();
      if (Number.isFinite(z[k])) {
        const right = x(k) > w - 200;
        context.textAlign = right ? "right" : "left";
        const row = rows[k];
        const sigma = Number.isFinite(s[k]) ? `, σ ${(1e3 * s[k]).toFixed(0)} mm` : "";
        context.fillStyle = ink.getPropertyValue("--ink");
        context.fillText(`${track.trace[row]}: ${z[k].toFixed(3)} m, ${track.status[row]}${sigma}`, x(k) + (right ? -6 : 6), 30);
      }
    }
  }
}
