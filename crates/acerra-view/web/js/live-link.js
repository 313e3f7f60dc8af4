// The WebSocket of a live image: rounds of tiles, traces and JSON, each answered once it is drawn.

/** @typedef {{x0_m: number, y0_m: number, z_m: number, pixel_m: number, nx: number, ny: number}} LiveGrid */
/** @typedef {{median_ms: number, p95_ms: number, most_ms: number, pulses: number}} Figures */
/** @typedef {{came: number, imaged: number, waiting: number, without_position: number, without_heading: number, too_low: number, not_cleaned: number, too_many: number, begun_anew: number, missed_records: number}} PulseCounts */
/** @typedef {{pulses: PulseCounts, by_kind: {fixed: number, float: number, other: number}, position: string | null, sigma_m: number | null, quarter_wavelength_m: number, positions: number, clock: string | null, clock_sigma_s: number | null, least_height_m: number, waits_for: string | null, shift_ns: number | null, latency: Figures | null, waiting: Figures | null, drawn: Figures | null, link: {lost_scans: number, incomplete_scans: number, whole_scans: number}, silent: {instrument: string, for_s: number, last_heard_utc: string}[], doubts: string[]}} LiveStatus */
/** @typedef {{state: "recording" | "ending" | "ended" | "making" | "made" | "failed", stage?: string, step?: string, share?: number, directory?: string, warnings?: string[], reason?: string}} LiveFinal */
/** @typedef {{sequence: number, grid: LiveGrid | null, origin_deg_m: number[] | null, status: LiveStatus, track: {from: number, places: [number[], string][]}, trace_axis_ns: [number, number], final: LiveFinal, can_stop: boolean}} LiveState */
/** @typedef {{x: number, y: number, columns: number, rows: number, levels: Uint8Array}} LiveTile */
/** @typedef {{baseDb: number, maximumDb: number, tiles: LiveTile[]}} LiveTiles */
/** @typedef {{first: number, bins: number, traces: Uint8Array[]}} LiveTraces */

const AGAIN_MS = 1000;

/** @param {ArrayBuffer} buffer @returns {LiveTiles} */
function readTiles(buffer) {
  const view = new DataView(buffer);
  const count = view.getUint16(2, true);
  const tiles = [];
  let at = 16;
  for (let k = 0; k < count; k++) {
    const [x, y] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    const [columns, rows] = [view.getUint16(at + 8, true), view.getUint16(at + 10, true)];
    tiles.push({ x, y, columns, rows, levels: new Uint8Array(buffer, at + 12, columns * rows) });
    at += 12 + columns * rows;
  }
  return { baseDb: view.getFloat32(8, true), maximumDb: view.getFloat32(12, true), tiles };
}

/** @param {ArrayBuffer} buffer @returns {LiveTraces} */
function readTraces(buffer) {
  const view = new DataView(buffer);
  const [count, first, bins] = [view.getUint16(2, true), view.getUint32(4, true), view.getUint16(8, true)];
  const traces = Array.from({ length: count }, (_, k) => new Uint8Array(buffer, 12 + k * bins, bins));
  return { first, bins, traces };
}

/**
 * Follows a live image; a connection that ends is opened again, and everything comes again.
 * @param {{begin: () => void, round: (state: LiveState, tiles: LiveTiles | null, traces: LiveTraces | null) => void, lost: () => void}} page
 */
export function follow(page) {
  const address = new URL("live", location.href);
  address.protocol = "ws:";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  /** @type {LiveTiles | null} */
  let tiles = null;
  /** @type {LiveTraces | null} */
  let traces = null;
  socket.addEventListener("open", () => page.begin());
  socket.addEventListener("message", (event) => {
    if (typeof event.data !== "string") {
      const kind = new Uint8Array(event.data, 0, 1)[0];
      if (kind === 1) tiles = readTiles(event.data);
      else traces = readTraces(event.data);
      return;
    }
    const state = /** @type {LiveState} */ (JSON.parse(event.data));
    page.round(state, tiles, traces);
    tiles = traces = null;
    const answer = (/** @type {string} */ word) => socket.readyState === WebSocket.OPEN && socket.send(`${word} ${state.sequence}`);
    // A page that is not in view is drawn when it is looked at.
    if (document.hidden) answer("kept");
    else requestAnimationFrame(() => answer("drawn"));
  });
  socket.addEventListener("close", () => {
    page.lost();
    setTimeout(() => follow(page), AGAIN_MS);
  });
}
