//! Satellites: broadcast and precise orbits and clocks, ranges to them, and delays of their signals.

pub(crate) mod atmosphere;
pub(crate) mod bits;
pub(crate) mod broadcast;
pub(crate) mod geometry;
pub(crate) mod glonass;
pub(crate) mod interpolate;
pub(crate) mod navigation;
pub(crate) mod products;
pub(crate) mod state;
