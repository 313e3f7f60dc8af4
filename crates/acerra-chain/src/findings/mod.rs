//! Findings of a run: each compares a value of the data with its expected value, and has a verdict.
//!
//! ```text
//! positions ──judge_source───► findings on their source                              (position)
//! Prepared  ──weigh_prepared──► findings on logs, clocks, delays, positions, grid     (before the image)
//! Focused   ──weigh_image─────► findings on the image
//! targets   ──weigh_targets───► findings on what was measured
//! ```
//!
//! A topic's file first gathers numbers that the stages hold and then judges these numbers by a plain
//! function. Contradictions make a run fail unless the campaign states otherwise (`[checks] contradictions =
//! "warn"`).

mod altimeter;
mod antenna;
mod autofocus;
mod background;
mod clock;
pub(crate) mod coverage;
mod delay;
mod extent;
mod grid;
mod ground_surface;
mod image;
mod inversion;
mod median;
mod motion;
mod paths;
mod permittivity;
pub(crate) mod positions;
mod preferred;
mod radar;
mod range_focus;
mod reach;
mod residue;
mod side;
mod spacing;
mod strongest;
mod surface;
mod target_focus;
mod targets;
mod track;
mod unchecked;
mod wander;

pub use autofocus::weigh_autofocus;
pub use residue::separate_residues;
pub use targets::{exceed_clutter, weigh_targets};
pub use unchecked::{Unchecked, weigh_unchecked};

pub use crate::journal::evidence::Evidence;
pub use crate::journal::finding::{Finding, Setting, Verdict};

use crate::align::geometry::ImageGeometry;
use crate::control::{Cancelled, Control};
use crate::focus::{Focused, ImageRequest};
use crate::prepare::{Prepared, Track};
use crate::scene::Scene;
use crate::scene::pixels::Pixels;

/// Pixels along each side at which the geometry is judged.
const PIXELS_A_SIDE: usize = 9;

/// Weighs everything that is known before the image is made.
///
/// # Errors
/// The caller asked to stop.
pub fn weigh_prepared(
    prepared: &Prepared,
    request: &ImageRequest,
    control: &Control<'_>,
) -> Result<Vec<Finding>, Cancelled> {
    let pixel_m = sample_pixels(&request.pixels, &prepared.scene);
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let (Some(low), Some(high)) = (frequency_hz.first(), frequency_hz.last()) else {
        return Ok(Vec::new());
    };
    let mut findings = Vec::new();
    for track in &prepared.tracks {
        control.check()?;
        let geometry = ImageGeometry {
            position_m: &prepared.aligned.position_m[track.range.clone()],
            pixel_m: &pixel_m,
            band_hz: [*low, *high],
            light_speed_m_s: prepared.scene.light_speed_m_s,
        };
        let is_below_ground = request.underground.is_some();
        let mut own = track::weigh(prepared, track, &geometry, is_below_ground);
        own.extend(radar::weigh(
            prepared,
            track,
            geometry.band_hz,
            is_below_ground,
        ));
        own.extend(delay::weigh(prepared, track, request, control)?);
        own.extend(grid::weigh_geometry(prepared, track, &geometry, request));
        own.extend(antenna::weigh(prepared, track, &geometry, request));
        findings.extend(
            own.into_iter()
                .map(|finding| named(prepared, track, finding)),
        );
    }
    Ok(findings)
}

/// Judges the image, and the settings by the image's strongest targets.
///
/// # Errors
/// The caller asked to stop.
pub fn weigh_image(
    prepared: &Prepared,
    focused: &Focused,
    control: &Control<'_>,
) -> Result<Vec<Finding>, Cancelled> {
    let mut findings = image::weigh_values(prepared, focused);
    findings.extend(inversion::weigh(focused));
    findings.extend(extent::weigh(prepared, focused, control)?);
    findings.extend(permittivity::weigh(prepared, focused, control)?);
    findings.extend(ground_surface::weigh(prepared, focused));
    for track in &prepared.tracks {
        let (background, (motion, range_focus)) = rayon::join(
            || background::weigh(prepared, focused, track, control),
            || {
                rayon::join(
                    || motion::weigh(prepared, focused, track, control),
                    || range_focus::weigh(prepared, focused, track, control),
                )
            },
        );
        let mut own = background?;
        own.extend(motion?);
        own.extend(spacing::weigh(prepared, focused, track, control)?);
        own.extend(range_focus?);
        findings.extend(
            own.into_iter()
                .map(|finding| named(prepared, track, finding)),
        );
    }
    Ok(findings)
}

/// The finding with the track's name appended to its own, where there are several tracks.
fn named(prepared: &Prepared, track: &Track, mut finding: Finding) -> Finding {
    if prepared.tracks.len() > 1 {
        finding.name = format!("{} of {}", finding.name, track.name);
    }
    finding
}

/// Pixels spread evenly over the image, edges included, at their heights (m).
fn sample_pixels(pixels: &Pixels, scene: &Scene) -> Vec<[f64; 3]> {
    let grid = &pixels.grid;
    let along = |count: usize| {
        let last = count.saturating_sub(1);
        (0..PIXELS_A_SIDE).map(move |k| last * k / (PIXELS_A_SIDE - 1))
    };
    along(grid.ny)
        .flat_map(|iy| along(grid.nx).map(move |ix| (ix, iy)))
        .map(|(ix, iy)| {
            let (x_m, y_m) = (grid.x_m(ix), grid.y_m(iy));
            let z_m = match &pixels.surface {
                Some(_) => scene.ground.below_m(x_m, y_m),
                None => grid.z_m,
            };
            [x_m, y_m, z_m]
        })
        .collect()
}
