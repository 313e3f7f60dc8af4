//! Differences between imaging and the forward operator in planning.

use super::options::SelfCheck;
use super::report::{DoubleChoice, OperatorKind, PathShares};
use super::request::{Propagation, Request};
use crate::engine::batches::Piece;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::spec::FactorizedSpec;
use crate::error::ImagingError;
use acerra_control::Control;

/// A segment of the aperture: its partition, and the tables of its sub-apertures.
pub(crate) type Segment = Piece<(FactorizedSpec, DirectSpec)>;

/// An engine in double precision that keeps the accuracy.
pub(super) struct DoublePlan<T> {
    pub engine: T,
    pub choice: DoubleChoice,
    pub check: SelfCheck,
    pub bytes: u128,
}

/// Differences between imaging and the forward operator.
pub(crate) trait Operator {
    /// The direct engine.
    type Direct;
    /// The factorized engine.
    type Factorized;
    /// The engine in double precision.
    type Double;
    const KIND: OperatorKind;
    /// Factorized plans that are tried.
    const FACTORIZED_ATTEMPTS: usize;
    /// Share of the accuracy that the self-check may find.
    const ACCEPTED_SHARE: f64;
    /// Whether the direct engine reads windows of bins on coarse grids; otherwise it reads bins lane by lane.
    const WINDOWS: bool;
    /// Whether the factorized engine takes uneven ground.
    const UNEVEN: bool;
    /// Whether the direct engine takes planes below level ground.
    const LEVEL_GROUND: bool;
    /// Whether sub-apertures may be merged from shorter ones.
    const TWO_STAGES: bool;
    /// Whether segments of the aperture may have separate factorized engines.
    const SEGMENTS: bool;
    /// Whether a plan is made for many runs; otherwise planning time counts relative to the time of one run.
    const REPEATED: bool;
    /// The arrays that count against the limit of memory.
    const MEMORY: &'static str;

    /// Power expected at each frequency of the data.
    fn power(request: &Request) -> Vec<f64>;
    /// Parameters of the direct engine in place of imaging's for `accuracy`, with the cost in vector
    /// operations a pixel.
    fn direct_spec(_: &Request, _accuracy: f64, imaging: (DirectSpec, f64)) -> (DirectSpec, f64) {
        imaging
    }
    /// Whether the factorized engine is sufficiently cheaper to be chosen.
    fn factorized_pays(cost: f64, direct_cost: f64) -> bool;
    /// Numbers of pixels of a first self-check, and of a second one where the first is undecided.
    fn check_pixels(request: &Request) -> [usize; 2];
    /// Bytes of the result.
    fn output_bytes(request: &Request) -> u128;
    /// Bytes of a direct engine.
    fn direct_bytes(request: &Request, piece: &Piece<DirectSpec>) -> Result<u128, ImagingError>;
    /// Bytes of a factorized engine.
    fn factorized_bytes(request: &Request, pieces: &[Segment]) -> Result<u128, ImagingError>;
    /// Number of batches of pulses in a run of a direct engine.
    fn direct_batches(_: &Self::Direct) -> usize {
        1
    }
    /// Number of batches of pulses in a run of a factorized engine.
    fn factorized_batches(_: &Self::Factorized) -> usize {
        1
    }
    /// Builds a direct engine.
    fn direct(
        request: &Request,
        piece: Piece<DirectSpec>,
        control: Control,
    ) -> Result<Self::Direct, ImagingError>;
    /// Builds a factorized engine.
    fn factorized(
        request: &Request,
        pieces: &[Segment],
        control: Control,
    ) -> Result<Self::Factorized, ImagingError>;
    /// An engine in double precision that keeps the accuracy; `None` where tables do not suffice.
    fn double(
        request: &Request,
        control: Control,
    ) -> Result<Option<DoublePlan<Self::Double>>, ImagingError>;
    /// Compares a direct engine with the double-precision sum.
    fn check_direct(
        request: &Request,
        direct: &Self::Direct,
        pixels: usize,
        control: Control,
    ) -> Result<(SelfCheck, Option<PathShares>), ImagingError>;
    /// Compares a factorized engine with the double-precision sum.
    fn check_factorized(
        request: &Request,
        factorized: &Self::Factorized,
        pixels: usize,
        control: Control,
    ) -> Result<SelfCheck, ImagingError>;
}

/// Accuracy below which roundings in single precision decide.
const ROUNDINGS_BELOW: f64 = 2e-5;

/// Share of the accuracy that plans aim at; a self-check may find the same share. Over and below uneven ground errors
/// concentrate where the relief is steep, and a sample of pixels misses the largest errors.
pub(super) fn margin(request: &Request) -> f64 {
    let is_uneven = request.grid.is_uneven() || request.propagation() == Propagation::UnevenGround;
    match (is_uneven, request.options.accuracy < ROUNDINGS_BELOW) {
        (false, _) => 1.0,
        (true, false) => 0.75,
        (true, true) => 0.6,
    }
}

/// Largest error bound, including the uncertainty of few pixels, by which a self-check accepts a plan.
pub(super) fn allowed_error<O: Operator>(request: &Request) -> f64 {
    O::ACCEPTED_SHARE * margin(request) * request.options.accuracy
}

/// Multiple of the allowed error above which few pixels reject a plan. Few pixels may miss the bright pixels
/// that dominate the power of an image; since the alternative to a factorized plan is much slower, more
/// pixels are checked below this multiple.
pub(super) const FAR: f64 = 2.0;
pub(super) const AT_ONCE: f64 = 1.0;

/// A self-check of few pixels, and of more where the few leave the verdict open: accepted with their standard
/// error included, or rejected where the error found is too large by a factor `too_far`.
///
/// # Errors
/// The errors of `check`.
pub(super) fn decided<O: Operator>(
    request: &Request,
    too_far: f64,
    mut check: impl FnMut(usize) -> Result<SelfCheck, ImagingError>,
) -> Result<SelfCheck, ImagingError> {
    let allowed = allowed_error::<O>(request);
    let [few, most] = O::check_pixels(request);
    let found = check(few)?;
    if found.error_bound <= allowed || found.error > too_far * allowed || few == most {
        return Ok(found);
    }
    check(most)
}
