//! Findings on the share of the image that ranges, aperture and incidence cover.

use acerra_imaging::IncidenceWeight;

use crate::align::geometry::{ImageGeometry, distance_m, ranges_held};
use crate::journal::finding::{Finding, Verdict};

/// The share of the image within the weight's support; antenna-pattern loss alone never contradicts.
pub(super) fn covered_by(
    weight: &IncidenceWeight,
    geometry: &ImageGeometry<'_>,
    boresight: Option<&[[f64; 3]]>,
) -> Option<Finding> {
    let within = SeenWithin {
        incidence_rad: weight.max_rad,
        off_boresight_rad: pattern_rad(weight),
        boresight,
    };
    let most = if within.off_boresight_rad < weight.max_rad {
        Verdict::Doubtful
    } else {
        Verdict::Contradicts
    };
    incidence_coverage(geometry, within).map(|finding| finding.at_most(most))
}

/// Angle from where the antenna looks at which its pattern has fallen by 10 dB; all round without a pattern.
fn pattern_rad(weight: &IncidenceWeight) -> f64 {
    const FALLEN: f64 = 0.316;
    if weight.cosine_power > 0.0 {
        FALLEN.powf(weight.cosine_power.recip()).acos()
    } else {
        std::f64::consts::PI
    }
}

/// Judges the share of the pixels whose range of closest approach is within `held_m`, the ranges that recorded window
/// and gate leave of each trace (m).
///
/// An image of which no trace holds any pixel is empty, which contradicts; an image of which less than half can be
/// focused is doubtful.
pub(super) fn range_coverage(geometry: &ImageGeometry<'_>, held_m: &[[f64; 2]]) -> Option<Finding> {
    let held = ranges_held(geometry, held_m)?;
    let (focused, ranges_m) = (held.focused, held.range_m);
    let verdict = if !held.any {
        Verdict::Contradicts
    } else if focused < 0.5 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Some(
        Finding::judged("range_coverage", focused, "share of the image", verdict)
            .expecting(1.0)
            .because(format!(
                "{:.0} % of the image lies, at closest approach, at ranges that the data hold after \
                 gating, {:.1} to {:.1} m ([image] x_m, y_m, z_m; [preprocess] gate_ns; [radar] \
                 delay_ns)",
                100.0 * focused,
                ranges_m[0],
                ranges_m[1]
            )),
    )
}

/// Share of the pixels whose closest approach lies within the track, not at one of its ends.
///
/// Beyond the ends a target is seen from one side alone, at a slant: smeared along and displaced
/// across. An image of which less than half lies abeam is doubtful.
pub(super) fn aperture_coverage(geometry: &ImageGeometry<'_>) -> Option<Finding> {
    let last = geometry
        .position_m
        .len()
        .checked_sub(1)
        .filter(|n| *n > 1)?;
    let is_abeam = |pixel: &&[f64; 3]| {
        let nearest = (0..=last).min_by(|a, b| {
            let range_m = |k: &usize| distance_m(geometry.position_m[*k], **pixel);
            range_m(a).total_cmp(&range_m(b))
        });
        nearest.is_some_and(|k| k != 0 && k != last)
    };
    let pixels = geometry.pixel_m.len().max(1) as f64;
    let abeam = geometry.pixel_m.iter().filter(is_abeam).count() as f64 / pixels;
    let verdict = if abeam < 0.5 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Some(
        Finding::judged("aperture_coverage", abeam, "share of the image", verdict)
            .expecting(1.0)
            .because(format!(
                "{:.0} % of the image lies abeam of the {} traces imaged, the rest beyond the ends \
                 of the track ([radar] select, [image] x_m, y_m; axes exchanged or of the wrong sign in \
                 the file of the positions)",
                100.0 * abeam,
                last + 1
            )),
    )
}

/// Directions from which a pixel counts.
#[derive(Clone, Copy, Debug)]
struct SeenWithin<'a> {
    /// Greatest angle of incidence, from the vertical (rad).
    pub incidence_rad: f64,
    /// Greatest angle from where the antenna looks (rad).
    pub off_boresight_rad: f64,
    /// Axis of the antenna at each trace, as unit vectors; `None` where the antenna looks straight down.
    pub boresight: Option<&'a [[f64; 3]]>,
}

impl SeenWithin<'_> {
    /// Whether trace `k` at `position_m` sees a pixel.
    fn sees(&self, k: usize, position_m: [f64; 3], pixel_m: [f64; 3]) -> bool {
        let way: [f64; 3] = std::array::from_fn(|a| pixel_m[a] - position_m[a]);
        let looks = self.boresight.and_then(|all| all.get(k));
        let looks = *looks.unwrap_or(&[0.0, 0.0, -1.0]);
        let range_m = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        let along_m = (0..3).map(|a| way[a] * looks[a]).sum::<f64>();
        let off_boresight_rad = (along_m / range_m).clamp(-1.0, 1.0).acos();
        way[0].hypot(way[1]).atan2(-way[2]) < self.incidence_rad
            && off_boresight_rad < self.off_boresight_rad
    }
}

/// Share of the pixels that a limit of the incidence angle, stated or by the antenna's pattern about where it
/// looks, lets any trace see.
fn incidence_coverage(geometry: &ImageGeometry<'_>, within: SeenWithin<'_>) -> Option<Finding> {
    if geometry.position_m.is_empty() {
        return None;
    }
    let is_seen = |pixel: &&[f64; 3]| {
        let mut traces = geometry.position_m.iter().enumerate();
        traces.any(|(k, position)| within.sees(k, *position, **pixel))
    };
    let pixels = geometry.pixel_m.len().max(1) as f64;
    let seen = geometry.pixel_m.iter().filter(is_seen).count() as f64 / pixels;
    let verdict = match seen {
        0.0 => Verdict::Contradicts,
        s if s < 0.5 => Verdict::Doubtful,
        _ => Verdict::Agrees,
    };
    let about_axis = if within.off_boresight_rad < std::f64::consts::PI {
        let pattern_deg = within.off_boresight_rad.to_degrees();
        format!(" and within {pattern_deg:.0}° of where the antenna looks")
    } else {
        String::new()
    };
    Some(
        Finding::judged("incidence_coverage", seen, "share of the image", verdict)
            .expecting(1.0)
            .because(format!(
                "{:.0} % of the image is seen at incidences below {:.0}°{about_axis}, beyond which its weight \
                 takes it away ([image] max_incidence_deg, antenna_cosine_power, antenna_axis, x_m, y_m)",
                100.0 * seen,
                within.incidence_rad.to_degrees(),
            )),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::geometry::samples::{geometry, track};

    #[test]
    fn a_steep_pattern_lets_less_through_than_its_limit() {
        let within_deg = |cosine_power| {
            let weight = IncidenceWeight {
                cosine_power,
                ..IncidenceWeight::default()
            };
            pattern_rad(&weight).to_degrees()
        };
        assert!((within_deg(0.0) - 180.0).abs() < 1e-9);
        // cos² falls to 10 dB at 56°, cos²⁰ at 19°.
        assert!((within_deg(2.0) - 55.8).abs() < 0.2);
        assert!((within_deg(20.0) - 19.2).abs() < 0.2);
    }

    #[test]
    fn an_image_beyond_the_ends_of_the_track_is_doubtful() {
        let pixels: Vec<[f64; 3]> = (0..19).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        let judge = |track: &[[f64; 3]]| aperture_coverage(&geometry(track, &pixels)).unwrap();
        let whole = track(0.1, 10.0);
        assert_eq!(judge(&whole).verdict, Verdict::Agrees);
        let start = judge(&whole[..60]);
        assert_eq!(start.verdict, Verdict::Doubtful);
        assert!((start.value.unwrap() - 5.0 / 19.0).abs() < 1e-9);
    }

    #[test]
    fn a_narrow_limit_of_incidence_leaves_little_of_the_image() {
        let track = track(0.1, 10.0);
        let pixels: Vec<[f64; 3]> = (0..19).map(|k| [9.0, f64::from(k) - 11.0, 0.0]).collect();
        let steep = |degrees: f64| SeenWithin {
            incidence_rad: degrees.to_radians(),
            off_boresight_rad: std::f64::consts::PI,
            boresight: None,
        };
        let judge = |within: SeenWithin<'_>| {
            incidence_coverage(&geometry(&track, &pixels), within).unwrap()
        };
        assert_eq!(judge(steep(60.0)).verdict, Verdict::Agrees);
        assert_eq!(judge(steep(5.0)).verdict, Verdict::Doubtful);
        assert_eq!(judge(steep(0.0)).verdict, Verdict::Contradicts);
        // A pattern about the vertical is a limit of incidence; about an axis that looks away, another one.
        let pattern = |degrees: f64, boresight| SeenWithin {
            incidence_rad: std::f64::consts::FRAC_PI_2,
            off_boresight_rad: degrees.to_radians(),
            boresight,
        };
        for degrees in [60.0, 30.0, 5.0] {
            let about_vertical = judge(pattern(degrees, None));
            assert_eq!(about_vertical.value, judge(steep(degrees)).value);
        }
        // Pixels 9 m to either side of a track 10 m up lie 42° off the vertical.
        let to_side = vec![[0.0, 0.8, -0.6]; track.len()];
        for (y_m, seen) in [(7.0, 1.0), (-11.0, 0.0)] {
            let pixel = [[9.0, y_m, 0.0]];
            let judge = |within| incidence_coverage(&geometry(&track, &pixel), within).unwrap();
            assert_eq!(judge(pattern(30.0, None)).value, Some(0.0));
            assert_eq!(judge(pattern(30.0, Some(&to_side))).value, Some(seen));
        }
    }

    #[test]
    fn an_image_out_of_range_contradicts() {
        let track = track(0.1, 10.0);
        let held = vec![[9.0, 14.0]; track.len()];
        let judge = |pixels: &[[f64; 3]]| {
            range_coverage(&geometry(&track, pixels), &held)
                .unwrap()
                .verdict
        };
        assert_eq!(judge(&[[4.0, 0.0, 0.0], [9.0, 0.0, 0.0]]), Verdict::Agrees);
        assert_eq!(judge(&[[1004.0, 0.0, 0.0]]), Verdict::Contradicts);
        let mut mostly_far = vec![[4.0, 0.0, 0.0]];
        mostly_far.extend((0..20).map(|k| [60.0 + f64::from(k), 0.0, 0.0]));
        assert_eq!(judge(&mostly_far), Verdict::Doubtful);
        // Seen from afar alone: 13 m at most off the closest approach of 10.2 m.
        let late = vec![[11.0, 14.0]; track.len()];
        let seen_late = range_coverage(&geometry(&track, &[[9.0, 0.0, 0.0]]), &late);
        assert_eq!(seen_late.unwrap().verdict, Verdict::Doubtful);
    }
}
