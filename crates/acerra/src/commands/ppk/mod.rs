//! `acerra ppk`: a rover's positions by carrier phase.

mod args;
mod option_values;
mod outputs;
mod settings;

use std::io::Write;
use std::path::{Path, PathBuf};

use acerra_chain::position::positioning::{self, Positioning, PositioningError, PpkAnswer};
use acerra_chain::read::inputs::InputFile;
use acerra_geo::geodesy::geodetic_from_ecef;
use acerra_geo::geoid::GeoidGrid;
use acerra_gnss::conf::write_conf;
use acerra_gnss::output::write_nmea;
use acerra_gnss::pos::write_pos;
use acerra_gnss::{AmbiguityMode, PpkOptions};
use acerra_products::report::{PpkReport, ppk_page};
use acerra_products::staging::StagedFile;
use anyhow::Context;

use crate::terminal;

use outputs::Extras;
use settings::Settings;

pub use args::Args;

/// Runs the command.
///
/// # Errors
/// Files that cannot be read or hold something else, and whatever makes a solution impossible;
/// an output that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    outputs_are_not_inputs(args)?;
    let Settings {
        options,
        mut format,
        inputs,
        outputs,
        mut remarks,
    } = args.settings()?;
    let input = args.input(inputs)?;
    let extras = Extras::new(args, &outputs)?;
    format.geoid = extras.solution_geoid(args, &outputs);
    let mut run = positioning::run(&input, &options).map_err(with_base_option)?;
    let remark = extras.wanted(&run.solution).1;
    remarks.extend(remark);
    remarks.extend(extras.remarks(args, &outputs));
    // The run's own remarks come last.
    remarks.append(&mut run.warnings);
    run.warnings = remarks;
    for warning in &run.warnings {
        terminal::warn(warning);
    }
    anyhow::ensure!(
        !run.solution.epochs.is_empty(),
        "{}: no epoch has a position{}",
        input.rover.display(),
        run.solution
            .summary
            .not_fixed
            .first()
            .map_or_else(String::new, |(reason, n)| format!(
                " ({reason}: {n} epochs)"
            ))
    );
    let answer = positioning::answer(&run, &options);
    let names: Vec<String> = run
        .files
        .iter()
        .map(|(p, _)| p.display().to_string())
        .collect();

    let mut written = Vec::new();
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));
    let (solution, _) = extras.wanted(&run.solution);
    let write = |to: &mut dyn Write| match outputs.nmea {
        true => write_nmea(to, &solution, extras.geoid.as_deref()),
        false => write_pos(to, &solution, &options, &names, &format),
    };
    if let Some(path) = args.output.as_deref().filter(|_| !to_stdout) {
        written.push(StagedFile::write(path, |to| Ok(write(to)?))?);
    }
    if let Some(path) = &args.report {
        let page = page(&run, &options, &answer)?;
        written.push(StagedFile::write(path, |to| {
            Ok(to.write_all(page.as_bytes())?)
        })?);
    }
    if let Some(path) = &args.events {
        written.push(StagedFile::write(path, |to| {
            write_events(to, &answer, format.geoid.as_deref())
        })?);
    }
    written.extend(extras.write(args, &solution)?);
    for file in written {
        file.publish()?;
    }
    if to_stdout {
        write(out)?;
    } else if args.json {
        serde_json::to_writer_pretty(&mut *out, &answer)?;
        writeln!(out)?;
    } else {
        write!(out, "{}", answer.text(&input))?;
    }
    Ok(())
}

/// The error with the option that gives the base's position, where that is missing.
fn with_base_option(error: PositioningError) -> anyhow::Error {
    if !error.is_base_position_missing() {
        return error.into();
    }
    let place = match error.suggested_base_ecef_m().map(geodetic_from_ecef) {
        Some(place) => format!(
            "llh:{:.8},{:.8},{:.2}",
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m
        ),
        None => "llh:LATITUDE,LONGITUDE,HEIGHT".to_owned(),
    };
    anyhow::anyhow!(
        "{error}; give its surveyed position by --base-position, or try --base-position {place}"
    )
}

/// Refuses to write over a file that is read.
fn outputs_are_not_inputs(args: &Args) -> anyhow::Result<()> {
    let inputs: Vec<PathBuf> = [Some(&args.rover), args.base.as_ref(), args.config.as_ref()]
        .into_iter()
        .flatten()
        .chain(&args.navigation)
        .chain(&args.more_rover)
        .chain(&args.more_base)
        .chain(&args.antennas)
        .chain(&args.geoid)
        .chain(&args.images)
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    let outputs = [
        &args.output,
        &args.report,
        &args.events,
        &args.nmea,
        &args.residuals,
        &args.image_positions,
        &args.attitudes,
    ];
    for path in outputs.into_iter().flatten() {
        let clash = path.canonicalize().is_ok_and(|path| inputs.contains(&path));
        anyhow::ensure!(
            !clash,
            "{}: is an input and would be overwritten",
            path.display()
        );
    }
    Ok(())
}

fn page(run: &Positioning, options: &PpkOptions, answer: &PpkAnswer) -> anyhow::Result<String> {
    let mut inputs = Vec::new();
    for (path, _) in &run.files {
        inputs.push(InputFile::record(path).with_context(|| path.display().to_string())?);
    }
    let rover = answer.files.first().map_or("", |f| f.file.as_str());
    let name = Path::new(rover)
        .file_name()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    // The page itself shows the run's own remarks.
    let own = run.solution.summary.warnings.len();
    let others = run.warnings.len().saturating_sub(own);
    Ok(ppk_page(&PpkReport {
        title: format!("Positions of {name}"),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        solution: &run.solution,
        ratio_threshold: (options.ambiguity != AmbiguityMode::Off)
            .then_some(options.ratio_threshold),
        pass_difference_m: Vec::new(),
        warnings: run.warnings[..others].to_vec(),
        inputs,
        configuration: write_conf(options),
    })?)
}

/// Events with heights above the geoid where one is given; the column name states the datum.
fn write_events(
    to: &mut dyn Write,
    answer: &PpkAnswer,
    geoid: Option<&GeoidGrid>,
) -> anyhow::Result<()> {
    let height = match geoid {
        Some(_) => "height_above_geoid_m",
        None => "height_m",
    };
    writeln!(
        to,
        "time_gpst,kind,latitude_deg,longitude_deg,{height},east_m,north_m,up_m,quality"
    )?;
    let separation_m = |lat: f64, lon: f64| match geoid {
        Some(geoid) => geoid
            .height_m(lat, lon)
            .with_context(|| format!("the geoid grid does not cover {lat:.6}° {lon:.6}°")),
        None => Ok(0.0),
    };
    for event in &answer.events {
        write!(to, "{},{}", event.time_gpst, event.kind)?;
        match event.llh {
            Some([lat, lon, height]) => {
                let height = height - separation_m(lat, lon)?;
                write!(to, ",{lat:.10},{lon:.10},{height:.4}")?;
            }
            None => write!(to, ",,,")?,
        }
        match event.enu_m {
            Some([e, n, u]) => write!(to, ",{e:.4},{n:.4},{u:.4}")?,
            None => write!(to, ",,,")?,
        }
        writeln!(
            to,
            ",{}",
            event.quality.map_or_else(String::new, |q| q.to_string())
        )?;
    }
    Ok(())
}
