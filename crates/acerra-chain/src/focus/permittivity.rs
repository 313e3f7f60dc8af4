//! Results of the search for the permittivity: the permittivity, or the reason for a refusal.

use serde::Serialize;

/// A permittivity found from the echoes of buried points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PermittivityFound {
    /// Relative permittivity of the topmost layer.
    pub value: f64,
    /// Standard deviation of the permittivity.
    pub sigma: f64,
    /// Number of points used.
    pub points: usize,
}

/// Remedies where the data leave the permittivity open.
const SETTLED_BY: &str = "State it ([ground] relative_permittivity) by a target at a known depth or a sample of the soil: \
                          dry sand has 3 to 5, moist soil 8 to 20";

/// Reason for which `[ground] relative_permittivity = "auto"` has no answer.
#[derive(Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum PermittivityError {
    /// The image is one slice.
    #[error(
        "[ground] relative_permittivity = \"auto\": expected the heights of a volume below the surface, [image] z_m = \
         [from, to]; found one slice, in which no echo has a depth"
    )]
    NoVolume,
    /// No echo of a buried point.
    #[error(
        "[ground] relative_permittivity = \"auto\": expected the echo of a buried point; found none that \
         exceeds the clutter significantly, deeper than two cells and within [image] x_m, y_m, z_m. \
         {SETTLED_BY}"
    )]
    NoPoint,
    /// Points that agree with any permittivity.
    #[error(
        "[ground] relative_permittivity = \"auto\": expected points that agree on one permittivity; found {points} whose \
         hyperbolas fit those from {from:.1} to {to:.1} within three standard deviations: seen from above, an echo \
         hardly changes its shape with the permittivity. {SETTLED_BY}; a longer aperture or heights that are better known \
         narrow it down"
    )]
    Vague {
        /// Points whose echoes exceed the clutter.
        points: usize,
        /// Least permittivity that agrees.
        from: f64,
        /// Greatest permittivity that agrees.
        to: f64,
    },
    /// Images by different permittivities, each of which agrees with its points.
    #[error(
        "[ground] relative_permittivity = \"auto\": expected one permittivity by which an image shows points that agree on \
         it; found {first:.1} and {second:.1}. {SETTLED_BY}"
    )]
    Several {
        /// Permittivity of the most points.
        first: f64,
        /// Another permittivity.
        second: f64,
    },
    /// Every image shows points that agree on another permittivity than the image's.
    #[error(
        "[ground] relative_permittivity = \"auto\": expected an image whose points agree on the permittivity by which it \
         was made; found another one each time, {last:.1} at last. {SETTLED_BY}"
    )]
    Unsettled {
        /// Last permittivity found.
        last: f64,
    },
}
