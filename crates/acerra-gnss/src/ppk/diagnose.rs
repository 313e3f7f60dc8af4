//! Warnings about the input: missing navigation data, gaps, unusable signals.

use crate::measurements::constellation::{Constellation, Unusable};
use crate::measurements::measurement::Epoch;
use crate::measurements::signal_group::SignalGroup;
use crate::observations::observation::ObservationData;
use crate::observations::satellite::System;
use crate::options::{AmbiguityMode, PpkOptions};
use crate::solution::{BaseGap, MissingNavigation, PpkWarning};
use crate::stations::epoch_input::RoverEpoch;

/// Warnings for groups of signals that contradict the others, named by the rover's first signal.
pub(crate) fn contradicting_groups(
    rover: &[RoverEpoch],
    groups: &[SignalGroup],
    warnings: &mut Vec<PpkWarning>,
) {
    for group in groups {
        let measured = rover.iter().flat_map(|e| &e.epoch.measurements);
        let mut own = measured.filter(|m| m.system == group.system());
        warnings.push(PpkWarning::SignalsContradict {
            system: group.system(),
            signal: own.find_map(|m| m.signal[group.slot]),
        });
    }
}

/// Satellites observed without a usable ephemeris or channel, and systems without any.
pub(crate) fn missing_navigation(
    constellation: &Constellation,
    rover: &[RoverEpoch],
    warnings: &mut Vec<PpkWarning>,
) {
    let mut missing: Vec<Option<MissingNavigation>> = vec![None; constellation.len()];
    for epoch in rover {
        for (m, state) in epoch.epoch.measurements.iter().zip(&epoch.states) {
            let id = constellation.id(m.satellite);
            let no_ephemeris = matches!(state, Err(Unusable::NoEphemeris));
            let no_channel =
                id.system() == System::Glonass && constellation.channel(m.satellite).is_none();
            if !no_ephemeris && !no_channel {
                continue;
            }
            let tag = epoch.epoch.tag;
            let entry = missing[m.satellite].get_or_insert(MissingNavigation {
                satellite: id,
                span: (tag, tag),
                epochs: 0,
                channel_missing: no_channel && !no_ephemeris,
            });
            entry.span.1 = tag;
            entry.epochs += 1;
        }
    }
    for system in System::ALL {
        let mut members =
            (0..constellation.len()).filter(|&k| constellation.id(k).system() == system);
        let silent =
            members.clone().next().is_some() && members.all(|k| !constellation.has_ephemerides(k));
        if silent {
            warnings.push(PpkWarning::SystemWithoutNavigation(system));
        } else {
            warnings.extend(
                missing
                    .iter()
                    .flatten()
                    .filter(|m| m.satellite.system() == system)
                    .cloned()
                    .map(PpkWarning::MissingNavigation),
            );
        }
    }
}

/// Holes in the base's log during the rover's.
pub(crate) fn base_gaps(
    base: &[Epoch],
    rover: &[RoverEpoch],
    options: &PpkOptions,
    warnings: &mut Vec<PpkWarning>,
) {
    let (Some(first), Some(last)) = (rover.first(), rover.last()) else {
        return;
    };
    for pair in base.windows(2) {
        let (from, to) = (pair[0].tag, pair[1].tag);
        let inside = to >= first.epoch.tag && from <= last.epoch.tag;
        if inside && to.seconds_since(from) > options.max_age_s {
            warnings.push(PpkWarning::BaseGap(BaseGap { from, to }));
        }
    }
}

/// Logs whose phases cannot be resolved, and logs that are identical.
pub(crate) fn phases_and_copies(
    rover: &ObservationData,
    base: &ObservationData,
    options: &PpkOptions,
    warnings: &mut Vec<PpkWarning>,
) {
    if !rover.epochs.is_empty() && rover.epochs == base.epochs {
        warnings.push(PpkWarning::IdenticalFiles);
    }
    if options.ambiguity == AmbiguityMode::Off {
        return;
    }
    for (data, is_base) in [(rover, false), (base, true)] {
        let usable = data
            .epochs
            .iter()
            .flat_map(|e| &e.satellites)
            .filter(|s| options.systems.contains(s.satellite.system()))
            .flat_map(|s| s.signals.iter().flatten())
            .any(|s| s.phase_cycles.is_some() && !s.loss_of_lock.half_cycle_unknown());
        if !usable {
            warnings.push(PpkWarning::NoUsablePhases { base: is_base });
        }
    }
}
