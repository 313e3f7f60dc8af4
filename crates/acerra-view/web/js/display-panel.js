// How levels become colours, which layers are drawn, and which run stands beside this one.

import { step } from "./drawing.js";
import { choice, section, slider, toggle } from "./form.js";
import { PALETTES, palette } from "./palettes.js";

/** @typedef {import("./store.js").Store} Store */

/** @param {Store} store */
export function displayPanel(store) {
  const { details, panel } = section("Display", true);
  const { look, meta } = store;
  const changed = () => {
    void draw();
    store.tell("look");
  };
  const legend = document.createElement("div");
  legend.className = "legend";
  const [bar, ticks] = [document.createElement("canvas"), document.createElement("div")];
  ticks.className = "ticks";
  legend.append(bar, ticks);
  const draw = async () => {
    const isPhase = look.mode === "phase";
    const isCoherence = look.mode === "coherence";
    const table = await palette(isPhase ? "phase" : look.palette);
    [bar.width, bar.height] = [256, 1];
    bar.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(table), 256, 1), 0, 0);
    const [low, high] = isPhase ? [-180, 180] : isCoherence ? [0, 1] : look.window;
    const unit = isPhase ? "°" : isCoherence ? "" : " dB";
    const apart = isPhase ? 90 : step(high - low, 5);
    const marks = [];
    for (let k = Math.ceil(low / apart - 1e-9); k * apart <= high + 1e-9; k++) {
      const mark = document.createElement("span");
      const value = Number((k * apart).toFixed(3));
      mark.textContent = `${value}${marks.length ? "" : unit}`.replace("-", "−");
      mark.style.left = `${(100 * (value - low)) / (high - low)}%`;
      marks.push(mark);
    }
    ticks.replaceChildren(...marks);
  };
  const floor = slider({
    name: "Lowest level", id: "floor", low: -100, high: -5, step: 1, value: look.window[0], text: (v) => `${v} dB`.replace("-", "−"),
    changed: (v) => {
      look.window[0] = Math.min(v, look.window[1] - 1);
      changed();
    },
  });
  const top = slider({
    name: "Highest level", id: "top", low: -60, high: 10, step: 1, value: look.window[1], text: (v) => `${v} dB`.replace("-", "−"),
    changed: (v) => {
      look.window[1] = Math.max(v, look.window[0] + 1);
      changed();
    },
  });
  const mode = choice({
    name: "Image shows", id: "mode", values: [["level", "level"], ["phase", "phase"], ["coherence", "coherence of two looks"]], value: look.mode,
    changed: (v) => {
      const was = look.mode;
      look.mode = v === "phase" || v === "coherence" ? v : "level";
      changed();
      if (was === "coherence" || look.mode === "coherence") store.tell("edits");
    },
  });
  const colours = choice({ name: "Colours", id: "palette", values: PALETTES, value: look.palette, changed: (v) => { look.palette = v; changed(); } });
  const radargram = choice({
    name: "Radargram shows", id: "radargram-look", values: [["level", "level"], ["signed", "signed amplitude"]], value: look.radargram,
    changed: (v) => {
      look.radargram = v === "signed" ? "signed" : "level";
      changed();
    },
  });
  const gain = slider({
    name: "Gain of the radargram", id: "radargram-gain", low: 0, high: 80, step: 1, value: look.radargramGain, text: (v) => `${v} dB at the last sample`,
    changed: (v) => {
      look.radargramGain = v;
      changed();
    },
  });
  panel.append(legend, mode.row, colours.row, floor.row, top.row);
  if (meta?.display.gain) panel.append(toggle("Undo 1/R², as the run's picture does", look.gain, (v) => { look.gain = v; changed(); }));
  if (store.hasTerrain) panel.append(toggle("Contours of the ground", look.contours, (v) => { look.contours = v; changed(); }));
  if (store.runs.basemap) {
    const opacity = slider({ name: "Image over the map", id: "opacity", low: 0, high: 1, step: 0.05, value: look.opacity, text: (v) => `${Math.round(100 * v)} %`, changed: (v) => { look.opacity = v; changed(); } });
    panel.append(opacity.row);
  }
  panel.append(radargram.row, gain.row, layersOf(store, changed));
  void draw();
  store.on(["look"], () => {
    mode.select.value = look.mode;
    void draw();
  });
  return details;
}

/** Layers of the image that can be taken away: those that the run has. @param {Store} store @param {() => void} changed */
function layersOf({ look, meta }, changed) {
  const group = document.createElement("fieldset");
  const title = document.createElement("legend");
  title.textContent = "Layers of the image";
  group.append(title);
  /** @type {[import("./store.js").Layer, string, boolean][]} */
  const layers = [
    ["image", "image", true],
    ["track", "track", true],
    ["targets", "targets", !!meta?.targets.targets.length],
    ["surveyed", "surveyed points", !!meta?.targets.surveyed?.length],
  ];
  for (const [layer, name, has] of layers) {
    if (has) group.append(toggle(name, look.layers[layer], (v) => { look.layers[layer] = v; changed(); }));
  }
  return group;
}

/** @param {Store} store @param {(run: number | null) => Promise<boolean>} setOther sets the other run; tells whether a difference means anything */
export function comparePanel(store, setOther) {
  const { details, panel } = section("Compare two runs", false);
  const others = store.runs.runs.map((run, k) => /** @type {const} */ ([String(k), run.name])).filter(([k]) => Number(k) !== store.run);
  const told = document.createElement("p");
  told.className = "hint";
  const set = async () => {
    const { compare } = store;
    const comparable = await setOther(compare.mode === "off" ? null : compare.run);
    told.textContent = compare.mode === "difference" && !comparable ? "The two images stand on different pixels: there is no difference to show." : compare.mode === "swipe" ? "Drag the line." : compare.mode === "difference" ? "Blue: weaker here than in the other run; red: stronger." : "";
    store.tell("compare", "look");
  };
  const run = choice({ name: "Other run", id: "other-run", values: others, value: others[0]?.[0] ?? "", changed: (v) => { store.compare.run = Number(v); void set(); } });
  const mode = choice({
    name: "Show", id: "compare", values: [["off", "this run alone"], ["swipe", "swipe"], ["blink", "blink"], ["difference", "difference in dB"]], value: "off",
    changed: (v) => {
      store.compare.mode = /** @type {import("./store.js").Compare["mode"]} */ (v);
      void set();
    },
  });
  store.compare = { mode: "off", run: Number(others[0]?.[0] ?? 0), share: 0.5 };
  panel.append(run.row, mode.row, told);
  return details;
}
