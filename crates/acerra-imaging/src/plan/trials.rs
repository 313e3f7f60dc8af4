//! Images of the same echoes at trial positions and delays.

use super::imaging::{ImagingPlan, image};
use super::options::{Engine, PlanOptions};
use super::planner::Method;
use super::request::Request;
use crate::control::Meter;
use crate::engine::direct::{Direct, table_ranges_m};
use crate::engine::factorized::merged::Factorized;
use crate::engine::weights::{WeightedPulses, Weights};
use crate::error::ImagingError;
use crate::grid::PlaneGrid;
use crate::grid::image::ImageGrid;
use crate::pulses::{PulseArrays, Pulses, Spreading};
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use std::f64::consts::TAU;

/// Positions, range and pixels of a trial image.
#[derive(Debug, Clone, Copy)]
pub struct TrialImage<'t> {
    /// Antenna phase centre of every pulse (m), `[pulses]`.
    pub position_m: &'t [[f64; 3]],
    /// Excess distance of a pixel's echo over the pixel's range (m): c/2 times an error of the delay.
    pub beyond_m: f64,
    /// The pixels.
    pub grid: PlaneGrid,
}

/// Images of the same echoes for searches that score tens of trial positions, delays or heights by the sharpness of an
/// image: without 1/R², and with range tables that are built once.
///
/// A trial outside the tables is planned and imaged separately.
///
/// ```
/// use acerra_imaging::{Complex64, PlaneGrid, PulseArrays, TrialImage, TrialImages};
/// let position_m: Vec<[f64; 3]> = (0..40).map(|m| [0.0, 0.05 * f64::from(m) - 1.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let range_m = |p: &[f64; 3]| (p[0] - 2.0).hypot(p[1]).hypot(p[2]);
/// let spectrum: Vec<Complex64> = (position_m.iter())
///     .flat_map(|p| frequency_hz.iter().map(|f| Complex64::cis(-4.0 * 3.14159265 * f * range_m(p) / 3e8)))
///     .collect();
/// let grid = PlaneGrid::from_ranges([1.8, 2.2], [-0.2, 0.2], 0.0, 0.05)?;
/// let echoes = PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &spectrum,
///     weight: &[1.0; 40],
///     light_speed_m_s: 3e8,
/// };
/// let images = TrialImages::new(echoes, grid, 0.2, 1e-2)?;
/// let peak = |beyond_m: f64| -> Result<f32, acerra_imaging::ImagingError> {
///     let trial = TrialImage { position_m: &position_m, beyond_m, grid };
///     Ok(images.image(&trial)?.iter().map(|v| v.norm()).fold(0.0, f32::max))
/// };
/// assert!(peak(0.0)? > 1.5 * peak(0.15)?);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug)]
pub struct TrialImages<'a> {
    echoes: PulseArrays<'a>,
    pulses: Pulses<'a>,
    grid: PlaneGrid,
    options: PlanOptions,
    reach_m: f64,
    tables: Tables,
}

/// The engine that trials share.
#[derive(Debug)]
enum Tables {
    /// Serves any positions and pixels whose ranges lie within the bounds held for every antenna (m).
    Direct(Box<Direct>, Vec<[f64; 2]>),
    /// Serves the positions and pixels that it was made for.
    Factorized(Box<Factorized>),
    None,
}

impl<'a> TrialImages<'a> {
    /// Range tables for the pixels of `grid` seen from the positions of `echoes`, and for trials of other
    /// positions and pixels whose ranges differ by `reach_m` at most from these. The accuracy of the tables
    /// is checked as that of a plan is.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`].
    pub fn new(
        echoes: PulseArrays<'a>,
        grid: PlaneGrid,
        reach_m: f64,
        accuracy: f64,
    ) -> Result<Self, ImagingError> {
        Self::with_engine(echoes, grid, [reach_m, accuracy], Engine::Direct)
    }

    /// As [`TrialImages::new`], for trials on these pixels from these positions that differ in
    /// [`TrialImage::beyond_m`] alone: large images use the factorized engine.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`].
    pub fn of_delays(
        echoes: PulseArrays<'a>,
        grid: PlaneGrid,
        reach_m: f64,
        accuracy: f64,
    ) -> Result<Self, ImagingError> {
        Self::with_engine(echoes, grid, [reach_m, accuracy], Engine::Auto)
    }

    fn with_engine(
        echoes: PulseArrays<'a>,
        grid: PlaneGrid,
        [reach_m, accuracy]: [f64; 2],
        engine: Engine,
    ) -> Result<Self, ImagingError> {
        // No 1/R², which would let the nearest echoes dominate.
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_spreading(Spreading::None)
            .with_check_pixels(4);
        let pulses = Pulses::new(echoes)?;
        let mut request = Request::new(pulses, grid.into(), &options.with_engine(engine))?;
        request.reach_m = reach_m;
        let ranges_m = request.ranges_m(0..echoes.position_m.len(), |plane| *plane);
        let plan = ImagingPlan::of_request(request, Control::default())?;
        let position_m = echoes.position_m;
        let tables = match &plan.method {
            Method::Direct(imager) => imager.only().map_or(Tables::None, |direct| {
                Tables::Direct(Box::new(direct.moved(position_m, 0.0)), ranges_m)
            }),
            Method::Factorized(imager) => imager.only().map_or(Tables::None, |factorized| {
                Tables::Factorized(Box::new(factorized.beyond(position_m, 0.0)))
            }),
            Method::Double(_) | Method::Reference => Tables::None,
        };
        Ok(Self {
            echoes,
            pulses,
            grid,
            options,
            reach_m,
            tables,
        })
    }

    /// A trial's image, `[rows, columns]` row-major.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`]; positions of another number than the pulses.
    pub fn image(&self, trial: &TrialImage) -> Result<Vec<Complex32>, ImagingError> {
        if !self.serve(trial) {
            return self.alone(trial);
        }
        let pulses = self.pulses.moved(trial.position_m)?;
        let grid = ImageGrid::from(trial.grid);
        let weights = Weights::new(&pulses, &grid, Spreading::None, None)?;
        let echoes = WeightedPulses::new(pulses, weights);
        let (which, meter) = (0..echoes.len(), Meter::silent(Control::default()));
        let mut values = vec![Complex32::ZERO; trial.grid.len()];
        match &self.tables {
            Tables::Direct(direct, _) => {
                let direct = direct.moved(trial.position_m, trial.beyond_m);
                direct.run(&echoes, which, &grid.whole(), &mut values, &meter);
            }
            Tables::Factorized(factorized) => {
                let factorized = factorized.beyond(trial.position_m, trial.beyond_m);
                factorized.run(&echoes, &grid.whole(), &mut values, &meter);
            }
            Tables::None => return self.alone(trial),
        }
        Ok(values)
    }

    /// Whether the tables hold all ranges that a trial looks up.
    fn serve(&self, trial: &TrialImage) -> bool {
        match &self.tables {
            Tables::Direct(_, ranges_m) => {
                let needed_m = table_ranges_m(trial.position_m, &trial.grid.into());
                let is_held = |([from, to], [first, last]): (&[f64; 2], &[f64; 2])| {
                    from + trial.beyond_m >= *first && to + trial.beyond_m <= *last
                };
                needed_m.len() == ranges_m.len() && needed_m.iter().zip(ranges_m).all(is_held)
            }
            Tables::Factorized(_) => {
                trial.beyond_m.abs() <= self.reach_m
                    && trial.grid == self.grid
                    && trial.position_m == self.echoes.position_m
            }
            Tables::None => false,
        }
    }

    /// The image by a separate plan.
    fn alone(&self, trial: &TrialImage) -> Result<Vec<Complex32>, ImagingError> {
        let per_hz = 2.0 * TAU * trial.beyond_m / self.echoes.light_speed_m_s;
        let turn: Vec<Complex64> = (self.echoes.frequency_hz.iter())
            .map(|f| Complex64::cis(f * per_hz))
            .collect();
        let mut spectrum = self.echoes.spectrum.to_vec();
        for trace in spectrum.chunks_mut(turn.len().max(1)) {
            trace.iter_mut().zip(&turn).for_each(|(v, t)| *v *= t);
        }
        let pulses = Pulses::new(PulseArrays {
            position_m: trial.position_m,
            spectrum: &spectrum,
            ..self.echoes
        })?;
        image(pulses, trial.grid, &self.options, Control::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHT_SPEED_M_S: f64 = 299_792_458.0;

    fn error(found: &[Complex32], expected: &[Complex32]) -> f32 {
        let difference: f32 = (found.iter().zip(expected))
            .map(|(a, b)| (a - b).norm_sqr())
            .sum();
        let power: f32 = expected.iter().map(|b| b.norm_sqr()).sum();
        (difference / power).sqrt()
    }

    #[test]
    fn trials_equal_images_planned_for_themselves() {
        let position_m: Vec<[f64; 3]> = (0..80)
            .map(|m| [0.1 * f64::from(m) - 4.0, 0.02 * f64::from(m % 7), 4.0])
            .collect();
        let frequency_hz: Vec<f64> = (0..120).map(|n| 3.1e9 + 1.4e7 * f64::from(n)).collect();
        let spectrum: Vec<Complex64> = (0..80 * 120)
            .map(|k| Complex64::from_polar(1.0, f64::from(k * k % 977)))
            .collect();
        let echoes = PulseArrays {
            position_m: &position_m,
            frequency_hz: &frequency_hz,
            spectrum: &spectrum,
            weight: &[1.0; 80],
            light_speed_m_s: LIGHT_SPEED_M_S,
        };
        let grid = PlaneGrid::from_ranges([-0.4, 0.6], [1.0, 2.0], 0.0, 0.04).unwrap();
        let images = TrialImages::new(echoes, grid, 0.5, 1e-2).unwrap();
        let away_m: Vec<[f64; 3]> = position_m
            .iter()
            .map(|p| [p[0], p[1] + 0.1, p[2]])
            .collect();
        let lower = PlaneGrid { z_m: -0.13, ..grid };
        let tried = [
            (&position_m, 0.0, grid, true),
            (&position_m, 0.1234, grid, true),
            (&position_m, -0.3217, lower, true),
            (&away_m, 0.0, grid, true),
            // Further than the tables reach.
            (&position_m, 0.8, grid, false),
        ];
        for (position_m, beyond_m, grid, is_held) in tried {
            let trial = TrialImage {
                position_m,
                beyond_m,
                grid,
            };
            assert_eq!(images.serve(&trial), is_held);
            let expected = images.alone(&trial).unwrap();
            let found = images.image(&trial).unwrap();
            let error = error(&found, &expected);
            assert!(error < 1.5e-2, "{beyond_m} m: {error}");
        }
    }

    #[test]
    fn delays_of_a_large_image_share_a_factorized_engine() {
        let position_m: Vec<[f64; 3]> = (0..400)
            .map(|m| [0.02 * f64::from(m) - 4.0, 0.0, 1.0])
            .collect();
        let frequency_hz: Vec<f64> = (0..120).map(|n| 3.1e9 + 1.4e7 * f64::from(n)).collect();
        let spectrum: Vec<Complex64> = (0..400 * 120)
            .map(|k: i64| Complex64::from_polar(1.0, (k * k % 977) as f64))
            .collect();
        let echoes = PulseArrays {
            position_m: &position_m,
            frequency_hz: &frequency_hz,
            spectrum: &spectrum,
            weight: &[1.0; 400],
            light_speed_m_s: LIGHT_SPEED_M_S,
        };
        let grid = PlaneGrid::from_ranges([-3.0, 3.0], [0.0, 3.0], 0.0, 0.01).unwrap();
        let request = [1.6, 1e-2];
        let images = TrialImages::with_engine(echoes, grid, request, Engine::Factorized).unwrap();
        assert!(matches!(images.tables, Tables::Factorized(_)));
        // The last looks up ranges below zero.
        for beyond_m in [0.0, 0.2345, -1.5] {
            let trial = TrialImage {
                position_m: &position_m,
                beyond_m,
                grid,
            };
            assert!(images.serve(&trial));
            let expected = images.alone(&trial).unwrap();
            let error = error(&images.image(&trial).unwrap(), &expected);
            assert!(error < 1.5e-2, "{beyond_m} m: {error}");
        }
    }

    #[test]
    fn positions_of_another_number_are_refused() {
        let echoes = PulseArrays {
            position_m: &[[0.0, 0.0, 3.0], [0.1, 0.0, 3.0]],
            frequency_hz: &[3e9, 3.1e9],
            spectrum: &[Complex64::ONE; 4],
            weight: &[1.0; 2],
            light_speed_m_s: LIGHT_SPEED_M_S,
        };
        let grid = PlaneGrid::from_ranges([0.0, 0.2], [0.0, 0.2], 0.0, 0.05).unwrap();
        let images = TrialImages::new(echoes, grid, 0.1, 1e-2).unwrap();
        let trial = TrialImage {
            position_m: &[[0.0, 0.0, 3.0]],
            beyond_m: 0.0,
            grid,
        };
        assert!(images.image(&trial).is_err());
    }
}
