//! What became of a random flight.

use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::findings::Verdict;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_products::run_record::{TargetRecord, TargetsRecord};
use acerra_products::{NamedCampaign, Outcome, process};
use toml::Table;

use crate::flight::RandomFlight;

/// Classes of outcomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Every reflector within 3 σ and one resolution cell; of an empty scene no target, or a doubt.
    Right,
    /// Every reflector within 3 σ, one of them farther than a cell.
    WithinSigma,
    /// Every reflector within a cell, one of them beyond 3 σ.
    SigmaTooSmall,
    /// Every listed reflector right; another is in the image, fainter than the levels that are listed.
    NotListed,
    /// Right, and stopped by a contradiction.
    StoppedWrongly,
    /// Wrong, with a doubt or a contradiction.
    Doubted,
    /// No image, with a reason.
    Refused,
    /// Wrong without a word.
    Silent,
}

impl Class {
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::WithinSigma => "within its deviation",
            Self::SigmaTooSmall => "right, σ too small",
            Self::NotListed => "a reflector below the listed levels",
            Self::StoppedWrongly => "stopped wrongly",
            Self::Doubted => "doubted",
            Self::Refused => "refused",
            Self::Silent => "WRONG",
        }
    }
}

/// A reflector's image: its error over its stated deviation, along and across the track.
pub type Errors = [f64; 2];

/// What became of a flight.
pub struct Judged {
    pub class: Class,
    /// Error of the clock offset and its stated deviation (s).
    pub offset_s: Option<[f64; 2]>,
    /// Every reflector that has a target within a metre.
    pub errors: Vec<Errors>,
    /// Why, in words.
    pub details: String,
}

/// Farther than this from a reflector a target is another (m).
const SAME_M: f64 = 1.0;
/// A reflector's image is looked for about its place (m), down to this far below the levels that are listed (dB).
const ABOUT_M: f64 = 0.3;
const FAINT_DB: f64 = 6.0;
/// Range resolution of the band (m), and wavelength of its middle.
const RANGE_CELL_M: f64 = 0.088;
const WAVELENGTH_M: f64 = 0.0759;

/// Processes the campaign as a user's, but for contradictions, which do not stop it here, and judges it.
pub fn judged(
    flight: &RandomFlight,
    campaign: &Table,
    true_offset_s: f64,
    folder: &Path,
) -> Judged {
    let mut campaign = campaign.clone();
    campaign.insert(
        "checks".to_owned(),
        "contradictions = 'warn'".parse::<Table>().unwrap().into(),
    );
    let named = NamedCampaign {
        name: "flight".to_owned(),
        campaign: Campaign::parse(&campaign.to_string())
            .unwrap()
            .resolved_in(folder),
    };
    let (mut sink, control, mut journal) = (
        MemorySink::default(),
        Control::default(),
        Journal::default(),
    );
    let outcome = match process(named, &mut sink, &mut journal, &control) {
        Ok(outcome) => outcome,
        Err(error) => {
            return Judged {
                class: Class::Refused,
                offset_s: None,
                errors: Vec::new(),
                details: error.to_string(),
            };
        }
    };
    let track = outcome.prepared.first();
    let sigma_s = track.search.as_ref().map_or(0.0, |s| s.estimate.sigma_s);
    let record = TargetsRecord::of(&outcome);
    let is_faint = |place_m: &[f64; 3]| is_faint(&outcome, *place_m);
    let shown = Shown::of(flight, &record.targets, is_faint);
    let evidence = &outcome.evidence;
    let doubts: Vec<String> = evidence
        .findings()
        .iter()
        .filter(|f| f.verdict != Verdict::Agrees)
        .map(|f| format!("{} ({:?})", f.name, f.verdict))
        .collect();
    let is_stopped = evidence.worst() == Some(Verdict::Contradicts);
    let class = match shown.class {
        Class::Silent if !doubts.is_empty() => Class::Doubted,
        Class::Right | Class::WithinSigma | Class::SigmaTooSmall | Class::NotListed
            if is_stopped =>
        {
            Class::StoppedWrongly
        }
        // A scene without a reflector whose image is doubted shows nothing that anybody trusts.
        class => class,
    };
    Judged {
        class,
        offset_s: Some([track.time_offset_s - true_offset_s, sigma_s]),
        errors: shown.errors,
        details: format!("{}; {}", shown.details, doubts.join(", ")),
    }
}

/// Whether the image shows something at a place, fainter than the levels that are listed.
fn is_faint(outcome: &Outcome, place_m: [f64; 3]) -> bool {
    let focused = &outcome.focused;
    let (mut strongest, mut here) = (0_f32, 0_f32);
    for (k, value) in focused.image.iter().enumerate() {
        let at = focused.pixels.place_m(k);
        strongest = strongest.max(value.norm());
        if (at[0] - place_m[0]).hypot(at[1] - place_m[1]) < ABOUT_M {
            here = here.max(value.norm());
        }
    }
    let below_db =
        outcome.campaign.measure.threshold_db - 20.0 * f64::from(here / strongest).log10();
    (0.0..FAINT_DB).contains(&below_db)
}

/// What the image shows, whatever is said of it.
struct Shown {
    class: Class,
    errors: Vec<Errors>,
    details: String,
}

impl Shown {
    fn of(
        flight: &RandomFlight,
        targets: &[TargetRecord<'_>],
        is_faint: impl Fn(&[f64; 3]) -> bool,
    ) -> Self {
        let is_clutter = |t: &TargetRecord<'_>| {
            flight.clutter_m.is_some_and(|[west, east, south, north]| {
                (west..=east).contains(&t.target.x_m) && (south..=north).contains(&t.target.y_m)
            })
        };
        let others: Vec<&TargetRecord<'_>> = targets.iter().filter(|t| !is_clutter(t)).collect();
        if flight.reflectors_m.is_empty() {
            let class = if others.is_empty() {
                Class::Right
            } else {
                Class::Silent
            };
            let details = format!("{} targets", others.len());
            return Self {
                class,
                errors: Vec::new(),
                details,
            };
        }
        let mut class = Class::Right;
        let (mut errors, mut details) = (Vec::new(), Vec::new());
        let mut strongest_db = f64::NEG_INFINITY;
        let (mut within_cells, mut within_sigmas) = (true, true);
        for place_m in &flight.reflectors_m {
            let away =
                |t: &TargetRecord<'_>| (t.target.x_m - place_m[0]).hypot(t.target.y_m - place_m[1]);
            let nearest = others.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let Some(nearest) = nearest.filter(|t| away(t) < SAME_M) else {
                if is_faint(place_m) {
                    class = class.max(Class::NotListed);
                    details.push("below the listed levels".to_owned());
                } else {
                    class = Class::Silent;
                    details.push("not seen".to_owned());
                }
                continue;
            };
            strongest_db = strongest_db.max(nearest.target.level_db);
            let off_m = flight.off_m([nearest.target.x_m, nearest.target.y_m], *place_m);
            let sigma_m = nearest.sigma_along_across_m.unwrap_or([0.0; 2]);
            let cell_m = flight.cell_m(*place_m, RANGE_CELL_M, WAVELENGTH_M);
            errors.push([0, 1].map(|i| off_m[i] / sigma_m[i]));
            within_cells &= (0..2).all(|i| off_m[i].abs() <= cell_m[i]);
            within_sigmas &= (0..2).all(|i| off_m[i].abs() <= 3.0 * sigma_m[i]);
            details.push(format!(
                "({:+.3} ± {:.3}, {:+.3} ± {:.3}) m",
                off_m[0], sigma_m[0], off_m[1], sigma_m[1]
            ));
        }
        let is_ghost = |t: &&TargetRecord<'_>| {
            let near = |p: &[f64; 3]| (t.target.x_m - p[0]).hypot(t.target.y_m - p[1]) < SAME_M;
            t.target.level_db > strongest_db && !flight.reflectors_m.iter().any(near)
        };
        if others.iter().copied().any(|t| is_ghost(&t)) {
            class = Class::Silent;
            details.push("another target is stronger".to_owned());
        }
        class = match (class, within_cells, within_sigmas) {
            (Class::Silent, _, _) | (_, false, false) => Class::Silent,
            (Class::NotListed, _, _) => Class::NotListed,
            (_, true, true) => Class::Right,
            (_, false, true) => Class::WithinSigma,
            (_, true, false) => Class::SigmaTooSmall,
        };
        Self {
            class,
            errors,
            details: details.join(" "),
        }
    }
}
