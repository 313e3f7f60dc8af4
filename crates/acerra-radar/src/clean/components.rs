//! Principal components of the traces, by subspace iteration.
//!
//! With X the `[traces, samples]` matrix, the strongest left singular vectors U are found by iterating Q ←
//! orth(X (Xᴴ Q)) on a few more columns than components, and a Rayleigh–Ritz step; U Uᴴ X is subtracted
//! (Halko, Martinsson, Tropp, SIAM Review 53 (2011), Alg. 4.4).

use nalgebra::{Complex, DMatrix};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::value::Value;
use acerra_control::{Cancelled, Control};

/// Columns beyond the number of components, for speed of convergence.
const EXTRA: usize = 6;
const ITERATIONS: usize = 60;
/// Relative change of the singular values at which the iteration ends.
const CONVERGED: f64 = 1e-9;

/// Subtracts the strongest components from `[traces, samples per trace]` samples.
pub(super) fn remove_components<V: Value>(
    samples: &mut [V],
    [traces, n]: [usize; 2],
    components: usize,
    control: Control<'_>,
) -> Result<(), Cancelled> {
    let columns = (components + EXTRA).min(traces).min(n);
    let mut basis = start(traces, columns);
    let mut before = 0.0;
    for _ in 0..ITERATIONS {
        control.check()?;
        let strength: f64 = orthonormalise(&mut basis).iter().take(components).sum();
        if (strength - before).abs() <= CONVERGED * strength {
            break;
        }
        before = strength;
        let projected = project(samples, n, &basis);
        control.check()?;
        basis = expand(samples, n, &projected);
    }
    orthonormalise(&mut basis);
    let projected = project(samples, n, &basis);
    let strongest = rayleigh_ritz(&basis, &projected, components);
    let part = project(samples, n, &strongest);
    samples
        .par_chunks_exact_mut(n)
        .enumerate()
        .for_each(|(i, row)| {
            for (j, v) in row.iter_mut().enumerate() {
                let along: Complex64 = strongest.iter().zip(&part).map(|(u, p)| u[i] * p[j]).sum();
                *v = V::narrow(v.wide() - along);
            }
        });
    Ok(())
}

/// Columns of fixed pseudo-random numbers, so that the same data give the same result.
fn start(traces: usize, columns: usize) -> Vec<Vec<Complex64>> {
    let mut state = 0x9E37_79B9_7F4A_7C15u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..columns)
        .map(|_| (0..traces).map(|_| Complex64::new(next(), 0.0)).collect())
        .collect()
}

/// Modified Gram–Schmidt, twice; a column that depends linearly on earlier columns becomes zero. Returns the
/// length of each column's orthogonal part.
fn orthonormalise(basis: &mut [Vec<Complex64>]) -> Vec<f64> {
    let mut lengths = Vec::with_capacity(basis.len());
    for k in 0..basis.len() {
        let (before, rest) = basis.split_at_mut(k);
        let column = &mut rest[0];
        let original = norm(column);
        for _ in 0..2 {
            for b in before.iter() {
                let along: Complex64 = b.iter().zip(column.iter()).map(|(b, c)| b.conj() * c).sum();
                column.iter_mut().zip(b).for_each(|(c, b)| *c -= along * b);
            }
        }
        let length = norm(column);
        let scale = if length > 1e-12 * original && length > 0.0 {
            1.0 / length
        } else {
            0.0
        };
        column.iter_mut().for_each(|c| *c *= scale);
        lengths.push(length);
    }
    lengths
}

fn norm(column: &[Complex64]) -> f64 {
    column.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

/// Qᴴ X: one row of `n` for each column of Q.
fn project<V: Value>(samples: &[V], n: usize, basis: &[Vec<Complex64>]) -> Vec<Vec<Complex64>> {
    basis
        .par_iter()
        .map(|column| {
            let mut out = vec![Complex64::default(); n];
            for (row, q) in samples.chunks_exact(n).zip(column) {
                let q = q.conj();
                out.iter_mut()
                    .zip(row)
                    .for_each(|(o, v)| *o += q * v.wide());
            }
            out
        })
        .collect()
}

/// X Pᴴ, column by column, P having one row of `n` for each.
fn expand<V: Value>(samples: &[V], n: usize, projected: &[Vec<Complex64>]) -> Vec<Vec<Complex64>> {
    projected
        .par_iter()
        .map(|p| {
            samples
                .chunks_exact(n)
                .map(|row| row.iter().zip(p).map(|(v, p)| v.wide() * p.conj()).sum())
                .collect()
        })
        .collect()
}

/// The `wanted` strongest directions within the span of the basis.
fn rayleigh_ritz(
    basis: &[Vec<Complex64>],
    projected: &[Vec<Complex64>],
    wanted: usize,
) -> Vec<Vec<Complex64>> {
    let k = basis.len();
    let small = DMatrix::from_fn(k, k, |a, b| {
        let z: Complex64 = projected[a]
            .iter()
            .zip(&projected[b])
            .map(|(x, y)| x * y.conj())
            .sum();
        Complex::new(z.re, z.im)
    });
    let eigen = small.symmetric_eigen();
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    order
        .iter()
        .take(wanted)
        .map(|&e| {
            let mut column = vec![Complex64::default(); basis[0].len()];
            for (b, q) in basis.iter().enumerate() {
                let weight = eigen.eigenvectors[(b, e)];
                let weight = Complex64::new(weight.re, weight.im);
                column.iter_mut().zip(q).for_each(|(c, q)| *c += weight * q);
            }
            column
        })
        .collect()
}
