//! Whether the positions of a flight resolve a volume's slices.

use acerra_imaging::VolumeGrid;
use acerra_imaging::resolution::elevation_m;

use crate::journal::warnings::Warnings;

/// Warns where the positions of a flight cannot resolve the slices of the volume.
pub(crate) fn check_elevation(
    volume: &VolumeGrid,
    position_m: &[[f64; 3]],
    wavelength_m: f64,
    warnings: &mut Warnings,
) {
    let base = &volume.base;
    let [x, y] = [(base.nx, base.x0_m), (base.ny, base.y0_m)]
        .map(|(n, from)| from + 0.5 * (n.saturating_sub(1)) as f64 * base.pixel_m);
    let tall_m = volume.nz.saturating_sub(1) as f64 * volume.step_m;
    let centre = [x, y, base.z_m + 0.5 * tall_m];
    let resolution_m = elevation_m(position_m, centre, wavelength_m);
    // In a single row the distance across the track is stated, and so the height is determined.
    if resolution_m > tall_m && base.nx.min(base.ny) > 1 {
        let resolved = if resolution_m.is_finite() {
            format!("resolve {resolution_m:.1} m in elevation")
        } else {
            "resolve no elevation".to_owned()
        };
        warnings.add(format!(
            "the positions of the flight {resolved}, the volume is {tall_m:.1} m tall: height and distance \
             across the track cannot be separated; several parallel tracks separate them"
        ));
    }
}
