// What the run found: targets with their point spread, evidence, warnings.

import { getJson } from "./api.js";
import { hint, section } from "./form.js";
import { number } from "./readout.js";

/** @typedef {import("./store.js").Store} Store */
/** @typedef {import("./types.js").Target} Target */

/** @param {string[]} names @param {string} caption */
function table(names, caption) {
  const made = document.createElement("table");
  const title = made.createCaption();
  title.textContent = caption;
  const head = made.createTHead().insertRow();
  for (const name of names) {
    const cell = document.createElement("th");
    cell.scope = "col";
    cell.textContent = name;
    head.append(cell);
  }
  return { made, body: made.createTBody() };
}

/** @param {Store} store @param {(target: Target) => void} picked */
export function targetsPanel(store, picked) {
  const list = store.meta?.targets.targets ?? [];
  const { details, panel } = section(`Targets (${list.length})`, true);
  if (!list.length) {
    panel.append(hint("The image holds no target above the threshold."));
    return details;
  }
  const { made, body } = table(["", "x (m)", "y (m)", "dB", "along (cm)", "across (cm)"], "Widths: distance of the first minimum as measured");
  const told = hint("Pick a target: its place is marked, and what its flight could resolve is told here.");
  told.id = "target-spread";
  list.forEach((target, k) => {
    const row = body.insertRow();
    row.className = "pick";
    row.tabIndex = 0;
    const cm = (/** @type {number | null} */ v) => number(v === null ? null : 100 * v, 1);
    for (const text of [`${k + 1}`, number(target.x_m, 2), number(target.y_m, 2), number(target.level_db, 1), cm(target.along.rayleigh_m), cm(target.across.rayleigh_m)]) {
      row.insertCell().textContent = text;
    }
    const pick = () => {
      for (const other of body.rows) other.setAttribute("aria-selected", String(other === row));
      picked(target);
      void compare(store, target, k, told);
    };
    row.addEventListener("click", pick);
    row.addEventListener("keydown", (event) => event.key === "Enter" && pick());
  });
  const scroll = document.createElement("div");
  scroll.className = "scroll";
  scroll.append(made);
  panel.append(scroll, told);
  return details;
}

/** Tells a target's widths beside those of a point at its place. @param {Store} store @param {Target} target @param {number} k @param {HTMLElement} told */
async function compare(store, target, k, told) {
  const cm = (/** @type {number | null} */ v) => number(v === null ? null : 100 * v, 1, "cm");
  const own = `Target ${k + 1}: ${cm(target.along.rayleigh_m)} along and ${cm(target.across.rayleigh_m)} across as measured`;
  told.textContent = own;
  if (!store.data) return;
  try {
    const expected = await getJson(`api/run/${store.run}/spread?x_m=${target.x_m}&y_m=${target.y_m}`);
    told.textContent = `${own}; a point that echoes alike in all directions has ${cm(expected.along_m)} along and ${cm(expected.across_m)} across there, by this flight and band.`;
  } catch (error) {
    told.textContent = `${own}; what a point there has is not known: ${/** @type {Error} */ (error).message}`;
  }
}

/** @param {Store} store */
export function evidencePanel(store) {
  const record = store.meta?.record;
  const findings = record?.evidence ?? [];
  const bad = findings.filter((f) => f.verdict !== "agrees").length;
  const { details, panel } = section(`Evidence (${findings.length - bad} of ${findings.length} agree)`, bad > 0);
  const list = document.createElement("ul");
  list.className = "findings";
  const order = ["contradicts", "doubtful", "agrees"];
  for (const finding of [...findings].sort((a, b) => order.indexOf(a.verdict) - order.indexOf(b.verdict))) {
    const item = document.createElement("li");
    const verdict = document.createElement("span");
    verdict.className = `verdict ${order.includes(finding.verdict) ? finding.verdict : ""}`;
    verdict.textContent = `${finding.verdict}: `;
    const name = document.createElement("b");
    name.textContent = finding.name;
    item.append(verdict, name, hint(finding.explanation));
    list.append(item);
  }
  for (const one of record?.unchecked ?? []) {
    const item = document.createElement("li");
    const word = document.createElement("span");
    word.className = "verdict";
    word.textContent = "not checked: ";
    const name = document.createElement("b");
    name.textContent = one.setting;
    item.append(word, name, hint(one.explanation));
    list.append(item);
  }
  for (const warning of record?.warnings ?? []) {
    const item = document.createElement("li");
    const word = document.createElement("span");
    word.className = "verdict doubtful";
    word.textContent = "warning: ";
    item.append(word, document.createTextNode(warning));
    list.append(item);
  }
  panel.append(list);
  return details;
}
