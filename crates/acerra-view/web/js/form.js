// Parts of panels: folding sections, sliders, choices.

let count = 0;

/** @param {string} title @param {boolean} open */
export function section(title, open) {
  const details = document.createElement("details");
  details.open = open;
  const summary = document.createElement("summary");
  summary.textContent = title;
  const panel = document.createElement("div");
  panel.className = "panel";
  details.append(summary, panel);
  return { details, panel };
}

/**
 * A slider with its value.
 * @param {{name: string, id: string, low: number, high: number, step: number, value: number, text: (v: number) => string, changed: (v: number) => void}} options
 */
export function slider(options) {
  const row = document.createElement("div");
  row.className = "row";
  const label = document.createElement("label");
  const input = document.createElement("input");
  const output = document.createElement("output");
  input.type = "range";
  input.id = options.id;
  label.htmlFor = options.id;
  label.textContent = options.name;
  output.htmlFor.add(options.id);
  [input.min, input.max, input.step] = [options.low, options.high, options.step].map(String);
  input.value = String(options.value);
  const show = () => {
    output.textContent = options.text(Number(input.value));
    input.setAttribute("aria-valuetext", output.textContent);
  };
  show();
  input.addEventListener("input", () => {
    show();
    options.changed(Number(input.value));
  });
  row.append(label, output, input);
  return {
    row,
    input,
    /** @param {number} value */
    set(value) {
      input.value = String(value);
      show();
    },
  };
}

/**
 * @param {{name: string, id: string, values: readonly (readonly [string, string])[], value: string, changed: (v: string) => void}} options
 */
export function choice(options) {
  const row = document.createElement("div");
  row.className = "row";
  const label = document.createElement("label");
  const select = document.createElement("select");
  select.id = options.id;
  label.htmlFor = options.id;
  label.textContent = options.name;
  for (const [value, text] of options.values) select.append(new Option(text, value));
  select.value = options.value;
  select.addEventListener("change", () => options.changed(select.value));
  row.append(label, select);
  return { row, select };
}

/** @param {string} name @param {boolean} value @param {(v: boolean) => void} changed */
export function toggle(name, value, changed) {
  const row = document.createElement("div");
  row.className = "row";
  const label = document.createElement("label");
  const input = document.createElement("input");
  input.type = "checkbox";
  input.id = `toggle-${(count += 1)}`;
  label.htmlFor = input.id;
  label.textContent = name;
  input.checked = value;
  input.addEventListener("change", () => changed(input.checked));
  row.append(label, input);
  return row;
}

/** @param {string} name @param {() => void} action */
export function button(name, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = name;
  made.addEventListener("click", action);
  return made;
}

/** @param {string} text */
export function hint(text) {
  const p = document.createElement("p");
  p.className = "hint";
  p.textContent = text;
  return p;
}

/** Saves a file from the page. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  window.setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
