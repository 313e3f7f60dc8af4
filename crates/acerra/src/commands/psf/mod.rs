//! `acerra psf`: the point spread function of a flight, before or after flying it.

mod blur;
mod output;
mod scene;
mod targets;

use std::io::Write;
use std::path::PathBuf;

use acerra_chain::memory::available_memory_bytes;
use acerra_imaging::psf::{Analysis, TrackShape, psf_image, retrieve};
use acerra_imaging::{Control, SPEED_OF_LIGHT_M_S};
use anyhow::{bail, ensure};
use clap::ArgGroup;

use super::values::{band_ghz, number, point_m, positive};

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
    height: Option<f64>,
    /// Offset of the target from the line y = 0: it stands at (0, D, 0) m.
    #[arg(long, value_name = "D", value_parser = number, allow_negative_numbers = true)]
    offset: Option<f64>,
    /// Shape of the synthetic flight: straight, or cosine:AMPLITUDE_M:PERIOD_M (Eq. 13 is
    /// cosine:0.15:24).
    #[arg(long, value_name = "SHAPE", value_parser = shape, conflicts_with = "trajectory")]
    track: Option<TrackShape>,
    /// Half-length of the synthetic flight, m [default: 3].
    #[arg(long, value_name = "L", value_parser = positive, conflicts_with = "trajectory")]
    half_length_m: Option<f64>,
    /// Distance between pulses, m [default: 0.01; a recorded flight's own positions].
    #[arg(long, value_name = "M", value_parser = positive)]
    step_m: Option<f64>,
    /// A recorded flight: RTKLIB .pos, CSV with a header, NMEA or OptiTrack export.
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Place of the target in the flight's frame, m.
    #[arg(long, value_name = "X,Y,Z", value_parser = point_m, allow_hyphen_values = true)]
    target: Option<[f64; 3]>,
    /// Several targets at once: a CSV file of x,y,z in metres, one target a line.
    #[arg(long, value_name = "FILE")]
    targets: Option<PathBuf>,
    /// Height of the image plane, m [default: the single target's; 0 with --targets].
    #[arg(long, value_name = "Z", value_parser = number, allow_negative_numbers = true)]
    plane_z: Option<f64>,
    /// Speed of light, m/s.
    #[arg(long, value_name = "V", default_value_t = SPEED_OF_LIGHT_M_S, value_parser = positive)]
    light_speed: f64,
    /// Band of the radar, GHz.
    #[arg(long, value_name = "A:B", default_value = "3.1:4.8", value_parser = band_ghz)]
    band_ghz: (f64, f64),
    /// Frequencies over the band, its ends included.
    #[arg(long, value_name = "N", default_value_t = 341, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frequencies: u32,
    /// Half-width of the image about the targets, m.
    #[arg(long, value_name = "M", default_value_t = 3.0, value_parser = positive)]
    half_width_m: f64,
    /// Pixel of the image, m.
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = positive)]
    pixel_m: f64,
    #[command(flatten)]
    blur: blur::BlurArgs,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,
    /// Write pictures and tables there: psf.png, cuts.png, cuts.csv, track.csv and psf.json, or
    /// targets.json and targets.csv.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Bytes that a pixel takes while the image is made and drawn: the value and its level.
const PIXEL_BYTES: u128 = 12;

/// Refuses an image that memory cannot hold.
fn fits_memory(scene: &scene::Scene) -> anyhow::Result<()> {
    let needed = PIXEL_BYTES * scene.grid.len() as u128;
    if let Some(available) = available_memory_bytes() {
        ensure!(
            needed <= u128::from(available),
            "the image needs {needed} bytes of memory, {available} bytes are available: choose a \
             larger --pixel-m or a smaller --half-width-m"
        );
    }
    Ok(())
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

/// Runs the command.
///
/// # Errors
/// Impossible geometry or sampling, a file that cannot be read, an output directory that cannot
/// be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let scene = scene::Scene::of(args)?;
    if args.output.is_some() || args.targets.is_some() {
        fits_memory(&scene)?;
    }
    for note in &scene.notes {
        crate::terminal::note(note);
    }
    if args.targets.is_some() {
        if args.blur.asked() {
            bail!("the sensitivity to positioning errors is that of one target, not of --targets");
        }
        let image = psf_image(
            &scene.spread,
            &scene.target_m,
            scene.grid,
            Control::default(),
        )?;
        let found = retrieve(&scene.spread, &scene.target_m, &image, scene.grid)?;
        if let Some(directory) = &args.output {
            output::write_targets(directory, &scene, &image, &found)?;
        }
        return targets::answer(args.json, scene.grid.z_m, &found, out);
    }
    let found = Analysis::of(&scene.spread, scene.target_m[0], scene.grid.z_m)?;
    if found.expected_m.is_none() {
        crate::terminal::note(&format!(
            "the image plane lies too far below the target to show it (Eq. 14): what follows \
             describes the residue at ({:.3}, {:.3}) m",
            found.peak_m[0], found.peak_m[1]
        ));
    }
    let answer = output::Answer::of(&found, blur::analyse(&args.blur, &scene)?);
    if let Some(directory) = &args.output {
        let image = psf_image(
            &scene.spread,
            &scene.target_m,
            scene.grid,
            Control::default(),
        )?;
        output::write_single(directory, &scene, &image, &found, &answer)?;
    }
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &answer)?;
        writeln!(out)?;
    } else {
        out.write_all(output::text(&found).as_bytes())?;
        if let Some(blur) = &answer.sensitivity {
            out.write_all(blur::text(blur).as_bytes())?;
        }
    }
    Ok(())
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
