//! The permittivity that echoes of buried points agree on.

use acerra_imaging::ImagingError;

use super::echo::PointEcho;
use super::leg::{depth_at, vertical};
use crate::focus::permittivity::PermittivityFound;
use crate::focus::underground::Underground;
use crate::journal::finding::DOUBTFUL_SIGMAS;

/// Radius of the near side of a buried object, and its standard deviation (m): from a stone or a cable to an
/// anti-personnel mine. Half of its variance is common to all objects of a flight.
pub(super) const RADIUS_M: f64 = 0.02;
pub(super) const RADIUS_SIGMA_M: f64 = 0.02;

/// Ratio of one factor of the permittivities to the one before.
const RATIO: f64 = 1.01;

/// Errors common to all points of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommonSigma {
    /// Standard deviation of the antennas' heights above the surface (m).
    pub height_m: f64,
    /// Standard deviation of the delay of the surface's echo, as one-way optical length (m).
    pub delay_m: f64,
}

/// Likelihood of factors by which all permittivities of a ground are multiplied.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// Permittivity of the topmost layer in force.
    top: f64,
    points: usize,
    /// Logarithms of factors, and of their likelihood.
    curve: Vec<[f64; 2]>,
}

impl Likelihood {
    /// The likelihood by the echoes of some points, over permittivities from 1 to 100; none without points.
    ///
    /// # Errors
    /// A ground that is none.
    pub fn of(
        underground: &Underground,
        frequency_hz: &[f64],
        points: &[PointEcho],
        common: CommonSigma,
    ) -> Result<Option<Self>, ImagingError> {
        let Some(top) = underground.layers.first() else {
            return Ok(None);
        };
        if points.is_empty() {
            return Ok(None);
        }
        let misfits = underground.factors(RATIO).into_iter().map(|factor| {
            let ground = underground.scaled(factor).seen_at(frequency_hz)?;
            let legs = points.iter().map(|point| {
                let depth_m = depth_at(&ground, point.delay_m);
                let near = vertical(&ground, depth_m);
                let centre = vertical(&ground, depth_m + RADIUS_M);
                let radius_sigma_m = RADIUS_SIGMA_M / near.index * 0.5_f64.sqrt();
                Residual {
                    value: point.curvature_m - centre.curvature_m,
                    own_sigma: point.sigma_m.hypot(radius_sigma_m),
                    common: [
                        radius_sigma_m,
                        common.height_m,
                        common.delay_m / (near.index * near.index),
                    ],
                }
            });
            Ok([factor.ln(), misfit(&legs.collect::<Vec<_>>())])
        });
        let misfits = misfits.collect::<Result<Vec<[f64; 2]>, ImagingError>>()?;
        let least = misfits.iter().map(|m| m[1]).fold(f64::INFINITY, f64::min);
        // Points that scatter more than their deviations get less weight accordingly.
        let freedom = points.len().saturating_sub(1).max(1) as f64;
        let excess = (least / freedom).max(1.0);
        let curve = misfits.iter().map(|[ln, chi2]| [*ln, -0.5 * chi2 / excess]);
        Ok(Some(Self {
            top: top.soil.relative_permittivity,
            points: points.len(),
            curve: curve.collect(),
        }))
    }

    /// The permittivity with its deviation, where the likelihood falls by three standard deviations on both sides
    /// within 1 to 100: the likeliest, with the deviation of the curve about it.
    #[must_use]
    pub fn found(&self) -> Option<PermittivityFound> {
        let most = self.most();
        let fall = 0.5 * DOUBTFUL_SIGMAS * DOUBTFUL_SIGMAS;
        let (first, last) = (self.curve.first()?, self.curve.last()?);
        if most - first[1] < fall || most - last[1] < fall {
            return None;
        }
        let weight = |p: &[f64; 2]| (p[1] - most).exp();
        let total: f64 = self.curve.iter().map(weight).sum();
        let value = self.likeliest();
        let squares =
            (self.curve.iter()).map(|p| weight(p) * (p[0] - (value / self.top).ln()).powi(2));
        Some(PermittivityFound {
            value,
            sigma: value * (squares.sum::<f64>() / total).sqrt(),
            points: self.points,
        })
    }

    /// Distance of the permittivities in force from the likeliest, in standard deviations.
    #[must_use]
    pub fn sigmas_in_force(&self) -> f64 {
        let in_force = (self.curve.iter()).min_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
        in_force.map_or(0.0, |p| (2.0 * (self.most() - p[1])).max(0.0).sqrt())
    }

    /// The likeliest permittivity of the topmost layer.
    #[must_use]
    pub fn likeliest(&self) -> f64 {
        let best = (self.curve.iter()).max_by(|a, b| a[1].total_cmp(&b[1]));
        self.top * best.map_or(0.0, |p| p[0]).exp()
    }

    /// Least and greatest permittivity of the topmost layer within three standard deviations.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        let least = self.most() - 0.5 * DOUBTFUL_SIGMAS * DOUBTFUL_SIGMAS;
        let mut likely = self.curve.iter().filter(|p| p[1] >= least);
        let first = likely.next();
        [first, likely.next_back().or(first)].map(|p| self.top * p.map_or(0.0, |p| p[0]).exp())
    }

    /// Points that it is from.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    fn most(&self) -> f64 {
        (self.curve.iter().map(|p| p[1])).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Difference of a point's hyperbola from that of a trial, with its deviations.
pub(super) struct Residual {
    pub value: f64,
    pub own_sigma: f64,
    /// Deviations by causes that are the same for all points.
    pub common: [f64; 3],
}

/// Sum of the squares of residuals in units of their joint deviations.
///
/// Common causes are removed one by one from the inverse of the covariance, by the Sherman–Morrison formula.
pub(super) fn misfit(residuals: &[Residual]) -> f64 {
    let weighted = |vector: &[f64], directions: &[(Vec<f64>, f64)]| -> Vec<f64> {
        let mut out: Vec<f64> = (vector.iter().zip(residuals))
            .map(|(v, r)| v / r.own_sigma.powi(2))
            .collect();
        for (direction, norm) in directions {
            let share = dot(direction, vector) / norm;
            for (o, d) in out.iter_mut().zip(direction) {
                *o -= share * d;
            }
        }
        out
    };
    let mut directions: Vec<(Vec<f64>, f64)> = Vec::new();
    for cause in 0..3 {
        let vector: Vec<f64> = residuals.iter().map(|r| r.common[cause]).collect();
        let direction = weighted(&vector, &directions);
        let norm = 1.0 + dot(&vector, &direction);
        directions.push((direction, norm));
    }
    let values: Vec<f64> = residuals.iter().map(|r| r.value).collect();
    dot(&values, &weighted(&values, &directions))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The echo of the near side of a sphere or cylinder below one soil.
    fn object(permittivity: f64, depth_m: f64, radius_m: f64, sigma_m: f64) -> PointEcho {
        let index = permittivity.sqrt();
        PointEcho {
            place_m: [0.0, 0.0, radius_m - depth_m],
            delay_m: index * (depth_m - radius_m),
            curvature_m: depth_m / index,
            sigma_m,
        }
    }

    fn likelihood(stated: f64, points: &[PointEcho], common: CommonSigma) -> Likelihood {
        let found = Likelihood::of(&Underground::of_soil(stated), &[1.5e9], points, common);
        found.unwrap().unwrap()
    }

    #[test]
    fn objects_of_known_size_give_the_permittivity_whatever_is_stated() {
        for stated in [2.5, 6.0, 20.0] {
            let points = [0.15, 0.25].map(|depth_m| object(6.0, depth_m, RADIUS_M, 0.002));
            let found = likelihood(stated, &points, CommonSigma::default())
                .found()
                .unwrap();
            assert!((found.value - 6.0).abs() < 0.1, "{found:?}");
            assert!((0.2..1.0).contains(&found.sigma), "{found:?}");
            assert_eq!(found.points, 2);
        }
    }

    #[test]
    fn points_without_size_and_larger_objects_are_within_two_deviations() {
        for radius_m in [0.0, 0.01, 0.04, 0.05] {
            for count in [1, 2, 6] {
                let points: Vec<PointEcho> = (0..count)
                    .map(|k| object(9.0, 0.12 + 0.05 * f64::from(k), radius_m, 0.003))
                    .collect();
                let found = likelihood(9.0, &points, CommonSigma::default());
                assert!(
                    found.sigmas_in_force() < 2.0,
                    "{radius_m} {count}: {}",
                    found.sigmas_in_force()
                );
            }
        }
    }

    #[test]
    fn wrong_permittivities_are_many_deviations_off() {
        let points = [0.15, 0.25].map(|depth_m| object(6.0, depth_m, 0.02, 0.003));
        for wrong in [3.0, 12.0] {
            let found = likelihood(wrong, &points, CommonSigma::default());
            assert!(
                found.sigmas_in_force() > 3.0,
                "{wrong}: {}",
                found.sigmas_in_force()
            );
        }
    }

    #[test]
    fn heights_that_are_not_known_leave_nothing_to_find() {
        let points = [object(6.0, 0.1, 0.02, 0.003)];
        let common = CommonSigma {
            height_m: 0.05,
            delay_m: 0.0,
        };
        assert_eq!(likelihood(6.0, &points, common).found(), None);
        let unsure = [object(6.0, 0.1, 0.02, 0.1)];
        assert_eq!(
            likelihood(6.0, &unsure, CommonSigma::default()).found(),
            None
        );
    }

    #[test]
    fn misfits_hold_common_causes() {
        // Two residuals of 1 with own variances of 1 and a common one of 1: (1, 1) · [[2, 1], [1, 2]]⁻¹ · (1, 1).
        let residual = || Residual {
            value: 1.0,
            own_sigma: 1.0,
            common: [1.0, 0.0, 0.0],
        };
        assert!((misfit(&[residual(), residual()]) - 2.0 / 3.0).abs() < 1e-12);
    }
}
