//! From a request (data, grid, accuracy) to a plan that keeps it, says why, and runs.

use crate::direct::{Direct, DirectSpec, table_ranges_m};
use crate::factorized::{Factorized, FactorizedSpec};
use crate::rows::{TiltedGrid, norm};
use crate::simd::SimdLevel;
use crate::simd::rows::Tally;
use crate::table::{RangeTable, TableSpec};
use crate::{ImagingError, Pulses, Spreading, reference};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Below this relative error single precision does not do and the reference itself is run.
const SINGLE_PRECISION_FLOOR: f64 = 4e-6;

/// Which algorithm makes the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Engine {
    /// The cheapest that keeps the accuracy.
    #[default]
    Auto,
    /// Every pulse at every pixel, through range tables and SIMD.
    Direct,
    /// Sub-apertures on coarse grids, merged: cost grows gently with pulses and pixels.
    Factorized,
    /// The double-precision sum over frequencies itself.
    Reference,
}

/// What is asked of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanOptions {
    /// Relative L2 error allowed against Eq. (3) in double precision; 10⁻³ by default.
    pub accuracy: f64,
    /// Weight by range; 1/R² by default.
    pub spreading: Spreading,
    /// Instruction set; the best of this processor by default.
    pub level: SimdLevel,
    /// Algorithm; chosen by cost by default.
    pub engine: Engine,
    /// Most bytes that tables and image may take together; 64 GiB by default.
    pub memory_limit_bytes: u128,
    /// Most random pixels of the self-check; 256 by default, at least 1.
    pub check_pixels: usize,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            accuracy: 1e-3,
            spreading: Spreading::default(),
            level: SimdLevel::detect(),
            engine: Engine::default(),
            memory_limit_bytes: crate::grid::DEFAULT_IMAGE_LIMIT_BYTES,
            check_pixels: 256,
        }
    }
}

/// How far a run has come, in pixel × pulse contributions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Contributions summed so far.
    pub done: u64,
    /// Contributions in the whole image.
    pub total: u64,
}

/// What a self-check of a plan found on random pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfCheck {
    /// Pixels compared with the double-precision sum.
    pub pixels: usize,
    /// Relative L2 error found on them.
    pub error: f64,
}

/// An image that is ready to be made, any number of times.
///
/// Making the plan builds the range tables and proves the accuracy on random pixels against the
/// double-precision sum; running it allocates nothing in its loops over pulses and pixels (the
/// factorized engine takes its coarse images once, at the start) and gives the same bits for any
/// number of threads.
///
/// ```
/// use acerra_imaging::{Complex64, Plan, PlanOptions, PlaneGrid, Pulses, SPEED_OF_LIGHT_M_S};
/// let position_m: Vec<[f64; 3]> = (0..20).map(|m| [0.0, 0.1 * f64::from(m) - 1.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let spectrum = vec![Complex64::new(1.0, 0.0); 20 * 50];
/// let weight = vec![1.0; 20];
/// let pulses = Pulses::new(&position_m, &frequency_hz, &spectrum, &weight, SPEED_OF_LIGHT_M_S)?;
/// let grid = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
/// let plan = Plan::new(pulses, grid, &PlanOptions::default())?;
/// println!("{plan}");
/// let mut image = vec![Default::default(); grid.len()];
/// plan.run(&mut image, &|progress| assert!(progress.done <= progress.total))?;
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug)]
pub struct Plan<'a> {
    pulses: Pulses<'a>,
    grid: TiltedGrid,
    options: PlanOptions,
    method: Method,
    check: Option<SelfCheck>,
    reasons: Vec<String>,
    table_bytes: u128,
}

#[derive(Debug)]
enum Method {
    Direct(Box<Direct>),
    Factorized(Box<Factorized>),
    Reference,
}

impl<'a> Plan<'a> {
    /// Chooses, builds and checks.
    ///
    /// # Errors
    /// An accuracy outside (0, 0.1], a level the processor lacks, an antenna exactly on a pixel
    /// (with 1/R²), or more memory than allowed.
    pub fn new(
        pulses: Pulses<'a>,
        grid: impl Into<TiltedGrid>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        let grid = grid.into();
        let options = *options;
        options.level.checked()?;
        if !(options.accuracy > 0.0 && options.accuracy <= 0.1) {
            return Err(ImagingError::OutOfRange {
                what: "accuracy",
                expected: "above 0 and at most 0.1",
                found: options.accuracy,
            });
        }
        if options.spreading == Spreading::InverseSquare {
            for (pulse, p) in pulses.position_m().iter().enumerate() {
                if let Some(point) = grid.pixel_at(*p) {
                    return Err(ImagingError::ZeroRange { pulse, point });
                }
            }
        }
        let mut plan = Self {
            pulses,
            grid,
            options,
            method: Method::Reference,
            check: None,
            reasons: Vec::new(),
            table_bytes: 0,
        };
        if options.engine == Engine::Reference {
            plan.reasons.push("the reference was asked for".to_owned());
        } else if options.accuracy < SINGLE_PRECISION_FLOOR {
            plan.reasons.push(format!(
                "single precision cannot promise {:.1e}: the double-precision sum is run",
                options.accuracy
            ));
        } else if !plan.choose_factorized()? {
            plan.choose_direct()?;
        }
        plan.check_memory()?;
        Ok(plan)
    }

    /// Takes the factorized engine where it was asked for or is clearly cheaper, and proves it;
    /// false where the direct engine is to be taken.
    fn choose_factorized(&mut self) -> Result<bool, ImagingError> {
        if !matches!(self.options.engine, Engine::Auto | Engine::Factorized) {
            return Ok(false);
        }
        let power = mean_power(&self.pulses);
        let sample = Sample::draw(&self.pulses, &self.grid);
        let level = self.options.level;
        for attempt in 0..4 {
            let accuracy = self.options.accuracy * 0.5f64.powi(attempt);
            let choose =
                |accuracy| choose_spec(&self.pulses, &self.grid, &power, &sample, accuracy, level);
            let (direct, direct_cost) = choose(accuracy);
            let (mut inner, _) = choose(0.8 * accuracy);
            inner.table.interleaved = true;
            // Exact ranges and gathered coefficients, in operations a value.
            let inner_cost = (32.0 + 26.0 * (inner.table.degree as f64 + 1.0) / 2.0)
                / level.lanes() as f64
                * 1.5;
            let band_hz = effective_band_hz(&self.pulses, &power, accuracy, &inner.table);
            let Some(spec) = FactorizedSpec::choose(
                &self.pulses,
                &self.grid,
                band_hz,
                0.85 * accuracy,
                inner_cost,
                level.lanes(),
            ) else {
                return Ok(false);
            };
            if self.options.engine == Engine::Auto && spec.cost > 0.6 * direct_cost {
                self.reasons.push(format!(
                    "factorized: {:.2} vector operations a contribution estimated, direct {:.2}",
                    spec.cost, direct_cost
                ));
                return Ok(false);
            }
            let coarse = Factorized::coarse_grid(&self.grid, spec.coarse);
            let ranges_m = table_ranges_m(&self.pulses, &coarse);
            self.table_bytes = RangeTable::bytes_for(&inner.table, &ranges_m)
                + Factorized::coarse_bytes(&spec, &self.grid, self.pulses.len());
            self.check_memory()?;
            let factorized = Factorized::new(
                &self.pulses,
                &self.grid,
                spec,
                inner,
                self.options.spreading,
                level,
            );
            let check = self.compare_patches(&factorized);
            self.reasons.push(format!(
                "factorized, {level}: sub-apertures of {} pulses on grids of {} × {} pixels                  (spatial frequencies up to {:.2} and {:.2} cycles a metre, interpolation error                  {:.1e}); range bins of {:.2} mm, degree {}; {:.2} vector operations a contribution                  estimated, {:.2} for the direct engine",
                spec.pulses,
                spec.coarse[0],
                spec.coarse[1],
                spec.bandwidth_a_metre[0],
                spec.bandwidth_a_metre[1],
                spec.interpolation_error,
                direct.table.bin_m.min(inner.table.bin_m) * 1e3,
                inner.table.degree,
                spec.cost,
                direct_cost,
            ));
            self.check = Some(check);
            if check.error <= self.options.accuracy {
                self.method = Method::Factorized(Box::new(factorized));
                return Ok(true);
            }
            self.reasons.push(format!(
                "its self-check found {:.2e}: a finer plan is tried",
                check.error
            ));
        }
        self.check = None;
        Ok(false)
    }

    /// Runs small patches at random places and compares pixels of each.
    fn compare_patches(&self, factorized: &Factorized) -> SelfCheck {
        const PATCHES: usize = 12;
        let grid = &self.grid;
        let work = self.pulses.len() * self.pulses.frequency_hz().len();
        let pixels = (30_000_000 / work.max(1)).clamp(48, 384) / PATCHES;
        let [dx, dy] = factorized.spec.coarse;
        let mut random = Random(0x5eed_0001);
        let places: Vec<(usize, usize, u64)> = (0..PATCHES)
            .map(|_| {
                // Patches start on the coarse lattice, as pixels of the whole image do.
                let i = random.below(grid.columns) / dx * dx;
                let j = random.below(grid.rows) / dy * dy;
                (i, j, random.next())
            })
            .collect();
        let found: Vec<(f64, f64)> = places
            .par_iter()
            .flat_map_iter(|&(i0, j0, seed)| {
                let patch = TiltedGrid {
                    origin_m: grid.point_m(i0 as f64, j0 as f64),
                    columns: (grid.columns - i0).min(4 * dx),
                    rows: (grid.rows - j0).min(2 * dy),
                    ..*grid
                };
                let mut out = vec![Complex32::ZERO; patch.columns * patch.rows];
                let spreading = self.options.spreading;
                factorized.run(&self.pulses, spreading, &patch, &mut out, &|_| ());
                let mut random = Random(seed);
                (0..pixels)
                    .map(|_| {
                        let k = random.below(out.len());
                        let (i, j) = (k % patch.columns, k / patch.columns);
                        let point = patch.point_m(i as f64, j as f64);
                        let expected = exact(&self.pulses, point, spreading);
                        let value = Complex64::new(f64::from(out[k].re), f64::from(out[k].im));
                        ((value - expected).norm_sqr(), expected.norm_sqr())
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        let difference: f64 = found.iter().map(|f| f.0).sum();
        let power: f64 = found.iter().map(|f| f.1).sum();
        SelfCheck {
            pixels: found.len(),
            error: if power > 0.0 {
                (difference / power).sqrt()
            } else {
                difference.sqrt()
            },
        }
    }

    fn choose_direct(&mut self) -> Result<(), ImagingError> {
        let ranges_m = table_ranges_m(&self.pulses, &self.grid);
        let power = mean_power(&self.pulses);
        let sample = Sample::draw(&self.pulses, &self.grid);
        let mut reached = f64::INFINITY;
        // The first try leaves room; should the data still be unkind, halve until it holds.
        for attempt in 0..6 {
            let accuracy = self.options.accuracy * 0.5f64.powi(attempt);
            let (spec, cost) = choose_spec(
                &self.pulses,
                &self.grid,
                &power,
                &sample,
                accuracy,
                self.options.level,
            );
            self.table_bytes = RangeTable::bytes_for(&spec.table, &ranges_m);
            self.check_memory()?;
            let direct = Direct::new(
                &self.pulses,
                &ranges_m,
                spec,
                self.options.spreading,
                self.options.level,
            );
            let (check, tally) = self.compare(&direct);
            reached = reached.min(check.error);
            self.check = Some(check);
            self.reasons
                .push(describe(&spec, self.options.level, &direct, cost, tally));
            if check.error <= self.options.accuracy {
                self.method = Method::Direct(Box::new(direct));
                return Ok(());
            }
            self.reasons.push(format!(
                "its self-check found {:.2e}: a finer plan is tried",
                check.error
            ));
        }
        self.check = None;
        self.table_bytes = 0;
        if self.options.level == SimdLevel::Avx512 {
            // Never trust an instruction set over the check.
            self.options.level = SimdLevel::Avx2;
            return self.choose_direct();
        }
        self.reasons.push(format!(
            "single precision reached {reached:.2e} here: the double-precision sum is run"
        ));
        Ok(())
    }

    /// Runs short pieces of rows at random places and compares a pixel of each.
    fn compare(&self, direct: &Direct) -> (SelfCheck, Tally) {
        let grid = &self.grid;
        let work = self.pulses.len() * self.pulses.frequency_hz().len();
        let most = self.options.check_pixels.max(1);
        let pixels = (40_000_000 / work.max(1)).clamp(most.min(24), most);
        let mut random = Random(0x1234_5678);
        let places: Vec<[usize; 3]> = (0..pixels)
            .map(|_| {
                let i = random.below(grid.columns);
                let start = i.saturating_sub(random.below(self.options.level.lanes()));
                [start, i, random.below(grid.rows)]
            })
            .collect();
        let found: Vec<(f64, f64, Tally)> = places
            .par_iter()
            .map(|&[start, i, j]| {
                let piece = TiltedGrid {
                    origin_m: grid.point_m(start as f64, j as f64),
                    columns: i - start + 1,
                    rows: 1,
                    ..*grid
                };
                let mut out = [Complex32::ZERO; crate::simd::MAX_LANES];
                let tally = direct.run(
                    &self.pulses,
                    self.options.spreading,
                    &piece,
                    &mut out[..=i - start],
                    &|_| (),
                );
                let point = grid.point_m(i as f64, j as f64);
                let expected = exact(&self.pulses, point, self.options.spreading);
                let value = out[i - start];
                let value = Complex64::new(f64::from(value.re), f64::from(value.im));
                ((value - expected).norm_sqr(), expected.norm_sqr(), tally)
            })
            .collect();
        let mut tally = Tally::default();
        let (mut difference, mut power) = (0.0, 0.0);
        for (d, p, t) in found {
            difference += d;
            power += p;
            tally.add(t);
        }
        let error = if power > 0.0 {
            (difference / power).sqrt()
        } else {
            difference.sqrt()
        };
        (SelfCheck { pixels, error }, tally)
    }

    fn check_memory(&self) -> Result<(), ImagingError> {
        let bytes = self.memory_bytes();
        if bytes > self.options.memory_limit_bytes {
            return Err(ImagingError::TooLarge {
                what: "range tables and image",
                bytes,
                limit_bytes: self.options.memory_limit_bytes,
            });
        }
        Ok(())
    }

    /// Bytes that range tables, coarse images and the image take together; beside the data nothing else grows
    /// with the size of the task.
    #[must_use]
    pub fn memory_bytes(&self) -> u128 {
        self.table_bytes + self.pixels() as u128 * size_of::<Complex32>() as u128
    }

    /// Pixels of the image.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.grid.columns * self.grid.rows
    }

    /// What the self-check on random pixels found; `None` where the reference itself is run.
    #[must_use]
    pub fn self_check(&self) -> Option<SelfCheck> {
        self.check
    }

    /// The engine chosen.
    #[must_use]
    pub fn engine(&self) -> Engine {
        match self.method {
            Method::Direct(_) => Engine::Direct,
            Method::Factorized(_) => Engine::Factorized,
            Method::Reference => Engine::Reference,
        }
    }

    /// The plan in words: what was chosen, why, what it costs and what the check found.
    #[must_use]
    pub fn explain(&self) -> String {
        self.to_string()
    }

    /// Makes the image, `[rows, columns]` row-major. `progress` is called from the working threads.
    ///
    /// # Errors
    /// An output of another length than the grid's.
    pub fn run(
        &self,
        image: &mut [Complex32],
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<(), ImagingError> {
        crate::pulses::check_length("image", self.pixels(), image.len())?;
        let pulses = self.pulses.len() as u64;
        let total = self.pixels() as u64 * pulses;
        let count = AtomicU64::new(0);
        let done = |pixels: u64| {
            let before = count.fetch_add(pixels * pulses, Ordering::Relaxed);
            progress(Progress {
                done: before + pixels * pulses,
                total,
            });
        };
        match &self.method {
            Method::Direct(direct) => {
                direct.run(
                    &self.pulses,
                    self.options.spreading,
                    &self.grid,
                    image,
                    &done,
                );
            }
            Method::Factorized(factorized) => {
                factorized.run(
                    &self.pulses,
                    self.options.spreading,
                    &self.grid,
                    image,
                    &done,
                );
            }
            Method::Reference => {
                image
                    .par_chunks_mut(self.grid.columns)
                    .enumerate()
                    .for_each(|(j, row)| {
                        row.par_iter_mut().enumerate().for_each(|(i, out)| {
                            let point = self.grid.point_m(i as f64, j as f64);
                            let v = exact(&self.pulses, point, self.options.spreading);
                            *out = Complex32::new(v.re as f32, v.im as f32);
                        });
                        done(row.len() as u64);
                    });
            }
        }
        Ok(())
    }
}

impl fmt::Display for Plan<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} × {} pixels, {} pulses of {} frequencies: {:.4} Gbp, relative error ≤ {:.1e} asked",
            self.grid.columns,
            self.grid.rows,
            self.pulses.len(),
            self.pulses.frequency_hz().len(),
            self.pixels() as f64 * self.pulses.len() as f64 * 1e-9,
            self.options.accuracy,
        )?;
        for reason in &self.reasons {
            writeln!(f, "{reason}")?;
        }
        if let Some(check) = self.check {
            writeln!(
                f,
                "self-check on {} random pixels: relative error {:.2e}",
                check.pixels, check.error
            )?;
        }
        write!(
            f,
            "memory: {:.1} MB tables and coarse images, {:.1} MB image",
            self.table_bytes as f64 * 1e-6,
            self.pixels() as f64 * 8e-6
        )
    }
}

/// Images `grid` with a plan of its own.
///
/// # Errors
/// As [`Plan::new`].
pub fn image(
    pulses: Pulses,
    grid: impl Into<TiltedGrid>,
    options: &PlanOptions,
) -> Result<Vec<Complex32>, ImagingError> {
    let plan = Plan::new(pulses, grid, options)?;
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, &|_| ())?;
    Ok(image)
}

/// Eq. (3) at a point in double precision; for even frequencies by turning phasors, renewed often
/// enough to stay exact.
fn exact(pulses: &Pulses, point: [f64; 3], spreading: Spreading) -> Complex64 {
    const RENEW: usize = 32;
    let step = pulses.frequency_step_hz();
    let f = pulses.frequency_hz();
    let mut sum = Complex64::ZERO;
    for (m, p) in pulses.position_m().iter().enumerate() {
        let range = reference::range_m(*p, point);
        let weight = pulses.weight()[m] * spreading.weight(range);
        let Some(step) = step else {
            sum += reference::pulse_at_range(pulses, m, range) * weight;
            continue;
        };
        let delay = 4.0 * std::f64::consts::PI * range / pulses.light_speed_m_s();
        let turn = Complex64::cis(step * delay);
        let mut profile = Complex64::ZERO;
        for (k, e) in pulses.spectrum_of(m).chunks(RENEW).enumerate() {
            // Horner from the last frequency of the piece to its first.
            let piece = e
                .iter()
                .rev()
                .fold(Complex64::ZERO, |sum, e| sum * turn + e);
            profile += piece * Complex64::cis(f[k * RENEW] * delay);
        }
        sum += profile * weight;
    }
    sum
}

/// Mean power at each frequency over the weighted pulses.
fn mean_power(pulses: &Pulses) -> Vec<f64> {
    let mut power = vec![0.0; pulses.frequency_hz().len()];
    for (m, w) in pulses.weight().iter().enumerate() {
        for (p, e) in power.iter_mut().zip(pulses.spectrum_of(m)) {
            *p += e.norm_sqr() * w * w;
        }
    }
    let total: f64 = power.iter().sum();
    if total > 0.0 && total.is_finite() {
        power.iter_mut().for_each(|p| *p /= total);
    } else {
        power.fill(1.0);
    }
    power
}

/// Lowest, carrier and highest frequency that matter at `accuracy`, given the power at each.
fn effective_band_hz(pulses: &Pulses, power: &[f64], accuracy: f64, table: &TableSpec) -> [f64; 3] {
    let f = pulses.frequency_hz();
    let carrier = f[table.carrier];
    let mut order: Vec<usize> = (0..f.len()).collect();
    order.sort_by(|a, b| (f[*b] - carrier).abs().total_cmp(&(f[*a] - carrier).abs()));
    // Frequencies at the edges may alias while what they hold stays well below the error allowed.
    let allowed = (0.2 * accuracy).powi(2) * power.iter().sum::<f64>();
    let mut left_out = 0.0;
    let widest = order
        .into_iter()
        .find(|k| {
            left_out += power[*k];
            left_out > allowed
        })
        .map_or(0.0, |k| (f[k] - carrier).abs());
    [carrier - widest, carrier, carrier + widest]
}

/// Random pairs of pulse and pixel: range and sine of the angle to the row.
struct Sample(Vec<(f64, f64)>);

impl Sample {
    fn draw(pulses: &Pulses, grid: &TiltedGrid) -> Self {
        let mut random = Random(0x9e37_79b9);
        let length = norm(grid.u_m).max(1e-12);
        Self(
            (0..256)
                .map(|_| {
                    let p = pulses.position_m()[random.below(pulses.len())];
                    let (i, j) = (random.below(grid.columns), random.below(grid.rows));
                    let point = grid.point_m(i as f64, j as f64);
                    let d = std::array::from_fn(|a| point[a] - p[a]);
                    let range = norm(d).max(1e-12);
                    (
                        range,
                        (crate::rows::dot(d, grid.u_m) / length / range).abs(),
                    )
                })
                .collect(),
        )
    }

    fn share(&self, f: impl Fn(f64, f64) -> bool) -> f64 {
        self.0.iter().filter(|(r, s)| f(*r, *s)).count() as f64 / self.0.len() as f64
    }
}

/// The cheapest table and expansion that keep `accuracy`, and their cost in operations a pixel.
fn choose_spec(
    pulses: &Pulses,
    grid: &TiltedGrid,
    power: &[f64],
    sample: &Sample,
    accuracy: f64,
    level: SimdLevel,
) -> (DirectSpec, f64) {
    let n = pulses.frequency_hz().len();
    let lanes = level.lanes() as f64;
    let pixel = norm(grid.u_m).max(1e-12);
    let half = 0.5 * 15.0 * pixel; // groups are 16 pixels at every level
    let half_vector = 0.5 * (lanes - 1.0) * pixel;
    let phase_tolerance_rad = 0.5 * accuracy;
    let mut best: Option<(DirectSpec, f64)> = None;
    for degree in 1..=3 {
        let Some(table) = choose_table(pulses, power, degree, 0.7 * accuracy) else {
            continue;
        };
        let alpha = table.carrier_rad(pulses);
        let fine_carrier = carrier_error(alpha, 3) > 0.6 * accuracy || degree > 1;
        let wave = alpha / table.bin_m; // rad per metre of range
        let third = |r: f64| 0.08 * half.powi(3) / (r * r) * wave;
        let cubic = fine_carrier || sample.share(|r, _| third(r) > phase_tolerance_rad) > 0.02;
        let left_out = |r: f64| {
            if cubic {
                0.5 * half.powi(4) / (r * r * r) * wave
            } else {
                third(r)
            }
        };
        let window = sample.share(|r, s| {
            let bend = half * (1.0 - s * s) / r;
            let span = half_vector * (2.0 * (s + bend) + half_vector * (1.0 - s * s) / (2.0 * r))
                / table.bin_m;
            span < lanes - 1.05 && left_out(r) < phase_tolerance_rad
        });
        // Vector operations for one vector of pixels, as counted in the kernel.
        let terms = if fine_carrier { 4.0 } else { 3.0 };
        let lookups = 2.0 * (degree as f64 + 1.0);
        let common = 5.0 + 2.0 * degree as f64 + 2.0 * terms + 4.0 + 6.0;
        let fast = common + lookups + if cubic { 3.0 } else { 2.0 };
        let slow = common + 20.0 + lookups * (4.0 + lanes);
        let cost = (window * fast + (1.0 - window) * slow) / lanes;
        let spec = DirectSpec {
            table,
            fine_carrier,
            cubic,
            phase_tolerance_rad,
            plain_below_m: table.folding_range_m(0.1 * accuracy),
        };
        if best.as_ref().is_none_or(|(_, c)| cost < *c) {
            best = Some((spec, cost));
        }
    }
    best.unwrap_or_else(|| {
        // Not reached for accuracies a plan accepts; a very fine cubic table is safe.
        let table = TableSpec {
            bin_m: fine_bin_m(pulses),
            degree: 3,
            period: None,
            carrier: n / 2,
            interleaved: false,
        };
        let spec = DirectSpec {
            table,
            fine_carrier: true,
            cubic: true,
            phase_tolerance_rad,
            plain_below_m: table.folding_range_m(0.1 * accuracy),
        };
        (spec, 100.0)
    })
}

/// Largest error of the carrier's polynomials over a bin turning by `alpha`: cosine of `terms` terms
/// and sine of one less, interpolated at Chebyshev nodes.
fn carrier_error(alpha: f64, terms: i32) -> f64 {
    let x = 0.5 * alpha;
    let left = |power: i32| {
        let factorial: f64 = (1..=power).map(f64::from).product();
        x.powi(power) / factorial
    };
    let cosine = left(2 * terms) / 2f64.powi(2 * terms - 1);
    let sine = left(2 * terms - 1) / 2f64.powi(2 * terms - 3);
    cosine.max(sine)
}

fn fine_bin_m(pulses: &Pulses) -> f64 {
    let top = pulses.frequency_hz().iter().copied().fold(0.0, f64::max);
    pulses.light_speed_m_s() / top / 40.0
}

/// The widest bins of a degree that keep `accuracy`.
fn choose_table(pulses: &Pulses, power: &[f64], degree: usize, accuracy: f64) -> Option<TableSpec> {
    let f = pulses.frequency_hz();
    let centre = 0.5
        * (f.iter().copied().fold(f64::INFINITY, f64::min) + f.iter().copied().fold(0.0, f64::max));
    let carrier =
        (0..f.len()).min_by(|a, b| (f[*a] - centre).abs().total_cmp(&(f[*b] - centre).abs()))?;
    let good = |spec: &TableSpec| {
        let alpha = spec.carrier_rad(pulses);
        alpha < 2.6
            && carrier_error(alpha, 4) <= 0.3 * accuracy
            && spec.fit_error(pulses, power) <= accuracy
    };
    let spec = |bin_m, period| TableSpec {
        bin_m,
        degree,
        period,
        carrier,
        interleaved: false,
    };
    if let Some(step) = pulses.frequency_step_hz() {
        let period_m = pulses.light_speed_m_s() / (2.0 * step);
        let shortest = (f.len() + 1).max(16);
        return smooth_lengths(shortest, shortest * 4096)
            .into_iter()
            .map(|length| spec(period_m / length as f64, Some(length)))
            .find(good);
    }
    let mut bin_m = 20.0 * fine_bin_m(pulses);
    for _ in 0..80 {
        if good(&spec(bin_m, None)) {
            return Some(spec(bin_m, None));
        }
        bin_m *= 0.93;
    }
    None
}

/// Lengths 2^a·3^b·5^c from `from` to `to`, about 4 % apart, rising.
fn smooth_lengths(from: usize, to: usize) -> Vec<usize> {
    let mut lengths = Vec::new();
    for b in 0..3 {
        for c in 0..3 {
            let mut length = 4 * 3usize.pow(b) * 5usize.pow(c);
            while length <= to {
                if length >= from {
                    lengths.push(length);
                }
                length *= 2;
            }
        }
    }
    lengths.sort_unstable();
    lengths
}

fn describe(
    spec: &DirectSpec,
    level: SimdLevel,
    direct: &Direct,
    cost: f64,
    tally: Tally,
) -> String {
    let vectors = (tally.window + tally.gather + tally.plain).max(1) as f64;
    format!(
        "direct, {level}: range bins of {:.2} mm ({}), polynomials of degree {}, carrier {:.2} rad \
         a bin, range {} along a vector; {:.1} vector operations a pixel estimated; {:.1} % of \
         vectors from register windows, {:.1} % by gathers, {:.1} % next to an antenna in double \
         precision",
        spec.table.bin_m * 1e3,
        match spec.table.period {
            Some(length) => format!("{length} a period"),
            None => "uneven frequencies".to_owned(),
        },
        spec.table.degree,
        direct.carrier_rad(),
        if spec.cubic { "cubic" } else { "quadratic" },
        cost,
        100.0 * tally.window as f64 / vectors,
        100.0 * tally.gather as f64 / vectors,
        100.0 * tally.plain as f64 / vectors,
    )
}

/// A small generator for places to check (Steele, Lea & Flood 2014, SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next()) * n as u128) >> 64) as usize
    }
}
