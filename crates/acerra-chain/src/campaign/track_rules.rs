//! Which keys of the tables of one track exclude or need each other.

use std::path::Path;

use acerra_settings::{Rule, check};

use super::error::exclude_if;
use super::sections::{GroundSection, ImageSection};
use super::values::{self, near, rule};
use super::{Campaign, CampaignError};
use crate::choices::{Delay, GroundSurface, ZeroTiming};

impl Campaign {
    /// The tables of a campaign of one track.
    pub(super) fn check_one(&self) -> Result<(), CampaignError> {
        exclude_if(
            self.radar.delay_ns == Some(Delay::Auto) && self.preprocess.zero_timing.is_some(),
            ["[radar] delay_ns = \"auto\"", "[preprocess] zero_timing"],
            "both find the fast time at which range is zero",
        )?;
        exclude_if(
            self.radar.delay_ns.is_some()
                && self.preprocess.zero_timing == Some(ZeroTiming::DirectWave),
            [
                "[radar] delay_ns",
                "[preprocess] zero_timing = \"direct-wave\"",
            ],
            "both state the fast time at which range is zero",
        )?;
        let offset_m = self.radar.antenna_offset_m;
        let is_near = |m: &[f64; 3]| m.iter().all(|m| m.abs() <= 100.0) && *m != [0.0; 3];
        let near = rule(
            "antenna_offset_m",
            offset_m.as_ref().is_none_or(is_near),
            "a vector from the receiver of up to 100 m, not 0",
            offset_m,
        );
        check("radar", &[near])?;
        values::preprocess(&self.preprocess)?;
        self.check_lines()?;
        values::trajectory(&self.trajectory)?;
        self.check_attitudes()?;
        if let Some(gnss) = &self.gnss {
            exclude_if(
                self.trajectory.file.is_some(),
                ["[gnss]", "[trajectory] file"],
                "both give the positions",
            )?;
            exclude_if(
                gnss.base_ecef_m.is_some() && gnss.base_deg_m.is_some(),
                ["[gnss] base_ecef_m", "[gnss] base_deg_m"],
                "both give the base's place",
            )?;
            values::gnss(gnss)?;
        }
        values::extent(&self.image)?;
        check_terrain(&self.image, self.ground.as_ref())?;
        values::pixels(&self.image)?;
        values::focus(&self.image)?;
        values::measure(&self.measure)?;
        Ok(())
    }

    /// Attitudes come from a log; an antenna on a gimbal needs attitudes, and a gimbal whose attitude no
    /// antenna uses is a mistake.
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
                "positions of [gnss] or of another file, to which the attitudes belong",
                "none",
            ),
            rule(
                "attitude_file",
                !has_attitude_file || trajectory.attitude_file != trajectory.file,
                "another file than that of the positions, whose own attitudes are used by default",
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
                "[image] antenna_axis = \"gimbal\" or \"gimbal-forward\" as well",
                self.image.antenna_axis.name(),
            ),
        ];
        Ok(check("trajectory", &rules)?)
    }

    /// The lines of one file or several.
    fn check_lines(&self) -> Result<(), CampaignError> {
        let radar = &self.radar;
        let is_grid = !radar.files.is_empty();
        exclude_if(
            is_grid && !radar.file.as_os_str().is_empty(),
            ["[radar] file", "[radar] files"],
            "both give the radar log",
        )?;
        exclude_if(
            is_grid && self.gnss.is_some(),
            ["[radar] files", "[gnss]"],
            "the traces of several files have no times: a [trajectory] file with a column trace places them",
        )?;
        exclude_if(
            is_grid
                && self.trajectory.file.is_some()
                && (radar.line_start_m.is_some() || !radar.lines.is_empty()),
            ["[radar] line_start_m or lines", "[trajectory] file"],
            "both place the traces of several files",
        )?;
        exclude_if(
            radar.line_start_m.is_some() && !radar.lines.is_empty(),
            ["[radar] line_start_m", "[radar] lines"],
            "both place the lines",
        )?;
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
                "the vector from each line of several files to the next, together with line_start_m and \
                 line_end_m",
                step_m,
            ),
            rule(
                "line_step_m",
                step_m.is_none_or(|step| step != [0.0; 3]),
                "the vector from each line to the next, which is not 0",
                step_m,
            ),
            Rule::new(
                "lines",
                is_grid || radar.lines.is_empty(),
                "[radar] files as well",
                "none",
            ),
        ];
        Ok(check("radar", &rules)?)
    }
}

/// Whether a file's name is a pattern for several files.
fn is_pattern(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.contains(['*', '?'])
}

fn check_terrain(
    image: &ImageSection,
    ground: Option<&GroundSection>,
) -> Result<(), CampaignError> {
    let is_below = ground.is_some_and(|ground| ground.surface == GroundSurface::Terrain);
    exclude_if(
        image.terrain.is_some() && image.z_m.is_some() && !is_below,
        ["[image] terrain", "[image] z_m"],
        "both give the heights of the image",
    )?;
    exclude_if(
        image.geoid.is_some() && image.geoid_height_m != 0.0,
        ["[image] geoid", "[image] geoid_height_m"],
        "both give the geoid's height",
    )?;
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
