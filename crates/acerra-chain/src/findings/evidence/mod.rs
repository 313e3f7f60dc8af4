//! Evidence: independent findings of a run, each a value beside what it should be, with a verdict.
//!
//! ```text
//! stages ──numbers──► judgements (surface, geometry, band, …) ──► Finding ──► Evidence ──► verdict
//! ```
//!
//! A judgement is a plain function of numbers that the stages hold anyway; it knows neither the
//! campaign nor the stages. What contradicts makes a run fail unless the campaign says otherwise
//! (`[checks] contradictions = "warn"`).

mod antenna;
mod attitude;
mod autofocus;
mod clock;
mod delay;
mod finding;
mod focus;
mod geometry;
mod image;
mod inversion;
mod positions;
mod processing;
mod radar;
mod setting;
mod targets;
mod unchecked;

use serde::Serialize;

pub use antenna::{AntennaSeen, AxisCarrier, antenna_tilt};
pub use attitude::{attitude_clock, attitude_place};
pub use autofocus::{
    AutofocusSeen, autofocus_correction, autofocus_gain, autofocus_global, autofocus_sigma,
};
pub use clock::{ClockSeen, clock_offset, clock_offset_sigma, recorded_clock_sigma};
pub use delay::{delay_before_zero, delay_sharpness};
pub use finding::{Finding, Verdict};
pub use focus::{PreferredSetting, preferred_setting};
pub use geometry::{
    Coverage, ImageGeometry, SeenWithin, aperture_coverage, coverage, incidence_coverage,
    pixel_size, scan_spacing, wavenumber_span,
};
pub use image::{ImageContrast, contrast};
pub use inversion::{InversionSeen, inversion_ambiguity, inversion_converged, inversion_residual};
pub use positions::{
    AltimeterSeen, autopilot_fixed, base_position, flight_height, focusing_loss, lever_arm_heading,
    lever_arm_length, radar_height, surface_height, trajectory_coverage,
};
pub use processing::{
    BackgroundWindow, FrequencyGrid, background_loss, background_window, frequency_step,
    light_speed, still_echoes,
};
pub use radar::{CouplingSeen, SurfaceSeen, band, band_used, coupling, surface, zero_timing};
pub use setting::Setting;
pub use targets::{SideSeen, surface_residue, target_side};
pub use unchecked::{Unchecked, unchecked};

/// The findings of a run, in the order of its stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Evidence {
    findings: Vec<Finding>,
}

impl Evidence {
    /// Adds a finding.
    pub fn add(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    /// All findings.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The worst verdict; none of an empty list.
    #[must_use]
    pub fn worst(&self) -> Option<Verdict> {
        self.findings.iter().map(|finding| finding.verdict).max()
    }

    /// Findings with this verdict.
    pub fn with(&self, verdict: Verdict) -> impl Iterator<Item = &Finding> {
        self.findings
            .iter()
            .filter(move |finding| finding.verdict == verdict)
    }

    /// One line: how many findings agree, and the names of those that do not.
    ///
    /// ```
    /// use acerra_chain::evidence::{Evidence, Finding};
    /// let mut evidence = Evidence::default();
    /// evidence.add(Finding::compared("surface_delay", 0.1, 0.0, 0.2, "ns"));
    /// evidence.add(Finding::compared("coupling_delay", 9.0, 1.0, 1.0, "ns"));
    /// assert_eq!(evidence.summary(), "1 of 2 findings agree; contradicts: coupling_delay");
    /// ```
    #[must_use]
    pub fn summary(&self) -> String {
        let agreeing = self.with(Verdict::Agrees).count();
        let mut line = format!("{agreeing} of {} findings agree", self.findings.len());
        for (verdict, word) in [
            (Verdict::Contradicts, "contradicts"),
            (Verdict::Doubtful, "doubtful"),
        ] {
            let names: Vec<&str> = self.with(verdict).map(|f| f.name.as_str()).collect();
            if !names.is_empty() {
                line.push_str(&format!("; {word}: {}", names.join(", ")));
            }
        }
        line
    }
}
