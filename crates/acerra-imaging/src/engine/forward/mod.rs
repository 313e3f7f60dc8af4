//! The transposed engines: from an image to range bins to spectra.

mod bins;
pub(crate) mod direct;
pub(crate) mod factorized;
pub(crate) mod filling;
pub(crate) mod grouped;
mod tiles;
