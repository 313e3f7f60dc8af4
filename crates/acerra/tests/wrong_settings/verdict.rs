//! What a run with a wrong setting came to.

use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::findings::Verdict;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_imaging::metrics::Target;
use acerra_products::{NamedCampaign, process};
use toml::Table;

use crate::subjects::Truth;

/// A run: its findings, and its targets or why there are none.
pub struct Run {
    /// The targets; the message of a run that was refused.
    pub targets: Result<Vec<Target>, String>,
    /// Findings that do not agree, as `name: explanation`, and warnings.
    pub doubts: Vec<String>,
    /// Every finding, as `name value expected sigma`.
    pub findings: Vec<String>,
    /// Whether a finding contradicts.
    pub contradicts: bool,
    /// What the run says of settings that nothing checks.
    pub unchecked: Vec<String>,
}

/// What became of a wrong setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The run failed with this message.
    Refused(String),
    /// Findings or warnings doubt the setting, and name it or what is wrong.
    Doubted(String),
    /// The image is within its tolerance.
    Harmless,
    /// The run says that nothing in the data checks the setting.
    Unchecked(String),
    /// The image is wrong, and what is doubted is something else.
    Misled(String),
    /// The image is wrong and nothing says so.
    Silent(String),
}

impl Outcome {
    /// The word for it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Refused(_) => "refused",
            Self::Doubted(_) => "doubted",
            Self::Harmless => "harmless",
            Self::Unchecked(_) => "unchecked",
            Self::Misled(_) => "MISLED",
            Self::Silent(_) => "SILENT",
        }
    }
}

/// Levels of reflectors may differ from the right run's by so much (dB).
const LEVEL_DB: f64 = 3.0;
/// Targets that may appear beside those of the right run.
const MORE_TARGETS: usize = 1;

/// Processes a campaign whose files are in `folder`.
pub fn run(campaign: &Table, folder: &Path) -> Run {
    let mut journal = Journal::default();
    let outcome = Campaign::parse(&campaign.to_string())
        .map_err(|error| error.to_string())
        .and_then(|campaign| {
            let named = NamedCampaign {
                name: "sweep".to_owned(),
                campaign: campaign.resolved_in(folder),
            };
            let (mut sink, control) = (MemorySink::default(), Control::default());
            process(named, &mut sink, &mut journal, &control).map_err(|error| error.to_string())
        });
    let findings = journal.evidence.findings().iter();
    let doubts = findings
        .filter(|finding| finding.verdict != Verdict::Agrees)
        .map(|finding| format!("{}: {}", finding.name, finding.explanation))
        .chain(journal.warnings.said().iter().cloned())
        .collect();
    let findings = journal.evidence.findings().iter();
    let findings = findings
        .map(|f| format!("{} {:?} {:?} {:?}", f.name, f.value, f.expected, f.sigma))
        .collect();
    let unchecked = outcome.as_ref().map(|outcome| {
        let each = outcome.unchecked.iter();
        each.map(|one| format!("{}: {}", one.setting, one.explanation))
            .collect()
    });
    Run {
        unchecked: unchecked.unwrap_or_default(),
        targets: outcome.map(|outcome| outcome.measured.targets),
        doubts,
        findings,
        contradicts: journal.evidence.worst() == Some(Verdict::Contradicts),
    }
}

impl Run {
    /// What the run came to, beside the right one; a doubt must hold one of the words `causes`.
    pub fn outcome(&self, right: &Self, truth: &Truth, causes: &[&str]) -> Outcome {
        let targets = match &self.targets {
            Err(message) => return Outcome::Refused(message.clone()),
            Ok(targets) => targets,
        };
        let Some(wrong) = truth.wrong(targets, right.targets.as_deref().unwrap_or(&[])) else {
            return Outcome::Harmless;
        };
        // A doubt that the right run raises as well says nothing of this setting.
        let names: Vec<&str> = right.doubts.iter().map(|doubt| name_of(doubt)).collect();
        let new = || {
            self.doubts
                .iter()
                .filter(|doubt| !names.contains(&name_of(doubt)))
        };
        let named = new().find(|doubt| causes.iter().any(|cause| doubt.contains(cause)));
        let told = || {
            let mut said = self.unchecked.iter();
            said.find(|text| causes.iter().any(|cause| text.contains(cause)))
        };
        match (named, new().next()) {
            (Some(doubt), _) => Outcome::Doubted(doubt.clone()),
            _ if told().is_some() => Outcome::Unchecked(told().cloned().unwrap_or_default()),
            (None, Some(other)) => Outcome::Misled(format!("{wrong}; {other}")),
            (None, None) => Outcome::Silent(wrong),
        }
    }
}

/// What a doubt is called: the finding's name, or the warning without its numbers.
fn name_of(doubt: &str) -> &str {
    doubt.split_once(": ").map_or(doubt, |(name, _)| name)
}

impl Truth {
    /// What is wrong with the targets of an image; none where it is right.
    pub fn wrong(&self, targets: &[Target], right: &[Target]) -> Option<String> {
        for place_m in &self.target_m {
            let Some((off, target)) = self.nearest(*place_m, targets) else {
                return Some("no target".to_owned());
            };
            if off > 1.0 {
                return Some(format!(
                    "nearest target {:+.2} m, {:+.2} m off",
                    target.x_m - place_m[0],
                    target.y_m - place_m[1]
                ));
            }
            let level_db = self
                .nearest(*place_m, right)
                .map_or(0.0, |(_, t)| t.level_db);
            if (target.level_db - level_db).abs() > LEVEL_DB {
                return Some(format!("level {:.1} dB off", target.level_db - level_db));
            }
        }
        (targets.len() > right.len().max(self.target_m.len()) + MORE_TARGETS)
            .then(|| format!("{} targets", targets.len()))
    }

    /// The nearest target, and its distance in units of the tolerance.
    fn nearest<'a>(&self, [x, y]: [f64; 2], targets: &'a [Target]) -> Option<(f64, &'a Target)> {
        let [along_m, across_m] = self.tolerance_m;
        // The greater of the two, not their sum: each axis has a tolerance of its own.
        let off = |t: &Target| ((t.x_m - x).abs() / along_m).max((t.y_m - y).abs() / across_m);
        let nearest = targets.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some((off(nearest), nearest))
    }
}
