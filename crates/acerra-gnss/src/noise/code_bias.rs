//! Lasting errors of codes, measured where integers are known.
//!
//! Code minus phase shows how codes vary, but not their constant error, which the ambiguity absorbs. At a fix
//! the phases determine the receiver's place to centimetres, and the codes' residuals are their errors. The
//! mean of a satellite's residuals over a time in which the varying part averages out is the lasting part:
//! receivers' delays that differ between signals, and reflections whose phase changes little during the log.
//! The mean square of these means over the satellites of a system, less the variance that the varying part
//! has in a mean, is the variance of the lasting part (the method of moments of variance components).

use std::collections::BTreeMap;

use super::calibration::SPAN_S;
use super::code_noise::MeasuredNoise;
use super::correlated::Lasting;
use super::phase_walk::FixResiduals;
use crate::measurements::constellation::Constellation;
use crate::observations::satellite::System;

/// Degrees of freedom that the prior variance counts as.
const PRIOR_FREEDOM: f64 = 2.0;

/// System and frequency slot.
type Group = (System, usize);

/// Variances of the lasting part, in units of the model's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LastingBiases {
    /// Variances by system and slot, where fixes exist.
    pub variances: BTreeMap<Group, Lasting>,
    /// Ratio of the measured to the assumed variance of codes averaged over a span, over all groups; 1
    /// without measurements.
    pub ratio: f64,
}

/// Sum and number of a satellite's residuals in a span.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

/// Squares of means about zero, their degrees of freedom, and the variance of such a mean by the varying
/// part.
#[derive(Default)]
struct Moments {
    squares: f64,
    freedom: f64,
    varying: f64,
}

impl LastingBiases {
    /// The lasting biases from the codes' residuals at the fixes of a pass; `noise` is the noise assumed in
    /// the pass.
    pub(crate) fn of(
        fixes: &[FixResiduals<'_>],
        constellation: &Constellation,
        noise: &MeasuredNoise,
    ) -> Self {
        let mut moments: BTreeMap<Group, Moments> = BTreeMap::new();
        for (group, means) in means(fixes, constellation) {
            let Some(freedom) = means.len().checked_sub(1).filter(|n| *n > 0) else {
                continue;
            };
            let own = moments.entry(group).or_default();
            let noise = noise.of(group.0, group.1);
            let varying: f64 = means.iter().map(|m| noise.mean_factor(m.count)).sum();
            let square = |m: &Mean| (m.sum / m.count as f64).powi(2);
            own.squares += means.iter().map(square).sum::<f64>();
            own.varying += varying * freedom as f64 / means.len() as f64;
            own.freedom += freedom as f64;
        }
        let mut sums = [0.0; 2];
        let of_group = |(group, m): (Group, Moments)| {
            let assumed = noise.of(group.0, group.1).lasting();
            let measured = (m.squares - m.varying).max(0.0);
            let lasting =
                assumed.map(|own| (PRIOR_FREEDOM * own + measured) / (PRIOR_FREEDOM + m.freedom));
            sums[0] += m.freedom * lasting.guarded + m.varying;
            sums[1] += m.freedom * assumed.guarded + m.varying;
            (group, lasting)
        };
        let variances = moments.into_iter().map(of_group).collect();
        Self {
            variances,
            ratio: if sums[1] > 0.0 {
                sums[0] / sums[1]
            } else {
                1.0
            },
        }
    }
}

/// The means of the satellites of each group, span by span.
fn means(fixes: &[FixResiduals<'_>], constellation: &Constellation) -> Vec<(Group, Vec<Mean>)> {
    let mut sums: BTreeMap<(Group, i64), BTreeMap<usize, Mean>> = BTreeMap::new();
    let Some(first) = fixes.first() else {
        return Vec::new();
    };
    let length_s = fixes
        .last()
        .map_or(0.0, |last| last.time.seconds_since(first.time).abs());
    // The log is divided into equal spans.
    let spans = (length_s / SPAN_S).round().max(1.0);
    for fix in fixes {
        let since_s = fix.time.seconds_since(first.time).abs();
        let span = (since_s / (length_s / spans).max(1e-3)).min(spans - 1.0) as i64;
        for r in fix.residuals {
            let system = constellation.id(r.satellite).system();
            let of_group = sums.entry(((system, r.slot), span)).or_default();
            let mean = of_group.entry(r.satellite).or_default();
            mean.sum += r.normalised;
            mean.count += 1;
        }
    }
    sums.into_iter()
        .map(|((group, _), means)| (group, means.into_values().collect()))
        .collect()
}
