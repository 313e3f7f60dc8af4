//! Which receiver flew, which was at rest, and their places.

use acerra_geo::geodesy::{EnuFrame, geodetic_from_ecef};
use anyhow::{bail, ensure};

use super::logs::Logs;
use super::receivers::{Place, SinglePoint, is_same};

/// Rover and base, with the evidence.
#[derive(Debug)]
pub(super) struct Pair<'a> {
    pub rover: Place<'a>,
    pub base: Place<'a>,
    /// Why this one is the rover.
    pub reason: String,
    /// Logs that are not used, and why.
    pub unused: Vec<String>,
}

/// Least ratio of the spread of a moving receiver to that of a receiver at rest …
const SPREAD_RATIO: f64 = 3.0;
/// … and least spread (m): single-point positions of a receiver at rest wander less.
const LEAST_SPREAD_M: f64 = 5.0;
/// It is also faster than this (m/s), by Doppler.
const LEAST_SPEED_M_S: f64 = 0.5;

/// Distinguishes rover and base; none without a receiver's log.
///
/// # Errors
/// A single receiver; two that share no time.
pub(super) fn pair(logs: &Logs) -> anyhow::Result<Option<Pair<'_>>> {
    let mut unused = Vec::new();
    let mut distinct: Vec<usize> = Vec::new();
    for (k, receiver) in logs.receiver.iter().enumerate() {
        let twin = distinct
            .iter()
            .find(|i| is_same(&logs.receiver[**i].observations, &receiver.observations));
        match twin {
            Some(i) => unused.push(format!(
                "{} holds the same measurements as {}",
                receiver.path.display(),
                logs.receiver[*i].path.display()
            )),
            None => distinct.push(k),
        }
    }
    let mut places: Vec<Place<'_>> = distinct
        .into_iter()
        .filter_map(|k| Place::of(&logs.receiver[k], &logs.navigation))
        .collect();
    match places.as_slice() {
        [] => return Ok(None),
        [one] => bail!(
            "{}: the only log of a GNSS receiver; positions by carrier phase need a second one at rest \
             nearby (or give a trajectory)",
            one.path.display()
        ),
        _ => {}
    }
    let (rover, reason) = tell_rover(&places);
    let rover = places.remove(rover);
    let base = best(&places, |place| place.overlap_s(&rover));
    let base = places.remove(base);
    unused.extend(
        places
            .iter()
            .map(|p| format!("{} is a third receiver's", p.path.display())),
    );
    ensure!(
        rover.overlap_s(&base) > 0.0,
        "{} and {} share no time: {} to {} against {} to {}",
        rover.path.display(),
        base.path.display(),
        rover.span[0],
        rover.span[1],
        base.span[0],
        base.span[1]
    );
    Ok(Some(Pair {
        rover,
        base,
        reason,
        unused,
    }))
}

/// Which of several receivers flew, with the evidence.
fn tell_rover(places: &[Place<'_>]) -> (usize, String) {
    let spread = |p: &Place<'_>| p.single.map_or(0.0, |s| s.spread_m);
    let speed = |p: &Place<'_>| p.single.and_then(|s| s.speed_m_s).unwrap_or(0.0);
    for (name, unit, least, of) in [
        (
            "positions spread over",
            "m",
            LEAST_SPREAD_M,
            &spread as &dyn Fn(&Place<'_>) -> f64,
        ),
        ("speeds reach", "m/s", LEAST_SPEED_M_S, &speed),
    ] {
        let k = best(places, of);
        let most = of(&places[k]);
        let others = places.iter().enumerate().filter(|(i, _)| *i != k);
        let next = others.map(|(_, p)| of(p)).fold(0.0, f64::max);
        if most >= least && most >= SPREAD_RATIO * next {
            let reason = format!(
                "its single-point {name} {most:.1} {unit}, those of the base over {next:.1} {unit}"
            );
            return (k, reason);
        }
    }
    let is_named = |p: &Place<'_>, word: &str| {
        let name = p.path.file_name().unwrap_or_default().to_string_lossy();
        name.to_lowercase().contains(word)
    };
    for (k, place) in places.iter().enumerate() {
        let others_are_bases = || {
            let mut others = places.iter().enumerate().filter(|(i, _)| *i != k);
            others.all(|(_, p)| is_named(p, "base"))
        };
        if is_named(place, "rover") || others_are_bases() {
            let reason = "by the names of the files alone, as neither is seen to move: check it";
            return (k, reason.to_owned());
        }
    }
    let shortest = best(places, |p| p.span[0] - p.span[1]);
    let reason = "its log is the shorter one; neither is seen to move nor named: check it";
    (shortest, reason.to_owned())
}

/// The place with the greatest value; the first of equal ones.
fn best(places: &[Place<'_>], value: impl Fn(&Place<'_>) -> f64) -> usize {
    let mut best = 0;
    for (k, place) in places.iter().enumerate() {
        if value(place) > value(&places[best]) {
            best = k;
        }
    }
    best
}

impl Pair<'_> {
    /// The base's place as its single-point positions have it: latitude and longitude (degrees) and
    /// ellipsoidal height (m).
    pub(super) fn base_deg_m(&self) -> Option<[f64; 3]> {
        self.base.single.map(|s| degrees(s.middle_ecef_m))
    }

    /// Source and accuracy of the base's place, in words.
    pub(super) fn says_base(&self) -> String {
        let text = |ecef_m: [f64; 3]| {
            let [latitude, longitude, height] = degrees(ecef_m);
            format!("{latitude:.8}°, {longitude:.8}°, {height:.2} m")
        };
        match (self.base.header_ecef_m, self.base.single) {
            (Some(header), Some(single)) => format!(
                "the log's header states {}, {:.1} m from the median of {} single-point positions",
                text(header),
                distance_m(header, single.middle_ecef_m),
                single.count
            ),
            (Some(header), None) => format!("the log's header states {}", text(header)),
            (None, Some(single)) => format!(
                "not in the log; this is the median of its {} single-point positions, some metres off: all \
                 positions shift with it, the image's sharpness does not change",
                single.count
            ),
            (None, None) => "not in the log, and no navigation data to compute it".to_owned(),
        }
    }

    /// The rover's horizontal path about the base, by single-point positions: lowest and highest
    /// east and north (m).
    pub(super) fn rover_bounds_m(&self) -> Option<[[f64; 3]; 2]> {
        let single: SinglePoint = self.rover.single?;
        let base_ecef_m = self
            .base
            .header_ecef_m
            .or(self.base.single.map(|s| s.middle_ecef_m))?;
        let middle = EnuFrame::from_ecef(base_ecef_m).enu_from_ecef(single.middle_ecef_m);
        Some(
            single
                .bounds_m
                .map(|end| [0, 1, 2].map(|k| middle[k] + end[k])),
        )
    }
}

fn degrees(ecef_m: [f64; 3]) -> [f64; 3] {
    let place = geodetic_from_ecef(ecef_m);
    [place.latitude_deg(), place.longitude_deg(), place.height_m]
}

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    [0, 1, 2]
        .map(|k| (a[k] - b[k]).powi(2))
        .iter()
        .sum::<f64>()
        .sqrt()
}
