//! The point spread function of the flight at a place, for comparison with a target's image.

use acerra_chain::campaign::Weight;
use acerra_imaging::psf::{Analysis, PointSpread};
use serde::Serialize;

use crate::engine::work::Current;
use crate::error::RequestError;

/// Distances of the first minima of the image of a unit point, by the positions, pulses and band in
/// force (m); none where the response has no minimum.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExpectedSpread {
    /// Along the track.
    pub along_m: Option<f64>,
    /// Across the track.
    pub across_m: Option<f64>,
}

/// The point spread expected of a point on the ground under (x, y).
///
/// # Errors
/// A point that is not below the flight, a band of no width.
pub fn expected_spread(
    current: &Current,
    x_m: f64,
    y_m: f64,
) -> Result<ExpectedSpread, RequestError> {
    let prepared = &current.prepared;
    let weight: Weight = current.campaign.image.weight;
    let weights = prepared.echoes().weights(weight);
    let spread = PointSpread::of(&prepared.echoes().pulses(&weights)?);
    let z_m = prepared.scene.ground.below_m(x_m, y_m);
    let found = Analysis::of(&spread, [x_m, y_m, z_m], z_m)?;
    Ok(ExpectedSpread {
        along_m: found.along.rayleigh_m,
        across_m: found.across.rayleigh_m,
    })
}
