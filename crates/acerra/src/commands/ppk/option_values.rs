//! Values of the options of `acerra ppk`: names, times, places and satellite systems.

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::pos::PosFrame;
use acerra_gnss::{BasePosition, FilterDirection, System, SystemSet};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parser of an option with named values.
pub(super) fn named<T>(
    values: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T>
where
    T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>
        + Copy
        + Send
        + Sync
        + 'static,
{
    described(
        values
            .iter()
            .map(|v| PossibleValue::new(name(*v)))
            .collect(),
    )
}

fn described<T>(values: Vec<PossibleValue>) -> impl TypedValueParser<Value = T>
where
    T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>
        + Clone
        + Send
        + Sync
        + 'static,
{
    PossibleValuesParser::new(values).try_map(|name: String| name.parse::<T>())
}

pub(super) fn directions() -> impl TypedValueParser<Value = FilterDirection> {
    described(
        FilterDirection::ALL
            .iter()
            .map(|direction| {
                let value = PossibleValue::new(direction.name());
                match direction {
            FilterDirection::CombinedWithoutReset => value
                .help("Combined, the backward pass starting from what the forward pass ended with"),
            _ => value,
        }
            })
            .collect(),
    )
}

pub(super) fn frames() -> impl TypedValueParser<Value = PosFrame> {
    described(
        PosFrame::ALL
            .iter()
            .map(|frame| {
                PossibleValue::new(frame.name()).help(match frame {
                    PosFrame::Geodetic => "Latitude, longitude, ellipsoidal height",
                    PosFrame::Ecef => "Earth-centred, Earth-fixed",
                    PosFrame::EnuBaseline => "East, north, up from the base",
                })
            })
            .collect(),
    )
}

pub(super) fn base_position(text: &str) -> Result<BasePosition, String> {
    const EXPECTED: &str = "expected header, average, llh:LAT,LON,HEIGHT or xyz:X,Y,Z";
    match text {
        "header" => return Ok(BasePosition::Header),
        "average" => return Ok(BasePosition::AverageSingle),
        _ => {}
    }
    let (kind, numbers) = text.split_once(':').ok_or(EXPECTED)?;
    let mut values = [0.0; 3];
    let mut parts = numbers.split(',');
    for value in &mut values {
        *value = parts
            .next()
            .and_then(|part| part.trim().parse().ok())
            .filter(|v: &f64| v.is_finite())
            .ok_or(EXPECTED)?;
    }
    let [a, b, c] = values;
    match (kind, parts.next()) {
        ("xyz", None) => Ok(BasePosition::Ecef(values)),
        ("llh", None) if a.abs() <= 90.0 && b.abs() <= 360.0 => Ok(BasePosition::Ecef(
            ecef_from_geodetic(&Geodetic::from_degrees(a, b, c)),
        )),
        ("llh", None) => Err("latitude beyond ±90° or longitude beyond ±360°".to_owned()),
        _ => Err(EXPECTED.to_owned()),
    }
}

pub(super) fn systems(text: &str) -> Result<SystemSet, String> {
    let found: Option<SystemSet> = text.chars().map(System::from_letter).collect();
    found
        .filter(|set| !set.is_empty())
        .ok_or_else(|| "expected letters of G, R, E, C, J, I, S".to_owned())
}

/// A time as `2018-10-09T12:30:00.5`, GPS time or, with a `Z`, UTC.
pub(super) fn time(text: &str) -> Result<GpsTime, String> {
    const EXPECTED: &str = "expected a time as 2018-10-09T12:30:00 (GPS time), or with a Z (UTC)";
    let (body, utc) = text
        .strip_suffix('Z')
        .map_or((text, false), |body| (body, true));
    let (date, clock) = body.split_once(['T', ' ']).ok_or(EXPECTED)?;
    let date: Vec<&str> = date.split(['-', '/']).collect();
    let clock: Vec<&str> = clock.split(':').collect();
    let ([year, month, day], [hour, minute, second]) = (&date[..], &clock[..]) else {
        return Err(EXPECTED.to_owned());
    };
    let whole = |part: &str| part.parse::<u8>().map_err(|_| EXPECTED.to_owned());
    let year = year.parse().map_err(|_| EXPECTED.to_owned())?;
    let second: f64 = second.parse().map_err(|_| EXPECTED.to_owned())?;
    let calendar = Calendar::new(
        year,
        whole(month)?,
        whole(day)?,
        whole(hour)?,
        whole(minute)?,
        second,
    )
    .map_err(|e| format!("{EXPECTED}: {e}"))?;
    if utc {
        GpsTime::from_utc(&calendar).map_err(|e| e.to_string())
    } else {
        Ok(GpsTime::from_calendar(&calendar))
    }
}

pub(super) fn elevation_deg(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|deg| (0.0..90.0).contains(deg))
        .ok_or_else(|| "expected degrees from 0 to below 90".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        let t = |text| time(text).unwrap();
        assert_eq!(t("2018-10-09T12:30:00"), t("2018/10/09 12:30:00.0"));
        assert!((t("2018-10-09T12:30:00Z") - t("2018-10-09T12:30:00.5") - 17.5).abs() < 1e-9);
        for bad in [
            "",
            "12:30:00",
            "2018-10-09",
            "2018-13-09T12:30:00",
            "2018-10-09T12:30",
            "2018-10-09T12:30:x",
        ] {
            assert!(time(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn base_positions() {
        assert_eq!(base_position("header"), Ok(BasePosition::Header));
        assert_eq!(base_position("average"), Ok(BasePosition::AverageSingle));
        assert_eq!(
            base_position("xyz:1,-2,3.5"),
            Ok(BasePosition::Ecef([1.0, -2.0, 3.5]))
        );
        let Ok(BasePosition::Ecef(p)) = base_position("llh:35,140,100") else {
            panic!()
        };
        assert!((p[0] + 4_006_802.166_763).abs() < 1e-6);
        for bad in [
            "",
            "llh:1,2",
            "xyz:1,2,3,4",
            "llh:95,0,0",
            "abc:1,2,3",
            "xyz:nan,0,0",
        ] {
            assert!(base_position(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn system_letters() {
        assert_eq!(systems("GR"), Ok(SystemSet::GPS.with(System::Glonass)));
        assert!(systems("").is_err() && systems("GX").is_err());
    }
}
