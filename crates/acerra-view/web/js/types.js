// Shapes of what the server answers.

/** @typedef {{x0_m: number, y0_m: number, z_m: number, pixel_m: number, nx: number, ny: number, uneven: boolean}} Grid */
/** @typedef {{zero_db: number, maximum_db: number, floor_db: number, half_db: number, gain: boolean}} Display */
/** @typedef {{rayleigh_m: number | null, width_3db_m: number | null, inner_m?: number | null, outer_m?: number | null}} Width */
/** @typedef {{x_m: number, y_m: number, z_m: number, level_db: number, along: Width, across: Width, theory?: Theory, pslr_db: number | null, islr_db: number | null, place_deg_m: number[] | null, sigma_along_across_m: number[] | null}} Target */
/** @typedef {{along_m?: number, across_m?: number}} Theory */
/** @typedef {{name: string, verdict: string, explanation: string, measured?: unknown, expected?: unknown}} Finding */
/** @typedef {{version: string, evidence: Finding[], unchecked: {setting: string, explanation: string}[], warnings: string[], configuration: Settings}} RunRecord */
/** @typedef {{z0_m: number, step_m: number, slices: number, levels: {x: number, y: number, z: number}}} Volume */
/** @typedef {{stride: number, columns: number, rows: number, height_m: number[]}} Terrain */
/** @typedef {{name: string, grid: Grid, levels: number, display: Display, volume: Volume | null, origin_deg_m: number[] | null, record: RunRecord, targets: {targets: Target[], surveyed?: {name: string, x_m: number, y_m: number}[]}, files: string[]}} RunMeta */
/** @typedef {{version: string, runs: {name: string, directory: string}[], basemap: {template: string} | null, tile: number}} Runs */
/** @typedef {{trace: number[], time_s: number[], position_m: (number | null)[][], sigma_m: (number | null)[][], status: string[], flag: string[], gpst: string[], line_starts: number[]}} Track */
/** @typedef {{trace: number, range_m: number, incidence_deg: number}} Seen */
/** @typedef {{place_m: number[], place_deg_m: number[] | null, pixel: number[] | null, value: number[] | null, level_db: number | null, phase_deg: number | null, seen: Seen | null}} Cursor */
/** @typedef {{traces: number, samples: number, fast_time_start_ns: number, fast_time_step_ns: number, levels: number, shift_ns: number, gate_ns: number[] | null, maximum_raw: number, maximum_clean: number}} RadargramMeta */
/** @typedef {{name: string, unit: string, first_pulse: number, pulses: number, time_offset_s: number, radargram: RadargramMeta | null, has_sky: boolean}} TrackMeta */
/** @typedef {{name: string, time_s: number[], direction_deg: ([number, number] | null)[], cn0_db_hz: (number | null)[][]}} SatelliteInSky */
/** @typedef {{preprocess: {background: unknown, gate_ns: unknown}, image: {band_ghz: number[], z_m: unknown, light_speed_m_s: number, terrain: string | null}}} Settings */
/** @typedef {{revision: number, tracks: TrackMeta[], trace: number[], time_s: number[], position_m: number[][], line_starts: number[], height_m: number[], settings: Settings, light_speed_m_s: number, soil: import("./depth.js").Soil}} EngineData */
/** @typedef {{state: "idle" | "reading" | "ready" | "failed", reason?: string, data?: EngineData}} EngineStatus */
/** @typedef {{place_m: number[], fast_time_ns: number[], incidence_deg: number[], apex: number | null}} Hyperbola */
/** @typedef {{pulse: number, range_m: number, incidence_deg: number | null, places_m: number[][]}} Ring */
/** @typedef {{x0_m: number, y0_m: number, pixel_m: number, nx: number, ny: number, z_m?: number}} View */
/** @typedef {{gate_ns?: unknown, background?: unknown, band_ghz?: number[], delay_change_ns?: number, time_offset_change_s?: number, z_m?: number, light_speed_m_s?: number}} Edits */
/** @typedef {{view: View, edits: Edits, pulses: number[] | null, coherence?: boolean}} ImageOrder */
/** @typedef {{values: Float32Array, maximum_db: number | null, pulses: number, cleaning_ms: number, imaging_ms: number, revision: number}} Made */

export {};
