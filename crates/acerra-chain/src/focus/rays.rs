//! Ways of echoes that are not twice the distance from one antenna: antennas apart, and the ground.

use acerra_imaging::refraction::Ground;
use acerra_imaging::{ImagingError, Pulses};

use crate::echoes::Echoes;
use crate::focus::underground::Underground;

/// Places of transmitters and receivers, and the ground, as pulses borrow them.
pub(crate) struct Rays {
    antennas_m: Option<[Vec<[f64; 3]>; 2]>,
    ground: Option<Ground>,
}

impl Rays {
    /// The rays of some echoes; the ground is that of the image, with its surface sampled.
    ///
    /// # Errors
    /// Invalid soils or layers.
    pub fn of(echoes: Echoes<'_>, underground: Option<&Underground>) -> Result<Self, ImagingError> {
        let ground =
            underground.map(|underground| underground.seen_at(&echoes.spectrum.frequency_hz));
        Ok(Self {
            antennas_m: echoes.aligned.antennas_m(),
            ground: ground.transpose()?,
        })
    }

    /// The pulses along these rays.
    ///
    /// # Errors
    /// Antennas of another number than the pulses, or below the surface.
    pub fn of_pulses<'a>(&'a self, pulses: Pulses<'a>) -> Result<Pulses<'a>, ImagingError> {
        let pulses = match &self.antennas_m {
            Some([transmitter_m, receiver_m]) => pulses.with_antennas(transmitter_m, receiver_m)?,
            None => pulses,
        };
        match &self.ground {
            Some(ground) => pulses.with_ground(ground),
            None => Ok(pulses),
        }
    }
}
