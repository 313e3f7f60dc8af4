//! The trajectories of the paper's examples.

use std::f64::consts::PI;

use crate::error::ImagingError;

/// Shape of a synthetic level track along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackShape {
    /// y = 0.
    Straight,
    /// y = A cos(2πx/P), as Eq. (13) with A = ±0.15 m and P = 24 m.
    Cosine {
        /// A, m; its sign distinguishes the two curves of Eq. (13).
        amplitude_m: f64,
        /// P, m.
        period_m: f64,
    },
}

/// Positions over x ∈ [−`half_length_m`, `half_length_m`], one every `step_m` of x, at `height_m`.
///
/// # Errors
/// A half-length, step, height or period that is not positive, an amplitude that is no number, a
/// step longer than the track, more than ten million positions.
///
/// ```
/// use acerra_imaging::psf::{TrackShape, synthetic_track};
/// let eq_13 = TrackShape::Cosine { amplitude_m: 0.15, period_m: 24.0 };
/// let track = synthetic_track(eq_13, 3.0, 0.01, 5.0)?;
/// assert_eq!(track.len(), 601);
/// assert!((track[300][1] - 0.15).abs() < 1e-12);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn synthetic_track(
    shape: TrackShape,
    half_length_m: f64,
    step_m: f64,
    height_m: f64,
) -> Result<Vec<[f64; 3]>, ImagingError> {
    let check = |what, expected, found: f64, fine: bool| {
        if fine && found.is_finite() {
            Ok(())
        } else {
            Err(ImagingError::OutOfRange {
                what,
                expected,
                found,
            })
        }
    };
    check(
        "half_length_m",
        "above 0 m",
        half_length_m,
        half_length_m > 0.0,
    )?;
    check(
        "step_m",
        "above 0 m and at most the track",
        step_m,
        step_m > 0.0 && step_m <= 2.0 * half_length_m,
    )?;
    check("height_m", "above 0 m", height_m, height_m > 0.0)?;
    let steps = (2.0 * half_length_m / step_m + 1e-6).floor();
    check(
        "positions of the track",
        "at most 10 000 000",
        steps + 1.0,
        steps < 1e7,
    )?;
    if let TrackShape::Cosine {
        amplitude_m,
        period_m,
    } = shape
    {
        check("amplitude_m", "a number", amplitude_m, true)?;
        check("period_m", "above 0 m", period_m, period_m > 0.0)?;
    }
    Ok((0..=steps as usize)
        .map(|m| {
            let x = step_m * m as f64 - half_length_m;
            let y = match shape {
                TrackShape::Straight => 0.0,
                TrackShape::Cosine {
                    amplitude_m,
                    period_m,
                } => amplitude_m * (2.0 * PI * x / period_m).cos(),
            };
            [x, y, height_m]
        })
        .collect())
}
