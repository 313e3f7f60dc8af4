//! The tables of a campaign file.

use std::path::{Path, PathBuf};

use acerra_imaging::IncidenceWeight;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use crate::choices::{
    AntennaAxis, Background, CalibrationSource, Contradictions, Delay, Gate, GroundSurface,
    HeightDatum, HeightSource, Heights, LookTaper, Permittivity, ProductFormat, Select, Sum,
    TimeOffset, Unfixed, Values, Weight, ZeroTiming,
};
use crate::focus::inversion::options::{InversionSection, Method};
use crate::prepare::Track;
use crate::read::grid::{GridLayout, GridSource};
use crate::read::{Line, path_text};

/// `[radar]`: the log, and which of its traces are used.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RadarSection {
    /// The radar log; its format is recognised from its content.
    #[serde(
        default,
        serialize_with = "path_text::path",
        skip_serializing_if = "is_empty"
    )]
    pub file: PathBuf,
    /// Several files over one area instead, imaged together: a list, or names with `*` and `?` for any characters. They
    /// follow one another by the numbers in their names. Where the files do not place their traces, `line_start_m`,
    /// `line_end_m` and `line_step_m` or `lines` do.
    #[serde(
        default,
        serialize_with = "Files::serialize_one_or_list",
        skip_serializing_if = "Files::is_empty"
    )]
    pub files: Files,
    /// The channel of a file that has several: of phase history data (CPHD; by default its reference channel), an
    /// antenna, a receiver and component of a model (`"rx1/Ez"`), a scattering parameter (`"S21"`); by default the
    /// first.
    #[serde(default)]
    pub channel: Option<String>,
    /// Place of the first trace (x, y, z in m), where traces were recorded along a line; with `line_end_m`. Between them
    /// traces lie where the file's odometer says, else evenly spaced.
    #[serde(default)]
    pub line_start_m: Option<[f64; 3]>,
    /// Place of the last trace (x, y, z in m).
    #[serde(default)]
    pub line_end_m: Option<[f64; 3]>,
    /// Vector from each of several parallel lines to the next (x, y, z in m); `line_start_m` and `line_end_m`
    /// are the ends of the first line.
    #[serde(default)]
    pub line_step_m: Option<[f64; 3]>,
    /// The line of each file, where they are not evenly spaced: `{ file, start_m, end_m }`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<LineSection>,
    /// Vector from the receiver to the transmitter where they are apart: forward, left, up, in metres;
    /// positions are those of the midpoint. Forward is the nose by the recorded attitude, or the direction of
    /// the line. By default as the file states.
    #[serde(default)]
    pub antenna_offset_m: Option<[f64; 3]>,
    /// Fast time at which range is zero, in nanoseconds, when calibrated; `"auto"` finds the one at
    /// which the echoes of points add up best.
    #[serde(default)]
    pub delay_ns: Option<Delay>,
    /// The traces that enter background and image. By default the traces during which the platform moves,
    /// where it is at rest for a tenth of the time or more, else all.
    #[serde(default)]
    pub select: Select,
}

impl RadarSection {
    /// Whether the campaign states no such table.
    #[must_use]
    pub fn is_absent(&self) -> bool {
        is_empty(&self.file) && self.files.is_empty()
    }

    /// The log, or the first name of several, for messages.
    #[must_use]
    pub fn first_file(&self) -> &Path {
        self.files.0.first().unwrap_or(&self.file)
    }

    /// The files of a grid, where there are several.
    #[must_use]
    pub fn grid(&self) -> Option<GridSource> {
        if self.files.is_empty() {
            return None;
        }
        let layout = match (self.line(), self.lines.as_slice()) {
            (Some(first), _) => GridLayout::Regular {
                first,
                step_m: self.line_step_m.unwrap_or_default(),
            },
            (None, []) => GridLayout::InFiles,
            (None, rows) => GridLayout::Table(rows.iter().map(LineSection::placed).collect()),
        };
        Some(GridSource {
            patterns: self.files.0.clone(),
            layout,
        })
    }

    /// The paths in it.
    pub(super) fn files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let one = Some(&mut self.file).filter(|file| !is_empty(file));
        let rows = self.lines.iter_mut().map(|row| &mut row.file);
        one.into_iter().chain(self.files.0.iter_mut()).chain(rows)
    }

    /// The line along which traces were recorded, where both ends are stated.
    #[must_use]
    pub fn line(&self) -> Option<Line> {
        Some(Line {
            start_m: self.line_start_m?,
            end_m: self.line_end_m?,
        })
    }

    /// Fills in the values found from the data.
    pub(super) fn settle(&mut self, track: &Track) {
        if self.is_absent() {
            return;
        }
        if let (Some(Delay::Auto), Some(found)) = (self.delay_ns, &track.delay) {
            self.delay_ns = Some(Delay::Nanoseconds(1e9 * found.delay_s));
        }
        if self.select == Select::Auto {
            self.select = track.selected();
        }
    }
}

fn is_empty(path: &Path) -> bool {
    path.as_os_str().is_empty()
}

/// A row of `[radar] lines`.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LineSection {
    /// One of the files.
    #[serde(serialize_with = "path_text::path")]
    pub file: PathBuf,
    /// Place of its first trace (x, y, z in m).
    pub start_m: [f64; 3],
    /// Place of its last trace (x, y, z in m).
    pub end_m: [f64; 3],
}

impl LineSection {
    fn placed(&self) -> (PathBuf, Line) {
        let line = Line {
            start_m: self.start_m,
            end_m: self.end_m,
        };
        (self.file.clone(), line)
    }
}

/// `[[track]]`: one of several flights that make one image.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TrackSection {
    /// Name in the report; by default its number.
    #[serde(default)]
    pub name: Option<String>,
    /// Its radar log.
    #[serde(default)]
    pub radar: RadarSection,
    /// Raw GNSS logs to compute its trajectory from.
    #[serde(default)]
    pub gnss: Option<GnssSection>,
    /// Its trajectory.
    #[serde(default)]
    pub trajectory: TrajectorySection,
    /// From raw traces to clean spectra; the campaign's `[preprocess]` by default.
    #[serde(default)]
    pub preprocess: Option<PreprocessSection>,
    /// Delay of this track's instrument relative to the other tracks', in nanoseconds; removed from the data.
    #[serde(default)]
    pub delay_ns: f64,
    /// Phase that it adds, in degrees; taken off.
    #[serde(default)]
    pub phase_deg: f64,
}

/// `[checks]`: treatment of a run that its own evidence contradicts.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChecksSection {
    /// Whether contradictions make the run fail.
    pub contradictions: Contradictions,
}

/// `[products]`: files for other programs.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProductsSection {
    /// Formats that are written. Georeferenced formats need positions on the Earth; without them, GeoTIFFs
    /// are written in the local frame with a world file, and KMZ, GeoJSON and CPHD are left out.
    pub formats: Vec<ProductFormat>,
    /// Coordinates of the GeoTIFFs, by their code in the EPSG registry; by default the UTM zone of the
    /// image on WGS84.
    pub epsg: Option<u32>,
}

impl Default for ProductsSection {
    fn default() -> Self {
        Self {
            formats: vec![
                ProductFormat::Geotiff,
                ProductFormat::Kmz,
                ProductFormat::Geojson,
            ],
            epsg: None,
        }
    }
}

/// `[tracks]`: how several tracks become one image.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TracksSection {
    /// What is summed.
    pub sum: Sum,
    /// Where delay and phase of each track come from.
    pub calibration: CalibrationSource,
    /// Largest delay that is searched, to either side, in nanoseconds.
    pub window_ns: f64,
    /// Position of the target that all tracks see, in metres; by default the maximum of the first track's
    /// image on which the others agree.
    pub target_m: Option<[f64; 3]>,
}

impl Default for TracksSection {
    fn default() -> Self {
        Self {
            sum: Sum::Coherent,
            calibration: CalibrationSource::Given,
            window_ns: 3.0,
            target_m: None,
        }
    }
}

/// `[trajectory]`: positions of the radar, and the relation of its clock to theirs.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrajectorySection {
    /// The trajectory; absent when `[gnss]` or the radar file gives the positions.
    #[serde(serialize_with = "path_text::optional")]
    pub file: Option<PathBuf>,
    /// Trajectory time minus radar time. By default that of the clock recorded with the radar log, where
    /// there is one and the positions are on GPS time; otherwise 0.
    pub time_offset_s: Option<TimeOffset>,
    /// Radar phase centre from the positioned point: forward, left, up (metres).
    pub lever_arm_m: [f64; 3],
    /// Origin of the local east-north-up frame: latitude and longitude in degrees, ellipsoidal
    /// height in metres. By default the file's own origin, or its first position.
    pub origin_deg_m: Option<[f64; 3]>,
    /// Rigid body to take from a motion-capture export that holds several.
    pub rigid_body: Option<String>,
    /// Source of the positions in the log of an autopilot or a robot: `"gnss"` (the receiver's, the
    /// default), `"ekf"` (the autopilot's own estimate), or one by its name as `acerra info` lists it, such as
    /// `"GPS[1]"` or a topic.
    pub source: Option<String>,
    /// Log of an autopilot or a robot whose attitudes turn the lever arm and the antenna at the positions of `[gnss]`
    /// or of another `file`, by GPS time; by default those that come with the positions.
    #[serde(serialize_with = "path_text::optional")]
    pub attitude_file: Option<PathBuf>,
    /// Source of the attitudes in such a log, by its name; by default the only one.
    pub attitude_source: Option<String>,
    /// Source of the attitudes of the gimbal that carries the antenna, by its name in such a log, for `[image]
    /// antenna_axis = "gimbal"`; by default the only one. Of an MCAP file a topic, which must be named.
    pub gimbal_source: Option<String>,
    /// Longest gap between positions that is interpolated over, in seconds; by default a few
    /// sampling intervals.
    pub max_gap_s: Option<f64>,
    /// Source of the heights: the positions, or the radar's own surface echo over level ground (`"radar"`),
    /// where the positions' heights are poor.
    pub height: HeightSource,
    /// Vertical datum of the heights of a table (CSV), where its header states none.
    pub height_datum: Option<HeightDatum>,
    /// Traces at unfixed positions: kept (with a warning) or dropped.
    pub unfixed: Unfixed,
}

/// `[gnss]`: positions are computed from raw GNSS logs by carrier-phase differential positioning.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GnssSection {
    /// The flying receiver's log: RINEX, Hatanaka, UBX, gzipped or not; a list of files is joined.
    #[serde(serialize_with = "Files::serialize_one_or_list")]
    pub rover: Files,
    /// The log of the receiver on the ground; a list, such as hourly files, is joined.
    #[serde(serialize_with = "Files::serialize_one_or_list")]
    pub base: Files,
    /// Navigation files; raw logs hold their own.
    #[serde(default)]
    pub navigation: Files,
    /// RTKLIB configuration (`.conf`) with the options of the positioning.
    #[serde(default, serialize_with = "path_text::optional")]
    pub config: Option<PathBuf>,
    /// Position of the base's antenna, Earth-centred (m). By default as its log states.
    #[serde(default)]
    pub base_ecef_m: Option<[f64; 3]>,
    /// Position of the base's antenna as latitude and longitude in degrees and ellipsoidal height in metres, instead of
    /// `base_ecef_m`.
    #[serde(default)]
    pub base_deg_m: Option<[f64; 3]>,
}

/// One file or several.
#[derive(Clone, Debug, Default, JsonSchema, Serialize, PartialEq, Eq)]
pub struct Files(
    #[serde(serialize_with = "path_text::list")]
    #[schemars(with = "OneOrSeveral")]
    pub Vec<PathBuf>,
);

/// The two forms of [`Files`] in a campaign file.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "defines the schema")]
enum OneOrSeveral {
    /// One file.
    One(PathBuf),
    /// Several files.
    Several(Vec<PathBuf>),
}

impl Files {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A single file is written as such.
    fn serialize_one_or_list<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] => path_text::path(one, serializer),
            several => path_text::list(several, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Files {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let path = |value: &toml::Value| value.as_str().map(PathBuf::from);
        let value = toml::Value::deserialize(deserializer)?;
        let files = match &value {
            toml::Value::Array(list) => list.iter().map(path).collect(),
            one => path(one).map(|one| vec![one]),
        };
        files.map(Self).ok_or_else(|| {
            D::Error::custom(format!("expected a file or a list of files; found {value}"))
        })
    }
}

/// `[preprocess]`: from raw traces to clean spectra.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PreprocessSection {
    /// The running mean over a window of fast time, in nanoseconds, is taken off every trace ("dewow"): one or two periods
    /// of the antenna's frequency. First of all steps; off by default.
    pub dewow_ns: Option<f64>,
    /// Lowest and highest frequency, in gigahertz, that are kept of every trace: unchanged within the band,
    /// tapered to zero over a fifth of its width outside, without delay. Applied before zero-timing; off by
    /// default.
    pub band_pass_ghz: Option<[f64; 2]>,
    /// How the fast time at which range is zero is found. By default the paper's
    /// `"first-trace"`, or `"none"` where `[radar] delay_ns` is given.
    pub zero_timing: Option<ZeroTiming>,
    /// What is subtracted from every trace. By default the mean of the traces, or with `[ground]` the mean and the echo
    /// of the surface, `"surface"`.
    pub background: Option<Background>,
    /// The part of each trace that is kept. By default 6 ns before 2h/c to 24 ns after it, or all of
    /// it where the image lies to the side of the flight, or below ground with `[ground]`.
    pub gate_ns: Gate,
}

/// `[image]`: band, grid, accuracy and weight of the image.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSection {
    /// Lowest and highest frequency, in gigahertz.
    #[serde(default = "default_band_ghz")]
    pub band_ghz: [f64; 2],
    /// Number of evenly spaced frequencies over the band.
    #[serde(default = "default_frequencies")]
    pub frequencies: usize,
    /// First and last pixel centre to the east, in metres; by default the flight's surroundings as
    /// far as the gate lets in.
    #[serde(default)]
    pub x_m: Option<[f64; 2]>,
    /// First and last pixel centre to the north, in metres; by default as for `x_m`.
    #[serde(default)]
    pub y_m: Option<[f64; 2]>,
    /// Height of the image plane, in metres; by default 0 where `origin_deg_m` is stated or positions
    /// are local, else the ground as the radar sees it. `[from, to]` asks for a volume.
    #[serde(default)]
    pub z_m: Option<Heights>,
    /// Distance of a volume's slices, in metres; the side of a pixel by default.
    #[serde(default)]
    pub pixel_z_m: Option<f64>,
    /// Height of the ground in a volume, from which 2h/c counts, in metres; by default the height of
    /// the volume nearest to 0.
    #[serde(default)]
    pub ground_z_m: Option<f64>,
    /// Heights of the ground, instead of `z_m`: GeoTIFF, ESRI ASCII grid or XYZ grid.
    #[serde(default, serialize_with = "path_text::optional")]
    pub terrain: Option<PathBuf>,
    /// The terrain's coordinates where its file does not say: `"local"` (the default for text
    /// grids) or an EPSG code such as `"EPSG:32633"`.
    #[serde(default)]
    pub terrain_crs: Option<String>,
    /// Added to the terrain's heights to have heights above the ellipsoid, in metres: the geoid's
    /// height there, where the file counts from the sea. With local coordinates simply added.
    #[serde(default)]
    pub geoid_height_m: f64,
    /// Heights of the geoid (EGM96, EGM2008) above the ellipsoid: a grid as NGA, NOAA (`.gtx`), GeographicLib
    /// (`.pgm`) or PROJ (GeoTIFF) distribute it. Targets and maps then also give heights above the sea, and a
    /// terrain whose file states heights above the sea is raised by the geoid.
    #[serde(default)]
    pub geoid: Option<PathBuf>,
    /// Looks along the track: a separate image of each, and the sum of their powers.
    #[serde(default)]
    pub looks: Option<usize>,
    /// Part of its path that a look shares with the next.
    #[serde(default)]
    pub look_overlap: f64,
    /// Taper of each look.
    #[serde(default)]
    pub look_window: LookTaper,
    /// Side of a pixel, in metres.
    #[serde(default = "default_pixel_m")]
    pub pixel_m: f64,
    /// Relative L2 error allowed against Eq. (3) in double precision.
    #[serde(default = "default_accuracy")]
    pub accuracy: f64,
    /// Most memory that tables and image may take, in gigabytes; by default what the machine has left.
    /// Tables that need more are built in batches of pulses.
    #[serde(default)]
    pub memory_gb: Option<f64>,
    /// Method of imaging: the adjoint of Eq. (3), or a solution for the scene. With any method but
    /// `"adjoint"` the image and its widths have another meaning.
    #[serde(default)]
    pub method: Method,
    /// Parameters of `method`, each found by itself unless stated.
    #[serde(default)]
    pub inversion: InversionSection,
    /// Weight of each trace. By default by path where the platform is at rest for a tenth of the time or more, else
    /// equal for all.
    #[serde(default)]
    pub weight: Weight,
    /// Meaning of the pixels; reflectivities require the adjoint on a plane or terrain in air.
    #[serde(default)]
    pub values: Values,
    /// Greatest angle of incidence that counts, in degrees from the vertical; level planes alone.
    #[serde(default)]
    pub max_incidence_deg: Option<f64>,
    /// Width of the soft edge below it, in degrees.
    #[serde(default = "default_incidence_taper_deg")]
    pub incidence_taper_deg: f64,
    /// Weight by the antenna's pattern cosⁿ of the angle from where it looks (`antenna_axis`): the power n, 0
    /// for none; level planes alone.
    #[serde(default)]
    pub antenna_cosine_power: f64,
    /// Where the antenna looks: down in the axes of the platform, tilted with its recorded attitude, straight
    /// down, or where a gimbal of recorded attitude points it. The lever arm turns with the platform in every
    /// case.
    #[serde(default)]
    pub antenna_axis: AntennaAxis,
    /// Propagation speed, in metres a second.
    #[serde(default = "default_light_speed_m_s")]
    pub light_speed_m_s: f64,
}

impl Default for ImageSection {
    fn default() -> Self {
        Self {
            band_ghz: default_band_ghz(),
            frequencies: default_frequencies(),
            x_m: None,
            y_m: None,
            z_m: None,
            pixel_z_m: None,
            ground_z_m: None,
            terrain: None,
            terrain_crs: None,
            geoid_height_m: 0.0,
            geoid: None,
            looks: None,
            look_overlap: 0.0,
            look_window: LookTaper::default(),
            pixel_m: default_pixel_m(),
            accuracy: default_accuracy(),
            memory_gb: None,
            method: Method::default(),
            inversion: InversionSection::default(),
            weight: Weight::default(),
            values: Values::default(),
            max_incidence_deg: None,
            incidence_taper_deg: default_incidence_taper_deg(),
            antenna_cosine_power: 0.0,
            antenna_axis: AntennaAxis::default(),
            light_speed_m_s: default_light_speed_m_s(),
        }
    }
}

impl ImageSection {
    /// Height of the ground under the flight where no terrain gives it, in metres.
    #[must_use]
    pub fn ground_z_m(&self) -> f64 {
        match self.z_m {
            Some(Heights::Range([from, to])) => {
                self.ground_z_m.unwrap_or_else(|| 0.0_f64.clamp(from, to))
            }
            _ => self.base_z_m(),
        }
    }

    /// The weight by incidence and antenna pattern, if any.
    #[must_use]
    pub fn incidence(&self) -> Option<IncidenceWeight> {
        (self.max_incidence_deg.is_some() || self.antenna_cosine_power != 0.0).then(|| {
            IncidenceWeight {
                max_rad: self.max_incidence_deg.unwrap_or(90.0).to_radians(),
                taper_rad: self.incidence_taper_deg.to_radians(),
                cosine_power: self.antenna_cosine_power,
            }
        })
    }

    /// Height of the plane, or of a volume's lowest slice, in metres.
    #[must_use]
    pub fn base_z_m(&self) -> f64 {
        match self.z_m {
            None => 0.0,
            Some(Heights::Plane(z_m) | Heights::Range([z_m, _])) => z_m,
        }
    }
}

/// `[ground]`: media below the surface, where rays are refracted.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GroundSection {
    /// Relative permittivity of a single soil. `"auto"` finds it from the echoes of buried points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_permittivity: Option<Permittivity>,
    /// Its conductivity, in siemens per metre.
    pub conductivity_s_m: f64,
    /// Where the surface lies.
    pub surface: GroundSurface,
    /// Height of a level surface, in metres.
    pub surface_z_m: f64,
    /// Layers from the top instead of one soil.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layer: Vec<GroundLayerSection>,
}

/// `[[ground.layer]]`: a level layer of soil.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GroundLayerSection {
    /// Its thickness, in metres; the last layer has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_m: Option<f64>,
    /// Its relative permittivity.
    pub relative_permittivity: f64,
    /// Its conductivity, in siemens per metre.
    #[serde(default)]
    pub conductivity_s_m: f64,
}

/// `[measure]`: selection of targets.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeasureSection {
    /// Peaks weaker than this, in decibels relative to the strongest, are not listed.
    pub threshold_db: f64,
    /// Largest number of targets listed.
    pub max_targets: usize,
    /// Surveyed points to compare the targets with, one a line as `x_m,y_m,z_m` or
    /// `name,x_m,y_m,z_m`: drawn over the image, with their distances to the nearest target.
    #[serde(serialize_with = "path_text::optional")]
    pub survey: Option<PathBuf>,
}

impl Default for MeasureSection {
    fn default() -> Self {
        Self {
            threshold_db: -12.0,
            max_targets: 50,
            survey: None,
        }
    }
}

fn default_band_ghz() -> [f64; 2] {
    [3.1, 4.8]
}

fn default_frequencies() -> usize {
    341
}

fn default_pixel_m() -> f64 {
    0.01
}

fn default_incidence_taper_deg() -> f64 {
    5.0
}

fn default_accuracy() -> f64 {
    1e-3
}

fn default_light_speed_m_s() -> f64 {
    299_792_458.0
}
