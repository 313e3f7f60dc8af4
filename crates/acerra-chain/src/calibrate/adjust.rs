//! The adjustment: Gauss-Newton on the echoes' apparent ranges. The positions' slow errors and the errors of the
//! survey are estimated too and eliminated, the noise is taken from the data, and outliers are left out.

use nalgebra::{DMatrix, DVector};

use super::drift::Drift;
use super::echo::median;
use super::error::CalibrateError;
use super::knots::Knots;
use super::model::predict;
use super::parameter::{Parameter, Values};
use super::path::Sampler;
use super::track::{Echo, Setting};

/// Iterations after which the adjustment gives up.
const MOST_ITERATIONS: usize = 40;
/// Iterations after which outliers and noise stay as they are: an echo on the border would come and
/// go for ever.
const NOISE_ITERATIONS: usize = 8;
/// Change, in deviations, below which it has settled.
const SETTLED: f64 = 0.1;
/// Deviations beyond which a residual is an outlier.
const OUTLIER: f64 = 3.5;
/// Largest change of a lever arm in an iteration (m).
const LARGEST_STEP_M: f64 = 0.5;

/// The adjustment of some echoes.
#[derive(Debug)]
pub(super) struct Adjustment<'a> {
    setting: Setting<'a>,
    samplers: &'a [Sampler<'a>],
    echoes: &'a [Echo],
    parameters: Vec<Parameter>,
    drifts: Vec<Option<Drift>>,
    nuisances: usize,
}

/// The normal equations of the unknowns, nuisances eliminated.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// Information matrix (SI units).
    pub information: DMatrix<f64>,
    gradient: DVector<f64>,
    /// The positions' errors at the knots as functions of steps of the unknowns and the places: offset and slope.
    nuisance: (DVector<f64>, DMatrix<f64>),
    /// The errors of the surveyed places as functions of steps of the unknowns: offset and slope.
    places: (DVector<f64>, DMatrix<f64>),
    /// Unknowns that the data spend on the nuisances.
    nuisance_freedom: f64,
}

/// An adjustment that has settled.
#[derive(Clone, Debug)]
pub(super) struct Adjusted {
    /// The values found.
    pub values: Values,
    /// Unknowns that were estimated, in the order of `covariance`.
    pub free: Vec<Parameter>,
    /// Covariance (SI units).
    pub covariance: DMatrix<f64>,
    /// Information on all unknowns, free or held.
    pub normal: Normal,
    /// Residual of each echo (m).
    pub residual_m: Vec<f64>,
    /// Whether each echo is used.
    pub kept: Vec<bool>,
    /// Standard deviation of each echo (m).
    pub sigma_m: Vec<f64>,
}

/// Linearised observations at some values.
struct Linearised {
    /// Observed less predicted (m).
    misfit_m: Vec<f64>,
    /// Derivatives by the unknowns, then by the surveyed places.
    slope: Vec<Vec<f64>>,
    /// Derivatives by the position.
    by_position: Vec<[f64; 3]>,
}

impl<'a> Adjustment<'a> {
    pub fn new(
        setting: Setting<'a>,
        samplers: &'a [Sampler<'a>],
        echoes: &'a [Echo],
        start: &Values,
        correlation_s: f64,
    ) -> Self {
        let mut nuisances = 0;
        let drifts = samplers
            .iter()
            .enumerate()
            .map(|(track, sampler)| {
                let own = || echoes.iter().filter(|e| e.track == track);
                let time_s: Vec<f64> = own().map(|e| e.time_s).collect();
                let sigma = |e: &Echo| sampler.at(e.time_s, start.time_offset_s[track])?.sigma_m;
                let sigma_m: Vec<_> = own().map(sigma).collect();
                let drift = Drift::over(&time_s, &sigma_m, correlation_s, nuisances);
                nuisances += drift.as_ref().map_or(0, Drift::len);
                drift
            })
            .collect();
        Self {
            setting,
            samplers,
            echoes,
            parameters: start.parameters(),
            drifts,
            nuisances,
        }
    }

    /// Whether all tracks state the deviations of their positions.
    pub fn knows_position_errors(&self) -> bool {
        self.drifts.iter().all(Option::is_some)
    }

    /// The information of the echoes about the unknowns near some values. The noise is the scatter of the
    /// residuals when all unknowns are free, so that wrong values of the campaign do not count as noise.
    pub fn information(&self, values: &Values) -> DMatrix<f64> {
        let at = self.linearise(values);
        let all: Vec<usize> = (0..self.parameters.len()).collect();
        let mut noise = self.first_noise(&at);
        for _ in 0..NOISE_ITERATIONS {
            let normal = self.normal(&at, &noise);
            let step = invert(&normal.information) * &normal.gradient;
            let residual_m = self.residuals(&at, &normal, &all, &step);
            noise = self.noise(&residual_m, all.len() as f64 + normal.nuisance_freedom);
        }
        self.normal(&at, &noise).information
    }

    /// Adjusts all unknowns but those held, starting from `start`.
    pub fn solve(&self, start: &Values, held: &[Parameter]) -> Result<Adjusted, CalibrateError> {
        let free: Vec<usize> = (0..self.parameters.len())
            .filter(|i| !held.contains(&self.parameters[*i]))
            .collect();
        let needed = 2 * free.len() + 4;
        if self.echoes.len() < needed {
            return Err(CalibrateError::TooFewEchoes {
                needed,
                found: self.echoes.len(),
            });
        }
        let mut values = start.clone();
        let mut noise = self.first_noise(&self.linearise(&values));
        let mut last = (String::new(), f64::INFINITY);
        for iteration in 0..MOST_ITERATIONS {
            let at = self.linearise(&values);
            let normal = self.normal(&at, &noise);
            let covariance = invert(&select(&normal.information, &free, &free));
            let step = &covariance * pick(&normal.gradient, &free);
            let residual_m = self.residuals(&at, &normal, &free, &step);
            // Ends of the path cut traces off at one offset and not at the next, and rates averaged over a second are
            // not those of a walk's bobbing: shrinking steps end between values that whole steps alternate between.
            let share = NOISE_ITERATIONS as f64 / iteration.max(NOISE_ITERATIONS) as f64;
            last = self.apply(&mut values, &free, (&step, share), &covariance);
            let settled = last.1 < SETTLED && iteration > NOISE_ITERATIONS;
            if settled {
                return Ok(Adjusted {
                    free: free.iter().map(|i| self.parameters[*i]).collect(),
                    values,
                    covariance,
                    residual_m,
                    kept: noise.kept,
                    sigma_m: noise.sigma_m,
                    normal,
                });
            }
            if iteration < NOISE_ITERATIONS {
                noise = self.noise(&residual_m, free.len() as f64 + normal.nuisance_freedom);
            }
        }
        Err(CalibrateError::NotConverged {
            iterations: MOST_ITERATIONS,
            parameter: last.0,
            step: last.1,
        })
    }

    /// Updates the values by a share of a step; returns the unknown that changes most, and its change in deviations.
    fn apply(
        &self,
        values: &mut Values,
        free: &[usize],
        (step, share): (&DVector<f64>, f64),
        covariance: &DMatrix<f64>,
    ) -> (String, f64) {
        let mut largest = (String::new(), 0.0);
        // All steps shrink together, so that the direction stays.
        let arm = |i: &usize| (2..5).contains(i);
        let longest_m = free
            .iter()
            .zip(step.iter())
            .filter(|(i, _)| arm(i))
            .map(|(_, s)| s.abs())
            .fold(0.0, f64::max);
        let shrink = (LARGEST_STEP_M / longest_m.max(1e-12)).min(1.0);
        for (k, i) in free.iter().enumerate() {
            let parameter = self.parameters[*i];
            values.add(parameter, share * shrink * step[k]);
            let relative = share * step[k].abs() / covariance[(k, k)].max(0.0).sqrt().max(1e-30);
            if relative > largest.1 {
                largest = (parameter.name(), relative);
            }
        }
        largest
    }

    /// First of the columns for a reflector's surveyed place; none where the survey is exact.
    fn place_column(&self, reflector: usize) -> Option<usize> {
        (self.setting.survey_sigma_m > 0.0).then_some(self.parameters.len() + 3 * reflector)
    }

    /// Unknowns and coordinates of surveyed places.
    fn columns(&self) -> usize {
        let places = self.setting.reflector_m.len();
        self.place_column(places).unwrap_or(self.parameters.len())
    }

    fn linearise(&self, values: &Values) -> Linearised {
        let c = self.setting.light_speed_m_s;
        let mut out = Linearised {
            misfit_m: Vec::new(),
            slope: Vec::new(),
            by_position: Vec::new(),
        };
        for echo in self.echoes {
            let pose = self.samplers[echo.track].at(echo.time_s, values.time_offset_s[echo.track]);
            let Some(pose) = pose else {
                // Beyond the path's end at this offset: no observation.
                out.misfit_m.push(0.0);
                out.slope.push(vec![0.0; self.columns()]);
                out.by_position.push([0.0; 3]);
                continue;
            };
            let place = self.setting.reflector_m[echo.reflector];
            let prediction = predict(values, &pose, place, c);
            let own = |p: &Parameter| prediction.derivative(*p, echo.track, c);
            let mut slope: Vec<f64> = self.parameters.iter().map(own).collect();
            slope.resize(self.columns(), 0.0);
            let by_position = prediction.by_position();
            if let Some(first) = self.place_column(echo.reflector) {
                (0..3).for_each(|i| slope[first + i] = -by_position[i]);
            }
            out.misfit_m.push(echo.range_m - prediction.range_m);
            out.slope.push(slope);
            out.by_position.push(by_position);
        }
        out
    }

    fn normal(&self, at: &Linearised, noise: &Noise) -> Normal {
        let (n, m) = (self.columns(), self.nuisances);
        let mut information = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let mut cross = DMatrix::zeros(n, m);
        let mut own = Knots::new(m / 3);
        let mut own_gradient = DVector::zeros(m);
        for (k, echo) in self.echoes.iter().enumerate() {
            if !noise.kept[k] {
                continue;
            }
            let weight = noise.sigma_m[k].powi(-2);
            let slope = &at.slope[k];
            for i in 0..n {
                gradient[i] += weight * slope[i] * at.misfit_m[k];
                for j in 0..n {
                    information[(i, j)] += weight * slope[i] * slope[j];
                }
            }
            let nuisance = self.nuisance_slope(echo, at.by_position[k]);
            for (a, da) in &nuisance {
                own_gradient[*a] += weight * da * at.misfit_m[k];
                for i in 0..n {
                    cross[(i, *a)] += weight * slope[i] * da;
                }
                for (b, db) in &nuisance {
                    own.add(*a, *b, weight * da * db);
                }
            }
        }
        let data = own.clone();
        for drift in self.drifts.iter().flatten() {
            drift.add_prior(&mut own);
        }
        let own = own.factorised();
        let offset = own.solve(&own_gradient);
        let slope = own.solve_columns(&cross.transpose());
        self.without_places(
            information - &cross * &slope,
            gradient - &cross * &offset,
            (offset, slope),
            own.trace_of_inverse_times(&data),
        )
    }

    /// Eliminates the errors of the surveyed places, whose deviation is the survey's, from the normal equations.
    fn without_places(
        &self,
        information: DMatrix<f64>,
        gradient: DVector<f64>,
        nuisance: (DVector<f64>, DMatrix<f64>),
        nuisance_freedom: f64,
    ) -> Normal {
        let unknowns: Vec<usize> = (0..self.parameters.len()).collect();
        let places: Vec<usize> = (self.parameters.len()..information.nrows()).collect();
        let data = select(&information, &places, &places);
        let cross = select(&information, &unknowns, &places);
        let prior = DMatrix::from_diagonal_element(
            places.len(),
            places.len(),
            self.setting.survey_sigma_m.powi(-2),
        );
        let inverse = if places.is_empty() {
            data.clone()
        } else {
            invert(&(&data + prior))
        };
        let offset = &inverse * pick(&gradient, &places);
        let slope = &inverse * cross.transpose();
        Normal {
            information: select(&information, &unknowns, &unknowns) - &cross * &slope,
            gradient: pick(&gradient, &unknowns) - &cross * &offset,
            nuisance_freedom: nuisance_freedom + (inverse * data).trace(),
            nuisance,
            places: (offset, slope),
        }
    }

    /// The nuisances that an echo depends on, and its derivatives by them.
    fn nuisance_slope(&self, echo: &Echo, by_position: [f64; 3]) -> Vec<(usize, f64)> {
        let Some(drift) = &self.drifts[echo.track] else {
            return Vec::new();
        };
        drift
            .shares(echo.time_s)
            .iter()
            .flat_map(|share| (0..3).map(|i| (share.unknown + i, share.weight * by_position[i])))
            .collect()
    }

    /// The misfits after a step and the corresponding nuisances (m).
    fn residuals(
        &self,
        at: &Linearised,
        normal: &Normal,
        free: &[usize],
        step: &DVector<f64>,
    ) -> Vec<f64> {
        let mut full = DVector::zeros(self.parameters.len());
        for (k, i) in free.iter().enumerate() {
            full[*i] = step[k];
        }
        let (offset, slope) = &normal.places;
        let places = offset - slope * &full;
        let full =
            DVector::from_iterator(self.columns(), full.iter().chain(places.iter()).copied());
        let (offset, slope) = &normal.nuisance;
        let nuisance = offset - slope * &full;
        self.echoes
            .iter()
            .enumerate()
            .map(|(k, echo)| {
                let known: f64 = at.slope[k]
                    .iter()
                    .zip(full.iter())
                    .map(|(s, d)| s * d)
                    .sum();
                let drift: f64 = self
                    .nuisance_slope(echo, at.by_position[k])
                    .iter()
                    .map(|(i, d)| d * nuisance[*i])
                    .sum();
                at.misfit_m[k] - known - drift
            })
            .collect()
    }
}

/// Echoes used, and their scatter.
struct Noise {
    kept: Vec<bool>,
    sigma_m: Vec<f64>,
}

impl Adjustment<'_> {
    /// The noise before anything is known: the scatter of each reflector's misfits about their
    /// median.
    fn first_noise(&self, at: &Linearised) -> Noise {
        let mut centred = at.misfit_m.clone();
        for series in self.reflectors() {
            let middle = median(series.iter().map(|k| at.misfit_m[*k]));
            series.iter().for_each(|k| centred[*k] -= middle);
        }
        self.noise(&centred, 0.0)
    }

    /// Outliers, and the noise of the remaining residuals, reflector by reflector. `freedom` unknowns were
    /// estimated. Residuals correlated with their neighbours in time count as fewer.
    fn noise(&self, residual_m: &[f64], freedom: f64) -> Noise {
        let mut kept = vec![false; self.echoes.len()];
        let mut sigma_m = vec![1.0; self.echoes.len()];
        let relative = |k: usize| residual_m[k] / self.echoes[k].relative_sigma;
        let freedom_share = (freedom / self.echoes.len() as f64).min(0.9);
        for series in self.reflectors() {
            let spread = 1.4826 * median(series.iter().map(|k| relative(*k).abs()));
            let inside: Vec<usize> = series
                .iter()
                .copied()
                .filter(|k| relative(*k).abs() <= OUTLIER * spread.max(1e-9))
                .collect();
            let squares: f64 = inside.iter().map(|k| relative(*k).powi(2)).sum();
            let count = (inside.len() as f64 * (1.0 - freedom_share)).max(1.0);
            let unit_m = (squares / count * self.excess(&inside, relative))
                .sqrt()
                .max(1e-6);
            inside.iter().for_each(|k| kept[*k] = true);
            for k in series {
                sigma_m[k] = unit_m * self.echoes[k].relative_sigma;
            }
        }
        Noise { kept, sigma_m }
    }

    /// Ratio of the variance of a mean to that for independent residuals: (1 + ρ)/(1 − ρ) of a first-order
    /// process whose neighbours correlate with ρ, where ρ is significant.
    fn excess(&self, series: &[usize], relative: impl Fn(usize) -> f64) -> f64 {
        let power: f64 = series.iter().map(|k| relative(*k).powi(2)).sum();
        let product: f64 = series
            .windows(2)
            .filter(|w| self.echoes[w[0]].track == self.echoes[w[1]].track)
            .map(|w| relative(w[0]) * relative(w[1]))
            .sum();
        let correlation = (product / power.max(1e-30)).min(0.95);
        if correlation > 2.0 / (series.len() as f64).sqrt() {
            (1.0 + correlation) / (1.0 - correlation)
        } else {
            1.0
        }
    }

    /// The echoes of each reflector, in order.
    fn reflectors(&self) -> Vec<Vec<usize>> {
        let mut lists = vec![Vec::new(); self.setting.reflector_m.len()];
        for (k, echo) in self.echoes.iter().enumerate() {
            lists[echo.reflector].push(k);
        }
        lists.retain(|list| !list.is_empty());
        lists
    }
}

/// Rows and columns of a matrix.
pub(super) fn select(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
        matrix[(rows[i], columns[j])]
    })
}

fn pick(vector: &DVector<f64>, rows: &[usize]) -> DVector<f64> {
    DVector::from_fn(rows.len(), |i, _| vector[rows[i]])
}

/// The inverse of a symmetric matrix without negative eigenvalues. The matrix is scaled to a unit diagonal
/// first; a direction without information gets a very large variance instead of none.
pub(super) fn invert(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    const RIDGE: f64 = 1e-12;
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| matrix[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip())
        .collect();
    let mut scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let mut ridge = RIDGE;
    loop {
        for i in 0..n {
            scaled[(i, i)] += ridge;
        }
        if let Some(cholesky) = scaled.clone().cholesky() {
            let inverse = cholesky.inverse();
            return DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
        }
        ridge *= 10.0;
        if ridge > 1.0 {
            return DMatrix::from_diagonal_element(n, n, f64::INFINITY);
        }
    }
}

impl Normal {
    /// The estimate of a held unknown relative to its held value, and its deviation, when the free unknowns
    /// are estimated along with it (score test; SI units).
    pub fn wanted(&self, held: usize, free: &[usize]) -> (f64, f64) {
        let information = select(&self.information, free, free);
        let cross = select(&self.information, &[held], free);
        let inverse = invert(&information);
        let left = self.information[(held, held)] - (&cross * &inverse * cross.transpose())[(0, 0)];
        let gradient = self.gradient[held] - (&cross * inverse * pick(&self.gradient, free))[0];
        (gradient / left, left.max(0.0).sqrt().recip())
    }
}
