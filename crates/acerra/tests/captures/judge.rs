//! What became of a capture: its calibration, and the image by the keys that the calibration writes.

use std::path::Path;

use acerra_chain::calibrate::{Calibrated, Parameter};
use acerra_chain::findings::Verdict;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_products::calibration::CampaignFile;
use acerra_products::{NamedCampaign, Outcome, process};
use toml::Table;

use crate::capture::{Capture, Reflector};

/// Classes of calibrations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Delay with a deviation, and every estimate within three deviations.
    Right,
    /// No delay, with a reason, or a delay without a deviation.
    Refused,
    /// An estimate beyond three deviations.
    Wrong,
}

impl Class {
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Refused => "says that it cannot",
            Self::Wrong => "CERTAIN AND WRONG",
        }
    }
}

/// Classes of the images by what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Imaged {
    /// Every reflector within a resolution cell.
    Right,
    /// Not so, and a finding doubts or contradicts it.
    Doubted,
    /// No image, with a reason.
    Refused,
    /// Not so, without a word.
    Silent,
}

impl Imaged {
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Doubted => "doubted",
            Self::Refused => "refused",
            Self::Silent => "WRONG",
        }
    }
}

/// What became of a capture.
pub struct Judged {
    pub class: Class,
    /// The image, where a delay was written.
    pub imaged: Option<Imaged>,
    /// Whether the image by right settings shows every surveyed reflector clearly.
    pub is_clear: bool,
    /// Error of the delay and its stated deviation (ns).
    pub delay_ns: Option<[f64; 2]>,
    /// Why, in words.
    pub details: String,
}

/// Level of a reflector over everything else near it from which a capture can be calibrated (dB).
const CLEAR_DB: f64 = 10.0;
/// Distance from a reflector within which the image is its own, and within which its image is compared (m).
const OWN_M: f64 = 0.4;
const NEAR_M: f64 = 1.0;

/// What the program takes where the user states no deviation (m).
const DEFAULT_SURVEY_SIGMA_M: f64 = 0.02;

/// Calibrates as a user does, writes the keys, focuses, and judges both.
pub fn judged(capture: &Capture, true_offset_s: f64, folder: &Path) -> Judged {
    let file = folder.join("campaign.toml");
    std::fs::write(&file, capture.stated(true_offset_s).to_string()).unwrap();
    let right = Image::of(&capture.right(true_offset_s), folder).ok();
    let is_clear = right.as_ref().is_some_and(|image| {
        let clear = |r: &Reflector| {
            let is_surveyed = r.is_seen && !r.is_misplaced;
            is_surveyed && image.clear_db(r) >= CLEAR_DB && image.is_within_cell(capture, r)
        };
        capture.reflectors.iter().all(clear)
    });
    let campaign = CampaignFile::read(&file).unwrap();
    let surveyed_m = capture.reflectors.iter().map(|r| r.surveyed_m).collect();
    let (mut journal, control) = (Journal::default(), Control::default());
    let sigma_m = capture.survey_sigma_m.unwrap_or(DEFAULT_SURVEY_SIGMA_M);
    let outcome = match campaign.calibrate(surveyed_m, sigma_m, &mut journal, &control) {
        Ok(outcome) => outcome,
        Err(error) => {
            return Judged {
                class: Class::Refused,
                imaged: None,
                is_clear,
                delay_ns: None,
                details: format!("{error:#}").replace('\n', " "),
            };
        }
    };
    let (class, mut details) = estimates(capture, true_offset_s, &outcome.calibrated);
    for warning in &outcome.warnings {
        details += &format!("; {warning}");
    }
    let delay = outcome.calibrated.estimate(Parameter::Delay).unwrap();
    let delay_ns = delay
        .sigma
        .map(|sigma_s| [delay.value * 1e9 - capture.delay_ns, sigma_s * 1e9]);
    let imaged = delay_ns.is_some().then(|| {
        campaign.write_keys(&outcome.keys()).unwrap();
        let written: Table = std::fs::read_to_string(&file).unwrap().parse().unwrap();
        let Ok(image) = Image::of(&written, folder) else {
            return Imaged::Refused;
        };
        // A reflector whose image is bent by clutter even with right settings is no measure.
        let is_measure = |r: &&Reflector| {
            let right = right.as_ref();
            r.is_seen && right.is_some_and(|image| image.is_within_cell(capture, r))
        };
        let mut measures = capture.reflectors.iter().filter(is_measure);
        if measures.all(|r| image.is_within_cell(capture, r)) {
            Imaged::Right
        } else if image.is_doubted {
            Imaged::Doubted
        } else {
            Imaged::Silent
        }
    });
    Judged {
        class,
        imaged,
        is_clear,
        delay_ns,
        details,
    }
}

/// Whether the estimates keep their deviations, and each in words.
fn estimates(capture: &Capture, offset_s: f64, found: &Calibrated) -> (Class, String) {
    let mut class = Class::Right;
    let mut details = String::new();
    for estimate in &found.estimates {
        let [forward_m, left_m, up_m] = capture.arm_m;
        // 5 mm of place or range, and what 5 mm are at the speed of the carrier: less than the held lever arm may be
        // wrong by.
        let (truth, bound) = match estimate.parameter {
            Parameter::Delay => (capture.delay_ns * 1e-9, 0.033e-9),
            Parameter::ClockOffset(_) => (offset_s, 0.005 / capture.motion.speed_m_s),
            Parameter::Forward => (forward_m, 0.005),
            Parameter::Left => (left_m, 0.005),
            Parameter::Up => (up_m, 0.005),
            Parameter::RangeScale => (0.0, 1e-4),
        };
        let (unit, per_si) = estimate.parameter.unit();
        let off = estimate.value - truth;
        let Some(sigma) = estimate.sigma else {
            if estimate.parameter == Parameter::Delay && class == Class::Right {
                class = Class::Refused;
            }
            continue;
        };
        if off.abs() > (3.0 * sigma).max(bound) {
            class = Class::Wrong;
        }
        details += &format!(
            "{} {:+.3} ± {:.3} {unit}, ",
            estimate.parameter.name(),
            off * per_si,
            sigma * per_si
        );
    }
    (class, details)
}

/// An image of a capture.
struct Image {
    level: Vec<(f64, f64, f64)>,
    is_doubted: bool,
}

impl Image {
    fn of(campaign: &Table, folder: &Path) -> Result<Self, acerra_products::RunError> {
        let mut campaign = campaign.clone();
        let checks: Table = "contradictions = 'warn'".parse().unwrap();
        campaign.insert("checks".to_owned(), checks.into());
        let campaign = acerra_chain::campaign::Campaign::parse(&campaign.to_string())
            .unwrap()
            .resolved_in(folder);
        let name = "capture".to_owned();
        let outcome: Outcome = process(
            NamedCampaign { name, campaign },
            &mut MemorySink::default(),
            &mut Journal::default(),
            &Control::default(),
        )?;
        let image = &outcome.focused;
        let grid = &outcome.campaign.image;
        let [x_m, y_m] = [grid.x_m, grid.y_m].map(Option::unwrap_or_default);
        let columns = ((x_m[1] - x_m[0]) / grid.pixel_m).round() as usize + 1;
        let place = |k: usize| {
            let after_m = |n: usize| n as f64 * grid.pixel_m;
            (x_m[0] + after_m(k % columns), y_m[0] + after_m(k / columns))
        };
        let pixel = |k: usize| (place(k).0, place(k).1, f64::from(image.image[k].norm()));
        let findings = outcome.evidence.findings();
        Ok(Self {
            level: (0..image.image.len()).map(pixel).collect(),
            is_doubted: findings.iter().any(|f| f.verdict != Verdict::Agrees),
        })
    }

    /// The highest pixel whose distance from a place lies within some (m), and its level.
    fn top(&self, place_m: [f64; 3], from_m: f64, to_m: f64) -> ([f64; 2], f64) {
        let away_m = |p: &(f64, f64, f64)| (p.0 - place_m[0]).hypot(p.1 - place_m[1]);
        let near = |p: &&(f64, f64, f64)| (from_m..=to_m).contains(&away_m(p));
        let all = self.level.iter().filter(near);
        let top = all.max_by(|a, b| a.2.total_cmp(&b.2));
        top.map_or(([0.0; 2], 0.0), |(x, y, level)| ([*x, *y], *level))
    }

    /// Level of a reflector over everything else near it (dB).
    fn clear_db(&self, reflector: &Reflector) -> f64 {
        let own = self.top(reflector.place_m, 0.0, OWN_M).1;
        let other = self.top(reflector.place_m, OWN_M, NEAR_M).1;
        20.0 * (own / other.max(f64::MIN_POSITIVE)).log10()
    }

    fn is_within_cell(&self, capture: &Capture, reflector: &Reflector) -> bool {
        let place_m = reflector.place_m;
        let (top_m, _) = self.top(place_m, 0.0, NEAR_M);
        let cell_m = capture.cell_m(place_m);
        (0..2).all(|i| (top_m[i] - place_m[i]).abs() <= cell_m[i])
    }
}
