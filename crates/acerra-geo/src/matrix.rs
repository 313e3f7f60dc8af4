//! The little linear algebra that frames need: vectors of three, matrices of three by three.

/// A vector, or a point's coordinates.
pub type Vector3 = [f64; 3];

/// A 3 × 3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];

/// The identity.
pub const IDENTITY: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `a + b`.
#[inline]
#[must_use]
pub fn add(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a − b`.
#[inline]
#[must_use]
pub fn subtract(a: Vector3, b: Vector3) -> Vector3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s · a`.
#[inline]
#[must_use]
pub fn scale(s: f64, a: Vector3) -> Vector3 {
    [s * a[0], s * a[1], s * a[2]]
}

/// Scalar product.
#[inline]
#[must_use]
pub fn dot(a: Vector3, b: Vector3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline]
#[must_use]
pub fn cross(a: Vector3, b: Vector3) -> Vector3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length.
#[inline]
#[must_use]
pub fn norm(a: Vector3) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// Distance between two points.
#[inline]
#[must_use]
pub fn distance(a: Vector3, b: Vector3) -> f64 {
    norm(subtract(a, b))
}

/// `M v`.
#[inline]
#[must_use]
pub fn multiply_vector(m: &Matrix3, v: Vector3) -> Vector3 {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// `A B`.
#[must_use]
pub fn multiply(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    let mut product = [[0.0; 3]; 3];
    for (row, out) in a.iter().zip(&mut product) {
        for (j, value) in out.iter_mut().enumerate() {
            *value = row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j];
        }
    }
    product
}

/// `Mᵀ`: for a rotation, its inverse.
#[must_use]
pub fn transpose(m: &Matrix3) -> Matrix3 {
    let mut out = [[0.0; 3]; 3];
    for (i, row) in m.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            out[j][i] = value;
        }
    }
    out
}

/// `R C Rᵀ`: a covariance seen in the axes that `R` turns into.
///
/// The result is symmetric to the last bit.
#[must_use]
pub fn rotate_covariance(r: &Matrix3, covariance: &Matrix3) -> Matrix3 {
    let mut out = multiply(&multiply(r, covariance), &transpose(r));
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let mean = 0.5 * (out[i][j] + out[j][i]);
        out[i][j] = mean;
        out[j][i] = mean;
    }
    out
}

/// Whether every element is finite.
#[inline]
#[must_use]
pub fn is_finite(a: Vector3) -> bool {
    a.iter().all(|value| value.is_finite())
}
