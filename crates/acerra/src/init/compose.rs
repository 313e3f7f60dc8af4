//! The campaign's text.

use std::path::{Path, PathBuf};

use acerra_autopilot::{LogFormat, LogReport};
use acerra_chain::Control;
use acerra_chain::look::{LookError, look};
use acerra_chain::position::trajectory_file::TrajectoryFile;
use acerra_geo::trajectory::TimeOrigin;
use acerra_radar::{LoggedClock, Radargram};
use anyhow::{bail, ensure};

use super::answers::Answers;
use super::gnss::{Pair, pair};
use super::ground::{ANTENNA_HEIGHT_M, OnGround};
use super::lines::{antennas_apart, distinct, files_key, way_said};
use super::logs::{Logs, RadarInput};
use super::named_in;
use super::sounding::Heights;
use crate::interrupt::cancel_flag;
use crate::progress::Bar;
use crate::settings_files::SettingsFile;
use crate::settings_files::template::{Filled, quoted, write_first};

/// Range beyond the height up to which the default gate keeps echoes of the ground (m): 24 ns.
const GATED_M: f64 = 3.6;

/// Keys that matter on every flight, whatever was found.
const FIRST_KEYS: &[&str] = &[
    "radar.delay_ns",
    "trajectory.time_offset_s",
    "trajectory.lever_arm_m",
    "image.x_m",
    "image.y_m",
    "image.z_m",
    "image.pixel_m",
    "image.band_ghz",
];

/// The text of a campaign from `logs`, for a file in `folder`.
///
/// # Errors
/// No radar log or several, no positions or several trajectories, a receiver without a base.
pub fn compose(logs: &Logs, folder: &Path) -> anyhow::Result<String> {
    let all = distinct(&logs.radar);
    let radar = match all.as_slice() {
        [radar] => *radar,
        [_, _, ..] if all.iter().all(|log| log.is_foreign) && logs.has_no_clock() => {
            return of_lines(&all, logs, folder);
        }
        [] => bail!(
            "no radar log among the files (MRM capture, MRM-RET text, NPZ, or a file of another maker's)"
        ),
        [first, second, ..] => bail!(
            "{} and {} are both radar logs: begin a campaign for each; several tracks become one \
             image by [[track]] tables, several files of another maker's radar by [radar] files",
            first.path.display(),
            second.path.display()
        ),
    };
    let mut campaign = Campaign {
        folder,
        has_clock: LoggedClock::path_beside(&radar.path).is_file(),
        has_lines: false,
        questions: Vec::new(),
        filled: vec![
            Filled::new("radar.file", quoted(&named_in(folder, &radar.path)?))
                .because(&radar.summary),
        ],
    };
    campaign.filled.extend(radar.band_ghz.map(band_key));
    campaign.filled.extend(antennas_apart(&[radar]));
    let pair = pair(logs)?;
    let (attitudes, trajectories) = attitudes_apart(logs, pair.is_some());
    match (trajectories.as_slice(), pair) {
        ([(path, trajectory)], pair) => {
            campaign.with_trajectory(radar, path, trajectory)?;
            if let Some(body) = &logs.body {
                let name = Filled::new("trajectory.rigid_body", quoted(&body.name));
                campaign.filled.push(name.because(&body.reason));
            }
            if let Some(radargram) = &radar.radargram
                && trajectory.trajectory.time_origin() != TimeOrigin::TraceNumbers
            {
                campaign.with_look(radargram, trajectory, radar.time_s)?;
            }
            if let Some(pair) = pair {
                campaign.filled.push(Filled::remark(
                    "gnss.rover",
                    format!(
                        "{} and {}, not used as a trajectory is given",
                        pair.rover.path.display(),
                        pair.base.path.display()
                    ),
                ));
            }
        }
        ([(first, _), (second, _), ..], _) => bail!(
            "{} and {} are both trajectories: give the one of the radar",
            first.display(),
            second.display()
        ),
        ([], Some(pair)) => campaign.with_receivers(logs, &pair)?,
        ([], None) if radar.has_positions => {
            campaign.filled.push(Filled::remark(
                "trajectory.file",
                "none needed, the radar file brings the positions of its traces",
            ));
            let ground = OnGround::of(&[radar], radar.band_ghz);
            campaign.below_places(&[radar], ground.as_ref());
        }
        ([], None) if radar.is_foreign => campaign.with_line(radar),
        ([], None) => bail!(
            "no positions among the files: expected a trajectory, or the logs of two GNSS receivers"
        ),
    }
    if let Some((path, log)) = attitudes {
        campaign.with_attitudes(path, log)?;
    }
    Ok(campaign.text())
}

/// The campaign of several files that count their traces along lines, or place them, or have a table of places by trace
/// number.
fn of_lines(radar: &[&RadarInput], logs: &Logs, folder: &Path) -> anyhow::Result<String> {
    let mut campaign = Campaign {
        folder,
        has_clock: false,
        has_lines: true,
        questions: Vec::new(),
        filled: vec![files_key(folder, radar)?],
    };
    let band_ghz = band_of(radar);
    campaign.filled.extend(band_ghz.map(band_key));
    campaign.filled.extend(antennas_apart(radar));
    if let [(path, table)] = logs.trajectory.as_slice() {
        campaign.with_trajectory(radar[0], path, table)?;
        return Ok(campaign.text());
    }
    let ground = OnGround::of(radar, band_ghz);
    if radar.iter().all(|log| log.has_positions) {
        campaign.below_places(radar, ground.as_ref());
        return Ok(campaign.text());
    }
    let said = way_said(radar);
    let area = ground.as_ref().map_or(
        "",
        |_| "; [image] x_m, y_m: which area below them is imaged?",
    );
    campaign.questions.push(format!(
        "[radar] line_start_m, line_end_m, line_step_m: where do the first and the last trace of the first line lie, \
         and how far is it from each line to the next (x, y, and the height of the antennas z, in m)? {said}. \
         Lines that are not evenly spaced have a table, lines = [{{ file, start_m, end_m }}, …]{area}{}",
        soil_question(ground.as_ref())
    ));
    let asked = ["start", "end", "step"].map(|of| format!("radar.line_{of}_m"));
    campaign
        .filled
        .extend(asked.map(|key| Filled::remark(&key, &said)));
    campaign.with_direct_wave(radar, ground.as_ref());
    campaign
        .filled
        .extend(ground.iter().flat_map(OnGround::below_lines));
    Ok(campaign.text())
}

/// Band of the echoes of several files (GHz).
fn band_of(radar: &[&RadarInput]) -> Option<[f64; 2]> {
    let bands = radar.iter().filter_map(|log| log.band_ghz);
    bands.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Clause on the soil, of a question on the places of the antennas.
fn soil_question(ground: Option<&OnGround>) -> String {
    ground.map_or_else(String::new, |ground| {
        format!("; [ground] relative_permittivity: {}", ground.question())
    })
}

fn band_key([low, high]: [f64; 2]) -> Filled {
    Filled::new("image.band_ghz", format!("[{low:?}, {high:?}]"))
        .because("within 10 dB of the top of the echoes' spectrum, mean of the traces removed")
}

/// A trajectory by its path.
type Given = (PathBuf, TrajectoryFile);

/// The only flight log with attitudes, where positions come from elsewhere: receivers' logs, or a trajectory
/// on GPS time. And the other trajectories.
fn attitudes_apart(logs: &Logs, has_receivers: bool) -> (Option<(&Path, &LogReport)>, Vec<&Given>) {
    let all = || logs.trajectory.iter();
    let attitudes = |given: &&Given| given.1.log().is_some_and(|l| l.attitude_source.is_some());
    let is_on_gps_time = |given: &Given| {
        let trajectory = &given.1.trajectory;
        trajectory.time_origin().gps_time().is_some() && trajectory.frame().enu().is_some()
    };
    let with: Vec<&Given> = all().filter(attitudes).collect();
    let others: Vec<&Given> = all().filter(|given| !attitudes(given)).collect();
    match (with.as_slice(), others.as_slice()) {
        ([(path, file)], others)
            if is_on_gps_time(with[0])
                && (has_receivers && others.is_empty()
                    || matches!(others, [one] if is_on_gps_time(one))) =>
        {
            (file.log().map(|log| (path.as_path(), log)), others.to_vec())
        }
        _ => (None, all().collect()),
    }
}

/// The keys found so far.
struct Campaign<'a> {
    folder: &'a Path,
    /// Whether a recorded clock is next to the radar log.
    has_clock: bool,
    /// Whether the files follow lines, each of which may have its own ends.
    has_lines: bool,
    filled: Vec<Filled>,
    /// Settings that the logs do not state and the image depends on.
    questions: Vec<String>,
}

impl Campaign<'_> {
    fn with_trajectory(
        &mut self,
        radar: &RadarInput,
        path: &Path,
        file: &TrajectoryFile,
    ) -> anyhow::Result<()> {
        let trajectory = &file.trajectory;
        let (start_s, end_s) = (trajectory.start_s(), trajectory.end_s());
        let is_by_number = trajectory.time_origin() == TimeOrigin::TraceNumbers;
        let span = if is_by_number {
            format!("of traces {start_s:.0} to {end_s:.0}")
        } else {
            format!("from {start_s:.1} to {end_s:.1} s")
        };
        let name = quoted(&named_in(self.folder, path)?);
        self.filled
            .push(Filled::new("trajectory.file", name).because(format!(
                "{} positions {span}, {:.1} m of path",
                trajectory.fixes().len(),
                trajectory.path_length_m()
            )));
        if let Some(log) = file.log() {
            let of_kind = log.sources.iter().filter(|s| s.kind == log.source.kind);
            let mut source = if of_kind.count() > 1 {
                Filled::new("trajectory.source", quoted(&log.source.name))
                    .because(log.sources_used())
            } else {
                Filled::remark("trajectory.source", log.sources_used())
            };
            for remark in file.remarks() {
                source = source.because(remark);
            }
            self.filled.push(source);
            self.filled.extend(gimbal_remark(log));
        }
        match radar.time_s {
            _ if is_by_number => {}
            Some([first, last]) if first < end_s && last > start_s => {
                self.filled.push(Filled::remark(
                    "trajectory.time_offset_s",
                    format!("the radar's times {first:.1} to {last:.1} s lie in the trajectory's"),
                ));
            }
            _ => self.offset_unknown(trajectory.time_origin().gps_time().is_some()),
        }
        if let Some(frame) = trajectory.frame().enu() {
            let origin = frame.origin();
            self.filled.push(Filled::remark(
                "trajectory.origin_deg_m",
                format!(
                    "the trajectory counts from {:.8}°, {:.8}°, {:.2} m",
                    origin.latitude_deg(),
                    origin.longitude_deg(),
                    origin.height_m
                ),
            ));
        }
        let (low, high) = trajectory.bounds_m();
        self.extent([low, high]);
        Ok(())
    }

    /// Places where the echoes of a side-looking radar focus, and the quantities that they leave open.
    fn with_look(
        &mut self,
        radargram: &Radargram,
        file: &TrajectoryFile,
        time_s: Option<[f64; 2]>,
    ) -> anyhow::Result<()> {
        let trajectory = &file.trajectory;
        let is_same_clock = time_s
            .is_some_and(|[first, last]| first < trajectory.end_s() && last > trajectory.start_s());
        let bar = Bar::default();
        let control = Control::default()
            .reporting_to(&bar)
            .cancelled_by(cancel_flag());
        let stated_s = is_same_clock.then_some(0.0);
        let seen = look(radargram, trajectory, stated_s, &control);
        bar.clear();
        let seen = match seen {
            Err(LookError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => {
                self.questions.push(format!(
                    "[image]: does the radar look down or to the side, and at what height is the scene? The \
                     echoes could not be examined ({error}); the defaults suit a radar that looks down"
                ));
                return Ok(());
            }
            Ok(seen) => seen,
        };
        let answers = Answers::of(&seen);
        self.filled.extend(answers.filled);
        self.questions.extend(answers.questions);
        Ok(())
    }

    /// A line of the length that the file counts, along x, and the vertical section below it.
    fn with_line(&mut self, radar: &RadarInput) {
        let ground = OnGround::of(&[radar], radar.band_ghz);
        self.questions.push(format!(
            "[radar] line_start_m, line_end_m: where do the first and the last trace lie (x, y, and the height of the \
             antennas z, in m)? {}{}",
            way_said(&[radar]),
            soil_question(ground.as_ref())
        ));
        self.with_direct_wave(&[radar], ground.as_ref());
        let z_m = ground.as_ref().map_or(0.0, |_| ANTENNA_HEIGHT_M);
        self.filled
            .extend(ground.iter().flat_map(OnGround::below_lines));
        let Some(way_m) = radar.way_m else {
            let asked = ["radar.line_start_m", "radar.line_end_m"];
            let unknown = way_said(&[radar]);
            self.filled
                .extend(asked.map(|key| Filled::remark(key, &unknown)));
            return;
        };
        self.filled.push(
            Filled::new("radar.line_start_m", format!("[0.0, 0.0, {z_m:?}]")).because(
                "the file gives the distance along its line, not the position of the line: state both ends",
            ),
        );
        self.filled.push(
            Filled::new("radar.line_end_m", format!("[{way_m:.3}, 0.0, {z_m:?}]"))
                .because(format!("{way_m:.3} m from the first trace to the last")),
        );
        if ground.is_some() {
            let along = Filled::new("image.x_m", format!("[0.0, {way_m:.3}]"));
            let across = Filled::new("image.y_m", "[0.0, 0.0]");
            let section = "the vertical section below the line";
            (self.filled).extend([along.because(section), across.because(section)]);
        }
    }

    /// The ground below traces that the files place: keys where the files give no heights, a question where these are on
    /// the Earth.
    fn below_places(&mut self, radar: &[&RadarInput], ground: Option<&OnGround>) {
        let is_on_earth =
            |log: &&RadarInput| log.sounding.is_some_and(|s| s.heights == Heights::OnEarth);
        if radar.iter().any(is_on_earth) {
            self.questions.push(
                "[image] z_m: was the radar flown, or on the ground? In flight the surface echo gives the height of the \
                 ground; where it is not seen, state z_m, counted from the first trace. Antennas on the ground have \
                 a height above it of centimetres, which positions by satellite do not give: state [ground], and \
                 places by [radar] line_start_m and line_end_m or by a [trajectory] table with a column trace"
                    .to_owned(),
            );
        }
        let Some(ground) = ground else {
            return;
        };
        self.questions.push(format!(
            "[ground] relative_permittivity, surface_z_m: {}",
            ground.question()
        ));
        self.with_direct_wave(radar, Some(ground));
        self.filled.extend(ground.below_places());
    }

    /// The direct wave gives the time of range zero on the ground, where the surface shows no echo of its own; the distance
    /// of the antennas is asked for where the files do not state it.
    fn with_direct_wave(&mut self, radar: &[&RadarInput], ground: Option<&OnGround>) {
        if ground.is_none() || radar.iter().any(|log| log.antenna_separation_m.is_some()) {
            return;
        }
        self.filled.push(
            Filled::new("preprocess.zero_timing", "\"direct-wave\"").because(
                "on the ground the echo of the surface and the direct wave arrive together",
            ),
        );
        if radar
            .iter()
            .all(|log| log.sounding.is_some_and(|s| s.has_antennas))
        {
            return;
        }
        self.questions.push(
            "[radar] antenna_offset_m: how far is the transmitter in front of the receiver (forward, left, up, in m)? \
             The direct wave between them gives the time of range zero; where the record begins after it, state \
             [radar] delay_ns and remove zero_timing"
                .to_owned(),
        );
        self.filled.push(Filled::remark(
            "radar.antenna_offset_m",
            "the file states no distance between transmitter and receiver",
        ));
    }

    fn with_attitudes(&mut self, path: &Path, log: &LogReport) -> anyhow::Result<()> {
        let name = quoted(&named_in(self.folder, path)?);
        self.filled.push(
            Filled::new("trajectory.attitude_file", name).because(format!(
                "{}; the log's own positions, of {}, are not used",
                log.attitudes_used(),
                log.source.name
            )),
        );
        if log.attitude_sources.len() > 1
            && let Some(source) = &log.attitude_source
        {
            self.filled
                .push(Filled::new("trajectory.attitude_source", quoted(source)));
        }
        self.filled.extend(gimbal_remark(log));
        Ok(())
    }

    fn with_receivers(&mut self, logs: &Logs, pair: &Pair<'_>) -> anyhow::Result<()> {
        ensure!(
            !logs.navigation.ephemerides.is_empty(),
            "no navigation data among the files: give a navigation file of the day (RINEX), or UBX \
             logs with RXM-SFRB or RXM-SFRBX"
        );
        let [rover, base] = [&pair.rover, &pair.base];
        let overlap_s = rover.overlap_s(base);
        self.filled.push(
            Filled::new("gnss.rover", quoted(&named_in(self.folder, rover.path)?))
                .because(format!(
                    "{} epochs from {} to {}",
                    rover.epochs, rover.span[0], rover.span[1]
                ))
                .because(format!("the rover: {}", pair.reason)),
        );
        let mut base_key = Filled::new("gnss.base", quoted(&named_in(self.folder, base.path)?))
            .because(format!(
                "{} epochs from {} to {}, {overlap_s:.0} s of them the rover's",
                base.epochs, base.span[0], base.span[1]
            ));
        for unused in &pair.unused {
            base_key = base_key.because(format!("not used: {unused}"));
        }
        self.filled.push(base_key);
        if !logs.navigation_files.is_empty() {
            let files: Vec<String> = logs
                .navigation_files
                .iter()
                .map(|path| Ok(quoted(&named_in(self.folder, path)?)))
                .collect::<anyhow::Result<_>>()?;
            self.filled.push(Filled::new(
                "gnss.navigation",
                format!("[{}]", files.join(", ")),
            ));
        }
        self.filled
            .push(match (base.header_ecef_m, pair.base_deg_m()) {
                (None, Some([latitude, longitude, height])) => Filled::new(
                    "gnss.base_deg_m",
                    format!("[{latitude:.9}, {longitude:.9}, {height:.3}]"),
                )
                .because(pair.says_base()),
                _ => Filled::remark("gnss.base_deg_m", pair.says_base()),
            });
        self.filled.push(Filled::remark(
            "trajectory.origin_deg_m",
            "positions count from the base's antenna unless this states otherwise",
        ));
        self.offset_unknown(true);
        if let Some(bounds_m) = pair.rover_bounds_m() {
            self.extent(bounds_m);
        }
        Ok(())
    }

    /// Leaves the offset to the recorded clock, where there is one and positions are on GPS time, or else to
    /// the data.
    fn offset_unknown(&mut self, is_on_gps_time: bool) {
        if self.has_clock && is_on_gps_time {
            self.filled.push(Filled::remark(
                "trajectory.time_offset_s",
                "left out: the clock recorded with the radar log gives it",
            ));
            return;
        }
        self.filled
            .push(Filled::new("trajectory.time_offset_s", "\"auto\"").because(
                "the radar's clock is not GPS time: the offset is found from the data; state it where it is \
                 known",
            ));
    }

    /// The surroundings of the track that the default gate lets in, where the campaign must state
    /// its image.
    fn extent(&mut self, [low, high]: [[f64; 3]; 2]) {
        let is_needed = SettingsFile::Campaign
            .tables()
            .iter()
            .filter(|table| table.path == "image")
            .flat_map(|table| &table.keys)
            .any(|key| key.name == "x_m" && key.required);
        if !is_needed {
            return;
        }
        let height_m = high[2] - low[2];
        let beside_m = ((height_m + GATED_M).powi(2) - height_m * height_m).sqrt();
        for (key, k) in [("image.x_m", 0), ("image.y_m", 1)] {
            let from = (low[k] - beside_m).floor();
            let to = (high[k] + beside_m).ceil();
            self.filled.push(
                Filled::new(key, format!("[{from:.1}, {to:.1}]"))
                    .because("the surroundings of the track: choose the area of interest"),
            );
        }
    }

    fn text(self) -> String {
        let questions = self.questions.iter().map(|q| format!("QUESTION: {q}\n"));
        let head = questions.collect::<String>()
            + "Campaign written by acerra init: acerra focus THIS-FILE";
        let mut tables = SettingsFile::Campaign.tables();
        // One radar's logs make one track.
        tables.retain(|table| {
            let path = table.path.as_str();
            path != "tracks" && path != "track" && !path.starts_with("track.")
        });
        if !self.has_lines {
            tables.retain(|table| table.path != "radar.lines");
        }
        write_first(&head, &tables, &self.filled, FIRST_KEYS)
    }
}

/// Remark on the gimbals of a log. A topic of an MCAP file does not state that it is one.
fn gimbal_remark(log: &LogReport) -> Option<Filled> {
    let gimbals = log.gimbal_sources.iter().filter(|g| g.attitudes > 0);
    let gimbals: Vec<String> = gimbals
        .map(|g| format!("{} ({} attitudes)", g.name, g.attitudes))
        .collect();
    let is_said = log.format != LogFormat::Mcap && !gimbals.is_empty();
    is_said.then(|| {
        let found = format!(
            "the log holds attitudes of a gimbal, {}: an antenna on it looks along \"gimbal\" or \"gimbal-forward\"",
            gimbals.join(", ")
        );
        Filled::remark("image.antenna_axis", found)
    })
}
