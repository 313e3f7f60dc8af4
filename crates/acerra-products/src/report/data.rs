//! Data of a report.

use acerra_chain::focus::inversion::InversionRecord;
use acerra_chain::journal::stages::Stage;
use acerra_chain::read::inputs::InputFile;
use acerra_figure::{Drawing, FigureError};
use acerra_geo::trajectory::SolutionStatus;
use std::fmt;

use crate::surveyed::SurveyRecord;

/// Data of the report of one focused campaign. Empty parts are left out of the page.
#[derive(Clone, Debug, Default)]
pub struct ReportData {
    /// Heading and window title.
    pub title: String,
    /// Summary in a sentence or two; may be empty.
    pub summary: String,
    /// Version of the program.
    pub version: String,
    /// The numbers that matter most, shown large.
    pub facts: Vec<Fact>,
    /// Independent findings about the run, each with its verdict.
    pub evidence: Vec<EvidenceRow>,
    /// Settings that no data check: name, and the effect of an error.
    pub unchecked: Vec<[String; 2]>,
    /// Warnings about the result, one sentence each.
    pub warnings: Vec<String>,
    /// Harmless omissions, one sentence each.
    pub notes: Vec<String>,
    /// The focused image.
    pub image: Option<Picture>,
    /// Solution for the scene, where the image is not the adjoint.
    pub inversion: Option<InversionRecord>,
    /// Targets, strongest first, numbered from 1 in this order.
    pub targets: Vec<TargetRow>,
    /// Surveyed points, and the target nearest to each.
    pub surveyed: Vec<SurveyRecord>,
    /// Explanations of the places of the targets, one paragraph each.
    pub remarks: Vec<String>,
    /// The radargram as recorded.
    pub radargram_raw: Option<Picture>,
    /// The radargram that went into the image.
    pub radargram_clean: Option<Picture>,
    /// Further pictures of evidence, in this order.
    pub pictures: Vec<Picture>,
    /// Inputs of the image, track by track.
    pub tracks: Vec<TrackEvidence>,
    /// Results of the automatic choices: offsets, counts.
    pub choices: Vec<Fact>,
    /// Computation of the image, a line for each part of the plan.
    pub plan: Vec<Fact>,
    /// Input files.
    pub inputs: Vec<InputFile>,
    /// Cost of the stages.
    pub stages: Vec<Stage>,
    /// The fully resolved configuration, as text.
    pub configuration: String,
}

/// One independent finding about a run: value, expected value, and conclusion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EvidenceRow {
    /// Quantity examined.
    pub name: String,
    /// The value found; none where it is not a number.
    pub value: Option<f64>,
    /// The value expected.
    pub expected: Option<f64>,
    /// Standard deviation of `value - expected`.
    pub sigma: Option<f64>,
    /// Unit of all three; may be empty.
    pub unit: String,
    /// Conclusion.
    pub verdict: Verdict,
    /// Derivation of the value, and the remedy where the value does not agree.
    pub explanation: String,
}

/// Whether a finding agrees with the settings and the other data of its run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// Within what is expected.
    #[default]
    Agrees,
    /// Unlikely, but possible.
    Doubtful,
    /// Not possible if everything else is right.
    Contradicts,
}

impl Verdict {
    /// Word of the verdict in `run.json`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Doubtful => "doubtful",
            Self::Contradicts => "contradicts",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A named value with its unit, and a note on how to read it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fact {
    /// Value found.
    pub name: String,
    /// The value as shown, with its unit.
    pub value: String,
    /// A remark in small print; may be empty.
    pub note: String,
}

impl Fact {
    /// A fact without a remark.
    #[must_use]
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
            note: String::new(),
        }
    }

    /// This fact with a remark.
    #[must_use]
    pub fn note(self, note: impl Into<String>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }
}

/// A finished figure: a PNG, and its representation in a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// The bytes of the PNG.
    pub png: Vec<u8>,
    /// The same figure as SVG, in which text follows the reader's theme; pages show the PNG where this is
    /// empty.
    pub wide_svg: String,
    /// The figure laid out for a telephone, as SVG.
    pub narrow_svg: String,
    /// Description for readers who cannot see the figure.
    pub alt: String,
    /// Explanation under the picture.
    pub caption: String,
}

/// Greatest widths of a figure in CSS pixels: of a desk's screen and print, and of a telephone.
const FIGURE_WIDTHS_PX: [f32; 2] = [860.0, 360.0];

impl Picture {
    /// The figure that `draw` lays out for a greatest width in CSS pixels.
    ///
    /// # Errors
    /// Errors of `draw`; a picture too large for memory.
    pub fn drawn(
        mut draw: impl FnMut(f32) -> Result<Drawing, FigureError>,
        alt: &str,
        caption: impl Into<String>,
    ) -> Result<Self, FigureError> {
        let [wide, narrow] = FIGURE_WIDTHS_PX;
        let (wide, narrow) = (draw(wide)?.described(alt), draw(narrow)?.described(alt));
        let (png, (wide_svg, narrow_svg)) = rayon::join(
            || wide.to_png(),
            || rayon::join(|| wide.to_svg(), || narrow.to_svg()),
        );
        Ok(Self {
            png: png?,
            wide_svg,
            narrow_svg,
            alt: alt.to_owned(),
            caption: caption.into(),
        })
    }
}

/// Widths of a response in one direction, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Widths {
    /// Rayleigh: peak to first minimum (mean of both sides).
    pub rayleigh_m: Option<f64>,
    /// Full width at −3 dB.
    pub width_3db_m: Option<f64>,
    /// Full width at −6 dB.
    pub width_6db_m: Option<f64>,
    /// Peak to first minimum towards the track.
    pub inner_m: Option<f64>,
    /// Peak to first minimum away from the track.
    pub outer_m: Option<f64>,
}

/// One target as measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetRow {
    /// Position east or along x, in metres.
    pub x_m: f64,
    /// Position north or along y, in metres.
    pub y_m: f64,
    /// Height of the image plane there, in metres.
    pub z_m: f64,
    /// Depth below the surface of the ground and its standard deviation, in metres, for a target below the
    /// surface.
    pub depth_m: Option<[f64; 2]>,
    /// Whether a target below the surface is stronger than the clutter at its depth.
    pub exceeds_clutter: Option<bool>,
    /// Level relative to the image's maximum, in dB.
    pub level_db: f64,
    /// Widths along the track.
    pub along: Widths,
    /// Widths across the track.
    pub across: Widths,
    /// Peak sidelobe ratio in dB.
    pub pslr_db: Option<f64>,
    /// Integrated sidelobe ratio in dB.
    pub islr_db: Option<f64>,
    /// The left–right ghost, if any.
    pub ghost: Option<GhostRow>,
    /// Cuts through the peak.
    pub cuts: Option<CutLevels>,
}

/// The left–right ghost of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GhostRow {
    /// Amplitude relative to its target.
    pub level: f64,
    /// Position along x, in metres.
    pub x_m: f64,
    /// Position along y, in metres.
    pub y_m: f64,
}

/// The two cuts through a peak.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutLevels {
    /// Along the local track, forwards.
    pub along: Cut,
    /// Across it, to the left.
    pub across: Cut,
}

/// Levels along one cut, in dB of the peak; lists of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// Distances from the peak in metres.
    pub distance_m: Vec<f64>,
    /// Levels of the image.
    pub image_db: Vec<f64>,
    /// Levels of an ideal point there, by Eq. (5); may be empty.
    pub theory_db: Vec<f64>,
}

/// Results for one track.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackEvidence {
    /// Name; empty where the campaign has only one.
    pub name: String,
    /// The trajectory at the traces.
    pub trajectory: Option<TrajectoryEvidence>,
    /// Search of the time offset between radar and trajectory.
    pub alignment: Option<AlignmentEvidence>,
    /// The surface echo against the height.
    pub surface: Option<SurfaceEvidence>,
}

/// The trajectory; all lists have one value per fix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajectoryEvidence {
    /// Times in seconds, rising.
    pub time_s: Vec<f64>,
    /// Positions (x east, y north, z up) in metres, in the image's frame.
    pub position_m: Vec<[f64; 3]>,
    /// Standard deviations (east, north, up) in metres; empty where unknown.
    pub sigma_m: Vec<[f64; 3]>,
    /// Solution status.
    pub status: Vec<SolutionStatus>,
    /// Height of the image plane, in metres.
    pub plane_z_m: f64,
    /// Positions with which a line begins, other than the first: between lines nothing was measured.
    pub line_starts: Vec<usize>,
    /// Whether the traces have no times: `time_s` counts them.
    pub is_untimed: bool,
    /// The stretch of time whose traces went into the image.
    pub used_s: Option<[f64; 2]>,
}

/// Search of the time offset: the agreement over the offsets tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AlignmentEvidence {
    /// Offsets tried, in seconds.
    pub offset_s: Vec<f64>,
    /// Agreement at each, larger is better.
    pub score: Vec<f64>,
    /// The offset taken, in seconds.
    pub chosen_s: f64,
    /// Meaning of the score.
    pub score_name: String,
    /// Confidence of the choice, in words and numbers.
    pub remark: String,
}

/// The surface echo as picked in the radargram against 2h/c from the trajectory; one value per
/// trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceEvidence {
    /// Times of the traces in seconds.
    pub time_s: Vec<f64>,
    /// Range of the picked echo in metres, after zero-timing; NaN where none was picked.
    pub picked_range_m: Vec<f64>,
    /// Height above the surface from the trajectory, in metres.
    pub height_m: Vec<f64>,
    /// The shift applied to fast time, in nanoseconds.
    pub shift_ns: f64,
    /// Explanation of the difference.
    pub remark: String,
}
