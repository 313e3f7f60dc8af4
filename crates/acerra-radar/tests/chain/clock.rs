//! The even clock underneath whole-millisecond stamps.

use acerra_radar::{ClockBasis, Numbering, recover_clock};
use proptest::prelude::*;

/// Stamps of an even clock, in whole milliseconds.
fn stamps(numbers: &[u32], start_ms: f64, interval_ms: f64) -> Vec<u32> {
    numbers
        .iter()
        .map(|&n| ((start_ms + interval_ms * f64::from(n)) as u64 & 0xffff_ffff) as u32)
        .collect()
}

fn ids(numbers: &[u32]) -> Vec<u16> {
    numbers.iter().map(|&n| n as u16).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any interval, phase, wrap and loss: times are the true ones to a fraction of a millisecond.
    #[test]
    fn true_times_are_recovered(
        interval_ms in 5.0..200.0f64,
        start_ms in prop_oneof![0.0..1e6f64, 4_294_960_000.0..4_294_967_000.0f64],
        keep in proptest::collection::vec(0.0..1.0f64, 100..400),
        with_ids in any::<bool>(),
    ) {
        let numbers: Vec<u32> = keep
            .iter()
            .enumerate()
            .filter(|(i, k)| *i == 0 || **k > 0.1)
            .map(|(i, _)| i as u32)
            .collect();
        let ids = if with_ids { ids(&numbers) } else { vec![0; numbers.len()] };
        let clock = recover_clock(&ids, &stamps(&numbers, start_ms, interval_ms));
        prop_assert_eq!(clock.basis, ClockBasis::EvenRadioClock);
        prop_assert_eq!(clock.stretches.len(), 1);
        prop_assert_eq!(
            clock.numbering,
            if with_ids { Numbering::MessageId } else { Numbering::TimeStamps }
        );
        let lost = u64::from(numbers[numbers.len() - 1]) + 1 - numbers.len() as u64;
        prop_assert_eq!(clock.lost_scans, lost);
        let last = f64::from(numbers[numbers.len() - 1]);
        prop_assert!((clock.interval_s * 1e3 - interval_ms).abs() < 1.5 / last);
        // Where the interval is so near to whole milliseconds that the stamps step only once or twice, such a
        // step in the middle tilts the line by 1.5 ms from end to end.
        let steps = (interval_ms - interval_ms.round()).abs() * last;
        let bound_ms = if steps < 2.0 { 1.5 } else { 1.0 };
        for (time, n) in clock.time_s.iter().zip(&numbers) {
            prop_assert!((time * 1e3 - interval_ms * f64::from(*n)).abs() < bound_ms);
        }
        prop_assert!(clock.residual_max_s < 1e-3);
        prop_assert_eq!(clock.wrapped, start_ms + interval_ms * f64::from(numbers[numbers.len() - 1]) >= 4_294_967_296.0);
    }
}

#[test]
fn a_pause_begins_a_new_stretch_with_its_own_phase() {
    let numbers: Vec<u32> = (0..100).collect();
    let mut all = stamps(&numbers, 1000.0, 21.573);
    all.extend(stamps(&numbers, 1000.0 + 100.0 * 21.573 + 7_777.4, 21.573));
    let ids: Vec<u16> = (0..200).collect();
    let clock = recover_clock(&ids, &all);
    assert_eq!(clock.stretches.len(), 2);
    assert_eq!(clock.stretches[1].first, 100);
    let truth = 100.0 * 21.573 + 7_777.4 + 50.0 * 21.573;
    assert!((clock.time_s[150] * 1e3 - truth).abs() < 1.2);
    let step = clock.time_s[151] - clock.time_s[150];
    assert!(
        (step * 1e3 - 21.573).abs() < 0.02,
        "even within the stretch: {step}"
    );
}

#[test]
fn one_late_stamp_is_put_back_on_the_line() {
    let numbers: Vec<u32> = (0..200).collect();
    let mut all = stamps(&numbers, 5.0, 20.25);
    all[77] += 9;
    let clock = recover_clock(&ids(&numbers), &all);
    assert_eq!((clock.stretches.len(), clock.stray_stamps), (1, 1));
    assert!((clock.time_s[77] * 1e3 - 77.0 * 20.25).abs() < 0.3);
}

#[test]
fn truly_uneven_stamps_are_kept_and_said() {
    // Host-triggered scans: intervals between 40 and 89 ms without a pattern.
    let mut t = 100u32;
    let all: Vec<u32> = (0..300u32)
        .map(|i| {
            t += 40 + i.wrapping_mul(2_654_435_761) % 50;
            t
        })
        .collect();
    let ids: Vec<u16> = (0..300).collect();
    let clock = recover_clock(&ids, &all);
    assert_eq!(clock.basis, ClockBasis::RadioStamps);
    for (time, stamp) in clock.time_s.iter().zip(&all) {
        assert_eq!(*time, f64::from(stamp - all[0]) * 1e-3);
    }
}

#[test]
fn few_scans_keep_their_stamps() {
    assert_eq!(recover_clock(&[1], &[7]).time_s, [0.0]);
    assert!(recover_clock(&[], &[]).time_s.is_empty());
    let two = recover_clock(&[1, 2], &[7, 29]);
    assert_eq!((two.time_s[1], two.interval_s), (22e-3, 22e-3));
}
