//! The page of a positioning run: where the rover was, how well that is known, and why not better.

use super::data::Fact;
use super::evidence::colour;
use super::numbers::{fixed, quantile};
use super::page::{self, document};
use super::provenance;
use crate::figure::{
    Axis, Colour, Drawing, FigureError, LinePlot, ReferenceLine, Series, Timeline, TimelineRow,
};
use crate::products::inputs::InputFile;
use acerra_geo::geodesy::{EnuFrame, geodetic_from_ecef};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::SolutionStatus;
use acerra_gnss::{PpkSolution, Quality, SatelliteId, Solution};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What the page of a positioning run is made from.
#[derive(Clone, Debug)]
pub struct PpkReport<'a> {
    /// Heading and window title.
    pub title: String,
    /// Version of the program.
    pub version: String,
    /// The run.
    pub solution: &'a PpkSolution,
    /// Further remarks, from the readers; those of the run are shown without being given here.
    pub warnings: Vec<String>,
    /// Input files.
    pub inputs: Vec<InputFile>,
    /// The options in force, as text.
    pub configuration: String,
}

/// Writes the page of a positioning run as a complete HTML page: trajectory, status over time,
/// height with ±1σ, satellites, residuals, and the reasons of epochs that are not fixed.
///
/// # Errors
/// [`FigureError`] where a figure cannot be drawn.
pub fn ppk_page(report: &PpkReport<'_>) -> Result<String, FigureError> {
    let run = Run::new(report.solution);
    let mut warnings: Vec<String> = report
        .solution
        .summary
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect();
    warnings.extend(report.warnings.iter().cloned());

    let mut body = String::new();
    page::heading(
        &mut body,
        &report.title,
        "",
        &report.version,
        warnings.len(),
    );
    body.push_str("<section id=\"result\">\n<h2>Result</h2>\n");
    page::tiles(&mut body, &run.facts());
    if run.is_empty() {
        body.push_str("<p class=\"muted\">No epoch has a position.</p>\n");
    } else {
        page::drawing(&mut body, &run.plan()?, &run.plan_caption());
        page::drawing(&mut body, &run.timeline()?, "Quality over time.");
    }
    not_fixed(&mut body, report.solution);
    body.push_str("</section>\n");
    page::warnings(&mut body, &warnings);
    if !run.is_empty() {
        body.push_str("<section id=\"evidence\">\n<h2>Evidence</h2>\n<h3>Height</h3>\n");
        page::drawing(
            &mut body,
            &run.height()?,
            "Ellipsoidal height, with one standard deviation.",
        );
        body.push_str("<h3>Ambiguities and satellites</h3>\n");
        page::drawing(
            &mut body,
            &run.ratio()?,
            "Ratio of the second-best to the best set of integers.",
        );
        page::drawing(&mut body, &run.satellite_count()?, "Satellites used.");
        body.push_str("<h3>Residuals</h3>\n");
        let satellites = run.satellites();
        page::drawing(
            &mut body,
            &run.residuals(&satellites)?,
            "Double-difference phase residuals after the update, one colour per satellite (cyclic).",
        );
        satellite_table(&mut body, &satellites);
        events(&mut body, report.solution, &run.frame);
        body.push_str("</section>\n");
    }
    body.push_str("<section id=\"provenance\">\n<h2>How it was made</h2>\n");
    provenance::inputs(&mut body, &report.inputs);
    provenance::configuration(&mut body, &report.configuration);
    body.push_str("</section>\n");
    Ok(document(&report.title, &body))
}

fn status(quality: Quality) -> SolutionStatus {
    SolutionStatus::from_rtklib_q(u32::from(quality.number()))
}

/// The run in local axes.
struct Run<'a> {
    solution: &'a PpkSolution,
    frame: EnuFrame,
    start: GpsTime,
    time_s: Vec<f64>,
    enu_m: Vec<[f64; 3]>,
    sigma_m: Vec<[f64; 3]>,
}

/// What one satellite contributed.
struct SatelliteStory {
    satellite: SatelliteId,
    time_s: Vec<f64>,
    phase_mm: Vec<f64>,
    code_m: Vec<f64>,
    epochs: usize,
    fixed: usize,
    slips: usize,
    elevation_deg: [f64; 2],
}

impl<'a> Run<'a> {
    fn new(solution: &'a PpkSolution) -> Self {
        let first = solution.epochs.first();
        let origin = solution
            .base_position_ecef_m
            .or_else(|| first.map(|s| s.position_ecef_m))
            .unwrap_or([6_378_137.0, 0.0, 0.0]);
        let frame = EnuFrame::from_ecef(origin);
        let start = first.map_or(GpsTime::EPOCH, |s| s.time);
        let of = |s: &Solution| {
            let covariance = frame.enu_covariance_from_ecef(&s.covariance_ecef_m2);
            [0, 1, 2].map(|i| covariance[i][i].max(0.0).sqrt())
        };
        Self {
            solution,
            frame,
            start,
            time_s: solution
                .epochs
                .iter()
                .map(|s| s.time.seconds_since(start))
                .collect(),
            enu_m: solution
                .epochs
                .iter()
                .map(|s| frame.enu_from_ecef(s.position_ecef_m))
                .collect(),
            sigma_m: solution.epochs.iter().map(of).collect(),
        }
    }

    fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    fn time_axis(&self) -> Axis {
        Axis::new(
            format!("time since {} GPST", self.start.format_calendar(0)),
            "s",
        )
    }

    fn facts(&self) -> Vec<Fact> {
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

    fn plan_caption(&self) -> String {
        let place = self.frame.origin();
        let whose = if self.solution.base_position_ecef_m.is_some() {
            "the base"
        } else {
            "the first fix"
        };
        format!(
            "The track from above, from {whose} at {}°, {}°, {} m.",
            fixed(place.latitude_deg(), 8),
            fixed(place.longitude_deg(), 8),
            fixed(place.height_m, 3)
        )
    }

    /// Values where the quality is `wanted`, NaN elsewhere: one broken series per quality.
    fn only(&self, wanted: Quality, value: impl Fn(usize) -> f64) -> Vec<f64> {
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
    fn qualities(&self) -> Vec<Quality> {
        let mut found: Vec<Quality> = self.solution.epochs.iter().map(|s| s.quality).collect();
        found.sort_unstable();
        found.dedup();
        found.reverse();
        found
    }

    fn plan(&self) -> Result<Drawing, FigureError> {
        let qualities = self.qualities();
        let series: Vec<_> = qualities
            .iter()
            .map(|q| {
                (
                    *q,
                    self.only(*q, |i| self.enu_m[i][0]),
                    self.only(*q, |i| self.enu_m[i][1]),
                )
            })
            .collect();
        let mut plot = LinePlot::new("", Axis::new("east", "m"), Axis::new("north", "m"))
            .equal()
            .height(460.0);
        for (quality, x, y) in &series {
            let dots = Series::dots(status(*quality).name(), x, y);
            plot = plot.with(dots.colour(colour(status(*quality))));
        }
        plot.draw()
    }

    fn timeline(&self) -> Result<Drawing, FigureError> {
        let mut qualities = self.qualities();
        qualities.reverse();
        let usual = quantile(self.time_s.windows(2).map(|w| w[1] - w[0]), 0.5)
            .filter(|step| *step > 0.0)
            .unwrap_or(1.0);
        let mut rows: Vec<TimelineRow> = Vec::new();
        let row = |label: String, colour, times: &mut dyn Iterator<Item = f64>| {
            let mut stretches: Vec<[f64; 2]> = Vec::new();
            for t in times {
                match stretches.last_mut() {
                    Some(last) if t <= last[1] + 0.5 * usual => last[1] = t + usual,
                    _ => stretches.push([t, t + usual]),
                }
            }
            TimelineRow {
                label,
                colour,
                stretches,
            }
        };
        for quality in qualities {
            let mut times = (0..self.time_s.len())
                .filter(|i| self.solution.epochs[*i].quality == quality)
                .map(|i| self.time_s[i]);
            let name = status(quality).name().to_owned();
            rows.push(row(name, colour(status(quality)), &mut times));
        }
        if !self.solution.lost.is_empty() {
            let mut times = self
                .solution
                .lost
                .iter()
                .map(|l| l.time.seconds_since(self.start));
            rows.push(row("none".to_owned(), Colour::Series(7), &mut times));
        }
        Timeline {
            title: String::new(),
            x: self.time_axis(),
            rows,
            width_px: 860.0,
        }
        .draw()
    }

    fn height(&self) -> Result<Drawing, FigureError> {
        let heights: Vec<f64> = self
            .solution
            .epochs
            .iter()
            .map(|s| geodetic_from_ecef(s.position_ecef_m).height_m)
            .collect();
        let sigma: Vec<f64> = self.sigma_m.iter().map(|s| s[2]).collect();
        LinePlot::new("", self.time_axis(), Axis::new("height", "m"))
            .height(240.0)
            .with(Series::line("height ±1σ", &self.time_s, &heights).band(&sigma))
            .draw()
    }

    fn ratio(&self) -> Result<Drawing, FigureError> {
        let ratio: Vec<f64> = self
            .solution
            .epochs
            .iter()
            .map(|s| if s.ratio > 0.0 { s.ratio } else { f64::NAN })
            .collect();
        LinePlot::new("", self.time_axis(), Axis::new("ratio", "").log())
            .height(180.0)
            .with(Series {
                dot_px: 1.4,
                ..Series::dots("", &self.time_s, &ratio)
            })
            .reference(ReferenceLine {
                at_x: false,
                value: 3.0,
                label: "3".to_owned(),
            })
            .draw()
    }

    fn satellite_count(&self) -> Result<Drawing, FigureError> {
        let count: Vec<f64> = self
            .solution
            .epochs
            .iter()
            .map(|s| s.satellites as f64)
            .collect();
        let most = count.iter().copied().fold(0.0, f64::max);
        LinePlot::new(
            "",
            self.time_axis(),
            Axis::new("satellites", "").range(0.0, most + 1.0),
        )
        .height(140.0)
        .with(Series::line("", &self.time_s, &count))
        .draw()
    }

    fn satellites(&self) -> Vec<SatelliteStory> {
        let mut stories: BTreeMap<SatelliteId, SatelliteStory> = BTreeMap::new();
        for (solution, time_s) in self.solution.epochs.iter().zip(&self.time_s) {
            for residual in solution.residuals.iter().filter(|r| r.slot == 0) {
                let satellite = residual.satellite;
                let story = stories.entry(satellite).or_insert_with(|| SatelliteStory {
                    satellite,
                    time_s: Vec::new(),
                    phase_mm: Vec::new(),
                    code_m: Vec::new(),
                    epochs: 0,
                    fixed: 0,
                    slips: 0,
                    elevation_deg: [f64::INFINITY, f64::NEG_INFINITY],
                });
                story.epochs += 1;
                story.fixed += usize::from(residual.fixed);
                story.slips += usize::from(residual.slipped);
                let elevation = residual.elevation_rad.to_degrees();
                story.elevation_deg[0] = story.elevation_deg[0].min(elevation);
                story.elevation_deg[1] = story.elevation_deg[1].max(elevation);
                story.time_s.push(*time_s);
                story
                    .phase_mm
                    .push(residual.phase_m.map_or(f64::NAN, |v| v * 1e3));
                story.code_m.extend(residual.code_m);
            }
        }
        stories.into_values().collect()
    }

    fn residuals(&self, satellites: &[SatelliteStory]) -> Result<Drawing, FigureError> {
        let mut plot =
            LinePlot::new("", self.time_axis(), Axis::new("phase residual", "mm")).height(240.0);
        for story in satellites {
            let label = story.satellite.to_string();
            let dots = Series::dots(label, &story.time_s, &story.phase_mm);
            plot = plot.with(Series {
                dot_px: 1.2,
                ..dots
            });
        }
        plot.draw()
    }
}

fn not_fixed(out: &mut String, solution: &PpkSolution) {
    let reasons = &solution.summary.not_fixed;
    if reasons.is_empty() {
        return;
    }
    let rows: Vec<Vec<String>> = reasons
        .iter()
        .map(|(reason, count)| vec![(*reason).to_owned(), count.to_string()])
        .collect();
    page::table(
        out,
        "Why epochs are not fixed.",
        &["reason", "epochs"],
        &rows,
    );
}

fn satellite_table(out: &mut String, satellites: &[SatelliteStory]) {
    let rms = |values: &[f64]| {
        let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = finite.iter().map(|v| v * v).sum::<f64>() / finite.len() as f64;
        (!finite.is_empty()).then(|| mean.sqrt())
    };
    let rows: Vec<Vec<String>> = satellites
        .iter()
        .map(|story| {
            vec![
                story.satellite.to_string(),
                story.epochs.to_string(),
                story.fixed.to_string(),
                story.slips.to_string(),
                format!(
                    "{}–{}",
                    fixed(story.elevation_deg[0], 0),
                    fixed(story.elevation_deg[1], 0)
                ),
                fixed(rms(&story.phase_mm), 1),
                fixed(rms(&story.code_m), 2),
            ]
        })
        .collect();
    page::table(
        out,
        "Satellites: epochs used and fixed, slips, elevation, and root mean square of the \
         double-difference residuals.",
        &[
            "satellite",
            "epochs",
            "fixed",
            "slips",
            "elevation (°)",
            "phase (mm)",
            "code (m)",
        ],
        &rows,
    );
}

fn events(out: &mut String, solution: &PpkSolution, frame: &EnuFrame) {
    if solution.events.is_empty() {
        return;
    }
    let _ = writeln!(out, "<h3>Events</h3>");
    let rows: Vec<Vec<String>> = solution
        .events
        .iter()
        .map(|event| {
            let enu = event.position_ecef_m.map(|p| frame.enu_from_ecef(p));
            let coordinate = |i: usize| fixed(enu.map(|e| e[i]), 3);
            let quality = event.quality.map_or("–", |q| status(q).name());
            vec![
                event.time.format_calendar(6),
                coordinate(0),
                coordinate(1),
                coordinate(2),
                quality.to_owned(),
            ]
        })
        .collect();
    page::table(
        out,
        "Positions at the recorded events.",
        &["time (GPST)", "east (m)", "north (m)", "up (m)", "quality"],
        &rows,
    );
}
