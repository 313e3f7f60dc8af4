//! Positions recorded at some traces, and those of the traces between.

use crate::recording::Positions;

/// A position by satellite at a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// The trace, counted from 0; a fraction between traces.
    pub trace: f64,
    /// Second of the day, where known.
    pub time_of_day_s: Option<f64>,
    /// Latitude and longitude in degrees, height in m.
    pub place: [f64; 3],
}

/// Position and time of every trace, interpolated from fixes, with remarks.
pub struct Tracked {
    pub positions: Positions,
    pub time_s: Option<Vec<f64>>,
    pub remarks: Vec<String>,
}

/// Positions and times of `traces` traces, linear between fixes and beyond the outer ones; none from fewer than two
/// fixes at different traces.
pub fn track(mut fixes: Vec<Fix>, traces: usize) -> Option<Tracked> {
    const DAY_S: f64 = 86_400.0;
    // Numbers that no receiver and no file has would not be interpolated.
    fixes.retain(|f| {
        f.trace.abs() < 1e9
            && f.place.iter().all(|v| v.abs() < 1e6)
            && f.time_of_day_s.is_none_or(|t| (0.0..=DAY_S).contains(&t))
    });
    fixes.sort_by(|a, b| a.trace.total_cmp(&b.trace));
    // Of several fixes at one trace the last holds.
    let mut kept: Vec<Fix> = Vec::with_capacity(fixes.len());
    for fix in fixes {
        match kept.last_mut() {
            Some(last) if last.trace == fix.trace => *last = fix,
            _ => kept.push(fix),
        }
    }
    if kept.len() < 2 || traces == 0 {
        return None;
    }
    let nodes: Vec<f64> = kept.iter().map(|f| f.trace).collect();
    // Longitudes on one side of the date line.
    let first_deg = kept[0].place[1];
    let unwrapped = |deg: f64| first_deg + (deg - first_deg + 180.0).rem_euclid(360.0) - 180.0;
    let axis = |k: usize| -> Vec<f64> {
        let values: Vec<f64> = kept
            .iter()
            .map(|f| {
                if k == 1 {
                    unwrapped(f.place[1])
                } else {
                    f.place[k]
                }
            })
            .collect();
        linear(&nodes, &values, traces)
    };
    let [latitude, longitude, height] = [axis(0), axis(1), axis(2)];
    let places = (0..traces)
        .map(|i| [latitude[i], longitude[i], height[i]])
        .collect();
    let times: Option<Vec<f64>> = kept.iter().map(|f| f.time_of_day_s).collect();
    let time_s = times.map(|mut times| {
        for i in 1..times.len() {
            while times[i] < times[i - 1] - DAY_S / 2.0 {
                times[i] += DAY_S;
            }
        }
        let mut at = linear(&nodes, &times, traces);
        let first = at[0];
        at.iter_mut().for_each(|t| *t -= first);
        at
    });
    let time_s = time_s.filter(|t| t.windows(2).all(|w| w[1] >= w[0]));
    let mut remarks = vec![format!(
        "positions of traces are interpolated between {} fixes",
        kept.len()
    )];
    let last = traces as f64 - 1.0;
    let beyond = (nodes[0].ceil().max(0.0)).min(traces as f64)
        + (last - nodes[nodes.len() - 1].floor()).clamp(0.0, traces as f64);
    if beyond > 0.0 {
        remarks.push(format!(
            "{beyond:.0} traces lie beyond the first or last fix; the motion there is continued"
        ));
    }
    Some(Tracked {
        positions: Positions::Geodetic(places),
        time_s,
        remarks,
    })
}

/// Values at 0, 1, …, n − 1, linear between nodes, continued beyond the outer ones.
pub fn linear(nodes: &[f64], values: &[f64], n: usize) -> Vec<f64> {
    let mut at = 0;
    (0..n)
        .map(|i| {
            let x = i as f64;
            while at + 2 < nodes.len() && nodes[at + 1] < x {
                at += 1;
            }
            let [from, to] = [nodes[at], nodes[at + 1]];
            values[at] + (values[at + 1] - values[at]) * (x - from) / (to - from)
        })
        .collect()
}

/// Time of day and place of an NMEA GGA sentence with a fix; the height above the ellipsoid where the sentence states
/// the geoid's, else above mean sea level.
pub fn gga(line: &str) -> Option<(f64, [f64; 3])> {
    let line = line.trim();
    let body = line.strip_prefix('$')?;
    let (body, sum) = match body.split_once('*') {
        Some((body, sum)) => (body, Some(sum)),
        None => (body, None),
    };
    if let Some(sum) = sum {
        let stated = u8::from_str_radix(sum.trim().get(..2)?, 16).ok()?;
        if body.bytes().fold(0, |a, b| a ^ b) != stated {
            return None;
        }
    }
    let fields: Vec<&str> = body.split(',').collect();
    if fields.len() < 10 || !fields[0].ends_with("GGA") || fields[6].trim() == "0" {
        return None;
    }
    let time = fields[1].trim();
    let hours: f64 = time.get(..2)?.parse().ok()?;
    let minutes: f64 = time.get(2..4)?.parse().ok()?;
    let seconds: f64 = time.get(4..)?.parse().ok()?;
    let angle = |text: &str, side: &str, degrees: usize| -> Option<f64> {
        let text = text.trim();
        let whole: f64 = text.get(..degrees)?.parse().ok()?;
        let minutes: f64 = text.get(degrees..)?.parse().ok()?;
        let deg = whole + minutes / 60.0;
        match side.trim() {
            "N" | "E" => Some(deg),
            "S" | "W" => Some(-deg),
            _ => None,
        }
    };
    let latitude = angle(fields[2], fields[3], 2)?;
    let longitude = angle(fields[4], fields[5], 3)?;
    let above_sea: f64 = fields[9].trim().parse().ok()?;
    let geoid: f64 = fields
        .get(11)
        .and_then(|f| f.trim().parse().ok())
        .unwrap_or(0.0);
    Some((
        hours * 3600.0 + minutes * 60.0 + seconds,
        [latitude, longitude, above_sea + geoid],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_becomes_a_place() {
        let line = "$GPGGA,123519.50,4807.038,N,01131.000,W,4,08,0.9,545.4,M,46.9,M,,";
        let (time, place) = gga(line).unwrap();
        assert!((time - 45_319.5).abs() < 1e-9);
        assert!((place[0] - 48.1173).abs() < 1e-9);
        assert!((place[1] + 11.516_666_667).abs() < 1e-8);
        assert!((place[2] - 592.3).abs() < 1e-9);
        assert!(gga(&format!("{line}*00")).is_none());
        assert!(gga("$GPGGA,,,,,,0,,,,,,,,").is_none());
    }

    #[test]
    fn traces_between_fixes_are_interpolated() {
        let fix = |trace, time, latitude| Fix {
            trace,
            time_of_day_s: Some(time),
            place: [latitude, 179.999_9, 10.0],
        };
        let mut fixes = vec![fix(1.0, 86_399.0, 50.0), fix(5.0, 1.0, 50.4)];
        fixes[1].place[1] = -179.999_9;
        let tracked = track(fixes, 7).unwrap();
        let Positions::Geodetic(places) = tracked.positions else {
            panic!()
        };
        assert!((places[3][0] - 50.2).abs() < 1e-12);
        assert!((places[3][1] - 180.0).abs() < 1e-9);
        assert!((places[6][0] - 50.5).abs() < 1e-12);
        let time_s = tracked.time_s.unwrap();
        assert!((time_s[6] - 3.0).abs() < 1e-9);
        assert!(
            tracked.remarks[1].starts_with("2 traces"),
            "{:?}",
            tracked.remarks
        );
    }
}
