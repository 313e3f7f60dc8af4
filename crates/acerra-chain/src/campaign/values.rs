//! Which values of single keys a campaign may have.

use std::fmt::Debug;

use acerra_settings::{Rule, ValueError, check, each, given, rules, within};

use super::sections::{
    Files, GnssSection, GroundSection, ImageSection, MeasureSection, PreprocessSection,
    TrackSection, TracksSection, TrajectorySection,
};
use crate::autofocus::AutofocusOptions;
use crate::choices::{FARTHEST_M, Heights, LONGEST_NS, LONGEST_S, Permittivity};
use crate::focus::inversion::options::InversionSection;

/// Smallest pixel (m).
const SMALLEST_PIXEL_M: f64 = 1e-6;

/// A rule whose value is shown as the file's reader holds it.
pub(super) fn rule(
    key: &'static str,
    holds: bool,
    expected: &'static str,
    found: impl Debug,
) -> Rule {
    Rule::new(key, holds, expected, format!("{found:?}"))
}

/// Whether each is a coordinate (m) near a flight.
pub(super) fn near<const N: usize>(values: &[f64; N]) -> bool {
    values.iter().all(|v| v.abs() <= FARTHEST_M)
}

pub(super) fn is_volume(image: &ImageSection) -> bool {
    matches!(image.z_m, Some(Heights::Range(_)))
}

fn is_positive(v: &f64) -> bool {
    v.is_finite() && *v > 0.0
}

/// Limits of the filters along fast time.
pub(super) fn preprocess(section: &PreprocessSection) -> Result<(), ValueError> {
    let rules = rules!(section as "{:?}" {
        dewow_ns: given(|ns| *ns > 0.0 && *ns <= LONGEST_NS) => "a time above 0 ns, to a million",
        band_pass_ghz: given(|[low, high]: &[f64; 2]| (0.0..*high).contains(low) && *high <= 1e6)
            => "two frequencies from 0 GHz on, the lower first",
    });
    check("preprocess", &rules)
}

pub(super) fn autofocus(section: &AutofocusOptions) -> Result<(), ValueError> {
    let rules = rules!(section as "{:?}" {
        sigma_m: given(each(|v| is_positive(v) && *v <= 100.0))
            => "three standard deviations above 0 m, to 100 m",
        correlation_s: given(is_positive) => "a time above 0 s",
        delay_sigma_ns: given(within(0.0..=100.0)) => "0 ns to 100 ns",
        clock_offset_sigma_s: given(within(0.0..=1.0)) => "0 s to 1 s",
        clock_drift_sigma_ppm: within(0.0..=1e4) => "0 ppm to 10000 ppm",
        lever_arm_sigma_m: each(within(0.0..=10.0)) => "three standard deviations of 0 m to 10 m",
        height_sigma_m: within(0.0..=100.0) => "0 m to 100 m",
        light_speed_sigma_m_s: within(0.0..=1e8) => "0 m/s to 1e8 m/s",
        track_delay_sigma_ns: given(within(0.0..=100.0)) => "0 ns to 100 ns",
        track_phase_sigma_deg: within(0.0..=180.0) => "0° to 180°",
        track_shift_sigma_m: given(each(within(0.0..=100.0)))
            => "three standard deviations of 0 m to 100 m",
        max_points: given(within(1..=100)) => "1 to 100 points",
    });
    check("autofocus", &rules)
}

pub(super) fn ground(section: &GroundSection) -> Result<(), ValueError> {
    let is_permittivity = |v: f64| (1.0..=100.0).contains(&v);
    let is_conductivity = |v: f64| (0.0..=10.0).contains(&v);
    let is_layered = !section.layer.is_empty();
    let rules = rules!(section as "{:?}" {
        relative_permittivity: |stated| stated.is_none() == is_layered
            && stated.and_then(Permittivity::given).is_none_or(is_permittivity)
            => "1 to 100, or \"auto\", or [[ground.layer]] tables instead",
        conductivity_s_m: |v| is_conductivity(*v) && (!is_layered || *v == 0.0)
            => "0 to 10, and none together with [[ground.layer]] tables",
        surface_z_m: |z| near(&[*z]) => "a height within 1e7 m",
        layer: |layers| layers.len() <= 8 && layers.iter().all(|l| {
            is_permittivity(l.relative_permittivity) && is_conductivity(l.conductivity_s_m)
        }) => "at most 8 layers of permittivity 1 to 100 and conductivity 0 to 10",
    });
    check("ground", &rules)
}

pub(super) fn track(section: &TrackSection) -> Result<(), ValueError> {
    let (delay_ns, phase_deg) = (section.delay_ns, section.phase_deg);
    let both = Rule::new(
        "delay_ns, phase_deg",
        delay_ns.abs() <= LONGEST_NS && phase_deg.abs() <= 1e6,
        "within 1e6 ns and 1e6°",
        format!("{delay_ns} and {phase_deg}"),
    );
    check("track", &[both])
}

pub(super) fn tracks(section: &TracksSection) -> Result<(), ValueError> {
    let window = rules!(section as "{}" {
        window_ns: |ns| *ns > 0.0 && *ns <= 1e3 => "above 0 and at most 1000",
    });
    check("tracks", &window)?;
    let target = rules!(section as "{:?}" { target_m: given(near) => "coordinates within 1e7 m" });
    check("tracks", &target)
}

pub(super) fn looks(image: &ImageSection) -> Result<(), ValueError> {
    let count = Rule::new("looks", image.looks != Some(0), "at least 1", 0);
    check("image", &[count])?;
    let overlap = rules!(image as "{}" {
        look_overlap: |share| (0.0..1.0).contains(share) => "at least 0 and below 1",
    });
    check("image", &overlap)
}

pub(super) fn trajectory(section: &TrajectorySection) -> Result<(), ValueError> {
    let is_place = |[latitude, longitude, height]: &[f64; 3]| {
        latitude.abs() <= 90.0 && longitude.abs() <= 360.0 && height.abs() < 1e6
    };
    let rules = rules!(section as "{:?}" {
        lever_arm_m: each(|v: &f64| v.abs() < 1e3) => "three lengths below a kilometre",
        max_gap_s: given(|gap| *gap > 0.0 && *gap <= LONGEST_S) => "a time above 0 s, to 1e10 s",
        origin_deg_m: given(is_place) => "[latitude, longitude, height]: degrees and metres",
    });
    check("trajectory", &rules)
}

pub(super) fn gnss(section: &GnssSection) -> Result<(), ValueError> {
    let places = [section.base_ecef_m, section.base_deg_m];
    let are_near = places.iter().flatten().all(near);
    let named = |key, files: &Files| rule(key, !files.0.is_empty(), "a file", &files.0);
    let rules = [
        named("rover", &section.rover),
        named("base", &section.base),
        rule("base_ecef_m", are_near, "coordinates within 1e7 m", places),
    ];
    check("gnss", &rules)
}

pub(super) fn extent(image: &ImageSection) -> Result<(), ValueError> {
    let [low, high] = image.band_ghz;
    let is_one = low == high;
    let rules = rules!(image as "{:?}" {
        band_ghz: |[low, high]| *low > 0.0 && low <= high && *high < 1e3 => "0 < low <= high < 1000",
        frequencies: |n| (1..=1_000_000).contains(n) && (*n > 1 || is_one)
            => "at least 2 (1 for a band of a single frequency) and at most a million",
    });
    check("image", &rules)?;
    for (key, range) in [("x_m", image.x_m), ("y_m", image.y_m)] {
        let is_range = range.is_none_or(|ends| near(&ends) && ends[0] <= ends[1]);
        let expected = "[from, to] with from <= to, within 1e7 m";
        check(
            "image",
            &[rule(key, is_range, expected, range.unwrap_or_default())],
        )?;
    }
    Ok(())
}

pub(super) fn pixels(image: &ImageSection) -> Result<(), ValueError> {
    let is_length = within(SMALLEST_PIXEL_M..=FARTHEST_M);
    let is_volume = is_volume(image);
    let rules = rules!(image as "{:?}" {
        geoid_height_m: within(-1e3..=1e3) => "a height within 1000 m",
        pixel_z_m: given(|step| is_length(step) && is_volume)
            => "1e-6 m to 1e7 m, with z_m = [from, to]",
        ground_z_m: given(|z| near(&[*z]) && is_volume)
            => "a height within 1e7 m, with z_m = [from, to]",
        pixel_m: &is_length => "1e-6 m to 1e7 m",
    });
    check("image", &rules)
}

pub(super) fn focus(image: &ImageSection) -> Result<(), ValueError> {
    let rules = rules!(image as "{:?}" {
        max_incidence_deg: given(|deg| *deg > 0.0 && *deg <= 90.0) => "above 0 and at most 90",
        incidence_taper_deg: within(0.1..=90.0) => "0.1 to 90",
        antenna_cosine_power: within(0.0..=100.0) => "0 to 100",
        accuracy: |share| (1e-12..1.0).contains(share) => "1e-12 <= accuracy < 1",
        memory_gb: given(within(0.01..=1e5)) => "0.01 to 100000",
        light_speed_m_s: |speed| *speed > 1e6 && *speed <= 3e8 => "above 1e6 and at most 3e8",
    });
    check("image", &rules)
}

pub(super) fn inversion(section: &InversionSection) -> Result<(), ValueError> {
    let is_level = |db: &f64| (-120.0..0.0).contains(db);
    let rules = rules!(section as "{:?}" {
        threshold_db: is_level => "from -120 to below 0",
        damping: given(|v| *v > 0.0 && *v < 1e3) => "above 0 and below 1000",
        sparsity: given(|v| *v > 0.0 && *v < 1.0) => "above 0 and below 1",
        clean_threshold_db: given(is_level) => "from -120 to below 0",
        clean_gain: |v| *v > 0.0 && *v <= 1.0 => "above 0 and at most 1",
    });
    check("image.inversion", &rules)?;
    let counts = (section.max_iterations, section.resolution_points);
    let are_counts = counts.0.is_none_or(|n| (1..=100_000).contains(&n)) && counts.1 <= 100;
    let both = rule(
        "max_iterations, resolution_points",
        are_counts,
        "1 to 100000 iterations and at most 100 points",
        counts,
    );
    check("image.inversion", &[both])
}

pub(super) fn measure(section: &MeasureSection) -> Result<(), ValueError> {
    let rules = rules!(section as "{:?}" {
        threshold_db: |db| db.is_finite() && *db < 0.0 => "a level below 0 dB",
    });
    check("measure", &rules)
}
