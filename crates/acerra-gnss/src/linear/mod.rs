//! Linear algebra of the filter: dense and sparse rows, normal residuals, quantiles.

pub(crate) mod chi_square;
pub(crate) mod dense;
pub(crate) mod double_row;
pub(crate) mod outliers;
pub(crate) mod sparse_row;
pub(crate) mod update_room;
