//! The whole chain, stage after stage.

use std::path::Path;

use acerra_imaging::metrics::Measurement;
use anyhow::{Context, bail};

use super::align::{Aligned, align};
use super::clean::{Cleaned, clean};
use super::focus::{Focused, focus};
use super::ground::{Ground, Site, grid_of};
use super::measure::measure;
use super::offset;
use super::position::{Positions, position};
use super::progress::Progress;
use super::read::{RadarContent, RadarData, read_radar};
use super::warnings::Warnings;
use crate::campaign::{Campaign, TimeOffset};
use crate::products::inputs::InputFile;
use crate::products::stages::Stages;

/// Everything that a run found, stage by stage.
#[derive(Debug)]
pub struct Outcome {
    /// Name of the campaign, for titles.
    pub name: String,
    /// The campaign, every default filled in.
    pub campaign: Campaign,
    /// The files that were read.
    pub inputs: Vec<InputFile>,
    /// The radar log.
    pub radar: RadarData,
    /// The positions.
    pub positions: Positions,
    /// The selected traces and their places.
    pub aligned: Aligned,
    /// Their spectra.
    pub cleaned: Cleaned,
    /// The image.
    pub focused: Focused,
    /// What it shows.
    pub measured: Measurement,
    /// What there is to say beside the result.
    pub warnings: Vec<String>,
}

/// Runs the chain on a campaign whose paths are resolved.
///
/// # Errors
/// The first stage that fails; its message names the file, the place and what was expected.
pub fn run(
    name: &str,
    campaign: &Campaign,
    campaign_file: Option<&Path>,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> anyhow::Result<Outcome> {
    // A grid that cannot be held is refused before anything is read.
    grid_of(campaign)?;
    let mut warnings = Warnings::default();
    let (inputs, radar) = stages.run("read", || {
        let mut inputs = Vec::new();
        let files = campaign_file
            .into_iter()
            .chain([campaign.radar.file.as_path()])
            .chain(campaign.position_files())
            .chain(campaign.image.terrain.as_deref());
        for path in files {
            let input = InputFile::record(path).with_context(|| format!("{}", path.display()))?;
            inputs.push(input);
        }
        let radar = read_radar(&campaign.radar.file, &mut warnings)?;
        anyhow::Ok((inputs, radar))
    })?;
    let (positions, ground) = stages.run("position", || {
        let positions = position(campaign, &radar, &mut warnings)?;
        let ground = Ground::find(campaign, &[&positions], &mut warnings)?;
        anyhow::Ok((positions, ground))
    })?;
    let site = Site {
        positions: &positions,
        ground: &ground,
    };
    let aligned = stages.run("align", || {
        align_clocks(campaign, &radar, site, &mut warnings, progress)
    })?;
    let cleaned = stages.run("clean", || {
        clean(campaign, &radar.content, &aligned, &mut warnings)
    })?;
    let focused = stages.run("focus", || {
        focus(
            campaign,
            &cleaned.spectrum,
            &aligned,
            ground.clone(),
            progress,
        )
    })?;
    let measured = stages.run("measure", || {
        measure(campaign, &focused, &cleaned.spectrum, &aligned)
    })?;
    Ok(Outcome {
        name: name.to_owned(),
        campaign: campaign.clone(),
        inputs,
        radar,
        positions,
        aligned,
        cleaned,
        focused,
        measured,
        warnings: warnings.said().to_vec(),
    })
}

/// Aligns at the offset given, or at the one that the data tell.
fn align_clocks(
    campaign: &Campaign,
    radar: &RadarData,
    site: Site<'_>,
    warnings: &mut Warnings,
    progress: &dyn Progress,
) -> anyhow::Result<Aligned> {
    let time_s = radar.content.time_s();
    match (campaign.trajectory.time_offset_s, site.positions) {
        (TimeOffset::Seconds(offset), _) => align(campaign, time_s, site, offset, warnings),
        // Positions that came with the traces are on the traces' own clock.
        (TimeOffset::Auto, Positions::PerTrace(_)) => align(campaign, time_s, site, 0.0, warnings),
        (TimeOffset::Auto, Positions::Trajectory(_)) => {
            let RadarContent::Radargram(radargram) = &radar.content else {
                bail!(
                    "[trajectory] time_offset_s = \"auto\": expected a radargram, found spectra; \
                     state the offset"
                );
            };
            let motion = offset::by_motion(campaign, radargram, site.positions)?;
            // Said once, at the offset finally taken.
            let mut unsaid = Warnings::default();
            let first = align(campaign, time_s, site, motion.offset_s, &mut unsaid)?;
            let spectrum = clean(campaign, &radar.content, &first, &mut unsaid)?.spectrum;
            let search =
                offset::refine(campaign, time_s, site, motion, &first, &spectrum, progress)?;
            if !search.is_clear() {
                warnings.add(format!(
                    "the clock offset of {:.3} s is uncertain: motion correlates with {:.2} there \
                     and with {:.2} elsewhere; state time_offset_s if it is known",
                    search.time_offset_s, search.motion.correlation, search.motion.runner_up
                ));
            }
            let mut aligned = align(campaign, time_s, site, search.time_offset_s, warnings)?;
            aligned.search = Some(search);
            Ok(aligned)
        }
    }
}
