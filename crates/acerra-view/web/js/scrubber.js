// A slider along the flight: chooses the pulse that radargram, map and sky show.

import { element, number } from "./readout.js";

export class Scrubber {
  /** @param {import("./store.js").Store} store */
  constructor(store) {
    this.store = store;
    this.input = element("scrubber", HTMLInputElement);
    this.output = element("scrubber-at", HTMLOutputElement);
    this.input.addEventListener("input", () => store.choose(this.first + Number(this.input.value)));
    store.on(["run", "engine", "chosen"], () => this.show());
    this.show();
  }

  /** The first pulse of the track shown. */
  get first() {
    return this.store.trackMeta?.first_pulse ?? 0;
  }

  /** Chooses the pulse so many after the chosen one; the first where none is. @param {number} count */
  step(count) {
    const { chosen, trackMeta } = this.store;
    if (!trackMeta?.pulses) return;
    const from = chosen === null ? 0 : chosen - this.first + count;
    this.store.choose(this.first + Math.min(Math.max(from, 0), trackMeta.pulses - 1));
  }

  /** Follows what is chosen, wherever that was done. */
  show() {
    const { chosen, trackMeta } = this.store;
    const count = trackMeta?.pulses ?? 0;
    this.input.disabled = count === 0;
    this.input.max = String(Math.max(count - 1, 0));
    const isOwn = chosen !== null && chosen >= this.first && chosen < this.first + count;
    this.input.value = isOwn ? String(chosen - this.first) : "0";
    this.output.textContent = isOwn ? this.described(chosen) : "";
    this.input.setAttribute("aria-valuetext", this.output.textContent || "no trace chosen");
  }

  /** @param {number} pulse */
  described(pulse) {
    const { data } = this.store;
    if (!data) return "";
    const [x, y, z] = data.position_m[pulse].map((v) => number(v, 2));
    return `trace ${data.trace[pulse]}, ${number(data.time_s[pulse], 3, "s")}: x ${x}, y ${y}, z ${z} m`;
  }
}
