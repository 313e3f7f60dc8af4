//! Prominent points: found one after another in images of the residual echoes.

use acerra_imaging::{
    Complex32, Complex64, ImagingError, ImagingPlan, PlanOptions, PulseArrays, Pulses, Spreading,
};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::fit::{Problem, Seen, Stage};
use crate::ground::PixelPlace;
use crate::model::Model;

/// Rounds of searching, by delays and by the coherent image.
const ROUNDS: [usize; 2] = [4, 2];
/// A round accepts maxima down to this share of the power of the round's greatest.
const SHARE_OF_ROUND: f64 = 0.5;
/// All rounds reject maxima below this share of the power of the first round's greatest.
const SHARE_OF_ALL: f64 = 0.02;
/// Least level of maxima above the image's median, in median deviations.
const LEAST_RISE: f64 = 8.0;
/// Least spacing of points, in range resolutions.
const APART_CELLS: f64 = 3.0;
/// Largest number of pulses summed in an image without phases.
const MOST_PULSES: usize = 400;

/// Images of the residual echoes, for the search.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub problem: Problem<'a>,
    pub pulses: Pulses<'a>,
    pub most_points: usize,
}

/// Powers on a lattice over the pixels.
struct PowerMap {
    power: Vec<f64>,
    columns: usize,
    /// Pixels between neighbouring values.
    step: f64,
}

impl Search<'_> {
    /// A model with points and a first estimate of the path, from delays alone.
    pub fn by_envelopes(&self) -> Result<Model, ImagingError> {
        self.rounds(Stage::Envelope, self.problem.nominal(Vec::new()))
    }

    /// Adds points to the points of `model`, found in the coherent image along the path of `model`.
    pub fn by_phases(&self, model: Model) -> Result<Model, ImagingError> {
        self.rounds(Stage::Phase, model)
    }

    /// The objective for noise of variance `noise` plus a penalty for the three parameters of each point
    /// (Bayesian information criterion), for comparing models with different points.
    pub fn penalised(&self, model: &Model, seen: &Seen, noise: f64) -> f64 {
        let samples = (self.pulses.len() * self.pulses.frequency_hz().len()) as f64;
        let price = 3.0 * model.places.len() as f64 * samples.ln();
        self.problem.objective(model, seen, Stage::Phase, noise) + price
    }

    fn rounds(&self, stage: Stage, mut model: Model) -> Result<Model, ImagingError> {
        let mut floor = None;
        for _ in 0..ROUNDS[usize::from(stage == Stage::Phase)] {
            self.problem.control.check()?;
            let map = match stage {
                Stage::Envelope => self.without_phases(&model),
                Stage::Phase => self.with_phases(&model)?,
            };
            let maxima = self.maxima(&map, &mut floor);
            let before = model.places.len();
            self.add(&mut model, &maxima);
            if model.places.len() == before {
                break;
            }
            let guides = vec![true; model.places.len()];
            model = self.problem.fit(model, stage, &guides, Some(2))?.model;
            self.tidy(&mut model);
        }
        Ok(model)
    }

    /// Σ_m |b_m(R)|² of the residual echoes.
    fn without_phases(&self, model: &Model) -> PowerMap {
        let problem = &self.problem;
        let Seen {
            ranges_m: ranges,
            histories,
        } = problem.seen(model);
        let carrier = problem.template.carrier;
        let echoes: Vec<Vec<(f64, Complex64)>> = histories
            .pulses
            .iter()
            .zip(&ranges)
            .map(|(pulse, ranges)| {
                let of = |(e, r): (&crate::echoes::Echo, &f64)| {
                    (*r, e.amplitude * Complex64::cis(-carrier * r))
                };
                pulse.echoes.iter().zip(ranges).map(of).collect()
            })
            .collect();
        let positions = problem.positions_m(model);
        let ranging = problem.ranging(model);
        let every = positions.len().div_ceil(MOST_PULSES);
        let profiles = problem.profiles;
        let powers = profiles.powers_without(&echoes, every, problem.template);
        let grid = problem.ground.grid();
        let pixel_m = problem.ground.tangents_m([0.0; 2]).map(|t| t.norm());
        let coarsest_m = pixel_m[0].max(pixel_m[1]).max(1e-9);
        let step = (0.5 * problem.template.cell_m / coarsest_m).max(1.0);
        let nodes = |pixels: usize| ((pixels - 1) as f64 / step) as usize + 1;
        let [columns, rows] = [grid.columns(), grid.rows()].map(nodes);
        // Single precision, about one of the antenna's places: the powers are smooth over
        // centimetres.
        let origin = Vector3::from(positions[0]);
        let antennas: Vec<(usize, [f32; 3])> = (0..positions.len())
            .step_by(every)
            .map(|m| (m, single(Vector3::from(positions[m]) - origin)))
            .collect();
        let (slowness, delay_m) = (ranging.slowness as f32, &ranging.delay_m);
        let mut power = vec![0.0; rows * columns];
        power
            .par_chunks_mut(columns)
            .enumerate()
            .for_each(|(j, row)| {
                let points: Vec<[f32; 3]> = (0..columns)
                    .map(|i| [i, j].map(|v| v as f64 * step))
                    .map(|place| single(problem.ground.point_m(place) - origin))
                    .collect();
                let [x, y, z] = [0, 1, 2].map(|a| points.iter().map(|p| p[a]).collect::<Vec<_>>());
                let mut range_m = vec![0.0_f32; columns];
                let mut sum = vec![0.0_f32; columns];
                for (m, at) in &antennas {
                    let places = x.iter().zip(&y).zip(&z);
                    for (range, ((x, y), z)) in range_m.iter_mut().zip(places) {
                        let (dx, dy, dz) = (x - at[0], y - at[1], z - at[2]);
                        *range = (dx * dx + dy * dy + dz * dz).sqrt() * slowness;
                    }
                    powers.add(*m, delay_m[*m], &range_m, &mut sum);
                }
                row.iter_mut()
                    .zip(&sum)
                    .for_each(|(p, s)| *p = f64::from(*s));
            });
        PowerMap {
            power,
            columns,
            step,
        }
    }

    /// Power of the coherent image of the residual echoes.
    fn with_phases(&self, model: &Model) -> Result<PowerMap, ImagingError> {
        let problem = &self.problem;
        let ranging = problem.ranging(model);
        let positions = problem.positions_m(model);
        let spectrum = self.residual_spectra(model);
        let left = Pulses::new(PulseArrays {
            position_m: &positions,
            frequency_hz: self.pulses.frequency_hz(),
            spectrum: &spectrum,
            weight: self.pulses.weight(),
            light_speed_m_s: self.pulses.light_speed_m_s() / ranging.slowness,
        })?;
        let options = PlanOptions::default()
            .with_accuracy(1e-2)
            .with_spreading(Spreading::None)
            .with_check_pixels(16);
        let grid = problem.ground.grid();
        let plan = ImagingPlan::with_control(left, grid, &options, problem.control)?;
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        plan.run(&mut image, problem.control)?;
        Ok(PowerMap {
            power: image.iter().map(|v| f64::from(v.norm_sqr())).collect(),
            columns: grid.columns(),
            step: 1.0,
        })
    }

    /// The spectra less the coherent echoes of the model's points, corrected to zero delay and phase.
    fn residual_spectra(&self, model: &Model) -> Vec<Complex64> {
        let problem = &self.problem;
        let Seen {
            ranges_m: ranges,
            histories,
        } = problem.seen(model);
        let amplitudes = histories.coherent();
        let template = problem.template;
        let n = template.wavenumber.len();
        let ranging = problem.ranging(model);
        let mut spectrum = self.pulses.spectrum().to_vec();
        spectrum.par_chunks_mut(n).enumerate().for_each(|(m, row)| {
            for (k, range) in ranges[m].iter().enumerate() {
                let amplitude = amplitudes.amplitude[m][k];
                for ((e, kappa), s) in row
                    .iter_mut()
                    .zip(&template.wavenumber)
                    .zip(&template.spectrum)
                {
                    *e -= amplitude * s * Complex64::cis(-(template.carrier + kappa) * range);
                }
            }
            let (delay_m, turn) = (ranging.delay_m[m], ranging.turn[m].conj());
            for (e, kappa) in row.iter_mut().zip(&template.wavenumber) {
                *e *= turn * Complex64::cis((template.carrier + kappa) * delay_m);
            }
        });
        spectrum
    }

    /// Prominent maxima of a map, strongest first.
    fn maxima(&self, map: &PowerMap, floor: &mut Option<f64>) -> Vec<PixelPlace> {
        let rows = map.power.len() / map.columns;
        let mut sorted = map.power.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let mut deviations: Vec<f64> = sorted.iter().map(|p| (p - median).abs()).collect();
        deviations.sort_by(f64::total_cmp);
        let spread = deviations[deviations.len() / 2];
        let greatest = sorted[sorted.len() - 1] - median;
        let first = *floor.get_or_insert(greatest);
        let least = (LEAST_RISE * spread)
            .max(SHARE_OF_ROUND * greatest)
            .max(SHARE_OF_ALL * first);
        let at = |i: usize, j: usize| map.power[j * map.columns + i];
        let mut found: Vec<(f64, PixelPlace)> = Vec::new();
        for j in 0..rows {
            for i in 0..map.columns {
                let own = at(i, j);
                if own - median < least {
                    continue;
                }
                let higher = (j.saturating_sub(1)..(j + 2).min(rows)).any(|b| {
                    (i.saturating_sub(1)..(i + 2).min(map.columns)).any(|a| at(a, b) > own)
                });
                if !higher {
                    let place = [i, j].map(|v| v as f64 * map.step);
                    found.push((own, place));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, place)| place).collect()
    }

    fn add(&self, model: &mut Model, maxima: &[PixelPlace]) {
        let ground = &self.problem.ground;
        let apart_m = APART_CELLS * self.problem.template.cell_m;
        for place in maxima {
            if model.places.len() >= self.most_points {
                break;
            }
            let point = ground.point_m(*place);
            let is_apart = |p: &PixelPlace| (ground.point_m(*p) - point).norm() > apart_m;
            if model.places.iter().all(is_apart) {
                model.places.push(*place);
            }
        }
    }

    /// Drops points that left the pixels or merged with a stronger point.
    pub fn tidy(&self, model: &mut Model) {
        let ground = &self.problem.ground;
        let apart_m = self.problem.template.cell_m;
        let mut kept: Vec<PixelPlace> = Vec::new();
        for place in &model.places {
            let point = ground.point_m(*place);
            let is_apart = |p: &PixelPlace| (ground.point_m(*p) - point).norm() > apart_m;
            if ground.holds(*place) && kept.iter().all(is_apart) {
                kept.push(*place);
            }
        }
        model.places = kept;
    }
}

fn single(v: Vector3<f64>) -> [f32; 3] {
    [v[0] as f32, v[1] as f32, v[2] as f32]
}
