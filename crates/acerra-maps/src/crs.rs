//! Coordinate reference systems of maps, by their codes in the EPSG registry.

pub use acerra_geo::epsg::{CrsError, EpsgCrs as MapCrs};
