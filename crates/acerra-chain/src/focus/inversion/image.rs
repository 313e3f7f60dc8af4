//! Image of a scene by inversion of the echoes.

use std::ops::Range;

use acerra_imaging::{Complex32, Complex64, Pulses};
use acerra_invert::{
    Flight, Ground, LinearOperator, SceneOperator, TrackData, Weighted, even_weights,
};

use super::noise::{NoiseFound, noise_before_first_echo};
use super::options::Method;
use super::record::{InversionRecord, NoiseRecord};
use super::resolution::{at_strongest, narrow};
use super::solve::{Setting, Solved, solve, sparse, steps};
use crate::choices::Sum;
use crate::control::Control;
use crate::echoes::Echoes;
use crate::focus::plan::ImageError;
use crate::focus::sink::ImageSink;
use crate::focus::volume::assemble_volume;
use crate::focus::{Focused, ImageRequest, looking, parts_within, plan_options};

/// Echoes, their tracks, and the ranges covered by the echoes.
#[derive(Clone, Copy, Debug)]
pub struct InversionInput<'a> {
    /// Clean spectra at their places.
    pub echoes: Echoes<'a>,
    /// The tracks' ranges of pulses.
    pub parts: &'a [Range<usize>],
    /// Nearest and farthest range covered by the data of each trace (m).
    pub held_m: &'a [[f64; 2]],
}

/// Accuracy of the operators as a share of the image's accuracy: a solver amplifies the operators' errors,
/// tenfold at a threshold of −20 dB.
const ACCURACY_SHARE: f64 = 0.3;
const ACCURACY: [f64; 2] = [1e-5, 3e-4];

/// Images the scene by inversion; a volume's slices go to the sink.
///
/// # Errors
/// Looks, tracks summed by power (except by `"sparse"`) and volumes by `"clean"`, for which no inversion
/// exists; data that the operators refuse; more memory than is available; cancellation.
pub fn invert(
    input: InversionInput<'_>,
    request: &ImageRequest,
    sink: &mut dyn ImageSink,
    control: &Control<'_>,
) -> Result<Focused, ImageError> {
    let is_grouped = request.options.sum == Sum::Incoherent && input.parts.len() > 1;
    refuse_what_is_not_solved_for(request, is_grouped)?;
    let is_straight =
        request.underground.is_none() && input.echoes.aligned.antennas_from_place_m.is_empty();
    if !is_straight {
        return Err(ImageError::Method {
            method: request.options.inversion.method.name(),
            expected: "monostatic echoes, through air",
            found: "transmitters and receivers apart, or [ground]",
        });
    }
    let whole = 0..input.echoes.aligned.position_m.len();
    let wanted = request.pulses.clone().unwrap_or(whole);
    let weight = input.echoes.weights(request.options.weight);
    let pulses = input.echoes.pulses(&weight).map_err(ImageError::Spectra)?;
    let axis = request.options.antenna_axis;
    let pulses = looking(pulses, input.echoes.aligned, axis)?;
    let pulses = pulses.slice(wanted.clone()).map_err(ImageError::Spectra)?;
    let survey = Survey {
        pulses,
        height_m: &input.echoes.aligned.height_m[wanted.clone()],
        held_m: &input.held_m[wanted.clone()],
        parts: parts_within(input.parts, &wanted),
    };
    let mut made = if is_grouped {
        survey.solve_grouped(request, control)?
    } else {
        survey.solve_jointly(request, control)?
    };
    let (image, pixels, projections) = match request.pixels.volume {
        Some(volume) => {
            let whole = std::iter::once(Ok(&made.image));
            let (image, pixels, seen) = assemble_volume(volume, whole, sink)?;
            (image, pixels, Some(seen))
        }
        None => (
            std::mem::take(&mut made.image),
            request.pixels.clone(),
            None,
        ),
    };
    Ok(Focused {
        image,
        pixels,
        options: request.options,
        plan: made.explained,
        promised_bytes: u64::try_from(made.memory_bytes).unwrap_or(u64::MAX),
        checked_error: None,
        multilook: None,
        projections,
        inversion: Some(made.record),
        underground: None,
    })
}

fn refuse_what_is_not_solved_for(
    request: &ImageRequest,
    is_grouped: bool,
) -> Result<(), ImageError> {
    let method = request.options.inversion.method;
    let refuse = |expected, found| {
        Err(ImageError::Method {
            method: method.name(),
            expected,
            found,
        })
    };
    if request.looks.is_some() {
        return refuse("one image of all pulses", "looks");
    }
    if is_grouped && method != Method::Sparse {
        return refuse(
            "[tracks] sum = \"coherent\" (or method = \"sparse\")",
            "[tracks] sum = \"incoherent\"",
        );
    }
    if request.pixels.volume.is_some() && method == Method::Clean {
        return refuse("a plane or terrain", "a volume");
    }
    if request.pixels.volume.is_some() && is_grouped {
        return refuse("a plane or terrain of tracks summed by power", "a volume");
    }
    Ok(())
}

/// The imaged pulses and their data.
struct Survey<'a> {
    pulses: Pulses<'a>,
    height_m: &'a [f64],
    held_m: &'a [[f64; 2]],
    parts: Vec<Range<usize>>,
}

/// An image and the record of its inversion.
struct Made {
    image: Vec<Complex32>,
    explained: String,
    memory_bytes: u128,
    record: InversionRecord,
}

/// Meaning of the pixels by method.
fn meaning(method: Method) -> &'static str {
    match method {
        Method::Adjoint => "the sum of Eq. (3)",
        Method::Tsvd | Method::Cgls => {
            "reflectivity of the pixel's own area: a unit point is spread over its resolution cell, and its \
             peak is that of the field `resolution`"
        }
        Method::Sparse => {
            "reflectivity of the points that explain the echoes, less a bias of the sparsity; zero \
             elsewhere. Widths are those of the solution, not of the instrument"
        }
        Method::Clean => {
            "reflectivity of a point: components under a beam of the theory's widths, over the residual \
             image. Widths are those of the beam"
        }
    }
}

impl Survey<'_> {
    /// One scene that explains all pulses.
    fn solve_jointly(
        &self,
        request: &ImageRequest,
        control: &Control<'_>,
    ) -> Result<Made, ImageError> {
        let options = request.options.inversion;
        let flight = self.flight(&self.pulses, request)?;
        let data = flight.weighted(self.pulses.spectrum())?;
        let operator = operator_on(&flight, &data, request, control)?;
        let weight = even_weights(&flight, operator.grids());
        let noise = self.noise(&flight, request)?;
        let setting = self.setting(&operator, &weight, noise, request);
        control.start("invert", options.max_iterations() as u64);
        let progress = steps(control);
        let imaging = control.operation_reporting(&progress);
        let solved = solve(&setting, &data, None, imaging)?;
        let image = narrow(&solved.scene);
        let resolution = if request.pixels.volume.is_some() {
            Vec::new()
        } else {
            let found = (&solved, image.as_slice());
            at_strongest(&setting, found, &data, &request.pixels, imaging)?
        };
        control.finish();
        let record = InversionRecord {
            resolution,
            ..self.record(&solved, (&flight, &data, noise), request)
        };
        Ok(Made {
            image,
            explained: operator.explained(),
            memory_bytes: solved.memory_bytes,
            record,
        })
    }

    /// A separate scene for every track, bright at the same pixels; the image is the root of the sum of their
    /// powers.
    fn solve_grouped(
        &self,
        request: &ImageRequest,
        control: &Control<'_>,
    ) -> Result<Made, ImageError> {
        let mut flights = Vec::new();
        let mut data = Vec::new();
        for part in &self.parts {
            let own = self
                .pulses
                .slice(part.clone())
                .map_err(ImageError::Tracks)?;
            let flight = self.flight(&own, request)?;
            data.push(flight.weighted(own.spectrum())?);
            flights.push(flight);
        }
        let mut operators = Vec::new();
        let mut weights = Vec::new();
        for (flight, data) in flights.iter().zip(&data) {
            let operator = operator_on(flight, data, request, control)?;
            weights.push(even_weights(flight, operator.grids()));
            operators.push(operator);
        }
        let mut even = Vec::new();
        for (operator, weight) in operators.iter().zip(&weights) {
            even.push(Weighted::new(operator, weight)?);
        }
        let tracks: Vec<TrackData<'_>> = even
            .iter()
            .zip(&data)
            .map(|(operator, data)| TrackData { operator, data })
            .collect();
        let whole = self.flight(&self.pulses, request)?;
        let noise = self.noise(&whole, request)?;
        let (Some(operator), Some(weight)) = (operators.first(), weights.first()) else {
            return Err(ImageError::LooksOfTracks { tracks: 0 });
        };
        let setting = self.setting(operator, weight, noise, request);
        let iterations = request.options.inversion.max_iterations();
        control.start("invert", iterations as u64);
        let progress = steps(control);
        let (solved, mut scenes) = sparse(
            &setting,
            &tracks,
            None,
            control.operation_reporting(&progress),
        )?;
        control.finish();
        let mut power = vec![0.0_f64; request.pixels.grid.len()];
        for (scene, even) in scenes.iter_mut().zip(&even) {
            even.scene_from(scene);
            power
                .iter_mut()
                .zip(scene)
                .for_each(|(p, v)| *p += v.norm_sqr());
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "pixels are single precision"
        )]
        let image = power
            .iter()
            .map(|p| Complex32::new(p.sqrt() as f32, 0.0))
            .collect();
        let all: Vec<_> = data.concat();
        Ok(Made {
            image,
            explained: operator.explained(),
            memory_bytes: solved.memory_bytes,
            record: self.record(&solved, (&whole, &all, noise), request),
        })
    }

    fn flight(&self, pulses: &Pulses<'_>, request: &ImageRequest) -> Result<Flight, ImageError> {
        let plane_z_m = request.pixels.grid.z_m;
        Ok(Flight::of(pulses)?.with_incidence(request.options.incidence, plane_z_m))
    }

    fn noise(
        &self,
        flight: &Flight,
        request: &ImageRequest,
    ) -> Result<Option<NoiseFound>, ImageError> {
        let known = (self.height_m, self.held_m);
        let spectrum = self.pulses.spectrum();
        Ok(noise_before_first_echo(
            flight,
            spectrum,
            &request.pixels,
            known,
        )?)
    }

    fn setting<'s>(
        &self,
        operator: &'s SceneOperator<'s>,
        weight: &'s [f32],
        noise: Option<NoiseFound>,
        request: &ImageRequest,
    ) -> Setting<'s> {
        let flight = operator.flight();
        // The greatest of N values of circular noise is √(ln N) times their standard deviation.
        let cells = (operator.pixels().min(operator.samples()) as f64).max(2.0);
        Setting {
            operator,
            weight,
            options: request.options.inversion,
            noise_norm: noise.map(|found| found.level.norm(flight, found.held)),
            noise_peak: noise.map(|found| found.level.correlated(flight) * cells.ln().sqrt()),
            memory_limit_bytes: plan_options(&request.options).memory_limit_bytes,
        }
    }

    fn record(
        &self,
        solved: &Solved,
        (flight, data, noise): (&Flight, &[Complex64], Option<NoiseFound>),
        request: &ImageRequest,
    ) -> InversionRecord {
        let norm = data.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        InversionRecord {
            method: request.options.inversion.method,
            meaning: meaning(request.options.inversion.method),
            parameter: solved.parameter,
            parameters: solved.parameters,
            stop: solved.history.stop,
            residual: solved.history.residual(),
            iterations: solved.history.iterations.clone(),
            noise: noise.map(|found| NoiseRecord {
                sigma: found.level.sigma,
                expected_residual: found.level.norm(flight, found.held) / norm,
                cells: found.level.cells,
            }),
            resolution: Vec::new(),
            operator_accuracy: operator_accuracy(request),
        }
    }
}

fn operator_accuracy(request: &ImageRequest) -> f64 {
    (ACCURACY_SHARE * request.options.accuracy).clamp(ACCURACY[0], ACCURACY[1])
}

fn operator_on<'a>(
    flight: &'a Flight,
    data: &'a [Complex64],
    request: &'a ImageRequest,
    control: &Control<'_>,
) -> Result<SceneOperator<'a>, ImageError> {
    let pixels = &request.pixels;
    let ground = match (&pixels.volume, &pixels.surface) {
        (Some(volume), _) => Ground::Volume(*volume),
        (None, Some(surface)) => Ground::Surface(surface),
        (None, None) => Ground::Plane(pixels.grid.into()),
    };
    let options = plan_options(&request.options).with_accuracy(operator_accuracy(request));
    Ok(SceneOperator::new(
        flight,
        data,
        ground,
        options,
        control.operation(),
    )?)
}
