//! Measuring an image: targets, resolution, sidelobes, ghosts, levels.
//!
//! The following definitions reproduce Table 1 of Catapano et al. (2020):
//! - the **Rayleigh distance** goes from the peak to the first minimum of the cut through it;
//!   across the track it is the mean of the inner (towards the track) and the outer side;
//! - **widths** at −3 dB and −6 dB are full widths of the main lobe's power;
//! - **PSLR** is the highest sidelobe on either cut, **ISLR** the energy of the sidelobes over that
//!   of the main lobe (null to null), added over the two cuts, both out to ten Rayleigh distances;
//! - the **ghost** is the maximum about the place mirrored at the local track, its level the ratio
//!   of amplitudes.
//!
//! Cuts follow the direction of flight at the closest approach to the target, whatever the shape of the
//! track. [`measure_targets`] measures an image; [`measure_shape`] and [`find_ghost`] also measure an exact
//! point spread function.

pub(crate) mod candidates;
pub(crate) mod crest;
pub(crate) mod explain;
pub(crate) mod field;
pub(crate) mod ghost;
pub(crate) mod height;
pub(crate) mod history;
pub(crate) mod image;
pub(crate) mod lobe;
pub(crate) mod measure;
pub(crate) mod options;
pub(crate) mod shape;
pub(crate) mod statistics;
pub(crate) mod surroundings;
pub(crate) mod target;
pub(crate) mod track;

pub use candidates::strongest_maxima;
pub use crest::climb_crest;
pub use field::{Field, climb_to_peak};
pub use ghost::{GhostWindow, find_ghost};
pub use height::likeliest_height_m;
pub use image::{ImageView, InterpolatedImage};
pub use lobe::{Arm, Lobe, SIDELOBE_REACH, measure_arm};
pub use measure::{Measurement, measure_targets, measure_targets_in};
pub use options::MeasureOptions;
pub use shape::measure_shape;
pub use statistics::ImageStatistics;
pub use surroundings::highest_power_by_chance;
pub use target::{AcrossTrack, AlongTrack, Ghost, Shape, Target};
pub use track::LocalTrack;
