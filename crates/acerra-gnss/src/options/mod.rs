//! Processing options, with the presets that reproduce known programs.

mod all;
mod choices;
mod policy;
mod presets;

pub use all::PpkOptions;
pub use choices::{
    AmbiguityMode, BasePosition, BaselineLength, Cn0Mask, Dynamics, FilterDirection,
    GlonassAmbiguity, PartialAmbiguity, PositioningMode, RuleSet,
};
