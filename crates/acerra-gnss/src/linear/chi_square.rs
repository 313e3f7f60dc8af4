//! Quantiles of the χ² distribution.

/// 0.999 quantiles of χ² for 1, 2, … degrees of freedom.
const CHI_SQUARE_999: [f64; 30] = [
    10.8, 13.8, 16.3, 18.5, 20.5, 22.5, 24.3, 26.1, 27.9, 29.6, 31.3, 32.9, 34.5, 36.1, 37.7, 39.3,
    40.8, 42.3, 43.8, 45.3, 46.8, 48.3, 49.7, 51.2, 52.6, 54.1, 55.5, 56.9, 58.3, 59.7,
];

/// The 0.999 quantile of χ² for a number of degrees of freedom; 0 for none.
pub(crate) fn chi_square_999(freedom: usize) -> f64 {
    let Some(place) = freedom.checked_sub(1) else {
        return 0.0;
    };
    CHI_SQUARE_999.get(place).copied().unwrap_or_else(|| {
        // Wilson and Hilferty's approximation, better than 0.2 % there.
        let n = freedom as f64;
        let spread = 2.0 / (9.0 * n);
        n * (1.0 - spread + 3.090_232 * spread.sqrt()).powi(3)
    })
}

#[cfg(test)]
mod tests {
    use super::chi_square_999;

    #[test]
    fn the_approximation_continues_the_table() {
        assert_eq!(chi_square_999(0), 0.0);
        assert_eq!(chi_square_999(1), 10.8);
        let step = chi_square_999(31) - chi_square_999(30);
        assert!((1.2..1.7).contains(&step), "{step}");
        // From tables of the distribution.
        assert!((chi_square_999(100) - 149.45).abs() < 0.3);
    }
}
