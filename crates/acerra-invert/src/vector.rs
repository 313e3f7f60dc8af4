//! Inner products and sums of long complex vectors, bitwise equal for any number of threads.

use acerra_imaging::Complex64;
use rayon::prelude::*;

/// Values of a partial sum.
const CHUNK: usize = 1 << 14;

/// ⟨a, b⟩ = Σ a* b.
pub(crate) fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    let parts: Vec<Complex64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum())
        .collect();
    parts.into_iter().sum()
}

/// ‖a‖².
pub(crate) fn power(a: &[Complex64]) -> f64 {
    let parts: Vec<f64> = a
        .par_chunks(CHUNK)
        .map(|a| a.iter().map(Complex64::norm_sqr).sum())
        .collect();
    parts.into_iter().sum()
}

/// ‖a‖.
pub(crate) fn norm(a: &[Complex64]) -> f64 {
    power(a).sqrt()
}

/// `y` += `factor` · `x`.
pub(crate) fn add_scaled(y: &mut [Complex64], factor: Complex64, x: &[Complex64]) {
    y.par_chunks_mut(CHUNK)
        .zip(x.par_chunks(CHUNK))
        .for_each(|(y, x)| y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x));
}

/// `y` = `x` + `factor` · `y`.
pub(crate) fn scale_and_add(y: &mut [Complex64], factor: f64, x: &[Complex64]) {
    y.par_chunks_mut(CHUNK)
        .zip(x.par_chunks(CHUNK))
        .for_each(|(y, x)| y.iter_mut().zip(x).for_each(|(y, x)| *y = x + *y * factor));
}

/// `y` *= `factor`.
pub(crate) fn scale(y: &mut [Complex64], factor: f64) {
    y.par_chunks_mut(CHUNK)
        .for_each(|y| y.iter_mut().for_each(|y| *y *= factor));
}

/// `y`ᵢ *= `weight`ᵢ.
pub(crate) fn multiply(y: &mut [Complex64], weight: &[f32]) {
    y.par_chunks_mut(CHUNK)
        .zip(weight.par_chunks(CHUNK))
        .for_each(|(y, w)| y.iter_mut().zip(w).for_each(|(y, w)| *y *= f64::from(*w)));
}

/// Greatest modulus and its index; the first of equals.
pub(crate) fn greatest(a: &[Complex64]) -> (usize, f64) {
    let parts: Vec<(usize, f64)> = a
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, a)| {
            let mut best = (chunk * CHUNK, -1.0);
            for (k, v) in a.iter().enumerate() {
                let power = v.norm_sqr();
                if power > best.1 {
                    best = (chunk * CHUNK + k, power);
                }
            }
            best
        })
        .collect();
    let mut best = (0, 0.0);
    for part in parts {
        if part.1 > best.1 {
            best = part;
        }
    }
    (best.0, best.1.sqrt())
}
