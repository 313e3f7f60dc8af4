//! Looks: the aperture is partitioned along the track; each part gives a separate image, and their powers are
//! summed.
//!
//! Looks see a place from different directions: their speckle differs, and the mean of their
//! powers fluctuates less (by the square root of their number where they do not overlap), at the
//! price of along-track resolution.

use crate::error::ImagingError;
use num_complex::Complex32;
use std::f64::consts::TAU;
use std::ops::Range;

/// Taper of the pulses of a look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum LookWindow {
    /// Equal weight of all pulses.
    #[default]
    Rectangular,
    /// ½ − ½ cos over the look's path, for lower sidelobes along the track.
    Hann,
}

/// One look: consecutive pulses and their weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Pulses of the look.
    pub pulses: Range<usize>,
    /// Weight of each pulse by the window.
    pub weight: Vec<f64>,
}

/// Partitions a track into `count` looks of equal path, each sharing the part `overlap` of its path with
/// the next.
///
/// # Errors
/// No look, fewer pulses than looks, an overlap outside [0, 1), a look without pulses (a gap of the
/// track).
///
/// ```
/// use acerra_imaging::looks::{LookWindow, looks};
/// let track: Vec<[f64; 3]> = (0..101).map(|m| [0.0, 0.02 * f64::from(m), 5.0]).collect();
/// let four = looks(&track, 4, 0.0, LookWindow::Rectangular)?;
/// assert_eq!(four[1].pulses, 25..50);
/// assert_eq!(four[3].pulses.end, 101);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn looks(
    position_m: &[[f64; 3]],
    count: usize,
    overlap: f64,
    window: LookWindow,
) -> Result<Vec<Look>, ImagingError> {
    if count == 0 || position_m.len() < count {
        return Err(ImagingError::OutOfRange {
            what: "looks",
            expected: "at least 1, and not more than pulses",
            found: count as f64,
        });
    }
    if !(0.0..1.0).contains(&overlap) {
        return Err(ImagingError::OutOfRange {
            what: "look overlap",
            expected: "at least 0 and below 1",
            found: overlap,
        });
    }
    let mut path_m = Vec::with_capacity(position_m.len());
    let mut so_far = 0.0;
    for (k, p) in position_m.iter().enumerate() {
        if k > 0 {
            so_far += crate::vector::range_m(*p, position_m[k - 1]);
        }
        path_m.push(so_far);
    }
    if so_far <= 0.0 {
        // A radar at rest: partitioned by number of pulses.
        path_m = (0..position_m.len()).map(|k| k as f64).collect();
        so_far = (position_m.len() - 1).max(1) as f64;
    }
    let length = so_far / (1.0 + (count - 1) as f64 * (1.0 - overlap));
    (0..count)
        .map(|k| {
            // A small margin inwards, so that rounding does not move a pulse on the boundary.
            let margin = 1e-9 * so_far;
            let from = k as f64 * length * (1.0 - overlap);
            let first = path_m.partition_point(|s| *s < from - margin);
            let end = if k + 1 == count {
                path_m.len()
            } else {
                path_m.partition_point(|s| *s < from + length - margin)
            };
            if first >= end {
                return Err(ImagingError::Empty { what: "look" });
            }
            let weight = path_m[first..end]
                .iter()
                .map(|s| match window {
                    LookWindow::Rectangular => 1.0,
                    // The window extends half a pulse's path beyond the ends, so that the end pulses have
                    // some weight.
                    LookWindow::Hann => {
                        let margin = 0.5 * length / (end - first) as f64;
                        let at = (s - from + margin) / (length + 2.0 * margin);
                        0.5 - 0.5 * (TAU * at.clamp(0.0, 1.0)).cos()
                    }
                })
                .collect();
            Ok(Look {
                pulses: first..end,
                weight,
            })
        })
        .collect()
}

/// Adds the power of a look's image to `power`; a multilook image is the sum over looks, divided by
/// their number.
///
/// # Errors
/// Arrays of different lengths.
pub fn add_power(power: &mut [f32], look: &[Complex32]) -> Result<(), ImagingError> {
    crate::checks::check_length("look", power.len(), look.len())?;
    for (p, v) in power.iter_mut().zip(look) {
        *p += v.norm_sqr();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(pulses: u32) -> Vec<[f64; 3]> {
        (0..pulses)
            .map(|m| [0.1 * f64::from(m), 0.0, 3.0])
            .collect()
    }

    #[test]
    fn looks_cover_the_track_and_overlap_as_asked() {
        let half = looks(&line(91), 3, 0.5, LookWindow::Hann).unwrap();
        let ends: Vec<_> = half.iter().map(|l| l.pulses.clone()).collect();
        // 9 m: looks of 4.5 m, every 2.25 m.
        assert_eq!(ends, [0..45, 23..68, 45..91]);
        for look in &half {
            assert_eq!(look.weight.len(), look.pulses.len());
            let middle = look.weight[look.weight.len() / 2];
            assert!(middle > 0.99 && look.weight[0] < 0.01 && look.weight[0] > 0.0);
        }
        // Looks have equal path, not equal numbers of pulses: hovering adds no look.
        let mut hovering = vec![[0.0, 0.0, 3.0]; 100];
        hovering.extend(line(101));
        let two = looks(&hovering, 2, 0.0, LookWindow::Rectangular).unwrap();
        assert_eq!(two[1].pulses.start, 150);
        let standing = looks(&[[0.0; 3]; 8], 2, 0.0, LookWindow::Rectangular).unwrap();
        assert_eq!(standing[0].pulses.len() + standing[1].pulses.len(), 8);
    }

    #[test]
    fn impossible_looks_are_refused() {
        let track = line(5);
        assert!(looks(&track, 0, 0.0, LookWindow::Hann).is_err());
        assert!(looks(&track, 6, 0.0, LookWindow::Hann).is_err());
        assert!(looks(&track, 2, 1.0, LookWindow::Hann).is_err());
        assert!(looks(&track, 2, f64::NAN, LookWindow::Hann).is_err());
        let jump = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.1, 0.0, 0.0]];
        assert!(looks(&jump, 3, 0.0, LookWindow::Hann).is_err());
        assert!(add_power(&mut [0.0; 2], &[Complex32::ONE]).is_err());
    }
}
