//! The double sums over pulses and frequencies behind the theory.

use rayon::prelude::*;

use super::geometry::{View, dot};

/// One term of the image's sum for every pulse and frequency of the quadrature.
pub(super) struct Nodes<'a> {
    view: &'a View,
    pulse: Vec<usize>,
    wavenumber: Vec<f64>,
    share: Vec<f64>,
}

/// Linear map from the sines of the terms' phase errors to the peak's shift, and the curvature of the peak.
pub(super) struct ShiftFunctional {
    /// Shift (along, across) per unit of sin θ, one pair a node.
    per_sine: Vec<[f64; 2]>,
    /// Negative second derivatives of the coherent power.
    pub curvature: [[f64; 2]; 2],
}

/// Results of the double sum.
pub(super) struct Sums {
    /// Expected power at the place itself; 1 without errors.
    pub power: f64,
    /// Covariance of the shift by speckle, m².
    pub shift: [[f64; 2]; 2],
    /// Expected power at the points of the cuts.
    pub cut: Vec<f64>,
}

impl<'a> Nodes<'a> {
    pub fn of(view: &'a View) -> Self {
        let mut nodes = Self {
            view,
            pulse: vec![],
            wavenumber: vec![],
            share: vec![],
        };
        for (m, share) in view.share.iter().enumerate() {
            for [k, v] in &view.wavenumber {
                nodes.pulse.push(m);
                nodes.wavenumber.push(*k);
                nodes.share.push(share * v);
            }
        }
        nodes
    }

    fn indices(&self) -> std::ops::Range<usize> {
        0..self.pulse.len()
    }

    /// Mean amplitude e^{−σ²/2} of a node under covariance `c`.
    fn kept(&self, a: usize, c: &[f64]) -> f64 {
        let n = self.view.pulse.len();
        (-0.5 * self.wavenumber[a].powi(2) * c[self.pulse[a] * (n + 1)]).exp()
    }

    /// Power of the mean image at the place itself.
    pub fn coherent_power(&self, c: &[f64]) -> f64 {
        self.indices()
            .map(|a| self.share[a] * self.kept(a, c))
            .sum::<f64>()
            .powi(2)
    }

    /// Power of the image without errors at points whose excess ranges, `[points][pulses]`, are
    /// `cuts`.
    pub fn ideal_cut(&self, cuts: &[Vec<f64>]) -> Vec<f64> {
        cuts.iter()
            .map(|excess| {
                let (mut re, mut im) = (0.0, 0.0);
                for a in self.indices() {
                    let (sin, cos) = (self.wavenumber[a] * excess[self.pulse[a]]).sin_cos();
                    re += self.share[a] * cos;
                    im += self.share[a] * sin;
                }
                re * re + im * im
            })
            .collect()
    }

    /// The zero of the gradient of |P|², to first order in the fluctuation of P about its mean: Δ = (−Hessian
    /// of the mean power)⁻¹ · 2 Σ share (S₀ k g − S₁) sin θ, with S₀ = Σ share ρ and S₁ = Σ share ρ k g over
    /// nodes of mean amplitude ρ.
    pub fn shift_functional(&self, c: &[f64]) -> Option<ShiftFunctional> {
        let slope = |a: usize| self.view.gradient[self.pulse[a]].map(|g| self.wavenumber[a] * g);
        let (mut s0, mut s1, mut s2) = (0.0, [0.0; 2], [[0.0; 2]; 2]);
        for a in self.indices() {
            let mean = self.share[a] * self.kept(a, c);
            let kg = slope(a);
            s0 += mean;
            for i in 0..2 {
                s1[i] += mean * kg[i];
                for j in 0..2 {
                    s2[i][j] += mean * kg[i] * kg[j];
                }
            }
        }
        let curvature = [0, 1].map(|i| [0, 1].map(|j| 2.0 * (s0 * s2[i][j] - s1[i] * s1[j])));
        let inverse = self.view.invert(curvature)?;
        let per_sine = self
            .indices()
            .map(|a| {
                let kg = slope(a);
                let push = [0, 1].map(|i| 2.0 * self.share[a] * (s0 * kg[i] - s1[i]));
                inverse.map(|row| row[0] * push[0] + row[1] * push[1])
            })
            .collect();
        Some(ShiftFunctional {
            per_sine,
            curvature,
        })
    }

    /// Covariance of the linear shift Hε with the shift by speckle, one value an axis.
    ///
    /// `residual` is the covariance of ε − GHε, `linear` the covariance of Hε; E[x sin θ] = Cov(x, θ)
    /// e^{−σ²/2} for Gaussian x and θ.
    pub fn cross(
        &self,
        c: &[f64],
        residual: &[f64],
        h: &[Vec<f64>; 2],
        linear: &[[f64; 2]; 2],
        functional: &ShiftFunctional,
    ) -> [f64; 2] {
        let n = self.view.pulse.len();
        [0, 1].map(|i| {
            let with_shift: Vec<f64> = c
                .chunks(n)
                .zip(&self.view.gradient)
                .map(|(row, g)| dot(row, &h[i]) - g[0] * linear[0][i] - g[1] * linear[1][i])
                .collect();
            self.indices()
                .map(|a| {
                    // θ = −k(ε − GHε) + …: the phase of a term falls as its range error grows, and
                    // the functional was derived for e^{−jkε}, so signs cancel.
                    functional.per_sine[a][i]
                        * self.kept(a, residual)
                        * self.wavenumber[a]
                        * with_shift[self.pulse[a]]
                })
                .sum()
        })
    }

    /// The double sum over nodes under covariance `c` (m², of range errors).
    ///
    /// Cov(θ, θ′) = k k′ c; coherence of two terms exp(−Var(θ − θ′)/2);
    /// E[sin θ sin θ′] = e^{−(σ² + σ′²)/2} sinh Cov(θ, θ′).
    pub fn sums(&self, c: &[f64], functional: Option<&ShiftFunctional>, cuts: &[Vec<f64>]) -> Sums {
        let n = self.view.pulse.len();
        let whole: f64 = self.view.share.iter().map(|w| w * w).sum();
        let same_scale = self.view.speckle_scale;
        // One pulse has no others.
        let other_scale = (1.0 - whole * same_scale) / (1.0 - whole).max(f64::MIN_POSITIVE);
        let phasor: Vec<Vec<[f64; 2]>> = self
            .indices()
            .map(|a| {
                cuts.iter()
                    .map(|excess| {
                        let (sin, cos) = (self.wavenumber[a] * excess[self.pulse[a]]).sin_cos();
                        [cos, sin]
                    })
                    .collect()
            })
            .collect();
        let variance: Vec<f64> = self
            .indices()
            .map(|a| self.wavenumber[a].powi(2) * c[self.pulse[a] * (n + 1)])
            .collect();
        let empty = || Sums {
            power: 0.0,
            shift: [[0.0; 2]; 2],
            cut: vec![0.0; cuts.len()],
        };
        // Collected in order and added one by one, so that the bits do not depend on the threads.
        let rows: Vec<Sums> = self
            .indices()
            .into_par_iter()
            .map(|a| {
                let mut sum = empty();
                // Each pair counts twice, once for either order.
                for b in 0..=a {
                    let same = self.pulse[a] == self.pulse[b];
                    let twice = if a == b { 1.0 } else { 2.0 };
                    let scale = twice * if same { same_scale } else { other_scale };
                    let together = self.wavenumber[a]
                        * self.wavenumber[b]
                        * c[self.pulse[a] * n + self.pulse[b]];
                    let apart = -0.5 * (variance[a] + variance[b]);
                    let coherence = (apart + together).exp();
                    let weight = scale * self.share[a] * self.share[b] * coherence;
                    sum.power += weight;
                    for ((total, p), q) in sum.cut.iter_mut().zip(&phasor[a]).zip(&phasor[b]) {
                        *total += weight * (p[0] * q[0] + p[1] * q[1]);
                    }
                    if let Some(f) = functional {
                        let sines = 0.5 * scale * (coherence - (apart - together).exp());
                        let (p, q) = (f.per_sine[a], f.per_sine[b]);
                        for i in 0..2 {
                            for j in 0..2 {
                                sum.shift[i][j] += 0.5 * sines * (p[i] * q[j] + q[i] * p[j]);
                            }
                        }
                    }
                }
                sum
            })
            .collect();
        rows.into_iter().fold(empty(), |mut total, row| {
            total.power += row.power;
            for i in 0..2 {
                for j in 0..2 {
                    total.shift[i][j] += row.shift[i][j];
                }
            }
            for (a, b) in total.cut.iter_mut().zip(&row.cut) {
                *a += b;
            }
            total
        })
    }
}
