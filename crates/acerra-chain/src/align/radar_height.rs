//! Heights by the radar itself, from the surface echo over level ground, where the heights of the positions
//! are poor (`[trajectory] height = "radar"`).
//!
//! Single-point heights are metres off, and a few centimetres already cost focus. The surface echo gives the
//! height above level ground to about 5 cm, up to the delay at which range is zero (Catapano et al. 2020,
//! ref. 17). Where the delay is not stated, the positions' mean height is kept, and zero-timing uses this
//! level.

use acerra_radar::Radargram;
use acerra_radar::clean::{SurfaceOptions, SurfaceTrack, track_surface};

use crate::scene::Scene;

/// Heights of the traces above the ground, measured by the radar.
#[derive(Clone, Debug, PartialEq)]
pub struct RadarHeights {
    /// Height of each trace (m).
    pub height_m: Vec<f64>,
    /// Standard deviation of a height (m): the scatter of the picks, and the roughness of the ground.
    pub sigma_m: f64,
    /// Standard deviation of the positions' heights about the radar's heights, without their common level
    /// (m).
    pub positions_off_m: f64,
    /// Share of the traces whose echo was used.
    pub picked: f64,
    /// Level of the followed echo above the rest of the radargram (dB).
    pub contrast_db: f64,
}

/// Reason for which the radar gives no heights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RadarHeightError {
    /// The log holds spectra.
    #[error("[trajectory] height = \"radar\": expected a radargram, found spectra")]
    Spectra,
    /// The ground is not level.
    #[error(
        "[trajectory] height = \"radar\": expected level ground ([image] z_m), found a terrain; the \
         surface echo of a slope does not come from straight below"
    )]
    Uneven,
    /// No echo can be followed.
    #[error("[trajectory] height = \"radar\": no surface echo can be followed: {0}")]
    NoEcho(String),
    /// The echo is missing in too many traces.
    #[error(
        "[trajectory] height = \"radar\": the surface echo is followed in {percent:.0} % of the \
         traces, {needed:.0} % are needed"
    )]
    Lost {
        /// Traces in which the echo is followed (%).
        percent: f64,
        /// Traces in which the echo must be followed (%).
        needed: f64,
    },
}

/// Largest error of the positions' heights up to which the echo is followed (m).
const STRAY_M: f64 = 4.0;
/// Length over which picks follow one smooth curve (s).
const SMOOTH_S: f64 = 0.6;
/// Distance from the curve beyond which a pick is an outlier (s).
const OUTLIER_S: f64 = 0.5e-9;
/// Least share of the traces with an echo.
const LEAST_PICKED: f64 = 0.6;
/// Least contrast of the echo (dB).
const LEAST_CONTRAST_DB: f64 = 6.0;
/// Roughness of ordinary ground in the surface echo (m): facets of the ground interfere, so that the crest
/// wanders smoothly.
const ROUGHNESS_M: f64 = 0.05;

/// Input of the heights by the radar: a track whose positions have poor heights.
#[derive(Clone, Copy, Debug)]
pub struct PoorHeights<'a> {
    /// The selected traces, raw.
    pub radargram: &'a Radargram,
    /// Heights of the traces above the ground by the positions (m).
    pub height_m: &'a [f64],
    /// Stated fast time of zero range (s).
    pub delay_s: Option<f64>,
}

/// Heights of the traces from the surface echo.
///
/// # Errors
/// An echo that cannot be followed, uneven ground.
pub fn radar_heights(
    poor: PoorHeights<'_>,
    scene: &Scene,
) -> Result<RadarHeights, RadarHeightError> {
    if scene.ground.is_uneven() {
        return Err(RadarHeightError::Uneven);
    }
    let track = poor.follow(scene.light_speed_m_s)?;
    let time_s = &poor.radargram.time_s;
    let curve = Curve::through(&track, time_s);
    let picked = curve.kept as f64 / time_s.len().max(1) as f64;
    if picked < LEAST_PICKED {
        return Err(RadarHeightError::Lost {
            percent: 100.0 * picked,
            needed: 100.0 * LEAST_PICKED,
        });
    }
    let half_c = 0.5 * scene.light_speed_m_s;
    let range_m: Vec<f64> = curve.fast_time_s.iter().map(|t| half_c * t).collect();
    let above_m: Vec<f64> = range_m
        .iter()
        .zip(poor.height_m)
        .map(|(r, h)| r - h)
        .collect();
    let level_m = median(&above_m);
    // For an unknown delay, the positions give the level.
    let delay_m = poor.delay_s.map_or(level_m, |delay_s| half_c * delay_s);
    let off_m: Vec<f64> = above_m.iter().map(|d| (d - level_m).abs()).collect();
    Ok(RadarHeights {
        height_m: range_m.iter().map(|r| r - delay_m).collect(),
        sigma_m: (half_c * curve.scatter_s).hypot(ROUGHNESS_M),
        positions_off_m: 1.4826 * median(&off_m),
        picked,
        contrast_db: track.contrast_db,
    })
}

impl PoorHeights<'_> {
    /// The clearer of two echoes: near the positions' heights, or near a constant height, since the
    /// positions' heights may wander more than the flight.
    fn follow(&self, light_speed_m_s: f64) -> Result<SurfaceTrack, RadarHeightError> {
        let mut options = SurfaceOptions::default().with_follow_s(2.0 * STRAY_M / light_speed_m_s);
        if let Some(delay_s) = self.delay_s {
            options = options.with_approximate_delay_s(delay_s);
            options.search_s = 2.0 * STRAY_M / light_speed_m_s;
        }
        let level = vec![median(self.height_m); self.height_m.len()];
        let tracks: Vec<_> = [self.height_m, &level]
            .iter()
            .map(|height_m| track_surface(self.radargram, height_m, &options))
            .collect();
        let mut refused = String::new();
        let mut best: Option<SurfaceTrack> = None;
        for track in tracks {
            match track {
                Ok(track)
                    if best
                        .as_ref()
                        .is_none_or(|b| track.contrast_db > b.contrast_db) =>
                {
                    best = Some(track);
                }
                Ok(_) => {}
                Err(error) => refused = error.to_string(),
            }
        }
        match best {
            Some(track) if track.contrast_db >= LEAST_CONTRAST_DB => Ok(track),
            Some(track) => Err(RadarHeightError::NoEcho(format!(
                "the clearest is {:.1} dB above the rest, {LEAST_CONTRAST_DB} dB are needed",
                track.contrast_db
            ))),
            None => Err(RadarHeightError::NoEcho(refused)),
        }
    }
}

/// A smooth curve through picks.
struct Curve {
    /// Fast time at each trace (s).
    fast_time_s: Vec<f64>,
    /// Number of picks that determine the curve.
    kept: usize,
    /// Standard deviation of the picks about the curve (s).
    scatter_s: f64,
}

impl Curve {
    /// Medians over a short time find the outliers; means over the remaining picks are the curve.
    fn through(track: &SurfaceTrack, time_s: &[f64]) -> Self {
        let picks: Vec<(f64, f64)> = time_s
            .iter()
            .zip(&track.picks)
            .filter_map(|(t, pick)| Some((*t, pick.as_ref()?.fast_time_s)))
            .collect();
        let near = |picks: &[(f64, f64)], t: f64| -> Vec<f64> {
            let from = picks.partition_point(|p| p.0 < t - 0.5 * SMOOTH_S);
            let to = picks.partition_point(|p| p.0 <= t + 0.5 * SMOOTH_S);
            picks[from..to].iter().map(|p| p.1).collect()
        };
        let kept: Vec<(f64, f64)> = picks
            .iter()
            .copied()
            .filter(|(t, pick)| (pick - median(&near(&picks, *t))).abs() <= OUTLIER_S)
            .collect();
        let at = |t: f64| -> f64 {
            let about = near(&kept, t);
            if about.is_empty() {
                return between(&kept, t);
            }
            about.iter().sum::<f64>() / about.len() as f64
        };
        let square: f64 = kept.iter().map(|(t, pick)| (pick - at(*t)).powi(2)).sum();
        Self {
            fast_time_s: time_s.iter().map(|t| at(*t)).collect(),
            scatter_s: (square / kept.len().max(1) as f64).sqrt(),
            kept: kept.len(),
        }
    }
}

/// Linear interpolation between points, constant beyond the ends; 0 without points.
fn between(points: &[(f64, f64)], t: f64) -> f64 {
    let next = points.partition_point(|p| p.0 < t);
    match (
        next.checked_sub(1).and_then(|k| points.get(k)),
        points.get(next),
    ) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0).max(1e-12),
        (Some(only), None) | (None, Some(only)) => only.1,
        (None, None) => 0.0,
    }
}

/// The median of the finite values; 0 where none is finite.
pub(super) fn median(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::PlaneGrid;
    use acerra_radar::{Samples, two_way_delay_s};

    const DELAY_S: f64 = 8e-9;

    fn flight_m(t: f64) -> f64 {
        6.0 + 0.25 * (0.9 * t).sin() + 0.15 * (0.37 * t).cos()
    }

    fn flown(level: f64) -> Radargram {
        let time_s: Vec<f64> = (0..300).map(|k| 0.07 * f64::from(k)).collect();
        let samples: Vec<f32> = time_s
            .iter()
            .flat_map(|t| {
                let echo_s = DELAY_S + two_way_delay_s(flight_m(*t));
                (0..1000_u32).map(move |k| {
                    let u = (20e-9 + 61e-12 * f64::from(k) - echo_s) / 0.4e-9;
                    let drawn = k.wrapping_mul(2_654_435_761) ^ ((t * 1e4) as u32);
                    let noise = f64::from(drawn.wrapping_mul(2_246_822_519) >> 16) / 65_536.0;
                    (level * (-u * u).exp() * (std::f64::consts::TAU * 3.95 * 0.4 * u).cos()
                        + 0.1 * (noise - 0.5)) as f32
                })
            })
            .collect();
        Radargram::new(time_s, 20e-9, 61e-12, Samples::Real(samples)).unwrap()
    }

    fn heights(level: f64, delay_s: Option<f64>) -> Result<(RadarHeights, f64), RadarHeightError> {
        let radargram = flown(level);
        // Single-point heights: 1.2 m too high, and a wander of half a metre.
        let height_m: Vec<f64> = radargram
            .time_s
            .iter()
            .map(|t| flight_m(*t) + 1.2 + 0.5 * (0.21 * t).sin())
            .collect();
        let scene = Scene::plane(PlaneGrid::new([0.0; 3], 0.1, [4, 4]).unwrap());
        let poor = PoorHeights {
            radargram: &radargram,
            height_m: &height_m,
            delay_s,
        };
        let found = radar_heights(poor, &scene)?;
        let error_m: Vec<f64> = found
            .height_m
            .iter()
            .zip(&radargram.time_s)
            .map(|(h, t)| h - flight_m(*t))
            .collect();
        let level_m = median(&error_m);
        let wander = error_m.iter().map(|e| (e - level_m).abs());
        assert!(wander.fold(0.0, f64::max) < 0.05);
        Ok((found, level_m))
    }

    #[test]
    fn the_echo_tells_the_height_where_positions_wander() {
        let (found, level_m) = heights(1.0, Some(DELAY_S)).unwrap();
        assert!(level_m.abs() < 0.02, "{level_m}");
        assert!(found.picked > 0.9 && found.sigma_m < 0.06, "{found:?}");
        assert!((0.2..0.8).contains(&found.positions_off_m));
        // Without a delay the level is the positions' level.
        let (_, level_m) = heights(1.0, None).unwrap();
        assert!((level_m - 1.2).abs() < 0.5, "{level_m}");
    }

    #[test]
    fn noise_and_slopes_are_refused() {
        assert!(matches!(
            heights(0.0, Some(DELAY_S)),
            Err(RadarHeightError::NoEcho(_) | RadarHeightError::Lost { .. })
        ));
    }
}
