//! The whole chain, stage after stage.

use std::ops::Range;
use std::path::Path;

use acerra_imaging::metrics::Measurement;
use acerra_radar::Spectrum;
use anyhow::{Context, bail};

use super::align::{Aligned, align};
use super::clean::{Cleaned, clean};
use super::elevation;
use super::focus::{Echoes, Focused, focus};
use super::ground::{Ground, Site};
use super::measure::measure;
use super::offset;
use super::position::{Positions, position};
use super::progress::Progress;
use super::read::{RadarContent, RadarData, read_radar};
use super::space::check_space;
use super::tracks::{Track, TrackCalibration, calibrate, in_one_frame, merge, name_of_track};
use super::warnings::Warnings;
use crate::campaign::{Campaign, TimeOffset};
use crate::inputs::InputFile;
use crate::stages::Stages;
use crate::staging::Staging;

/// Everything that a run found, stage by stage.
#[derive(Debug)]
pub struct Outcome {
    /// Name of the campaign, for titles.
    pub name: String,
    /// The campaign, every default filled in.
    pub campaign: Campaign,
    /// The files that were read.
    pub inputs: Vec<InputFile>,
    /// The radar log; of several tracks only what they share.
    pub radar: RadarData,
    /// The positions; of several tracks the first's.
    pub positions: Positions,
    /// The selected traces and their places, of all tracks.
    pub aligned: Aligned,
    /// Their spectra.
    pub cleaned: Cleaned,
    /// The tracks, where the campaign has several.
    pub tracks: Vec<Track>,
    /// Which of the traces are which track's.
    pub parts: Vec<Range<usize>>,
    /// Traces in all logs.
    pub traces_in_log: usize,
    /// The image.
    pub focused: Focused,
    /// What it shows.
    pub measured: Measurement,
    /// What there is to say beside the result.
    pub warnings: Vec<String>,
}

/// Runs the chain on a campaign whose paths are resolved; looks and volumes go to `staging`.
///
/// # Errors
/// The first stage that fails; its message names the file, the place and what was expected.
pub fn run(
    name: &str,
    campaign: &Campaign,
    campaign_file: Option<&Path>,
    staging: &Staging,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> anyhow::Result<Outcome> {
    // Pixels that cannot be held are refused before anything is read.
    check_space(campaign, &staging.folder())?;
    let each = campaign.each_track();
    let mut warnings = Warnings::default();
    let (inputs, radars) = stages.run("read", || {
        let mut inputs = Vec::new();
        let logs = each.iter().flat_map(|one| {
            [one.radar.file.as_path()]
                .into_iter()
                .chain(one.position_files())
        });
        let files = campaign_file
            .into_iter()
            .chain(logs)
            .chain(campaign.image.terrain.as_deref());
        for path in files {
            let input = InputFile::record(path).with_context(|| format!("{}", path.display()))?;
            if !inputs.contains(&input) {
                inputs.push(input);
            }
        }
        let radars = each
            .iter()
            .map(|one| read_radar(&one.radar.file, &mut warnings))
            .collect::<anyhow::Result<Vec<_>>>()?;
        anyhow::Ok((inputs, radars))
    })?;
    let (positions, ground) = stages.run("position", || {
        let mut positions = each
            .iter()
            .zip(&radars)
            .map(|(one, radar)| position(one, radar, &mut warnings))
            .collect::<anyhow::Result<Vec<_>>>()?;
        in_one_frame(&mut positions)?;
        let first = each.first().unwrap_or(campaign);
        let all: Vec<&Positions> = positions.iter().collect();
        let ground = Ground::find(first, &all, &mut warnings)?;
        anyhow::Ok((positions, ground))
    })?;
    let aligned = stages.run("align", || {
        each.iter()
            .zip(radars.iter().zip(&positions))
            .map(|(one, (radar, positions))| {
                let site = Site {
                    positions,
                    ground: &ground,
                };
                align_clocks(one, radar, site, &mut warnings, progress)
            })
            .collect::<anyhow::Result<Vec<_>>>()
    })?;
    let cleaned = stages.run("clean", || {
        each.iter()
            .zip(radars.iter().zip(&aligned))
            .map(|(one, (radar, aligned))| clean(one, &radar.content, aligned, &mut warnings))
            .collect::<anyhow::Result<Vec<_>>>()
    })?;
    let mut tracks: Vec<Track> = radars
        .into_iter()
        .zip(positions)
        .zip(aligned.into_iter().zip(cleaned))
        .enumerate()
        .map(|(k, ((radar, positions), (aligned, cleaned)))| Track {
            name: campaign
                .track
                .get(k)
                .map_or_else(String::new, |track| name_of_track(track, k)),
            radar,
            positions,
            aligned,
            cleaned,
            calibration: TrackCalibration::default(),
        })
        .collect();
    let traces_in_log = tracks.iter().map(|t| t.radar.content.time_s().len()).sum();
    let (merged, parts, focused) = stages.run("focus", || {
        let (merged, parts) = if campaign.track.is_empty() {
            (None, Vec::new())
        } else {
            calibrate(campaign, &mut tracks, &ground, &mut warnings)?;
            let (aligned, spectrum, parts) = merge(&tracks)?;
            (Some((aligned, spectrum)), parts)
        };
        let (aligned, spectrum) = match (&merged, tracks.first()) {
            (Some((aligned, spectrum)), _) => (aligned, spectrum),
            (None, Some(track)) => (&track.aligned, &track.cleaned.spectrum),
            (None, None) => bail!("no track"),
        };
        let echoes = Echoes {
            spectrum,
            aligned,
            parts: &parts,
        };
        let [low, high] = campaign.image.band_ghz;
        let wavelength_m = campaign.image.light_speed_m_s / (0.5e9 * (low + high));
        elevation::check(&ground, &aligned.position_m, wavelength_m, &mut warnings);
        let focused = focus(campaign, echoes, ground, staging, progress)?;
        anyhow::Ok((merged, parts, focused))
    })?;
    let whole = match merged {
        Some((aligned, spectrum)) => joined(&tracks, aligned, spectrum),
        None => tracks.pop(),
    };
    let Some(whole) = whole else {
        bail!("no track");
    };
    let measured = stages.run("measure", || {
        measure(campaign, &focused, &whole.cleaned.spectrum, &whole.aligned)
    })?;
    Ok(Outcome {
        name: name.to_owned(),
        campaign: campaign.clone(),
        inputs,
        radar: whole.radar,
        positions: whole.positions,
        aligned: whole.aligned,
        cleaned: whole.cleaned,
        tracks,
        parts,
        traces_in_log,
        focused,
        measured,
        warnings: warnings.said().to_vec(),
    })
}

/// Several tracks as one.
fn joined(tracks: &[Track], aligned: Aligned, spectrum: Spectrum) -> Option<Track> {
    let first = tracks.first()?;
    let nothing = Spectrum {
        frequency_hz: spectrum.frequency_hz.clone(),
        values: Vec::new(),
        time_s: Vec::new(),
    };
    Some(Track {
        name: String::new(),
        radar: RadarData {
            content: RadarContent::Spectrum(nothing),
            position_m: None,
            unit: first.radar.unit,
            summary: format!(
                "{} tracks; the first: {}",
                tracks.len(),
                first.radar.summary
            ),
        },
        positions: first.positions.clone(),
        aligned,
        cleaned: Cleaned {
            spectrum,
            traces: None,
        },
        calibration: TrackCalibration::default(),
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
