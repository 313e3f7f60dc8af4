//! The finding on the surface of the ground, by the time of its echo.
//!
//! Depths are counted from the stated surface, and delays from the stated zero of fast time: an error δ of either places
//! targets below ground by about δ (1 − 1/n) or δ/n too high or too low.

use crate::focus::Focused;
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::prepare::Prepared;
use crate::soil::evidence::TIMING_CELLS;
use crate::soil::zero::excess_path_m;

/// Largest standard deviation, in resolution cells of the range, with which the heights count as checked.
const CHECKED_CELLS: f64 = 0.2;

/// Judges the stated surface and zero of fast time; no finding above ground, where the surface or the zero is by the
/// echo of the surface itself, and where no such echo is seen.
pub(super) fn weigh(prepared: &Prepared, focused: &Focused) -> Option<Finding> {
    focused.underground.as_ref()?;
    let is_stated = |track: &crate::prepare::Track| track.is_calibrated && track.delay.is_none();
    if prepared.scene.open.surface || !prepared.tracks.iter().all(is_stated) {
        return None;
    }
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let cell_m =
        0.5 * prepared.scene.light_speed_m_s / (frequency_hz.last()? - frequency_hz.first()?);
    let sigma_m = &prepared.aligned.sigma_m;
    let height_sigma_m = sigma_m.iter().map(|s| s[2]).sum::<f64>() / sigma_m.len().max(1) as f64;
    Some(ground_surface(
        0.5 * excess_path_m(prepared)?,
        height_sigma_m,
        cell_m,
    ))
}

/// The finding on an echo of the surface that comes later by the one-way path `later_m` than the stated surface.
fn ground_surface(later_m: f64, height_sigma_m: f64, cell_m: f64) -> Finding {
    let sigma_m = height_sigma_m.hypot(TIMING_CELLS * cell_m);
    let finding = Finding::compared("ground_surface", later_m, 0.0, sigma_m, "m")
        .at_most(Verdict::Doubtful)
        .because(format!(
            "the echo of the surface comes {later_m:+.3} m of range after the stated surface: where the surface is \
             lower or higher by this, or the zero of fast time is earlier or later, depths are wrong by up to as much \
             ([ground] surface_z_m, [image] terrain, [radar] delay_ns; heights of the positions)"
        ));
    match sigma_m <= CHECKED_CELLS * cell_m {
        true => finding.checking(Setting::Heights),
        false => finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell of 7.5 cm, that of 2 GHz.
    #[test]
    fn a_surface_three_centimetres_off_is_doubtful_where_heights_are_known() {
        let found = |later_m, height_sigma_m| {
            let found = ground_surface(later_m, height_sigma_m, 0.075);
            (found.verdict, found.checks)
        };
        let checked = Some(Setting::Heights);
        assert_eq!(found(0.005, 0.0), (Verdict::Agrees, checked));
        assert_eq!(found(0.03, 0.0), (Verdict::Doubtful, checked));
        assert_eq!(found(-0.3, 0.005), (Verdict::Doubtful, checked));
        assert_eq!(found(0.03, 0.03), (Verdict::Agrees, None));
    }
}
