//! The paper's campaign (§4) as scenes: two corner reflectors, flown over twice.

/// Track 1, over the reflectors, 4 m high: the text of its scene file.
pub const TRACK_1: &str = include_str!("track-1.toml");

/// Track 2, 2 m from the reflectors, 10 m high: the text of its scene file.
pub const TRACK_2: &str = include_str!("track-2.toml");
