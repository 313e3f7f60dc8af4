// What is said of a live image beside it.

/** @param {import("./live-link.js").Figures | null} figures */
const figuresText = (figures) => (figures ? `${figures.median_ms.toFixed(0)} ms, 95 % within ${figures.p95_ms.toFixed(0)} ms` : "–");

/** @param {number} m */
const lengthText = (m) => (m < 0.1 ? `${(1000 * m).toFixed(0)} mm` : `${m.toFixed(2)} m`);

/** One line: what the image is made of and what it waits for. @param {import("./live-link.js").LiveStatus} status */
export function imageState(status) {
  const { fixed, float, other } = status.by_kind;
  const kinds = [[fixed, "RTK fixed"], [float, "RTK float"], [other, "without carrier phase"]];
  const made = kinds.filter(([count]) => count).map(([count, name]) => `${count} ${name}`);
  const parts = made.length ? [`pulses at positions of the receiver: ${made.join(", ")}`] : [];
  if (status.waits_for) parts.push(`waits for ${status.waits_for}`);
  return parts.join("; ");
}

/** What is said, loudly, of instruments that are silent. @param {import("./live-link.js").LiveStatus} status */
export function silenceText(status) {
  const capital = (/** @type {string} */ text) => text[0].toUpperCase() + text.slice(1);
  const of = status.silent.map((one) => `${capital(one.instrument)} is silent: last heard at ${one.last_heard_utc} UTC.`);
  return of.join(" ");
}

/** Rows of the table. @param {import("./live-link.js").LiveStatus} status @returns {[string, string][]} */
export function rows(status) {
  const { pulses, link } = status;
  const lost = link.lost_scans + link.incomplete_scans;
  const made = link.whole_scans + lost;
  const position = status.position ? `${status.position}${status.sigma_m === null ? "" : `, ± ${lengthText(status.sigma_m)}`}` : "none";
  /** @type {[string, string | null][]} */
  const all = [
    ["Pulses imaged", String(pulses.imaged)],
    ["waiting for their position", String(pulses.waiting)],
    ["without position", pulses.without_position ? String(pulses.without_position) : null],
    ["before a heading was known", pulses.without_heading ? String(pulses.without_heading) : null],
    [`below ${lengthText(status.least_height_m)}`, pulses.too_low ? String(pulses.too_low) : null],
    ["not cleaned", pulses.not_cleaned ? String(pulses.not_cleaned) : null],
    ["imaging too slow", pulses.too_many ? String(pulses.too_many) : null],
    ["records missed", pulses.missed_records ? String(pulses.missed_records) : null],
    ["Scans lost", made ? `${lost} of ${made}` : "–"],
    ["Position", position],
    ["¼ wavelength", lengthText(status.quarter_wavelength_m)],
    ["of a picture started again", pulses.begun_anew ? String(pulses.begun_anew) : null],
    ["Clock", status.clock_sigma_s === null ? "–" : `${status.clock}, ± ${(1000 * status.clock_sigma_s).toFixed(2)} ms`],
    ["Range zero", status.shift_ns === null ? "–" : `${(-status.shift_ns).toFixed(2)} ns`],
    ["Pulse to picture", figuresText(status.latency)],
    ["of it until its imaging began", figuresText(status.waiting)],
    ["Pulse to screen", figuresText(status.drawn)],
  ];
  return /** @type {[string, string][]} */ (all.filter(([, value]) => value !== null));
}

/** What there is to say of the final image. @param {import("./live-link.js").LiveFinal} last */
export function finalText(last) {
  switch (last.state) {
    case "making":
      return `Final image: ${last.stage}${last.step ? `, ${last.step} ${Math.round(100 * (last.share ?? 0))} %` : ""}`;
    case "made":
      return `The final image is made: ${last.directory}${last.warnings?.length ? ` (${last.warnings.length} warnings)` : ""}`;
    case "failed":
      return `It ended: ${last.reason}`;
    case "ending":
      return "The recording is being ended.";
    case "ended":
      return "The recording is over.";
    default:
      return "";
  }
}
