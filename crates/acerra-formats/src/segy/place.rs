//! Places and times of traces from their headers.

use super::trace::TraceHeader;
use crate::recording::Positions;

/// A foot in metres.
pub const FOOT_M: f64 = 0.3048;

/// Data of headers on places.
pub struct Places {
    pub positions: Option<Positions>,
    pub antennas_m: Option<[Vec<[f64; 3]>; 2]>,
    /// Why there are none, though coordinates are there.
    pub refused: Option<String>,
}

/// Places of traces. Coordinates that are 0 in every trace are ignored; the middle of transmitter and
/// receiver is used where both are present and differ, else whichever moves.
pub fn places(headers: &[TraceHeader], is_feet: bool) -> Places {
    let nothing = |refused| Places {
        positions: None,
        antennas_m: None,
        refused,
    };
    let is_there = |of: fn(&TraceHeader) -> [f64; 2]| headers.iter().any(|h| of(h) != [0.0, 0.0]);
    let source: fn(&TraceHeader) -> [f64; 2] = |h| h.source;
    let group: fn(&TraceHeader) -> [f64; 2] = |h| h.group;
    let middle: fn(&TraceHeader) -> [f64; 2] = |h| h.middle;
    let both = is_there(source) && is_there(group);
    let chosen: Vec<[f64; 2]> = if both {
        let mean = |h: &TraceHeader| [0, 1].map(|k| f64::midpoint(h.source[k], h.group[k]));
        headers.iter().map(mean).collect()
    } else if is_there(source) {
        headers.iter().map(source).collect()
    } else if is_there(group) {
        headers.iter().map(group).collect()
    } else if is_there(middle) {
        headers.iter().map(middle).collect()
    } else {
        return nothing(None);
    };
    // Height of the receiver, or of the surface at the source where none of the receiver is given.
    let k = usize::from(headers.iter().all(|h| h.elevation[0] == 0.0));
    let length = if is_feet { FOOT_M } else { 1.0 };
    let height = |h: &TraceHeader| h.elevation[k] * length;
    let units: Vec<i16> = headers.iter().map(|h| h.unit).collect();
    let unit = units[0];
    if units.iter().any(|u| *u != unit) {
        return nothing(Some(
            "the unit of coordinates (bytes 89 and 90 of trace headers) changes".to_owned(),
        ));
    }
    let degrees = |v: f64| match unit {
        2 => v / 3600.0,
        4 => {
            let (whole, rest) = ((v.abs() / 1e4).trunc(), v.abs() % 1e4);
            (whole + (rest / 100.0).trunc() / 60.0 + rest % 100.0 / 3600.0).copysign(v)
        }
        _ => v,
    };
    if matches!(unit, 2..=4) {
        let places: Vec<[f64; 3]> = chosen
            .iter()
            .zip(headers)
            .map(|(p, h)| [degrees(p[1]), degrees(p[0]), height(h)])
            .collect();
        let beyond = places
            .iter()
            .position(|p| p[0].abs() > 90.0 || p[1].abs() > 360.0);
        if let Some(i) = beyond {
            return nothing(Some(format!(
                "coordinates of trace {} would be {:.3}° north, {:.3}° east: their scalar (bytes 71 and 72 of trace \
                 headers) or their unit is not the truth",
                i + 1,
                places[i][0],
                places[i][1]
            )));
        }
        return Places {
            positions: Some(Positions::Geodetic(places)),
            antennas_m: None,
            refused: None,
        };
    }
    let local = |p: [f64; 2], h: &TraceHeader| [p[0] * length, p[1] * length, height(h)];
    let each = |of: fn(&TraceHeader) -> [f64; 2]| -> Vec<[f64; 3]> {
        headers.iter().map(|h| local(of(h), h)).collect()
    };
    let apart = both && headers.iter().any(|h| h.source != h.group);
    Places {
        positions: Some(Positions::Local(
            chosen
                .iter()
                .zip(headers)
                .map(|(p, h)| local(*p, h))
                .collect(),
        )),
        antennas_m: apart.then(|| [each(source), each(group)]),
        refused: None,
    }
}

/// Seconds of traces from the first. Headers stamp whole seconds; traces of one second are spread over it.
pub fn times(headers: &[TraceHeader]) -> Option<Vec<f64>> {
    if headers.iter().all(|h| h.stamp == [0; 5]) {
        return None;
    }
    let first_year = i64::from(headers[0].stamp[0]);
    let second = |h: &TraceHeader| -> i64 {
        let [year, day, hour, minute, second] = h.stamp.map(i64::from);
        // A turn of the year: 365 days, and a 366th where the year before had one.
        let leap =
            i64::from(first_year % 4 == 0 && (first_year % 100 != 0 || first_year % 400 == 0));
        let day = day + (year - first_year) * (365 + leap);
        ((day * 24 + hour) * 60 + minute) * 60 + second
    };
    let seconds: Vec<i64> = headers.iter().map(second).collect();
    if seconds.windows(2).any(|w| w[1] < w[0]) {
        return None;
    }
    // The first trace of each second; the first of all is seldom the first of its second.
    let mut starts = vec![0];
    starts.extend((1..seconds.len()).filter(|&i| seconds[i] > seconds[i - 1]));
    if starts.len() < 3 {
        return None;
    }
    let nodes: Vec<f64> = starts[1..].iter().map(|&i| i as f64).collect();
    let values: Vec<f64> = starts[1..].iter().map(|&i| seconds[i] as f64).collect();
    let mut at = crate::fixes::linear(&nodes, &values, seconds.len());
    let first = at[0];
    at.iter_mut().for_each(|t| *t -= first);
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::Fields;

    fn header(change: impl Fn(&mut [u8])) -> TraceHeader {
        let mut bytes = [0; 240];
        change(&mut bytes);
        TraceHeader::read(Fields::little(&bytes))
    }

    fn put(bytes: &mut [u8], at: usize, value: i32) {
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }

    #[test]
    fn seconds_of_arc_become_degrees_and_a_wrong_scalar_is_refused() {
        let h = header(|b| {
            put(b, 72, 5_148_000); // 51,480.00″ E = 14.3°
            put(b, 76, -14_760_036); // −147,600.36″ = −41.0001°
            b[70..72].copy_from_slice(&(-100i16).to_le_bytes());
            b[88] = 2;
            put(b, 40, 1250);
            b[68..70].copy_from_slice(&(-100i16).to_le_bytes());
        });
        let Some(Positions::Geodetic(p)) = places(&[h], false).positions else {
            panic!("{h:?}")
        };
        assert!((p[0][0] + 41.0001).abs() < 1e-9 && (p[0][1] - 14.3).abs() < 1e-9);
        assert_eq!(p[0][2], 12.5);
        let wrong = header(|b| {
            put(b, 76, 14_760_036);
            b[88] = 2;
        });
        let refused = places(&[wrong], false).refused.unwrap();
        assert!(refused.contains("scalar"), "{refused}");
    }

    #[test]
    fn antennas_apart_have_a_middle() {
        let h = header(|b| {
            put(b, 72, 100);
            put(b, 80, 110);
            b[88] = 1;
        });
        let found = places(&[h], true);
        let Some(Positions::Local(p)) = found.positions else {
            panic!()
        };
        assert!((p[0][0] - 105.0 * FOOT_M).abs() < 1e-12);
        let [t, r] = found.antennas_m.unwrap();
        assert!((r[0][0] - t[0][0] - 10.0 * FOOT_M).abs() < 1e-12);
    }

    #[test]
    fn whole_seconds_are_spread() {
        // 10 traces a second from the middle of a second on.
        let headers: Vec<TraceHeader> = (0..40u16)
            .map(|i| {
                header(|b| {
                    b[156..158].copy_from_slice(&2024u16.to_le_bytes());
                    b[158..160].copy_from_slice(&100u16.to_le_bytes());
                    b[164..166].copy_from_slice(&((i + 5) / 10).to_le_bytes());
                })
            })
            .collect();
        let t = times(&headers).unwrap();
        for (i, t) in t.iter().enumerate() {
            assert!((t - 0.1 * i as f64).abs() < 1e-9, "{i}: {t}");
        }
    }
}
