//! Stage `focus`: the adjoint of Eq. (3) on the pixels.

pub mod inversion;
pub mod looks;
pub mod memory;
pub mod permittivity;
pub mod plan;
pub(crate) mod rays;
mod reflectivity;
pub mod sink;
pub mod space;
pub mod tiles;
pub mod underground;
pub mod volume;

use std::ops::Range;

use acerra_imaging::{Complex32, ImagingPlan, IncidenceWeight, PlanOptions, Pulses};

use crate::choices::{AntennaAxis, Sum, Values, Weight};
use crate::control::Control;
use crate::echoes::Echoes;
use crate::focus::inversion::options::InversionOptions;
use crate::focus::inversion::record::InversionRecord;
use crate::focus::looks::{LookInput, LookOptions, Multilook, image_looks};
use crate::focus::memory::available_memory_bytes;
use crate::focus::plan::{ImageError, contributions, plan_on, run_plan};
use crate::focus::rays::Rays;
use crate::focus::sink::ImageSink;
use crate::focus::underground::Underground;
use crate::focus::volume::{Projections, image_volume};
use crate::position::aligned::Aligned;
use crate::scene::pixels::Pixels;

/// Parameters of the stage `focus`.
#[derive(Clone, Copy, Debug)]
pub struct FocusOptions {
    /// Relative L2 error allowed against Eq. (3) in double precision.
    pub accuracy: f64,
    /// Weight of each trace.
    pub weight: Weight,
    /// Meaning of the pixels of an image; ignored for a volume, looks and solutions.
    pub values: Values,
    /// Weight by incidence and antenna pattern, for level planes only.
    pub incidence: Option<IncidenceWeight>,
    /// Boresight of the antenna, from which the angle of the pattern counts.
    pub antenna_axis: AntennaAxis,
    /// Sum of several tracks: coherent, or by power.
    pub sum: Sum,
    /// Random pixels on which each plan checks itself against Eq. (3) in double precision.
    pub check_pixels: usize,
    /// Most bytes that tables and image may take; all available memory where `None`.
    pub memory_limit_bytes: Option<u64>,
    /// The adjoint, or the parameters of an inversion.
    pub inversion: InversionOptions,
}

impl Default for FocusOptions {
    fn default() -> Self {
        Self {
            accuracy: 1e-3,
            weight: Weight::Trace,
            values: Values::Sum,
            incidence: None,
            antenna_axis: AntennaAxis::default(),
            sum: Sum::Coherent,
            check_pixels: PlanOptions::default().check_pixels,
            memory_limit_bytes: None,
            inversion: InversionOptions::default(),
        }
    }
}

/// A requested image.
#[derive(Clone, Debug)]
pub struct ImageRequest {
    /// Places of the pixels.
    pub pixels: Pixels,
    /// Options of the stage.
    pub options: FocusOptions,
    /// Looks in addition to the image, each passed to the sink.
    pub looks: Option<LookOptions>,
    /// The pulses to image, counted over all tracks; all by default.
    pub pulses: Option<Range<usize>>,
    /// The ground below whose surface rays are refracted.
    pub underground: Option<Underground>,
}

impl ImageRequest {
    /// An image on these pixels, with the default options and without looks.
    #[must_use]
    pub fn on(pixels: impl Into<Pixels>) -> Self {
        Self {
            pixels: pixels.into(),
            options: FocusOptions::default(),
            looks: None,
            pulses: None,
            underground: None,
        }
    }

    /// This request for a part of the pulses, counted over all tracks.
    #[must_use]
    pub fn of_pulses(self, pulses: Range<usize>) -> Self {
        Self {
            pulses: Some(pulses),
            ..self
        }
    }
}

/// The focused image and its record.
#[derive(Clone, Debug)]
pub struct Focused {
    /// The sum of Eq. (3), row-major `[ny, nx]`, row 0 at the smallest y. For tracks summed by power the
    /// modulus; for a volume the value of greatest modulus along z; for an inversion the reflectivity defined
    /// by [`InversionRecord::meaning`].
    pub image: Vec<Complex32>,
    /// Places of the pixels; for a volume with the heights of the image's values.
    pub pixels: Pixels,
    /// Options of the stage.
    pub options: FocusOptions,
    /// Choices of the planner and their reasons, as text.
    pub plan: String,
    /// Bytes that the plan needs in addition to the input.
    pub promised_bytes: u64,
    /// Relative L2 error that the plan's self-check found on random pixels.
    pub checked_error: Option<f64>,
    /// The mean power of the looks, where looks were asked for.
    pub multilook: Option<Multilook>,
    /// Maximum projections of a volume.
    pub projections: Option<Projections>,
    /// Record of the inversion, if any.
    pub inversion: Option<InversionRecord>,
    /// The ground below whose surface rays were refracted.
    pub underground: Option<Underground>,
}

impl Focused {
    /// East, north and height of the pixel of greatest modulus (m).
    #[must_use]
    pub fn maximum_m(&self) -> [f64; 3] {
        let power = self.image.iter().map(Complex32::norm_sqr).enumerate();
        let greatest = power.max_by(|a, b| a.1.total_cmp(&b.1));
        self.pixels.place_m(greatest.map_or(0, |(k, _)| k))
    }
}

/// Makes an image of echoes whose tracks are the ranges `parts`; looks and volume slices go to the
/// sink.
///
/// # Errors
/// Data that the imaging operators refuse, a sink that is full, cancellation.
pub fn focus(
    echoes: Echoes<'_>,
    parts: &[Range<usize>],
    request: &ImageRequest,
    sink: &mut dyn ImageSink,
    control: &Control<'_>,
) -> Result<Focused, ImageError> {
    let weight = echoes.weights(request.options.weight);
    let pulses = echoes.pulses(&weight).map_err(ImageError::Spectra)?;
    let pulses = looking(pulses, echoes.aligned, request.options.antenna_axis)?;
    let rays = Rays::of(echoes, request.underground.as_ref()).map_err(ImageError::Ground)?;
    let pulses = rays.of_pulses(pulses).map_err(ImageError::Ground)?;
    let (pulses, parts) = match &request.pulses {
        None => (pulses, parts.to_vec()),
        Some(wanted) => {
            let selected = pulses.slice(wanted.clone()).map_err(ImageError::Spectra)?;
            (selected, parts_within(parts, wanted))
        }
    };
    let plan = plan_options(&request.options);
    let pixels = &request.pixels;
    if let Some(volume) = pixels.volume {
        let made = image_volume(pulses, volume, &plan, sink, control)?;
        return Ok(Focused {
            image: made.image,
            pixels: made.pixels,
            options: request.options,
            plan: made.run.report.to_string(),
            promised_bytes: u64::try_from(made.bytes).unwrap_or(u64::MAX),
            checked_error: made.run.checked_error,
            multilook: None,
            projections: Some(made.projections),
            inversion: None,
            underground: request.underground.clone(),
        });
    }
    if request.looks.is_some() && parts.len() > 1 {
        return Err(ImageError::LooksOfTracks {
            tracks: parts.len(),
        });
    }
    let input = LookInput {
        pulses,
        pixels,
        plan: &plan,
    };
    let incoherent = request.options.sum == Sum::Incoherent && parts.len() > 1;
    let mut made = if incoherent {
        sum_of_powers(input, &parts, control)?
    } else {
        coherent_sum(input, control)?
    };
    if request.options.values == Values::Reflectivity {
        let seen = (pulses.position_m(), pulses.weight());
        let frequencies = pulses.frequency_hz().len();
        reflectivity::to_reflectivity(&mut made.image, pixels, seen, frequencies);
    }
    let multilook = match request.looks {
        Some(looks) => Some(image_looks(input, looks, sink, control)?),
        None => None,
    };
    made.summary.bytes += pixels.surface.as_ref().map_or(0, |s| s.len() as u128 * 4);
    made.summary.bytes += multilook.as_ref().map_or(0, |m| m.bytes);
    Ok(Focused {
        image: made.image,
        pixels: pixels.clone(),
        options: request.options,
        promised_bytes: u64::try_from(made.summary.bytes).unwrap_or(u64::MAX),
        plan: made.summary.explained,
        checked_error: made.summary.checked_error,
        multilook,
        projections: None,
        inversion: None,
        underground: request.underground.clone(),
    })
}

/// The pulses with the boresight of the options.
///
/// # Errors
/// An antenna on a gimbal whose attitude is not known, or a boresight without direction.
pub(crate) fn looking<'a>(
    pulses: Pulses<'a>,
    aligned: &'a Aligned,
    axis: AntennaAxis,
) -> Result<Pulses<'a>, ImageError> {
    match aligned.boresights(axis) {
        None => Ok(pulses.without_boresight()),
        Some(boresights) if !boresights.is_empty() => pulses
            .with_boresight(&boresights.looks)
            .map_err(ImageError::Spectra),
        Some(_) if axis.is_gimbal() => Err(ImageError::NoGimbal { axis: axis.name() }),
        Some(_) => Ok(pulses.without_boresight()),
    }
}

/// The tracks' parts of the pulses in `wanted`, counted from the first of `wanted`; tracks without pulses in
/// `wanted` are omitted.
pub(crate) fn parts_within(parts: &[Range<usize>], wanted: &Range<usize>) -> Vec<Range<usize>> {
    let within = |part: &Range<usize>| {
        let from = part.start.max(wanted.start);
        let to = part.end.min(wanted.end);
        (from < to).then(|| from - wanted.start..to - wanted.start)
    };
    parts.iter().filter_map(within).collect()
}

pub(crate) fn plan_options(options: &FocusOptions) -> PlanOptions {
    let default = PlanOptions::default();
    let stated = options.memory_limit_bytes.map(u128::from);
    let limit_bytes = stated.unwrap_or(default.memory_limit_bytes);
    default
        .with_accuracy(options.accuracy)
        .with_incidence(options.incidence)
        .with_check_pixels(options.check_pixels)
        .with_memory_limit_bytes(
            available_memory_bytes().map_or(limit_bytes, |b| limit_bytes.min(b.into())),
        )
}

/// An image, and the record of its plans.
struct Made {
    image: Vec<Complex32>,
    summary: PlanSummary,
}

/// The coherent image of all traces.
fn coherent_sum(input: LookInput<'_>, control: &Control<'_>) -> Result<Made, ImageError> {
    let mut image = vec![Complex32::default(); input.pixels.grid.len()];
    let mut summary = PlanSummary::default();
    control.start(
        "focus",
        contributions(image.len(), &(0..input.pulses.len())),
    );
    let plan = plan_on(input.pixels, input.pulses, input.plan, control)?;
    summary.add(&plan, control);
    run_plan(&plan, &mut image, 0, control)?;
    control.finish();
    Ok(Made { image, summary })
}

/// The root of the summed powers of the tracks' images.
fn sum_of_powers(
    input: LookInput<'_>,
    parts: &[Range<usize>],
    control: &Control<'_>,
) -> Result<Made, ImageError> {
    let mut image = vec![Complex32::default(); input.pixels.grid.len()];
    let mut power = vec![0_f32; image.len()];
    let mut summary = PlanSummary::default();
    control.start(
        "focus",
        contributions(image.len(), &(0..input.pulses.len())),
    );
    let mut before = 0;
    for part in parts {
        let pulses = input
            .pulses
            .slice(part.clone())
            .map_err(ImageError::Tracks)?;
        let plan = plan_on(input.pixels, pulses, input.plan, control)?;
        summary.add(&plan, control);
        run_plan(&plan, &mut image, before, control)?;
        before += contributions(image.len(), part);
        acerra_imaging::looks::add_power(&mut power, &image)?;
    }
    control.finish();
    for (v, p) in image.iter_mut().zip(&power) {
        *v = Complex32::new(p.sqrt(), 0.0);
    }
    summary.bytes += 4 * power.len() as u128;
    Ok(Made { image, summary })
}

/// Number of contributions from which estimating the run time by timed samples is cheap relative to the
/// image.
const MIN_CONTRIBUTIONS_TO_ESTIMATE: u64 = 2_000_000_000;

/// Record of one plan, or of the most demanding of several.
#[derive(Default)]
struct PlanSummary {
    explained: String,
    bytes: u128,
    checked_error: Option<f64>,
}

impl PlanSummary {
    fn add(&mut self, plan: &ImagingPlan<'_>, control: &Control<'_>) {
        if !self.explained.is_empty() {
            self.explained.push('\n');
        }
        self.explained.push_str(&plan.report().to_string());
        if plan.contributions() > MIN_CONTRIBUTIONS_TO_ESTIMATE {
            let threads = rayon::current_num_threads();
            let seconds = plan.estimate_run_time_s(control.operation());
            let line = format!("\nabout {seconds:.2} s on {threads} threads");
            self.explained.push_str(&line);
        }
        self.bytes = self.bytes.max(plan.memory_bytes());
        if let Some(check) = plan.self_check() {
            self.checked_error = Some(self.checked_error.unwrap_or(0.0).max(check.error));
        }
    }
}
