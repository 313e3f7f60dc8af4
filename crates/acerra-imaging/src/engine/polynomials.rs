//! Polynomials of cosine and sine over half a period or less, for single-precision kernels.

/// Polynomials in δ² of cos αδ and sin(αδ)/δ over |δ| ≤ ½; the sine's polynomial has one term fewer.
pub(crate) fn carrier_polynomials(carrier_rad: f64, fine: bool) -> ([f32; 4], [f32; 4]) {
    let terms = if fine { 4 } else { 3 };
    (
        even_polynomial(|d| (carrier_rad * d).cos(), terms),
        even_polynomial(|d| (carrier_rad * d).sin() / d, terms - 1),
    )
}

/// The polynomial in x² of an even function on |x| ≤ ½, by interpolation at Chebyshev nodes.
pub(crate) fn even_polynomial<const N: usize>(f: impl Fn(f64) -> f64, terms: usize) -> [f32; N] {
    // Newton's divided differences in q = x² ∈ [0, ¼], then expanded into powers.
    let node = |k: usize| {
        let angle = std::f64::consts::PI * (k as f64 + 0.5) / terms as f64;
        0.125 * (1.0 + angle.cos())
    };
    let mut divided: Vec<f64> = (0..terms).map(|k| f(node(k).sqrt())).collect();
    for order in 1..terms {
        for k in (order..terms).rev() {
            divided[k] = (divided[k] - divided[k - 1]) / (node(k) - node(k - order));
        }
    }
    let mut powers = [0.0; N];
    for k in (0..terms).rev() {
        for p in (1..N).rev() {
            powers[p] = powers[p - 1] - node(k) * powers[p];
        }
        powers[0] = divided[k] - node(k) * powers[0];
    }
    powers.map(|p| p as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carrier_polynomials_are_close() {
        for (fine, bound) in [(false, 3e-3), (true, 4e-5)] {
            let (cosine, sine) = carrier_polynomials(2.4, fine);
            for k in 0..=100 {
                let d = k as f32 / 100.0 - 0.5;
                let q = d * d;
                let at = |c: [f32; 4]| c[0] + q * (c[1] + q * (c[2] + q * c[3]));
                assert!((at(cosine) - (2.4 * d).cos()).abs() < bound);
                assert!((at(sine) * d - (2.4 * d).sin()).abs() < bound);
            }
        }
    }
}
