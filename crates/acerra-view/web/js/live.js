// The page of a live image.

import { postStop } from "./api.js";
import { LivePicture } from "./live-picture.js";
import { follow } from "./live-link.js";
import { finalText, imageState, rows, silenceText } from "./live-status.js";
import { LiveTracesPane } from "./live-traces.js";
import { startTheme, switchTheme } from "./theme.js";

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

startTheme();
const picture = new LivePicture(element("image-box"), (place) => {
  const readout = element("image-readout");
  readout.replaceChildren();
  if (!place) return;
  /** @type {[string, string][]} */
  const told = [["east", `${place.x_m.toFixed(2)} m`], ["north", `${place.y_m.toFixed(2)} m`], ["level", place.db === null ? "–" : `${place.db.toFixed(1)} dB`]];
  for (const [name, value] of told) {
    const [row, dt, dd] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
    [dt.textContent, dd.textContent] = [name, value];
    row.append(dt, dd);
    readout.append(row);
  }
});
const traces = new LiveTracesPane(element("traces-box"));

/** @param {string} text @param {boolean} [bad] */
function say(text, bad = false) {
  const notice = element("notice");
  if (notice.textContent !== text) notice.textContent = text;
  notice.classList.toggle("bad", bad);
}

let told = "";

/** Rebuilds what has changed: a table made again with each picture costs as much as the picture. @param {import("./live-link.js").LiveStatus} status */
function tell(status) {
  const now = JSON.stringify(status);
  if (now === told) return;
  told = now;
  const silence = silenceText(status);
  if (element("silence").textContent !== silence) element("silence").textContent = silence;
  element("silence").hidden = !silence;
  element("image-state").textContent = imageState(status);
  element("image-state").title = imageState(status);
  const lines = rows(status).map(([name, value]) => {
    const row = document.createElement("tr");
    const [head, cell] = [document.createElement("th"), document.createElement("td")];
    head.scope = "row";
    [head.textContent, cell.textContent] = [name, value];
    row.append(head, cell);
    return row;
  });
  element("state").replaceChildren(...lines);
  const doubts = status.doubts.map((text) => {
    const item = document.createElement("li");
    item.className = "verdict doubtful";
    item.textContent = text;
    return item;
  });
  const shown = element("doubts");
  if (shown.textContent !== status.doubts.join("")) shown.replaceChildren(...doubts);
}

/** What tests and the curious look at. */
const known = { picture, traces, state: /** @type {import("./live-link.js").LiveState | null} */ (null), rounds: 0 };
Object.assign(window, { acerra: known });

follow({
  begin: () => {
    picture.begin();
    traces.begin();
    say("");
  },
  lost: () => say("The program does not answer; trying again.", true),
  round: (state, tiles, news) => {
    known.state = state;
    known.rounds += 1;
    if (state.grid) picture.setGrid(state.grid);
    if (tiles) picture.take(tiles);
    picture.track.splice(state.track.from);
    picture.track.push(...state.track.places);
    if (state.track.places.length) picture.invalidate();
    if (news) traces.take(news, state.trace_axis_ns);
    element("image-empty").textContent = state.grid ? "" : `Waiting for ${state.status.waits_for ?? "the recording"}.`;
    tell(state.status);
    const { final } = state;
    say(finalText(final), final.state === "failed");
    if (final.state === "made" && element("final").hidden) {
      element("final").hidden = element("which").hidden = false;
      showFinal(true);
    }
    element("stop").hidden = !state.can_stop;
    if (!state.can_stop && dialog.open) dialog.close("no");
    document.documentElement.dataset.final = final.state;
  },
});

const dialog = /** @type {HTMLDialogElement} */ (element("stop-dialog"));
element("stop").addEventListener("click", () => {
  dialog.returnValue = "no";
  dialog.showModal();
});
dialog.addEventListener("close", () => {
  if (dialog.returnValue !== "yes") return;
  dialog.returnValue = "no";
  postStop().catch((/** @type {Error} */ error) => say(`The recording goes on: ${error.message}`, true));
});

/** Shows the final image or the provisional one. @param {boolean} final */
function showFinal(final) {
  const shown = /** @type {HTMLImageElement} */ (element("final-picture"));
  if (final && !shown.src) shown.src = "view/run/0/image.png";
  shown.hidden = !final;
  element("image-title").textContent = final ? "Final image" : "Provisional image";
  element("image-state").hidden = final;
  element("which").setAttribute("aria-pressed", String(!final));
}

element("which").addEventListener("click", () => showFinal(Boolean(element("final-picture").hidden)));
element("theme").addEventListener("click", switchTheme);
element("fit").addEventListener("click", () => picture.fit());
element("range").addEventListener("change", (event) => {
  picture.rangeDb = Number(/** @type {HTMLSelectElement} */ (event.target).value);
  picture.recolour();
});
document.addEventListener("keydown", (event) => {
  if (dialog.open || event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "d" || event.key === "D") switchTheme();
  if (event.key === "0") picture.fit();
  if ((event.key === "f" || event.key === "F") && !element("which").hidden) showFinal(Boolean(element("final-picture").hidden));
});
for (const tab of document.querySelectorAll(".tabs button")) {
  tab.addEventListener("click", () => {
    const show = /** @type {HTMLElement} */ (tab).dataset.show ?? "image";
    element("main").dataset.show = show;
    for (const other of document.querySelectorAll(".tabs button")) other.setAttribute("aria-pressed", String(other === tab));
  });
}
