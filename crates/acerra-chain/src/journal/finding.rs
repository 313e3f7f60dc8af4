//! One finding: a number of a run, and its expected value.

use serde::Serialize;

/// Verdict of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The value agrees with its expected value.
    Agrees,
    /// The value is unlikely, or the image suffers from it; the settings need a check.
    Doubtful,
    /// The value cannot be, were the settings right.
    Contradicts,
}

/// A value that a run has found, judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the finding, unique within a run (and track).
    pub name: String,
    /// The value found; none where it cannot be measured.
    pub value: Option<f64>,
    /// The value expected if the settings are right.
    pub expected: Option<f64>,
    /// Standard deviation of `value - expected` if the settings are right.
    pub sigma: Option<f64>,
    /// Unit of the three.
    pub unit: &'static str,
    /// The judgement.
    pub verdict: Verdict,
    /// The judgement in words: what was compared, and which settings to look at.
    pub explanation: String,
    /// The setting that the finding checks: a wrong value that harms the image would be doubted or
    /// contradicted.
    #[serde(skip)]
    pub checks: Option<Setting>,
}

/// Differences beyond this number of σ are doubtful, or contradict.
pub(crate) const DOUBTFUL_SIGMAS: f64 = 3.0;

const CONTRADICTING_SIGMAS: f64 = 6.0;

impl Finding {
    /// A finding whose verdict follows from the deviation in units of σ: doubtful from 3 σ, a
    /// contradiction from 6 σ.
    ///
    /// ```
    /// use acerra_chain::findings::{Finding, Verdict};
    /// let finding = Finding::compared("surface_delay", 1.9, 0.0, 0.2, "ns");
    /// assert_eq!(finding.verdict, Verdict::Contradicts);
    /// ```
    #[must_use]
    pub fn compared(
        name: impl Into<String>,
        value: f64,
        expected: f64,
        sigma: f64,
        unit: &'static str,
    ) -> Self {
        let deviation = (value - expected).abs() / sigma;
        let verdict = match deviation {
            d if d <= DOUBTFUL_SIGMAS => Verdict::Agrees,
            d if d <= CONTRADICTING_SIGMAS => Verdict::Doubtful,
            // Also where the deviation is not a number.
            _ => Verdict::Contradicts,
        };
        Self {
            name: name.into(),
            value: Some(value),
            expected: Some(expected),
            sigma: Some(sigma),
            unit,
            verdict,
            explanation: String::new(),
            checks: None,
        }
    }

    /// A finding with a verdict that the caller has reached.
    #[must_use]
    pub fn judged(
        name: impl Into<String>,
        value: f64,
        unit: &'static str,
        verdict: Verdict,
    ) -> Self {
        Self {
            name: name.into(),
            value: Some(value),
            expected: None,
            sigma: None,
            unit,
            verdict,
            explanation: String::new(),
            checks: None,
        }
    }

    /// This finding, checking a setting.
    #[must_use]
    pub fn checking(mut self, setting: Setting) -> Self {
        self.checks = Some(setting);
        self
    }

    /// This finding with the expected value.
    #[must_use]
    pub fn expecting(mut self, expected: f64) -> Self {
        self.expected = Some(expected);
        self
    }

    /// This finding with an explanation of the verdict.
    #[must_use]
    pub fn because(mut self, explanation: impl Into<String>) -> Self {
        self.explanation = explanation.into();
        self
    }

    /// This finding with a verdict no more severe than `most`.
    #[must_use]
    pub fn at_most(mut self, most: Verdict) -> Self {
        self.verdict = self.verdict.min(most);
        self
    }
}

/// A setting whose value a finding may check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The clock offset between radar and trajectory.
    ClockOffset,
    /// The fast time of range zero.
    Delay,
    /// The heights, lever arm up included: a check of the heights checks the delay as well, except for the
    /// direct coupling.
    Heights,
    /// The datum of a terrain's heights, where the delay was found over these heights.
    Datum,
    /// The lever arm along the nose of the platform.
    LeverArmForward,
    /// The lever arm across it.
    LeverArmLeft,
    /// The position of the base, as far as its own single-point position does not determine it.
    Base,
    /// The axes of positions that a file gives in a local frame: ranges are the same in its mirror image.
    Axes,
    /// Axis of the antenna, from which its pattern counts.
    AntennaAxis,
    /// Pattern of the antenna about its axis.
    AntennaPattern,
    /// The permittivity of the ground below the surface.
    Permittivity,
}
