//! From the options to a flight, targets and a grid that make sense together.

use std::f64::consts::FRAC_PI_2;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use acerra_chain::position::trajectory_file::{TrajectoryFileOptions, read_trajectory_file};
use acerra_imaging::PlaneGrid;
use acerra_imaging::psf::{PointSpread, TrackShape, synthetic_track};
use acerra_imaging::resolution::{longest_step_m, unambiguous_range_m};
use anyhow::{Context, bail, ensure};

use super::args::Args;

/// All that the point spread function needs.
pub(super) struct Scene {
    pub spread: PointSpread,
    pub target_m: Vec<[f64; 3]>,
    pub grid: PlaneGrid,
    /// The flight that the spread was made from.
    pub flight: Flight,
    /// Remarks for the user that are no errors.
    pub notes: Vec<String>,
}

/// The pulses of a flight, with data of the file on them.
pub(super) struct Flight {
    pub position_m: Vec<[f64; 3]>,
    /// Time of each pulse, s; of recorded flights.
    pub time_s: Option<Vec<f64>>,
    /// Standard deviations of each position, m; where the file states all of them.
    pub sigma_m: Option<Vec<[f64; 3]>>,
}

/// Paper's examples (§3.2).
const HALF_LENGTH_M: f64 = 3.0;
const STEP_M: f64 = 0.01;

impl Scene {
    pub fn of(args: &Args) -> anyhow::Result<Self> {
        let mut notes = vec![];
        let target_m = match (args.target, args.offset, &args.targets) {
            (Some(point), ..) => vec![point],
            (_, Some(offset), _) => vec![[0.0, offset, 0.0]],
            (.., Some(file)) => super::targets::read(file)?,
            _ => bail!("one of --offset, --target and --targets is needed"),
        };
        let flight = match &args.trajectory {
            Some(file) => recorded(file, args.step_m, &mut notes)?,
            None => Flight {
                position_m: synthetic_track(
                    args.track.unwrap_or(TrackShape::Straight),
                    args.half_length_m.unwrap_or(HALF_LENGTH_M),
                    args.step_m.unwrap_or(STEP_M),
                    args.height
                        .context("--height is needed without --trajectory")?,
                )?,
                time_s: None,
                sigma_m: None,
            },
        };
        let position_m = flight.position_m.clone();
        let plane_z_m = args.plane_z.unwrap_or(match target_m[..] {
            [only] if args.targets.is_none() => only[2],
            _ => 0.0,
        });
        let lowest = position_m
            .iter()
            .map(|p| p[2])
            .fold(f64::INFINITY, f64::min);
        for t in &target_m {
            ensure!(
                t[2] < lowest,
                "the target at z = {} m is not below the drone, which flies down to z = {lowest} m",
                t[2]
            );
        }
        ensure!(
            plane_z_m < lowest,
            "the image plane at z = {plane_z_m} m is not below the drone, which flies down to z = \
             {lowest} m"
        );

        let (low_hz, high_hz) = args.band_ghz;
        let step_hz = (high_hz - low_hz) / f64::from(args.frequencies - 1);
        let frequency_hz = (0..args.frequencies)
            .map(|n| low_hz + step_hz * f64::from(n))
            .collect();
        let spread = PointSpread::new(position_m, None, frequency_hz, args.light_speed)?;
        let grid = grid(args, &target_m, plane_z_m)?;
        check_pulses(&spread, &target_m, args, &mut notes)?;
        check_frequencies(&spread, &target_m, &grid, step_hz)?;
        Ok(Self {
            spread,
            target_m,
            grid,
            flight,
            notes,
        })
    }
}

/// The pulses of a recorded flight: its own positions, or one every `step_m` of its path.
fn recorded(file: &Path, step_m: Option<f64>, notes: &mut Vec<String>) -> anyhow::Result<Flight> {
    let place = || file.display().to_string();
    let reader = BufReader::new(File::open(file).with_context(place)?);
    let file =
        read_trajectory_file(reader, &TrajectoryFileOptions::default()).with_context(place)?;
    notes.extend(file.skipped().map(|what| format!("{}: {what}", place())));
    let fixes = file.trajectory.fixes();
    let flight = Flight {
        position_m: fixes.iter().map(|f| f.position_m).collect(),
        time_s: Some(fixes.iter().map(|f| f.time_s).collect()),
        sigma_m: fixes.iter().map(|f| f.standard_deviation_m()).collect(),
    };
    match step_m {
        None => Ok(flight),
        Some(step_m) => along_path(&flight, step_m).with_context(place),
    }
}

/// Pulses every `step_m` along the polyline through the positions of `flight`; times and standard
/// deviations are interpolated with them.
fn along_path(flight: &Flight, step_m: f64) -> anyhow::Result<Flight> {
    const MOST: f64 = 1e7;
    let position_m = &flight.position_m;
    let length = |a: &[f64; 3], b: &[f64; 3]| -> f64 {
        (0..3).map(|i| (b[i] - a[i]).powi(2)).sum::<f64>().sqrt()
    };
    let total_m: f64 = position_m.windows(2).map(|p| length(&p[0], &p[1])).sum();
    ensure!(
        total_m / step_m < MOST,
        "a step of {step_m} m along {total_m:.1} m makes more than 10 million pulses"
    );
    // Leg and fraction of the leg for every pulse.
    let mut stops = vec![];
    let (mut next_m, mut passed_m) = (0.0, 0.0);
    for (leg, pair) in position_m.windows(2).enumerate() {
        let leg_m = length(&pair[0], &pair[1]);
        while next_m <= passed_m + leg_m && leg_m > 0.0 {
            stops.push((leg, (next_m - passed_m) / leg_m));
            next_m += step_m;
        }
        passed_m += leg_m;
    }
    ensure!(
        !stops.is_empty(),
        "the trajectory does not move: there is no path to sample"
    );
    let between = |a: f64, b: f64, t: f64| a + t * (b - a);
    let at = |values: &[[f64; 3]]| -> Vec<[f64; 3]> {
        stops
            .iter()
            .map(|(leg, t)| [0, 1, 2].map(|i| between(values[*leg][i], values[leg + 1][i], *t)))
            .collect()
    };
    Ok(Flight {
        position_m: at(position_m),
        time_s: flight.time_s.as_ref().map(|v| {
            stops
                .iter()
                .map(|(leg, t)| between(v[*leg], v[leg + 1], *t))
                .collect()
        }),
        sigma_m: flight.sigma_m.as_deref().map(at),
    })
}

fn grid(args: &Args, target_m: &[[f64; 3]], plane_z_m: f64) -> anyhow::Result<PlaneGrid> {
    let over = |axis: usize| {
        // The paper's examples show [−3, 3]² m about the middle of the track, not the target.
        let (low, high) = if args.trajectory.is_none() {
            (0.0, 0.0)
        } else {
            target_m
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| {
                    (l.min(t[axis]), h.max(t[axis]))
                })
        };
        [low - args.half_width_m, high + args.half_width_m]
    };
    // A few GiB: more than any picture needs.
    const MOST_BYTES: u128 = 4 << 30;
    let grid = PlaneGrid::from_ranges(over(0), over(1), plane_z_m, args.pixel_m)?;
    grid.check_limit(MOST_BYTES)?;
    Ok(grid)
}

/// Pulses too far apart cause grating lobes: refused for a requested step, noted for a recorded flight.
///
/// The phase of an echo may turn by at most π from pulse to pulse, so the range to the target may
/// change by at most a quarter of the shortest wavelength: the step of Eq. (6) with sin θ in it,
/// whatever the shape of the track.
fn check_pulses(
    spread: &PointSpread,
    target_m: &[[f64; 3]],
    args: &Args,
    notes: &mut Vec<String>,
) -> anyhow::Result<()> {
    let quarter_m = longest_step_m(spread.band_hz().1, FRAC_PI_2, spread.light_speed_m_s())?;
    for t in target_m {
        let range =
            |p: &[f64; 3]| -> f64 { (0..3).map(|i| (p[i] - t[i]).powi(2)).sum::<f64>().sqrt() };
        let change_m = spread
            .position_m()
            .windows(2)
            .map(|p| (range(&p[1]) - range(&p[0])).abs())
            .fold(0.0, f64::max);
        if change_m <= quarter_m {
            continue;
        }
        let message = format!(
            "the pulses are too far apart and alias: the range to the target at ({}, {}, {}) m \
             changes by up to {change_m:.4} m between neighbours, more than a quarter of the \
             shortest wavelength, {quarter_m:.4} m",
            t[0], t[1], t[2]
        );
        match (args.trajectory.is_some(), args.step_m) {
            (true, None) => {
                notes.push(format!(
                    "{message}; --step-m samples the recorded path finer"
                ));
                return Ok(());
            }
            (_, step_m) => {
                let step_m = step_m.unwrap_or(STEP_M);
                bail!(
                    "{message}: --step-m at most {:.4}",
                    step_m * quarter_m / change_m
                );
            }
        }
    }
    Ok(())
}

/// Frequencies too far apart fold distant echoes onto the image.
fn check_frequencies(
    spread: &PointSpread,
    target_m: &[[f64; 3]],
    grid: &PlaneGrid,
    step_hz: f64,
) -> anyhow::Result<()> {
    let unambiguous_m = unambiguous_range_m(step_hz, spread.light_speed_m_s())?;
    let (x, y) = (grid.x_m(grid.nx - 1), grid.y_m(grid.ny - 1));
    let corners = [
        [grid.x0_m, grid.y0_m],
        [x, grid.y0_m],
        [grid.x0_m, y],
        [x, y],
    ];
    let range = |p: &[f64; 3], q: [f64; 3]| -> f64 {
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    };
    let mut excess_m = 0.0_f64;
    for p in spread.position_m() {
        let farthest = corners
            .iter()
            .map(|c| range(p, [c[0], c[1], grid.z_m]))
            .fold(0.0, f64::max);
        let nearest = p[2] - grid.z_m;
        for t in target_m {
            let own = range(p, *t);
            excess_m = excess_m.max(farthest - own).max(own - nearest);
        }
    }
    ensure!(
        excess_m < unambiguous_m,
        "{} frequencies over the band are {:.3} MHz apart and repeat every {unambiguous_m:.2} m of \
         range, but the image spans {excess_m:.2} m about its targets: more --frequencies or a \
         smaller --half-width-m",
        spread.frequency_hz().len(),
        step_hz / 1e6
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_sampled_evenly_around_corners() {
        let position_m = vec![
            [0.0, 0.0, 5.0],
            [0.0, 0.0, 5.0],
            [1.0, 0.0, 5.0],
            [1.0, 0.75, 5.0],
        ];
        let flight = Flight {
            position_m,
            time_s: Some(vec![0.0, 1.0, 3.0, 6.0]),
            sigma_m: Some(vec![[0.01; 3], [0.01; 3], [0.03; 3], [0.03; 3]]),
        };
        let found = along_path(&flight, 0.5).unwrap();
        assert_eq!(found.position_m.len(), 4);
        assert_eq!(found.position_m[2], [1.0, 0.0, 5.0]);
        assert_eq!(found.position_m[3], [1.0, 0.5, 5.0]);
        assert_eq!(found.time_s.unwrap(), [1.0, 2.0, 3.0, 5.0]);
        assert!((found.sigma_m.unwrap()[1][2] - 0.02).abs() < 1e-12);
        assert!(along_path(&flight, 1e-9).is_err());
        let hover = Flight {
            position_m: vec![[0.0; 3]; 2],
            time_s: None,
            sigma_m: None,
        };
        assert!(along_path(&hover, 0.5).is_err());
    }
}
