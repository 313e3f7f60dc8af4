//! Observations in the form of the filter: dense satellite indices, 0 for "absent".

use super::constellation::Constellation;
use super::noise::noise_power;
use crate::observations::observation::{EPOCH_TOLERANCE_S, ObservationData};
use crate::observations::satellite::System;
use crate::observations::signal::{FREQUENCY_SLOTS, SignalCode};
use acerra_geo::time::GpsTime;

/// Pseudoranges below this (m) are no measurements: 19 000 km less 60 ms of receiver clock.
const SMALLEST_PSEUDORANGE_M: f64 = 1e6;
/// Values beyond this (m or cycles) are no measurements.
const LARGEST_PSEUDORANGE_M: f64 = 1e9;
const LARGEST_PHASE_CYCLES: f64 = 1e10;

/// One satellite at one epoch; in every array 0 means "absent".
#[derive(Debug, Clone)]
pub(crate) struct Measurement {
    pub satellite: usize,
    pub system: System,
    pub first_code: SignalCode,
    pub code_m: [f64; FREQUENCY_SLOTS],
    pub phase_cycles: [f64; FREQUENCY_SLOTS],
    pub doppler_hz: [f64; FREQUENCY_SLOTS],
    pub cn0_db_hz: [f64; FREQUENCY_SLOTS],
    /// Noise over carrier power in one hertz, from C/N₀.
    pub noise_power: [f64; FREQUENCY_SLOTS],
    /// C/N₀ below its usual value of this signal around this time (dB, not negative).
    pub cn0_drop_db: [f64; FREQUENCY_SLOTS],
    pub loss_of_lock: [u8; FREQUENCY_SLOTS],
    /// Slips reported in the whole log up to and including this epoch: two epochs with different counts have
    /// a slip between them, for both directions of the filter and any number of skipped epochs.
    pub slip_count: [u32; FREQUENCY_SLOTS],
    /// Carrier of the slot's signal; 0 when it carries no pseudorange or its channel is unknown.
    pub frequency_hz: [f64; FREQUENCY_SLOTS],
    /// Signal tracked, to notice a change.
    pub signal: [Option<SignalCode>; FREQUENCY_SLOTS],
}

impl Measurement {
    /// First available pseudorange, lowest slot first; 0 when none.
    pub(crate) fn any_pseudorange_m(&self) -> f64 {
        self.code_m.into_iter().find(|&p| p != 0.0).unwrap_or(0.0)
    }
}

/// One epoch of one receiver.
#[derive(Debug, Clone)]
pub(crate) struct Epoch {
    pub tag: GpsTime,
    /// Ascending satellite index, each once.
    pub measurements: Vec<Measurement>,
}

impl Epoch {
    pub(crate) fn find(&self, satellite: usize) -> Option<usize> {
        self.measurements
            .binary_search_by_key(&satellite, |m| m.satellite)
            .ok()
    }
}

fn plausible(value: Option<f64>, largest: f64) -> f64 {
    value
        .filter(|v| v.is_finite() && v.abs() < largest)
        .unwrap_or(0.0)
}

/// The epochs of `data` in time order, tags at least the tolerance apart (the first of two nearer epochs is
/// kept).
pub(crate) fn epochs(data: &ObservationData, constellation: &Constellation) -> Vec<Epoch> {
    let mut order: Vec<usize> = (0..data.epochs.len()).collect();
    order.sort_by_key(|&k| data.epochs[k].time);
    let mut result: Vec<Epoch> = Vec::with_capacity(order.len());
    let mut slips = vec![[0u32; FREQUENCY_SLOTS]; constellation.len()];
    for k in order {
        let source = &data.epochs[k];
        if result
            .last()
            .is_some_and(|last| source.time.seconds_since(last.tag) < EPOCH_TOLERANCE_S)
        {
            continue;
        }
        let mut measurements: Vec<Measurement> = Vec::with_capacity(source.satellites.len());
        for s in &source.satellites {
            let Some(satellite) = constellation.index(s.satellite) else {
                continue;
            };
            let Some(first) = s.signals.iter().flatten().next() else {
                continue;
            };
            let mut m = Measurement {
                satellite,
                system: s.satellite.system(),
                first_code: s.signals[0].map_or(first.code, |s| s.code),
                code_m: [0.0; FREQUENCY_SLOTS],
                phase_cycles: [0.0; FREQUENCY_SLOTS],
                doppler_hz: [0.0; FREQUENCY_SLOTS],
                cn0_db_hz: [0.0; FREQUENCY_SLOTS],
                noise_power: [0.0; FREQUENCY_SLOTS],
                cn0_drop_db: [0.0; FREQUENCY_SLOTS],
                loss_of_lock: [0; FREQUENCY_SLOTS],
                slip_count: slips[satellite],
                frequency_hz: [0.0; FREQUENCY_SLOTS],
                signal: [None; FREQUENCY_SLOTS],
            };
            for (slot, signal) in s.signals.iter().enumerate() {
                let Some(signal) = signal else { continue };
                // No satellite is nearer than this, whatever the receiver's clock.
                m.code_m[slot] = plausible(
                    signal
                        .pseudorange_m
                        .filter(|range_m| *range_m > SMALLEST_PSEUDORANGE_M),
                    LARGEST_PSEUDORANGE_M,
                );
                m.phase_cycles[slot] = plausible(signal.phase_cycles, LARGEST_PHASE_CYCLES);
                m.doppler_hz[slot] = plausible(signal.doppler_hz, 1e6);
                m.cn0_db_hz[slot] = plausible(signal.cn0_db_hz, 1e3);
                m.noise_power[slot] = noise_power(m.cn0_db_hz[slot]);
                m.loss_of_lock[slot] = signal.loss_of_lock.0 & 3;
                if signal.loss_of_lock.slipped() {
                    slips[satellite][slot] += 1;
                    m.slip_count[slot] = slips[satellite][slot];
                }
                m.signal[slot] = Some(signal.code);
                if m.code_m[slot] != 0.0 {
                    m.frequency_hz[slot] = constellation.frequency_hz(satellite, signal.code);
                }
            }
            measurements.push(m);
        }
        measurements.sort_by_key(|m| m.satellite);
        measurements.dedup_by_key(|m| m.satellite);
        result.push(Epoch {
            tag: source.time,
            measurements,
        });
    }
    note_weak_signals(&mut result, constellation.len());
    result
}

/// Span over which a signal's usual strength is computed (s).
const USUAL_STRENGTH_SPAN_S: f64 = 600.0;

/// Compares every signal's C/N₀ with the upper quartile of that signal's values in the same span of time.
fn note_weak_signals(epochs: &mut [Epoch], satellites: usize) {
    let Some(first) = epochs.first().map(|e| e.tag) else {
        return;
    };
    let mut start = 0;
    while start < epochs.len() {
        let span = |tag: GpsTime| (tag.seconds_since(first) / USUAL_STRENGTH_SPAN_S).floor();
        let this = span(epochs[start].tag);
        let end = start
            + epochs[start..]
                .iter()
                .take_while(|e| span(e.tag) == this)
                .count();
        let mut strengths = vec![Vec::new(); satellites * FREQUENCY_SLOTS];
        for m in epochs[start..end].iter().flat_map(|e| &e.measurements) {
            for slot in (0..FREQUENCY_SLOTS).filter(|&s| m.cn0_db_hz[s] > 0.0) {
                strengths[m.satellite * FREQUENCY_SLOTS + slot].push(m.cn0_db_hz[slot]);
            }
        }
        let usual: Vec<f64> = strengths
            .into_iter()
            .map(|mut values| {
                values.sort_by(f64::total_cmp);
                values.get(values.len() * 3 / 4).copied().unwrap_or(0.0)
            })
            .collect();
        for m in epochs[start..end]
            .iter_mut()
            .flat_map(|e| &mut e.measurements)
        {
            for slot in (0..FREQUENCY_SLOTS).filter(|&s| m.cn0_db_hz[s] > 0.0) {
                let below = usual[m.satellite * FREQUENCY_SLOTS + slot] - m.cn0_db_hz[slot];
                m.cn0_drop_db[slot] = below.max(0.0);
            }
        }
        start = end;
    }
}
