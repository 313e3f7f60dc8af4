//! The soil and the surface by which an image below ground was made, as facts of the report.

use acerra_chain::choices::{GroundSurface, Permittivity};

use crate::outcome::Outcome;
use crate::report::Fact;

/// The soil used for the image below ground, and its surface; empty for an image above ground.
pub fn soil_facts(outcome: &Outcome) -> Vec<Fact> {
    let Some(ground) = &outcome.campaign.ground else {
        return Vec::new();
    };
    let permittivity = match outcome.prepared.permittivity {
        Some(found) => {
            let points = if found.points == 1 { "point" } else { "points" };
            let note = format!(
                "found from {} buried {points}, equal from several starts",
                found.points
            );
            Fact::new(
                "Permittivity of the ground",
                format!("{:.2} ± {:.2}", found.value, found.sigma),
            )
            .note(note)
        }
        None => {
            let one = ground.relative_permittivity.and_then(Permittivity::given);
            let layers = ground.layer.iter().map(|layer| layer.relative_permittivity);
            let stated: Vec<String> = one
                .into_iter()
                .chain(layers)
                .map(|v| format!("{v:.2}"))
                .collect();
            let note = match stated.len() {
                1 => "as stated",
                _ => "as stated, from the top layer down",
            };
            Fact::new("Permittivity of the ground", stated.join(", ")).note(note)
        }
    };
    let scene_ground = &outcome.prepared.scene.ground;
    let grid = &outcome.focused.pixels.grid;
    let heights_m = || {
        let places = (0..grid.ny).flat_map(|iy| (0..grid.nx).map(move |ix| (ix, iy)));
        places.map(|(ix, iy)| scene_ground.below_m(grid.x_m(ix), grid.y_m(iy)))
    };
    let span = || {
        let least_m = heights_m().fold(f64::INFINITY, f64::min);
        let most_m = heights_m().fold(f64::NEG_INFINITY, f64::max);
        format!("{least_m:.3} to {most_m:.3} m")
    };
    let (surface, note) = match ground.surface {
        GroundSurface::Level => (
            format!("{:.3} m", ground.surface_z_m),
            "level, at the stated height",
        ),
        GroundSurface::Terrain => (span(), "heights of the terrain raster under the image"),
        GroundSurface::Radar => (
            span(),
            "heights by the first echo of the ground; across a single track those under the nearest traces",
        ),
    };
    vec![
        permittivity,
        Fact::new("Surface of the ground", surface).note(note),
    ]
}
