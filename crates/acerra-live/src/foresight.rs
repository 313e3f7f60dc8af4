//! How far extrapolated places are found to be off once the position after them has come, and whether pulses
//! are worth imaging there meanwhile.

use std::collections::VecDeque;

use serde::Serialize;

/// Pulses that figures are of.
const LATEST: usize = 200;
/// Pulses before which nothing is known.
const FEWEST: usize = 10;
/// Part of the wavelength by which extrapolated places may be off in 95 % of cases: the echo's phase is then
/// off by half a turn at most. The few pulses that stand there for a tenth of a second may blur a picture of
/// hundreds, and do not take from it.
pub const MOST_WAVELENGTHS_OFF: f64 = 0.25;

/// How far extrapolated places were off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForesightFigures {
    /// Half of the pulses were off by no more (m).
    pub median_off_m: f64,
    /// 95 % of them were off by no more (m).
    pub p95_off_m: f64,
    /// Pulses that these are of.
    pub pulses: usize,
    /// Whether pulses are imaged at extrapolated places.
    pub is_used: bool,
}

/// The latest pulses' extrapolated places against those between positions.
#[derive(Clone, Debug)]
pub(crate) struct Foresight {
    off_m: VecDeque<f64>,
    most_off_m: f64,
}

impl Foresight {
    /// For a wavelength (m).
    pub fn new(wavelength_m: f64) -> Self {
        Self {
            off_m: VecDeque::new(),
            most_off_m: MOST_WAVELENGTHS_OFF * wavelength_m,
        }
    }

    /// Takes the distance between both places of a pulse (m).
    pub fn take(&mut self, off_m: f64) {
        if self.off_m.len() == LATEST {
            self.off_m.pop_front();
        }
        self.off_m.push_back(off_m);
    }

    /// Whether extrapolated places are near enough; not before some were compared.
    pub fn is_good(&self) -> bool {
        self.figures().is_some_and(|figures| figures.is_used)
    }

    /// The figures; none before some places were compared.
    pub fn figures(&self) -> Option<ForesightFigures> {
        if self.off_m.len() < FEWEST {
            return None;
        }
        let mut sorted: Vec<f64> = self.off_m.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = (share * sorted.len() as f64).ceil() as usize;
            sorted.get(place.saturating_sub(1)).copied()
        };
        let p95_off_m = at(0.95)?;
        Some(ForesightFigures {
            median_off_m: at(0.5)?,
            p95_off_m,
            pulses: sorted.len(),
            is_used: p95_off_m <= self.most_off_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_are_found_far_off_are_not_used_until_they_are_near_again() {
        let mut foresight = Foresight::new(0.04);
        assert!(!foresight.is_good());
        (0..FEWEST).for_each(|_| foresight.take(0.004));
        assert!(foresight.is_good());
        (0..20).for_each(|_| foresight.take(0.03));
        assert!(!foresight.is_good());
        let figures = foresight.figures().unwrap();
        assert_eq!((figures.p95_off_m, figures.is_used), (0.03, false));
        // One in twenty may be further off.
        (0..390).for_each(|k| foresight.take(if k % 25 == 0 { 0.5 } else { 0.009 }));
        assert!(foresight.is_good());
        assert_eq!(foresight.figures().unwrap().pulses, LATEST);
        foresight.take(f64::NAN);
    }
}
