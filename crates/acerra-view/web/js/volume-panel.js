// Which slice of a volume is shown.

import { choice, hint, section, slider } from "./form.js";

/** @param {import("./store.js").Store} store @param {import("./types.js").Volume} volume */
export function volumePanel(store, volume) {
  const { details, panel } = section(`Volume (${volume.slices} slices)`, true);
  const height = (/** @type {number} */ k) => `${(volume.z0_m + k * volume.step_m).toFixed(3)} m`.replace("-", "−");
  const shown = choice({
    name: "Shown of it", id: "volume-shows", values: [["strongest", "strongest along each vertical"], ["slice", "slice at one height"]], value: store.slice === null ? "strongest" : "slice",
    changed: (v) => store.showSlice(v === "slice" ? Number(slice.input.value) : null),
  });
  const slice = slider({
    name: "Height of the slice", id: "slice", low: 0, high: volume.slices - 1, step: 1, value: store.sliceIndex ?? Math.floor((volume.slices - 1) / 2), text: height,
    changed: (k) => store.showSlice(k),
  });
  store.on(["slice"], () => {
    shown.select.value = store.slice === null ? "strongest" : "slice";
    if (store.sliceIndex !== null) slice.set(store.sliceIndex);
  });
  panel.append(shown.row, slice.row, hint("The cuts below the image follow the pointer; a click on the image holds them, a click on a cut moves slice and cuts there. Levels are those of volume.npz below its maximum."));
  return details;
}
