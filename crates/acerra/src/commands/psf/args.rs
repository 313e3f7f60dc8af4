//! Arguments of `acerra psf`.

use std::path::PathBuf;

use acerra_imaging::SPEED_OF_LIGHT_M_S;
use acerra_imaging::psf::TrackShape;
use clap::ArgGroup;

use crate::commands::values::{band_ghz, not_negative, number, point_m, positive};

/// Show how a flight images a point (Eqs. 4 and 5): resolution, sidelobes and ghost.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra psf --height 10 --offset 2
  acerra psf --height 10 --offset 2 --track cosine:0.15:24 -o psf
  acerra psf --trajectory flight.pos --target 4,0,0 --json")]
#[command(group(ArgGroup::new("flight").required(true).args(["height", "trajectory"])))]
#[command(group(ArgGroup::new("what").required(true).args(["offset", "target", "targets"])))]
pub struct Args {
    /// Height of a synthetic flight along x above z = 0, m.
    #[arg(long, value_name = "H", value_parser = positive, allow_negative_numbers = true)]
    pub(super) height: Option<f64>,
    /// Offset of the target from the line y = 0: the target is at (0, D, 0) m.
    #[arg(long, value_name = "D", value_parser = number, allow_negative_numbers = true)]
    pub(super) offset: Option<f64>,
    /// Shape of the synthetic flight: straight, or cosine:AMPLITUDE_M:PERIOD_M (Eq. 13 is
    /// cosine:0.15:24).
    #[arg(long, value_name = "SHAPE", value_parser = shape, conflicts_with = "trajectory")]
    pub(super) track: Option<TrackShape>,
    /// Half-length of the synthetic flight, m [default: 3].
    #[arg(long, value_name = "L", value_parser = positive, conflicts_with = "trajectory")]
    pub(super) half_length_m: Option<f64>,
    /// Distance between pulses, m [default: 0.01; a recorded flight's own positions].
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(super) step_m: Option<f64>,
    /// A recorded flight: RTKLIB .pos, CSV with a header, NMEA or OptiTrack export.
    #[arg(long, value_name = "FILE")]
    pub(super) trajectory: Option<PathBuf>,
    /// Place of the target in the flight's frame, m.
    #[arg(long, value_name = "X,Y,Z", value_parser = point_m, allow_hyphen_values = true)]
    pub(super) target: Option<[f64; 3]>,
    /// Several targets at once: a CSV file of x,y,z in metres, one target a line.
    #[arg(long, value_name = "FILE")]
    pub(super) targets: Option<PathBuf>,
    /// Height of the image plane, m [default: the single target's; 0 with --targets].
    #[arg(long, value_name = "Z", value_parser = number, allow_negative_numbers = true)]
    pub(super) plane_z: Option<f64>,
    /// Speed of light, m/s.
    #[arg(long, value_name = "V", default_value_t = SPEED_OF_LIGHT_M_S, value_parser = positive)]
    pub(super) light_speed: f64,
    /// Band of the radar, GHz.
    #[arg(long, value_name = "A:B", default_value = "3.1:4.8", value_parser = band_ghz)]
    pub(super) band_ghz: (f64, f64),
    /// Frequencies over the band, its ends included.
    #[arg(long, value_name = "N", default_value_t = 341, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub(super) frequencies: u32,
    /// Half-width of the image about the targets, m.
    #[arg(long, value_name = "M", default_value_t = 3.0, value_parser = positive)]
    pub(super) half_width_m: f64,
    /// Pixel of the image, m.
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = positive)]
    pub(super) pixel_m: f64,
    #[command(flatten)]
    pub(super) blur: BlurArgs,
    /// Answer as JSON.
    #[arg(long)]
    pub(super) json: bool,
    /// Write pictures and tables there: psf.png, cuts.png, cuts.csv, track.csv and psf.json, or
    /// targets.json and targets.csv.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
}

/// Options of the sensitivity analysis.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Positioning errors")]
pub struct BlurArgs {
    /// Standard deviation of the position on each axis, m: print the resulting blur of the image.
    #[arg(long, value_name = "S", value_parser = not_negative, allow_negative_numbers = true)]
    pub(super) position_sigma_m: Option<f64>,
    /// Take the standard deviations of the positions from the trajectory file (.pos, CSV, NMEA).
    #[arg(long, requires = "trajectory", conflicts_with = "position_sigma_m")]
    pub(super) position_sigma_from_file: bool,
    /// Path over which errors are correlated (to 1/e), m; by default they are independent at every pulse.
    #[arg(long, value_name = "L", value_parser = positive)]
    pub(super) correlation_m: Option<f64>,
    /// Time over which errors of a recorded flight are correlated, s.
    #[arg(long, value_name = "T", value_parser = positive, requires = "trajectory", conflicts_with = "correlation_m")]
    pub(super) correlation_s: Option<f64>,
    /// Draws of the Monte Carlo check; 0 for theory alone.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = trials)]
    pub(super) trials: usize,
    /// Seed of the draws.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(super) seed: u64,
}

fn trials(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(n) if n == 0 || (20..=1_000_000).contains(&n) => Ok(n),
        _ => Err("expected 0, or a number from 20 to 1000000".to_owned()),
    }
}

impl BlurArgs {
    /// Whether any of these options was given.
    pub fn asked(&self) -> bool {
        self.position_sigma_m.is_some() || self.position_sigma_from_file
    }
}

/// A track's shape as the option gives it.
fn shape(text: &str) -> Result<TrackShape, String> {
    let expected = "expected straight or cosine:AMPLITUDE_M:PERIOD_M, such as cosine:0.15:24";
    if text == "straight" {
        return Ok(TrackShape::Straight);
    }
    let parts: Vec<&str> = text.split(':').collect();
    let ["cosine", amplitude, period] = parts[..] else {
        return Err(expected.to_owned());
    };
    match (number(amplitude), positive(period)) {
        (Ok(amplitude_m), Ok(period_m)) => Ok(TrackShape::Cosine {
            amplitude_m,
            period_m,
        }),
        _ => Err(expected.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_read_or_refused() {
        assert_eq!(shape("straight"), Ok(TrackShape::Straight));
        assert_eq!(
            shape("cosine:-0.15:24"),
            Ok(TrackShape::Cosine {
                amplitude_m: -0.15,
                period_m: 24.0
            })
        );
        for bad in [
            "",
            "circle",
            "cosine",
            "cosine:0.15",
            "cosine:0.15:0",
            "cosine:x:24",
            "cosine:1:2:3",
        ] {
            assert!(shape(bad).is_err(), "{bad}");
        }
    }
}
