//! Finds the offset between the clocks of a radar log and a trajectory.
//!
//! `cargo run --release -p acerra-radar --example find_offset -- flight.mrm flight.pos [GROUND_M]`
//!
//! `GROUND_M` is the height of the ground in the trajectory's frame, 0 by default.

#![allow(clippy::print_stdout)] // an example talks to its user

use std::error::Error;
use std::fs::File;
use std::io::BufReader;

use acerra_geo::interpolate::{InterpolationOptions, Interpolator};
use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_radar::align::{FlightProfile, FlightState, OffsetOptions, offset_likelihood};
use acerra_radar::{Control, Limits, RadarFile, RadargramOptions, read};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [radar, trajectory, rest @ ..] = &arguments[..] else {
        return Err("expected a radar log and a trajectory".into());
    };
    let ground_m: f64 = rest.first().map_or(Ok(0.0), |text| text.parse())?;

    let RadarFile::Log(log) = read(BufReader::new(File::open(radar)?), &Limits::default())? else {
        return Err("expected a log of scans".into());
    };
    let radargram = log.radargram(&RadargramOptions::default())?.radargram;
    println!("{}: {}", log.format, log.report);

    let file = BufReader::new(File::open(trajectory)?);
    let (track, report) = read_trajectory(file, &ReadOptions::default())?;
    println!("{}: {report}", report.format);
    let at = Interpolator::new(&track, &InterpolationOptions::default());
    let profile = FlightProfile::sample([track.start_s(), track.end_s()], |t| {
        let [before, here, after] = [-0.1, 0.0, 0.1].map(|dt| at.at(t + dt));
        let d = [0, 1, 2].map(|i| after.position_m[i] - before.position_m[i]);
        here.flag.is_covered().then_some(FlightState {
            height_m: here.position_m[2] - ground_m,
            speed_m_s: (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() / 0.2,
        })
    })?;

    let options = OffsetOptions::default();
    let likelihood = offset_likelihood(&radargram, &profile, &options, Control::default())?;
    if let Some(cue) = &likelihood.height {
        println!(
            "height: {:.3} s, delay {:.2} ± {:.2} ns, residual {:.3} ns, {:.0} % strays, {} picks \
             of which {:.1} make one, evidence {:.1}",
            cue.offset_s,
            cue.delay_s * 1e9,
            cue.delay_sigma_s * 1e9,
            cue.residual_s * 1e9,
            100.0 * cue.stray_share,
            cue.picks,
            cue.correlation_length,
            cue.evidence
        );
    }
    if let Some(cue) = &likelihood.motion {
        println!(
            "motion: {:.3} s, {:.0} % explained, {:.1} traces make one, {} starts and halts, evidence {:.1}",
            cue.offset_s,
            100.0 * cue.explained,
            cue.correlation_length,
            cue.transitions,
            cue.evidence
        );
    }
    for c in &likelihood.candidates {
        println!(
            "candidate: {:.3} ± {:.3} s, {:.1} below the best",
            c.offset_s, c.sigma_s, c.below_best
        );
    }
    match likelihood.decide() {
        Ok(found) => println!(
            "offset {:.4} ± {:.4} s; next best (s, log-likelihood below): {:?}",
            found.offset_s, found.sigma_s, found.second
        ),
        Err(refusal) => println!("refused: {refusal}"),
    }
    Ok(())
}
