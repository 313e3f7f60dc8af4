//! A first look at a flight whose settings are all open: whether the radar sees the surface below, and where
//! its echoes focus if it looks to the side.
//!
//! ```text
//! change of the echoes, speed ─► offset ─┐
//! no echo follows the height ────────────┼─► coherence of echoes over delay and height ─► SideLook
//! spectra without gate or surface ───────┘
//! ```
//!
//! The look needs no gate and no extent of an image.

mod error;
mod motion;
mod side;

use acerra_geo::trajectory::Trajectory;
use acerra_radar::Radargram;

use crate::align::delay::surface_delay;
use crate::align::offset::{OffsetError, SearchRange, by_height_and_motion};
use crate::align::plane;
use crate::control::Control;
use crate::scene::Scene;

pub use error::LookError;
pub use motion::{MotionMatch, match_motion};
pub use side::{Determined, SideLook};

/// Result of a first look.
#[derive(Clone, Debug)]
pub struct FirstLook {
    /// Whether an echo follows the height of the flight.
    pub sees_surface: bool,
    /// Trajectory time minus radar time used in the look (s); none where neither height nor motion determines
    /// an offset.
    pub time_offset_s: Option<f64>,
    /// Focus of the echoes; none where the surface is seen, or no offset is determined.
    pub side: Option<SideLook>,
}

/// Looks at a flight whose offset is stated (s), or found by height and motion. The settings are the defaults.
///
/// # Errors
/// Traces that cannot be placed, cleaned or imaged; cancellation.
pub fn look(
    radargram: &Radargram,
    trajectory: &Trajectory,
    stated_offset_s: Option<f64>,
    control: &Control<'_>,
) -> Result<FirstLook, LookError> {
    let lowest_m = plane::lowest_m(trajectory);
    let spread_m = plane::highest_m(trajectory) - lowest_m;
    let scene = side::scene(trajectory, lowest_m)?;
    let found = by_height(radargram, trajectory, &scene, spread_m, control)?;
    let sees_surface = found.as_ref().and_then(surface_delay).is_some();
    let best_s = found.and_then(|found| Some(found.candidates.first()?.offset_s));
    let time_offset_s = stated_offset_s.or(best_s);
    let side = match time_offset_s {
        Some(offset_s) if !sees_surface => Some(side::look(
            radargram, trajectory, &scene, offset_s, control,
        )?),
        _ => None,
    };
    Ok(FirstLook {
        sees_surface,
        time_offset_s,
        side,
    })
}

/// Likelihood of the clock offset from height and motion, for any delay and height of the ground; none where neither
/// determines the offset.
fn by_height(
    radargram: &Radargram,
    trajectory: &Trajectory,
    scene: &Scene,
    spread_m: f64,
    control: &Control<'_>,
) -> Result<Option<acerra_radar::align::OffsetLikelihood>, LookError> {
    let spread_s = 2.0 * spread_m / scene.light_speed_m_s;
    let range = SearchRange {
        max_gap_s: None,
        delay_s: Some([-spread_s - 20e-9, spread_s + 20e-9]),
    };
    match by_height_and_motion(radargram, trajectory, scene, range, control) {
        Ok(found) => Ok(Some(found)),
        Err(OffsetError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(_) => Ok(None),
    }
}
