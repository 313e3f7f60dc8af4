//! Factorisation, substitution and products of small dense matrices, stored by columns.

/// Factorises a symmetric matrix of `n` columns as LLᵀ, in place, from its lower triangle, which L
/// replaces; false where it is not positive definite.
pub(crate) fn factorise(matrix: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let (before, from) = matrix.split_at_mut(j * n);
        let own = &mut from[j..n];
        for column in before.chunks_exact(n) {
            subtract(own, column[j], &column[j..]);
        }
        if own[0].is_nan() || own[0] <= 0.0 {
            return false;
        }
        let root = own[0].sqrt();
        own[0] = root;
        for element in &mut own[1..] {
            *element /= root;
        }
    }
    true
}

/// Replaces `right` by the solution of Lx = `right`.
pub(crate) fn solve_lower(factor: &[f64], right: &mut [f64]) {
    let n = right.len();
    for (i, column) in factor.chunks_exact(n.max(1)).enumerate() {
        let (known, rest) = right.split_at_mut(i + 1);
        let value = known[i] / column[i];
        known[i] = value;
        subtract(rest, value, &column[i + 1..]);
    }
}

/// Replaces the rows of R, which are `count` long, by those of L⁻¹R.
pub(crate) fn solve_lower_rows(factor: &[f64], rows: &mut [f64], count: usize) {
    let n = rows.len() / count.max(1);
    for (i, column) in factor.chunks_exact(n.max(1)).enumerate() {
        let (known, rest) = rows.split_at_mut((i + 1) * count);
        let own = &mut known[i * count..];
        for value in own.iter_mut() {
            *value /= column[i];
        }
        for (row, &l) in rest.chunks_exact_mut(count).zip(&column[i + 1..]) {
            subtract(row, l, own);
        }
    }
}

fn subtract(from: &mut [f64], factor: f64, column: &[f64]) {
    for (element, c) in from.iter_mut().zip(column) {
        *element -= factor * c;
    }
}

/// The [scalar products](dot) of one vector with two others.
pub(crate) fn dot_pair(a: &[f64], b: &[f64], c: &[f64]) -> [f64; 2] {
    let (mut of_b, mut of_c) = ([0.0; 8], [0.0; 8]);
    let [a, b, c] = [a, b, c].map(|of| of.chunks_exact(8));
    let rest = a.remainder().iter().zip(b.remainder()).zip(c.remainder());
    for ((a, b), c) in a.zip(b).zip(c) {
        for k in 0..8 {
            of_b[k] += a[k] * b[k];
            of_c[k] += a[k] * c[k];
        }
    }
    let whole = |p: [f64; 8]| (p[0] + p[4]) + (p[1] + p[5]) + (p[2] + p[6]) + (p[3] + p[7]);
    rest.fold([whole(of_b), whole(of_c)], |[of_b, of_c], ((a, b), c)| {
        [of_b + a * b, of_c + a * c]
    })
}

/// The scalar product, summed in eight parts, which processors take several at a time.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a.remainder().iter().zip(b.remainder());
    for (a, b) in a.zip(b) {
        for ((part, a), b) in parts.iter_mut().zip(a).zip(b) {
            *part += a * b;
        }
    }
    let [p0, p1, p2, p3, p4, p5, p6, p7] = parts;
    let whole = (p0 + p4) + (p1 + p5) + (p2 + p6) + (p3 + p7);
    rest.fold(whole, |sum, (a, b)| sum + a * b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Cholesky, DMatrix, DVector};

    fn positive_definite(n: usize) -> DMatrix<f64> {
        let root = DMatrix::from_fn(n, n, |i, j| ((3 * i + 7 * j) % 11) as f64 - 4.5);
        &root * root.transpose() + DMatrix::identity(n, n)
    }

    #[test]
    fn agrees_with_nalgebra() {
        for n in [0, 1, 2, 7, 8, 9, 23] {
            let matrix = positive_definite(n);
            let expected = Cholesky::new(matrix.clone()).unwrap().unpack();
            let mut factor = matrix.as_slice().to_vec();
            assert!(factorise(&mut factor, n));
            let right = DVector::from_fn(n, |i, _| i as f64 - 1.7);
            let mut solved = right.as_slice().to_vec();
            solve_lower(&factor, &mut solved);
            let mut twice: Vec<f64> = right.iter().flat_map(|r| [*r, 2.0 * r]).collect();
            solve_lower_rows(&factor, &mut twice, 2);
            for (pair, one) in twice.chunks_exact(2).zip(&solved) {
                assert_eq!(*pair, [*one, 2.0 * one]);
            }
            let residual = &expected * DVector::from_column_slice(&solved) - &right;
            assert!(residual.amax() < 1e-12, "{n}: {residual}");
            for j in 0..n {
                for i in j..n {
                    assert!((factor[j * n + i] - expected[(i, j)]).abs() < 1e-12);
                }
            }
            let expected = right.dot(&DVector::from_column_slice(&solved));
            let found = dot(right.as_slice(), &solved);
            assert!((found - expected).abs() <= 1e-14 * expected.abs());
            let itself = dot(right.as_slice(), right.as_slice());
            let pair = dot_pair(right.as_slice(), &solved, right.as_slice());
            assert_eq!(pair, [found, itself]);
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        for matrix in [
            [1.0, 2.0, 2.0, 1.0],
            [0.0, 0.0, 0.0, 1.0],
            [f64::NAN, 0.0, 0.0, 1.0],
        ] {
            assert!(!factorise(&mut matrix.clone(), 2), "{matrix:?}");
        }
    }
}
