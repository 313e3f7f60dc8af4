//! Keys for an image below the surface, from radar files that give no heights of their traces.

use acerra_imaging::SPEED_OF_LIGHT_M_S;

use super::logs::RadarInput;
use super::sounding::{Heights, Sounding};
use crate::settings_files::template::Filled;

/// Height above the surface of antennas on a skid or on wheels (m).
pub(super) const ANTENNA_HEIGHT_M: f64 = 0.01;
/// Relative permittivity of a soil of which nothing is known: waves travel at a third of the speed of light.
const USUAL_PERMITTIVITY: f64 = 9.0;
/// Pixels in the shortest wavelength in the soil, at least: echoes have half that wavelength in depth.
const PIXELS_A_WAVELENGTH: f64 = 6.0;

/// The ground below antennas that are on it.
pub(super) struct OnGround {
    permittivity: f64,
    is_stated: bool,
    /// Depths of the image (m).
    from_m: f64,
    to_m: f64,
    pixel_m: f64,
}

impl OnGround {
    /// The ground below these radars, where the files give no heights: within the time that all records cover, at the
    /// resolution of the band of their echoes.
    pub(super) fn of(radar: &[&RadarInput], band_ghz: Option<[f64; 2]>) -> Option<Self> {
        let [low_ghz, high_ghz] = band_ghz?;
        let without_heights =
            |log: &&RadarInput| log.sounding.filter(|s| s.heights == Heights::None);
        let soundings: Option<Vec<Sounding>> = radar.iter().map(without_heights).collect();
        let soundings = soundings.filter(|found| !found.is_empty())?;
        let stated = soundings[0].permittivity;
        let permittivity = stated
            .filter(|_| soundings.iter().all(|one| one.permittivity == stated))
            .unwrap_or(USUAL_PERMITTIVITY);
        let window_s = soundings.iter().map(|one| one.window_s);
        let speed_m_s = SPEED_OF_LIGHT_M_S / permittivity.sqrt();
        let cell_m = 0.5 * speed_m_s / (1e9 * (high_ghz - low_ghz));
        let from_m = rounded(cell_m, f64::round);
        let to_m = rounded(
            0.5 * speed_m_s * window_s.fold(f64::INFINITY, f64::min),
            f64::floor,
        );
        let wavelength_m = speed_m_s / (1e9 * high_ghz);
        (from_m < to_m).then(|| Self {
            permittivity,
            is_stated: Some(permittivity) == stated,
            from_m,
            to_m,
            pixel_m: side_m(wavelength_m / PIXELS_A_WAVELENGTH),
        })
    }

    /// Keys of a volume below lines whose ends the campaign states.
    pub(super) fn below_lines(&self) -> Vec<Filled> {
        let depths = format!("[{}, {}]", -self.to_m, -self.from_m);
        let depths = Filled::new("image.z_m", depths)
            .because("depths from one cell of the resolution, above which residues of the surface echo are, to the end of the record");
        vec![self.soil(), depths, self.pixel()]
    }

    /// Keys of a slice below traces that lie at z = 0, as the file places them.
    pub(super) fn below_places(&self) -> Vec<Filled> {
        let surface = Filled::new("ground.surface_z_m", format!("{}", -ANTENNA_HEIGHT_M)).because(
            "the file gives no heights: its traces lie at z = 0, the surface as far below as the antennas are high",
        );
        let slice = Filled::new("image.z_m", format!("{}", -2.0 * self.from_m)).because(format!(
            "a slice; a volume of all depths, z_m = [{}, {}], needs x_m and y_m as well",
            -self.to_m, -self.from_m
        ));
        vec![self.soil(), surface, slice, self.pixel()]
    }

    /// Sentence on the soil and on antennas that are not on the ground.
    pub(super) fn question(&self) -> String {
        let by = if self.is_stated {
            "as the header states"
        } else {
            "a usual soil's"
        };
        format!(
            "what is the soil? Antennas on the ground and a relative permittivity of {}, {by}, are assumed; for an image \
             in air remove [ground] and state [image] z_m",
            self.permittivity
        )
    }

    fn soil(&self) -> Filled {
        let soil = Filled::new(
            "ground.relative_permittivity",
            format!("{:?}", self.permittivity),
        );
        soil.because(if self.is_stated {
            "by the header of the file"
        } else {
            "assumed: waves travel at 0.1 m/ns in many soils; \"auto\" finds it where echoes of buried points are strong"
        })
    }

    fn pixel(&self) -> Filled {
        Filled::new("image.pixel_m", format!("{}", self.pixel_m))
            .because("at most a sixth of the shortest wavelength in the soil")
    }
}

/// A length to two significant digits.
fn rounded(length_m: f64, to_whole: fn(f64) -> f64) -> f64 {
    let digits = 1 - length_m.log10().floor() as i32;
    let unit = 10f64.powi(digits);
    to_whole(length_m * unit) / unit
}

/// The greatest of 1, 2 and 5 times a power of ten that does not exceed a length (m).
fn side_m(length_m: f64) -> f64 {
    let decade = -length_m.log10().floor() as i32;
    let share = length_m * 10f64.powi(decade);
    let digit = [5.0, 2.0].into_iter().find(|d| *d <= share).unwrap_or(1.0);
    digit / 10f64.powi(decade)
}
