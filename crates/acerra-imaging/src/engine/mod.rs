//! Engines: range tables, the direct and the factorized sum, their transposes, the direct sum in double
//! precision, and the reference.

pub(crate) mod batches;
pub(crate) mod direct;
mod direct_estimate;
pub(crate) mod double;
pub(crate) mod factorized;
pub(crate) mod forward;
pub(crate) mod level_law;
pub(crate) mod level_ways;
pub(crate) mod planar;
pub(crate) mod polynomials;
pub(crate) mod ray_records;
pub mod reference;
pub(crate) mod refracted_table;
pub(crate) mod relief_ways;
pub(crate) mod tables;
pub(crate) mod travel_time;
pub(crate) mod uneven_rays;
pub(crate) mod ways;
pub(crate) mod weights;
