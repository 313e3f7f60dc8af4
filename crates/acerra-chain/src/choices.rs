//! What each stage can be asked for, as a settings file writes it: a word, a number, a list or a
//! table.

use schemars::JsonSchema;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};
use toml::Value;

/// `[radar] select`: the traces that enter background and image.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Select {
    /// The traces during which the platform moves, where it stands much of the time; every trace
    /// otherwise.
    #[default]
    Auto,
    /// Every trace that has a position.
    All,
    /// The traces during which the platform moves.
    Moving,
    /// Trace numbers counted from 0, both ends included.
    #[serde(untagged)]
    Range([usize; 2]),
}

impl<'de> Deserialize<'de> for Select {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "expected \"auto\", \"all\", \"moving\" or [first, last]";
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "auto" => Ok(Self::Auto),
            Value::String(word) if word == "all" => Ok(Self::All),
            Value::String(word) if word == "moving" => Ok(Self::Moving),
            Value::Array(ends) => match ends.as_slice() {
                [Value::Integer(first), Value::Integer(last)] if 0 <= *first && first <= last => {
                    let index = |i: i64| usize::try_from(i).map_err(Error::custom);
                    Ok(Self::Range([index(*first)?, index(*last)?]))
                }
                _ => Err(Error::custom(format!(
                    "{EXPECTED}, whole numbers with 0 <= first <= last; found {}",
                    Value::Array(ends)
                ))),
            },
            other => Err(Error::custom(format!("{EXPECTED}; found {other}"))),
        }
    }
}

/// `[trajectory] height`: where the heights of the flight come from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightSource {
    /// The positions.
    #[default]
    Positions,
    /// The surface echo of the radar, over level ground.
    Radar,
}

/// `[ground] surface`: where the surface of the ground lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GroundSurface {
    /// Level, at `surface_z_m`.
    #[default]
    Level,
    /// That of `[image] terrain`, with one soil below; `[image] z_m` gives the heights of the image.
    Terrain,
    /// As the first echo of the ground places it below the tracks, with one soil below. Where `[radar] delay_ns` is not
    /// stated, its median is at `surface_z_m`.
    Radar,
}

/// `[trajectory] height_datum`: what the heights of a table are above.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightDatum {
    /// The ellipsoid.
    Ellipsoid,
    /// The sea; `[image] geoid` raises them to the ellipsoid.
    Sea,
    /// The place of take-off, whose height above the ellipsoid is not known.
    TakeOff,
}

impl From<HeightDatum> for acerra_geo::read::HeightDatum {
    fn from(datum: HeightDatum) -> Self {
        match datum {
            HeightDatum::Ellipsoid => Self::Ellipsoid,
            HeightDatum::Sea => Self::Sea,
            HeightDatum::TakeOff => Self::TakeOff,
        }
    }
}

/// `[radar] delay_ns`: the fast time at which range is zero.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Delay {
    /// Found from the data.
    Auto,
    /// Given, in nanoseconds.
    #[serde(untagged)]
    Nanoseconds(f64),
}

impl Delay {
    /// The delay given, in nanoseconds; none where it is to be found.
    #[must_use]
    pub fn given_ns(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Nanoseconds(delay_ns) => Some(delay_ns),
        }
    }
}

impl<'de> Deserialize<'de> for Delay {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "auto" => Ok(Self::Auto),
            other => within(&other, LONGEST_NS)
                .map(Self::Nanoseconds)
                .ok_or_else(|| {
                    Error::custom(format!(
                        "expected nanoseconds, within a million, or \"auto\"; found {other}"
                    ))
                }),
        }
    }
}

/// `[ground] relative_permittivity`: that of the soil.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Permittivity {
    /// Found from the data.
    Auto,
    /// Given.
    #[serde(untagged)]
    Relative(f64),
}

impl Permittivity {
    /// The permittivity given; none where it is to be found.
    #[must_use]
    pub fn given(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Relative(given) => Some(given),
        }
    }
}

impl<'de> Deserialize<'de> for Permittivity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "auto" => Ok(Self::Auto),
            Value::Float(given) => Ok(Self::Relative(given)),
            Value::Integer(given) => Ok(Self::Relative(given as f64)),
            other => Err(Error::custom(format!(
                "expected the relative permittivity of the soil as a number, or \"auto\"; found {other}"
            ))),
        }
    }
}

/// `[trajectory] time_offset_s`: trajectory time minus radar time.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeOffset {
    /// Found from the data.
    Auto,
    /// Taken from the clock that was recorded beside the radar log.
    Logged,
    /// Given, in seconds.
    #[serde(untagged)]
    Seconds(f64),
}

impl Default for TimeOffset {
    fn default() -> Self {
        Self::Seconds(0.0)
    }
}

impl<'de> Deserialize<'de> for TimeOffset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "auto" => Ok(Self::Auto),
            Value::String(word) if word == "logged" => Ok(Self::Logged),
            other => within(&other, LONGEST_S).map(Self::Seconds).ok_or_else(|| {
                Error::custom(format!(
                    "expected seconds, within 1e10, \"auto\" or \"logged\"; found {other}"
                ))
            }),
        }
    }
}

/// `[image] z_m`: the height of the image.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum Heights {
    /// A horizontal plane at this height (m).
    Plane(f64),
    /// A volume between two heights (m).
    Range([f64; 2]),
}

impl<'de> Deserialize<'de> for Heights {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let height_m = |value: &Value| within(value, FARTHEST_M);
        if let Some(height) = height_m(&value) {
            return Ok(Self::Plane(height));
        }
        if let Some([from, to]) = value.as_array().map(Vec::as_slice)
            && let (Some(from), Some(to)) = (height_m(from), height_m(to))
            && from <= to
        {
            return Ok(Self::Range([from, to]));
        }
        Err(Error::custom(format!(
            "expected a height within 1e7 m, or [from, to] with from <= to; found {value}"
        )))
    }
}

/// `[preprocess] zero_timing`: how the fast time at which range is zero is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ZeroTiming {
    /// The paper's: the surface echo of the first trace is put at 2h/c.
    #[default]
    FirstTrace,
    /// The direct wave between transmitter and receiver, the first arrival of the mean trace, is put at the time of
    /// light from one to the other: for antennas whose places apart are known.
    DirectWave,
    /// Fast time is left as it is (less `[radar] delay_ns`).
    None,
    /// Fast time is shifted by so much.
    #[serde(untagged)]
    Shift {
        /// Added to fast time, in nanoseconds.
        shift_ns: f64,
    },
}

impl<'de> Deserialize<'de> for ZeroTiming {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "first-trace" => Ok(Self::FirstTrace),
            Value::String(word) if word == "direct-wave" => Ok(Self::DirectWave),
            Value::String(word) if word == "none" => Ok(Self::None),
            other => single(&other, "shift_ns")
                .and_then(|value| within(value, LONGEST_NS))
                .map(|shift_ns| Self::Shift { shift_ns })
                .ok_or_else(|| {
                    Error::custom(format!(
                        "expected \"first-trace\", \"direct-wave\", \"none\" or {{ shift_ns = NUMBER }}; \
                         found {other}"
                    ))
                }),
        }
    }
}

/// `[preprocess] background`: what is subtracted from every trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// The mean of the selected traces (the paper's).
    #[default]
    Mean,
    /// Their median, sample by sample.
    Median,
    /// The mean, and the echo of the surface wherever the height puts it: both at once, with `[ground]` the default.
    Surface,
    /// Nothing.
    None,
    /// The mean of a window of so many traces about each trace.
    #[serde(untagged)]
    Window {
        /// Length of the window, in traces.
        window: usize,
    },
    /// The strongest principal components.
    #[serde(untagged)]
    Components {
        /// How many are removed.
        components: usize,
    },
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let count = |key| {
            single(&value, key)
                .and_then(Value::as_integer)
                .and_then(|n| usize::try_from(n).ok())
                .filter(|n| *n > 0)
        };
        match &value {
            Value::String(word) if word == "mean" => return Ok(Self::Mean),
            Value::String(word) if word == "median" => return Ok(Self::Median),
            Value::String(word) if word == "surface" => return Ok(Self::Surface),
            Value::String(word) if word == "none" => return Ok(Self::None),
            _ => {}
        }
        if let Some(window) = count("window") {
            return Ok(Self::Window { window });
        }
        if let Some(components) = count("components") {
            return Ok(Self::Components { components });
        }
        Err(Error::custom(format!(
            "expected \"mean\", \"median\", \"surface\", \"none\", {{ window = TRACES }} or \
             {{ components = COUNT }} with a count above 0; found {value}"
        )))
    }
}

/// `[preprocess] gate_ns`: the part of each trace that is kept, about 2h/c.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Gate {
    /// From 6 ns before 2h/c to 24 ns after it, where the image lies at such ranges; the whole trace
    /// where it looks to the side.
    #[default]
    Auto,
    /// The whole trace.
    None,
    /// From so many nanoseconds after 2h/c (negative: before) to so many after it.
    #[serde(untagged)]
    About([f64; 2]),
}

impl Gate {
    /// The gate of [`Gate::Auto`] where the image lies below the flight: nanoseconds about 2h/c.
    pub const BELOW_NS: [f64; 2] = [-6.0, 24.0];

    /// The nanoseconds about 2h/c that are kept, [`Gate::Auto`] taken for a view below the flight;
    /// none where all are.
    #[must_use]
    pub fn about_ns(self) -> Option<[f64; 2]> {
        match self {
            Self::Auto => Some(Self::BELOW_NS),
            Self::About(ns) => Some(ns),
            Self::None => None,
        }
    }
}

impl<'de> Deserialize<'de> for Gate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        match value.as_str() {
            Some("none") => return Ok(Self::None),
            Some("auto") => return Ok(Self::Auto),
            _ => {}
        }
        if let Some([from, to]) = value.as_array().map(Vec::as_slice)
            && let [Some(from), Some(to)] = [from, to].map(|end| within(end, LONGEST_NS))
            && from < to
        {
            return Ok(Self::About([from, to]));
        }
        Err(Error::custom(format!(
            "expected [from, to] with from < to, within a million ns, \"auto\" or \"none\"; found {value}"
        )))
    }
}

/// `[tracks] sum`: what of several tracks is summed.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sum {
    /// Amplitudes: one image with the aperture of all.
    #[default]
    Coherent,
    /// Powers of each track's own image.
    Incoherent,
}

/// `[tracks] calibration`: where delay and phase of each track come from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CalibrationSource {
    /// The campaign file alone.
    #[default]
    Given,
    /// A target that all tracks see, beside what the campaign file gives.
    Target,
}

/// `[image] look_window`: the taper of each look.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LookTaper {
    /// None.
    #[default]
    None,
    /// Hann, over the look's path.
    Hann,
}

/// `[trajectory] unfixed`: what becomes of traces whose position has no fixed solution.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unfixed {
    /// They enter the image, and a warning counts them.
    #[default]
    Keep,
    /// They are left out, and a warning counts them.
    Drop,
}

/// `[checks] contradictions`: what becomes of a run whose evidence contradicts its settings.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Contradictions {
    /// It fails, and writes no products.
    #[default]
    Refuse,
    /// It goes on; every contradiction becomes a warning.
    Warn,
}

/// `[products] formats`: files for other programs, beside those that every run writes.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProductFormat {
    /// `image-db.tif`: levels in dB below the maximum as a cloud-optimised GeoTIFF, with the style `image-db.qml` for QGIS.
    /// Pixels that no trace reaches and those below the floor of `image.png` have no data.
    Geotiff,
    /// `image-absolute-db.tif`: levels in dB of |σ̃|² itself, likewise, without a floor.
    GeotiffAbsolute,
    /// `image-power.tif`: linear powers, likewise.
    GeotiffPower,
    /// `image-complex.tif`: the complex image, likewise.
    GeotiffComplex,
    /// `image.kmz`: the image, the track and the targets for Google Earth.
    Kmz,
    /// `targets.geojson`: targets with their uncertainty; `flight.geojson`: the track, the outline of the image.
    Geojson,
    /// `data.zarr`: image, cleaned radargram, spectra, trajectory and targets as a Zarr v3 group, with
    /// named coordinates and units.
    Zarr,
    /// `data.h5`: the same as NetCDF-4 (HDF5), complex arrays as real and imaginary part.
    Hdf5,
    /// `image.vti`, `volume.vti`: the image and the volume for ParaView.
    Vtk,
    /// `spectra.cphd`: the cleaned spectra with their positions, as phase history data (CPHD) for other
    /// programs; left out where the positions have no place on the Earth.
    Cphd,
}

/// `[image] weight`: the weight of each trace in the sum of Eq. (3).
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// By path where the platform stands much of the time, otherwise one for every trace.
    #[default]
    Auto,
    /// One for every trace: the paper's sum.
    Trace,
    /// The path that the trace covers, in metres, so that hovering does not dominate.
    Path,
}

/// `[image] values`: what the pixels hold.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Values {
    /// The sum of Eq. (3), which grows as 1/R⁴ towards the flight.
    #[default]
    Sum,
    /// The sum divided by that of a point of unit reflectivity: reflectors near and far are equally bright, and noise
    /// is brighter far away.
    Reflectivity,
}

/// `[image] antenna_axis`: where the antenna looks, from which its pattern counts.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AntennaAxis {
    /// Down in the axes of the platform, by the recorded attitude; straight down where none is recorded.
    #[default]
    Attitude,
    /// Straight down whatever the attitude: on a gimbal that keeps it level.
    Vertical,
    /// Down in the axes of a gimbal, by its attitude in the log of the autopilot: an antenna that looks down where
    /// the gimbal's angles are zero.
    Gimbal,
    /// Forward in the axes of a gimbal, by the same: an antenna in the place of a camera, which looks down where the
    /// gimbal's pitch is −90°.
    GimbalForward,
}

impl AntennaAxis {
    /// Whether the antenna looks where a gimbal points.
    #[must_use]
    pub const fn is_gimbal(self) -> bool {
        matches!(self, Self::Gimbal | Self::GimbalForward)
    }

    /// Its name in the campaign.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Attitude => "attitude",
            Self::Vertical => "vertical",
            Self::Gimbal => "gimbal",
            Self::GimbalForward => "gimbal-forward",
        }
    }
}

/// The value of a table's only key.
fn single<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    let table = value.as_table()?;
    if table.len() == 1 {
        table.get(key)
    } else {
        None
    }
}

/// Farthest place (m) from the origin of the frame, more than the Earth's radius.
pub(crate) const FARTHEST_M: f64 = 1e7;
/// Longest time (s) between radar and trajectory clock: GPS time is a tenth of it.
pub(crate) const LONGEST_S: f64 = 1e10;
/// Longest delay (ns): light goes 300 km.
pub(crate) const LONGEST_NS: f64 = 1e6;

/// A number, whole or not, whose magnitude is `most` or less.
fn within(value: &Value, most: f64) -> Option<f64> {
    let number = match value {
        Value::Float(x) => *x,
        #[expect(
            clippy::cast_precision_loss,
            reason = "campaign numbers are far below 2^53"
        )]
        Value::Integer(x) => *x as f64,
        _ => return None,
    };
    (number.abs() <= most).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    struct One<T> {
        key: T,
    }

    fn parse<T: serde::de::DeserializeOwned>(value: &str) -> Result<T, toml::de::Error> {
        toml::from_str::<One<T>>(&format!("key = {value}")).map(|one| one.key)
    }

    #[test]
    fn every_form_of_the_contract_is_read() {
        assert_eq!(parse::<Select>("\"moving\"").unwrap(), Select::Moving);
        assert_eq!(parse::<Select>("[3, 9]").unwrap(), Select::Range([3, 9]));
        assert_eq!(parse::<TimeOffset>("\"auto\"").unwrap(), TimeOffset::Auto);
        assert_eq!(
            parse::<TimeOffset>("-2").unwrap(),
            TimeOffset::Seconds(-2.0)
        );
        assert_eq!(
            parse::<ZeroTiming>("\"first-trace\"").unwrap(),
            ZeroTiming::FirstTrace
        );
        assert_eq!(
            parse::<ZeroTiming>("\"direct-wave\"").unwrap(),
            ZeroTiming::DirectWave
        );
        assert_eq!(
            parse::<ZeroTiming>("{ shift_ns = 1.5 }").unwrap(),
            ZeroTiming::Shift { shift_ns: 1.5 }
        );
        assert_eq!(
            parse::<Background>("{ window = 51 }").unwrap(),
            Background::Window { window: 51 }
        );
        assert_eq!(
            parse::<Background>("{ components = 2 }").unwrap(),
            Background::Components { components: 2 }
        );
        assert_eq!(
            parse::<Gate>("[-6, 24.0]").unwrap(),
            Gate::About([-6.0, 24.0])
        );
        assert_eq!(parse::<Gate>("\"none\"").unwrap(), Gate::None);
        assert_eq!(parse::<Gate>("\"auto\"").unwrap(), Gate::Auto);
        assert_eq!(parse::<Select>("\"auto\"").unwrap(), Select::Auto);
        assert_eq!(parse::<Delay>("\"auto\"").unwrap(), Delay::Auto);
        assert_eq!(parse::<Delay>("12").unwrap(), Delay::Nanoseconds(12.0));
        assert_eq!(parse::<Heights>("-1").unwrap(), Heights::Plane(-1.0));
        assert_eq!(
            parse::<Heights>("[0, 1.5]").unwrap(),
            Heights::Range([0.0, 1.5])
        );
    }

    #[test]
    fn everything_else_is_refused_with_what_was_expected() {
        for wrong in ["\"some\"", "[3]", "[9, 3]", "[-1, 3]", "[0.5, 2]", "true"] {
            let message = parse::<Select>(wrong).unwrap_err().to_string();
            assert!(message.contains("[first, last]"), "{message}");
        }
        assert!(parse::<TimeOffset>("nan").is_err());
        assert!(parse::<Delay>("nan").is_err());
        assert!(parse::<Delay>("'automatic'").is_err());
        for wrong in ["inf", "[0]", "[1, 0]", "[0, 1, 2]", "'low'"] {
            let message = parse::<Heights>(wrong).unwrap_err().to_string();
            assert!(message.contains("[from, to]"), "{message}");
        }
        assert!(parse::<ZeroTiming>("{ shift_ns = inf }").is_err());
        assert!(parse::<ZeroTiming>("{ shift_ns = 1, more = 2 }").is_err());
        assert!(parse::<Background>("{ window = 0 }").is_err());
        assert!(parse::<Background>("{ window = -5 }").is_err());
        assert!(parse::<Gate>("[24, -6]").is_err());
        assert!(parse::<Gate>("[-6, 24, 30]").is_err());
    }
}
