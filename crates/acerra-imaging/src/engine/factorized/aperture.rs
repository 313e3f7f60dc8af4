//! Sub-apertures.

use crate::pulses::Pulses;
use crate::vector::range_m;
use std::ops::Range;

/// A step this many times the median step separates tracks: a turn, or a gap.
const BREAK: f64 = 8.0;

/// Partitions the aperture into sub-apertures of at most `count` pulses: tracks, each divided as evenly as
/// possible. No sub-aperture extends across a gap, where directions would differ too much for a coarse grid.
pub(crate) fn partition_aperture(pulses: &Pulses, count: usize) -> Vec<Range<usize>> {
    let position = pulses.position_m();
    let steps: Vec<f64> = position.windows(2).map(|p| range_m(p[0], p[1])).collect();
    let mut sorted = steps.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let mut parts = Vec::new();
    let mut start = 0;
    for end in 1..=position.len() {
        let broken = end == position.len() || (median > 0.0 && steps[end - 1] > BREAK * median);
        if broken {
            parts.extend(evenly(start..end, count));
            start = end;
        }
    }
    parts
}

/// The sub-apertures `parts`, each divided into shorter ones of at most `count` pulses.
pub(crate) fn divided(parts: &[Range<usize>], count: usize) -> Vec<Range<usize>> {
    (parts.iter())
        .flat_map(|part| evenly(part.clone(), count))
        .collect()
}

/// Pieces of at most `count` pulses, as even as possible.
fn evenly(Range { start, end }: Range<usize>, count: usize) -> impl Iterator<Item = Range<usize>> {
    let (length, pieces) = (end - start, (end - start).div_ceil(count.max(1)));
    (0..pieces).map(move |k| start + k * length / pieces..start + (k + 1) * length / pieces)
}

/// Mean position of some pulses, m.
pub(crate) fn centre_m(pulses: &Pulses, which: Range<usize>) -> [f64; 3] {
    let p = &pulses.position_m()[which];
    std::array::from_fn(|a| p.iter().map(|p| p[a]).sum::<f64>() / p.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulses::PulseArrays;

    #[test]
    fn apertures_are_partitioned_completely_and_at_gaps() {
        let pulses_at = |position_m: &[[f64; 3]], count: usize| {
            let spectrum = vec![num_complex::Complex64::ZERO; position_m.len()];
            let weight = vec![1.0; position_m.len()];
            let pulses = Pulses::new(PulseArrays {
                position_m,
                frequency_hz: &[3e9],
                spectrum: &spectrum,
                weight: &weight,
                light_speed_m_s: 3e8,
            })
            .unwrap();
            partition_aperture(&pulses, count)
        };
        for (number, count) in [(331, 32), (7, 8), (64, 16), (65, 16), (1, 8)] {
            let line: Vec<_> = (0..number)
                .map(|m| [0.0, 0.1 * f64::from(m), 5.0])
                .collect();
            let parts = pulses_at(&line, count);
            assert_eq!(
                (parts[0].start, parts[parts.len() - 1].end),
                (0, line.len())
            );
            assert!(parts.windows(2).all(|p| p[0].end == p[1].start));
            assert!(parts.iter().all(|p| !p.is_empty() && p.len() <= count));
        }
        // Two tracks of 20 and 15 pulses, 3 m apart.
        let mut tracks: Vec<_> = (0..20).map(|m| [0.0, 0.1 * f64::from(m), 5.0]).collect();
        tracks.extend((0..15).map(|m| [3.0, 0.1 * f64::from(m), 5.0]));
        assert_eq!(pulses_at(&tracks, 16), [0..10, 10..20, 20..35]);
        let shorter = divided(&pulses_at(&tracks, 16), 6);
        assert_eq!(
            shorter,
            [0..5, 5..10, 10..15, 15..20, 20..25, 25..30, 30..35]
        );
        // A drone that hovers has no median step.
        assert_eq!(pulses_at(&[[0.0, 0.0, 5.0]; 9], 5), [0..4, 4..9]);
    }
}
