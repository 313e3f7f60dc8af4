//! The campaign file: the logs, how they belong together, and the image to make.

mod corrected;
mod error;
mod parameters;
mod rules;
mod sections;
mod track_rules;
mod values;

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::autofocus::AutofocusOptions;
use crate::prepare::Prepared;

pub use crate::choices::{
    Background, CalibrationSource, Contradictions, Delay, Gate, GroundSurface, HeightSource,
    Heights, LookTaper, Permittivity, ProductFormat, Select, Sum, TimeOffset, Unfixed, Values,
    Weight, ZeroTiming,
};
pub use crate::focus::inversion::options::{InversionSection, Method};
pub use error::CampaignError;
pub use sections::{
    ChecksSection, Files, GnssSection, GroundLayerSection, GroundSection, ImageSection,
    LineSection, MeasureSection, PreprocessSection, ProductsSection, RadarSection, TrackSection,
    TracksSection, TrajectorySection,
};

/// A campaign, as its file states it and with every default filled in.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// The radar log; absent where `[[track]]` tables give several.
    #[serde(default, skip_serializing_if = "RadarSection::is_absent")]
    pub radar: RadarSection,
    /// Raw GNSS logs to compute the trajectory from.
    #[serde(default)]
    pub gnss: Option<GnssSection>,
    /// The trajectory.
    #[serde(default)]
    pub trajectory: TrajectorySection,
    /// From raw traces to clean spectra.
    #[serde(default)]
    pub preprocess: PreprocessSection,
    /// Several flights that make one image.
    #[serde(default, rename = "track", skip_serializing_if = "Vec::is_empty")]
    pub track: Vec<TrackSection>,
    /// How they become one.
    #[serde(default)]
    pub tracks: TracksSection,
    /// The image.
    #[serde(default)]
    pub image: ImageSection,
    /// Media below the surface of the ground; without them all is air.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<GroundSection>,
    /// Corrections of the positions from the echoes.
    #[serde(default)]
    pub autofocus: AutofocusOptions,
    /// What counts as a target.
    #[serde(default)]
    pub measure: MeasureSection,
    /// Treatment of a run that its own evidence contradicts.
    #[serde(default)]
    pub checks: ChecksSection,
    /// Files for other programs.
    #[serde(default)]
    pub products: ProductsSection,
}

impl Campaign {
    /// Reads a campaign from the text of its file; paths stay as written.
    ///
    /// # Errors
    /// Unknown keys, values of the wrong form, impossible values.
    ///
    /// ```
    /// let campaign = acerra_chain::campaign::Campaign::parse(
    ///     "[radar]\nfile = 'flight.npz'\n[image]\nx_m = [0, 1]\ny_m = [-1, 1]\n",
    /// )?;
    /// assert_eq!(campaign.image.frequencies, 341);
    /// let error = acerra_chain::campaign::Campaign::parse("[radar]\nfiel = 'flight.npz'\n").unwrap_err();
    /// assert!(error.to_string().starts_with("line 2, column 1: unknown field `fiel`"));
    /// # Ok::<(), acerra_chain::campaign::CampaignError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let mut campaign: Self = acerra_settings::parse(text)?;
        campaign.check()?;
        let is_placed = campaign.each_track().first().is_some_and(|one| {
            // Heights by the radar count from the ground.
            one.trajectory.origin_deg_m.is_some() || one.trajectory.height == HeightSource::Radar
        });
        if campaign.image.z_m.is_none() && campaign.image.terrain.is_none() && is_placed {
            campaign.image.z_m = Some(Heights::Plane(0.0));
        }
        Ok(campaign)
    }

    /// The campaign with the values found from the data in place of open ones: the image's extent and height,
    /// traces and their weight, gate and delay.
    #[must_use]
    pub fn with_found(mut self, prepared: &Prepared) -> Self {
        let grid = &prepared.scene.pixels.grid;
        let image = &mut self.image;
        image.x_m = image.x_m.or(Some([grid.x0_m, grid.x_m(grid.nx - 1)]));
        image.y_m = image.y_m.or(Some([grid.y0_m, grid.y_m(grid.ny - 1)]));
        if image.terrain.is_none() {
            image.z_m = image.z_m.or(Some(Heights::Plane(grid.z_m)));
        }
        if image.weight == Weight::Auto {
            image.weight = if prepared.aligned.is_often_at_rest {
                Weight::Path
            } else {
                Weight::Trace
            };
        }
        if let (Some(ground), Some(found)) = (&mut self.ground, &prepared.permittivity)
            && ground.relative_permittivity == Some(Permittivity::Auto)
        {
            ground.relative_permittivity = Some(Permittivity::Relative(found.value));
        }
        if let [first] = prepared.tracks.as_slice() {
            self.radar.settle(first);
            self.trajectory.settle(first);
            self.preprocess.settle(first);
        }
        for (section, track) in self.track.iter_mut().zip(&prepared.tracks) {
            section.radar.settle(track);
            section.trajectory.settle(track);
            if let Some(preprocess) = &mut section.preprocess {
                preprocess.settle(track);
            }
        }
        self
    }

    /// Makes the paths of the campaign relative to `folder`, the folder of its file.
    #[must_use]
    pub fn resolved_in(mut self, folder: &Path) -> Self {
        let resolve = |path: &mut PathBuf| *path = folder.join(&*path);
        let resolve_gnss = |gnss: &mut GnssSection| {
            for files in [&mut gnss.rover, &mut gnss.base, &mut gnss.navigation] {
                files.0.iter_mut().for_each(resolve);
            }
            gnss.config.as_mut().map(resolve);
        };
        self.radar.files_mut().for_each(resolve);
        self.trajectory.files_mut().for_each(resolve);
        self.image.terrain.as_mut().map(resolve);
        self.image.geoid.as_mut().map(resolve);
        self.measure.survey.as_mut().map(resolve);
        self.gnss.as_mut().map(resolve_gnss);
        for track in &mut self.track {
            track.radar.files_mut().for_each(resolve);
            track.trajectory.files_mut().for_each(resolve);
            track.gnss.as_mut().map(resolve_gnss);
        }
        self
    }

    /// A campaign for each track, with that track alone.
    #[must_use]
    pub fn each_track(&self) -> Vec<Self> {
        if self.track.is_empty() {
            return vec![self.clone()];
        }
        let one = |track: &TrackSection| Self {
            radar: track.radar.clone(),
            gnss: track.gnss.clone(),
            trajectory: track.trajectory.clone(),
            preprocess: track
                .preprocess
                .clone()
                .unwrap_or_else(|| self.preprocess.clone()),
            track: Vec::new(),
            ..self.clone()
        };
        self.track.iter().map(one).collect()
    }

    /// The files that hold or make the positions.
    pub fn position_files(&self) -> impl Iterator<Item = &Path> {
        let gnss = self.gnss.iter().flat_map(|gnss| {
            [&gnss.rover, &gnss.base, &gnss.navigation]
                .into_iter()
                .flat_map(|files| files.0.iter().map(PathBuf::as_path))
                .chain(gnss.config.as_deref())
        });
        let trajectory = [&self.trajectory.file, &self.trajectory.attitude_file];
        trajectory
            .into_iter()
            .flat_map(|file| file.as_deref())
            .chain(gnss)
    }

    /// The background in force: the stated one, else the mean, with the echo of the surface where the image lies below
    /// it.
    #[must_use]
    pub fn background(&self) -> Background {
        let default = match self.ground {
            Some(_) => Background::Surface,
            None => Background::default(),
        };
        self.preprocess.background.unwrap_or(default)
    }

    /// The gate in force: the stated one; by default the whole trace where the image lies below the ground, as echoes
    /// are the later there the slower the soil is.
    #[must_use]
    pub fn gate(&self) -> Gate {
        match (self.preprocess.gate_ns, &self.ground) {
            (Gate::Auto, Some(_)) => Gate::None,
            (stated, _) => stated,
        }
    }

    /// The zero-timing in force: the stated one, else the calibrated delay, else the paper's.
    #[must_use]
    pub fn zero_timing(&self) -> ZeroTiming {
        self.preprocess
            .zero_timing
            .unwrap_or(match self.radar.delay_ns {
                Some(Delay::Nanoseconds(_)) => ZeroTiming::None,
                // Until the delay is found, the surface echo gives it.
                Some(Delay::Auto) | None => ZeroTiming::FirstTrace,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "[radar]\nfile = 'a.mrm'\n[trajectory]\nfile = 'a.pos'\n\
                        [image]\nx_m = [0, 18]\ny_m = [-9, 9]\n";

    fn message(text: &str) -> String {
        Campaign::parse(text).unwrap_err().to_string()
    }

    #[test]
    fn defaults_are_the_papers() {
        let campaign = Campaign::parse(GOOD).unwrap();
        assert_eq!(campaign.zero_timing(), ZeroTiming::FirstTrace);
        assert_eq!(campaign.preprocess.gate_ns.about_ns(), Some([-6.0, 24.0]));
        assert_eq!(campaign.image.band_ghz, [3.1, 4.8]);
        assert_eq!(campaign.image.weight, Weight::Auto);
        assert!((campaign.image.light_speed_m_s - 299_792_458.0).abs() < f64::EPSILON);
    }

    #[test]
    fn gnss_logs_may_be_lists_of_files() {
        let gnss = |logs: &str| {
            let own = format!("[gnss]\n{logs}navigation = 'c.nav'\n");
            GOOD.replace("[trajectory]\nfile = 'a.pos'\n", &own)
        };
        let several = Campaign::parse(&gnss("rover = ['a.obs', 'b.obs']\nbase = 'c.obs'\n"))
            .unwrap()
            .resolved_in(Path::new("folder"));
        let files: Vec<&Path> = several.position_files().collect();
        let expected =
            ["a.obs", "b.obs", "c.obs", "c.nav"].map(|name| Path::new("folder").join(name));
        assert_eq!(files, expected);
        let written = toml::to_string(several.gnss.as_ref().unwrap()).unwrap();
        assert!(
            written.contains("rover = [\"folder/a.obs\", \"folder/b.obs\"]"),
            "{written}"
        );
        assert!(written.contains("base = \"folder/c.obs\""), "{written}");
        let found = message(&gnss("rover = []\nbase = 'c.obs'\n"));
        assert!(
            found.contains("rover") && found.contains("a file"),
            "{found}"
        );
    }

    #[test]
    fn a_calibrated_delay_replaces_zero_timing_unless_both_are_stated() {
        let delay = GOOD.replace("'a.mrm'\n", "'a.mrm'\ndelay_ns = 10\n");
        assert_eq!(
            Campaign::parse(&delay).unwrap().zero_timing(),
            ZeroTiming::None
        );
        let auto = GOOD.replace("'a.mrm'\n", "'a.mrm'\ndelay_ns = 'auto'\n");
        assert_eq!(
            Campaign::parse(&auto).unwrap().radar.delay_ns,
            Some(Delay::Auto)
        );
        let stated = format!("{auto}[preprocess]\nzero_timing = 'first-trace'\n");
        assert!(message(&stated).contains("exclude each other"));
        let both = format!("{delay}[preprocess]\nzero_timing = 'first-trace'\n");
        assert_eq!(
            Campaign::parse(&both).unwrap().zero_timing(),
            ZeroTiming::FirstTrace
        );
    }

    #[test]
    fn unknown_keys_and_wrong_forms_are_placed() {
        assert!(
            message(&GOOD.replace("x_m", "x_n")).starts_with("line 6, column 1: unknown field")
        );
        assert!(message("[radar\n").starts_with("line 1, column"));
        assert!(message("[image]\nx_m = 3\n").starts_with("line 2, column 7"));
        let select = GOOD.replace("'a.mrm'\n", "'a.mrm'\nselect = 'mowing'\n");
        assert!(
            message(&select).contains("\"moving\""),
            "{}",
            message(&select)
        );
    }

    #[test]
    fn impossible_values_are_refused_with_what_is_possible() {
        for (from, to, key) in [
            ("x_m = [0, 18]", "x_m = [18, 0]", "[image] x_m"),
            ("x_m = [0, 18]", "x_m = [0, nan]", "[image] x_m"),
            ("[image]\n", "[image]\npixel_m = 0\n", "[image] pixel_m"),
            (
                "[image]\n",
                "[image]\nband_ghz = [4.8, 3.1]\n",
                "[image] band_ghz",
            ),
            ("[image]\n", "[image]\naccuracy = 0\n", "[image] accuracy"),
            (
                "[image]\n",
                "[image]\nfrequencies = 0\n",
                "[image] frequencies",
            ),
            ("[image]\n", "[image]\nmemory_gb = 0\n", "[image] memory_gb"),
            (
                "[image]\n",
                "[image]\npixel_z_m = 0.1\n",
                "[image] pixel_z_m",
            ),
            (
                "[image]\n",
                "[image]\ngeoid_height_m = 3\n",
                "[image] terrain",
            ),
            (
                "[image]\n",
                "[image]\nlight_speed_m_s = 0\n",
                "[image] light_speed_m_s",
            ),
            (
                "'a.pos'\n",
                "'a.pos'\ngimbal_source = 'MNT[0]'\n",
                "[trajectory] gimbal_source",
            ),
            (
                "[trajectory]\nfile = 'a.pos'\n[image]\n",
                "[image]\nantenna_axis = 'gimbal'\n",
                "[trajectory] file",
            ),
            (
                "[trajectory]\nfile = 'a.pos'\n",
                "[trajectory]\nattitude_file = 'a.bin'\n",
                "[trajectory] attitude_file",
            ),
            (
                "[trajectory]\nfile = 'a.pos'\n",
                "[gnss]\nrover = 'a.obs'\nbase = 'b.obs'\n[trajectory]\nsource = 'ekf'\n",
                "[trajectory] source",
            ),
            (
                "[trajectory]\nfile = 'a.pos'\n",
                "[gnss]\nrover = 'a.obs'\nbase = 'b.obs'\n[trajectory]\nattitude_source = 'ATT'\n",
                "[trajectory] attitude_source",
            ),
            (
                "'a.pos'\n",
                "'a.pos'\nmax_gap_s = -1\n",
                "[trajectory] max_gap_s",
            ),
        ] {
            let found = message(&GOOD.replace(from, to));
            assert!(found.starts_with(key), "{found}");
            assert!(found.contains("expected"), "{found}");
        }
    }

    #[test]
    fn a_volume_has_its_ground_nearest_to_zero_unless_told() {
        for (keys, ground_z_m) in [
            ("z_m = [-0.5, 1]\n", 0.0),
            ("z_m = [2, 3]\n", 2.0),
            ("z_m = [2, 3]\nground_z_m = 2.5\n", 2.5),
            ("z_m = 4\n", 4.0),
        ] {
            let campaign = Campaign::parse(&format!("{GOOD}{keys}")).unwrap();
            assert!((campaign.image.ground_z_m() - ground_z_m).abs() < 1e-12);
        }
    }

    #[test]
    fn several_tracks_stand_in_for_one() {
        let image = "[image]\nx_m = [0, 18]\ny_m = [-9, 9]\n";
        let tracks = "[[track]]\ndelay_ns = 0.2\n[track.radar]\nfile = 'a.mrm'\n\
                      [track.trajectory]\nfile = 'a.pos'\n[[track]]\nname = 'west'\n\
                      [track.radar]\nfile = 'b.mrm'\n[track.preprocess]\ngate_ns = 'none'\n";
        let campaign = Campaign::parse(&format!("{tracks}{image}")).unwrap();
        let each = campaign.resolved_in(Path::new("/d")).each_track();
        assert_eq!(each[1].radar.file, Path::new("/d/b.mrm"));
        assert_eq!(
            each[0].trajectory.file.as_deref(),
            Some(Path::new("/d/a.pos"))
        );
        assert_eq!(each[0].preprocess.gate_ns, Gate::Auto);
        assert_eq!(each[1].preprocess.gate_ns, Gate::None);
        for (text, part) in [
            (image.to_owned(), "a radar log, here or in [[track]]"),
            (format!("{GOOD}{tracks}"), "[radar] and [[track]] exclude"),
            (
                format!("{tracks}[trajectory]\nfile = 'a.pos'\n{image}"),
                "exclude",
            ),
            (
                format!("{tracks}[trajectory]\nlever_arm_m = [0.1, 0, -0.2]\n{image}"),
                "each track has its own",
            ),
            (
                format!("{tracks}{image}looks = 3\n"),
                "looks cut a single track",
            ),
            (
                format!("{tracks}[tracks]\nwindow_ns = 0\n{image}"),
                "[tracks] window_ns",
            ),
            (format!("{GOOD}looks = 0\n"), "[image] looks"),
            (
                format!("{GOOD}max_incidence_deg = 95\n"),
                "[image] max_incidence_deg",
            ),
            (
                format!("{GOOD}incidence_taper_deg = 0\n"),
                "[image] incidence_taper_deg",
            ),
            (
                format!("{GOOD}antenna_cosine_power = -1\n"),
                "[image] antenna_cosine_power",
            ),
            (
                format!("{GOOD}max_incidence_deg = 40\nterrain = 'dem.tif'\n"),
                "level plane",
            ),
            (format!("{GOOD}look_overlap = 1\n"), "[image] look_overlap"),
            (
                format!("{GOOD}looks = 2\nmethod = 'tsvd'\n"),
                "[image] looks and [image] method exclude",
            ),
            (
                format!("{GOOD}z_m = [0, 1]\nmethod = 'clean'\n"),
                "points are put back on one plane",
            ),
            (
                format!("{tracks}[tracks]\nsum = 'incoherent'\n{image}method = 'cgls'\n"),
                "all tracks explain one scene",
            ),
            (format!("{GOOD}method = 'svd'\n"), "line 8, column 10"),
            (
                format!("{GOOD}[image.inversion]\nthreshold_db = 3\n"),
                "[image.inversion] threshold_db",
            ),
            (
                format!("{GOOD}[image.inversion]\nclean_gain = 0\n"),
                "[image.inversion] clean_gain",
            ),
            (
                format!("{GOOD}looks = 2\nz_m = [0, 1]\n"),
                "looks are planes",
            ),
        ] {
            assert!(message(&text).contains(part), "{}", message(&text));
        }
    }

    #[test]
    fn paths_are_relative_to_the_file() {
        let campaign = Campaign::parse(GOOD)
            .unwrap()
            .resolved_in(Path::new("/data/may"));
        assert_eq!(campaign.radar.file, Path::new("/data/may/a.mrm"));
        assert_eq!(
            campaign.trajectory.file.unwrap(),
            Path::new("/data/may/a.pos")
        );
    }
}
