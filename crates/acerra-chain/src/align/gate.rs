//! The gate of a track whose campaign leaves the gate to the data.

use crate::align::geometry::{ImageGeometry, ranges_held};
use crate::choices::Gate;
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;
use crate::scene::Scene;

/// Share of the image that must be within the gate at closest approach, where the surface echo is seen at
/// 2h/c.
const LEAST_SHARE: f64 = 0.5;
/// This share where no surface echo is seen.
const LEAST_SHARE_UNSEEN: f64 = 0.75;
/// Number of pixels along each side at which ranges are evaluated.
const PIXELS_A_SIDE: usize = 9;

/// The gate for traces with known positions: [`Gate::Auto`] becomes the gate about 2h/c where the image lies
/// below the flight, and no gate where the image lies to the side. The extent of an image whose sides follow
/// the flight does not depend on the radar's direction of view, which only the surface echo shows.
#[must_use]
pub fn settle_gate(
    choice: Gate,
    aligned: &Aligned,
    scene: &Scene,
    sees_surface: bool,
    warnings: &mut Warnings,
) -> Gate {
    if choice != Gate::Auto {
        return choice;
    }
    if aligned.height_m.iter().any(|h| *h <= 0.0) {
        warnings.add(
            "no gate: traces are at or below the ground of the image, where 2h/c has no meaning \
             ([preprocess] gate_ns)",
        );
        return Gate::None;
    }
    let needed = if sees_surface {
        LEAST_SHARE
    } else {
        LEAST_SHARE_UNSEEN
    };
    match share_below(aligned, scene) {
        None if !sees_surface => {
            warnings.add(
                "no gate: the image follows the flight, and no surface echo is seen at 2h/c ([preprocess] gate_ns)",
            );
            Gate::None
        }
        Some(share) if share < needed => {
            warnings.add(format!(
                "no gate: only {:.0} % of the image lies at ranges within [{}, {}] ns of 2h/c{} \
                 ([preprocess] gate_ns, [image] x_m, y_m)",
                100.0 * share,
                Gate::BELOW_NS[0],
                Gate::BELOW_NS[1],
                if sees_surface {
                    ""
                } else {
                    ", and no surface echo is seen there"
                }
            ));
            Gate::None
        }
        _ => Gate::About(Gate::BELOW_NS),
    }
}

/// Share of the image within the gate of a downward view at closest approach; `None` where the image's sides
/// follow the gate.
fn share_below(aligned: &Aligned, scene: &Scene) -> Option<f64> {
    if scene.open.sides != [false; 2] {
        return None;
    }
    let half_c = 0.5 * scene.light_speed_m_s;
    let range_m: Vec<[f64; 2]> = aligned
        .height_m
        .iter()
        .map(|h| Gate::BELOW_NS.map(|ns| h + half_c * 1e-9 * ns))
        .collect();
    let geometry = ImageGeometry {
        position_m: &aligned.position_m,
        pixel_m: &sample_pixels(scene),
        band_hz: [0.0, 0.0],
        light_speed_m_s: scene.light_speed_m_s,
    };
    Some(ranges_held(&geometry, &range_m)?.focused)
}

/// Pixels spread evenly over the image, on the ground (m).
fn sample_pixels(scene: &Scene) -> Vec<[f64; 3]> {
    let grid = &scene.pixels.grid;
    let along = |count: usize| {
        (0..PIXELS_A_SIDE).map(move |k| count.saturating_sub(1) * k / (PIXELS_A_SIDE - 1))
    };
    along(grid.ny)
        .flat_map(|iy| along(grid.nx).map(move |ix| [grid.x_m(ix), grid.y_m(iy)]))
        .map(|[x_m, y_m]| [x_m, y_m, scene.ground.below_m(x_m, y_m)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::PlaneGrid;

    fn settled(height_m: f64, y_m: [f64; 2], sees_surface: bool) -> (Gate, usize) {
        settled_in([false; 2], height_m, y_m, sees_surface)
    }

    fn settled_in(
        open: [bool; 2],
        height_m: f64,
        y_m: [f64; 2],
        sees_surface: bool,
    ) -> (Gate, usize) {
        let position_m: Vec<[f64; 3]> = (0..100)
            .map(|k| [0.1 * f64::from(k), 0.0, height_m])
            .collect();
        let aligned = Aligned {
            height_m: vec![height_m; position_m.len()],
            position_m,
            ..Aligned::default()
        };
        let grid = PlaneGrid::from_ranges([0.0, 10.0], y_m, 0.0, 0.1).unwrap();
        let mut scene = Scene::plane(grid);
        scene.open.sides = open;
        let warnings = &mut Warnings::default();
        let gate = settle_gate(Gate::Auto, &aligned, &scene, sees_surface, warnings);
        (gate, warnings.said().len())
    }

    #[test]
    fn an_image_below_the_flight_is_gated_and_one_to_the_side_is_not() {
        let below = Gate::About(Gate::BELOW_NS);
        assert_eq!(settled(10.0, [-9.0, 9.0], true), (below, 0));
        assert_eq!(settled(10.0, [-9.0, 9.0], false), (below, 0));
        assert_eq!(settled(1.2, [4.0, 30.0], false), (Gate::None, 1));
        // Sides that follow the flight do not depend on the radar's direction of view.
        let follows = |sees_surface| settled_in([true; 2], 2.0, [-9.0, 9.0], sees_surface);
        assert_eq!(follows(true), (below, 0));
        assert_eq!(follows(false), (Gate::None, 1));
        // At the height of the platform no pixel is below the flight.
        assert_eq!(settled(0.0, [2.0, 12.0], false), (Gate::None, 1));
    }
}
