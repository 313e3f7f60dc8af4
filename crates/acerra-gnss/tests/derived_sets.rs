//! Logs derived from the real sets by what receivers, places and settings vary in: no fix may be wrong
//! and certain.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_gnss::{
    AmbiguityMode, FilterDirection, PositioningMode, PpkOptions, Quality, SystemSet, process,
};
use rtklib::derived::{Judged, Known, cut, slipping, variation};
use rtklib::sets::{GEONET, STATIC_1HZ, STATIC_M8P, Set, WALK, WETTZELL};
use rtklib::trust::default_options;

/// Draws of every set in the slow validation.
const DRAWS: u64 = 60;

/// Judges a window of the still pair by changed defaults.
fn still(start_s: f64, length_s: f64, change: impl Fn(PpkOptions) -> PpkOptions) -> Option<Judged> {
    let mut known = Known::read(&STATIC_M8P)?;
    let start = known.logs.rover.epochs[0].time + start_s;
    cut(&mut known.logs.rover, start, length_s);
    let options = change(known.options());
    let logs = &known.logs;
    let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
    Some(known.judge(&solution))
}

/// A backward pass that starts from the forward pass's integers repeats them, right or wrong: counted as a
/// confirmation, they put all 39 fixes of this window 0.6 m off.
#[test]
fn a_pass_that_starts_from_anothers_integers_confirms_none() {
    let low = f64::to_radians(35.0);
    let judged = still(886.0, 60.0, |options| {
        options
            .with_direction(FilterDirection::CombinedWithoutReset)
            .with_mode(PositioningMode::Static)
            .with_elevation_mask_rad(low)
    });
    let Some(judged) = judged else { return };
    assert_eq!(judged.wrong, 0, "{judged:?}");
}

/// Both passes agree on places 1.1 m off, and at other epochs of the same unbroken phases on the right one;
/// or on four satellites, whose integers agree with some place whatever they are, or five, which hardly check them.
#[test]
fn what_passes_agree_on_is_wrong_where_unbroken_phases_contradict_it() {
    for (exchanged, seed) in [
        (false, 27),
        (false, 28),
        (false, 45),
        (true, 54),
        (true, 130),
    ] {
        let Some(known) = Known::read(&STATIC_M8P) else {
            return;
        };
        let known = if exchanged { known.exchanged() } else { known };
        let (logs, options, words) = variation(&known, seed);
        let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
        assert_eq!(known.judge(&solution).wrong, 0, "{words}");
    }
}

/// Fixes of logs in which most satellites slip at once, and some of the rest unnoticed.
fn judge_slipping(
    known: &Known,
    seeds: std::ops::Range<u64>,
    unflagged: usize,
    change: impl Fn(PpkOptions) -> PpkOptions,
) -> Judged {
    let mut all = Judged::default();
    for seed in seeds {
        let logs = slipping(known, seed, unflagged);
        let options = change(known.options());
        let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
        let own = known.judge(&solution);
        all.fixed += own.fixed;
        all.wrong += own.wrong;
        all.wrong_and_certain += own.wrong_and_certain;
    }
    all
}

/// The satellites that carry the integers over are few, and one of them has slipped: what it changes passes
/// for a motion, which the ambiguities that begin anew and the pass in the other direction contradict.
#[test]
fn a_slip_that_nobody_flagged_is_not_a_motion_where_most_satellites_slip() {
    let Some(known) = Known::read(&STATIC_M8P) else {
        return;
    };
    for unflagged in [1, 2] {
        let forward = |o: PpkOptions| o.with_direction(FilterDirection::Forward);
        let judged = judge_slipping(&known, 0..16, unflagged, forward);
        assert_eq!(judged.wrong, 0, "{unflagged}: {judged:?}");
        assert!(judged.fixed > 1_500, "{unflagged}: {judged:?}");
    }
}

/// Draws that two rules decide. Where ambiguities that begin anew need not be whole at the held place, 18 fixes
/// of both passes together are wrong in the first; where a fix that is only linked to confirmed ones stands
/// against a pass that is certain of another place, 17 of a forward pass are in the second and 8 in the third.
#[test]
fn slips_that_nobody_flagged_are_no_motion_by_two_systems() {
    let [Some(still), Some(mosaic)] = [&STATIC_M8P, &STATIC_1HZ].map(Known::read) else {
        return;
    };
    let (forward, combined) = (FilterDirection::Forward, FilterDirection::Combined);
    for (known, direction, unflagged, seed) in [
        (&still, combined, 2, 23),
        (&still, forward, 1, 63),
        (&mosaic, forward, 2, 44),
    ] {
        let change = |o: PpkOptions| {
            let systems = SystemSet::GPS.with(acerra_gnss::System::Glonass);
            o.with_direction(direction).with_systems(systems)
        };
        let judged = judge_slipping(known, seed..seed + 1, unflagged, change);
        assert_eq!(judged.wrong, 0, "{seed}: {judged:?}");
        assert!(judged.fixed > 100, "{seed}: {judged:?}");
    }
}

/// A code's multipath does not average out the sooner for its ambiguity beginning anew at every epoch.
#[test]
fn static_positions_of_ambiguities_resolved_one_by_one_state_their_errors() {
    let Some(mut known) = Known::read(&STATIC_M8P) else {
        return;
    };
    let start = known.logs.rover.epochs[0].time + 592.0;
    cut(&mut known.logs.rover, start, 300.0);
    let options = known
        .options()
        .with_mode(PositioningMode::Static)
        .with_ambiguity(AmbiguityMode::Instantaneous)
        .with_systems(SystemSet::GPS);
    let logs = &known.logs;
    let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
    let floats = solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Float);
    let beyond = floats.clone().filter(|e| {
        let off = (0..3).map(|k| e.position_ecef_m[k] - known.rover_ecef_m[k]);
        let squared_m2: f64 = off.map(|d| d * d).sum();
        let variance_m2: f64 = (0..3).map(|k| e.covariance_ecef_m2[k][k]).sum();
        squared_m2 > 9.0 * variance_m2
    });
    assert!(floats.count() > 100);
    assert_eq!(beyond.count(), 0);
    assert_eq!(known.judge(&solution).wrong, 0);
}

/// Two minutes in which integers 1.9 m off fit ten phases better than the right ones: reflections speak
/// for them at every epoch alike. The whole log and RTKLIB-EX agree on the place, 1.3 m below the base.
#[test]
fn what_phases_say_again_and_again_counts_once() {
    let Some(mut logs) = WALK.read() else { return };
    let start = logs.rover.epochs[0].time + 977.2;
    cut(&mut logs.rover, start, 120.0);
    let options = default_options(&WALK).with_direction(FilterDirection::Forward);
    let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
    let base = solution.base_position_ecef_m.unwrap();
    assert!(solution.epochs.len() > 100);
    let high =
        solution.epochs.iter().take(40).filter(|e| {
            e.quality == Quality::Fixed && rtklib::enu(base, e.position_ecef_m)[2] > -0.8
        });
    assert_eq!(high.count(), 0);
}

#[test]
#[ignore = "hundreds of solutions; cargo xtask validate, as CI does"]
fn validation_few_fixes_of_derived_logs_are_wrong_and_certain() {
    let sets: [&'static Set; 4] = [&STATIC_M8P, &GEONET, &WETTZELL, &STATIC_1HZ];
    let (mut fixed, mut certain) = (0, 0);
    for (exchanged, set) in [false, true].iter().flat_map(|x| sets.map(|set| (*x, set))) {
        let Some(known) = Known::read(set) else {
            return;
        };
        let known = if exchanged { known.exchanged() } else { known };
        let mut all = Judged::default();
        for seed in 0..DRAWS {
            let (logs, options, words) = variation(&known, seed);
            let solved = process(&logs.rover, &logs.base, &logs.navigation, &options);
            // Draws may leave nothing in common.
            let Ok(solution) = solved else { continue };
            let own = known.judge(&solution);
            if own.wrong > 0 {
                println!("{}, {seed}: {words}: {own:?}", set.name);
            }
            all.fixed += own.fixed;
            all.wrong += own.wrong;
            all.wrong_and_certain += own.wrong_and_certain;
        }
        println!("{}, exchanged {exchanged}: {all:?}", set.name);
        fixed += all.fixed;
        certain += all.wrong_and_certain;
    }
    assert!(fixed > 26_000, "{fixed}");
    // None as this is written; other draws have some.
    assert!(5_000 * certain < fixed, "{certain} of {fixed}");
}

#[test]
#[ignore = "hundreds of solutions; cargo xtask validate, as CI does"]
fn validation_slips_that_nobody_flagged_where_most_satellites_slip() {
    let (mut fixed, mut wrong) = (0, 0);
    for set in [&STATIC_M8P, &STATIC_1HZ] {
        let Some(known) = Known::read(set) else {
            return;
        };
        for direction in [FilterDirection::Forward, FilterDirection::Combined] {
            for unflagged in [1, 2] {
                let change = |o: PpkOptions| {
                    // Five systems leave little to mistake.
                    let systems = SystemSet::GPS.with(acerra_gnss::System::Glonass);
                    o.with_direction(direction).with_systems(systems)
                };
                let judged = judge_slipping(&known, 0..DRAWS, unflagged, change);
                println!(
                    "{}, {direction:?}, {unflagged} unflagged: {judged:?}",
                    set.name
                );
                fixed += judged.fixed;
                wrong += judged.wrong;
            }
        }
    }
    // Few satellites of which two have slipped agree with a motion (docs/validation/ppk-derived.md).
    assert!(fixed > 50_000, "{fixed}");
    assert!(500 * wrong < fixed, "{wrong} of {fixed}");
}
