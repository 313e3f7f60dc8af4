//! The strip next to a line that meets the requirements at one height.

use acerra_imaging::resolution::{across_track_m, longest_step_m, range_m};

use super::{LIGHT_SPEED_M_S, PlanError, PlanFile, image_snr_db};

/// Imaged strip at one height: all places between two distances, on both sides of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swath {
    /// Height above ground (m).
    pub height_m: f64,
    /// Nearest distance from the line with the required resolution (m).
    pub near_m: f64,
    /// Farthest distance in the beam, in the record and over the noise (m).
    pub far_m: f64,
    /// Limit on the far side.
    pub far_limit: FarLimit,
}

/// Limits of a swath on its far side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarLimit {
    /// The antenna's beam.
    Beam,
    /// The signal-to-noise ratio.
    Noise,
    /// The end of the record.
    Record,
}

/// The view and step for the required along-track resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Half of the angle under which each target must be seen (rad).
    pub half_rad: f64,
    /// Longest distance between scans without aliasing (m).
    pub longest_step_m: f64,
}

impl View {
    /// The narrowest view with the required resolution, by Eq. (6) solved for the angle.
    pub fn of(file: &PlanFile) -> Result<Self, PlanError> {
        let radar = &file.radar;
        let sine = LIGHT_SPEED_M_S / (4.0 * radar.centre_hz() * file.want.along_m);
        let most = radar.half_beam_rad().sin();
        if sine >= most {
            return Err(PlanError::Impossible(format!(
                "{:.3} m along the track cannot be had: the beam of {}° resolves {:.3} m at best",
                file.want.along_m,
                radar.beam_deg,
                LIGHT_SPEED_M_S / (4.0 * radar.centre_hz() * most),
            )));
        }
        let half_rad = sine.asin();
        let [_, high_hz] = radar.band_hz();
        let longest_step_m = longest_step_m(high_hz, half_rad, LIGHT_SPEED_M_S)
            .map_err(|e| PlanError::Impossible(e.to_string()))?;
        Ok(Self {
            half_rad,
            longest_step_m,
        })
    }
}

impl Swath {
    /// The swath of one height; where it is empty, an error that names the limiting end.
    pub(super) fn at(
        file: &PlanFile,
        view: &View,
        height_m: f64,
        step_m: f64,
    ) -> Result<Self, PlanError> {
        let (radar, want) = (&file.radar, &file.want);
        let theory = |e: acerra_imaging::ImagingError| PlanError::Impossible(e.to_string());
        let dr = range_m(radar.bandwidth_hz(), LIGHT_SPEED_M_S).map_err(theory)?;

        // Off the axis by the view along the track and by the offset across it.
        let (cos_view, cos_beam) = (view.half_rad.cos(), radar.half_beam_rad().cos());
        let offset = |range_m: f64| (range_m * range_m - height_m * height_m).max(0.0).sqrt();
        let beam_m = offset(height_m * cos_view / cos_beam);
        let record_m = offset(radar.max_range_m * cos_view);
        let noise_m = {
            let enough = |d: f64| {
                image_snr_db(
                    radar,
                    height_m.hypot(d),
                    want.rcs_dbsm,
                    view.half_rad,
                    step_m,
                ) >= want.snr_db
            };
            if !enough(0.0) {
                0.0
            } else {
                bisect(0.0, beam_m.max(record_m) + 1.0, enough)
            }
        };
        let (far_m, far_limit) = [
            (beam_m, FarLimit::Beam),
            (noise_m, FarLimit::Noise),
            (record_m, FarLimit::Record),
        ]
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((beam_m, FarLimit::Beam));

        let across = |d: f64| across_track_m(dr, height_m, d);
        let finest_m = across(far_m).map_err(theory)?;
        if finest_m > want.across_m {
            return Err(PlanError::Impossible(format!(
                "{:.2} m across the track cannot be had from {height_m:.1} m: {} at {far_m:.1} m \
                 from the line, where it is {finest_m:.2} m",
                want.across_m,
                far_limit.reason(),
            )));
        }
        let coarse = |d: f64| across(d).is_ok_and(|a| a > want.across_m);
        let near_m = if coarse(0.0) {
            bisect(0.0, far_m, coarse)
        } else {
            0.0
        };
        let swath = Self {
            height_m,
            near_m,
            far_m,
            far_limit,
        };
        let stray_m = file.drone.stray_m;
        if far_m - near_m <= 2.0 * stray_m + 0.05 {
            return Err(PlanError::Impossible(format!(
                "from {height_m:.1} m only the strip from {near_m:.1} to {far_m:.1} m from a \
                 line is good enough, too narrow for a drone that strays {stray_m} m"
            )));
        }
        Ok(swath)
    }

    /// The swath that remains when the drone strays: (near, far), m.
    pub(super) fn sure(&self, stray_m: f64) -> (f64, f64) {
        let near = if self.near_m > 0.0 {
            self.near_m + stray_m
        } else {
            0.0
        };
        (near, self.far_m - stray_m)
    }
}

impl FarLimit {
    pub(super) const fn reason(self) -> &'static str {
        match self {
            Self::Beam => "the beam ends",
            Self::Noise => "the echo drowns in noise",
            Self::Record => "the record ends",
        }
    }
}

/// Where something that holds at `low` stops holding, up to `high`.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if holds(high) {
        return high;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(along_m: f64, across_m: f64) -> PlanFile {
        let text = format!(
            "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9002, 14.2003]]\n\
             [want]\nalong_m = {along_m}\nacross_m = {across_m}\nrcs_dbsm = 10\n"
        );
        PlanFile::parse(&text).expect("possible")
    }

    #[test]
    fn the_view_is_eq_6_turned_round() {
        let view = View::of(&file(0.0369, 0.5)).expect("a view");
        // Half an aperture of 3 m at 5 m: θ = 0.540.
        assert!((view.half_rad - 0.540).abs() < 2e-3, "{}", view.half_rad);
        assert!((view.longest_step_m - 0.0369 * 3.95 / 4.8).abs() < 1e-6);
        let error = View::of(&file(0.02, 0.5))
            .expect_err("too fine")
            .to_string();
        assert!(error.contains("resolves 0.027 m at best"), "{error}");
    }

    #[test]
    fn the_swath_ends_where_the_equations_do() {
        let file = file(0.05, 0.41);
        let view = View::of(&file).expect("a view");
        let swath = Swath::at(&file, &view, 10.0, view.longest_step_m).expect("a swath");
        // Table 4: 0.41 m across at 2 m from 10 m.
        assert!((swath.near_m - 2.0).abs() < 0.02, "{swath:?}");
        let off_axis = (10.0 * view.half_rad.cos() / 10f64.hypot(swath.far_m)).acos();
        assert_eq!(swath.far_limit, FarLimit::Beam);
        assert!((off_axis.to_degrees() - 45.0).abs() < 1e-6);
        let deaf = PlanFile {
            want: crate::Want {
                rcs_dbsm: -25.0,
                ..file.want.clone()
            },
            ..file.clone()
        };
        let swath = Swath::at(&deaf, &view, 10.0, view.longest_step_m);
        let snr = |d: f64| {
            image_snr_db(
                &deaf.radar,
                10f64.hypot(d),
                -25.0,
                view.half_rad,
                view.longest_step_m,
            )
        };
        match swath {
            Ok(s) => assert!((snr(s.far_m) - deaf.want.snr_db).abs() < 1e-6),
            Err(e) => assert!(e.to_string().contains("drowns in noise"), "{e}"),
        }
        let fine = PlanFile {
            want: crate::Want {
                across_m: 0.09,
                ..file.want.clone()
            },
            ..file
        };
        let error = Swath::at(&fine, &view, 10.0, 0.04)
            .expect_err("too fine")
            .to_string();
        assert!(
            error.contains("cannot be had from 10.0 m: the beam ends"),
            "{error}"
        );
    }
}
