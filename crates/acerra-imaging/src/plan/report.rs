//! What a plan decided, why, and what its self-check found.

use super::options::{Engine, SelfCheck};
use crate::kernel::level::SimdLevel;
use serde::Serialize;
use std::fmt;

/// The operator that a plan evaluates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OperatorKind {
    /// From spectra to an image, Eq. (3).
    Imaging,
    /// From an image to spectra, Eq. (1).
    Forward,
}

/// Decisions, cost, accuracy and memory of a plan. `Display` writes them as lines of text.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PlanReport {
    /// The operator planned.
    pub operator: OperatorKind,
    /// Pixels in a row.
    pub columns: usize,
    /// Rows of pixels.
    pub rows: usize,
    /// Whether each pixel has a height of its own.
    pub is_uneven: bool,
    /// Pulses.
    pub pulses: usize,
    /// Frequencies of each pulse.
    pub frequencies: usize,
    /// Relative L2 error allowed.
    pub accuracy: f64,
    /// The engine chosen.
    pub engine: Engine,
    /// Decisions in the order in which they were made.
    pub decisions: Vec<Decision>,
    /// Result of the self-check; `None` where the double-precision sum is run.
    pub self_check: Option<SelfCheck>,
    /// Bytes of range tables, bins and coarse images.
    pub working_bytes: u64,
    /// Bytes of the result: the image, or the spectra.
    pub output_bytes: u64,
}

impl PlanReport {
    /// Pixel × pulse contributions.
    #[must_use]
    pub fn contributions(&self) -> u64 {
        (self.columns as u64)
            .saturating_mul(self.rows as u64)
            .saturating_mul(self.pulses as u64)
    }
}

/// A decision of the planner.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "decision")]
#[non_exhaustive]
pub enum Decision {
    /// The options ask for the double-precision sum.
    ReferenceRequested,
    /// Level planes below level ground: refracted delays are a function of distance for each pulse and plane, and so
    /// part of the range tables.
    LevelGround,
    /// A level plane below uneven ground: rays are traced to the corners of squares of pixels.
    UnevenRays,
    /// Patterns of antennas apart, these over ground, uneven ground or pixels at different depths: every pixel has rays of its own,
    /// in double precision.
    RaysOfPixels,
    /// The accuracy is below what single precision can keep.
    BelowSinglePrecision {
        /// Accuracy asked for.
        accuracy: f64,
    },
    /// Uneven ground that the factorized engine does not take: its kinks are too sharp for coarse grids, or the
    /// operator is the forward one.
    UnevenGround,
    /// The factorized engine is not sufficiently cheaper.
    DirectIsCheaper {
        /// Estimated vector operations a contribution of the factorized engine.
        factorized_cost: f64,
        /// Those of the direct engine.
        direct_cost: f64,
    },
    /// The direct engine is done before the factorized one is even planned.
    FewContributions {
        /// Vector operations that the direct engine takes.
        direct_operations: f64,
    },
    /// What a finer plan of the factorized engine saves beside the direct one is less than it takes to make.
    LittleSaved {
        /// Vector operations that it saves.
        saved_operations: f64,
    },
    /// Not even a sub-aperture of the factorized engine fits in the memory allowed.
    FactorizedTooLarge {
        /// Bytes of its tables and coarse images.
        bytes: u64,
    },
    /// A direct engine was built and checked.
    Direct(DirectChoice),
    /// A factorized engine was built and checked.
    Factorized(FactorizedChoice),
    /// An engine in double precision was built and checked.
    Double(DoubleChoice),
    /// The double-precision sum over frequencies itself: a forward operator, uneven frequencies, tables that the
    /// memory allowed does not hold, or an accuracy that an image in single precision rounds away.
    NoDoubleTables,
    /// Memory does not hold the tables of all pulses: every run builds and drops them batch by batch.
    Batches {
        /// Number of batches.
        batches: usize,
    },
    /// The plan serves some slices of a volume; others have plans of their own.
    Slices {
        /// The first slice, from 0.
        from: usize,
        /// The one after the last.
        to: usize,
        /// Slices of the volume.
        of: usize,
    },
    /// The self-check of the engine before found too large an error.
    Rejected {
        /// Relative error found.
        error: f64,
    },
    /// No engine in single precision keeps the accuracy on these data.
    SinglePrecisionExhausted {
        /// Least relative error reached.
        reached: f64,
    },
}

/// Parameters of a direct engine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DirectChoice {
    /// Instruction set.
    pub level: SimdLevel,
    /// Width of a range bin, m.
    pub bin_m: f64,
    /// Range bins in a period c/(2Δf); `None` for uneven frequencies.
    pub bins_per_period: Option<usize>,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Two-way carrier phase advance per range bin, rad.
    pub carrier_rad_per_bin: f64,
    /// Pixels along the row and across that share an expansion of the range.
    pub group: [usize; 2],
    /// Whether the range over a group is expanded to third order instead of second.
    pub cubic: bool,
    /// Estimated vector operations a pixel.
    pub cost: f64,
    /// Paths that the vectors of the self-check took.
    pub paths: Option<PathShares>,
}

/// Parameters of an engine in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DoubleChoice {
    /// Instruction set.
    pub level: SimdLevel,
    /// Width of a range bin, m.
    pub bin_m: f64,
    /// Range bins in a period c/(2Δf).
    pub bins_per_period: Option<usize>,
    /// Degree of the polynomials.
    pub degree: usize,
}

/// Shares of vectors by the way in which their range bins are read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathShares {
    /// From windows in registers.
    pub windowed: f64,
    /// By gathers.
    pub gathered: f64,
    /// Next to an antenna, in double precision.
    pub reference: f64,
}

/// Parameters of a factorized engine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FactorizedChoice {
    /// Instruction set.
    pub level: SimdLevel,
    /// Pulses of the segment of the aperture that is partitioned so.
    pub pulses: usize,
    /// Pulses in a sub-aperture.
    pub sub_aperture_pulses: usize,
    /// Fine pixels per coarse interval, along the row and across.
    pub coarse: [f64; 2],
    /// Samples from which a pixel is interpolated, in either direction.
    pub taps: usize,
    /// Bound of the spatial frequencies along the row and across, cycles/m.
    pub bandwidth_per_m: [f64; 2],
    /// Shorter sub-apertures that those are merged from on their coarse grids; `None` where the range tables are
    /// summed on these.
    pub merged_from: Option<ShorterChoice>,
    /// Interpolation error expected.
    pub interpolation_error: f64,
    /// Width of a range bin, m.
    pub bin_m: f64,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Estimated vector operations a contribution.
    pub cost: f64,
    /// Those of the direct engine.
    pub direct_cost: f64,
}

/// Sub-apertures that longer ones are merged from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ShorterChoice {
    /// Pulses in a sub-aperture.
    pub sub_aperture_pulses: usize,
    /// Fine pixels per coarse interval, along the row and across.
    pub coarse: [f64; 2],
    /// Samples from which one of the longer sub-aperture's grid is interpolated, in either direction.
    pub taps: usize,
    /// Bound of the spatial frequencies along the row and across, cycles/m.
    pub bandwidth_per_m: [f64; 2],
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ReferenceRequested => write!(f, "the reference was asked for"),
            Self::LevelGround => write!(
                f,
                "below level ground: refracted delays are part of the range tables of the direct engine"
            ),
            Self::UnevenRays => write!(
                f,
                "below uneven ground: rays to the corners of squares of pixels are followed from pulse to pulse"
            ),
            Self::RaysOfPixels => write!(
                f,
                "every pixel has rays of its own: double precision is taken"
            ),
            Self::BelowSinglePrecision { accuracy } => write!(
                f,
                "single precision cannot promise {accuracy:.1e}: double precision is taken"
            ),
            Self::UnevenGround => write!(
                f,
                "a surface that coarse grids cannot follow: every pulse at every pixel, by the direct engine"
            ),
            Self::FewContributions { direct_operations } => write!(
                f,
                "factorized: planning it takes longer than the direct engine's {:.1} million vector \
                 operations",
                direct_operations * 1e-6
            ),
            Self::LittleSaved { saved_operations } => write!(
                f,
                "factorized: a finer plan takes longer to make than the {:.1} million vector operations \
                 that it saves",
                saved_operations * 1e-6
            ),
            Self::DirectIsCheaper {
                factorized_cost,
                direct_cost,
            } => write!(
                f,
                "factorized: {factorized_cost:.2} vector operations a contribution estimated, direct \
                 {direct_cost:.2}"
            ),
            Self::FactorizedTooLarge { bytes } => write!(
                f,
                "factorized: {:.1} MB are more than the memory allowed",
                *bytes as f64 * 1e-6
            ),
            Self::Direct(choice) => choice.fmt(f),
            Self::Factorized(choice) => choice.fmt(f),
            Self::Double(choice) => choice.fmt(f),
            Self::NoDoubleTables => write!(f, "the sum over frequencies itself is run"),
            Self::Batches { batches } => write!(
                f,
                "tables of all pulses exceed the memory allowed: built anew in {batches} batches of \
                 pulses by every run"
            ),
            Self::Slices { from, to, of } => {
                write!(f, "for slices {} to {to} of {of}", from + 1)
            }
            Self::Rejected { error } => {
                write!(f, "its self-check found {error:.2e}: a finer plan is tried")
            }
            Self::SinglePrecisionExhausted { reached } => write!(
                f,
                "single precision reached {reached:.2e} here: double precision is taken"
            ),
        }
    }
}

impl fmt::Display for DirectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "direct, {}: range bins of {:.2} mm (",
            self.level,
            self.bin_m * 1e3
        )?;
        match self.bins_per_period {
            Some(length) => write!(f, "{length} a period")?,
            None => write!(f, "uneven frequencies")?,
        }
        write!(
            f,
            "), polynomials of degree {}, carrier {:.2} rad a bin, range {} over {} × {} \
             pixels; {:.1} vector operations a pixel estimated",
            self.degree,
            self.carrier_rad_per_bin,
            if self.cubic { "cubic" } else { "quadratic" },
            self.group[0],
            self.group[1],
            self.cost,
        )?;
        let Some(paths) = self.paths else {
            return Ok(());
        };
        write!(
            f,
            "; {:.1} % of vectors from register windows, {:.1} % by gathers, {:.1} % next to an \
             antenna in double precision",
            100.0 * paths.windowed,
            100.0 * paths.gathered,
            100.0 * paths.reference,
        )
    }
}

impl fmt::Display for DoubleChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "double precision, {}: range bins of {:.2} mm, polynomials of degree {}",
            self.level,
            self.bin_m * 1e3,
            self.degree,
        )
    }
}

/// To hundredths, so that whole numbers are written without a fraction.
fn rounded(x: f64) -> f64 {
    (100.0 * x).round() / 100.0
}

impl fmt::Display for FactorizedChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "factorized, {}: {} pulses in sub-apertures of {} on grids of {} × {} pixels (spatial \
             frequencies up to {:.2} and {:.2} cycles a metre)",
            self.level,
            self.pulses,
            self.sub_aperture_pulses,
            rounded(self.coarse[0]),
            rounded(self.coarse[1]),
            self.bandwidth_per_m[0],
            self.bandwidth_per_m[1],
        )?;
        if let Some(shorter) = self.merged_from {
            write!(
                f,
                ", merged from sub-apertures of {} on grids of {} × {} pixels ({:.2} and {:.2} cycles a metre)",
                shorter.sub_aperture_pulses,
                rounded(shorter.coarse[0]),
                rounded(shorter.coarse[1]),
                shorter.bandwidth_per_m[0],
                shorter.bandwidth_per_m[1],
            )?;
        }
        write!(
            f,
            ", interpolation error {:.1e}; range bins of {:.2} mm, degree {}; {:.2} vector operations a \
             contribution estimated, {:.2} for the direct engine",
            self.interpolation_error,
            self.bin_m * 1e3,
            self.degree,
            self.cost,
            self.direct_cost,
        )
    }
}

impl fmt::Display for PlanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.operator == OperatorKind::Forward {
            write!(f, "forward: ")?;
        }
        writeln!(
            f,
            "{} × {} pixels{}, {} pulses of {} frequencies: {:.4} Gbp, relative error ≤ {:.1e} asked",
            self.columns,
            self.rows,
            if self.is_uneven { " of a surface" } else { "" },
            self.pulses,
            self.frequencies,
            self.contributions() as f64 * 1e-9,
            self.accuracy,
        )?;
        for decision in &self.decisions {
            writeln!(f, "{decision}")?;
        }
        if let Some(check) = self.self_check {
            writeln!(
                f,
                "self-check on {} random pixels: relative error {:.2e}",
                check.pixels, check.error
            )?;
        }
        let (working_mb, output_mb) = (
            self.working_bytes as f64 * 1e-6,
            self.output_bytes as f64 * 1e-6,
        );
        match self.operator {
            OperatorKind::Imaging => write!(
                f,
                "memory: {working_mb:.1} MB tables and coarse images, {output_mb:.1} MB image"
            ),
            OperatorKind::Forward => write!(
                f,
                "memory: {working_mb:.1} MB bins and coarse images, {output_mb:.1} MB spectra"
            ),
        }
    }
}
