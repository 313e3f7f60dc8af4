// Settings of the run by sliders; the image in view follows.

import { postCampaign } from "./api.js";
import { button, choice, hint, save, section, slider, toggle } from "./form.js";

/** @typedef {import("./types.js").Edits} Edits */

const BACKGROUNDS = /** @type {const} */ ([
  ["mean", "mean of all traces"],
  ["median", "median of all traces"],
  ["none", "nothing"],
  ['{"window":51}', "mean of 51 traces"],
  ['{"window":201}', "mean of 201 traces"],
  ['{"components":1}', "1 component"],
  ['{"components":3}', "3 components"],
]);

/** A number with its sign. @param {number} v @param {number} digits @param {string} unit */
const signed = (v, digits, unit) => `${v < 0 ? "−" : v > 0 ? "+" : "±"}${Math.abs(v).toFixed(digits)} ${unit}`;

/**
 * The gate in force, and whether there is one: its sliders act only while there is.
 * @param {import("./types.js").EngineData} data @param {(edits: Edits) => void} change
 */
function gateRows(data, change) {
  const inForce = data.tracks.map((track) => track.radargram?.gate_ns ?? null).find((found) => found !== null) ?? null;
  // The engine counts in seconds: what that leaves behind the sixth decimal is no setting.
  const gate = inForce?.map((ns) => Number(ns.toFixed(6))) ?? [-6, 24];
  const ns = (/** @type {number} */ v) => `${v.toFixed(1)} ns`.replace("-", "−");
  const gated = () => gate[0] < gate[1] && change({ gate_ns: [...gate] });
  const from = slider({ name: "Gate from, about 2h/c", id: "gate-from", low: Math.min(-20, Math.floor(gate[0])), high: 40, step: 0.5, value: gate[0], text: ns, changed: (v) => { gate[0] = v; gated(); } });
  const to = slider({ name: "Gate to", id: "gate-to", low: -10, high: Math.max(80, Math.ceil(gate[1])), step: 0.5, value: gate[1], text: ns, changed: (v) => { gate[1] = v; gated(); } });
  const acts = (/** @type {boolean} */ is) => [from, to].forEach(({ input }) => (input.disabled = !is));
  const on = toggle("Gate about 2h/c", inForce !== null, (is) => {
    acts(is);
    if (is) gated();
    else change({ gate_ns: "none" });
  });
  acts(inForce !== null);
  return [on, from.row, to.row];
}

/** @param {import("./store.js").Store} store @param {(error: Error) => void} failed */
export function settingsPanel(store, failed) {
  const { details, panel } = section("Process again", true);
  const data = store.data;
  if (!data) {
    panel.append(hint(store.engine.state === "failed" ? `The data behind this run cannot be had: ${store.engine.reason}` : "The logs of the run are being read …"));
    return details;
  }
  const settings = /** @type {import("./types.js").RunMeta} */ (store.meta).record.configuration;
  const hasTraces = data.tracks.some((track) => track.radargram);
  const change = (/** @type {Edits} */ edits) => {
    store.edits = { ...store.edits, ...edits };
    store.tell("edits");
  };
  panel.append(hint("The image in view follows; nothing of the run is changed."));
  if (hasTraces) {
    panel.append(...gateRows(data, change));
    const own = typeof settings.preprocess.background === "string" ? settings.preprocess.background : JSON.stringify(settings.preprocess.background);
    const known = BACKGROUNDS.some(([value]) => value === own);
    const values = known ? BACKGROUNDS : [/** @type {const} */ ([own, own]), ...BACKGROUNDS];
    panel.append(choice({ name: "Background", id: "background", values, value: own, changed: (v) => change({ background: v.startsWith("{") ? JSON.parse(v) : v }) }).row);
  }
  const [low, high] = settings.image.band_ghz;
  const band = [low, high];
  const ghz = (/** @type {number} */ v) => `${v.toFixed(2)} GHz`;
  const banded = () => band[0] < band[1] && change({ band_ghz: [...band] });
  if (hasTraces) {
    panel.append(
      slider({ name: "Band from", id: "band-from", low, high: high - 0.1, step: 0.05, value: low, text: ghz, changed: (v) => { band[0] = v; banded(); } }).row,
      slider({ name: "Band to", id: "band-to", low: low + 0.1, high, step: 0.05, value: high, text: ghz, changed: (v) => { band[1] = v; banded(); } }).row,
      slider({ name: "Delay", id: "delay", low: -2, high: 2, step: 0.01, value: 0, text: (v) => signed(v, 2, "ns"), changed: (v) => change({ delay_change_ns: v }) }).row,
    );
  }
  panel.append(slider({ name: "Clock offset", id: "clock", low: -0.5, high: 0.5, step: 0.002, value: 0, text: (v) => signed(1e3 * v, 0, "ms"), changed: (v) => change({ time_offset_change_s: v }) }).row);
  const z = settings.image.z_m;
  if (!settings.image.terrain && typeof z === "number") {
    panel.append(slider({ name: "Height of the plane", id: "height", low: z - 2, high: z + 2, step: 0.01, value: z, text: (v) => `${v.toFixed(2)} m`.replace("-", "−"), changed: (v) => change({ z_m: v }) }).row);
  }
  if (Array.isArray(z) && !store.meta?.volume) {
    const [from, to] = z;
    const slice = slider({ name: "Slice of the volume", id: "slice", low: from, high: to, step: (to - from) / 200, value: store.slice ?? from, text: (v) => `${v.toFixed(3)} m`.replace("-", "−"), changed: (v) => { store.slice = v; store.tell("edits"); } });
    panel.append(slice.row);
  }
  const c = settings.image.light_speed_m_s;
  panel.append(slider({ name: "Speed of light", id: "speed", low: 1e8, high: 299792458, step: 1, value: c, text: (v) => `${(v / 1e9).toFixed(4)} m/ns`, changed: (v) => change({ light_speed_m_s: v }) }).row);
  const buttons = document.createElement("div");
  buttons.className = "buttons";
  const keep = button("Save campaign file", async () => {
    try {
      const text = await postCampaign(store.run, store.edits);
      save(new Blob([text], { type: "application/toml" }), "campaign.toml");
    } catch (error) {
      failed(/** @type {Error} */ (error));
    }
  });
  keep.id = "save-campaign";
  const back = button("As the run", () => {
    store.edits = {};
    if (!store.meta?.volume) store.slice = null;
    details.replaceWith(settingsPanel(store, failed));
    store.tell("edits");
  });
  back.id = "reset";
  buttons.append(keep, back);
  panel.append(buttons);
  return details;
}
