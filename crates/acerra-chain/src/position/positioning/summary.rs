//! Summary of a positioning in numbers: the output of `--json`.

use acerra_geo::geodesy::{EnuFrame, geodetic_from_ecef};
use acerra_gnss::{BasePosition, Baseline, EventKind, PpkOptions, Quality};
use serde::Serialize;

use super::{Positioning, PositioningInput};

/// Output of `acerra ppk --json`. Times are GPS time.
#[derive(Clone, Debug, Serialize)]
pub struct PpkAnswer {
    /// Version of the program.
    pub version: &'static str,
    /// The files, in the order read.
    pub files: Vec<FileAnswer>,
    /// The base; `null` in single-point mode.
    pub base: Option<BaseAnswer>,
    /// First and last position.
    pub span_gpst: Option<[String; 2]>,
    /// Rover epochs.
    pub epochs: usize,
    /// Epochs with fixed ambiguities.
    pub fixed: usize,
    /// Epochs with float ambiguities.
    pub float: usize,
    /// Epochs with a position of another quality.
    pub other: usize,
    /// Epochs without a position.
    pub lost: usize,
    /// Share of the epochs that are fixed, %.
    pub fixed_percent: f64,
    /// Reasons for which epochs are not fixed, most frequent first.
    pub not_fixed: Vec<ReasonAnswer>,
    /// Decision about GLONASS ambiguities, with its reason; `null` without GLONASS.
    pub glonass: Option<String>,
    /// Smallest, mean and largest age of the base's data, s.
    pub age_s: Option<[f64; 3]>,
    /// Median standard deviation of the fixed positions: east, north, up, m.
    pub fixed_sd_m: Option<[f64; 3]>,
    /// The baseline from a moving base; `null` with a base at rest.
    pub baseline: Option<BaselineAnswer>,
    /// Events and the rover's positions at the events.
    pub events: Vec<EventAnswer>,
    /// Remarks.
    pub warnings: Vec<String>,
}

/// The vector between two antennas, over all fixed epochs.
#[derive(Clone, Debug, Serialize)]
pub struct BaselineAnswer {
    /// Median length, m.
    pub length_m: f64,
    /// 5 % and 95 % quantiles of the length over the epochs, m.
    pub length_range_m: [f64; 2],
    /// Median standard deviation of the heading, degrees; `null` where the baseline is upright.
    pub heading_sd_deg: Option<f64>,
}

/// One input file.
#[derive(Clone, Debug, Serialize)]
pub struct FileAnswer {
    /// Path as given.
    pub file: String,
    /// Format in words.
    pub format: String,
    /// Data dropped.
    pub dropped: Vec<DropAnswer>,
}

/// One reason for dropping something.
#[derive(Clone, Debug, Serialize)]
pub struct DropAnswer {
    /// The reason in words.
    pub reason: String,
    /// Number of occurrences.
    pub count: u64,
    /// Place of the first occurrence.
    pub first: String,
}

/// One reason for not fixing.
#[derive(Clone, Debug, Serialize)]
pub struct ReasonAnswer {
    /// The reason in words.
    pub reason: String,
    /// Number of epochs.
    pub epochs: usize,
}

/// The base's position.
#[derive(Clone, Debug, Serialize)]
pub struct BaseAnswer {
    /// Source of the position: `given`, `header` or `average`.
    pub source: &'static str,
    /// Earth-centred coordinates, m.
    pub ecef_m: [f64; 3],
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Ellipsoidal height, m.
    pub height_m: f64,
}

/// One event.
#[derive(Clone, Debug, Serialize)]
pub struct EventAnswer {
    /// Time of the event.
    pub time_gpst: String,
    /// `external`, `rising` or `falling`.
    pub kind: &'static str,
    /// East, north, up from the base, m; `null` in a gap or outside the solution.
    pub enu_m: Option<[f64; 3]>,
    /// Latitude and longitude in degrees and ellipsoidal height in metres.
    pub llh: Option<[f64; 3]>,
    /// RTKLIB's quality number of the worse neighbour.
    pub quality: Option<u8>,
}

/// The answer of a run.
#[must_use]
pub fn answer(run: &Positioning, options: &PpkOptions) -> PpkAnswer {
    let solution = &run.solution;
    let summary = &solution.summary;
    let frame = solution.base_position_ecef_m.map(EnuFrame::from_ecef);
    let base = solution.base_position_ecef_m.map(|ecef_m| {
        let place = geodetic_from_ecef(ecef_m);
        BaseAnswer {
            source: match options.base_position {
                BasePosition::Ecef(_) => "given",
                BasePosition::Header => "header",
                BasePosition::AverageSingle => "average",
            },
            ecef_m,
            latitude_deg: place.latitude_deg(),
            longitude_deg: place.longitude_deg(),
            height_m: place.height_m,
        }
    });
    let ends = solution.epochs.first().zip(solution.epochs.last());
    let events = solution.events.iter().map(|event| EventAnswer {
        time_gpst: event.time.format_calendar(9),
        kind: match event.event.kind {
            EventKind::External => "external",
            EventKind::RisingEdge => "rising",
            EventKind::FallingEdge => "falling",
        },
        enu_m: frame
            .zip(event.position_ecef_m)
            .map(|(frame, p)| frame.enu_from_ecef(p)),
        llh: event.position_ecef_m.map(|p| {
            let place = geodetic_from_ecef(p);
            [place.latitude_deg(), place.longitude_deg(), place.height_m]
        }),
        quality: event.quality.map(Quality::number),
    });
    PpkAnswer {
        version: env!("CARGO_PKG_VERSION"),
        files: files(run),
        base,
        span_gpst: ends.map(|(a, b)| [a.time.to_string(), b.time.to_string()]),
        epochs: summary.rover_epochs,
        fixed: summary.fixed,
        float: summary.float,
        other: summary.other,
        lost: solution.lost.len(),
        fixed_percent: percent(summary.fixed, summary.rover_epochs),
        not_fixed: summary
            .not_fixed
            .iter()
            .map(|&(reason, epochs)| ReasonAnswer {
                reason: reason.to_owned(),
                epochs,
            })
            .collect(),
        glonass: summary.glonass.map(|decision| decision.to_string()),
        age_s: summary.age_s,
        fixed_sd_m: median_deviation_m(run),
        baseline: baseline(run),
        events: events.collect(),
        warnings: run.warnings.clone(),
    }
}

fn files(run: &Positioning) -> Vec<FileAnswer> {
    run.files
        .iter()
        .map(|(path, report)| FileAnswer {
            file: path.display().to_string(),
            format: report.format.clone(),
            dropped: report
                .dropped
                .iter()
                .map(|d| DropAnswer {
                    reason: d.reason.to_string(),
                    count: d.count,
                    first: d.first.to_string(),
                })
                .collect(),
        })
        .collect()
}

fn percent(part: usize, whole: usize) -> f64 {
    if whole == 0 {
        0.0
    } else {
        100.0 * part as f64 / whole as f64
    }
}

fn baseline(run: &Positioning) -> Option<BaselineAnswer> {
    let epochs = run.solution.epochs.iter();
    let fixed = epochs.filter(|e| e.quality == Quality::Fixed);
    let baselines: Vec<_> = fixed.filter_map(|e| e.baseline).collect();
    let sorted = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values
    };
    let lengths = sorted(baselines.iter().map(Baseline::length_m).collect());
    let at = |share: f64| {
        lengths
            .get((share * lengths.len() as f64) as usize)
            .copied()
    };
    let attitudes = baselines.iter().filter_map(Baseline::attitude);
    let sigmas = sorted(
        attitudes
            .map(|a| a.heading_sigma_rad.to_degrees())
            .collect(),
    );
    Some(BaselineAnswer {
        length_m: at(0.5)?,
        length_range_m: [at(0.05)?, at(0.95)?],
        heading_sd_deg: sigmas.get(sigmas.len() / 2).copied(),
    })
}

fn median_deviation_m(run: &Positioning) -> Option<[f64; 3]> {
    let mut by_axis: [Vec<f64>; 3] = Default::default();
    for epoch in run
        .solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed)
    {
        let here = EnuFrame::from_ecef(epoch.position_ecef_m);
        let covariance = here.enu_covariance_from_ecef(&epoch.relative_covariance_ecef_m2());
        for (i, values) in by_axis.iter_mut().enumerate() {
            values.push(covariance[i][i].max(0.0).sqrt());
        }
    }
    if by_axis[0].is_empty() {
        return None;
    }
    Some(by_axis.map(|mut values| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }))
}

impl PpkAnswer {
    /// The answer as a few lines of text.
    #[must_use]
    pub fn text(&self, input: &PositioningInput) -> String {
        use std::fmt::Write as _;
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "rover       {}", input.rover.display());
        if let Some(base) = &self.base {
            let [x, y, z] = base.ecef_m;
            let _ = writeln!(
                out,
                "base        {:.9}° {:.9}° {:.4} m ({x:.4} {y:.4} {z:.4}), {}",
                base.latitude_deg,
                base.longitude_deg,
                base.height_m,
                match base.source {
                    "header" => "from the file's header",
                    "average" => "mean of its single-point positions",
                    _ => "as given",
                }
            );
        }
        if let Some([from, to]) = &self.span_gpst {
            let _ = writeln!(out, "positions   {from} to {to} GPST");
        }
        let _ = writeln!(
            out,
            "epochs      {}: {} fixed ({:.1} %), {} float, {} other, {} without a position",
            self.epochs, self.fixed, self.fixed_percent, self.float, self.other, self.lost
        );
        for reason in &self.not_fixed {
            let _ = writeln!(out, "  not fixed {:>6}  {}", reason.epochs, reason.reason);
        }
        if let Some(glonass) = &self.glonass {
            let _ = writeln!(out, "GLONASS     {glonass}");
        }
        if let Some([e, n, u]) = self.fixed_sd_m {
            let _ = writeln!(
                out,
                "fixed ±1σ   {e:.4} {n:.4} {u:.4} m east, north, up (median)"
            );
        }
        if let Some(baseline) = &self.baseline {
            let [low, high] = baseline.length_range_m;
            let _ = write!(
                out,
                "baseline    {:.4} m long ({low:.4} to {high:.4} m at 90 % of the fixed epochs)",
                baseline.length_m
            );
            let _ = match baseline.heading_sd_deg {
                Some(deg) => writeln!(out, ", heading ±1σ {deg:.3}°"),
                None => writeln!(out),
            };
        }
        if let Some([least, mean, most]) = self.age_s {
            let _ = writeln!(
                out,
                "base age    {least:.2} to {most:.2} s, mean {mean:.2} s"
            );
        }
        if !self.events.is_empty() {
            let placed = self.events.iter().filter(|e| e.llh.is_some()).count();
            let _ = writeln!(
                out,
                "events      {}, {placed} with a position",
                self.events.len()
            );
        }
        out
    }
}
