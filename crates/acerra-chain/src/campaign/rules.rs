//! Which values of a campaign are possible.

use std::fmt::Debug;
use std::path::Path;

use acerra_settings::{Rule, check};

use super::sections::{
    AutofocusSection, Files, GnssSection, GroundSection, ImageSection, MeasureSection,
    PreprocessSection, TrackSection, TracksSection, TrajectorySection,
};
use super::{Campaign, CampaignError};
use crate::choices::{
    Delay, FARTHEST_M, GroundSurface, Heights, LONGEST_NS, LONGEST_S, Permittivity, Sum, Values,
    ZeroTiming,
};
use crate::focus::inversion::options::{InversionSection, Method};

impl Campaign {
    /// Refuses values that are impossible, and keys that exclude each other.
    pub(super) fn check(&self) -> Result<(), CampaignError> {
        self.check_sources()?;
        for track in &self.track {
            check("track", &track_rules(track))?;
            let present = !track.radar.is_absent();
            check(
                "track.radar",
                &[Rule::new("file", present, "a radar log", "none")],
            )?;
        }
        check("tracks", &tracks_rules(&self.tracks))?;
        check("autofocus", &autofocus_rules(&self.autofocus))?;
        self.check_looks_and_volumes()?;
        self.check_ground()?;
        for track in self.each_track() {
            track.check_one()?;
        }
        Ok(())
    }

    /// One flight here, or several in `[[track]]`.
    fn check_sources(&self) -> Result<(), CampaignError> {
        if self.track.is_empty() {
            let expected = "a radar log, here or in [[track]]";
            let present = !self.radar.is_absent();
            check("radar", &[Rule::new("file", present, expected, "none")])?;
            return Ok(());
        }
        if !self.radar.is_absent() {
            return exclude("[radar]", "[[track]]", "both give radar logs");
        }
        if self.gnss.is_some() || self.trajectory != TrajectorySection::default() {
            return exclude(
                "[trajectory] or [gnss]",
                "[[track]]",
                "each track has its own: [track.trajectory], [track.gnss]",
            );
        }
        if self.image.looks.is_some() {
            return exclude("[image] looks", "[[track]]", "looks cut a single track");
        }
        Ok(())
    }

    /// The ground is one soil or layers, below a plane or a volume that is focused as it is.
    fn check_ground(&self) -> Result<(), CampaignError> {
        let Some(ground) = &self.ground else {
            return Ok(());
        };
        check("ground", &ground_rules(ground))?;
        if let Some((last, above)) = ground.layer.split_last() {
            let thick = above
                .iter()
                .all(|l| l.thickness_m.is_some_and(|t| t.is_finite() && t > 0.0));
            let rules = [rule(
                "thickness_m",
                thick && last.thickness_m.is_none(),
                "above 0 in every layer but the last, which has none",
                ground
                    .layer
                    .iter()
                    .map(|l| l.thickness_m)
                    .collect::<Vec<_>>(),
            )];
            check("ground.layer", &rules)?;
        }
        let follows_terrain = ground.surface == GroundSurface::Terrain;
        if self.image.terrain.is_some() != follows_terrain {
            return exclude(
                "[ground] surface",
                "[image] terrain",
                "surface = \"terrain\" needs the terrain, and a level surface has none",
            );
        }
        let is_uneven = ground.surface != GroundSurface::Level;
        if is_uneven && self.image.z_m.is_none() {
            return exclude(
                "[ground] surface",
                "[image] z_m",
                "below uneven ground the image has heights of its own: state z_m",
            );
        }
        if is_uneven && !ground.layer.is_empty() {
            return exclude(
                "[ground] surface",
                "[[ground.layer]]",
                "layers are level, below a level surface",
            );
        }
        if self.image.method != Method::Adjoint {
            return exclude(
                "[ground]",
                "[image] method",
                "the scene below ground is not solved for",
            );
        }
        if self.autofocus.enabled {
            return exclude(
                "[ground]",
                "[autofocus] enabled",
                "positions are corrected by echoes through air",
            );
        }
        Ok(())
    }

    fn check_looks_and_volumes(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        if image.terrain.is_some() && image.incidence().is_some() {
            return exclude(
                "[image] max_incidence_deg and antenna_cosine_power",
                "[image] terrain",
                "incidence is counted from the vertical of a level plane",
            );
        }
        check("image", &look_rules(image))?;
        self.check_method()?;
        if !is_volume(image) {
            return Ok(());
        }
        if image.looks.is_some() {
            return exclude(
                "[image] looks",
                "[image] z_m = [from, to]",
                "looks are planes",
            );
        }
        if self.tracks.sum == Sum::Incoherent {
            return exclude(
                "[tracks] sum = \"incoherent\"",
                "[image] z_m = [from, to]",
                "a volume is resolved by coherence alone",
            );
        }
        Ok(())
    }

    /// What `[image] method` does not make.
    fn check_method(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        check("image.inversion", &inversion_rules(&image.inversion))?;
        self.check_values()?;
        if image.method == Method::Adjoint {
            return Ok(());
        }
        if image.looks.is_some() {
            return exclude(
                "[image] looks",
                "[image] method",
                "looks are adjoints of a part of the pulses",
            );
        }
        if image.method == Method::Clean && is_volume(image) {
            return exclude(
                "[image] method = \"clean\"",
                "[image] z_m = [from, to]",
                "points are put back on one plane or terrain",
            );
        }
        if self.tracks.sum == Sum::Incoherent && image.method != Method::Sparse {
            return exclude(
                "[tracks] sum = \"incoherent\"",
                "[image] method",
                "all tracks explain one scene (but with method = \"sparse\")",
            );
        }
        Ok(())
    }

    /// Reflectivities are those of an adjoint on a plane or terrain in air.
    fn check_values(&self) -> Result<(), CampaignError> {
        let image = &self.image;
        if image.values == Values::Sum {
            return Ok(());
        }
        let others = [
            (is_volume(image), "[image] z_m = [from, to]"),
            (image.looks.is_some(), "[image] looks"),
            (image.method != Method::Adjoint, "[image] method"),
            (self.ground.is_some(), "[ground]"),
            (
                self.tracks.sum == Sum::Incoherent,
                "[tracks] sum = \"incoherent\"",
            ),
        ];
        match others.iter().find(|(is_asked, _)| *is_asked) {
            Some((_, other)) => exclude(
                "[image] values = \"reflectivity\"",
                other,
                "only an adjoint on a plane or terrain in air is divided by what a point gives",
            ),
            None => Ok(()),
        }
    }

    /// Attitudes come from a log; an antenna on a gimbal needs one, and a gimbal that nothing is turned by is a
    /// mistake.
    fn check_attitudes(&self) -> Result<(), CampaignError> {
        let trajectory = &self.trajectory;
        let is_gimbal = self.image.antenna_axis.is_gimbal();
        let has_file = trajectory.file.is_some();
        let has_attitude_file = trajectory.attitude_file.is_some();
        let has_log = has_file || has_attitude_file;
        let rules = [
            Rule::new(
                "attitude_file",
                !has_attitude_file || has_file || self.gnss.is_some(),
                "positions of [gnss] or of a file beside it, which it turns",
                "none",
            ),
            rule(
                "attitude_file",
                !has_attitude_file || trajectory.attitude_file != trajectory.file,
                "another file than that of the positions, whose own attitudes count without it",
                &trajectory.attitude_file,
            ),
            Rule::new(
                if has_file || self.gnss.is_none() {
                    "file"
                } else {
                    "attitude_file"
                },
                has_log || !is_gimbal,
                "the log of an autopilot or a robot with the attitude of the gimbal, as [image] antenna_axis asks \
                 for it",
                "none",
            ),
            Rule::new(
                "attitude_source",
                has_log || trajectory.attitude_source.is_none(),
                "the log that it is a source of, [trajectory] file or attitude_file",
                "none",
            ),
            Rule::new(
                "source",
                has_file || trajectory.source.is_none(),
                "the log that it is a source of, [trajectory] file",
                "none",
            ),
            Rule::new(
                "gimbal_source",
                is_gimbal || trajectory.gimbal_source.is_none(),
                "[image] antenna_axis = \"gimbal\" or \"gimbal-forward\" beside it",
                self.image.antenna_axis.name(),
            ),
        ];
        Ok(check("trajectory", &rules)?)
    }

    /// The lines of one file or several.
    fn check_lines(&self) -> Result<(), CampaignError> {
        let radar = &self.radar;
        let is_grid = !radar.files.is_empty();
        if is_grid && !radar.file.as_os_str().is_empty() {
            return exclude("[radar] file", "[radar] files", "both give the radar log");
        }
        if is_grid && (self.gnss.is_some() || self.trajectory.file.is_some()) {
            return exclude(
                "[radar] files",
                "[trajectory] file or [gnss]",
                "each file of a grid places its traces by itself or along its line",
            );
        }
        if radar.line_start_m.is_some() && !radar.lines.is_empty() {
            return exclude(
                "[radar] line_start_m",
                "[radar] lines",
                "both place the lines",
            );
        }
        let has_both = radar.line_start_m.is_some() == radar.line_end_m.is_some();
        let step_m = radar.line_step_m;
        let is_regular = is_grid && radar.line_start_m.is_some();
        let is_one = !radar.files.0.iter().any(|file| is_pattern(file)) && radar.files.0.len() < 2;
        let ends = [radar.line_start_m, radar.line_end_m, step_m];
        let rows = radar.lines.iter().flat_map(|row| [row.start_m, row.end_m]);
        let are_finite = ends.into_iter().flatten().chain(rows).all(|p| near(&p));
        let rules = [
            Rule::new(
                "line_end_m",
                has_both,
                "both ends of the line, or neither",
                "one",
            ),
            rule("line_start_m", are_finite, "finite coordinates", ends),
            rule(
                "line_step_m",
                step_m.is_some() == (is_regular && !is_one) || is_regular && is_one,
                "the way from each line of several files to the next, beside line_start_m and line_end_m",
                step_m,
            ),
            rule(
                "line_step_m",
                step_m.is_none_or(|step| step != [0.0; 3]),
                "the way from each line to the next, which is not 0",
                step_m,
            ),
            Rule::new(
                "lines",
                is_grid || radar.lines.is_empty(),
                "[radar] files beside it",
                "none",
            ),
        ];
        Ok(check("radar", &rules)?)
    }

    /// The tables of a campaign of one track.
    fn check_one(&self) -> Result<(), CampaignError> {
        if self.radar.delay_ns == Some(Delay::Auto) && self.preprocess.zero_timing.is_some() {
            return exclude(
                "[radar] delay_ns = \"auto\"",
                "[preprocess] zero_timing",
                "both find the fast time at which range is zero",
            );
        }
        if self.radar.delay_ns.is_some()
            && self.preprocess.zero_timing == Some(ZeroTiming::DirectWave)
        {
            return exclude(
                "[radar] delay_ns",
                "[preprocess] zero_timing = \"direct-wave\"",
                "both say at which fast time range is zero",
            );
        }
        let offset_m = self.radar.antenna_offset_m;
        let is_near = |m: &[f64; 3]| m.iter().all(|m| m.abs() <= 100.0) && *m != [0.0; 3];
        let near = rule(
            "antenna_offset_m",
            offset_m.as_ref().is_none_or(is_near),
            "a way from the receiver of up to 100 m, not 0",
            offset_m,
        );
        check("radar", &[near])?;
        check("preprocess", &preprocess_rules(&self.preprocess))?;
        self.check_lines()?;
        check("trajectory", &trajectory_rules(&self.trajectory))?;
        self.check_attitudes()?;
        if let Some(gnss) = &self.gnss {
            if self.trajectory.file.is_some() {
                return exclude("[gnss]", "[trajectory] file", "both give the positions");
            }
            if gnss.base_ecef_m.is_some() && gnss.base_deg_m.is_some() {
                return exclude(
                    "[gnss] base_ecef_m",
                    "[gnss] base_deg_m",
                    "both give the base's place",
                );
            }
            check("gnss", &gnss_rules(gnss))?;
        }
        check("image", &extent_rules(&self.image))?;
        check_terrain(&self.image, self.ground.as_ref())?;
        check("image", &pixel_rules(&self.image))?;
        check("image", &focus_rules(&self.image))?;
        check("measure", &measure_rules(&self.measure))?;
        Ok(())
    }
}

fn exclude(
    first: &'static str,
    second: &'static str,
    reason: &'static str,
) -> Result<(), CampaignError> {
    Err(CampaignError::Conflict {
        first,
        second,
        reason,
    })
}

/// What the filters along fast time may be.
fn preprocess_rules(preprocess: &PreprocessSection) -> [Rule; 2] {
    let (window_ns, band_ghz) = (preprocess.dewow_ns, preprocess.band_pass_ghz);
    [
        rule(
            "dewow_ns",
            window_ns.is_none_or(|ns| ns > 0.0 && ns <= LONGEST_NS),
            "a time above 0 ns, to a million",
            window_ns,
        ),
        rule(
            "band_pass_ghz",
            band_ghz.is_none_or(|[low, high]| (0.0..high).contains(&low) && high <= 1e6),
            "two frequencies from 0 GHz on, the lower first",
            band_ghz,
        ),
    ]
}

/// A rule whose value is shown as the file's reader holds it.
fn rule(key: &'static str, holds: bool, expected: &'static str, found: impl Debug) -> Rule {
    Rule::new(key, holds, expected, format!("{found:?}"))
}

/// Smallest pixel (m).
const SMALLEST_PIXEL_M: f64 = 1e-6;
/// Whether each is a coordinate (m) of a flight's surroundings.
fn near(values: &[f64]) -> bool {
    values.iter().all(|v| v.abs() <= FARTHEST_M)
}

/// Whether a file's name stands for several.
fn is_pattern(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.contains(['*', '?'])
}

fn finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite())
}

fn is_volume(image: &ImageSection) -> bool {
    matches!(image.z_m, Some(Heights::Range(_)))
}

fn autofocus_rules(autofocus: &AutofocusSection) -> [Rule; 12] {
    let positive = |v: f64| v.is_finite() && v > 0.0;
    let within = |v: f64, most: f64| (0.0..=most).contains(&v);
    let sigma_m = autofocus.sigma_m;
    let delay = autofocus.delay_sigma_ns;
    [
        rule(
            "sigma_m",
            sigma_m.is_none_or(|s| s.iter().all(|v| positive(*v) && *v <= 100.0)),
            "three standard deviations above 0 m, to 100 m",
            sigma_m,
        ),
        rule(
            "correlation_s",
            autofocus.correlation_s.is_none_or(positive),
            "a time above 0 s",
            autofocus.correlation_s,
        ),
        rule(
            "delay_sigma_ns",
            delay.is_none_or(|ns| within(ns, 100.0)),
            "0 ns to 100 ns",
            delay,
        ),
        rule(
            "clock_offset_sigma_s",
            autofocus
                .clock_offset_sigma_s
                .is_none_or(|s| within(s, 1.0)),
            "0 s to 1 s",
            autofocus.clock_offset_sigma_s,
        ),
        rule(
            "clock_drift_sigma_ppm",
            within(autofocus.clock_drift_sigma_ppm, 1e4),
            "0 ppm to 10000 ppm",
            autofocus.clock_drift_sigma_ppm,
        ),
        rule(
            "lever_arm_sigma_m",
            autofocus.lever_arm_sigma_m.iter().all(|s| within(*s, 10.0)),
            "three standard deviations of 0 m to 10 m",
            autofocus.lever_arm_sigma_m,
        ),
        rule(
            "height_sigma_m",
            within(autofocus.height_sigma_m, 100.0),
            "0 m to 100 m",
            autofocus.height_sigma_m,
        ),
        rule(
            "light_speed_sigma_m_s",
            within(autofocus.light_speed_sigma_m_s, 1e8),
            "0 m/s to 1e8 m/s",
            autofocus.light_speed_sigma_m_s,
        ),
        rule(
            "track_delay_sigma_ns",
            autofocus
                .track_delay_sigma_ns
                .is_none_or(|ns| within(ns, 100.0)),
            "0 ns to 100 ns",
            autofocus.track_delay_sigma_ns,
        ),
        rule(
            "track_phase_sigma_deg",
            within(autofocus.track_phase_sigma_deg, 180.0),
            "0° to 180°",
            autofocus.track_phase_sigma_deg,
        ),
        rule(
            "track_shift_sigma_m",
            autofocus
                .track_shift_sigma_m
                .is_none_or(|s| s.iter().all(|v| within(*v, 100.0))),
            "three standard deviations of 0 m to 100 m",
            autofocus.track_shift_sigma_m,
        ),
        rule(
            "max_points",
            autofocus.max_points.is_none_or(|n| (1..=100).contains(&n)),
            "1 to 100 points",
            autofocus.max_points,
        ),
    ]
}

fn ground_rules(ground: &GroundSection) -> [Rule; 4] {
    let is_permittivity = |v: f64| (1.0..=100.0).contains(&v);
    let is_conductivity = |v: f64| (0.0..=10.0).contains(&v);
    let layers = &ground.layer;
    [
        rule(
            "relative_permittivity",
            ground.relative_permittivity.is_some() == layers.is_empty()
                && (ground.relative_permittivity)
                    .and_then(Permittivity::given)
                    .is_none_or(is_permittivity),
            "1 to 100, or \"auto\", or [[ground.layer]] tables instead",
            ground.relative_permittivity,
        ),
        rule(
            "conductivity_s_m",
            is_conductivity(ground.conductivity_s_m)
                && (layers.is_empty() || ground.conductivity_s_m == 0.0),
            "0 to 10, and none beside [[ground.layer]] tables",
            ground.conductivity_s_m,
        ),
        rule(
            "surface_z_m",
            near(&[ground.surface_z_m]),
            "a height within 1e7 m",
            ground.surface_z_m,
        ),
        rule(
            "layer",
            layers.len() <= 8
                && layers.iter().all(|l| {
                    is_permittivity(l.relative_permittivity) && is_conductivity(l.conductivity_s_m)
                }),
            "at most 8 layers of permittivity 1 to 100 and conductivity 0 to 10",
            layers,
        ),
    ]
}

fn track_rules(track: &TrackSection) -> [Rule; 1] {
    let (delay_ns, phase_deg) = (track.delay_ns, track.phase_deg);
    [Rule::new(
        "delay_ns, phase_deg",
        delay_ns.abs() <= LONGEST_NS && phase_deg.abs() <= 1e6,
        "within 1e6 ns and 1e6°",
        format!("{delay_ns} and {phase_deg}"),
    )]
}

fn tracks_rules(tracks: &TracksSection) -> [Rule; 2] {
    let window_ns = tracks.window_ns;
    let target_m = tracks.target_m;
    [
        Rule::new(
            "window_ns",
            window_ns > 0.0 && window_ns <= 1e3,
            "above 0 and at most 1000",
            window_ns,
        ),
        rule(
            "target_m",
            target_m.is_none_or(|p| near(&p)),
            "coordinates within 1e7 m",
            target_m,
        ),
    ]
}

fn look_rules(image: &ImageSection) -> [Rule; 2] {
    [
        Rule::new("looks", image.looks != Some(0), "at least 1", 0),
        Rule::new(
            "look_overlap",
            (0.0..1.0).contains(&image.look_overlap),
            "at least 0 and below 1",
            image.look_overlap,
        ),
    ]
}

fn trajectory_rules(trajectory: &TrajectorySection) -> [Rule; 3] {
    let arm_m = trajectory.lever_arm_m;
    let gap_s = trajectory.max_gap_s;
    let is_place = |[latitude, longitude, height]: [f64; 3]| {
        latitude.abs() <= 90.0 && longitude.abs() <= 360.0 && height.abs() < 1e6
    };
    [
        rule(
            "lever_arm_m",
            arm_m.iter().all(|v| v.abs() < 1e3),
            "three lengths below a kilometre",
            arm_m,
        ),
        rule(
            "max_gap_s",
            gap_s.is_none_or(|gap| gap > 0.0 && gap <= LONGEST_S),
            "a time above 0 s, to 1e10 s",
            gap_s,
        ),
        rule(
            "origin_deg_m",
            trajectory.origin_deg_m.is_none_or(is_place),
            "[latitude, longitude, height]: degrees and metres",
            trajectory.origin_deg_m,
        ),
    ]
}

fn gnss_rules(gnss: &GnssSection) -> [Rule; 3] {
    let places = [gnss.base_ecef_m, gnss.base_deg_m];
    let named = |key, files: &Files| rule(key, !files.0.is_empty(), "a file", &files.0);
    [
        named("rover", &gnss.rover),
        named("base", &gnss.base),
        rule(
            "base_ecef_m",
            places.iter().flatten().all(|place| near(place)),
            "coordinates within 1e7 m",
            places,
        ),
    ]
}

fn extent_rules(image: &ImageSection) -> [Rule; 4] {
    let [low, high] = image.band_ghz;
    let is_range = |range: [f64; 2]| near(&range) && range[0] <= range[1];
    let count = image.frequencies;
    [
        rule(
            "band_ghz",
            finite(&image.band_ghz) && 0.0 < low && low <= high && high < 1e3,
            "0 < low <= high < 1000",
            image.band_ghz,
        ),
        rule(
            "frequencies",
            (1..=1_000_000).contains(&count) && (count > 1 || low == high),
            "at least 2 (1 for a band of a single frequency) and at most a million",
            count,
        ),
        rule(
            "x_m",
            image.x_m.is_none_or(is_range),
            "[from, to] with from <= to, within 1e7 m",
            image.x_m.unwrap_or_default(),
        ),
        rule(
            "y_m",
            image.y_m.is_none_or(is_range),
            "[from, to] with from <= to, within 1e7 m",
            image.y_m.unwrap_or_default(),
        ),
    ]
}

fn check_terrain(
    image: &ImageSection,
    ground: Option<&GroundSection>,
) -> Result<(), CampaignError> {
    let is_below = ground.is_some_and(|ground| ground.surface == GroundSurface::Terrain);
    if image.terrain.is_some() && image.z_m.is_some() && !is_below {
        return exclude(
            "[image] terrain",
            "[image] z_m",
            "both give the heights of the image",
        );
    }
    if image.geoid.is_some() && image.geoid_height_m != 0.0 {
        return exclude(
            "[image] geoid",
            "[image] geoid_height_m",
            "both give the geoid's height",
        );
    }
    let is_described = image.terrain_crs.is_some() || image.geoid_height_m != 0.0;
    check(
        "image",
        &[Rule::new(
            "terrain",
            image.terrain.is_some() || !is_described,
            "a file, as terrain_crs or geoid_height_m is given",
            "none",
        )],
    )?;
    Ok(())
}

fn pixel_rules(image: &ImageSection) -> [Rule; 4] {
    let is_length = |v: f64| (SMALLEST_PIXEL_M..=FARTHEST_M).contains(&v);
    let volume = is_volume(image);
    [
        rule(
            "geoid_height_m",
            image.geoid_height_m.abs() <= 1e3,
            "a height within 1000 m",
            image.geoid_height_m,
        ),
        rule(
            "pixel_z_m",
            image.pixel_z_m.is_none_or(|step| is_length(step) && volume),
            "1e-6 m to 1e7 m, with z_m = [from, to]",
            image.pixel_z_m,
        ),
        rule(
            "ground_z_m",
            image.ground_z_m.is_none_or(|z| near(&[z]) && volume),
            "a height within 1e7 m, with z_m = [from, to]",
            image.ground_z_m,
        ),
        rule(
            "pixel_m",
            is_length(image.pixel_m),
            "1e-6 m to 1e7 m",
            image.pixel_m,
        ),
    ]
}

fn focus_rules(image: &ImageSection) -> [Rule; 6] {
    [
        rule(
            "max_incidence_deg",
            image.max_incidence_deg.is_none_or(|a| a > 0.0 && a <= 90.0),
            "above 0 and at most 90",
            image.max_incidence_deg,
        ),
        rule(
            "incidence_taper_deg",
            (0.1..=90.0).contains(&image.incidence_taper_deg),
            "0.1 to 90",
            image.incidence_taper_deg,
        ),
        rule(
            "antenna_cosine_power",
            (0.0..=100.0).contains(&image.antenna_cosine_power),
            "0 to 100",
            image.antenna_cosine_power,
        ),
        rule(
            "accuracy",
            (1e-12..1.0).contains(&image.accuracy),
            "1e-12 <= accuracy < 1",
            image.accuracy,
        ),
        rule(
            "memory_gb",
            image.memory_gb.is_none_or(|gb| (0.01..=1e5).contains(&gb)),
            "0.01 to 100000",
            image.memory_gb,
        ),
        rule(
            "light_speed_m_s",
            image.light_speed_m_s > 1e6 && image.light_speed_m_s <= 3e8,
            "above 1e6 and at most 3e8",
            image.light_speed_m_s,
        ),
    ]
}

fn inversion_rules(section: &InversionSection) -> [Rule; 6] {
    let is_share = |v: f64| v > 0.0 && v < 1.0;
    let is_level = |v: f64| v.is_finite() && (-120.0..0.0).contains(&v);
    let count = section.max_iterations;
    [
        rule(
            "threshold_db",
            is_level(section.threshold_db),
            "from -120 to below 0",
            section.threshold_db,
        ),
        rule(
            "damping",
            section.damping.is_none_or(|v| v > 0.0 && v < 1e3),
            "above 0 and below 1000",
            section.damping,
        ),
        rule(
            "sparsity",
            section.sparsity.is_none_or(is_share),
            "above 0 and below 1",
            section.sparsity,
        ),
        rule(
            "clean_threshold_db",
            section.clean_threshold_db.is_none_or(is_level),
            "from -120 to below 0",
            section.clean_threshold_db,
        ),
        rule(
            "clean_gain",
            section.clean_gain > 0.0 && section.clean_gain <= 1.0,
            "above 0 and at most 1",
            section.clean_gain,
        ),
        rule(
            "max_iterations, resolution_points",
            count.is_none_or(|n| (1..=100_000).contains(&n)) && section.resolution_points <= 100,
            "1 to 100000 iterations and at most 100 points",
            (count, section.resolution_points),
        ),
    ]
}

fn measure_rules(measure: &MeasureSection) -> [Rule; 1] {
    let level_db = measure.threshold_db;
    [rule(
        "threshold_db",
        level_db.is_finite() && level_db < 0.0,
        "a level below 0 dB",
        level_db,
    )]
}
