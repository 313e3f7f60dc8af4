//! `acerra resolution`: the theoretical resolution of a straight track.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use acerra_imaging::SPEED_OF_LIGHT_M_S;
use acerra_imaging::resolution::{Aperture, Band, Prediction, across_track_map_m};
use serde::Serialize;

use super::values::{band_ghz, not_negative, positive};
use acerra_figure::{Axis, Map};
use acerra_products::staging::Staging;

/// Print the resolution of a straight flight (Eqs. 6–12), and map it (Figure 6).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra resolution --height 10 --offset 2 --half-aperture-m 3
  acerra resolution --height 10 --offset 2 -o map")]
pub struct Args {
    /// Height of the flight above the target, m.
    #[arg(long, value_name = "H", value_parser = positive, allow_negative_numbers = true)]
    height: f64,
    /// Horizontal distance of the target from the track, m.
    #[arg(long, value_name = "D", value_parser = not_negative, allow_negative_numbers = true)]
    offset: f64,
    /// Band of the radar, GHz.
    #[arg(long, value_name = "A:B", default_value = "3.1:4.8", value_parser = band_ghz)]
    band_ghz: (f64, f64),
    /// Half-length of the track abeam the target, m; without it there is no along-track figure.
    #[arg(long, value_name = "L", value_parser = positive, allow_negative_numbers = true)]
    half_aperture_m: Option<f64>,
    /// Speed of light, m/s.
    #[arg(long, value_name = "V", default_value_t = SPEED_OF_LIGHT_M_S, value_parser = positive)]
    light_speed: f64,
    /// Largest offset of the map, m.
    #[arg(long, value_name = "D", default_value_t = 10.0, value_parser = positive)]
    map_offset_m: f64,
    /// Greatest height of the map, m.
    #[arg(long, value_name = "H", default_value_t = 10.0, value_parser = positive)]
    map_height_m: f64,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,
    /// Write the map over offset and height there: resolution-map.png and resolution-map.csv.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Serialize)]
struct Answer<'a> {
    height_m: f64,
    offset_m: f64,
    band_hz: [f64; 2],
    light_speed_m_s: f64,
    half_aperture_m: Option<f64>,
    #[serde(flatten)]
    prediction: &'a Prediction,
}

/// Runs the command.
///
/// # Errors
/// Impossible geometry; an output directory that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let (low_hz, high_hz) = args.band_ghz;
    let band = Band {
        low_hz,
        high_hz,
        light_speed_m_s: args.light_speed,
    };
    let aperture = Aperture::new(args.height, args.offset)?;
    let prediction = Prediction::of(aperture, band, args.half_aperture_m)?;
    if let Some(directory) = &args.output {
        let staging = Staging::new(directory)?;
        let [png, csv] = map(args, prediction.range_m)?;
        staging.write("resolution-map.png", png)?;
        staging.write("resolution-map.csv", csv)?;
        staging.publish()?;
    }
    if args.json {
        let answer = Answer {
            height_m: args.height,
            offset_m: args.offset,
            band_hz: [low_hz, high_hz],
            light_speed_m_s: args.light_speed,
            half_aperture_m: args.half_aperture_m,
            prediction: &prediction,
        };
        serde_json::to_writer_pretty(&mut *out, &answer)?;
        writeln!(out)?;
    } else {
        out.write_all(text(args, &prediction).as_bytes())?;
    }
    Ok(())
}

fn text(args: &Args, prediction: &Prediction) -> String {
    let mut text = format!(
        "height {} m, offset {} m, band {}–{} GHz\n",
        args.height,
        args.offset,
        args.band_ghz.0 / 1e9,
        args.band_ghz.1 / 1e9
    );
    // Writing to a String cannot fail.
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<26}{value}");
    };
    match (
        prediction.along_m,
        prediction.along_small_angle_m,
        prediction.longest_step_m,
    ) {
        (Some(along), Some(small), Some(step)) => {
            line("along track, Eq. (6)", format!("{along:.4} m"));
            line("  small angle, Eq. (7)", format!("{small:.4} m"));
            line("  pulses at most", format!("{step:.4} m apart"));
        }
        _ => line("along track", "needs --half-aperture-m".to_owned()),
    }
    line("range, Eq. (8)", format!("{:.4} m", prediction.range_m));
    line(
        "across track, Eq. (9)",
        format!("{:.4} m", prediction.across_m),
    );
    let [least, most] = prediction.across_bounds_m;
    line("  bounds, Eq. (12)", format!("{least:.4} to {most:.4} m"));
    for caveat in &prediction.caveats {
        let _ = writeln!(text, "note: {caveat}");
    }
    text
}

/// Points of the map along each axis.
const MAP_POINTS: usize = 101;

/// Figure 6 as PNG and as CSV (first row offsets, first column heights).
fn map(args: &Args, range_m: f64) -> anyhow::Result<[Vec<u8>; 2]> {
    let last = (MAP_POINTS - 1) as f64;
    let (offset_step, height_step) = (args.map_offset_m / last, args.map_height_m / last);
    let offset_m: Vec<f64> = (0..MAP_POINTS).map(|i| offset_step * i as f64).collect();
    // A flight has a height above 0: the first row is one step up.
    let height_m: Vec<f64> = (1..MAP_POINTS).map(|i| height_step * i as f64).collect();
    let across_m = across_track_map_m(range_m, &offset_m, &height_m)?;

    let mut csv = String::from("height_m\\offset_m");
    for d in &offset_m {
        let _ = write!(csv, ",{d:.3}");
    }
    csv.push('\n');
    for (h, row) in height_m.iter().zip(across_m.chunks(offset_m.len())) {
        let _ = write!(csv, "{h:.3}");
        for value in row {
            let _ = write!(csv, ",{value:.5}");
        }
        csv.push('\n');
    }

    let figure = Map::new(
        "Across-track Rayleigh resolution of a straight track, Eq. (9)",
        Axis::new("offset d", "m"),
        Axis::new("height h", "m"),
        &across_m,
        offset_m.len(),
        height_m.len(),
    )
    .grid([0.0, offset_step], [height_step, height_step])
    .contours(&[0.1, 0.12, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0])
    .values_are("across-track Rayleigh resolution (m)");
    let figure = Map {
        log_colours: true,
        width_px: 640.0,
        plot_height_px: 400.0,
        ..figure
    };
    Ok([figure.draw()?.to_png()?, csv.into_bytes()])
}
