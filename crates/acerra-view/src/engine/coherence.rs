//! Coherence of two looks at the same ground: γ = Σ a·b* / √(Σ|a|² Σ|b|²) over a window about each
//! pixel (Born & Wolf, Principles of Optics, §10.3; Touzi et al., IEEE TGRS 1999).

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Pixels of the window to each side of its middle.
const REACH: usize = 3;

/// The complex coherence of two images with a number of columns: its modulus lies within 0 and 1, its phase
/// is that of the first relative to the second. Zero where either image has no power.
///
/// A window of 7 × 7 pixels holds fewer independent samples where a pixel is smaller than the
/// resolution, and the modulus of incoherent images is then far from zero.
#[must_use]
pub fn coherence(a: &[Complex32], b: &[Complex32], columns: usize) -> Vec<Complex32> {
    let rows = a.len().min(b.len()).checked_div(columns).unwrap_or(0);
    let mut made = vec![Complex32::default(); rows * columns];
    made.par_chunks_mut(columns.max(1))
        .enumerate()
        .for_each(|(j, row)| {
            let lines = j.saturating_sub(REACH)..(j + REACH + 1).min(rows);
            for (i, value) in row.iter_mut().enumerate() {
                let window = i.saturating_sub(REACH)..(i + REACH + 1).min(columns);
                let places = lines
                    .clone()
                    .flat_map(|y| window.clone().map(move |x| y * columns + x));
                *value = of_window(places.map(|k| (a[k], b[k])));
            }
        });
    made
}

fn of_window(pairs: impl Iterator<Item = (Complex32, Complex32)>) -> Complex32 {
    let (mut cross, mut own, mut other) = (Complex64::default(), 0.0, 0.0);
    for (a, b) in pairs {
        let [a, b] = [a, b].map(|v| Complex64::new(v.re.into(), v.im.into()));
        cross += a * b.conj();
        own += a.norm_sqr();
        other += b.norm_sqr();
    }
    let power = (own * other).sqrt();
    let gamma = if power > 0.0 {
        cross / power
    } else {
        Complex64::default()
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a number within the unit circle"
    )]
    Complex32::new(gamma.re as f32, gamma.im as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_looks_are_coherent_and_unlike_ones_are_not() {
        let wave =
            |turn: f32| move |k: usize| Complex32::from_polar(1.0 + k as f32, turn * k as f32);
        let a: Vec<Complex32> = (0..400).map(wave(0.3)).collect();
        let turned: Vec<Complex32> = a
            .iter()
            .map(|v| v * Complex32::from_polar(2.0, -0.7))
            .collect();
        for gamma in coherence(&a, &turned, 20) {
            assert!((gamma - Complex32::from_polar(1.0, 0.7)).norm() < 1e-5);
        }
        let b: Vec<Complex32> = (0..400).map(wave(1.9)).collect();
        assert!(coherence(&a, &b, 20)[210].norm() < 0.3);
        let dark = vec![Complex32::default(); 400];
        assert_eq!(coherence(&a, &dark, 20)[0], Complex32::default());
        assert!(coherence(&[], &[], 0).is_empty());
    }
}
