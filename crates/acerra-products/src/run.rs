//! A run: from a campaign file to its products.

use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::inputs::InputFile;
use acerra_chain::{ChainError, Control, ImageSink, Journal};
use anyhow::Context;

use crate::deliver::deliver;
use crate::outcome::Outcome;
use crate::space::check_space;
use crate::stack_npz::NpzSink;
use crate::staging::Staging;

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
    let at = || format!("{}", file.display());
    let text = std::fs::read_to_string(file).with_context(at)?;
    let campaign = Campaign::parse(&text).with_context(at)?;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let campaign = NamedCampaign {
        name: name_of_campaign(file),
        campaign: campaign.resolved_in(folder),
    };
    let staging = Staging::new(directory)?;
    // Pixels that cannot be held are refused before anything is read.
    check_space(&campaign.campaign, staging.folder())?;
    let inputs = journal.stage("read", |_| record_inputs(file, &campaign.campaign))?;
    let mut sink = NpzSink::new(staging.folder());
    let mut outcome = process(campaign, &mut sink, journal, control)?;
    outcome.inputs = inputs;
    deliver(&outcome, staging, &mut journal.stages)?;
    Ok(outcome)
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
) -> Result<Outcome, ChainError> {
    let NamedCampaign { name, campaign } = campaign;
    let prepared = campaign.survey().prepare(journal, control)?;
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let focused = journal.stage("focus", |warnings| {
        warnings.extend(prepared.doubts(&request));
        prepared.image(&request, sink, control)
    })?;
    let measured = journal.stage("measure", |_| {
        prepared.measure(&focused, &(&campaign.measure).into())
    })?;
    Ok(Outcome {
        name,
        campaign,
        inputs: Vec::new(),
        prepared,
        focused,
        measured,
        warnings: journal.warnings.said().to_vec(),
    })
}

/// Size and digest of every file that a campaign reads, each once.
fn record_inputs(file: &Path, campaign: &Campaign) -> anyhow::Result<Vec<InputFile>> {
    let each = campaign.each_track();
    let logs = each
        .iter()
        .flat_map(|one| std::iter::once(one.radar.file.as_path()).chain(one.position_files()));
    let files = std::iter::once(file)
        .chain(logs)
        .chain(campaign.image.terrain.as_deref());
    let mut inputs = Vec::new();
    for path in files {
        let input = InputFile::record(path).with_context(|| format!("{}", path.display()))?;
        if !inputs.contains(&input) {
            inputs.push(input);
        }
    }
    Ok(inputs)
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
