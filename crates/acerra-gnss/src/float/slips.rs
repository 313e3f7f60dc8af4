//! Cycle slips: from loss-of-lock flags, from the geometry-free combination, from Doppler, and
//! from a change of the signal tracked.

use super::state::{FilterState, Track};
use crate::measurements::common::Common;
use crate::measurements::measurement::{Epoch, Measurement};
use crate::observations::observation::{EPOCH_TOLERANCE_S, LossOfLock};
use crate::options::PpkOptions;
use acerra_geo::time::GpsTime;

/// Inputs of slip detection at an epoch.
pub(crate) struct SlipView<'a> {
    pub options: &'a PpkOptions,
    pub common: &'a [Common],
    pub wavelengths_m: &'a [[f64; 3]],
    pub rover: &'a Epoch,
    pub base: &'a Epoch,
    pub backward: bool,
}

/// Flags the slips of this epoch in the tracks of the common satellites.
pub(crate) fn detect(state: &mut FilterState, view: &SlipView<'_>) {
    let &SlipView {
        options,
        common,
        wavelengths_m,
        rover,
        base,
        backward,
    } = view;
    for slot in 0..options.frequencies {
        let doppler = [(0, rover), (1, base)].map(|(receiver, epoch)| {
            (options.detects_slips_by_doppler())
                .then(|| doppler_outliers(state, options, common, slot, receiver, epoch))
        });
        for (k, c) in common.iter().enumerate() {
            let (u, b) = (&rover.measurements[c.rover], &base.measurements[c.base]);
            let track = state.track_mut(c.satellite, slot);
            track.flags = 0;
            for (receiver, m, tag) in [(0, u, rover.tag), (1, b, base.tag)] {
                loss_of_lock(track, options, receiver, m, slot, tag, backward);
                if doppler[receiver]
                    .as_ref()
                    .is_some_and(|outliers| outliers[k])
                {
                    track.flags |= LossOfLock::SLIP;
                }
            }
            track.half_cycle_known =
                (u.loss_of_lock[slot] | b.loss_of_lock[slot]) & LossOfLock::HALF_CYCLE == 0;
        }
    }
    for slot in 1..options.frequencies {
        for (k, c) in common.iter().enumerate() {
            let difference = |s: usize| {
                let (u, b) = (
                    rover.measurements[c.rover].phase_cycles[s],
                    base.measurements[c.base].phase_cycles[s],
                );
                let wavelength = wavelengths_m[k][s];
                (u != 0.0 && b != 0.0 && wavelength != 0.0).then_some((u - b) * wavelength)
            };
            let (Some(first), Some(second)) = (difference(0), difference(slot)) else {
                continue;
            };
            let now = first - second;
            let before = state
                .track_mut(c.satellite, slot)
                .geometry_free_m
                .replace(now);
            if before.is_some_and(|before| (now - before).abs() > options.slip_threshold_m) {
                state.track_mut(c.satellite, 0).flags |= LossOfLock::SLIP;
                state.track_mut(c.satellite, slot).flags |= LossOfLock::SLIP;
            }
        }
    }
}

fn is_repeated(track: &Track, receiver: usize, tag: GpsTime) -> bool {
    track.phase_tag[receiver].is_some_and(|last| tag.seconds_since(last).abs() < EPOCH_TOLERANCE_S)
}

fn loss_of_lock(
    track: &mut Track,
    options: &PpkOptions,
    receiver: usize,
    m: &Measurement,
    slot: usize,
    tag: GpsTime,
    backward: bool,
) {
    let current = m.loss_of_lock[slot];
    let stored = track.stored_lli[receiver];
    if options.policy().sees_flags_of_processed_only() {
        if m.phase_cycles[slot] != 0.0 && !is_repeated(track, receiver, tag) {
            track.flags |= if backward { stored } else { current };
            if (stored ^ current) & LossOfLock::HALF_CYCLE != 0 {
                track.flags |= LossOfLock::SLIP;
            }
            track.stored_lli[receiver] = current;
        }
        return;
    }
    if track.last_slip_count[receiver].is_some_and(|before| before != m.slip_count[slot]) {
        track.flags |= LossOfLock::SLIP;
    }
    track.last_slip_count[receiver] = Some(m.slip_count[slot]);
    if m.phase_cycles[slot] == 0.0 {
        return;
    }
    // The half-cycle flag of the arc; backward, RTKLIB includes the later epoch's flag.
    track.flags |= current & LossOfLock::HALF_CYCLE;
    if (stored ^ current) & LossOfLock::HALF_CYCLE != 0 {
        track.flags |= LossOfLock::SLIP;
    }
    track.stored_lli[receiver] = current;
    let changed = matches!(
        (track.last_signal[receiver], m.signal[slot]),
        (Some(before), Some(now)) if before != now
    );
    if changed {
        track.flags |= LossOfLock::SLIP;
    }
    track.last_signal[receiver] = m.signal[slot];
}

/// Common satellites whose phase change disagrees with their Doppler shift, after removal of the receiver's
/// clock as the mean over the satellites that agree.
fn doppler_outliers(
    state: &FilterState,
    options: &PpkOptions,
    common: &[Common],
    slot: usize,
    receiver: usize,
    epoch: &Epoch,
) -> Vec<bool> {
    let threshold = options.doppler_slip_threshold_cycles_s;
    let excess: Vec<Option<f64>> = common
        .iter()
        .map(|c| {
            let m = &epoch.measurements[if receiver == 0 { c.rover } else { c.base }];
            let track = state.track(c.satellite, slot);
            let (phase, doppler) = (m.phase_cycles[slot], m.doppler_hz[slot]);
            let last = track.phase_tag[receiver]?;
            let elapsed_s = epoch.tag.seconds_since(last);
            (phase != 0.0 && doppler != 0.0 && elapsed_s.abs() >= EPOCH_TOLERANCE_S)
                .then(|| (phase - track.last_phase_cycles[receiver]) / elapsed_s + doppler)
        })
        .collect();
    let agreeing: Vec<f64> = excess
        .iter()
        .flatten()
        .copied()
        .filter(|e| e.abs() < 3.0 * threshold)
        .collect();
    if agreeing.is_empty() {
        return vec![false; common.len()];
    }
    let mean = agreeing.iter().sum::<f64>() / agreeing.len() as f64;
    excess
        .iter()
        .map(|e| e.is_some_and(|e| (e - mean).abs() > threshold))
        .collect()
}

/// Stores the phases of this epoch for every satellite of the filter.
pub(crate) fn remember(
    state: &mut FilterState,
    options: &PpkOptions,
    receiver: usize,
    epoch: &Epoch,
) {
    for m in &epoch.measurements {
        for slot in 0..options.frequencies {
            if m.phase_cycles[slot] != 0.0 {
                let track = state.track_mut(m.satellite, slot);
                track.phase_tag[receiver] = Some(epoch.tag);
                track.last_phase_cycles[receiver] = m.phase_cycles[slot];
            }
        }
    }
}
