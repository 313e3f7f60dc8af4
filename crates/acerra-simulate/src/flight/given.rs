//! A flight that was flown or planned elsewhere: positions from a file.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use acerra_geo::geodesy::Geodetic;
use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_geo::trajectory::{Attitude, Trajectory};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::path::{Flight, Pose, STEP_S};

/// `[trajectory]` of a scene file: the flight as a file has it (CSV, RTKLIB's `.pos`, NMEA, an
/// OptiTrack export), instead of `[flight]`.
///
/// The file gives the true positions of the positioned point. Local ones (CSV with x, y, z) are
/// taken as they are, geographic ones about the scene's origin. Where the file has no attitude the
/// craft stays level and looks where it flies.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GivenFlight {
    /// The file; relative paths are relative to the scene file.
    pub file: PathBuf,
    /// The part that counts as the track: seconds after the first position. By default all of it.
    #[serde(default)]
    pub on_track_s: Option<[f64; 2]>,
}

/// Reason why a given flight is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GivenFlightError {
    /// A file that cannot be opened or read.
    #[error("[trajectory] file: {}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Defect found.
        reason: String,
    },
    /// Positions that no flight can have.
    #[error("[trajectory] file: expected {expected}, found {found} s after its first position")]
    Positions {
        /// What a flight needs.
        expected: &'static str,
        /// Where it fails, seconds after the first position.
        found: f64,
    },
    /// A track outside the flight.
    #[error(
        "[trajectory] on_track_s: expected rising times from 0 to {duration_s:.3} s, found {found:?}"
    )]
    OnTrack {
        /// How long the file is.
        duration_s: f64,
        /// Request.
        found: [f64; 2],
    },
}

impl GivenFlight {
    /// Reads the file.
    ///
    /// # Errors
    /// A file that cannot be read, positions that no flight can have, a track outside them.
    pub fn fly(&self, origin: Geodetic) -> Result<Flight, GivenFlightError> {
        let trajectory = read(&self.file, origin).map_err(|reason| GivenFlightError::File {
            file: self.file.clone(),
            reason,
        })?;
        Flight::along(&trajectory, self.on_track_s)
    }
}

fn read(path: &Path, origin: Geodetic) -> Result<Trajectory, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let options = ReadOptions::default().with_origin(origin);
    let (trajectory, _) =
        read_trajectory(BufReader::new(file), &options).map_err(|error| error.to_string())?;
    Ok(trajectory)
}

/// Longest flight (s): a day.
const LONGEST_S: f64 = 86_400.0;
/// Slower than this (m/s) the craft keeps the heading that it has.
const SLOW_M_S: f64 = 0.3;

impl Flight {
    /// The flight along `trajectory`, starting at its first position; `on_track_s` is the part that
    /// counts as the track, in seconds from there.
    ///
    /// # Errors
    /// Fewer than two positions, gaps, a flight longer than a day, a track outside the flight or
    /// not above the ground.
    ///
    /// ```
    /// use acerra_simulate::flight::Flight;
    /// use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
    /// let fixes = (0..50).map(|k| Fix::new(0.2 * f64::from(k), [0.3 * f64::from(k), 0.0, 5.0]));
    /// let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect())?;
    /// let flight = Flight::along(&trajectory, Some([2.0, 8.0]))?;
    /// assert!((flight.pose_at(4.0).position_m[0] - 6.0).abs() < 1e-6);
    /// // Eastwards, so the left wing points north.
    /// assert!(flight.pose_at(4.0).attitude.rotate([0.0, 1.0, 0.0])[1] > 0.999);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn along(
        trajectory: &Trajectory,
        on_track_s: Option<[f64; 2]>,
    ) -> Result<Self, GivenFlightError> {
        let start_s = trajectory.start_s();
        let duration_s = trajectory.end_s() - start_s;
        let wrong = |expected, found| GivenFlightError::Positions { expected, found };
        if !(duration_s > 4.0 * STEP_S && duration_s <= LONGEST_S) {
            return Err(wrong("positions over a moment to a day", duration_s));
        }
        let on_track_s = on_track_s.unwrap_or([0.0, duration_s]);
        let [from_s, to_s] = on_track_s;
        if !(from_s >= 0.0 && from_s < to_s && to_s <= duration_s + 1e-6) {
            return Err(GivenFlightError::OnTrack {
                duration_s,
                found: on_track_s,
            });
        }
        let at = Interpolator::new(trajectory, &InterpolationOptions::default());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most a day of steps"
        )]
        let count = (duration_s / STEP_S) as usize + 1;
        let mut heading = Attitude::from_heading(0.0);
        let mut headless = true;
        let mut poses = Vec::with_capacity(count);
        for k in 0..count {
            #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
            let time_s = k as f64 * STEP_S;
            let place = at.at(start_s + time_s);
            if place.flag == Flag::InGap {
                return Err(wrong("no gap between positions", time_s));
            }
            if place.position_m[2] <= 0.0 && (from_s..=to_s).contains(&time_s) {
                return Err(wrong("heights above the ground, z = 0", time_s));
            }
            let [east, north, _] = place.velocity_m_s;
            if east.hypot(north) >= SLOW_M_S {
                heading = Attitude::from_heading(east.atan2(north));
                if headless {
                    // The direction before the first motion is unknown: forward along the later path.
                    poses
                        .iter_mut()
                        .for_each(|p: &mut Pose| p.attitude = heading);
                    headless = false;
                }
            }
            poses.push(Pose {
                time_s,
                position_m: place.position_m,
                attitude: place.attitude.unwrap_or(heading),
            });
        }
        Ok(Self::of(poses, on_track_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(name: &str, text: &str) -> Result<Flight, GivenFlightError> {
        let here = tempfile::tempdir().unwrap();
        let file = here.path().join(name);
        std::fs::write(&file, text).unwrap();
        let given = GivenFlight {
            file,
            on_track_s: None,
        };
        given.fly(Geodetic::from_degrees(41.0, 14.0, 50.0))
    }

    fn csv(rows: &[[f64; 4]]) -> String {
        let mut text = "time_s,x_m,y_m,z_m\n".to_owned();
        for [t, x, y, z] in rows {
            text += &format!("{t},{x},{y},{z}\n");
        }
        text
    }

    #[test]
    fn local_and_geographic_files_are_flown() {
        let rows: Vec<[f64; 4]> = (0..60)
            .map(|k| 0.2 * f64::from(k))
            .map(|t| [100.0 + t, 1.5 * t, 2.0, 6.0 + 0.1 * t])
            .collect();
        let flight = read_text("flown.csv", &csv(&rows)).unwrap();
        let place = flight.pose_at(3.0).position_m;
        assert!((place[0] - 4.5).abs() < 1e-6 && (place[2] - 6.3).abs() < 1e-6);
        assert!((flight.on_track_s[1] - 11.8).abs() < 1e-9);

        let mut pos = "%  GPST          latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio\n".to_owned();
        for k in 0..40 {
            let s = 0.25 * f64::from(k);
            pos += &format!(
                "2019/10/15 09:30:{s:06.3}   41.000000000   {:.9}   60.0000   1   8   0.0050   0.0050   0.0100   0.0000   0.0000   0.0000   0.00   20.0\n",
                14.0 + 1e-5 * s
            );
        }
        let flight = read_text("flown.pos", &pos).unwrap();
        let place = flight.pose_at(4.0).position_m;
        // 1e-5° of longitude at 41° are 0.842 m; the origin lies 10 m lower.
        assert!((place[0] - 4.0 * 0.842).abs() < 0.01, "{place:?}");
        assert!((place[2] - 10.0).abs() < 1e-3);
    }

    #[test]
    fn what_cannot_be_flown_is_refused() {
        let line = |n: i32, dt: f64, z: f64| -> Vec<[f64; 4]> {
            (0..n)
                .map(|k| [dt * f64::from(k), f64::from(k), 0.0, z])
                .collect()
        };
        let said = |text: &str| read_text("f.csv", text).unwrap_err().to_string();
        assert!(said("not a trajectory\n").contains("f.csv"));
        assert!(said(&csv(&line(20, 0.2, -1.0))).contains("above the ground"));
        let mut broken = line(20, 0.2, 5.0);
        broken.iter_mut().skip(10).for_each(|row| row[0] += 60.0);
        assert!(said(&csv(&broken)).contains("no gap"));
        let missing = GivenFlight {
            file: "/no/such/flight.csv".into(),
            on_track_s: None,
        };
        let origin = Geodetic::from_degrees(41.0, 14.0, 50.0);
        let error = missing.fly(origin).unwrap_err().to_string();
        assert!(error.contains("/no/such/flight.csv"), "{error}");
    }
}
