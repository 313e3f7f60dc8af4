// The page: opens a run, and ties panes and panels together.

import { Refused, getJson } from "./api.js";
import { CutsPane } from "./cuts-pane.js";
import { comparePanel, displayPanel } from "./display-panel.js";
import { pulsesCsv } from "./export.js";
import { evidencePanel, targetsPanel } from "./findings-panel.js";
import { save } from "./form.js";
import { ImagePane } from "./image-pane.js";
import { RadargramPane } from "./radargram-pane.js";
import { element } from "./readout.js";
import { Scrubber } from "./scrubber.js";
import { settingsPanel } from "./settings-panel.js";
import { SkyPanel } from "./sky-panel.js";
import { Store } from "./store.js";
import { startTheme, switchTheme } from "./theme.js";
import { TrackStrip } from "./track-strip.js";
import { volumePanel } from "./volume-panel.js";

startTheme();
const store = new Store();
/** The first run is asked for with the list of runs. @type {Promise<import("./types.js").RunMeta> | null} */
let first = getJson("api/run/0");
first.catch(() => {
  // Told when it is waited for.
});
const notice = element("notice", HTMLElement);

/** @param {Error} error */
function failed(error) {
  // A newer request took the place of this one: nothing to tell.
  if (error instanceof Refused && error.status === 409) return;
  notice.className = "notice bad";
  notice.textContent = error.message;
  notice.title = error.message;
}

function settled() {
  notice.className = "notice";
  notice.textContent = "";
}

try {
  store.runs = await getJson("api/runs");
} catch (error) {
  failed(/** @type {Error} */ (error));
}
const image = new ImagePane(element("image-box", HTMLElement), element("image-readout", HTMLElement), element("image-state", HTMLElement), store, failed);
const radargram = new RadargramPane(element("radargram-box", HTMLElement), element("radargram-readout", HTMLElement), store, failed);
const cuts = new CutsPane(element("cuts", HTMLElement), store, { hover: (x, y, slice) => image.ask(x, y, slice), failed });
new TrackStrip(element("track-strip", HTMLElement), store);
const scrubber = new Scrubber(store);
const sky = new SkyPanel(store, failed);
const panels = element("panels", HTMLElement);
const trackChoice = element("track-choice", HTMLSelectElement);

/** @param {number} run */
async function openRun(run) {
  settled();
  store.run = run;
  [store.mark, store.echo, store.selection, store.pulse, store.edits] = [null, null, null, null, {}];
  store.engine = { state: "idle" };
  image.revision = 0;
  [store.slice, store.cut, store.chosen] = [null, null, null];
  if (store.look.mode === "coherence") store.look.mode = "level";
  store.trackNumber = 0;
  /** @type {import("./types.js").RunMeta} */
  const meta = await (first ?? getJson(`api/run/${run}`));
  first = null;
  store.meta = meta;
  store.look.window = [meta.display.floor_db, 0];
  document.title = `${meta.name} – Acerra`;
  const report = element("report", HTMLAnchorElement);
  report.hidden = !meta.files.includes("report.html");
  report.href = `run/${run}/report.html`;
  image.setOther(run, null);
  await image.show(run, meta);
  fillPanels();
  store.tell("run", "engine", "mark", "echo", "selection", "look");
  const track = getJson(`api/run/${run}/track`);
  void follow(run);
  store.track = await track;
  store.tell("run", "mark");
}

/** Follows the reading of the logs until they are ready. @param {number} run */
async function follow(run) {
  try {
    for (;;) {
      /** @type {import("./types.js").EngineStatus} */
      const status = await getJson(`api/run/${run}/engine`);
      if (store.run !== run) return;
      store.engine = status;
      if (status.state === "ready" || status.state === "failed") break;
      radargram.refresh();
      await new Promise((done) => window.setTimeout(done, 250));
    }
    const tracks = store.data?.tracks ?? [];
    trackChoice.replaceChildren(...tracks.map((track, k) => new Option(track.name, String(k))));
    /** @type {HTMLElement} */ (trackChoice.parentElement).hidden = tracks.length < 2;
    fillPanels();
    store.tell("engine");
    if (store.mark) void image.mark(store.mark.x, store.mark.y);
    document.documentElement.dataset.engine = store.engine.state;
    image.revision = store.data?.revision ?? 0;
    // Another page may have left other settings behind.
    image.restore();
  } catch (error) {
    failed(/** @type {Error} */ (error));
  }
}

/** After an image with other settings: the radargram and its axes are others too. */
async function followSettings() {
  if (!store.data || image.revision === store.data.revision) return;
  const status = await getJson(`api/run/${store.run}/engine`);
  if (status.state !== "ready") return;
  store.engine = status;
  store.tell("engine");
  if (store.mark) void image.mark(store.mark.x, store.mark.y);
}

/** @param {number | null} run */
async function setOther(run) {
  if (run === null) image.setOther(0, null);
  else image.setOther(run, await getJson(`api/run/${run}`));
  return image.comparable;
}

function fillPanels() {
  const parts = [displayPanel(store), settingsPanel(store, failed)];
  const volume = store.meta?.volume;
  if (volume) parts.unshift(volumePanel(store, volume));
  if (store.runs.runs.length > 1) parts.push(comparePanel(store, setOther));
  parts.push(
    sky.details,
    targetsPanel(store, (target) => void image.mark(target.x_m, target.y_m)),
    evidencePanel(store),
  );
  panels.replaceChildren(...parts);
}

/** @param {"select" | "measure"} mode */
function switchMode(mode) {
  store.mode = store.mode === mode ? "move" : mode;
  element("select", HTMLElement).setAttribute("aria-pressed", String(store.mode === "select"));
  element("measure", HTMLElement).setAttribute("aria-pressed", String(store.mode === "measure"));
  store.tell("mode");
}

function clear() {
  [store.mark, store.echo, store.selection, store.chosen] = [null, null, null, null];
  image.measured = [];
  store.tell("mark", "echo", "selection", "chosen");
}

function runsOwn() {
  store.selection = null;
  if (!store.meta?.volume) store.slice = null;
  store.edits = {};
  if (store.look.mode === "coherence") store.look.mode = "level";
  fillPanels();
  store.tell("selection", "edits", "look");
}

/** @param {string} pane */
function showPane(pane) {
  element("main", HTMLElement).dataset.show = pane;
  for (const tab of document.querySelectorAll(".tabs button")) tab.setAttribute("aria-pressed", String(/** @type {HTMLElement} */ (tab).dataset.show === pane));
}

/** @param {string} id @param {() => void} action */
const onClick = (id, action) => element(id, HTMLElement).addEventListener("click", action);

const help = element("help", HTMLDialogElement);
/** @type {Record<string, () => void>} */
const keys = {
  s: () => switchMode("select"),
  m: () => switchMode("measure"),
  d: switchTheme,
  p: () => {
    const was = store.look.mode;
    store.look.mode = was === "level" ? "phase" : "level";
    store.tell("look");
    if (was === "coherence") store.tell("edits");
  },
  ",": () => scrubber.step(-1),
  ".": () => scrubber.step(1),
  PageUp: () => store.showSlice((store.sliceIndex ?? -1) + 1),
  PageDown: () => store.showSlice((store.sliceIndex ?? store.meta?.volume?.slices ?? 0) - 1),
  Escape: clear,
  "?": () => help.showModal(),
};
document.addEventListener("keydown", (event) => {
  const inForm = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
  if (inForm || help.open || event.ctrlKey || event.metaKey || event.altKey) return;
  keys[event.key]?.();
});
onClick("help-button", () => help.showModal());
onClick("theme", () => {
  switchTheme();
  store.tell("pulse");
});
onClick("fit", () => image.own && image.pane.bounds && image.pane.fit(image.pane.bounds));
onClick("fit-radargram", () => radargram.layer && radargram.pane.fit(radargram.interesting()));
onClick("select", () => switchMode("select"));
onClick("measure", () => switchMode("measure"));
onClick("clear", clear);
onClick("run-image", runsOwn);
onClick("export-png", () => void image.pane.picture().then((blob) => save(blob, `${store.meta?.name ?? "view"}.png`), failed));
onClick("export-csv", () => save(new Blob([pulsesCsv(store)], { type: "text/csv" }), `${store.meta?.name ?? "view"}-pulses.csv`));
element("stage", HTMLSelectElement).addEventListener("change", (event) => {
  radargram.stage = /** @type {HTMLSelectElement} */ (event.target).value === "raw" ? "raw" : "clean";
  radargram.refresh();
});
trackChoice.addEventListener("change", () => {
  store.trackNumber = Number(trackChoice.value);
  store.tell("engine");
});
for (const tab of document.querySelectorAll(".tabs button")) tab.addEventListener("click", () => showPane(/** @type {HTMLElement} */ (tab).dataset.show ?? "image"));
store.on(["live"], () => void followSettings().catch(failed));
store.on(["edits", "selection"], () => {
  settled();
  element("run-image", HTMLElement).hidden = !store.isLive;
});

const choice = element("run", HTMLSelectElement);
choice.addEventListener("change", () => void openRun(Number(choice.value)).catch(failed));
try {
  choice.replaceChildren(...store.runs.runs.map((run, k) => new Option(run.name, String(k))));
  if (store.runs.basemap) image.underlay(store.runs.basemap.template);
  await openRun(0);
} catch (error) {
  failed(/** @type {Error} */ (error));
}

// What the browser tests and the benchmark look at.
Object.assign(window, { acerra: { store, image, radargram, cuts, sky } });
