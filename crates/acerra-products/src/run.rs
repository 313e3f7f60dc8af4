//! A run: from a campaign file to its products.

use std::path::{Path, PathBuf};

use acerra_chain::autofocus::AutofocusFailure;
use acerra_chain::campaign::{Campaign, Contradictions};
use acerra_chain::echoes::ImageError;
use acerra_chain::evidence::{Evidence, Verdict};
use acerra_chain::inputs::InputFile;
use acerra_chain::measure::MeasureError;
use acerra_chain::weigh::{weigh_autofocus, weigh_image, weigh_prepared, weigh_unchecked};
use acerra_chain::{
    Cancelled, ChainError, Control, Focused, ImageRequest, ImageSink, Journal, MemorySink, Prepared,
};
use acerra_geo::geoid::{GeoidError, GeoidGrid};
use acerra_radar::LoggedClock;
use anyhow::Context;

use crate::data;
use crate::deliver::deliver;
use crate::maps::{self, earth_frame};
use crate::names::{PRODUCTS, of_older_run};
use crate::outcome::Outcome;
use crate::space::check_space;
use crate::stack_npz::NpzSink;
use crate::staging::Staging;
use crate::surveyed::{SurveyError, compared, read_survey};

/// Reads a campaign file, runs it, and writes its products into `directory`. What the stages cost
/// and noticed is in the journal, also after a failure.
///
/// # Errors
/// Whatever cannot be done, with the file, the place and what was expected. The directory is then
/// left as it was.
pub fn run_campaign(
    file: &Path,
    directory: &Path,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<Outcome> {
    run_campaign_with(
        RunRequest {
            file,
            directory,
            autofocus: false,
        },
        journal,
        control,
    )
}

/// A run asked for.
#[derive(Clone, Copy, Debug)]
pub struct RunRequest<'a> {
    /// The campaign file.
    pub file: &'a Path,
    /// Where the products go.
    pub directory: &'a Path,
    /// Whether positions are corrected by autofocus, also where the campaign does not say so.
    pub autofocus: bool,
}

/// The same as [`run_campaign`], with what the command line adds to the campaign.
///
/// # Errors
/// As [`run_campaign`].
pub fn run_campaign_with(
    request: RunRequest<'_>,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<Outcome> {
    let RunRequest {
        file, directory, ..
    } = request;
    let at = || format!("{}", file.display());
    let text = std::fs::read_to_string(file).with_context(at)?;
    let mut campaign = Campaign::parse(&text).with_context(at)?;
    campaign.autofocus.enabled |= request.autofocus;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let campaign = NamedCampaign {
        name: name_of_campaign(file),
        campaign: campaign.resolved_in(folder),
    };
    inputs_are_kept(file, &campaign.campaign, directory)?;
    maps::check(&campaign.campaign).with_context(at)?;
    let mut staging = Staging::new(directory)?;
    staging.supersede(of_older_run(directory));
    // Pixels that cannot be held are refused before anything is read.
    check_space(&campaign.campaign, &staging.folder())?;
    let inputs = journal.stage("read", |_| record_inputs(file, &campaign.campaign))?;
    let mut sink = NpzSink::new(&staging.folder());
    let mut outcome = process(campaign, &mut sink, journal, control)?;
    outcome.inputs = inputs;
    name_sources(&mut outcome);
    if let Some(left_out) = data::left_out(&outcome) {
        journal.warnings.add(&left_out);
        outcome.warnings.push(left_out);
    }
    deliver(&outcome, staging, &mut journal.stages)?;
    Ok(outcome)
}

/// Why a run leaves no products.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A stage failed.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A stage failed while imaging.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The autofocus failed.
    #[error(transparent)]
    Autofocus(AutofocusFailure),
    /// A stage failed while measuring.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// The surveyed points cannot be read.
    #[error(transparent)]
    Survey(#[from] SurveyError),
    /// The grid of the geoid cannot be read.
    #[error("[image] geoid: {0}")]
    Geoid(#[from] GeoidError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// What the run found cannot be, were its settings right.
    #[error(
        "the evidence contradicts the settings:\n{found}\n([checks] contradictions = \"warn\" makes \
         the image all the same)"
    )]
    Contradicted {
        /// The contradictions, a line each.
        found: String,
    },
}

impl From<AutofocusFailure> for RunError {
    fn from(failure: AutofocusFailure) -> Self {
        match failure {
            AutofocusFailure::Cancelled(cancelled) => Self::Cancelled(cancelled),
            failure => Self::Autofocus(failure),
        }
    }
}

/// Fails on the first contradictions, unless the campaign wants them as warnings.
fn refuse_contradictions(campaign: &Campaign, evidence: &Evidence) -> Result<(), RunError> {
    let found: Vec<String> = evidence
        .with(Verdict::Contradicts)
        .map(|finding| format!("  {}: {}", finding.name, finding.explanation))
        .collect();
    if found.is_empty() || campaign.checks.contradictions == Contradictions::Warn {
        return Ok(());
    }
    Err(RunError::Contradicted {
        found: found.join("\n"),
    })
}

/// A campaign with resolved paths, and what it is called in titles.
#[derive(Clone, Debug)]
pub struct NamedCampaign {
    /// What it is called.
    pub name: String,
    /// The campaign.
    pub campaign: Campaign,
}

/// Prepares, images and measures a campaign; looks and volume slices go to the sink.
///
/// # Errors
/// The first stage that fails.
pub fn process(
    campaign: NamedCampaign,
    sink: &mut dyn ImageSink,
    journal: &mut Journal,
    control: &Control<'_>,
) -> Result<Outcome, RunError> {
    let NamedCampaign { name, campaign } = campaign;
    let surveyed = read_survey(campaign.measure.survey.as_deref())?;
    let geoid = campaign.image.geoid.as_ref();
    let geoid = geoid.map(GeoidGrid::read).transpose()?;
    let mut prepared = campaign.survey().prepare(journal, control)?;
    let campaign = campaign.with_found(&prepared);
    let request = campaign.image_request(prepared.scene.pixels.clone());
    journal
        .stage("clean", |_| weigh_prepared(&prepared, &request, control))?
        .into_iter()
        .for_each(|finding| journal.evidence.add(finding));
    refuse_contradictions(&campaign, &journal.evidence)?;
    let uncorrected = if campaign.autofocus.enabled {
        autofocus(&campaign, &mut prepared, &request, journal, control)?
    } else {
        None
    };
    let focused = journal.stage("focus", |warnings| {
        warnings.extend(prepared.doubts(&request));
        prepared.image(&request, sink, control)
    })?;
    let measured = journal.stage("measure", |_| {
        prepared.measure(&focused, &(&campaign.measure).into(), control)
    })?;
    journal
        .stage("measure", |_| weigh_image(&prepared, &focused, control))?
        .into_iter()
        .for_each(|finding| journal.evidence.add(finding));
    refuse_contradictions(&campaign, &journal.evidence)?;
    // A surveyed point beside its target checks what else nothing does.
    let unchecked = if surveyed.is_empty() {
        weigh_unchecked(&prepared, &journal.evidence)
    } else {
        Vec::new()
    };
    let without = geoid
        .as_ref()
        .and_then(|geoid| without_sea_level(geoid, &prepared));
    if let Some(reason) = without {
        journal.warnings.add(reason);
    }
    Ok(Outcome {
        name,
        campaign,
        inputs: Vec::new(),
        geoid,
        prepared,
        focused,
        uncorrected,
        surveyed: compared(&surveyed, &measured.targets),
        measured,
        evidence: journal.evidence.clone(),
        unchecked,
        warnings: journal.warnings.said().to_vec(),
    })
}

/// Corrects the positions where that is significant; the image without the correction where it is
/// made, of one plane alone.
fn autofocus(
    campaign: &Campaign,
    prepared: &mut Prepared,
    request: &ImageRequest,
    journal: &mut Journal,
    control: &Control<'_>,
) -> Result<Option<Focused>, RunError> {
    let options = (&campaign.autofocus).into();
    let applied = journal.stage("focus", |_| {
        let found = prepared.autofocus(&options, control)?;
        Ok::<bool, RunError>(found.is_applied())
    })?;
    if let Some(found) = &prepared.correction {
        weigh_autofocus(found)
            .into_iter()
            .for_each(|finding| journal.evidence.add(finding));
    }
    if !applied || request.pixels.volume.is_some() {
        return Ok(None);
    }
    let plain = ImageRequest {
        looks: None,
        ..request.clone()
    };
    let before = journal.stage("focus", |_| {
        prepared
            .as_stated()
            .image(&plain, &mut MemorySink::default(), control)
    })?;
    Ok(Some(before))
}

/// What keeps heights above the geoid from being told, where something does.
fn without_sea_level(geoid: &GeoidGrid, prepared: &Prepared) -> Option<String> {
    let Some(frame) = earth_frame(&prepared.first().positions) else {
        return Some(
            "[image] geoid: positions in a local frame have no place on the Earth, and no heights above \
             the sea"
                .to_owned(),
        );
    };
    let origin = frame.geodetic_from_enu([0.0; 3]);
    let [latitude_deg, longitude_deg] = [origin.latitude_deg(), origin.longitude_deg()];
    geoid.height_m(latitude_deg, longitude_deg).is_none().then(|| {
        format!(
            "[image] geoid: the grid does not cover {latitude_deg:.4}°, {longitude_deg:.4}°: no heights \
             above the sea are told"
        )
    })
}

/// Size and digest of every file that a campaign reads, each once.
fn record_inputs(file: &Path, campaign: &Campaign) -> anyhow::Result<Vec<InputFile>> {
    let mut inputs = Vec::new();
    for path in input_paths(file, campaign) {
        let input = InputFile::record(&path).with_context(|| format!("{}", path.display()))?;
        if !inputs.contains(&input) {
            inputs.push(input);
        }
    }
    Ok(inputs)
}

/// Says of the logs of autopilots which of their sources the positions are.
fn name_sources(outcome: &mut Outcome) {
    let each = outcome.campaign.each_track();
    for (one, track) in each.iter().zip(&outcome.prepared.tracks) {
        let Some(file) = &one.trajectory.file else {
            continue;
        };
        for input in outcome
            .inputs
            .iter_mut()
            .filter(|input| input.path == *file)
        {
            input.sources.clone_from(&track.log_sources);
        }
    }
}

/// The campaign file, every file that it names, and the clocks beside radar logs.
fn input_paths(file: &Path, campaign: &Campaign) -> Vec<PathBuf> {
    let each = campaign.each_track();
    let logs = each
        .iter()
        .flat_map(|one| std::iter::once(one.radar.file.as_path()).chain(one.position_files()));
    let clocks: Vec<PathBuf> = each
        .iter()
        .map(|one| LoggedClock::path_beside(&one.radar.file))
        .filter(|path| path.is_file())
        .collect();
    std::iter::once(file)
        .chain(logs)
        .chain(campaign.image.terrain.as_deref())
        .chain(campaign.image.geoid.as_deref())
        .chain(campaign.measure.survey.as_deref())
        .map(Path::to_owned)
        .chain(clocks)
        .collect()
}

/// Refuses a directory in which a product would take the place of an input.
fn inputs_are_kept(file: &Path, campaign: &Campaign, directory: &Path) -> anyhow::Result<()> {
    let inputs: Vec<PathBuf> = input_paths(file, campaign)
        .into_iter()
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    for name in PRODUCTS {
        let place = directory.join(name);
        let clash = place.canonicalize().is_ok_and(|p| inputs.contains(&p));
        anyhow::ensure!(
            !clash,
            "{}: is an input and would be overwritten; name another directory with -o",
            place.display()
        );
    }
    Ok(())
}

/// What a campaign is called: as its file, or as the folder of one that is called `campaign`.
fn name_of_campaign(file: &Path) -> String {
    let of = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = of(file.file_stem()).unwrap_or_default();
    let folder = std::path::absolute(file)
        .ok()
        .and_then(|file| of(file.parent()?.file_name()));
    match folder {
        Some(folder) if stem == "campaign" => folder,
        _ => stem,
    }
}
