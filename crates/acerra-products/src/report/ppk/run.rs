//! A positioning run in local axes.

use super::super::data::Fact;
use super::super::numbers::{fixed, quantile};
use super::input::PpkReport;
use acerra_figure::{Axis, FigureError};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::SolutionStatus;
use acerra_gnss::{NotFixedReason, PpkSolution, Quality, SatelliteId, Solution};
use std::collections::BTreeMap;

/// The status that shows a quality.
pub(super) fn status(quality: Quality) -> SolutionStatus {
    SolutionStatus::from_rtklib_q(u32::from(quality.number()))
}

/// The run in local axes, with the origin at the base where that is known.
pub(super) struct Run<'a> {
    pub solution: &'a PpkSolution,
    pub frame: EnuFrame,
    pub start: GpsTime,
    /// Time of every epoch with a position, since `start`.
    pub time_s: Vec<f64>,
    pub enu_m: Vec<[f64; 3]>,
    pub sigma_m: Vec<[f64; 3]>,
    /// Distance between forward and backward position, NaN where not known.
    pub pass_difference_m: Vec<f64>,
    pub ratio_threshold: Option<f64>,
}

/// Contribution of one satellite.
pub(super) struct SatelliteUse {
    pub satellite: SatelliteId,
    pub time_s: Vec<f64>,
    pub phase_mm: Vec<f64>,
    pub code_m: Vec<f64>,
    pub epochs: usize,
    pub fixed: usize,
    pub slips: usize,
    /// Lowest and highest.
    pub elevation_deg: [f64; 2],
}

impl<'a> Run<'a> {
    pub fn new(report: &PpkReport<'a>) -> Result<Self, FigureError> {
        let solution = report.solution;
        let first = solution.epochs.first();
        let origin = solution
            .base_position_ecef_m
            .or_else(|| first.map(|s| s.position_ecef_m))
            .unwrap_or([6_378_137.0, 0.0, 0.0]);
        let frame = EnuFrame::from_ecef(origin);
        let lost = solution.lost.iter().map(|epoch| epoch.time);
        let starts = first.map(|s| s.time).into_iter().chain(lost);
        let start = starts
            .min_by(|a, b| a.seconds_since(*b).total_cmp(&0.0))
            .unwrap_or(GpsTime::EPOCH);
        let sigma_m = |s: &Solution| {
            let covariance = frame.enu_covariance_from_ecef(&s.covariance_ecef_m2);
            [0, 1, 2].map(|i| covariance[i][i].max(0.0).sqrt())
        };
        let epochs = &solution.epochs;
        Ok(Self {
            solution,
            frame,
            start,
            time_s: epochs.iter().map(|s| s.time.seconds_since(start)).collect(),
            enu_m: epochs
                .iter()
                .map(|s| frame.enu_from_ecef(s.position_ecef_m))
                .collect(),
            sigma_m: epochs.iter().map(sigma_m).collect(),
            pass_difference_m: pass_difference_m(report)?,
            ratio_threshold: report.ratio_threshold,
        })
    }

    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Usual time between epochs.
    pub fn interval_s(&self) -> f64 {
        quantile(self.time_s.windows(2).map(|w| w[1] - w[0]), 0.5)
            .filter(|step| *step > 0.0)
            .unwrap_or(1.0)
    }

    /// A longer step between epochs is a gap.
    pub fn longest_step_s(&self) -> f64 {
        3.0 * self.interval_s()
    }

    /// The time axis of every figure: all epochs, with and without a position.
    pub fn time_axis(&self) -> Axis {
        let lost = self
            .solution
            .lost
            .iter()
            .map(|l| l.time.seconds_since(self.start));
        let times = self.time_s.iter().copied().chain(lost);
        let last = times.fold(0.0, f64::max);
        let start = self.start.format_calendar(0);
        Axis::new(format!("time since {start} GPST"), "s").range(0.0, last + self.interval_s())
    }

    pub fn facts(&self) -> Vec<Fact> {
        let summary = &self.solution.summary;
        let share = |count: usize| {
            let percent = 100.0 * count as f64 / summary.rover_epochs.max(1) as f64;
            format!("{} %", fixed(percent, 1))
        };
        let count = |n: usize| format!("{n} of {} epochs", summary.rover_epochs);
        let mut facts = vec![
            Fact::new("Fixed", share(summary.fixed)).note(count(summary.fixed)),
            Fact::new("Float", share(summary.float)).note(count(summary.float)),
            Fact::new("Without position", share(self.solution.lost.len()))
                .note(count(self.solution.lost.len())),
        ];
        let good = |axis: usize| {
            let values = self.solution.epochs.iter().zip(&self.sigma_m);
            let fixed_only = values.filter(|(s, _)| s.quality == Quality::Fixed);
            quantile(fixed_only.map(|(_, sigma)| sigma[axis]), 0.5).map(|v| v * 1e3)
        };
        if summary.fixed > 0 {
            let value = format!(
                "{} / {} / {} mm",
                fixed(good(0), 0),
                fixed(good(1), 0),
                fixed(good(2), 0)
            );
            facts.push(Fact::new("Median σ where fixed", value).note("east / north / up"));
        }
        if let Some([_, mean, largest]) = summary.age_s {
            facts.push(
                Fact::new("Age of base data", format!("{} s", fixed(mean, 2)))
                    .note(format!("at the most {} s", fixed(largest, 2))),
            );
        }
        facts
    }

    pub fn map_caption(&self) -> String {
        let place = self.frame.origin();
        let whose = if self.solution.base_position_ecef_m.is_some() {
            "the base"
        } else {
            "the first fix"
        };
        format!(
            "The track from above, both axes to one scale, from {whose} at {}°, {}°, {} m.",
            fixed(place.latitude_deg(), 8),
            fixed(place.longitude_deg(), 8),
            fixed(place.height_m, 3)
        )
    }

    /// Values where the quality is `wanted`, NaN elsewhere: one broken series per quality.
    pub fn only(&self, wanted: Quality, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.time_s.len())
            .map(|i| {
                if self.solution.epochs[i].quality == wanted {
                    value(i)
                } else {
                    f64::NAN
                }
            })
            .collect()
    }

    /// The qualities that occur, worst first so that better ones are drawn on top.
    pub fn qualities(&self) -> Vec<Quality> {
        let mut found: Vec<Quality> = self.solution.epochs.iter().map(|s| s.quality).collect();
        found.sort_unstable();
        found.dedup();
        found.reverse();
        found
    }

    pub fn satellites(&self) -> Vec<SatelliteUse> {
        let mut uses: BTreeMap<SatelliteId, SatelliteUse> = BTreeMap::new();
        for (solution, time_s) in self.solution.epochs.iter().zip(&self.time_s) {
            for residual in solution.residuals.iter().filter(|r| r.slot == 0) {
                let satellite = residual.satellite;
                let of_one = uses.entry(satellite).or_insert_with(|| SatelliteUse {
                    satellite,
                    time_s: Vec::new(),
                    phase_mm: Vec::new(),
                    code_m: Vec::new(),
                    epochs: 0,
                    fixed: 0,
                    slips: 0,
                    elevation_deg: [f64::INFINITY, f64::NEG_INFINITY],
                });
                of_one.epochs += 1;
                of_one.fixed += usize::from(residual.fixed);
                of_one.slips += usize::from(residual.slipped);
                let elevation = residual.elevation_rad.to_degrees();
                of_one.elevation_deg[0] = of_one.elevation_deg[0].min(elevation);
                of_one.elevation_deg[1] = of_one.elevation_deg[1].max(elevation);
                of_one.time_s.push(*time_s);
                of_one
                    .phase_mm
                    .push(residual.phase_m.map_or(f64::NAN, |v| v * 1e3));
                of_one.code_m.extend(residual.code_m);
            }
        }
        uses.into_values().collect()
    }
}

/// The pass differences that were kept, else those of epochs that are float because of the difference.
fn pass_difference_m(report: &PpkReport<'_>) -> Result<Vec<f64>, FigureError> {
    let epochs = &report.solution.epochs;
    if report.pass_difference_m.is_empty() {
        let stated = |s: &Solution| match s.not_fixed {
            Some(NotFixedReason::PassesDisagree { distance_m }) => distance_m,
            _ => f64::NAN,
        };
        return Ok(epochs.iter().map(stated).collect());
    }
    if report.pass_difference_m.len() != epochs.len() {
        return Err(FigureError::ShapeMismatch {
            what: "pass differences",
            expected: epochs.len(),
            found: report.pass_difference_m.len(),
        });
    }
    Ok(report.pass_difference_m.clone())
}
