//! From a request (data, grid, accuracy) to a plan that keeps it, says why, and runs.

pub(crate) mod check;
pub(crate) mod choose;
pub(crate) mod estimate;
mod options;

pub use options::{Engine, PlanOptions, Progress, SelfCheck};

use crate::direct::{Direct, DirectSpec, MARGIN_COLUMNS, table_ranges_m};
use crate::factorized::{Factorized, coarse_bytes, coarse_grid};
use crate::rows::TiltedGrid;
use crate::simd::SimdLevel;
use crate::simd::rows::Tally;
use crate::simd::surface::Relief;
use crate::table::RangeTable;
use crate::weights::Weights;
use crate::{ImagingError, Pulses, Spreading, SurfaceGrid};
use check::exact;
use choose::{Choice, Sample, choose_factorized, choose_spec, mean_power};
use num_complex::Complex32;
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Below this relative error single precision does not do and the reference itself is run.
pub(crate) const SINGLE_PRECISION_FLOOR: f64 = 4e-6;

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
    surface: Option<&'a SurfaceGrid>,
    options: PlanOptions,
    weights: Weights,
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
        Self::build(pulses, grid.into(), None, options)
    }

    /// As [`Plan::new`], for pixels on a surface. The direct engine makes it (or the reference): the
    /// factorized one interpolates between pixels of a plane.
    ///
    /// # Errors
    /// As [`Plan::new`].
    ///
    /// ```
    /// use acerra_imaging::{Complex64, Plan, PlanOptions, PlaneGrid, Pulses, SurfaceGrid};
    /// let position_m: Vec<[f64; 3]> = (0..20).map(|m| [0.0, 0.1 * f64::from(m) - 1.0, 5.0]).collect();
    /// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
    /// let spectrum = vec![Complex64::new(1.0, 0.0); 20 * 50];
    /// let pulses = Pulses::new(&position_m, &frequency_hz, &spectrum, &[1.0; 20], 3e8)?;
    /// let base = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
    /// let slope = |x_m: f64, _: f64| Ok::<_, acerra_imaging::ImagingError>(0.2 * x_m);
    /// let ground = SurfaceGrid::from_fn(base, slope)?;
    /// let plan = Plan::on_surface(pulses, &ground, &PlanOptions::default())?;
    /// let mut image = vec![Default::default(); ground.len()];
    /// plan.run(&mut image, &|_| ())?;
    /// assert!(plan.self_check().is_some_and(|check| check.error <= 1e-3));
    /// # Ok::<(), acerra_imaging::ImagingError>(())
    /// ```
    pub fn on_surface(
        pulses: Pulses<'a>,
        surface: &'a SurfaceGrid,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        Self::build(pulses, (*surface.base()).into(), Some(surface), options)
    }

    fn build(
        pulses: Pulses<'a>,
        grid: TiltedGrid,
        surface: Option<&'a SurfaceGrid>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        let options = *options;
        check_request(&pulses, &grid, surface, &options)?;
        let weights = Weights::new(&pulses, &grid, surface.is_none(), &options)?;
        let mut plan = Self {
            pulses,
            grid,
            surface,
            options,
            weights,
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
        if self.surface.is_some() {
            self.reasons
                .push("a surface: every pulse at every pixel, by the direct engine".to_owned());
            return Ok(false);
        }
        let power = mean_power(&self.pulses);
        let sample = Sample::draw(&self.pulses, &self.grid);
        let level = self.options.level;
        for attempt in 0..4 {
            let accuracy = self.options.accuracy * 0.5f64.powi(attempt);
            let Some(Choice {
                spec,
                inner,
                direct_cost,
            }) = choose_factorized(&self.pulses, &self.grid, &power, &sample, accuracy, level)
            else {
                return Ok(false);
            };
            if self.options.engine == Engine::Auto && spec.cost > 0.9 * direct_cost {
                self.reasons.push(format!(
                    "factorized: {:.2} vector operations a contribution estimated, direct {:.2}",
                    spec.cost, direct_cost
                ));
                return Ok(false);
            }
            let coarse = coarse_grid(&self.grid, spec.coarse);
            let ranges_m = table_ranges_m(&self.pulses, &coarse);
            self.table_bytes = RangeTable::bytes_for(&inner.table, &ranges_m)
                + coarse_bytes(&spec, &self.grid, &self.pulses);
            self.check_memory()?;
            let factorized =
                Factorized::new(&self.pulses, &self.grid, spec, inner, &self.weights, level);
            let check = self.compare_patches(&factorized);
            self.reasons.push(format!(
                "factorized, {level}: sub-apertures of {} pulses on grids of {} × {} pixels (spatial \
                 frequencies up to {:.2} and {:.2} cycles a metre, interpolation error {:.1e}); \
                 range bins of {:.2} mm, degree {}; {:.2} vector operations a contribution \
                 estimated, {:.2} for the direct engine",
                spec.pulses,
                spec.coarse[0],
                spec.coarse[1],
                spec.bandwidth_a_metre[0],
                spec.bandwidth_a_metre[1],
                spec.interpolation_error,
                inner.table.bin_m * 1e3,
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
    fn choose_direct(&mut self) -> Result<(), ImagingError> {
        let ranges_m = match self.surface {
            Some(surface) => {
                let bounds = |p: &[f64; 3]| surface.ranges_m(*p, MARGIN_COLUMNS);
                self.pulses.position_m().iter().map(bounds).collect()
            }
            None => table_ranges_m(&self.pulses, &self.grid),
        };
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
                &self.weights,
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
    /// Heights over the grid, where there are any.
    fn relief(&self) -> Option<Relief<'a>> {
        self.surface.map(|surface| Relief {
            heights_m: surface.relief_m(),
            stride: self.grid.columns,
        })
    }

    /// Where pixel (i, j) stands.
    fn point_m(&self, i: usize, j: usize) -> [f64; 3] {
        match self.surface {
            Some(surface) => surface.point_m(j * self.grid.columns + i),
            None => self.grid.point_m(i as f64, j as f64),
        }
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

    /// Pixel × pulse contributions to the image.
    #[must_use]
    pub fn contributions(&self) -> u64 {
        (self.pixels() as u64).saturating_mul(self.pulses.len() as u64)
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
                direct.run_over(
                    &self.pulses,
                    0..self.pulses.len(),
                    &self.weights,
                    &self.grid,
                    self.relief(),
                    image,
                    &done,
                );
            }
            Method::Factorized(factorized) => {
                factorized.run(&self.pulses, &self.weights, &self.grid, image, &done);
            }
            Method::Reference => {
                image
                    .par_chunks_mut(self.grid.columns)
                    .enumerate()
                    .for_each(|(j, row)| {
                        row.par_iter_mut().enumerate().for_each(|(i, out)| {
                            let point = self.point_m(i, j);
                            let v = exact(&self.pulses, point, &self.weights);
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

/// What no plan can be made for.
pub(crate) fn check_request(
    pulses: &Pulses,
    grid: &TiltedGrid,
    surface: Option<&SurfaceGrid>,
    options: &PlanOptions,
) -> Result<(), ImagingError> {
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
            let on = surface.map_or_else(|| grid.pixel_at(*p), |s| s.pixel_at(*p));
            if let Some(point) = on {
                return Err(ImagingError::ZeroRange { pulse, point });
            }
        }
    }
    Ok(())
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
