//! Autofocus: the places of the traces from the echoes of prominent points, between `clean` and `focus`.
//!
//! The prior is the positions' own statement of their errors: covariances, trace by trace, and the
//! correlation time.

mod globals;
mod lasting;
mod options;
mod tracks;

use std::f64::consts::TAU;

use acerra_autofocus::{AutofocusError, Autofocused, Correlation, PositionPrior};
use acerra_geo::matrix::Matrix3;
use acerra_imaging::{ImagingError, PlaneGrid};
use acerra_radar::Spectrum;
use num_complex::Complex64;

pub use crate::align::correction::PathCorrection;
pub use crate::align::quantity::{GlobalCorrection, Quantity};
use crate::choices::Sum;
use crate::control::Control;
use crate::echoes::sharpen::coarse;
use crate::position::Positions;
use crate::prepare::{Prepared, Track};
pub use acerra_autofocus::Decision;
pub use options::{AutofocusFailure, AutofocusOptions};

/// Pixels in which points are looked for, at most.
const MOST_PIXELS: f64 = 400_000.0;
/// Errors last at least so long by default (s).
const LEAST_CORRELATION_S: f64 = 0.25;
/// Default correlation time of errors in sampling intervals of the positions: a position interpolated between
/// two epochs has the errors of both.
const CORRELATED_SAMPLES: f64 = 2.0;
/// Time between tracks on the axis of the prior: their errors are independent (s).
const BETWEEN_TRACKS_S: f64 = 1e6;

impl Prepared {
    /// Estimates the errors of the places from the echoes, and corrects the places where the corrections are
    /// significant. The statistics of the original positions stay in [`Prepared::correction`].
    ///
    /// # Errors
    /// Positions without deviations, data that are refused, cancellation.
    pub fn autofocus(
        &mut self,
        options: &AutofocusOptions,
        control: &Control<'_>,
    ) -> Result<&PathCorrection, AutofocusFailure> {
        let (mut prior, correlation_s) = self.position_prior(options)?;
        let free = self.free(options)?;
        prior.globals = free.iter().map(|f| f.global.clone()).collect();
        let light_speed_m_s = self.scene.light_speed_m_s;
        if options.sigma_m.is_none() {
            self.keep_what_changes(&mut prior.covariance_m2);
        }
        let prior_sigma_m = self.aligned.sigma_m.clone();
        let found = self.estimate(&prior, options, control)?;
        let correction = PathCorrection {
            stated_m: self.aligned.position_m.clone(),
            stated: self.aligned.all.clone(),
            prior_sigma_m,
            correlation_s,
            globals: free
                .iter()
                .zip(&found.globals)
                .map(|(free, found)| free.corrected(found, light_speed_m_s))
                .collect(),
            stated_light_speed_m_s: light_speed_m_s,
            found,
        };
        if correction.is_applied() {
            self.apply(&correction);
        }
        Ok(self.correction.insert(correction))
    }

    /// These tracks with the places as the positions state them.
    #[must_use]
    pub fn as_stated(&self) -> Self {
        let mut stated = self.clone();
        if let Some(correction) = stated.correction.take() {
            for (height, (old, new)) in stated
                .aligned
                .height_m
                .iter_mut()
                .zip(correction.stated_m.iter().zip(&self.aligned.position_m))
            {
                *height += old[2] - new[2];
            }
            if correction.is_applied() {
                let light_speed_m_s = correction.stated_light_speed_m_s;
                stated.scene.light_speed_m_s = light_speed_m_s;
                stated.take_off(&correction, -1.0);
            }
            stated.aligned.position_m = correction.stated_m;
            stated.aligned.all = correction.stated;
            stated.aligned.sigma_m = correction.prior_sigma_m;
        }
        stated
    }

    fn estimate(
        &self,
        prior: &PositionPrior,
        options: &AutofocusOptions,
        control: &Control<'_>,
    ) -> Result<Autofocused, AutofocusFailure> {
        let mut limits = acerra_autofocus::AutofocusOptions::default();
        if let Some(most) = options.max_points {
            limits.most_points = most;
        }
        if options.sum == Sum::Incoherent {
            let parts = self.tracks.iter().map(|track| track.range.clone());
            limits.coherent_parts = parts.filter(|part| !part.is_empty()).collect();
        }
        let refused = |error: ImagingError| AutofocusFailure::from(AutofocusError::from(error));
        if !self.aligned.antennas_from_place_m.is_empty() {
            return Err(refused(ImagingError::OutOfRange {
                what: "number of antennas",
                expected: "one, which transmits and receives",
                found: 2.0,
            }));
        }
        let weight = vec![1.0; self.aligned.position_m.len()];
        let pulses = self.echoes().pulses(&weight).map_err(refused)?;
        let imaging = control.operation();
        let pixels = &self.scene.pixels;
        let found = match &pixels.surface {
            Some(surface) => {
                acerra_autofocus::autofocus(pulses, &**surface, prior, &limits, imaging)
            }
            None => {
                let grid: PlaneGrid = coarse(pixels.grid, MOST_PIXELS).map_err(refused)?;
                acerra_autofocus::autofocus(pulses, grid, prior, &limits, imaging)
            }
        };
        Ok(found?)
    }

    /// The prior of the places' errors, and the correlation time (s).
    pub(crate) fn position_prior(
        &self,
        options: &AutofocusOptions,
    ) -> Result<(PositionPrior, f64), AutofocusFailure> {
        let traces = self.aligned.position_m.len();
        let covariance_m2 = match options.sigma_m {
            Some(stated) => vec![with_deviations(None, stated); traces],
            None => self
                .stated_covariances_m2()
                .ok_or(AutofocusFailure::NoDeviations)?,
        };
        let correlation_s = options
            .correlation_s
            .unwrap_or_else(|| self.tracks.iter().map(lasting_s).fold(0.0, f64::max));
        let mut abscissa = Vec::with_capacity(traces);
        for track in &self.tracks {
            let own = &self.aligned.time_s[track.range.clone()];
            let start = own.first().copied().unwrap_or(0.0);
            let before = abscissa.last().map_or(0.0, |last| last + BETWEEN_TRACKS_S);
            abscissa.extend(own.iter().map(|t| before + t - start));
        }
        let correlation = Correlation::Matern32 {
            length: correlation_s,
        };
        let prior = PositionPrior::of_covariances(&covariance_m2, &abscissa, correlation);
        Ok((prior, correlation_s))
    }

    /// Covariances of the places of the imaged traces; none where the positions state none.
    fn stated_covariances_m2(&self) -> Option<Vec<Matrix3>> {
        let aligned = &self.aligned;
        if aligned.sigma_m.len() != aligned.position_m.len() {
            return None;
        }
        let mut found = Vec::with_capacity(aligned.sigma_m.len());
        let mut before = 0;
        for track in &self.tracks {
            for m in track.range.clone() {
                let full = aligned.all[before + aligned.traces[m]].covariance_m2;
                found.push(with_deviations(full, aligned.sigma_m[m]));
            }
            before += track.traces_in_log;
        }
        Some(found)
    }

    /// Removes the estimated delays and phases of the instruments from the spectra, `times` fold.
    fn take_off(&mut self, correction: &PathCorrection, times: f64) {
        let Spectrum {
            frequency_hz,
            values,
            ..
        } = &mut self.spectrum;
        let pulses: Vec<_> = values.chunks_exact_mut(frequency_hz.len()).collect();
        let mut pulses = pulses.into_iter();
        for (number, track) in self.tracks.iter().enumerate() {
            let found = correction.instrument(number);
            let delay_ns = found.delay_ns + correction.moved_zero_ns(number);
            let turn: Vec<Complex64> = frequency_hz
                .iter()
                .map(|f| TAU * f * 1e-9 * delay_ns - found.phase_deg.to_radians())
                .map(|turn_rad| Complex64::cis(times * turn_rad))
                .collect();
            for pulse in pulses.by_ref().take(track.range.len()) {
                pulse.iter_mut().zip(&turn).for_each(|(v, turn)| *v *= turn);
            }
        }
    }

    fn apply(&mut self, correction: &PathCorrection) {
        let found = &correction.found;
        self.take_off(correction, 1.0);
        self.scene.light_speed_m_s += correction.of_all(Quantity::LightSpeed);
        let aligned = &mut self.aligned;
        let rises = found.position_m.iter().zip(&aligned.position_m);
        for (height, (new, old)) in aligned.height_m.iter_mut().zip(rises) {
            *height += new[2] - old[2];
        }
        aligned.position_m.clone_from(&found.position_m);
        if !aligned.sigma_m.is_empty() {
            aligned.sigma_m.clone_from(&found.sigma_m);
        }
        let mut before = 0;
        for track in &self.tracks {
            for m in track.range.clone() {
                let place = &mut aligned.all[before + aligned.traces[m]];
                place.position_m = found.position_m[m];
                place.covariance_m2 = Some(found.covariance_m2[m]);
            }
            before += track.traces_in_log;
        }
    }
}

/// A covariance of these deviations. The correlation of two axes is that of `full` where `full` has the
/// deviations of both; an axis with another deviation, as heights by the radar have, is independent.
fn with_deviations(full: Option<Matrix3>, sigma_m: [f64; 3]) -> Matrix3 {
    let stated = |i: usize, c: &Matrix3| {
        let own_m = c[i][i].max(0.0).sqrt();
        (own_m - sigma_m[i]).abs() <= 1e-9 * sigma_m[i]
    };
    let of = |i: usize, j: usize| match full {
        _ if i == j => sigma_m[i] * sigma_m[i],
        Some(c) if stated(i, &c) && stated(j, &c) => c[i][j],
        _ => 0.0,
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| of(i, j)))
}

/// Correlation time of the errors of a track's positions, from the interval of the positions (s).
fn lasting_s(track: &Track) -> f64 {
    let interval_s = match &track.positions {
        Positions::Trajectory(trajectory) => trajectory.sample_interval_s(),
        Positions::PerTrace(_) => None,
    };
    interval_s
        .map_or(0.0, |interval| CORRELATED_SAMPLES * interval)
        .max(LEAST_CORRELATION_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_between_axes_are_kept_where_both_are_the_positions() {
        let full = [[4.0, 1.0, -2.0], [1.0, 9.0, 3.0], [-2.0, 3.0, 16.0]];
        assert_eq!(with_deviations(Some(full), [2.0, 3.0, 4.0]), full);
        let heights_by_radar = with_deviations(Some(full), [2.0, 3.0, 0.5]);
        let expected = [[4.0, 1.0, 0.0], [1.0, 9.0, 0.0], [0.0, 0.0, 0.25]];
        assert_eq!(heights_by_radar, expected);
        let none = with_deviations(None, [1.0, 2.0, 3.0]);
        assert_eq!(none, [[1.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 9.0]]);
    }
}
