//! Cuts along and across the track through one target.

use super::field::Field;
use super::lobe::{Lobe, SIDELOBE_REACH, measure_arm};
use super::target::{AcrossTrack, AlongTrack, Shape};
use super::track::LocalTrack;
use crate::psf::cell::Cell;

/// Samples per expected resolution distance: first minima are then measured to better than 10⁻³ of that
/// distance (by a parabola through a minimum of power).
const STEPS_PER_CELL: f64 = 48.0;
/// Lobes are followed this many expected resolution distances before they count as unbounded.
const LOBE_REACH: f64 = 6.0;

/// Measures the image of a target at (x, y) = `peak_m` along and across its local track.
///
/// `cell` is the expected resolution; it determines sampling and extent of the cuts, not the result. The
/// across-track cut ends at the track where the target's lobe does, so that the ghost beyond the track is no
/// sidelobe.
pub fn measure_shape(
    field: &dyn Field,
    track: &LocalTrack,
    peak_m: [f64; 2],
    cell: Cell,
) -> Option<Shape> {
    let peak = field.amplitude(peak_m[0], peak_m[1]).filter(|a| *a > 0.0)?;
    let arm = |direction: [f64; 2], cell_m: f64, sidelobe_limit_m: f64| {
        let at =
            |s: f64| field.amplitude(peak_m[0] + s * direction[0], peak_m[1] + s * direction[1]);
        measure_arm(
            at,
            peak,
            cell_m / STEPS_PER_CELL,
            LOBE_REACH * cell_m,
            sidelobe_limit_m,
        )
    };
    let (ahead, left) = (track.tangent, track.left());
    let far = |cell_m: f64| 2.0 * SIDELOBE_REACH * cell_m;
    let along = Lobe {
        minus: arm(ahead.map(|v| -v), cell.along_m, far(cell.along_m)),
        plus: arm(ahead, cell.along_m, far(cell.along_m)),
    };

    let offset_m =
        left[0] * (peak_m[0] - track.closest_m[0]) + left[1] * (peak_m[1] - track.closest_m[1]);
    // For a target on the left the track is to the right.
    let towards = if offset_m >= 0.0 {
        left.map(|v| -v)
    } else {
        left
    };
    let inner = arm(towards, cell.across_m, offset_m.abs());
    let apart = inner.rayleigh_m.is_some_and(|r| r < offset_m.abs());
    let across = if apart {
        Lobe {
            minus: inner,
            plus: arm(towards.map(|v| -v), cell.across_m, far(cell.across_m)),
        }
    } else {
        let right = left.map(|v| -v);
        Lobe {
            minus: arm(right, cell.across_m, far(cell.across_m)),
            plus: arm(left, cell.across_m, far(cell.across_m)),
        }
    };

    let side_peak = match (along.side_peak(), across.side_peak()) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    let side_energy = match (along.side_to_main(), across.side_to_main()) {
        (Some(a), Some(b)) => Some(a + b),
        _ => None,
    };
    let decibel = |power: f64| 10.0 * power.max(1e-30).log10();
    Some(Shape {
        along: AlongTrack {
            rayleigh_m: along.rayleigh_m(),
            width_3db_m: along.width_3db_m(),
            width_6db_m: along.width_6db_m(),
        },
        across: AcrossTrack {
            rayleigh_m: across.rayleigh_m(),
            inner_m: across.minus.rayleigh_m,
            outer_m: across.plus.rayleigh_m,
            width_3db_m: across.width_3db_m(),
            width_6db_m: across.width_6db_m(),
        },
        pslr_db: side_peak.map(decibel),
        islr_db: side_energy.map(decibel),
    })
}
