// What is shown at the moment, and who wants to hear when it changes.

/** @typedef {"image" | "track" | "targets" | "surveyed"} Layer */
/** @typedef {{palette: string, mode: "level" | "phase" | "coherence", window: [number, number], gain: boolean, radargram: "level" | "signed", radargramGain: number, opacity: number, contours: boolean, layers: Record<Layer, boolean>}} Look */
/** @typedef {{mode: "off" | "swipe" | "blink" | "difference", run: number, share: number}} Compare */
/** @typedef {"run" | "engine" | "look" | "mark" | "echo" | "selection" | "edits" | "pulse" | "compare" | "live" | "mode" | "slice" | "cut" | "chosen"} Topic */

export class Store {
  constructor() {
    this.run = 0;
    /** @type {import("./types.js").Runs} */
    this.runs = { version: "", runs: [], basemap: null, tile: 256 };
    /** @type {import("./types.js").RunMeta | null} */
    this.meta = null;
    /** @type {import("./types.js").Track | null} */
    this.track = null;
    /** @type {import("./types.js").EngineStatus} */
    this.engine = { state: "idle" };
    /** @type {Look} */
    this.look = { palette: "inferno", mode: "level", window: [-40, 0], gain: true, radargram: "level", radargramGain: 0, opacity: 0.75, contours: true, layers: { image: true, track: true, targets: true, surveyed: true } };
    /** @type {Compare} */
    this.compare = { mode: "off", run: 0, share: 0.5 };
    /** The place marked on the image, and its echoes. @type {{x: number, y: number, hyperbola: import("./types.js").Hyperbola | null} | null} */
    this.mark = null;
    /** The echo marked on the radargram, and its places. @type {import("./types.js").Ring | null} */
    this.echo = null;
    /** First and last pulse selected. @type {[number, number] | null} */
    this.selection = null;
    /** @type {import("./types.js").Edits} */
    this.edits = {};
    /** Height of the slice shown of a volume (m); none where the image is. @type {number | null} */
    this.slice = null;
    /** Where a volume is cut: the place under the pointer, or the one marked. @type {{x: number, y: number} | null} */
    this.cut = null;
    /** The pulse under the pointer. @type {number | null} */
    this.pulse = null;
    /** The pulse from which places are looked at; the nearest where none is chosen. @type {number | null} */
    this.chosen = null;
    /** What a drag does. @type {"move" | "select" | "measure"} */
    this.mode = "move";
    /** The radargram's track. */
    this.trackNumber = 0;
    /** @type {Map<Topic, (() => void)[]>} */
    this.listeners = new Map();
  }

  /** @param {Topic[]} topics @param {() => void} listener */
  on(topics, listener) {
    for (const topic of topics) this.listeners.set(topic, [...(this.listeners.get(topic) ?? []), listener]);
  }

  /** @param {Topic[]} topics */
  tell(...topics) {
    const heard = new Set(topics.flatMap((topic) => this.listeners.get(topic) ?? []));
    for (const listener of heard) listener();
  }

  /** Data of the engine, once it is ready. */
  get data() {
    return this.engine.data ?? null;
  }

  /** The track of which the radargram is shown. */
  get trackMeta() {
    return this.data?.tracks[this.trackNumber] ?? null;
  }

  /** Looks at places from a pulse, or from the nearest. @param {number | null} pulse */
  choose(pulse) {
    this.chosen = pulse;
    this.tell("chosen");
  }

  /** The number of the slice shown of the run's volume. */
  get sliceIndex() {
    const volume = this.meta?.volume;
    if (!volume || this.slice === null) return null;
    return Math.min(Math.max(Math.round((this.slice - volume.z0_m) / volume.step_m), 0), volume.slices - 1);
  }

  /** Shows a slice of the run's volume, or none of them. @param {number | null} index */
  showSlice(index) {
    const volume = this.meta?.volume;
    if (!volume) return;
    this.slice = index === null ? null : volume.z0_m + Math.min(Math.max(index, 0), volume.slices - 1) * volume.step_m;
    this.tell("slice");
  }

  /** Whether the image stands on terrain: heights of a volume's image are those of its strongest values. */
  get hasTerrain() {
    return !!this.meta?.grid.uneven && !this.meta.volume;
  }

  /** Whether the image shown is made again. A slice is too, where the run has left no volume. */
  get isLive() {
    const isNewSlice = this.slice !== null && !this.meta?.volume;
    return this.selection !== null || isNewSlice || this.look.mode === "coherence" || Object.keys(this.edits).length > 0;
  }
}

/** Colour of the pulse from which places are looked at, and of its echoes' places. */
export const CHOSEN = "#7cf29c";
/** Colour of surveyed points. */
export const SURVEYED = "#6fd8ff";

/** Colours of solution statuses, told apart by lightness as well. */
const STATUS = /** @type {Record<string, string>} */ ({
  fixed: "#4dd0e1", float: "#ffb74d", single: "#ff6e6e", dgps: "#ffe082", sbas: "#ffe082", ppp: "#b39ddb", external: "#cfd8dc",
});

/** @param {string} status */
export function statusColour(status) {
  return STATUS[status] ?? "#cfd8dc";
}
