// What is shown, as files.

/** The selected pulses as a table. @param {import("./store.js").Store} store @returns {string} */
export function pulsesCsv(store) {
  const { data, selection, mark } = store;
  if (!data) return "";
  const [first, last] = selection ?? [0, data.trace.length - 1];
  const echoes = mark?.hyperbola ?? null;
  const head = ["pulse", "trace", "time_s", "x_m", "y_m", "z_m", "height_m"];
  if (echoes) head.push("fast_time_ns", "incidence_deg");
  const lines = [head.join(",")];
  for (let k = first; k <= last; k++) {
    const row = [k, data.trace[k], data.time_s[k], ...data.position_m[k], data.height_m[k]];
    if (echoes) row.push(echoes.fast_time_ns[k], echoes.incidence_deg[k]);
    lines.push(row.join(","));
  }
  return `${lines.join("\n")}\n`;
}
