//! The stages of a run, from a campaign to its products.

use acerra_chain::autofocus::AutofocusFailure;
use acerra_chain::calibrate::SurveyedPoint;
use acerra_chain::campaign::{Campaign, Contradictions};
use acerra_chain::findings::{Evidence, Verdict};
use acerra_chain::findings::{
    exceed_clutter, separate_residues, weigh_autofocus, weigh_image, weigh_prepared, weigh_targets,
    weigh_unchecked,
};
use acerra_chain::focus::plan::ImageError;
use acerra_chain::measure::MeasureError;
use acerra_chain::{
    Cancelled, ChainError, Control, Focused, ImageRequest, ImageSink, Journal, MemorySink, Prepared,
};
use acerra_geo::geoid::{GeoidError, GeoidGrid};

use crate::outcome::Outcome;
use crate::survey_check::{checked_by_survey, survey_finding};
use crate::surveyed::{SurveyError, compared, read_survey};

/// Reasons why a run leaves no products.
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
    /// Findings that contradict the settings.
    #[error(
        "the evidence contradicts the settings:\n{found}\n([checks] contradictions = \"warn\" makes the \
         image nevertheless)"
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

/// Fails on the first contradictions, unless the campaign turns them into warnings.
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

/// A campaign with resolved paths, and its name in titles.
#[derive(Clone, Debug)]
pub struct NamedCampaign {
    /// Name.
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
    let ready = Ready::of(campaign, journal, control)?;
    let uncorrected = ready.uncorrected(journal, control)?;
    let focused = journal.stage("focus", |warnings| {
        warnings.extend(ready.prepared.doubts(&ready.request));
        ready.prepared.image(&ready.request, sink, control)
    })?;
    let outcome = ready.measured(focused, journal, control)?;
    Ok(Outcome {
        uncorrected,
        ..outcome
    })
}

/// All that is known before an image is made.
#[derive(Debug)]
pub(crate) struct Ready {
    name: String,
    campaign: Campaign,
    surveyed: Vec<SurveyedPoint>,
    geoid: Option<GeoidGrid>,
    /// Clean spectra at their places, corrected where the campaign enables the correction.
    pub prepared: Prepared,
    /// The image asked for.
    pub request: ImageRequest,
}

impl Ready {
    /// Prepares a campaign, and judges its settings by the data.
    ///
    /// # Errors
    /// The first stage that fails; settings that the data contradict.
    pub fn of(
        campaign: NamedCampaign,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> Result<Self, RunError> {
        let NamedCampaign { name, campaign } = campaign;
        let surveyed = read_survey(campaign.measure.survey.as_deref())?;
        let geoid = campaign.image.geoid.as_ref();
        let geoid = geoid.map(GeoidGrid::read).transpose()?;
        let mut prepared = campaign.survey().prepare(journal, control)?;
        let mut campaign = campaign.with_found(&prepared);
        let request = campaign.image_request(prepared.scene.pixels.clone());
        journal
            .stage("clean", |_| weigh_prepared(&prepared, &request, control))?
            .into_iter()
            .for_each(|finding| journal.evidence.add(finding));
        refuse_contradictions(&campaign, &journal.evidence)?;
        if campaign.autofocus.enabled {
            autofocus(&campaign, &mut prepared, journal, control)?;
            campaign = campaign.with_corrected(&prepared);
        }
        Ok(Self {
            name,
            campaign,
            surveyed,
            geoid,
            prepared,
            request,
        })
    }

    /// The image by the stated positions, of one plane or terrain alone; none where no correction was
    /// applied.
    fn uncorrected(
        &self,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> Result<Option<Focused>, RunError> {
        let correction = self.prepared.correction.as_ref();
        let is_applied = correction.is_some_and(|found| found.is_applied());
        if !is_applied || self.request.pixels.volume.is_some() {
            return Ok(None);
        }
        let plain = ImageRequest {
            looks: None,
            ..self.request.clone()
        };
        let before = journal.stage("focus", |_| {
            let stated = self.prepared.as_stated();
            stated.image(&plain, &mut MemorySink::default(), control)
        })?;
        Ok(Some(before))
    }

    /// Measures an image, and judges it.
    ///
    /// # Errors
    /// The first stage that fails; settings that the image contradicts.
    pub fn measured(
        self,
        focused: Focused,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> Result<Outcome, RunError> {
        let Self {
            name,
            campaign,
            surveyed,
            geoid,
            prepared,
            ..
        } = self;
        let (measured, exceeds_clutter, residue, findings) = journal.stage("measure", |_| {
            let (measured, findings) = rayon::join(
                || prepared.measure(&focused, &(&campaign.measure).into(), control),
                || weigh_image(&prepared, &focused, control),
            );
            let mut measured = measured?;
            let residue = separate_residues(&prepared, &focused, &mut measured);
            let exceeds = exceed_clutter(&prepared, &focused, &measured.targets, control)?;
            Ok::<_, RunError>((measured, exceeds, residue, findings?))
        })?;
        for finding in findings.into_iter().chain(residue) {
            journal.evidence.add(finding);
        }
        weigh_targets(&prepared, &focused, &measured.targets, &exceeds_clutter)
            .into_iter()
            .for_each(|finding| journal.evidence.add(finding));
        let surveyed = compared(&surveyed, &measured.targets);
        let grid = &focused.pixels.grid;
        if let Some(finding) = survey_finding(&prepared, grid, &surveyed, &measured.targets) {
            journal.evidence.add(finding);
        }
        refuse_contradictions(&campaign, &journal.evidence)?;
        let checked = checked_by_survey(&prepared, grid, &surveyed, &measured.targets);
        let unchecked = weigh_unchecked(
            &prepared,
            &focused.options,
            focused.underground.as_ref(),
            &journal.evidence,
            &checked,
        );
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
            uncorrected: None,
            surveyed,
            measured,
            exceeds_clutter,
            evidence: journal.evidence.clone(),
            unchecked,
            warnings: journal.warnings.said().to_vec(),
            notes: journal.warnings.notes().to_vec(),
        })
    }
}

/// Corrects the positions where that is significant.
fn autofocus(
    campaign: &Campaign,
    prepared: &mut Prepared,
    journal: &mut Journal,
    control: &Control<'_>,
) -> Result<(), RunError> {
    let options = campaign.autofocus_options();
    let findings = journal.stage("focus", |_| {
        let found = prepared.autofocus(&options, control)?;
        Ok::<_, RunError>(weigh_autofocus(found))
    })?;
    findings
        .into_iter()
        .for_each(|finding| journal.evidence.add(finding));
    Ok(())
}

/// Reason why heights above the geoid cannot be given, if so.
fn without_sea_level(geoid: &GeoidGrid, prepared: &Prepared) -> Option<String> {
    let Some(frame) = prepared.first().positions.earth_frame() else {
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
             above the sea are given"
        )
    })
}
