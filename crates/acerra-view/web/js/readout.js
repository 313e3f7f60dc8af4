// Names and numbers under a pane.

/** A number of so many digits, or a dash. @param {number | null | undefined} value @param {number} digits @param {string} [unit] */
export function number(value, digits, unit = "") {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return `${value.toFixed(digits).replace("-", "−")}${unit && ` ${unit}`}`;
}

/** Writes names and values; what is empty is left out. @param {HTMLElement} list @param {[string, string | null][]} entries */
export function readout(list, entries) {
  const rows = entries.filter(([, text]) => text !== null);
  while (list.children.length > rows.length) list.lastElementChild?.remove();
  rows.forEach(([name, text], k) => {
    let row = list.children[k];
    if (!row) {
      row = document.createElement("div");
      row.append(document.createElement("dt"), document.createElement("dd"));
      list.append(row);
    }
    const [dt, dd] = row.children;
    if (dt.textContent !== name) dt.textContent = name;
    if (dd.textContent !== text) dd.textContent = text;
    /** @type {HTMLElement} */ (dd).dataset.value = name;
  });
}

/** An element by its id. @template {HTMLElement} T @param {string} id @param {new () => T} kind @returns {T} */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${kind.name} #${id}`);
  return found;
}
