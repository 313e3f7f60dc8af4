//! `acerra ppk`: a rover's positions by carrier phase.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::conf::{ConfInputs, ConfOutputs, read_conf};
use acerra_gnss::output::write_nmea;
use acerra_gnss::pos::{PosFormat, PosFrame, PosTime, PosTimeScale, write_pos};
use acerra_gnss::{
    AmbiguityMode, BasePosition, Cn0Mask, Dynamics, FilterDirection, GlonassAmbiguity,
    PositioningMode, PpkOptions, RuleSet, SatelliteId, System, SystemSet,
};
use anyhow::Context;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use acerra_chain::inputs::InputFile;
use acerra_chain::positioning::{
    self, AntennaInput, AntennaName, Positioning, PositioningInput, PpkAnswer,
};
use acerra_products::report::{PpkReport, ppk_page};
use acerra_products::staging::StagedFile;

use super::ppk_outputs::Extras;
use crate::terminal;

/// Position a rover by carrier phase against a base, after the flight.
///
/// Reads RINEX 2–4 (plain or Hatanaka-compressed), u-blox UBX and RTCM 3 logs, SP3 orbits and RINEX
/// clocks, each also inside gzip or compress (.Z), recognised by content; UBX and RTCM 3 logs bring
/// their own navigation data. Without options: kinematic, fix and hold,
/// forward and backward combined, every system's L1, the base's position from its header.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra ppk rover.ubx base.ubx -o flight.pos --report flight.html
  acerra ppk rover.obs base.obs brdc.nav --base-position llh:40.9596,14.3696,75.0 -o flight.pos
  acerra ppk rover.obs base.obs brdc.nav --config rtkpost.conf --json")]
pub struct Args {
    /// The rover's log.
    rover: PathBuf,
    /// The base's log.
    base: Option<PathBuf>,
    /// Navigation files: broadcast ephemerides, SP3 orbits, RINEX clocks.
    #[arg(value_name = "NAV")]
    navigation: Vec<PathBuf>,
    /// One more file of the rover's receiver, joined to its log (may be repeated).
    #[arg(long = "rover", value_name = "FILE", help_heading = "Input")]
    more_rover: Vec<PathBuf>,
    /// One more file of the base's receiver, such as that of another hour (may be repeated).
    #[arg(long = "base", value_name = "FILE", help_heading = "Input")]
    more_base: Vec<PathBuf>,
    /// Any time within half a week of RTCM 3 logs that do not tell their date: 2018-10-09T12:30:00.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Input")]
    date: Option<GpsTime>,
    /// Antenna calibrations of rover and base, found by the antennas' names in the logs.
    #[arg(long, value_name = "FILE.atx", help_heading = "Input")]
    antennas: Option<PathBuf>,
    /// The rover's antenna, as the calibrations name it, or `none`.
    #[arg(
        long,
        value_name = "NAME",
        requires = "antennas",
        help_heading = "Input"
    )]
    rover_antenna: Option<String>,
    /// The base's antenna, likewise.
    #[arg(
        long,
        value_name = "NAME",
        requires = "antennas",
        help_heading = "Input"
    )]
    base_antenna: Option<String>,
    /// Write the positions there, as RTKLIB does (`-`: standard output).
    #[arg(short, long, value_name = "FILE.pos")]
    pub(super) output: Option<PathBuf>,
    /// Settings of an RTKLIB configuration file; the options below override them.
    #[arg(long, value_name = "FILE.conf")]
    config: Option<PathBuf>,
    /// Write a page with trajectory, status, heights, satellites and residuals.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the positions of the events in the rover's log.
    #[arg(long, value_name = "FILE.csv")]
    events: Option<PathBuf>,
    /// Write NMEA sentences (GGA, RMC, GST).
    #[arg(long, value_name = "FILE.nmea")]
    pub(super) nmea: Option<PathBuf>,
    /// Write the residuals of every satellite and epoch.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) residuals: Option<PathBuf>,
    /// Write the positions of a camera's images: the first of --images at the rover's first event,
    /// and so on.
    #[arg(long, value_name = "FILE.csv", requires = "images")]
    pub(super) image_positions: Option<PathBuf>,
    /// The images: a folder, taken in order of their names, or a text file with a name on each
    /// line.
    #[arg(long, value_name = "PATH", requires = "image_positions")]
    pub(super) images: Option<PathBuf>,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,

    /// What is estimated.
    #[arg(long, value_parser = named(PositioningMode::ALL, PositioningMode::name), help_heading = "Positioning")]
    mode: Option<PositioningMode>,
    /// Which way through the log.
    #[arg(long, value_parser = directions(), help_heading = "Positioning")]
    direction: Option<FilterDirection>,
    /// Use the rover's log from this time on: 2018-10-09T12:30:00 in GPS time, with a Z at the end
    /// in UTC.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Positioning")]
    start: Option<GpsTime>,
    /// Use the rover's log up to this time, written likewise.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Positioning")]
    end: Option<GpsTime>,
    /// Where the base stands: `header`, `average` (of its single-point positions),
    /// `llh:LATITUDE,LONGITUDE,HEIGHT` (degrees, ellipsoidal m) or `xyz:X,Y,Z` (ECEF, m).
    #[arg(long, value_name = "PLACE", value_parser = base_position, allow_hyphen_values = true,
          help_heading = "Positioning")]
    base_position: Option<BasePosition>,
    /// Systems used, by letter: G GPS, R GLONASS, E Galileo, C BeiDou, J QZSS, I NavIC, S SBAS.
    #[arg(long, value_name = "LETTERS", value_parser = systems, help_heading = "Positioning")]
    systems: Option<SystemSet>,
    /// Satellites never used, as G05,R11.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Positioning"
    )]
    exclude: Vec<SatelliteId>,
    /// Frequencies: 1 (L1), 2 (L1 and L2 or E5b), 3 (and L5).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=3),
          help_heading = "Positioning")]
    frequencies: Option<u8>,
    /// Elevation mask, degrees.
    #[arg(long, value_name = "DEG", value_parser = elevation_deg, help_heading = "Positioning")]
    elevation_mask: Option<f64>,
    /// Least carrier-to-noise density, dB-Hz; signals of unknown strength pass.
    #[arg(long, value_name = "DBHZ", value_parser = super::values::positive,
          help_heading = "Positioning")]
    cn0_mask: Option<f64>,
    /// Largest age of the base's data, s.
    #[arg(long, value_name = "S", value_parser = super::values::positive,
          help_heading = "Positioning")]
    max_age: Option<f64>,
    /// Interpolate the base's data to the rover's time tags.
    #[arg(long, help_heading = "Positioning")]
    interpolate_base: bool,
    /// Predict the motion from velocity and acceleration.
    #[arg(long, help_heading = "Positioning")]
    dynamics: bool,
    /// Give positions from codes where nothing better exists (without --unguarded they are given
    /// anyway).
    #[arg(long, help_heading = "Positioning")]
    output_single: bool,

    /// How ambiguities are resolved.
    #[arg(
        long,
        value_parser = named(AmbiguityMode::ALL, AmbiguityMode::name),
        value_name = "MODE",
        help_heading = "Ambiguities and weights"
    )]
    ar: Option<AmbiguityMode>,
    /// Whether GLONASS ambiguities are resolved.
    #[arg(
        long,
        value_parser = named(GlonassAmbiguity::ALL, GlonassAmbiguity::name),
        value_name = "MODE",
        help_heading = "Ambiguities and weights"
    )]
    glonass_ar: Option<GlonassAmbiguity>,
    /// Least ratio of the second-best to the best set of integers.
    #[arg(long, value_name = "RATIO", value_parser = super::values::positive,
          help_heading = "Ambiguities and weights")]
    ratio: Option<f64>,
    /// Standard deviation of code over that of phase.
    #[arg(long, value_name = "RATIO", value_parser = super::values::positive,
          help_heading = "Ambiguities and weights")]
    code_phase_ratio: Option<f64>,
    /// Do only what RTKLIB does: no check of phases by signal strength and residuals, no base data
    /// interpolated across gaps, no satellites left out of a fix that fails with all.
    #[arg(long, help_heading = "Ambiguities and weights")]
    unguarded: bool,
    /// Whose rules hold where RTKLIB 2.4.3 and demo5 differ.
    #[arg(long, value_parser = named(RuleSet::ALL, RuleSet::name), help_heading = "Ambiguities and weights")]
    rules: Option<RuleSet>,

    /// Coordinates of the output.
    #[arg(long, value_parser = frames(), help_heading = "Output")]
    format: Option<PosFrame>,
    /// Form of the times.
    #[arg(long, value_parser = named(PosTime::ALL, PosTime::name), help_heading = "Output")]
    time_form: Option<PosTime>,
    /// Write velocities, too, into the solution file.
    #[arg(long, help_heading = "Output")]
    velocities: bool,
    /// Write positions only whose standard deviation is at most this along every axis, m.
    #[arg(long, value_name = "M", value_parser = super::values::positive, help_heading = "Output")]
    pub(super) max_sigma: Option<f64>,
    /// A geoid grid for the heights of --nmea and --image-positions: NGA WW15MGH.DAC, NOAA .gtx or
    /// GeographicLib .pgm.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(super) geoid: Option<PathBuf>,
    /// Scale of the times.
    #[arg(long, value_parser = named(PosTimeScale::ALL, PosTimeScale::name), help_heading = "Output")]
    time_scale: Option<PosTimeScale>,
}

/// Parser of an option whose values have names of their own.
fn named<T>(values: &'static [T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T>
where
    T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>
        + Copy
        + Send
        + Sync
        + 'static,
{
    described(
        values
            .iter()
            .map(|v| PossibleValue::new(name(*v)))
            .collect(),
    )
}

fn described<T>(values: Vec<PossibleValue>) -> impl TypedValueParser<Value = T>
where
    T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>
        + Clone
        + Send
        + Sync
        + 'static,
{
    PossibleValuesParser::new(values).try_map(|name: String| name.parse::<T>())
}

fn directions() -> impl TypedValueParser<Value = FilterDirection> {
    described(
        FilterDirection::ALL
            .iter()
            .map(|direction| {
                let value = PossibleValue::new(direction.name());
                match direction {
            FilterDirection::CombinedWithoutReset => value
                .help("Combined, the backward pass starting from what the forward pass ended with"),
            _ => value,
        }
            })
            .collect(),
    )
}

fn frames() -> impl TypedValueParser<Value = PosFrame> {
    described(
        PosFrame::ALL
            .iter()
            .map(|frame| {
                PossibleValue::new(frame.name()).help(match frame {
                    PosFrame::Geodetic => "Latitude, longitude, ellipsoidal height",
                    PosFrame::Ecef => "Earth-centred, Earth-fixed",
                    PosFrame::EnuBaseline => "East, north, up from the base",
                })
            })
            .collect(),
    )
}

fn base_position(text: &str) -> Result<BasePosition, String> {
    const EXPECTED: &str = "expected header, average, llh:LAT,LON,HEIGHT or xyz:X,Y,Z";
    match text {
        "header" => return Ok(BasePosition::Header),
        "average" => return Ok(BasePosition::AverageSingle),
        _ => {}
    }
    let (kind, numbers) = text.split_once(':').ok_or(EXPECTED)?;
    let mut values = [0.0; 3];
    let mut parts = numbers.split(',');
    for value in &mut values {
        *value = parts
            .next()
            .and_then(|part| part.trim().parse().ok())
            .filter(|v: &f64| v.is_finite())
            .ok_or(EXPECTED)?;
    }
    let [a, b, c] = values;
    match (kind, parts.next()) {
        ("xyz", None) => Ok(BasePosition::Ecef(values)),
        ("llh", None) if a.abs() <= 90.0 && b.abs() <= 360.0 => Ok(BasePosition::Ecef(
            ecef_from_geodetic(&Geodetic::from_degrees(a, b, c)),
        )),
        ("llh", None) => Err("latitude beyond ±90° or longitude beyond ±360°".to_owned()),
        _ => Err(EXPECTED.to_owned()),
    }
}

fn systems(text: &str) -> Result<SystemSet, String> {
    let found: Option<SystemSet> = text.chars().map(System::from_letter).collect();
    found
        .filter(|set| !set.is_empty())
        .ok_or_else(|| "expected letters of G, R, E, C, J, I, S".to_owned())
}

/// A time as `2018-10-09T12:30:00.5`, GPS time or, with a `Z`, UTC.
fn time(text: &str) -> Result<GpsTime, String> {
    const EXPECTED: &str = "expected a time as 2018-10-09T12:30:00 (GPS time), or with a Z (UTC)";
    let (body, utc) = text
        .strip_suffix('Z')
        .map_or((text, false), |body| (body, true));
    let (date, clock) = body.split_once(['T', ' ']).ok_or(EXPECTED)?;
    let date: Vec<&str> = date.split(['-', '/']).collect();
    let clock: Vec<&str> = clock.split(':').collect();
    let ([year, month, day], [hour, minute, second]) = (&date[..], &clock[..]) else {
        return Err(EXPECTED.to_owned());
    };
    let whole = |part: &str| part.parse::<u8>().map_err(|_| EXPECTED.to_owned());
    let year = year.parse().map_err(|_| EXPECTED.to_owned())?;
    let second: f64 = second.parse().map_err(|_| EXPECTED.to_owned())?;
    let calendar = Calendar::new(
        year,
        whole(month)?,
        whole(day)?,
        whole(hour)?,
        whole(minute)?,
        second,
    )
    .map_err(|e| format!("{EXPECTED}: {e}"))?;
    if utc {
        GpsTime::from_utc(&calendar).map_err(|e| e.to_string())
    } else {
        Ok(GpsTime::from_calendar(&calendar))
    }
}

fn elevation_deg(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|deg| (0.0..90.0).contains(deg))
        .ok_or_else(|| "expected degrees from 0 to below 90".to_owned())
}

/// Runs the command.
///
/// # Errors
/// Files that cannot be read or hold something else, and whatever makes a solution impossible;
/// an output that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    outputs_are_not_inputs(args)?;
    let Settings {
        options,
        format,
        inputs,
        outputs,
        mut remarks,
    } = args.settings()?;
    let input = args.input(inputs)?;
    let extras = Extras::new(args, &outputs)?;
    let mut run = positioning::run(&input, &options)?;
    let remark = extras.wanted(&run.solution).1;
    remarks.extend(remark);
    remarks.extend(extras.remark(args, &outputs));
    // The run's own remarks stay last.
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
        true => write_nmea(to, &solution, extras.geoid.as_ref()),
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
        written.push(StagedFile::write(path, |to| write_events(to, &answer))?);
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

/// What the command line and a configuration file ask for.
struct Settings {
    options: PpkOptions,
    format: PosFormat,
    inputs: ConfInputs,
    outputs: ConfOutputs,
    remarks: Vec<String>,
}

impl Args {
    /// The files of the run: those of the command line, then those of a configuration file.
    fn input(&self, conf: ConfInputs) -> anyhow::Result<PositioningInput> {
        let named = |option: &Option<String>, conf: &str| match (option.as_deref(), conf) {
            (Some("none"), _) => AntennaName::None,
            (Some(name), _) => AntennaName::Given(name.to_owned()),
            (None, _) if self.antennas.is_some() && conf.is_empty() => AntennaName::Header,
            (None, "") => AntennaName::None,
            (None, "*") => AntennaName::Header,
            (None, name) => AntennaName::Given(name.to_owned()),
        };
        let antennas = AntennaInput {
            rover: named(&self.rover_antenna, &conf.rover_antenna),
            base: named(&self.base_antenna, &conf.base_antenna),
            file: self
                .antennas
                .clone()
                .or_else(|| conf.antenna_file.map(PathBuf::from)),
        };
        let calibrated = [&antennas.rover, &antennas.base]
            .into_iter()
            .any(|name| *name != AntennaName::None);
        Ok(PositioningInput {
            rover: self.rover.clone(),
            base: self.base.clone(),
            navigation: self.navigation.clone(),
            more_rover: self.more_rover.clone(),
            more_base: self.more_base.clone(),
            date: self.date,
            needs_precise_orbits: conf.precise_orbits,
            antennas: if calibrated {
                antennas
            } else {
                AntennaInput::default()
            },
        })
    }

    /// Options and outputs: preset or configuration file, then what the command line says.
    fn settings(&self) -> anyhow::Result<Settings> {
        let mut remarks = Vec::new();
        let (mut inputs, mut outputs) = (ConfInputs::default(), ConfOutputs::default());
        let (mut options, mut format) = match &self.config {
            Some(path) => {
                let place = || path.display().to_string();
                let file = File::open(path).with_context(place)?;
                let conf = read_conf(BufReader::new(file), self.rules.unwrap_or(RuleSet::Rtklib))
                    .with_context(place)?;
                remarks.extend(
                    conf.not_followed
                        .iter()
                        .map(|setting| format!("{}: {setting}", place())),
                );
                (inputs, outputs) = (conf.inputs, conf.outputs);
                let mut options = conf.options;
                if let Some(rules) = self.rules.filter(|r| *r != options.rules) {
                    remarks.push(format!(
                        "{}: its settings are followed by the rules of {rules}, as the command \
                         line says, not of {}",
                        place(),
                        options.rules
                    ));
                    options.rules = rules;
                }
                (options, conf.format)
            }
            None => match self.rules {
                Some(RuleSet::Demo5) => (
                    PpkOptions::demo5().with_direction(FilterDirection::Combined),
                    PosFormat::default(),
                ),
                Some(RuleSet::Rtklib) => (
                    PpkOptions::rtklib()
                        .with_systems(PpkOptions::default().systems)
                        .with_direction(FilterDirection::Combined),
                    PosFormat::default(),
                ),
                None => (PpkOptions::default(), PosFormat::default()),
            },
        };
        if self.unguarded {
            options = options.without_safeguards();
        } else if options.rules == RuleSet::Rtklib {
            options = options.with_safeguards();
        }
        self.override_options(&mut options);
        format.frame = self.format.unwrap_or(format.frame);
        format.time = self.time_form.unwrap_or(format.time);
        format.scale = self.time_scale.unwrap_or(format.scale);
        format.velocity |= self.velocities;
        Ok(Settings {
            options,
            format,
            inputs,
            outputs,
            remarks,
        })
    }

    fn override_options(&self, options: &mut PpkOptions) {
        options.mode = self.mode.unwrap_or(options.mode);
        options.start = self.start.or(options.start);
        options.end = self.end.or(options.end);
        options.direction = self.direction.unwrap_or(options.direction);
        options.ambiguity = self.ar.unwrap_or(options.ambiguity);
        options.glonass_ambiguity = self.glonass_ar.unwrap_or(options.glonass_ambiguity);
        if let Some(ratio) = self.ratio {
            options.ratio_threshold = ratio;
            options.ratio_threshold_range = [ratio; 2];
        }
        if let Some(ratio) = self.code_phase_ratio {
            options.code_phase_ratio = [ratio; acerra_gnss::FREQUENCY_SLOTS];
        }
        if let Some(place) = self.base_position {
            options.base_position = place;
        }
        if let Some(systems) = self.systems {
            options.systems = systems;
        }
        options.excluded_satellites.extend(&self.exclude);
        if let Some(frequencies) = self.frequencies {
            options.frequencies = usize::from(frequencies);
        }
        if let Some(mask) = self.elevation_mask {
            options.elevation_mask_rad = mask.to_radians();
        }
        if let Some(age) = self.max_age {
            options.max_age_s = age;
        }
        if let Some(least) = self.cn0_mask {
            options.cn0_mask = Some(Cn0Mask::uniform(least));
        }
        options.interpolate_base |= self.interpolate_base;
        options.output_single |= self.output_single;
        if self.dynamics && options.dynamics.is_none() {
            options.dynamics = Some(Dynamics::DRONE);
        }
    }
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
    // The run's own remarks are shown by the page itself.
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
        configuration: format!("{options:#?}"),
    })?)
}

fn write_events(to: &mut dyn Write, answer: &PpkAnswer) -> anyhow::Result<()> {
    writeln!(
        to,
        "time_gpst,kind,latitude_deg,longitude_deg,height_m,east_m,north_m,up_m,quality"
    )?;
    for event in &answer.events {
        write!(to, "{},{}", event.time_gpst, event.kind)?;
        match event.llh {
            Some([lat, lon, height]) => write!(to, ",{lat:.10},{lon:.10},{height:.4}")?,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        let t = |text| time(text).unwrap();
        assert_eq!(t("2018-10-09T12:30:00"), t("2018/10/09 12:30:00.0"));
        assert!((t("2018-10-09T12:30:00Z") - t("2018-10-09T12:30:00.5") - 17.5).abs() < 1e-9);
        for bad in [
            "",
            "12:30:00",
            "2018-10-09",
            "2018-13-09T12:30:00",
            "2018-10-09T12:30",
            "2018-10-09T12:30:x",
        ] {
            assert!(time(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn base_positions() {
        assert_eq!(base_position("header"), Ok(BasePosition::Header));
        assert_eq!(base_position("average"), Ok(BasePosition::AverageSingle));
        assert_eq!(
            base_position("xyz:1,-2,3.5"),
            Ok(BasePosition::Ecef([1.0, -2.0, 3.5]))
        );
        let Ok(BasePosition::Ecef(p)) = base_position("llh:35,140,100") else {
            panic!()
        };
        assert!((p[0] + 4_006_802.166_763).abs() < 1e-6);
        for bad in [
            "",
            "llh:1,2",
            "xyz:1,2,3,4",
            "llh:95,0,0",
            "abc:1,2,3",
            "xyz:nan,0,0",
        ] {
            assert!(base_position(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn system_letters() {
        assert_eq!(systems("GR"), Ok(SystemSet::GPS.with(System::Glonass)));
        assert!(systems("").is_err() && systems("GX").is_err());
    }
}
