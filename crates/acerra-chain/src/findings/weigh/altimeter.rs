//! Heights of the positions against the ground that the radar sees, where no echo follows them.
//!
//! Heights that drift, as those of a single-point solution do, lose the surface echo: it neither follows
//! them nor lies in the gate. The echo that stands out near them tells the ground all the same.

use acerra_radar::clean::{Background, remove_background};

use crate::align::radar_height::{PoorHeights, radar_heights};
use crate::clean::CleanedTraces;
use crate::findings::evidence::{AltimeterSeen, Finding, surface_height};
use crate::findings::weigh::median::median;
use crate::prepare::{Prepared, Track};
use crate::scene::Scene;

/// Judges the heights of a track by the echo that stands out most near them.
pub(super) fn weigh(prepared: &Prepared, track: &Track, traces: &CleanedTraces) -> Option<Finding> {
    let height_m = prepared.aligned.height_m.get(track.range.clone())?;
    if prepared.aligned.radar_height.is_some() {
        return None;
    }
    seen(traces, height_m, &prepared.scene).and_then(|seen| surface_height(&seen))
}

fn seen(traces: &CleanedTraces, height_m: &[f64], scene: &Scene) -> Option<AltimeterSeen> {
    // Ringing of the antennas stands still at every height; the ground does so below a platform at rest only.
    let moving = remove_background(traces.raw.clone(), Background::Mean).ok()?;
    let poor = PoorHeights {
        radargram: &moving,
        height_m,
        delay_s: Some(0.0),
    };
    let found = radar_heights(poor, scene).ok()?;
    let off_m = found.height_m.iter().zip(height_m).map(|(r, h)| r - h);
    Some(AltimeterSeen {
        level_m: median(off_m)?,
        wander_m: found.positions_off_m,
        sigma_m: found.sigma_m,
        contrast_db: found.contrast_db,
        picked: found.picked,
    })
}
