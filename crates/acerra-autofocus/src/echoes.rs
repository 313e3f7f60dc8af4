//! The echoes of several points in one pulse, separated by least squares.

use nalgebra::{Cholesky, ComplexField, DMatrix, DVector};
use num_complex::Complex64;

use crate::profiles::Profiles;
use crate::template::Template;

/// Share of a point's energy that is added to the diagonal of the normal matrix: points closer in
/// range than about a tenth of the resolution are not separated.
const RIDGE: f64 = 1e-3;

/// One point's echo in one pulse.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Echo {
    /// Complex amplitude of S(n) e^{−jκR}.
    pub amplitude: Complex64,
    /// Range of the envelope's maximum less R, m.
    pub delay_m: f64,
    /// Variance of the amplitude for noise of unit variance per frequency.
    pub amplitude_variance: f64,
    /// Variance of `delay_m` (m²) for noise of unit variance per frequency; infinite where the echo does not
    /// determine the delay.
    pub delay_variance_m2: f64,
}

/// All points' echoes in one pulse.
#[derive(Clone, Debug)]
pub(crate) struct Separated {
    /// One echo a point.
    pub echoes: Vec<Echo>,
    /// Energy of the spectrum explained by the echoes.
    pub captured: f64,
}

/// Separates the echoes of points at the ranges `range_m` in one pulse.
pub(crate) fn separate(
    profiles: &Profiles,
    template: &Template,
    pulse: usize,
    range_m: &[f64],
) -> Separated {
    let count = range_m.len();
    let (mut value, mut moment) = (DVector::zeros(count), DVector::zeros(count));
    for (k, r) in range_m.iter().enumerate() {
        let [v, d] = profiles.at(pulse, *r);
        value[k] = v;
        moment[k] = d;
    }
    let mut tables = [(); 3].map(|()| DMatrix::<Complex64>::zeros(count, count));
    for k in 0..count {
        for l in 0..=k {
            let c = template.correlation(range_m[k] - range_m[l]);
            for (table, v) in tables.iter_mut().zip(c) {
                table[(k, l)] = v;
                table[(l, k)] = v.conj();
            }
        }
    }
    let [mut normal, first, second] = tables;
    for k in 0..count {
        normal[(k, k)] += template.energy * RIDGE;
    }
    let nothing = || Separated {
        echoes: vec![Echo::default(); count],
        captured: 0.0,
    };
    let Some(factor) = Cholesky::new(normal) else {
        return nothing();
    };
    let amplitude = factor.solve(&value);
    let Some(root) = inverse_root(&factor.unpack()) else {
        return nothing();
    };
    let captured = value.dotc(&amplitude).re;
    // ∂E/∂R of a point is −jκ' S e^{−jκ'R} times its amplitude; the part explained by the amplitudes is
    // projected out.
    let rest = (&moment - &first * &amplitude) * Complex64::I;
    let taken = &root * &first;
    let projected = &second - taken.ad_mul(&taken);
    let information = DMatrix::from_fn(count, count, |k, l| {
        (amplitude[k].conj() * projected[(k, l)] * amplitude[l]).re
    });
    let right = DVector::from_fn(count, |k, _| (amplitude[k].conj() * rest[k]).re);
    let (delay, delay_variance) = delays(information, &right);
    let echoes = (0..count)
        .map(|k| Echo {
            amplitude: amplitude[k] * Complex64::cis(template.carrier * range_m[k]),
            delay_m: delay[k],
            amplitude_variance: root.column(k).norm_squared(),
            delay_variance_m2: delay_variance[k],
        })
        .collect();
    Separated { echoes, captured }
}

/// Changes of range by one Gauss–Newton step, and their variances for noise of unit variance.
fn delays(mut information: DMatrix<f64>, right: &DVector<f64>) -> (Vec<f64>, Vec<f64>) {
    let count = right.len();
    let greatest = information.diagonal().iter().copied().fold(0.0, f64::max);
    for k in 0..count {
        information[(k, k)] += 1e-4 * greatest;
    }
    match Cholesky::new(information) {
        Some(factor) if greatest > 0.0 => {
            let step = factor.solve(right);
            let variance = match inverse_root(&factor.unpack()) {
                Some(root) => (root.column_iter().map(|c| 0.5 * c.norm_squared())).collect(),
                None => vec![f64::INFINITY; count],
            };
            (step.iter().copied().collect(), variance)
        }
        _ => (vec![0.0; count], vec![f64::INFINITY; count]),
    }
}

/// The inverse R of a lower factor L of a matrix N, N⁻¹ = RᴴR; `None` where L is singular.
fn inverse_root<T: ComplexField>(lower: &DMatrix<T>) -> Option<DMatrix<T>> {
    let count = lower.nrows();
    lower.solve_lower_triangular(&DMatrix::identity(count, count))
}

/// −2 Re cᴴb + cᴴGc of one pulse: Σ_n |E − Σ c S e^{−jκR}|² less Σ_n |E|².
pub(crate) fn misfit(
    profiles: &Profiles,
    template: &Template,
    pulse: usize,
    model: &[(f64, Complex64)],
) -> f64 {
    let base: Vec<Complex64> = model
        .iter()
        .map(|(r, c)| c * Complex64::cis(-template.carrier * r))
        .collect();
    let mut sum = 0.0;
    for (k, (r, _)) in model.iter().enumerate() {
        sum -= 2.0 * (base[k].conj() * profiles.value(pulse, *r)).re;
        sum += base[k].norm_sqr() * template.energy;
        for (l, (other, _)) in model[..k].iter().enumerate() {
            let g = template.correlation_value(r - other);
            sum += 2.0 * (base[k].conj() * g * base[l]).re;
        }
    }
    sum
}
