//! The finding on residues of the surface echo among the targets.
//!
//! Background removal leaves speckle of the surface echo in the pixels straight below the flight. A maximum there is a
//! residue unless it exceeds the highest that chance gives among those pixels.

use acerra_imaging::metrics::{Measurement, Target, highest_power_by_chance};
use rayon::prelude::*;

use super::targets::range_cell_m;
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::position::aligned::Aligned;
use crate::prepare::Prepared;

/// Judges how many of an image's targets are residues of the surface echo; where these are the majority, they become
/// clutter. No finding below ground, where targets are compared with the clutter at their depth.
#[must_use]
pub fn separate_residues(
    prepared: &Prepared,
    focused: &Focused,
    measured: &mut Measurement,
) -> Option<Finding> {
    let cell_m = range_cell_m(prepared).filter(|_| focused.underground.is_none())?;
    let below = Below::of(&prepared.aligned, cell_m);
    let highest = below.highest_by_chance(focused);
    let is_residue = |target: &Target| {
        below.contains([target.x_m, target.y_m, target.z_m]) && power(focused, target) <= highest
    };
    let targets = measured.targets.len();
    let residues = measured.targets.iter().filter(|t| is_residue(t)).count();
    let finding = surface_residue(residues, targets);
    if finding.verdict != Verdict::Agrees {
        measured.targets.retain(|target| !is_residue(target));
        measured.clutter += residues;
        let strongest_db = measured.targets.first().map_or(0.0, |t| t.level_db);
        for target in &mut measured.targets {
            target.level_db -= strongest_db;
        }
    }
    Some(finding)
}

/// Traces of which the nearest to a place is searched, at the most: closer together than the range needs.
const MOST_TRACES: usize = 256;
/// Pixels from which the level straight below the flight is estimated, at the most.
const MOST_PIXELS: usize = 1 << 15;

/// The ground straight below a flight: the places whose range from the nearest trace is the trace's height, to a
/// range cell.
struct Below {
    /// Places of the traces (m) and their heights above the ground (m).
    traces: Vec<([f64; 3], f64)>,
    cell_m: f64,
}

impl Below {
    fn of(aligned: &Aligned, cell_m: f64) -> Self {
        let traces = aligned.position_m.iter().zip(&aligned.height_m);
        let stride = aligned.position_m.len().div_ceil(MOST_TRACES).max(1);
        Self {
            traces: traces
                .step_by(stride)
                .map(|(place_m, height_m)| (*place_m, *height_m))
                .collect(),
            cell_m,
        }
    }

    fn contains(&self, place_m: [f64; 3]) -> bool {
        let range_m = |p: &[f64; 3]| {
            let squares = (0..3).map(|axis| (place_m[axis] - p[axis]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let nearest = self
            .traces
            .iter()
            .map(|(p, height_m)| (range_m(p), *height_m))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.is_some_and(|(range_m, height_m)| (range_m - height_m).abs() <= self.cell_m)
    }

    /// Power that chance gives the highest of the pixels of an image straight below the flight.
    fn highest_by_chance(&self, focused: &Focused) -> f64 {
        // An odd stride, so that pixels of all columns are used.
        let stride = (focused.image.len() / MOST_PIXELS) | 1;
        let mut power: Vec<f64> = (0..focused.image.len())
            .into_par_iter()
            .step_by(stride)
            .filter(|k| self.contains(focused.pixels.place_m(*k)))
            .map(|k| f64::from(focused.image[k].norm_sqr()))
            .collect();
        let area_m2 = (power.len() * stride) as f64 * focused.pixels.grid.pixel_m.powi(2);
        highest_power_by_chance(&mut power, area_m2 / self.cell_m.powi(2))
    }
}

/// Power of the strongest of the pixels about a target.
fn power(focused: &Focused, target: &Target) -> f64 {
    let grid = &focused.pixels.grid;
    let about = |place_m: f64, first_m: f64, pixels: usize| {
        let at = ((place_m - first_m) / grid.pixel_m).round().max(0.0) as usize;
        at.saturating_sub(1)..(at + 2).min(pixels)
    };
    let rows = about(target.y_m, grid.y0_m, grid.ny);
    rows.flat_map(|iy| about(target.x_m, grid.x0_m, grid.nx).map(move |ix| iy * grid.nx + ix))
        .filter_map(|k| focused.image.get(k))
        .map(|value| f64::from(value.norm_sqr()))
        .fold(0.0, f64::max)
}

/// Residues of the surface echo from which their share is judged: fewer are chance.
const LEAST_RESIDUES: usize = 3;

/// Judges how many of the maxima are residues of the surface echo after background removal.
///
/// An image of a scene to the side holds only such residues where the campaign leaves the image's sides to
/// the flight.
fn surface_residue(residues: usize, targets: usize) -> Finding {
    let share = residues as f64 / targets.max(1) as f64;
    let verdict = if residues >= LEAST_RESIDUES && 2 * residues > targets {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let count = format!(
        "{residues} of {targets} maxima lie straight below the flight and are no stronger than chance among the \
         echoes there"
    );
    Finding::judged("surface_residue", share, "share of the maxima", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => format!("{count}, as residues of the surface echo are"),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "{count}: residues of the surface echo after background removal, not points, and not listed as \
                 targets. A scene to the side is imaged where [image] x_m, y_m state it, without a gate \
                 ([preprocess] gate_ns, background)"
            ),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn below_is_within_a_range_cell_of_the_height() {
        let aligned = Aligned {
            position_m: (0..50).map(|k| [0.2 * f64::from(k), -20.0, 6.5]).collect(),
            height_m: vec![8.0; 50],
            ..Aligned::default()
        };
        let below = Below::of(&aligned, 0.088);
        let is_below = |y_m: f64| below.contains([4.1, y_m, -1.5]);
        // √(2 · 8 · 0.088) = 1.19 m.
        assert!(is_below(-20.0) && is_below(-18.9));
        assert!(!is_below(-18.7) && !is_below(0.0));
    }

    #[test]
    fn mostly_residues_are_doubtful() {
        assert_eq!(surface_residue(0, 0).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(2, 2).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(3, 6).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(37, 47).verdict, Verdict::Doubtful);
    }
}
