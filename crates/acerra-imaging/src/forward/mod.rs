//! The forward operator: from an image to the spectra that its pixels would send back, Eq. (1) of
//! Catapano et al. 2020 in its discrete form, as fast as imaging.
//!
//! Both engines are the transposes of those of [`crate::plan`], bins and weights included, so that
//! ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩ holds far within the accuracy: what iterative inversions rest on.

mod bins;
mod check;
mod direct;
mod factorized;

use crate::direct::{DirectSpec, table_ranges_m};
use crate::factorized::{coarse_bytes, coarse_grid};
use crate::plan::choose::{Sample, choose_factorized, choose_spec};
use crate::plan::{SINGLE_PRECISION_FLOOR, check_request};
use crate::planar::{Planar, padded, split_parts};
use crate::rows::TiltedGrid;
use crate::weights::Weights;
use crate::{Engine, ImagingError, PlanOptions, Progress, Pulses, SelfCheck};
use direct::{Spreader, add_plain};
use factorized::FactorizedForward;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// A forward operator that is ready to be applied, any number of times.
///
/// Of the pulses only positions, frequencies, weights and the speed of light count, not the
/// spectra: E(m, n) = w_m Σ_i σ_i e^{−j4πf_n R/c} / R² is the adjoint of [`crate::Plan`] on the same
/// pulses and grid.
///
/// ```
/// use acerra_imaging::{Complex32, Complex64, Forward, PlanOptions, PlaneGrid, Pulses};
/// let position_m: Vec<[f64; 3]> = (0..20).map(|m| [0.0, 0.1 * f64::from(m) - 1.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let spectrum = vec![Complex64::ZERO; 20 * 50];
/// let weight = vec![1.0; 20];
/// let pulses = Pulses::new(&position_m, &frequency_hz, &spectrum, &weight, 3e8)?;
/// let grid = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
/// let forward = Forward::new(pulses, grid, &PlanOptions::default())?;
/// let mut image = vec![Complex32::ZERO; grid.len()];
/// image[0] = Complex32::new(1.0, 0.0);
/// let mut echo = vec![Complex64::ZERO; 20 * 50];
/// forward.run(&image, &mut echo, &|_| ())?;
/// let range_m = f64::hypot(5.0, 1.0); // from the first pulse to pixel 0
/// assert!((echo[0].norm() * range_m * range_m - 1.0).abs() < 1e-2);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub struct Forward<'a> {
    pulses: Pulses<'a>,
    grid: TiltedGrid,
    options: PlanOptions,
    method: Method,
    check: Option<SelfCheck>,
    reasons: Vec<String>,
    working_bytes: u128,
    weights: Weights,
}

enum Method {
    Direct(Box<Spreader>),
    Factorized(Box<FactorizedForward>),
    Reference,
}

impl<'a> Forward<'a> {
    /// Chooses, builds and checks.
    ///
    /// # Errors
    /// As [`crate::Plan::new`].
    pub fn new(
        pulses: Pulses<'a>,
        grid: impl Into<TiltedGrid>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        let grid = grid.into();
        check_request(&pulses, &grid, None, options)?;
        let weights = Weights::new(&pulses, &grid, true, options)?;
        let mut forward = Self {
            pulses,
            grid,
            options: *options,
            method: Method::Reference,
            check: None,
            reasons: Vec::new(),
            working_bytes: 0,
            weights,
        };
        if options.engine == Engine::Reference {
            forward
                .reasons
                .push("the double-precision sum was asked for".to_owned());
        } else if options.accuracy < SINGLE_PRECISION_FLOOR {
            forward.reasons.push(format!(
                "single precision cannot promise {:.1e}: the double-precision sum is run",
                options.accuracy
            ));
        } else if !forward.choose_factorized()? {
            forward.choose_direct()?;
        }
        forward.check_memory()?;
        Ok(forward)
    }

    /// The spectra to come may hold any frequency alike.
    fn power(&self) -> Vec<f64> {
        let n = self.pulses.frequency_hz().len();
        vec![1.0 / n as f64; n]
    }

    fn choose_factorized(&mut self) -> Result<bool, ImagingError> {
        if !matches!(self.options.engine, Engine::Auto | Engine::Factorized) {
            return Ok(false);
        }
        let (power, sample) = (self.power(), Sample::draw(&self.pulses, &self.grid));
        let level = self.options.level;
        for attempt in 0..6 {
            let accuracy = self.options.accuracy * 0.5f64.powi(attempt);
            let Some(choice) =
                choose_factorized(&self.pulses, &self.grid, &power, &sample, accuracy, level)
            else {
                return Ok(false);
            };
            // Adding to bins lane by lane, against reading them through windows.
            let direct_cost = choice.direct_cost.max(SPREAD_COST);
            if self.options.engine == Engine::Auto && choice.spec.cost > 0.6 * direct_cost {
                return Ok(false);
            }
            let ranges_m =
                table_ranges_m(&self.pulses, &coarse_grid(&self.grid, choice.spec.coarse));
            self.working_bytes = coarse_bytes(&choice.spec, &self.grid, &self.pulses)
                + self.image_bytes()
                + self.thread_bytes(&choice.inner, &ranges_m);
            self.check_memory()?;
            let factorized = FactorizedForward::new(
                &self.pulses,
                &self.grid,
                choice.spec,
                choice.inner,
                &self.weights,
                level,
            );
            let [dx, dy] = choice.spec.coarse;
            let check = check::compare(self, [dx, dy], &|grid, image, out| {
                factorized.run(&self.pulses, grid, image, out, &|_| ());
            });
            self.reasons.push(format!(
                "factorized, {level}: sub-apertures of {} pulses on grids of {dx} × {dy} pixels, \
                 range bins of {:.2} mm, degree {}",
                choice.spec.pulses,
                choice.inner.table.bin_m * 1e3,
                choice.inner.table.degree,
            ));
            if self.accept(check) {
                self.method = Method::Factorized(Box::new(factorized));
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn choose_direct(&mut self) -> Result<(), ImagingError> {
        let (power, sample) = (self.power(), Sample::draw(&self.pulses, &self.grid));
        let ranges_m = table_ranges_m(&self.pulses, &self.grid);
        for attempt in 0..6 {
            let accuracy = self.options.accuracy * 0.5f64.powi(attempt);
            let level = self.options.level;
            let (spec, _) = choose_spec(&self.pulses, &self.grid, &power, &sample, accuracy, level);
            self.working_bytes = self.image_bytes() + self.thread_bytes(&spec, &ranges_m);
            self.check_memory()?;
            let spreader = Spreader::new(&self.pulses, &ranges_m, spec, &self.weights, level);
            let check = check::compare(self, [1, 1], &|grid, image, out| {
                run_direct(&spreader, &self.pulses, grid, image, out, &|_| ());
            });
            self.reasons.push(format!(
                "direct, {level}: range bins of {:.2} mm, polynomials of degree {}",
                spec.table.bin_m * 1e3,
                spec.table.degree,
            ));
            if self.accept(check) {
                self.method = Method::Direct(Box::new(spreader));
                return Ok(());
            }
        }
        self.working_bytes = 0;
        self.check = None;
        self.reasons.push(
            "single precision did not reach the accuracy: the double-precision sum is run"
                .to_owned(),
        );
        Ok(())
    }

    fn accept(&mut self, check: SelfCheck) -> bool {
        // The check sees a few places only: errors that gather elsewhere need room.
        let good = check.error <= 0.6 * self.options.accuracy;
        if good {
            self.check = Some(check);
        } else {
            self.reasons.push(format!(
                "its self-check found {:.2e}: a finer plan is tried",
                check.error
            ));
        }
        good
    }

    fn image_bytes(&self) -> u128 {
        padded(self.grid.columns) as u128 * self.grid.rows as u128 * 8
    }

    fn thread_bytes(&self, spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
        Spreader::bytes_a_thread(spec, ranges_m) * rayon::current_num_threads() as u128
    }

    fn check_memory(&self) -> Result<(), ImagingError> {
        let bytes = self.memory_bytes();
        if bytes > self.options.memory_limit_bytes {
            return Err(ImagingError::TooLarge {
                what: "range bins, image and spectra",
                bytes,
                limit_bytes: self.options.memory_limit_bytes,
            });
        }
        Ok(())
    }

    /// Bytes that a run takes beside the image given, spectra included.
    #[must_use]
    pub fn memory_bytes(&self) -> u128 {
        let spectra = self.pulses.len() as u128 * self.pulses.frequency_hz().len() as u128;
        self.working_bytes + spectra * size_of::<Complex64>() as u128
    }

    /// What the self-check on random pixels found; `None` where the double-precision sum is run.
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

    /// The spectra `[M, N]` of `image` `[rows, columns]`, both row-major. `progress` is called from the
    /// working threads. The same bits come from any number of threads.
    ///
    /// # Errors
    /// Arrays of other lengths than the grid's and the pulses'.
    pub fn run(
        &self,
        image: &[Complex32],
        spectrum: &mut [Complex64],
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<(), ImagingError> {
        let pixels = self.grid.columns * self.grid.rows;
        let n = self.pulses.frequency_hz().len();
        crate::pulses::check_length("image", pixels, image.len())?;
        crate::pulses::check_length("spectrum", self.pulses.len() * n, spectrum.len())?;
        let total = pixels as u64 * self.pulses.len() as u64;
        let count = AtomicU64::new(0);
        let done = |more: u64| {
            let done = count.fetch_add(more, Ordering::Relaxed) + more;
            progress(Progress { done, total });
        };
        spectrum.fill(Complex64::ZERO);
        match &self.method {
            Method::Direct(spreader) => {
                run_direct(spreader, &self.pulses, &self.grid, image, spectrum, &done);
            }
            Method::Factorized(factorized) => {
                factorized.run(&self.pulses, &self.grid, image, spectrum, &done);
            }
            Method::Reference => {
                spectrum.par_chunks_mut(n).enumerate().for_each(|(m, out)| {
                    exact(&self.pulses, m, &self.grid, image, &self.weights, out);
                    done(pixels as u64);
                });
            }
        }
        Ok(())
    }
}

/// Lane-wise additions to a bin, in vector operations a pixel and pulse.
const SPREAD_COST: f64 = 5.0;

fn run_direct(
    spreader: &Spreader,
    pulses: &Pulses,
    grid: &TiltedGrid,
    image: &[Complex32],
    out: &mut [Complex64],
    done: &(dyn Fn(u64) + Sync),
) {
    let (real, imag) = split_parts(image, grid.columns);
    let planar = Planar {
        grid: *grid,
        stride: padded(grid.columns),
        real: &real,
        imag: &imag,
    };
    spreader.run(pulses, 0..pulses.len(), &[planar], out, done);
}

/// Adds the spectrum of pulse `m` in double precision.
fn exact(
    pulses: &Pulses,
    m: usize,
    grid: &TiltedGrid,
    image: &[Complex32],
    weights: &Weights,
    out: &mut [Complex64],
) {
    for (k, v) in image.iter().enumerate() {
        if *v != Complex32::ZERO {
            let (i, j) = (k % grid.columns, k / grid.columns);
            let value = Complex64::new(f64::from(v.re), f64::from(v.im));
            let point = grid.point_m(i as f64, j as f64);
            add_plain(pulses, m, point, weights, value, out);
        }
    }
}

impl fmt::Debug for Forward<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Forward({self})")
    }
}

impl fmt::Display for Forward<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "forward: {} × {} pixels, {} pulses of {} frequencies, relative error ≤ {:.1e} asked",
            self.grid.columns,
            self.grid.rows,
            self.pulses.len(),
            self.pulses.frequency_hz().len(),
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
        write!(f, "memory: {:.1} MB", self.memory_bytes() as f64 * 1e-6)
    }
}
