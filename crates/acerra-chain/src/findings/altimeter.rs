//! Heights of the positions against the ground that the radar sees, where no echo follows them.
//!
//! Where heights drift, as in a single-point solution, the surface echo neither follows the heights nor lies
//! in the gate. The clearest echo near the heights still gives the ground.

use acerra_radar::clean::{Background, remove_background};

use super::median::median;
use crate::align::radar_height::{PoorHeights, radar_heights};
use crate::clean::CleanedTraces;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::{Prepared, Track};
use crate::scene::Scene;

/// Judges the heights of a track by the clearest echo near them.
pub(super) fn weigh(prepared: &Prepared, track: &Track, traces: &CleanedTraces) -> Option<Finding> {
    let height_m = prepared.aligned.height_m.get(track.range.clone())?;
    if prepared.aligned.radar_height.is_some() {
        return None;
    }
    seen(traces, height_m, &prepared.scene).and_then(|seen| surface_height(&seen))
}

fn seen(traces: &CleanedTraces, height_m: &[f64], scene: &Scene) -> Option<AltimeterSeen> {
    // Ringing of the antennas is constant at every height; the surface echo is constant below a platform at
    // rest only.
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

/// The height of the flight by the surface echo, where no echo follows the heights of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AltimeterSeen {
    /// Median of the heights by the echo less those of the positions (m).
    pub level_m: f64,
    /// Standard deviation of the positions' heights about the echo's, without their common level (m).
    pub wander_m: f64,
    /// Standard deviation of a height by the echo (m).
    pub sigma_m: f64,
    /// Level of the echo above the rest (dB), and the share of the traces in which the echo is followed.
    pub contrast_db: f64,
    /// Share of the traces in which it is followed.
    pub picked: f64,
}

/// An echo with this level (dB), in this share of the traces, counts as the ground's.
const ALTIMETER_CONTRAST_DB: f64 = 10.0;
const ALTIMETER_PICKED: f64 = 0.8;

/// Largest distance of an echo from straight below for an object on the ground (m).
const HEIGHT_OFF_M: f64 = 1.0;

/// Wander of heights (m), in addition to the echo's own deviation, that blurs every target.
const HEIGHT_WANDER_M: f64 = 0.1;

/// Judges heights that no echo follows, by the clearest echo near them; none without such an echo. The echo
/// may come from a wall or a roof, so that the heights are at most doubtful.
fn surface_height(seen: &AltimeterSeen) -> Option<Finding> {
    let is_ground = seen.contrast_db >= ALTIMETER_CONTRAST_DB && seen.picked >= ALTIMETER_PICKED;
    let is_off = seen.level_m.abs() > HEIGHT_OFF_M
        || seen.wander_m > HEIGHT_WANDER_M.hypot(3.0 * seen.sigma_m);
    let verdict = if is_off {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    is_ground.then(|| {
        Finding {
            sigma: Some(seen.sigma_m),
            ..Finding::judged("surface_height", seen.level_m, "m", verdict)
        }
        .expecting(0.0)
        .because({
            let clearest = format!(
                "the clearest echo near the heights of the positions, seen in {:.0} % of the traces, is \
                 {:+.2} m from straight below, and those heights wander about it by {:.2} m",
                100.0 * seen.picked,
                seen.level_m,
                seen.wander_m
            );
            if is_off {
                format!(
                    "no echo follows the heights of the positions: {clearest} (heights of the positions, \
                     [trajectory] origin_deg_m, height = \"radar\"; [image] z_m; [radar] delay_ns)"
                )
            } else {
                format!("{clearest}: explained by the ground")
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_a_metre_off_or_wandering_are_doubted_where_an_echo_tells_the_ground() {
        let seen = AltimeterSeen {
            level_m: 0.05,
            wander_m: 0.05,
            sigma_m: 0.05,
            contrast_db: 15.0,
            picked: 0.95,
        };
        let verdict = |seen| surface_height(&seen).map(|finding| finding.verdict);
        assert_eq!(verdict(seen), Some(Verdict::Agrees));
        let high = AltimeterSeen {
            level_m: -1.4,
            ..seen
        };
        assert_eq!(verdict(high), Some(Verdict::Doubtful));
        let wandering = AltimeterSeen {
            wander_m: 0.3,
            ..seen
        };
        assert_eq!(verdict(wandering), Some(Verdict::Doubtful));
        let faint = AltimeterSeen {
            contrast_db: 7.0,
            ..high
        };
        assert_eq!(verdict(faint), None);
    }
}
