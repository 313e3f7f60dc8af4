//! The permittivity of the ground, found from the data.

use acerra_imaging::Complex32;

use super::evidence::likelihood;
use crate::control::Control;
use crate::error::ChainError;
use crate::focus::permittivity::{PermittivityError, PermittivityFound};
use crate::focus::sink::{ImageSink, SinkError, StackArray, StackHeader};
use crate::focus::underground::Underground;
use crate::focus::{FocusOptions, ImageRequest};
use crate::prepare::Prepared;

/// Permittivities from which the search begins, until one shows points that agree on one: of damp sand, dry sand, moist
/// and wet soil.
const STARTS: [f64; 4] = [6.0, 3.0, 12.0, 25.0];
/// Images at most from one start.
const ROUNDS: usize = 5;
/// Share of its deviation by which the permittivity may still change.
const SETTLED_SIGMAS: f64 = 0.25;

impl Prepared {
    /// Finds the permittivity of a ground that leaves it open: images of the pixels of the scene by one permittivity
    /// after another, until that by which its points were found is the one that they agree on.
    ///
    /// # Errors
    /// An image that is no volume, no buried point that exceeds the clutter, points by which any permittivity might be;
    /// cancellation.
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
        for start in STARTS {
            match self.permittivity_from(start, underground, options, control)? {
                Ok(found) => {
                    self.permittivity = Some(found);
                    return Ok(());
                }
                Err(PermittivityError::NoPoint) => {}
                Err(other) => refusal = other,
            }
        }
        Err(refusal.into())
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
