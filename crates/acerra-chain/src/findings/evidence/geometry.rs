//! Geometry of flight and grid: whether pixels, scans and ranges fit one another.

use std::f64::consts::TAU;

use super::finding::{Finding, Verdict};

/// Flight, grid and band of an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageGeometry<'a> {
    /// Phase centre of each trace: east, north, up (m).
    pub position_m: &'a [[f64; 3]],
    /// Some pixels of the image, corners and middle at least (m).
    pub pixel_m: &'a [[f64; 3]],
    /// Lowest and highest frequency (Hz).
    pub band_hz: [f64; 2],
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Span of the two-way wavenumber along east and north (rad/m) at `pixel_m`: the support of its
/// point spread function, over all traces and the band.
#[must_use]
pub fn wavenumber_span(geometry: &ImageGeometry<'_>, pixel_m: [f64; 3]) -> [f64; 2] {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for position in geometry.position_m {
        let away: [f64; 3] = std::array::from_fn(|i| pixel_m[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        for frequency_hz in geometry.band_hz {
            let wavenumber = 2.0 * TAU * frequency_hz / geometry.light_speed_m_s;
            for axis in 0..2 {
                let along = wavenumber * away[axis] / range_m.max(1e-9);
                low[axis] = low[axis].min(along);
                high[axis] = high[axis].max(along);
            }
        }
    }
    std::array::from_fn(|axis| (high[axis] - low[axis]).max(0.0))
}

/// Pixel size against the resolution cell 2π/ΔK, the finer of the two axes, at the image's best
/// resolved pixel of those given. The edges of the aperture add little, so that the lobe is about
/// twice as wide as the cell; larger pixels leave gaps in which a target can disappear.
#[must_use]
pub fn pixel_size(geometry: &ImageGeometry<'_>, pixel_size_m: f64) -> Option<Finding> {
    let span = geometry
        .pixel_m
        .iter()
        .flat_map(|pixel| wavenumber_span(geometry, *pixel))
        .fold(0.0, f64::max);
    if !(span > 0.0 && pixel_size_m.is_finite()) {
        return None;
    }
    let cell_m = TAU / span;
    let verdict = match pixel_size_m / cell_m {
        r if r <= 2.0 => Verdict::Agrees,
        r if r <= 6.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    Some(
        Finding::judged("pixel_size", pixel_size_m, "m", verdict)
            .expecting(cell_m)
            .because(format!(
                "pixels of {pixel_size_m} m, a resolution cell of {cell_m:.3} m: above twice the \
                 cell, targets fall between pixels ([image] pixel_m)"
            )),
    )
}

/// Level of the grating lobes that the spacing of the scans leaves, dB below the main lobe.
///
/// Where the two-way path changes by more than half a wavelength from trace to trace (spacing above
/// λ/4 at the steepest angle), aliased lobes appear; a band of width B about f smears each over all
/// but f/B traces, so that its amplitude is f/(B·N) of N traces.
#[must_use]
pub fn scan_spacing(geometry: &ImageGeometry<'_>) -> Option<Finding> {
    let [low_hz, high_hz] = geometry.band_hz;
    let wavelength_m = geometry.light_speed_m_s / high_hz;
    let mut steps_m: Vec<f64> = geometry
        .position_m
        .windows(2)
        .map(|pair| distance_m(pair[0], pair[1]))
        .filter(|step| *step > 0.0)
        .collect();
    if steps_m.len() < 2 {
        return None;
    }
    steps_m.sort_by(f64::total_cmp);
    let spacing_m = steps_m[(steps_m.len() - 1) * 95 / 100];
    let steepest = steepest_sine(geometry);
    let allowed_m = 0.25 * wavelength_m / steepest.max(1e-6);
    let traces = geometry.position_m.len() as f64;
    let smeared = 0.5 * (low_hz + high_hz) / (high_hz - low_hz).max(1e-3 * high_hz);
    let lobe_db = 20.0 * (smeared / traces).min(1.0).log10();
    let verdict = if spacing_m <= allowed_m || lobe_db < -20.0 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Some(
        Finding::judged("scan_spacing", spacing_m, "m", verdict)
            .expecting(allowed_m)
            .because(format!(
                "scans are {spacing_m:.3} m apart, λ/4 at the steepest angle imaged is \
                 {allowed_m:.3} m; the band smears aliased lobes to {lobe_db:.0} dB (fly slower, or \
                 scan faster)"
            )),
    )
}

/// Greatest sine of the angle between the line of sight and the plane across the track.
fn steepest_sine(geometry: &ImageGeometry<'_>) -> f64 {
    let stride = (geometry.position_m.len() / 64).max(1);
    let mut steepest: f64 = 0.0;
    for pair in geometry.position_m.windows(2).step_by(stride) {
        let step_m = distance_m(pair[0], pair[1]);
        if step_m <= 0.0 {
            continue;
        }
        let direction: [f64; 3] = std::array::from_fn(|i| (pair[1][i] - pair[0][i]) / step_m);
        for pixel in geometry.pixel_m {
            let range_m = distance_m(pair[0], *pixel).max(1e-9);
            let along: f64 = (0..3).map(|i| direction[i] * (pixel[i] - pair[0][i])).sum();
            steepest = steepest.max((along / range_m).abs());
        }
    }
    steepest
}

/// Ranges that the data hold about each trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage<'a> {
    /// Nearest and farthest range that the cleaned data of each trace hold (m).
    pub range_m: &'a [[f64; 2]],
}

/// Share of the pixels whose range of closest approach the recorded window and the gate hold.
///
/// An echo is focused from the traces about its closest approach; traces from afar alone leave
/// smeared arcs. Where no trace at all holds a pixel the image is empty, which contradicts; an image
/// of which less than half can be focused is doubtful.
#[must_use]
pub fn coverage(geometry: &ImageGeometry<'_>, held: Coverage<'_>) -> Option<Finding> {
    if geometry.position_m.is_empty() || held.range_m.len() != geometry.position_m.len() {
        return None;
    }
    let stride = (geometry.position_m.len() / 256).max(1);
    let traces = || geometry.position_m.iter().zip(held.range_m).step_by(stride);
    let is_held = |range_m: f64, [near, far]: &[f64; 2]| (*near..=*far).contains(&range_m);
    let is_seen = |pixel: &[f64; 3]| {
        traces().any(|(position, held)| is_held(distance_m(*position, *pixel), held))
    };
    let is_focused = |pixel: &[f64; 3]| {
        traces()
            .map(|(position, held)| (distance_m(*position, *pixel), held))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .is_some_and(|(range_m, held)| is_held(range_m, held))
    };
    let pixels = geometry.pixel_m.len().max(1) as f64;
    let focused = geometry.pixel_m.iter().filter(|p| is_focused(p)).count() as f64 / pixels;
    let verdict = if !geometry.pixel_m.iter().any(is_seen) {
        Verdict::Contradicts
    } else if focused < 0.5 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let ranges_m = held.range_m.iter().fold(
        [f64::INFINITY, f64::NEG_INFINITY],
        |[low, high], [near, far]| [low.min(*near), high.max(*far)],
    );
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
#[must_use]
pub fn aperture_coverage(geometry: &ImageGeometry<'_>) -> Option<Finding> {
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
pub struct SeenWithin<'a> {
    /// Greatest angle of incidence, from the vertical (rad).
    pub incidence_rad: f64,
    /// Greatest angle from where the antenna looks (rad).
    pub off_boresight_rad: f64,
    /// Where the antenna looks at each trace, as unit vectors; `None` where it looks straight down.
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
#[must_use]
pub fn incidence_coverage(geometry: &ImageGeometry<'_>, within: SeenWithin<'_>) -> Option<Finding> {
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

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND_HZ: [f64; 2] = [3.1e9, 4.8e9];

    fn track(step_m: f64, height_m: f64) -> Vec<[f64; 3]> {
        let count = (18.0 / step_m) as i32;
        (0..count)
            .map(|k| [f64::from(k) * step_m, -2.0, height_m])
            .collect()
    }

    fn geometry<'a>(position_m: &'a [[f64; 3]], pixel_m: &'a [[f64; 3]]) -> ImageGeometry<'a> {
        ImageGeometry {
            position_m,
            pixel_m,
            band_hz: BAND_HZ,
            light_speed_m_s: 299_792_458.0,
        }
    }

    #[test]
    fn the_resolution_cell_is_that_of_aperture_and_band() {
        // Over the middle of a long track the along-track wavenumber spans ±2K sin θ.
        let track = track(0.05, 10.0);
        let pixels = [[9.0, -2.0, 0.0]];
        let [along, _] = wavenumber_span(&geometry(&track, &pixels), pixels[0]);
        let sine = 9.0 / 181.0_f64.sqrt();
        let expected = 2.0 * 2.0 * TAU * 4.8e9 / 299_792_458.0 * sine;
        assert!((along / expected - 1.0).abs() < 0.01, "{along} {expected}");
    }

    #[test]
    fn pixels_of_ten_metres_contradict_and_of_a_centimetre_agree() {
        let track = track(0.1, 10.0);
        let pixels = [[4.0, 0.0, 0.0], [14.0, 0.0, 0.0]];
        let judge = |size| {
            pixel_size(&geometry(&track, &pixels), size)
                .unwrap()
                .verdict
        };
        assert_eq!(judge(0.01), Verdict::Agrees);
        assert_eq!(judge(0.1), Verdict::Doubtful);
        assert_eq!(judge(10.0), Verdict::Contradicts);
    }

    #[test]
    fn sparse_scans_of_a_wide_band_are_no_fault_until_they_are_few() {
        let pixels = [[0.0, 0.0, 0.0], [18.0, 0.0, 0.0]];
        let dense = track(0.1, 10.0);
        assert_eq!(
            scan_spacing(&geometry(&dense, &pixels)).unwrap().verdict,
            Verdict::Agrees
        );
        let sparse = track(1.5, 10.0);
        assert_eq!(
            scan_spacing(&geometry(&sparse, &pixels)).unwrap().verdict,
            Verdict::Doubtful
        );
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
            coverage(&geometry(&track, pixels), Coverage { range_m: &held })
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
        let seen_late = coverage(
            &geometry(&track, &[[9.0, 0.0, 0.0]]),
            Coverage { range_m: &late },
        );
        assert_eq!(seen_late.unwrap().verdict, Verdict::Doubtful);
    }
}
