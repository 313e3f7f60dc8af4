//! Detection of outliers: residuals after the update, relative to their noise.

use super::double_row::DoubleRow;

/// The measurement whose residual is largest in units of its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Worst {
    /// Index among the common satellites.
    pub common: usize,
    pub slot: usize,
    /// Residual over standard deviation.
    pub normalised: f64,
}

/// The worst phase (or, with `of_codes`, code) among `rows`, over the satellites selected by `counts`.
///
/// A double difference does not identify the faulty satellite: within each block the single differences are
/// taken about their median, so that a faulty reference satellite appears as an outlier. Deviations are in
/// units of an undisturbed signal's noise, so that faulty weak signals are left out as well.
pub(crate) fn worst(
    rows: &[DoubleRow],
    of_codes: bool,
    counts: impl Fn(usize, usize) -> bool,
) -> Option<Worst> {
    let mut worst: Option<Worst> = None;
    let mut start = 0;
    while start < rows.len() {
        let first = &rows[start];
        let end = start
            + rows[start..]
                .iter()
                .take_while(|r| r.block == first.block)
                .count();
        if first.is_code == of_codes {
            let mut members: Vec<(usize, f64, f64)> = Vec::with_capacity(end - start + 1);
            if counts(first.reference, first.slot) {
                members.push((first.reference, 0.0, first.undisturbed_m2[0]));
            }
            members.extend(
                rows[start..end]
                    .iter()
                    .filter(|r| counts(r.other, r.slot))
                    .map(|r| (r.other, -r.residual_m, r.undisturbed_m2[1])),
            );
            let middle = median(members.iter().map(|m| m.1).collect());
            for (common, single, variance) in members {
                let normalised = (single - middle).abs() / variance.sqrt();
                if worst.is_none_or(|w| normalised > w.normalised) {
                    worst = Some(Worst {
                        common,
                        slot: first.slot,
                        normalised,
                    });
                }
            }
        }
        start = end;
    }
    worst
}

/// One satellite's residual about its block's weighted mean, over its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Standardised {
    /// Index among the common satellites.
    pub common: usize,
    pub slot: usize,
    pub normalised: f64,
}

/// The residuals of codes or phases of the satellites that `counts` selects, and their degrees of freedom.
pub(crate) fn standardised(
    rows: &[DoubleRow],
    of_codes: bool,
    counts: impl Fn(usize, usize) -> bool,
) -> (Vec<Standardised>, usize) {
    let (mut residuals, mut freedom) = (Vec::new(), 0);
    let kept = |r: &&DoubleRow| {
        r.is_code == of_codes && counts(r.reference, r.slot) && counts(r.other, r.slot)
    };
    for block in rows
        .iter()
        .filter(kept)
        .collect::<Vec<_>>()
        .chunk_by(|a, b| a.block == b.block)
    {
        let members = || {
            let reference = (block[0].reference, 0.0, block[0].variance_reference_m2);
            let others = block
                .iter()
                .map(|r| (r.other, -r.residual_m, r.variance_other_m2));
            std::iter::once(reference).chain(others)
        };
        let weight: f64 = members().map(|(_, _, variance)| 1.0 / variance).sum();
        let mean = members().map(|(_, r, variance)| r / variance).sum::<f64>() / weight;
        residuals.extend(members().map(|(common, r, variance)| Standardised {
            common,
            slot: block[0].slot,
            normalised: (r - mean) / variance.sqrt(),
        }));
        freedom += block.len();
    }
    (residuals, freedom)
}

/// Sum of squares of the [standardised] residuals, and their degrees of freedom.
pub(crate) fn misfit(
    rows: &[DoubleRow],
    of_codes: bool,
    counts: impl Fn(usize, usize) -> bool,
) -> (f64, usize) {
    let (residuals, freedom) = standardised(rows, of_codes, counts);
    (
        residuals.iter().map(|r| r.normalised.powi(2)).sum(),
        freedom,
    )
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    let (below, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().max_by(f64::total_cmp);
    (lower.unwrap_or(upper) + upper) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(reference: usize, other: usize, residual_m: f64) -> DoubleRow {
        DoubleRow {
            slot: 0,
            is_code: false,
            reference,
            other,
            residual_m,
            position: [0.0; 3],
            wavelengths_m: [0.19; 2],
            variance_reference_m2: 1e-4,
            variance_other_m2: 1e-4,
            undisturbed_m2: [1e-4; 2],
            common_delay_m: 0.0,
            channels_apart: 0.0,
            block: 1,
        }
    }

    #[test]
    fn medians_of_odd_and_even_numbers() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0]), 3.0);
        assert_eq!(median(vec![4.0, 1.0]), 2.5);
        assert_eq!(median(vec![9.0, -1.0, 2.0]), 2.0);
        assert_eq!(median(vec![7.0, 1.0, 3.0, 2.0]), 2.5);
    }

    #[test]
    fn the_culprit_is_found_even_when_it_is_the_reference() {
        let other = [row(0, 1, 0.002), row(0, 2, -0.1), row(0, 3, 0.0)];
        let found = worst(&other, false, |_, _| true).unwrap();
        assert_eq!(found.common, 2);
        assert!(found.normalised > 9.0);
        assert!(worst(&other, true, |_, _| true).is_none());
        let reference = [row(0, 1, 0.1), row(0, 2, 0.101), row(0, 3, 0.099)];
        let found = worst(&reference, false, |_, _| true).unwrap();
        assert_eq!(found.common, 0);
        assert!(worst(&[], false, |_, _| true).is_none());
    }
}
