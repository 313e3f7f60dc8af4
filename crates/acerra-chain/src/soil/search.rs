//! The permittivity of the ground, found from the data.

use acerra_imaging::Complex32;

use super::evidence::likelihood;
use crate::control::Control;
use crate::error::ChainError;
use crate::focus::permittivity::{PermittivityError, PermittivityFound};
use crate::focus::sink::{ImageSink, SinkError, StackArray, StackHeader};
use crate::focus::underground::Underground;
use crate::focus::{FocusOptions, ImageRequest};
use crate::journal::finding::DOUBTFUL_SIGMAS;
use crate::prepare::Prepared;

/// Permittivities from which the search begins, each time: of damp sand, dry sand, moist and wet soil.
const STARTS: [f64; 4] = [6.0, 3.0, 12.0, 25.0];
/// Images at most from one start.
const ROUNDS: usize = 5;
/// Share of its deviation by which the permittivity may still change.
const SETTLED_SIGMAS: f64 = 0.25;

impl Prepared {
    /// Finds the permittivity where the ground leaves it open: images the pixels of the scene by one
    /// permittivity after another, until the points found in an image agree on the permittivity of that
    /// image. Several starts must lead to one permittivity.
    ///
    /// # Errors
    /// An image that is no volume, no buried point that exceeds the clutter, points by which any permittivity might be,
    /// starts that end at different answers; cancellation.
    pub fn find_permittivity(
        &mut self,
        underground: &Underground,
        options: &FocusOptions,
        control: &Control<'_>,
    ) -> Result<(), ChainError> {
        if self.scene.pixels.volume.is_none() {
            return Err(PermittivityError::NoVolume.into());
        }
        let mut refusal = PermittivityError::NoPoint;
        let mut settled = Vec::new();
        for start in STARTS {
            match self.permittivity_from(start, underground, options, control)? {
                Ok(found) => settled.push(found),
                Err(PermittivityError::NoPoint) => {}
                Err(other) => refusal = other,
            }
        }
        self.permittivity = Some(joined(&settled, refusal)?);
        Ok(())
    }

    fn permittivity_from(
        &self,
        start: f64,
        underground: &Underground,
        options: &FocusOptions,
        control: &Control<'_>,
    ) -> Result<Result<PermittivityFound, PermittivityError>, ChainError> {
        let mut in_force = start;
        for _ in 0..ROUNDS {
            let request = ImageRequest {
                options: *options,
                underground: Some(underground.of_permittivity(in_force)),
                ..ImageRequest::on(self.scene.pixels.clone())
            };
            let focused = self.image(&request, &mut Discard, control)?;
            let Some(likelihood) = likelihood(self, &focused, control)? else {
                return Ok(Err(PermittivityError::NoPoint));
            };
            let Some(found) = likelihood.found() else {
                let [from, to] = likelihood.bounds();
                return Ok(Err(PermittivityError::Vague {
                    points: likelihood.points(),
                    from,
                    to,
                }));
            };
            if (found.value - in_force).abs() <= SETTLED_SIGMAS * found.sigma {
                return Ok(Ok(found));
            }
            in_force = found.value;
        }
        Ok(Err(PermittivityError::Unsettled { last: in_force }))
    }
}

/// The permittivity with the most points among those of several starts, with their scatter about it;
/// `refusal` without any.
///
/// # Errors
/// Two answers further from each other than their deviations explain.
fn joined(
    settled: &[PermittivityFound],
    refusal: PermittivityError,
) -> Result<PermittivityFound, PermittivityError> {
    let share = |found: &PermittivityFound| found.sigma / found.value;
    let narrower = |a: &PermittivityFound, b: &PermittivityFound| share(b).total_cmp(&share(a));
    let best = (settled.iter().copied())
        .max_by(|a, b| a.points.cmp(&b.points).then(narrower(a, b)))
        .ok_or(refusal)?;
    let apart = |other: &PermittivityFound| (other.value - best.value).abs();
    let is_other =
        |other: &&PermittivityFound| apart(other) > DOUBTFUL_SIGMAS * other.sigma.hypot(best.sigma);
    if let Some(other) = settled.iter().find(is_other) {
        return Err(PermittivityError::Several {
            first: best.value,
            second: other.value,
        });
    }
    let scatter = settled
        .iter()
        .map(|other| apart(other).powi(2))
        .sum::<f64>();
    Ok(PermittivityFound {
        sigma: (best.sigma.powi(2) + scatter / settled.len() as f64).sqrt(),
        ..best
    })
}

/// Takes slices and keeps none.
struct Discard;

impl ImageSink for Discard {
    fn begin(&mut self, _: &StackHeader) -> Result<(), SinkError> {
        Ok(())
    }

    fn put(&mut self, _: &[Complex32]) -> Result<(), SinkError> {
        Ok(())
    }

    fn finish(&mut self, _: Vec<StackArray>) -> Result<(), SinkError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(value: f64, sigma: f64, points: usize) -> PermittivityFound {
        PermittivityFound {
            value,
            sigma,
            points,
        }
    }

    #[test]
    fn starts_must_end_at_one_answer_and_their_scatter_counts() {
        let refusal = || PermittivityError::Unsettled { last: 7.0 };
        assert_eq!(joined(&[], refusal()), Err(refusal()));
        let alone = found(4.0, 0.5, 3);
        assert_eq!(joined(&[alone], refusal()), Ok(alone));
        let both = joined(&[found(5.0, 0.8, 2), alone], refusal()).unwrap();
        assert_eq!((both.value, both.points), (4.0, 3));
        assert!(
            (both.sigma - (0.25_f64 + 0.5).sqrt()).abs() < 1e-12,
            "{both:?}"
        );
        let several = joined(&[alone, found(9.0, 1.0, 3)], refusal());
        let expected = PermittivityError::Several {
            first: 9.0,
            second: 4.0,
        };
        assert_eq!(several, Err(expected));
    }
}
