//! Findings on the surface echo that follows the height of the flight.

use acerra_radar::clean::{SurfaceOptions, SurfacePick, track_surface};

use super::grid::LIGHT_SPEED_M_S;
use super::median::median;
use crate::clean::surface_path_m;
use crate::journal::finding::{Finding, Setting, Verdict};
use crate::prepare::{Prepared, Track};

/// Least number of picks of an echo that is judged.
const LEAST_PICKS: usize = 20;

/// Largest distance from 2h/c at which the surface echo is searched where fast time is calibrated (s).
const SEARCH_S: f64 = 15e-9;

/// Timing of the echo itself (ns).
const TIMING_NS: f64 = 0.05;

/// Log-likelihood over an unrelated echo from which the echo that follows the height is accepted.
pub(super) const LEAST_EVIDENCE: f64 = 12.0;

/// Largest standard deviation of heights that follow the flight (m).
const BELIEVED_SIGMA_M: f64 = 0.1;

/// Judges the surface echo of a track where one is known to follow the height.
pub(super) fn weigh(prepared: &Prepared, track: &Track) -> Vec<Finding> {
    let Some(seen) = surface_seen(prepared, track) else {
        return Vec::new();
    };
    // Over a short stretch a strong target may be mistaken for the surface: where the height itself agrees
    // with the offset, the spread at most doubts.
    let speaks = height_speaks(prepared, track);
    let milder = |finding: Finding| {
        if finding.name == "surface_spread" && !speaks {
            finding.at_most(Verdict::Doubtful)
        } else {
            finding
        }
    };
    surface(&seen).into_iter().map(milder).collect()
}

/// Whether an echo of the log clearly follows the height of the flight.
pub(super) fn follows_height(track: &Track) -> bool {
    let height = track.likelihood.as_ref().and_then(|l| l.height.as_ref());
    height.is_some_and(|cue| cue.evidence >= LEAST_EVIDENCE)
}

/// Whether the height of the surface echo by itself contradicts the offset in force, and the positions'
/// heights are accurate enough.
pub(super) fn height_speaks(prepared: &Prepared, track: &Track) -> bool {
    let Some(cue) = track.likelihood.as_ref().and_then(|l| l.height.as_ref()) else {
        return false;
    };
    let sigma_z_m = height_sigma_m(prepared, track);
    let below = cue.curve.best().1 - cue.curve.at(track.time_offset_s);
    cue.evidence >= LEAST_EVIDENCE
        && below >= LEAST_EVIDENCE
        && sigma_z_m.is_none_or(|sigma_m| sigma_m <= BELIEVED_SIGMA_M)
}

/// Median deviation of the positions' heights (m), where they state any.
pub(super) fn height_sigma_m(prepared: &Prepared, track: &Track) -> Option<f64> {
    let sigma_m = prepared.aligned.sigma_m.get(track.range.clone())?;
    median(sigma_m.iter().map(|s| s[2]))
}

/// The surface echo of the zero-timed traces, where one follows the height.
fn surface_seen(prepared: &Prepared, track: &Track) -> Option<SurfaceSeen> {
    // A surface that the first echoes placed agrees with them whatever the zero of fast time.
    if prepared.scene.open.surface {
        return None;
    }
    let traces = track.cleaned.as_ref()?;
    let aligned = &prepared.aligned;
    let ground = &prepared.scene.ground;
    // Over uneven ground the first echo comes from the nearest place, not from straight below.
    let height_m: Vec<f64> = if ground.is_uneven() {
        let path_m = surface_path_m(aligned, ground);
        let own = path_m.get(track.range.clone())?;
        own.iter().map(|path_m| 0.5 * path_m).collect()
    } else {
        aligned.height_m.get(track.range.clone())?.to_vec()
    };
    let mut options = SurfaceOptions::default().with_approximate_delay_s(0.0);
    options.search_s = SEARCH_S;
    let echo = track_surface(&traces.raw, &height_m, &options).ok()?;
    let two_way_s = |height_m: f64| 2.0 * height_m / prepared.scene.light_speed_m_s;
    let absent = ground.is_uneven() && is_absent(&echo.picks);
    let (position, residual_ns): (Vec<f64>, Vec<f64>) = echo
        .picks
        .iter()
        .zip(&height_m)
        .enumerate()
        .filter_map(|(k, (pick, height_m))| {
            let pick = pick.as_ref()?;
            let share = k as f64 / echo.picks.len() as f64;
            Some((share, 1e9 * (pick.fast_time_s - two_way_s(*height_m))))
        })
        .unzip();
    if residual_ns.len() < LEAST_PICKS {
        return None;
    }
    let level_ns = median(residual_ns.iter().copied())?;
    let spread_ns = 1.4826 * median(residual_ns.iter().map(|r| (r - level_ns).abs()))?;
    let sigma_z_m = height_sigma_m(prepared, track);
    let expected_spread_ns = TIMING_NS.hypot(1e9 * two_way_s(sigma_z_m.unwrap_or(0.02)));
    let (drift_ns, drift_sigma_ns) = drift(&position, &residual_ns, spread_ns);
    Some(SurfaceSeen {
        shape_ns: (ground.is_uneven())
            .then(|| shape(&residual_ns, level_ns))
            .flatten(),
        is_absent: absent,
        level_ns,
        spread_ns,
        expected_spread_ns,
        drift_ns,
        drift_sigma_ns,
        is_calibrated: track.is_calibrated,
    })
}

/// Number of stretches of a flight over which the shape of a terrain is compared, and least number of picks
/// of each.
const STRETCHES: usize = 12;
const STRETCH_PICKS: usize = 8;

/// Share of the usual level of the surface echo below which a pick shows none: 12 dB.
const ABSENT_LEVEL: f64 = 0.25;

/// Whether over one stretch of the flight most picks have no surface echo: a terrain that is off by more than
/// the echo is followed leaves noise at the fast times that the terrain gives.
fn is_absent(picks: &[Option<SurfacePick>]) -> bool {
    let levels: Vec<f64> = picks.iter().flatten().map(|pick| pick.level).collect();
    let Some(usual) = median(levels.iter().copied()) else {
        return false;
    };
    let size = levels.len().div_ceil(STRETCHES).max(STRETCH_PICKS);
    levels.chunks(size).any(|stretch| {
        let absent = stretch
            .iter()
            .filter(|level| **level < ABSENT_LEVEL * usual);
        2 * stretch.len() > size && 2 * absent.count() > stretch.len()
    })
}

/// The median of the stretch that is farthest from the level, less the level (ns).
fn shape(residual_ns: &[f64], level_ns: f64) -> Option<f64> {
    let picks = residual_ns.len().div_ceil(STRETCHES).max(STRETCH_PICKS);
    residual_ns
        .chunks(picks)
        .filter(|stretch| 2 * stretch.len() > picks)
        .filter_map(|stretch| Some(median(stretch.iter().copied())? - level_ns))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// Change over the flight of a straight line through the residuals, and its standard deviation
/// (ns).
fn drift(position: &[f64], residual_ns: &[f64], spread_ns: f64) -> (f64, f64) {
    let count = position.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (middle, level) = (mean(position), mean(residual_ns));
    let (mut product, mut square) = (0.0, 0.0);
    for (p, r) in position.iter().zip(residual_ns) {
        // Strays must not tilt the line.
        let r = (r - level).clamp(-3.0 * spread_ns, 3.0 * spread_ns);
        product += (p - middle) * r;
        square += (p - middle).powi(2);
    }
    if square <= 0.0 {
        return (0.0, f64::INFINITY);
    }
    (product / square, spread_ns / square.sqrt())
}

/// The surface echo of the traces relative to 2h/c, after zero-timing.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SurfaceSeen {
    /// Median of echo minus 2h/c (ns).
    pub level_ns: f64,
    /// Robust standard deviation of echo minus 2h/c (ns).
    pub spread_ns: f64,
    /// Standard deviation expected from the positions' own σ and the echo's timing (ns).
    pub expected_spread_ns: f64,
    /// Change of echo minus 2h/c from the first trace to the last by a straight line (ns).
    pub drift_ns: f64,
    /// Standard deviation of that change (ns).
    pub drift_sigma_ns: f64,
    /// Of uneven ground: the median of the stretch whose echo is farthest from the level, less the level (ns).
    pub shape_ns: Option<f64>,
    /// Whether a stretch of uneven ground has no echo where the terrain puts one.
    pub is_absent: bool,
    /// Whether fast time was calibrated (stated) rather than set by this echo.
    pub is_calibrated: bool,
}

/// Roughness of ordinary ground as the surface echo shows it (ns): 5 cm, one standard deviation.
const GROUND_ROUGHNESS_NS: f64 = 0.33;

/// Deviation of the delay by the surface echo of a whole flight (ns): the ground's mean level about
/// the plane, 3 cm, of which the roughness is no part any more, and the echo's own delay, a tenth of
/// the pulse's length of 1 ns.
pub(super) const MEAN_LEVEL_NS: f64 = 0.22;

/// Deviations of the ground's mean level from which a stated delay is doubted: 0.44 ns or 7 cm of height, which move
/// targets to the side of a high flight by decimetres and are not seen in the image.
const LEVEL_SIGMAS: f64 = 2.0;

/// Judges the surface echo: its level where fast time is calibrated, its spread and its drift.
///
/// A wrong clock offset or another flight's log leaves the flight's own climbs and descents in
/// echo minus 2h/c; a wrong delay, lever arm, plane or propagation speed shifts it.
fn surface(seen: &SurfaceSeen) -> Vec<Finding> {
    let mut findings = Vec::new();
    let spread_sigma_ns = seen.expected_spread_ns.hypot(GROUND_ROUGHNESS_NS);
    // Heights of a terrain are compared to the accuracy of the ground's mean level, those of a plane to the
    // ground's roughness.
    let level_sigma_ns = seen.expected_spread_ns.hypot(MEAN_LEVEL_NS);
    if seen.is_calibrated {
        let sigma_ns = match seen.shape_ns {
            Some(_) => level_sigma_ns,
            None => spread_sigma_ns.hypot(0.3),
        };
        let mut finding = Finding::compared("surface_delay", seen.level_ns, 0.0, sigma_ns, "ns");
        if seen.level_ns.abs() > LEVEL_SIGMAS * level_sigma_ns {
            finding.verdict = finding.verdict.max(Verdict::Doubtful);
        }
        findings.push(
            finding
                .checking(Setting::Heights)
                .because(format!(
                    "the surface echo comes {:+.2} ns after 2h/c: {:+.2} m of range ([radar] \
                     delay_ns, [image] z_m, terrain and geoid_height_m; [trajectory] origin_deg_m and \
                     lever_arm_m)",
                    seen.level_ns,
                    0.5e-9 * seen.level_ns * LIGHT_SPEED_M_S
                )),
        );
    }
    if let Some(shape_ns) = seen.shape_ns {
        findings.push(
            Finding::compared("surface_shape", shape_ns, 0.0, level_sigma_ns, "ns")
                .at_most(Verdict::Doubtful)
                .because(format!(
                    "over one stretch of the flight the surface echo comes {shape_ns:+.2} ns after 2h/c \
                     over the terrain, relative to its mean: {:+.2} m of height (a raster displaced, or of \
                     bushes and roofs rather than the ground; [image] terrain, terrain_crs)",
                    -0.5e-9 * shape_ns * LIGHT_SPEED_M_S
                )),
        );
    }
    if seen.is_absent {
        findings.push(
            Finding::judged("surface_absent", 1.0, "stretch", Verdict::Doubtful)
                .expecting(0.0)
                .because(
                    "over one stretch of the flight no surface echo is at the fast time that the terrain gives (a \
                     raster displaced, or of bushes and roofs rather than the ground; [image] terrain, terrain_crs)",
                ),
        );
    }
    let verdict = match seen.spread_ns / spread_sigma_ns {
        r if r <= 1.5 => Verdict::Agrees,
        r if r <= 3.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    findings.push(
        Finding::judged("surface_spread", seen.spread_ns, "ns", verdict)
            .expecting(spread_sigma_ns)
            .because(format!(
                "the surface echo scatters by {:.2} ns about 2h/c, {spread_sigma_ns:.2} ns are \
                 explained by the positions and the ground ([trajectory] time_offset_s; is this the \
                 trajectory of this flight?)",
                seen.spread_ns
            )),
    );
    let drift_sigma_ns = seen.drift_sigma_ns.hypot(GROUND_ROUGHNESS_NS);
    findings.push(
        Finding::compared("surface_drift", seen.drift_ns, 0.0, drift_sigma_ns, "ns")
            .at_most(Verdict::Doubtful)
            .because(format!(
                "the surface echo drifts by {:+.2} ns against 2h/c over the flight (sloping ground, \
                 drifting positions or clock)",
                seen.drift_ns
            )),
    );
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen() -> SurfaceSeen {
        SurfaceSeen {
            level_ns: 0.1,
            spread_ns: 0.05,
            expected_spread_ns: 0.1,
            drift_ns: 0.05,
            drift_sigma_ns: 0.1,
            shape_ns: None,
            is_absent: false,
            is_calibrated: true,
        }
    }

    fn verdicts(seen: SurfaceSeen) -> Vec<(String, Verdict)> {
        surface(&seen)
            .into_iter()
            .map(|f| (f.name, f.verdict))
            .collect()
    }

    #[test]
    fn a_delay_two_nanoseconds_off_is_doubtful_and_one_of_ten_contradicts() {
        assert!(verdicts(seen()).iter().all(|(_, v)| *v == Verdict::Agrees));
        let off = |level_ns| verdicts(SurfaceSeen { level_ns, ..seen() })[0].clone();
        assert_eq!(off(2.0), ("surface_delay".to_owned(), Verdict::Doubtful));
        assert_eq!(off(-10.0).1, Verdict::Contradicts);
        let uncalibrated = SurfaceSeen {
            is_calibrated: false,
            level_ns: 5.0,
            ..seen()
        };
        assert!(
            verdicts(uncalibrated)
                .iter()
                .all(|(name, _)| name != "surface_delay")
        );
    }

    #[test]
    fn the_spread_of_a_wrong_offset_is_seen() {
        let spread = |spread_ns| {
            verdicts(SurfaceSeen {
                spread_ns,
                ..seen()
            })[1]
                .1
        };
        assert_eq!(spread(0.05), Verdict::Agrees);
        assert_eq!(spread(0.72), Verdict::Doubtful);
        assert_eq!(spread(3.0), Verdict::Contradicts);
    }

    #[test]
    fn a_terrain_is_held_to_its_level_and_its_shape() {
        let over = |level_ns, shape_ns| {
            let found = surface(&SurfaceSeen {
                level_ns,
                shape_ns: Some(shape_ns),
                ..seen()
            });
            let names: Vec<&str> = found.iter().map(|f| f.name.as_str()).collect();
            assert_eq!(names[..2], ["surface_delay", "surface_shape"]);
            [found[0].verdict, found[1].verdict]
        };
        assert_eq!(over(0.3, 0.4), [Verdict::Agrees; 2]);
        // A datum 0.15 m off; 0.15 m of shape along the track.
        assert_eq!(over(1.0, 0.4), [Verdict::Doubtful, Verdict::Agrees]);
        assert_eq!(over(0.3, -1.0), [Verdict::Agrees, Verdict::Doubtful]);
    }

    #[test]
    fn a_stated_delay_off_by_seven_centimetres_is_doubtful() {
        let off = |level_ns| verdicts(SurfaceSeen { level_ns, ..seen() })[0].1;
        assert_eq!(off(0.4), Verdict::Agrees);
        assert_eq!(off(-0.5), Verdict::Doubtful);
    }

    /// A bush of the raster over 30 of 300 traces: the echo of the ground is not where the raster puts it.
    #[test]
    fn a_stretch_without_an_echo_is_absent() {
        let picks = |bush: std::ops::Range<usize>| -> Vec<Option<SurfacePick>> {
            let level = |k: usize| if bush.contains(&k) { 40.0 } else { 1_000.0 };
            let pick = |k| SurfacePick {
                fast_time_s: 30e-9,
                level: level(k),
            };
            (0..300).map(|k| Some(pick(k))).collect()
        };
        assert!(!is_absent(&picks(0..0)));
        // Single traces without an echo are no stretch.
        assert!(!is_absent(&picks(100..110)));
        assert!(is_absent(&picks(100..140)));
        assert!(!is_absent(&[None, None]));
    }

    #[test]
    fn the_shape_is_that_of_a_stretch_and_not_of_strays() {
        let even: Vec<f64> = (0..240).map(|k| 0.2 + 0.1 * f64::from(k % 3 - 1)).collect();
        assert!(shape(&even, 0.2).unwrap().abs() < 0.11);
        let mut strays = even.clone();
        strays.iter_mut().step_by(5).for_each(|r| *r = 9.0);
        assert!(shape(&strays, 0.2).unwrap().abs() < 0.11);
        let mut bump = even;
        bump[100..125].fill(-1.3);
        assert!((shape(&bump, 0.2).unwrap() + 1.5).abs() < 1e-9);
    }
}
