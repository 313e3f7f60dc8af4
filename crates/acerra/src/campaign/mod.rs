//! The campaign file: which logs, how they fit together, which image is wanted.

mod choices;
mod error;
mod sections;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use choices::{Background, Gate, Heights, Select, TimeOffset, ZeroTiming};
pub use error::CampaignError;
pub use sections::{
    Files, GnssSection, ImageSection, MeasureSection, PreprocessSection, RadarSection,
    TrajectorySection, Unfixed, Weight,
};

/// A campaign, as its file states it and with every default filled in.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// The radar log.
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
    /// The image.
    pub image: ImageSection,
    /// What counts as a target.
    #[serde(default)]
    pub measure: MeasureSection,
}

impl Campaign {
    /// Reads a campaign from the text of its file; paths are left as they stand there.
    ///
    /// # Errors
    /// Unknown keys, values of the wrong form, impossible values.
    ///
    /// ```
    /// let campaign = acerra::campaign::Campaign::parse(
    ///     "[radar]\nfile = 'flight.npz'\n[image]\nx_m = [0, 1]\ny_m = [-1, 1]\n",
    /// )?;
    /// assert_eq!(campaign.image.frequencies, 341);
    /// let error = acerra::campaign::Campaign::parse("[radar]\nfiel = 'flight.npz'\n").unwrap_err();
    /// assert!(error.to_string().starts_with("line 2, column 1: unknown field `fiel`"));
    /// # Ok::<(), acerra::campaign::CampaignError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let mut campaign: Self = toml::from_str(text).map_err(|error| {
            let (line, column) = line_and_column(text, error.span());
            CampaignError::Syntax {
                line,
                column,
                message: error.message().to_owned(),
            }
        })?;
        campaign.check()?;
        if campaign.image.z_m.is_none() && campaign.image.terrain.is_none() {
            campaign.image.z_m = Some(Heights::Plane(0.0));
        }
        Ok(campaign)
    }

    /// Makes the paths of the campaign relative to `folder`, the folder of its file.
    #[must_use]
    pub fn resolved_in(mut self, folder: &Path) -> Self {
        let resolve = |path: &mut PathBuf| *path = folder.join(&*path);
        resolve(&mut self.radar.file);
        self.trajectory.file.as_mut().map(resolve);
        self.image.terrain.as_mut().map(resolve);
        if let Some(gnss) = &mut self.gnss {
            resolve(&mut gnss.rover);
            resolve(&mut gnss.base);
            gnss.navigation.0.iter_mut().for_each(resolve);
            gnss.config.as_mut().map(resolve);
        }
        self
    }

    /// The files that hold or make the positions.
    pub fn position_files(&self) -> impl Iterator<Item = &Path> {
        let gnss = self.gnss.iter().flat_map(|gnss| {
            [gnss.rover.as_path(), gnss.base.as_path()]
                .into_iter()
                .chain(gnss.navigation.0.iter().map(PathBuf::as_path))
                .chain(gnss.config.as_deref())
        });
        self.trajectory.file.as_deref().into_iter().chain(gnss)
    }

    /// The zero-timing in force: the stated one, else the calibrated delay, else the paper's.
    #[must_use]
    pub fn zero_timing(&self) -> ZeroTiming {
        self.preprocess
            .zero_timing
            .unwrap_or(match self.radar.delay_ns {
                Some(_) => ZeroTiming::None,
                None => ZeroTiming::FirstTrace,
            })
    }

    fn check(&self) -> Result<(), CampaignError> {
        let require = |ok: bool, table, key, expected, found: &dyn std::fmt::Debug| {
            if ok {
                Ok(())
            } else {
                Err(CampaignError::Value {
                    table,
                    key,
                    expected,
                    found: format!("{found:?}"),
                })
            }
        };
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());

        let radar = &self.radar;
        require(
            radar.delay_ns.is_none_or(f64::is_finite),
            "radar",
            "delay_ns",
            "a finite number",
            &radar.delay_ns,
        )?;
        let trajectory = &self.trajectory;
        require(
            finite(&trajectory.lever_arm_m) && trajectory.lever_arm_m.iter().all(|v| v.abs() < 1e3),
            "trajectory",
            "lever_arm_m",
            "three lengths below a kilometre",
            &trajectory.lever_arm_m,
        )?;
        require(
            trajectory
                .max_gap_s
                .is_none_or(|gap| gap.is_finite() && gap > 0.0),
            "trajectory",
            "max_gap_s",
            "a time above 0",
            &trajectory.max_gap_s,
        )?;
        require(
            trajectory
                .origin_deg_m
                .is_none_or(|[latitude, longitude, height]| {
                    latitude.abs() <= 90.0 && longitude.abs() <= 360.0 && height.abs() < 1e6
                }),
            "trajectory",
            "origin_deg_m",
            "[latitude, longitude, height]: degrees and metres",
            &trajectory.origin_deg_m,
        )?;

        if let Some(gnss) = &self.gnss {
            if self.trajectory.file.is_some() {
                return Err(CampaignError::Conflict {
                    first: "[gnss]",
                    second: "[trajectory] file",
                    reason: "both give the positions",
                });
            }
            if gnss.base_ecef_m.is_some() && gnss.base_deg_m.is_some() {
                return Err(CampaignError::Conflict {
                    first: "[gnss] base_ecef_m",
                    second: "[gnss] base_deg_m",
                    reason: "both give the base's place",
                });
            }
            let places = [gnss.base_ecef_m, gnss.base_deg_m];
            let ok = places.iter().flatten().all(|place| finite(place));
            require(ok, "gnss", "base_ecef_m", "finite coordinates", &places)?;
        }

        let image = &self.image;
        let [low, high] = image.band_ghz;
        let band_ok = finite(&image.band_ghz) && 0.0 < low && low <= high && high < 1e3;
        require(
            band_ok,
            "image",
            "band_ghz",
            "0 < low <= high < 1000",
            &image.band_ghz,
        )?;
        require(
            (1..=1_000_000).contains(&image.frequencies) && (image.frequencies > 1 || low == high),
            "image",
            "frequencies",
            "at least 2 (1 for a band of a single frequency) and at most a million",
            &image.frequencies,
        )?;
        for (key, range) in [("x_m", image.x_m), ("y_m", image.y_m)] {
            let ok = finite(&range) && range[0] <= range[1];
            require(ok, "image", key, "[from, to] with from <= to", &range)?;
        }
        if image.terrain.is_some() {
            if image.z_m.is_some() {
                return Err(CampaignError::Conflict {
                    first: "[image] terrain",
                    second: "[image] z_m",
                    reason: "both give the heights of the image",
                });
            }
        } else if image.terrain_crs.is_some() || image.geoid_height_m != 0.0 {
            return Err(CampaignError::Value {
                table: "image",
                key: "terrain",
                expected: "a file, as terrain_crs or geoid_height_m is given",
                found: "none".to_owned(),
            });
        }
        require(
            image.geoid_height_m.is_finite(),
            "image",
            "geoid_height_m",
            "a finite number",
            &image.geoid_height_m,
        )?;
        require(
            image.pixel_z_m.is_none_or(|s| s.is_finite() && s > 0.0)
                && (image.pixel_z_m.is_none() || matches!(image.z_m, Some(Heights::Range(_)))),
            "image",
            "pixel_z_m",
            "a length above 0, with z_m = [from, to]",
            &image.pixel_z_m,
        )?;
        let pixel_ok = image.pixel_m.is_finite() && image.pixel_m > 0.0;
        require(
            pixel_ok,
            "image",
            "pixel_m",
            "a length above 0",
            &image.pixel_m,
        )?;
        let accuracy_ok = image.accuracy >= 1e-12 && image.accuracy < 1.0;
        require(
            accuracy_ok,
            "image",
            "accuracy",
            "1e-12 <= accuracy < 1",
            &image.accuracy,
        )?;
        require(
            image.light_speed_m_s > 1e6 && image.light_speed_m_s <= 3e8,
            "image",
            "light_speed_m_s",
            "above 1e6 and at most 3e8",
            &image.light_speed_m_s,
        )?;
        require(
            self.measure.threshold_db.is_finite() && self.measure.threshold_db < 0.0,
            "measure",
            "threshold_db",
            "a level below 0 dB",
            &self.measure.threshold_db,
        )?;
        Ok(())
    }
}

/// Line and column, counted from 1, of the start of `span`.
pub(crate) fn line_and_column(text: &str, span: Option<std::ops::Range<usize>>) -> (usize, usize) {
    let at = span.map_or(0, |span| span.start).min(text.len());
    let before = &text.as_bytes()[..at];
    let line_start = before
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |i| i + 1);
    (
        1 + before.iter().filter(|b| **b == b'\n').count(),
        1 + at - line_start,
    )
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
        assert_eq!(campaign.preprocess.gate_ns, Gate::About([-6.0, 24.0]));
        assert_eq!(campaign.image.band_ghz, [3.1, 4.8]);
        assert_eq!(campaign.image.weight, Weight::Trace);
        assert!((campaign.image.light_speed_m_s - 299_792_458.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_calibrated_delay_replaces_zero_timing_unless_both_are_stated() {
        let delay = GOOD.replace("'a.mrm'\n", "'a.mrm'\ndelay_ns = 10\n");
        assert_eq!(
            Campaign::parse(&delay).unwrap().zero_timing(),
            ZeroTiming::None
        );
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
