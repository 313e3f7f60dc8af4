//! Spectra with positions, as they are written and read.

use std::borrow::Cow;

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use num_complex::Complex64;

/// Speed of light in vacuum, m/s.
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// Spectra with positions on the Earth.
#[derive(Clone, Debug)]
pub struct PhaseHistory<'a> {
    /// The frame of all positions: east, north, up about a place on the Earth.
    pub frame: EnuFrame,
    /// The instant from which times count; none where it is not known.
    pub start: Option<GpsTime>,
    /// The channels: one a track.
    pub channels: Vec<Channel<'a>>,
    /// Description and source of the data.
    pub description: Description,
}

/// Description and source of phase history data.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// Name of the collection.
    pub name: String,
    /// The radar.
    pub collector: String,
    /// Names and values of the data's provenance.
    pub items: Vec<(String, String)>,
}

/// The pulses of one track.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    /// Name, unique in the file.
    pub name: String,
    /// Time of each pulse, `[M]`, rising (s).
    pub time_s: Vec<f64>,
    /// Phase centre of the antenna at each pulse: east, north, up, `[M]` (m).
    pub position_m: Vec<[f64; 3]>,
    /// The frequencies of all pulses.
    pub frequency: EvenFrequencies,
    /// Spectra, `[M, N]` row-major: an echo from range R has phase e^{−j4πfR/c}.
    pub spectrum: Cow<'a, [Complex64]>,
    /// First and last fast time at which echoes were kept (s); none where that is not known.
    pub fast_time_s: Option<[f64; 2]>,
}

/// Evenly spaced frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvenFrequencies {
    /// The lowest (Hz).
    pub first_hz: f64,
    /// Spacing (Hz), positive.
    pub step_hz: f64,
    /// Number present.
    pub count: usize,
}

impl EvenFrequencies {
    /// The frequencies `frequency_hz`, where they rise evenly to a millionth of a step; the spacing is
    /// that from the first to the last.
    #[must_use]
    pub fn of(frequency_hz: &[f64]) -> Option<Self> {
        let (first, last) = (*frequency_hz.first()?, *frequency_hz.last()?);
        let steps = frequency_hz.len() - 1;
        let even = Self {
            first_hz: first,
            step_hz: (last - first) / steps as f64,
            count: frequency_hz.len(),
        };
        let is_even = |(n, hz): (usize, &f64)| (hz - even.hz(n)).abs() <= 1e-6 * even.step_hz;
        (even.step_hz > 0.0 && frequency_hz.iter().enumerate().all(is_even)).then_some(even)
    }

    /// Frequency number `n` (Hz).
    #[must_use]
    pub fn hz(&self, n: usize) -> f64 {
        self.first_hz + self.step_hz * n as f64
    }

    /// The last frequency (Hz).
    #[must_use]
    pub fn last_hz(&self) -> f64 {
        self.hz(self.count.saturating_sub(1))
    }
}

/// The pixels for which data were prepared: rectangle and reference point of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Middle of the rectangle: east, north, up (m). It becomes the reference point of the image area
    /// and the stabilization reference point of every pulse.
    pub middle_m: [f64; 3],
    /// Side of a pixel (m).
    pub pixel_m: f64,
    /// Pixels to the east.
    pub nx: usize,
    /// Pixels to the north.
    pub ny: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_even_frequencies_are_even() {
        let of = |hz: &[f64]| EvenFrequencies::of(hz).map(|f| (f.first_hz, f.step_hz, f.count));
        assert_eq!(of(&[3e9, 3.5e9, 4e9]), Some((3e9, 5e8, 3)));
        assert_eq!(of(&[3e9, 3.6e9, 4e9]), None);
        assert_eq!(of(&[4e9, 3e9]), None);
        assert_eq!(of(&[3e9]), None);
        assert_eq!(of(&[]), None);
    }
}
