//! The data of a run: its logs are read once, then cleaned and imaged for each request.

mod coherence;
mod edits;
mod links;
mod place;
mod radargram;
mod sky;
mod spread;
mod state;
mod work;

pub use edits::Edits;
pub use links::{Hyperbola, Ring, hyperbola, ring, seen_from};
pub use place::{checked_echo, checked_place};
pub use radargram::{Stage, TrackRadargram};
pub use sky::{TrackSky, has_sky};
pub use spread::{ExpectedSpread, expected_spread};
pub use state::{Engine, EngineStatus};
pub use work::{Current, ImageOrder, Made, View};
