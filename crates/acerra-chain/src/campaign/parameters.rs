//! From the tables of a campaign file to the parameters of the stages.

use std::path::PathBuf;

use acerra_autopilot::GimbalChoice;
use acerra_geo::geodesy::Geodetic;
use acerra_imaging::refraction::{Layer, Soil};

use super::sections::{
    GnssSection, GroundSection, ImageSection, MeasureSection, PreprocessSection, TrajectorySection,
};
use super::{Campaign, TrackSection};
use crate::align::AlignOptions;
use crate::align::calibration::CalibrationOptions;
use crate::align::recording::{InstrumentError, TrackOptions};
use crate::autofocus::AutofocusOptions;
use crate::choices::{Delay, GroundSurface, HeightSource, Heights, Permittivity, TimeOffset};
use crate::clean::{CleanOptions, frequencies_hz};
use crate::focus::inversion::options::InversionOptions;
use crate::focus::looks::LookOptions;
use crate::focus::underground::Underground;
use crate::focus::{FocusOptions, ImageRequest};
use crate::measure::MeasureOptions;
use crate::position::positioning::PositioningInput;
use crate::position::{BasePlace, GnssLogs, PositionOptions, PositionSource};
use crate::prepare::Track;
use crate::scene::pixels::Pixels;
use crate::scene::{SceneHeights, SceneOptions, TerrainSource};
use crate::survey::{Survey, TrackSource};

impl Campaign {
    /// The survey that the campaign describes.
    #[must_use]
    pub fn survey(&self) -> Survey {
        let each = self.each_track();
        let origin = each.first().and_then(|one| one.trajectory.origin());
        let image = &self.image;
        let by_radar = each
            .first()
            .is_some_and(|one| one.trajectory.height == HeightSource::Radar);
        let is_open =
            image.z_m.is_none() && image.terrain.is_none() && origin.is_none() && !by_radar;
        let mut scene = SceneOptions::from(image);
        if is_open {
            scene.heights = SceneHeights::Ground;
        }
        if image.ground_z_m.is_none() {
            scene.surface_z_m = self.ground.as_ref().map(|ground| ground.surface_z_m);
        }
        scene.has_radar_surface =
            (self.ground.as_ref()).is_some_and(|ground| ground.surface == GroundSurface::Radar);
        // Of several tracks the longest gate lets in most.
        let kept = |one: &Campaign| {
            let [_, end_ns] = one.preprocess.gate_ns.about_ns()?;
            Some(1e-9 * end_ns)
        };
        scene.kept_s = each
            .iter()
            .map(kept)
            .try_fold(0.0_f64, |most, end_s| end_s.map(|end_s| most.max(end_s)));
        let open = (self.ground.as_ref())
            .map(Underground::from)
            .filter(|ground| ground.is_open);
        Survey {
            open_ground: open.map(|ground| (ground, FocusOptions::from(&self.image))),
            tracks: each
                .iter()
                .enumerate()
                .map(|(k, one)| one.track_source(self.track.get(k), k))
                .collect(),
            scene: SceneOptions { origin, ..scene },
            calibration: CalibrationOptions {
                source: self.tracks.calibration,
                window_ns: self.tracks.window_ns,
                target_m: self.tracks.target_m,
                weight: self.image.weight,
            },
        }
    }

    /// The image that the campaign asks for, on pixels that its survey found.
    #[must_use]
    pub fn image_request(&self, pixels: Pixels) -> ImageRequest {
        ImageRequest {
            pixels,
            options: FocusOptions {
                sum: self.tracks.sum,
                ..FocusOptions::from(&self.image)
            },
            looks: self.image.look_options(),
            pulses: None,
            underground: self.ground.as_ref().map(Underground::from),
        }
    }

    /// Track `k` of a campaign, which has it alone.
    fn track_source(&self, section: Option<&TrackSection>, k: usize) -> TrackSource {
        let name = section.and_then(|track| track.name.clone());
        TrackSource {
            name: name.unwrap_or_else(|| (k + 1).to_string()),
            radar: self.radar.first_file().to_owned(),
            grid: self.radar.grid(),
            channel: self.radar.channel.clone(),
            line: self.radar.line(),
            positions: PositionOptions {
                source: self.position_source(),
                geoid: self.image.geoid.clone(),
                gimbal: self.gimbal(),
                ..PositionOptions::from(&self.trajectory)
            },
            options: TrackOptions {
                align: AlignOptions {
                    select: self.radar.select,
                    antenna_offset_m: self.radar.antenna_offset_m,
                    delay_ns: self.radar.delay_ns.and_then(Delay::given_ns),
                    ..AlignOptions::from(&self.trajectory)
                },
                clean: self.clean_options(),
                known_error: section.map(InstrumentError::from).unwrap_or_default(),
                recorded_clock: None,
            },
        }
    }

    fn position_source(&self) -> PositionSource {
        match (&self.gnss, &self.trajectory.file) {
            (Some(gnss), _) => PositionSource::Gnss(Box::new(gnss.into())),
            (None, Some(file)) => PositionSource::Trajectory(file.clone()),
            (None, None) => PositionSource::RadarFile,
        }
    }

    /// The gimbal whose attitude the antenna's axis needs.
    fn gimbal(&self) -> GimbalChoice {
        match &self.trajectory.gimbal_source {
            _ if !self.image.antenna_axis.is_gimbal() => GimbalChoice::None,
            None => GimbalChoice::Only,
            Some(name) => GimbalChoice::Named(name.clone()),
        }
    }

    fn clean_options(&self) -> CleanOptions {
        CleanOptions {
            dewow_ns: self.preprocess.dewow_ns,
            band_pass_ghz: self.preprocess.band_pass_ghz,
            delay_ns: self.radar.delay_ns,
            zero_timing: self.zero_timing(),
            surface_delay_s: None,
            background: self.background(),
            gate_ns: self.gate(),
            frequency_hz: frequencies_hz(self.image.band_ghz, self.image.frequencies),
        }
    }
}

fn geodetic([latitude_deg, longitude_deg, height_m]: [f64; 3]) -> Geodetic {
    Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)
}

impl PreprocessSection {
    /// Values found from the data, where the campaign left them open.
    pub(super) fn settle(&mut self, track: &Track) {
        self.gate_ns = track.gate_ns;
        self.background = Some(track.background);
    }
}

impl TrajectorySection {
    /// The paths in it.
    pub(super) fn files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        [&mut self.file, &mut self.attitude_file]
            .into_iter()
            .flatten()
    }

    /// States the offset in force where the campaign states none.
    pub(super) fn settle(&mut self, track: &Track) {
        let taken = match track.recorded_clock {
            Some(_) => TimeOffset::Logged,
            None => TimeOffset::Seconds(track.time_offset_s),
        };
        self.time_offset_s.get_or_insert(taken);
    }

    fn origin(&self) -> Option<Geodetic> {
        self.origin_deg_m.map(geodetic)
    }
}

impl From<&TrajectorySection> for PositionOptions {
    fn from(section: &TrajectorySection) -> Self {
        Self {
            source: PositionSource::default(),
            origin: section.origin(),
            rigid_body: section.rigid_body.clone(),
            log_source: section.source.clone(),
            attitude_file: section.attitude_file.clone(),
            attitude_source: section.attitude_source.clone(),
            gimbal: GimbalChoice::None,
            height_datum: section.height_datum,
            geoid: None,
            lever_arm_m: section.lever_arm_m,
        }
    }
}

impl From<&TrajectorySection> for AlignOptions {
    fn from(section: &TrajectorySection) -> Self {
        Self {
            time_offset: section.time_offset_s,
            max_gap_s: section.max_gap_s,
            height: section.height,
            unfixed: section.unfixed,
            lever_arm_m: section.lever_arm_m,
            ..Self::default()
        }
    }
}

impl From<&GnssSection> for GnssLogs {
    fn from(section: &GnssSection) -> Self {
        let stated = section.base_deg_m.map(geodetic).map(BasePlace::Geodetic);
        let mut rover = section.rover.0.iter().cloned();
        let mut base = section.base.0.iter().cloned();
        Self {
            files: PositioningInput {
                rover: rover.next().unwrap_or_default(),
                more_rover: rover.collect(),
                base: base.next(),
                more_base: base.collect(),
                navigation: section.navigation.0.clone(),
                ..PositioningInput::default()
            },
            config: section.config.clone(),
            base: stated.or(section.base_ecef_m.map(BasePlace::Ecef)),
        }
    }
}

impl From<&TrackSection> for InstrumentError {
    fn from(section: &TrackSection) -> Self {
        Self {
            delay_ns: section.delay_ns,
            phase_deg: section.phase_deg,
        }
    }
}

impl From<&ImageSection> for SceneOptions {
    fn from(section: &ImageSection) -> Self {
        let terrain = section.terrain.as_ref().map(|path| TerrainSource {
            path: path.clone(),
            crs: section.terrain_crs.clone(),
            geoid_height_m: section.geoid_height_m,
            geoid: section.geoid.clone(),
        });
        let (heights, terrain) = match (terrain, section.z_m) {
            (Some(terrain), None) => (SceneHeights::Terrain(terrain), None),
            (terrain, z_m) => (section.level_heights(z_m), terrain),
        };
        Self {
            x_m: section.x_m,
            y_m: section.y_m,
            kept_s: None,
            pixel_m: section.pixel_m,
            heights,
            origin: None,
            surface_z_m: None,
            has_radar_surface: false,
            terrain,
            light_speed_m_s: section.light_speed_m_s,
        }
    }
}

impl ImageSection {
    /// Heights of pixels that are not on a terrain.
    fn level_heights(&self, z_m: Option<Heights>) -> SceneHeights {
        match z_m {
            Some(Heights::Range(z_m)) => SceneHeights::Volume {
                z_m,
                step_m: self.pixel_z_m.unwrap_or(self.pixel_m),
                ground_z_m: self.ground_z_m(),
            },
            _ => SceneHeights::Plane(self.base_z_m()),
        }
    }
}

impl From<&ImageSection> for FocusOptions {
    fn from(section: &ImageSection) -> Self {
        Self {
            accuracy: section.accuracy,
            weight: section.weight,
            values: section.values,
            incidence: section.incidence(),
            antenna_axis: section.antenna_axis,
            memory_limit_bytes: section.memory_gb.map(|gb| (gb * 1e9) as u64),
            inversion: InversionOptions {
                method: section.method,
                parameters: section.inversion,
            },
            ..Self::default()
        }
    }
}

impl ImageSection {
    fn look_options(&self) -> Option<LookOptions> {
        self.looks.map(|count| LookOptions {
            count,
            overlap: self.look_overlap,
            taper: self.look_window,
        })
    }
}

impl Campaign {
    /// Parameters of the autofocus, whether it is enabled or not.
    #[must_use]
    pub fn autofocus_options(&self) -> AutofocusOptions {
        AutofocusOptions {
            sum: self.tracks.sum,
            ..self.autofocus
        }
    }
}

impl From<&GroundSection> for Underground {
    fn from(section: &GroundSection) -> Self {
        let layer = |relative_permittivity, conductivity_s_m, thickness_m: Option<f64>| Layer {
            soil: Soil {
                relative_permittivity,
                conductivity_s_m,
            },
            thickness_m: thickness_m.unwrap_or(f64::INFINITY),
        };
        let layers = section
            .layer
            .iter()
            .map(|l| layer(l.relative_permittivity, l.conductivity_s_m, l.thickness_m));
        let one = section.relative_permittivity.map(|permittivity| {
            // An open permittivity makes no image before it is found.
            let permittivity = permittivity.given().unwrap_or(f64::NAN);
            layer(permittivity, section.conductivity_s_m, None)
        });
        Self {
            surface_z_m: section.surface_z_m,
            is_uneven: section.surface != GroundSurface::Level,
            relief: None,
            is_open: section.relative_permittivity == Some(Permittivity::Auto),
            layers: one.into_iter().chain(layers).collect(),
        }
    }
}

impl From<&MeasureSection> for MeasureOptions {
    fn from(section: &MeasureSection) -> Self {
        Self {
            threshold_db: section.threshold_db,
            max_targets: section.max_targets,
        }
    }
}
