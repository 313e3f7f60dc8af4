// The satellites of the track's GNSS log at the pulse shown: sky plot, C/N₀ over the flight, numbers.

import { getJson } from "./api.js";
import { hint, section } from "./form.js";
import { number } from "./readout.js";

/** @typedef {import("./types.js").SatelliteInSky} Satellite */

/** Longest time from a sample of the log at which it is still shown (s). */
const MOST_APART_S = 1.5;
/** Range of the C/N₀ plot (dB-Hz). */
const CN0 = [20, 55];
const BANDS = ["L1", "L2", "L5"];
/** Colours of GPS, GLONASS, Galileo, BeiDou; others are grey. */
const SYSTEMS = /** @type {Record<string, string>} */ ({ G: "#3d8fd9", R: "#d9603d", E: "#2c9e62", C: "#b05cc6" });

/** @param {Satellite} satellite */
const colour = (satellite) => SYSTEMS[satellite.name[0]] ?? "#8793a1";

/** The sample nearest to a time; none where the satellite was not tracked then. @param {Satellite} satellite @param {number} time */
export function sampleAt({ time_s: times }, time) {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1;
    else high = middle;
  }
  const nearest = low > 0 && time - times[low - 1] < times[low] - time ? low - 1 : low;
  return times.length && Math.abs(times[nearest] - time) <= MOST_APART_S ? nearest : null;
}

export class SkyPanel {
  /** @param {import("./store.js").Store} store @param {(error: Error) => void} failed */
  constructor(store, failed) {
    this.store = store;
    this.failed = failed;
    /** @type {Satellite[]} */
    this.satellites = [];
    /** Run and track of the satellites. */
    this.shown = "";
    const { details, panel } = section("Satellites of the GNSS log", false);
    this.details = details;
    details.id = "sky";
    this.plot = canvas("sky-plot");
    this.strengths = canvas("strengths");
    this.table = document.createElement("table");
    const scroll = document.createElement("div");
    scroll.className = "scroll";
    scroll.append(this.table);
    panel.append(this.plot, this.strengths, scroll, hint("At the pulse under the pointer, or else the chosen one. Azimuth counts from north over east. Grey: the way of each satellite during the log."));
    this.frame = 0;
    details.addEventListener("toggle", () => this.refresh());
    new ResizeObserver(() => this.later()).observe(panel);
    store.on(["run", "engine"], () => this.refresh());
    store.on(["pulse", "chosen"], () => this.later());
    this.refresh();
  }

  /** Asks for the satellites once somebody looks. */
  refresh() {
    const { store, details } = this;
    const has = !!store.trackMeta?.has_sky;
    details.hidden = !has;
    const wanted = has && details.open ? `${store.run}/${store.trackNumber}` : "";
    if (wanted && wanted !== this.shown) void this.load(wanted);
    else this.later();
  }

  /** @param {string} wanted */
  async load(wanted) {
    this.shown = wanted;
    this.satellites = [];
    const [run, track] = wanted.split("/");
    try {
      const answer = await getJson(`api/run/${run}/sky/${track}`);
      if (this.shown === wanted) this.satellites = answer.satellites;
    } catch (error) {
      this.failed(/** @type {Error} */ (error));
    }
    this.later();
  }

  /** Draws with the next frame. */
  later() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      if (!this.details.hidden && this.details.open) this.draw();
    });
  }

  /** Radar time of the pulse shown (s). */
  get time() {
    const { data, trackMeta, pulse, chosen } = this.store;
    return data?.time_s[pulse ?? chosen ?? trackMeta?.first_pulse ?? 0] ?? 0;
  }

  draw() {
    const time = this.time;
    const tracked = this.satellites.map((satellite) => ({ satellite, at: sampleAt(satellite, time) }));
    this.drawSky(tracked);
    this.drawStrengths(time);
    this.fillTable(tracked, time);
  }

  /** @param {{satellite: Satellite, at: number | null}[]} tracked */
  drawSky(tracked) {
    const c = context(this.plot);
    if (!c) return;
    const [w, h] = [this.plot.clientWidth, this.plot.clientHeight];
    const { ink, muted, line } = inks(this.plot);
    const radius = Math.min(w, h) / 2 - 18;
    /** @type {(direction: [number, number]) => [number, number]} */
    const place = ([azimuth, elevation]) => {
      const [a, r] = [(azimuth * Math.PI) / 180, (radius * (90 - elevation)) / 90];
      return [w / 2 + r * Math.sin(a), h / 2 - r * Math.cos(a)];
    };
    c.font = "12px system-ui, sans-serif";
    c.textBaseline = "middle";
    c.textAlign = "center";
    c.lineWidth = 1;
    for (const elevation of [0, 30, 60]) {
      c.strokeStyle = line;
      c.beginPath();
      c.arc(w / 2, h / 2, (radius * (90 - elevation)) / 90, 0, 2 * Math.PI);
      c.stroke();
      c.fillStyle = muted;
      if (elevation > 0) c.fillText(`${elevation}°`, ...place([0, elevation]));
    }
    ["N", "E", "S", "W"].forEach((name, k) => {
      const [x, y] = place([90 * k, 0]);
      c.fillText(name, x + [0, 10, 0, -10][k], y + [-10, 0, 10, 0][k]);
    });
    for (const { satellite } of tracked) trail(c, satellite, place, muted);
    c.textAlign = "left";
    for (const { satellite, at } of tracked) {
      const direction = at === null ? null : satellite.direction_deg[at];
      if (!direction || at === null) continue;
      const [x, y] = place(direction);
      c.fillStyle = colour(satellite);
      c.beginPath();
      c.arc(x, y, 3 + 4 * Math.min(Math.max(((satellite.cn0_db_hz[at][0] ?? CN0[0]) - 25) / 25, 0), 1), 0, 2 * Math.PI);
      c.fill();
      c.fillStyle = ink;
      c.fillText(satellite.name, x + 8, y);
    }
    const count = tracked.filter(({ at }) => at !== null).length;
    this.plot.setAttribute("aria-label", `Sky plot of ${count} satellites; the table below has their directions`);
  }

  /** C/N₀ of the first frequency over the flight. @param {number} time */
  drawStrengths(time) {
    const c = context(this.strengths);
    const { data, trackMeta } = this.store;
    if (!c || !data || !trackMeta) return;
    const [w, h] = [this.strengths.clientWidth, this.strengths.clientHeight];
    const { muted, line, accent } = inks(this.strengths);
    const [from, to] = [data.time_s[trackMeta.first_pulse], data.time_s[trackMeta.first_pulse + trackMeta.pulses - 1]];
    const left = 26;
    const x = (/** @type {number} */ t) => left + ((w - left) * (t - from)) / Math.max(to - from, 1e-9);
    const y = (/** @type {number} */ v) => h - 6 - ((h - 24) * (v - CN0[0])) / (CN0[1] - CN0[0]);
    c.font = "12px system-ui, sans-serif";
    c.textBaseline = "middle";
    c.fillStyle = muted;
    c.fillText("C/N₀ of L1 in dB-Hz over the flight", left, 7);
    for (const level of [20, 30, 40, 50]) {
      c.fillText(`${level}`, 4, y(level));
      stroke(c, [[left, y(level)], [w, y(level)]], line, 1);
    }
    c.save();
    c.beginPath();
    c.rect(left, 0, w - left, h);
    c.clip();
    for (const satellite of this.satellites) {
      stroke(c, satellite.time_s.map((t, k) => [x(t), y(satellite.cn0_db_hz[k][0] ?? NaN)]), colour(satellite), 1.2);
    }
    stroke(c, [[x(time), 14], [x(time), h]], accent, 1.5);
    c.restore();
    this.strengths.setAttribute("aria-label", `C/N₀ of ${this.satellites.length} satellites over the flight`);
  }

  /** @param {{satellite: Satellite, at: number | null}[]} tracked @param {number} time */
  fillTable(tracked, time) {
    const bands = BANDS.map((_, band) => band).filter((band) => this.satellites.some(({ cn0_db_hz }) => cn0_db_hz.some((one) => one[band] !== null)));
    this.table.replaceChildren();
    this.table.createCaption().textContent = `Satellites at ${number(time, 2, "s")}`;
    const head = this.table.createTHead().insertRow();
    for (const name of ["", "azimuth", "elevation", ...bands.map((band) => `C/N₀ ${BANDS[band]}`)]) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = name;
      head.append(cell);
    }
    const body = this.table.createTBody();
    for (const { satellite, at } of tracked) {
      if (at === null) continue;
      const row = body.insertRow();
      const direction = satellite.direction_deg[at];
      const texts = [satellite.name, number(direction?.[0], 0, "°"), number(direction?.[1], 0, "°"), ...bands.map((band) => number(satellite.cn0_db_hz[at][band], 1))];
      for (const text of texts) row.insertCell().textContent = text;
    }
  }
}

/** @param {string} kind */
function canvas(kind) {
  const made = document.createElement("canvas");
  made.className = kind;
  made.setAttribute("role", "img");
  return made;
}

/** The drawing of a canvas in CSS pixels, cleared; none of a canvas that is not seen. @param {HTMLCanvasElement} on */
function context(on) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const c = on.getContext("2d");
  if (!c || !on.clientWidth) return null;
  [on.width, on.height] = [on.clientWidth * ratio, on.clientHeight * ratio];
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  return c;
}

/** Colours of the theme. @param {HTMLElement} of */
function inks(of) {
  const style = getComputedStyle(of);
  const [ink, muted, line, accent] = ["--ink", "--muted", "--line", "--accent"].map((name) => style.getPropertyValue(name));
  return { ink, muted, line, accent };
}

/** @param {CanvasRenderingContext2D} c @param {Satellite} satellite @param {(direction: [number, number]) => [number, number]} place @param {string} ink */
function trail(c, satellite, place, ink) {
  c.globalAlpha = 0.5;
  stroke(c, satellite.direction_deg.map((direction) => (direction ? place(direction) : [NaN, NaN])), ink, 1);
  c.globalAlpha = 1;
}

/** A line that values which are not finite break. @param {CanvasRenderingContext2D} c @param {number[][]} points @param {string} ink @param {number} width */
function stroke(c, points, ink, width) {
  c.beginPath();
  let pen = false;
  for (const [x, y] of points) {
    const is = Number.isFinite(x) && Number.isFinite(y);
    if (is && pen) c.lineTo(x, y);
    else if (is) c.moveTo(x, y);
    pen = is;
  }
  c.strokeStyle = ink;
  c.lineWidth = width;
  c.stroke();
}
