//! Theoretical resolution for one geometry, with the limits of validity.

use std::fmt;

use serde::Serialize;

use super::equations::{
    SMALL_ANGLE_LIMIT_RAD, across_track_bounds_m, across_track_m, along_track_m,
    along_track_small_angle_m, half_view_rad, longest_step_m, range_m,
};
use super::geometry::{Aperture, Band};
use crate::checks::check_positive;
use crate::error::ImagingError;

/// Results of Eqs. (6)–(12) for one geometry. All distances in metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Eq. (6); `None` without an aperture.
    pub along_m: Option<f64>,
    /// Eq. (7); `None` without an aperture.
    pub along_small_angle_m: Option<f64>,
    /// Eq. (8).
    pub range_m: f64,
    /// Eq. (9).
    pub across_m: f64,
    /// Eq. (12): least and greatest across-track resolution from this height.
    pub across_bounds_m: [f64; 2],
    /// Half view θ of Eqs. (6) and (7), rad; `None` without an aperture.
    pub half_view_rad: Option<f64>,
    /// Longest distance between pulses without grating lobes; `None` without an aperture.
    pub longest_step_m: Option<f64>,
    /// The equations used outside their range of validity.
    pub caveats: Vec<Caveat>,
}

/// An equation used outside its range of validity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum Caveat {
    /// Eq. (7) is off by more than 5 %: use Eq. (6).
    SmallAngle {
        /// Half view, rad.
        half_view_rad: f64,
    },
    /// The range resolution is more than half of the range: the derivation of Eq. (9) no longer holds.
    CoarseRange {
        /// Range resolution over range.
        ratio: f64,
    },
    /// The band is wider than its centre frequency: one wavelength no longer represents the band in Eq. (6).
    WideBand {
        /// Bandwidth over centre frequency.
        ratio: f64,
    },
    /// The target is nearer to the track than its resolution: the lobe spans the track and includes the
    /// ghost, so that Eq. (9) is half of the width of their common spot.
    UnderTrack {
        /// Offset over across-track resolution.
        ratio: f64,
    },
}

impl fmt::Display for Caveat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SmallAngle { half_view_rad } => write!(
                f,
                "the half view of {:.1}° is too wide for Eq. (7) (5 % off beyond {:.0}°); Eq. (6) holds",
                half_view_rad.to_degrees(),
                SMALL_ANGLE_LIMIT_RAD.to_degrees()
            ),
            Self::CoarseRange { ratio } => write!(
                f,
                "the range resolution is {ratio:.2} of the range: Eq. (9) presumes much less"
            ),
            Self::WideBand { ratio } => write!(
                f,
                "the band is {ratio:.2} of its centre frequency: Eq. (6) presumes one wavelength"
            ),
            Self::UnderTrack { ratio } => write!(
                f,
                "the target lies {ratio:.2} resolutions from the track: its spot spans the track and merges \
                 with its ghost"
            ),
        }
    }
}

impl Prediction {
    /// Evaluates the theory; `half_aperture_m` is the half-length of the track abeam the target.
    ///
    /// # Errors
    /// A height that is not positive, a negative offset, a band that has no width or does not lie
    /// above 0 Hz, a half-aperture that is not positive.
    ///
    /// ```
    /// use acerra_imaging::resolution::{Aperture, Band, Prediction};
    /// let band = Band { low_hz: 3.1e9, high_hz: 4.8e9, light_speed_m_s: 3e8 };
    /// let track_2 = Prediction::of(Aperture::new(10.0, 2.0)?, band, Some(9.0))?;
    /// // Table 4: 0.03 m along, 0.41 m across.
    /// assert!((track_2.along_m.unwrap() - 0.03).abs() < 0.005);
    /// assert!((track_2.across_m - 0.410).abs() < 5e-4);
    /// # Ok::<(), acerra_imaging::ImagingError>(())
    /// ```
    pub fn of(
        aperture: Aperture,
        band: Band,
        half_aperture_m: Option<f64>,
    ) -> Result<Self, ImagingError> {
        let Aperture { height_m, offset_m } = Aperture::new(aperture.height_m, aperture.offset_m)?;
        let c = band.light_speed_m_s;
        check_positive("low_hz", "above 0 Hz", band.low_hz)?;
        check_positive(
            "bandwidth_hz",
            "above 0 Hz (the upper frequency above the lower)",
            band.width_hz(),
        )?;
        let range_resolution_m = range_m(band.width_hz(), c)?;
        let across_m = across_track_m(range_resolution_m, height_m, offset_m)?;
        let half_view = half_aperture_m
            .map(|l| half_view_rad(l, height_m, offset_m))
            .transpose()?;
        let centre_hz = band.centre_hz();
        let along_m = half_view
            .map(|v| along_track_m(centre_hz, v, c))
            .transpose()?;

        let mut caveats = vec![];
        if let Some(half_view_rad) = half_view.filter(|v| *v > SMALL_ANGLE_LIMIT_RAD) {
            caveats.push(Caveat::SmallAngle { half_view_rad });
        }
        let coarse = range_resolution_m / aperture.range_m();
        if coarse > 0.5 {
            caveats.push(Caveat::CoarseRange { ratio: coarse });
        }
        let wide = band.width_hz() / centre_hz;
        if wide > 1.0 {
            caveats.push(Caveat::WideBand { ratio: wide });
        }
        if offset_m < across_m {
            caveats.push(Caveat::UnderTrack {
                ratio: offset_m / across_m,
            });
        }
        Ok(Self {
            along_m,
            along_small_angle_m: half_view
                .map(|v| along_track_small_angle_m(centre_hz, v, c))
                .transpose()?,
            range_m: range_resolution_m,
            across_m,
            across_bounds_m: across_track_bounds_m(range_resolution_m, height_m)?,
            half_view_rad: half_view,
            longest_step_m: half_view
                .map(|v| longest_step_m(band.high_hz, v, c))
                .transpose()?,
            caveats,
        })
    }
}
