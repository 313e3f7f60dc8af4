//! The ground below the flight, and the pixels on it.

pub(crate) mod elevation;
pub mod pixels;
pub mod size;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::geoid::{GeoidError, GeoidGrid};
use acerra_geo::terrain::{Crs, LocalTerrain, TerrainError, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use acerra_imaging::{ImagingError, PlaneGrid, SPEED_OF_LIGHT_M_S, SurfaceGrid, VolumeGrid};

use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::read::name_of;
use crate::scene::pixels::Pixels;
use crate::scene::size::{bytes_text, fitting_pixel_m, millimetres};

/// The image's rectangle and heights, as stated.
#[derive(Clone, Debug)]
pub struct SceneOptions {
    /// First and last pixel centre to the east (m); by default the flight's surroundings.
    pub x_m: Option<[f64; 2]>,
    /// First and last pixel centre to the north (m); by default the flight's surroundings.
    pub y_m: Option<[f64; 2]>,
    /// Two-way time after the surface echo up to which the data are kept (s); bounds the flight's
    /// surroundings.
    pub kept_s: Option<f64>,
    /// Side of a pixel (m).
    pub pixel_m: f64,
    /// Heights of the pixels.
    pub heights: SceneHeights,
    /// Height of the ground's level surface, where it is not the pixels' (m).
    pub surface_z_m: Option<f64>,
    /// Whether the radar's own first echo gives the surface of the ground.
    pub has_radar_surface: bool,
    /// Terrain of the ground, where the pixels are not on it.
    pub terrain: Option<TerrainSource>,
    /// Origin of the frame for positions that state no origin.
    pub origin: Option<Geodetic>,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Heights of an image's pixels.
#[derive(Clone, Debug)]
pub enum SceneHeights {
    /// A horizontal plane on the ground: at z = 0 of local positions; under positions on the Earth
    /// as the radar sees it.
    Ground,
    /// A horizontal plane at this height (m).
    Plane(f64),
    /// The slices of a volume.
    Volume {
        /// Lowest and highest slice (m).
        z_m: [f64; 2],
        /// Distance of the slices (m).
        step_m: f64,
        /// Height of the ground, from which 2h/c counts (m).
        ground_z_m: f64,
    },
    /// Heights of a terrain raster.
    Terrain(TerrainSource),
}

/// A terrain raster.
#[derive(Clone, Debug)]
pub struct TerrainSource {
    /// The raster.
    pub path: PathBuf,
    /// Coordinates where the file does not say: `"local"` or an EPSG code.
    pub crs: Option<String>,
    /// Added to its heights to have heights above the ellipsoid (m).
    pub geoid_height_m: f64,
    /// Grid of the geoid, whose height is added where the file states heights above the sea.
    pub geoid: Option<PathBuf>,
}

/// Reason why there are no pixels, or no ground.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A rectangle that makes no grid, or a grid too large for memory.
    #[error("[image]: {0}")]
    Grid(ImagingError),
    /// Far more pixels than memory holds.
    #[error(
        "[image] x_m, y_m, pixel_m: {} m × {} m in pixels of {pixel_m} m need {} of memory, more than the \
         {} that an image may have; expected a smaller extent, or pixel_m = {} and more",
        millimetres(extent_m[0]), millimetres(extent_m[1]), bytes_text(*bytes), bytes_text(*limit_bytes),
        fitting_pixel_m(*pixel_m, *bytes, *limit_bytes)
    )]
    TooLarge {
        /// Sides along east and north (m).
        extent_m: [f64; 2],
        /// Side of a pixel (m).
        pixel_m: f64,
        /// Memory that the pixels need.
        bytes: u128,
        /// Memory that an image may have.
        limit_bytes: u128,
    },
    /// A single pixel.
    #[error(
        "[image] x_m, y_m: expected an extent of two pixels or more along x or y, found one pixel of {pixel_m} m: \
         x_m = [{}, {}], y_m = [{}, {}]",
        x_m[0], x_m[1], y_m[0], y_m[1]
    )]
    OnePixel {
        /// First and last pixel centre along east (m).
        x_m: [f64; 2],
        /// First and last pixel centre along north (m).
        y_m: [f64; 2],
        /// Side of a pixel (m).
        pixel_m: f64,
    },
    /// Sides left to the flight, of terrain or a volume.
    #[error(
        "[image] x_m, y_m: expected [from, to], as terrain and volumes do not follow the flight"
    )]
    OpenSides,
    /// Far too many slices.
    #[error("[image] z_m: {slices:.0} slices of {step_m} m are more than ten million")]
    Slices {
        /// Slices asked for.
        slices: f64,
        /// Distance of the slices (m).
        step_m: f64,
    },
    /// Heights that make no volume.
    #[error("[image] z_m: {0}")]
    Volume(ImagingError),
    /// The operating system does not open the terrain.
    #[error("{}: {cause}", path.display())]
    Open {
        /// The raster.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The name of the terrain's coordinates is unknown.
    #[error("{}: [image] terrain_crs: {cause}", path.display())]
    Coordinates {
        /// The raster.
        path: PathBuf,
        /// Cause.
        cause: TerrainError,
    },
    /// The terrain cannot be read.
    #[error("{}: {cause}", path.display())]
    Terrain {
        /// The raster.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: TerrainError,
    },
    /// The terrain has no height under a part of the image.
    #[error("{} under the image: {cause}", path.display())]
    UnderImage {
        /// The raster.
        path: PathBuf,
        /// Where.
        cause: TerrainError,
    },
    /// The grid of the geoid cannot be read.
    #[error("[image] geoid: {0}")]
    Geoid(#[from] GeoidError),
    /// The grid of the geoid does not cover the flight.
    #[error(
        "[image] geoid: expected a grid that covers {latitude_deg:.4}°, {longitude_deg:.4}°, found \
         none of its heights there"
    )]
    BeyondGeoid {
        /// Latitude of the frame's origin (degrees).
        latitude_deg: f64,
        /// Longitude (degrees).
        longitude_deg: f64,
    },
    /// Heights that make no surface.
    #[error(transparent)]
    Surface(#[from] ImagingError),
}

impl SceneError {
    /// Reason why the rectangle in pixels of `pixel_m` makes no grid.
    fn of_grid(error: ImagingError, x_m: [f64; 2], y_m: [f64; 2], pixel_m: f64) -> Self {
        match error {
            ImagingError::TooLarge {
                bytes, limit_bytes, ..
            } => Self::TooLarge {
                extent_m: [x_m[1] - x_m[0], y_m[1] - y_m[0]],
                pixel_m,
                bytes,
                limit_bytes,
            },
            other => Self::Grid(other),
        }
    }
}

/// Height of the ground under a flight.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Height where no terrain gives one (m).
    level_m: f64,
    /// The terrain under the image.
    near: Option<Arc<SurfaceGrid>>,
    /// The terrain under the flight as well, where its file reaches so far.
    wide: Option<LocalTerrain>,
}

impl Ground {
    /// Level ground.
    #[must_use]
    pub fn level(z_m: f64) -> Self {
        Self {
            level_m: z_m,
            near: None,
            wide: None,
        }
    }

    /// Uneven ground, level beyond the edges of the surface.
    #[must_use]
    pub fn surface(surface: Arc<SurfaceGrid>) -> Self {
        Self {
            level_m: surface.base().z_m,
            near: Some(surface),
            wide: None,
        }
    }

    /// Height of the ground at (x, y), m: of the terrain where there is one, else level.
    #[must_use]
    pub fn below_m(&self, x_m: f64, y_m: f64) -> f64 {
        let wide = self.wide.as_ref();
        match (&self.near, wide.map(|w| w.height_m(x_m, y_m))) {
            (Some(_), Some(Ok(z_m))) => z_m,
            (Some(surface), _) => surface.height_m(x_m, y_m),
            (None, _) => self.level_m,
        }
    }

    /// Whether a terrain gives the heights.
    #[must_use]
    pub fn is_uneven(&self) -> bool {
        self.near.is_some()
    }
}

/// The pixels of an image, and the ground below the flight.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The pixels.
    pub pixels: Pixels,
    /// The ground.
    pub ground: Ground,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
    /// Quantities still to be found from the data.
    pub open: OpenChoices,
}

/// Quantities of a scene that are found from the data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenChoices {
    /// The height of the ground.
    pub ground: bool,
    /// The uneven surface of the ground, about the level that is stated.
    pub surface: bool,
    /// The image's sides along east and north.
    pub sides: [bool; 2],
    /// Two-way time after the surface echo up to which the data are kept (s).
    pub kept_s: Option<f64>,
    /// Side of a pixel, where sides are open (m).
    pub pixel_m: f64,
}

/// Distance to the side of the track that an image reaches whose data are kept without a bound: the height of
/// the flight.
const OPEN_SWATH_HEIGHTS: f64 = 1.0;

impl Scene {
    /// This scene over level ground at the height `z_m`.
    #[must_use]
    pub fn on_ground(&self, z_m: f64) -> Self {
        let mut scene = self.clone();
        scene.pixels.grid.z_m = z_m;
        scene.ground = Ground::level(z_m);
        scene
    }

    /// These pixels over level ground at `z_m`.
    #[must_use]
    pub fn on_level(self, z_m: f64) -> Self {
        Self {
            ground: Ground::level(z_m),
            ..self
        }
    }

    /// These pixels over uneven ground.
    #[must_use]
    pub fn over(self, surface: SurfaceGrid) -> Self {
        Self {
            ground: Ground::surface(Arc::new(surface)),
            ..self
        }
    }

    /// The image's rectangle on the plane at `z_m`, the sides that are open fitted to the traces at
    /// `position_m`: their surroundings as far as the data are kept.
    ///
    /// # Errors
    /// More pixels than can be held.
    pub fn around(&self, position_m: &[[f64; 3]], z_m: f64) -> Result<PlaneGrid, ImagingError> {
        let own = &self.pixels.grid;
        let stated = [
            [own.x0_m, own.x_m(own.nx - 1)],
            [own.y0_m, own.y_m(own.ny - 1)],
        ];
        let mut heights_m: Vec<f64> = position_m.iter().map(|p| p[2] - z_m).collect();
        heights_m.sort_by(f64::total_cmp);
        let height_m = heights_m
            .get(heights_m.len() / 2)
            .copied()
            .unwrap_or(1.0)
            .max(0.1);
        let swath_m = match self.open.kept_s {
            Some(kept_s) => {
                let range_m = height_m + 0.5 * self.light_speed_m_s * kept_s;
                (range_m * range_m - height_m * height_m).sqrt()
            }
            None => OPEN_SWATH_HEIGHTS * height_m,
        };
        let side = |axis: usize| {
            if !self.open.sides[axis] {
                return stated[axis];
            }
            let along = position_m.iter().map(|p| p[axis]);
            let low = along.clone().fold(f64::INFINITY, f64::min);
            let high = along.fold(f64::NEG_INFINITY, f64::max);
            [(low - swath_m).floor(), (high + swath_m).ceil()]
        };
        let pixel_m = if self.open.sides == [false; 2] {
            own.pixel_m
        } else {
            self.open.pixel_m
        };
        PlaneGrid::from_ranges(side(0), side(1), z_m, pixel_m)
    }
    /// A horizontal plane that is also the ground, in vacuum.
    #[must_use]
    pub fn plane(grid: PlaneGrid) -> Self {
        Self {
            pixels: Pixels::plane(grid),
            ground: Ground::level(grid.z_m),
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
            open: OpenChoices::default(),
        }
    }

    /// Uneven ground with the image on it, in vacuum.
    #[must_use]
    pub fn surface(surface: SurfaceGrid) -> Self {
        let surface = Arc::new(surface);
        Self {
            pixels: Pixels::surface(Arc::clone(&surface)),
            ground: Ground::surface(surface),
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
            open: OpenChoices::default(),
        }
    }

    /// The plane, the volume or the terrain of the campaign, in the frame of the positions.
    ///
    /// # Errors
    /// Terrain that cannot be read, or does not reach under the whole image; the message names the
    /// file and the place.
    pub fn find(
        options: &SceneOptions,
        positions: &[&Positions],
        warnings: &mut Warnings,
    ) -> Result<Self, SceneError> {
        let open = options.open(positions)?;
        let grid = options.grid_over(positions)?;
        let mut scene = match &options.heights {
            SceneHeights::Plane(_) | SceneHeights::Ground => Self::plane(grid),
            SceneHeights::Volume { ground_z_m, .. } => {
                let mut scene = Self::plane(grid);
                scene.pixels.volume = options.volume(grid)?;
                scene.ground = Ground::level(*ground_z_m);
                scene
            }
            SceneHeights::Terrain(source) => {
                let frame = frame_of(options.origin, positions);
                source.scene(grid, &frame, positions, warnings)?
            }
        };
        if let Some(terrain) = &options.terrain {
            if open.sides != [false; 2] {
                return Err(SceneError::OpenSides);
            }
            let frame = frame_of(options.origin, positions);
            scene.ground = terrain.scene(grid, &frame, positions, warnings)?.ground;
        }
        if let (Some(z_m), false) = (options.surface_z_m, scene.ground.is_uneven()) {
            scene.ground = Ground::level(z_m);
        }
        Ok(Self {
            light_speed_m_s: options.light_speed_m_s,
            open,
            ..scene
        })
    }
}

impl SceneOptions {
    /// The columns and rows stated; none where they are left to the flight.
    ///
    /// # Errors
    /// More than memory holds, with the bytes it would need.
    pub fn grid(&self) -> Result<Option<PlaneGrid>, SceneError> {
        match (self.x_m, self.y_m) {
            (Some(x_m), Some(y_m)) => {
                let grid = PlaneGrid::from_ranges(x_m, y_m, self.base_z_m(), self.pixel_m)
                    .map_err(|error| SceneError::of_grid(error, x_m, y_m, self.pixel_m))?;
                let is_plane = !matches!(self.heights, SceneHeights::Volume { .. });
                if grid.len() == 1 && is_plane {
                    return Err(SceneError::OnePixel {
                        x_m,
                        y_m,
                        pixel_m: self.pixel_m,
                    });
                }
                Ok(Some(grid))
            }
            _ => Ok(None),
        }
    }

    fn base_z_m(&self) -> f64 {
        match self.heights {
            SceneHeights::Plane(z_m) | SceneHeights::Volume { z_m: [z_m, _], .. } => z_m,
            SceneHeights::Terrain(_) | SceneHeights::Ground => 0.0,
        }
    }

    /// Quantities that the data determine.
    fn open(&self, positions: &[&Positions]) -> Result<OpenChoices, SceneError> {
        let sides = [self.x_m.is_none(), self.y_m.is_none()];
        let is_plane = matches!(self.heights, SceneHeights::Plane(_) | SceneHeights::Ground);
        if sides != [false; 2] && !is_plane {
            return Err(SceneError::OpenSides);
        }
        let is_on_earth = matches!(frame_of(self.origin, positions), Frame::Enu(_));
        Ok(OpenChoices {
            ground: matches!(self.heights, SceneHeights::Ground) && is_on_earth,
            surface: self.has_radar_surface,
            sides,
            kept_s: self.kept_s,
            pixel_m: self.pixel_m,
        })
    }

    /// The columns and rows stated; where they are left to the flight, coarse ones under all of it.
    fn grid_over(&self, positions: &[&Positions]) -> Result<PlaneGrid, SceneError> {
        if let Some(grid) = self.grid()? {
            return Ok(grid);
        }
        let nowhere = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let [east, north] = with_flight(nowhere, positions);
        let (x_m, y_m) = (self.x_m.unwrap_or(east), self.y_m.unwrap_or(north));
        // A thousand pixels along the longer side, until the traces that are imaged are known.
        let longest_m = (x_m[1] - x_m[0]).max(y_m[1] - y_m[0]);
        let coarse_m = self.pixel_m.max(longest_m / 1000.0);
        PlaneGrid::from_ranges(x_m, y_m, self.base_z_m(), coarse_m).map_err(SceneError::Grid)
    }

    /// The slices stated, for a volume.
    ///
    /// # Errors
    /// Heights that make no volume.
    pub fn volume(&self, base: PlaneGrid) -> Result<Option<VolumeGrid>, SceneError> {
        let SceneHeights::Volume {
            z_m: [from, to],
            step_m,
            ..
        } = self.heights
        else {
            return Ok(None);
        };
        let steps = ((to - from) / step_m + 1e-6).floor();
        if steps.is_nan() || steps >= 1e7 {
            return Err(SceneError::Slices {
                slices: steps,
                step_m,
            });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be a moderate number, not negative"
        )]
        let slices = steps as usize + 1;
        VolumeGrid::new(base, step_m, slices)
            .map(Some)
            .map_err(SceneError::Volume)
    }
}

impl TerrainSource {
    /// The terrain under the image and, where the file reaches so far, under the flight.
    fn scene(
        &self,
        grid: PlaneGrid,
        frame: &Frame,
        positions: &[&Positions],
        warnings: &mut Warnings,
    ) -> Result<Scene, SceneError> {
        let file = self.open(self.geoid_height_m)?;
        let counts_from_sea = file.vertical().is_some_and(|v| v != "the ellipsoid");
        let geoid_m = match counts_from_sea {
            true => self.geoid_m(frame)?,
            false => None,
        };
        let raised_m = self.geoid_height_m + geoid_m.unwrap_or(0.0);
        let file = match geoid_m {
            Some(_) => self.open(raised_m)?,
            None => file,
        };
        if let Some(vertical) = file.vertical()
            && raised_m == 0.0
            && counts_from_sea
        {
            warnings.add(format!(
                "{}: heights count from {vertical}; state [image] geoid or geoid_height_m, or they are \
                 taken as heights above the ellipsoid",
                name_of(&self.path)
            ));
        }
        if self.geoid.is_some() && file.vertical().is_none() {
            warnings.add(format!(
                "{} does not state what its heights count from: the geoid is not added to the heights; \
                 state [image] geoid_height_m instead of geoid if they count from the sea",
                name_of(&self.path)
            ));
        }
        let under_image = |cause| SceneError::UnderImage {
            path: self.path.clone(),
            cause,
        };
        let near = [
            [grid.x0_m, grid.x_m(grid.nx - 1)],
            [grid.y0_m, grid.y_m(grid.ny - 1)],
        ];
        let terrain = file
            .in_frame(frame, near[0], near[1])
            .map_err(under_image)?;
        let surface = SurfaceGrid::in_parallel(grid, |x_m, y_m| {
            terrain.height_m(x_m, y_m).map_err(under_image)
        })?;
        drop(terrain);
        let [far_x_m, far_y_m] = with_flight(near, positions);
        let wide = self
            .open(raised_m)
            .ok()
            .and_then(|file| file.in_frame(frame, far_x_m, far_y_m).ok());
        if wide.is_none() {
            warnings.add(format!(
                "{} does not reach under the whole flight: heights above ground are those above \
                 the image's nearest edge there",
                name_of(&self.path)
            ));
        }
        let mut scene = Scene::surface(surface);
        scene.ground.wide = wide;
        Ok(scene)
    }

    /// The geoid's height at the origin of a frame on the Earth (m), where a grid is given. Over the few
    /// kilometres of a flight it changes by centimetres.
    fn geoid_m(&self, frame: &Frame) -> Result<Option<f64>, SceneError> {
        let (Some(path), Frame::Enu(frame)) = (&self.geoid, frame) else {
            return Ok(None);
        };
        let origin = frame.geodetic_from_enu([0.0; 3]);
        let [latitude_deg, longitude_deg] = [origin.latitude_deg(), origin.longitude_deg()];
        let height_m = GeoidGrid::read(path)?.height_m(latitude_deg, longitude_deg);
        height_m.map(Some).ok_or(SceneError::BeyondGeoid {
            latitude_deg,
            longitude_deg,
        })
    }

    fn open(&self, raised_m: f64) -> Result<TerrainFile<File>, SceneError> {
        let path = || self.path.clone();
        let mut options = TerrainOptions::default().with_offset_m(raised_m);
        if let Some(crs) = &self.crs {
            options =
                options.with_crs(Crs::parse(crs).map_err(|cause| SceneError::Coordinates {
                    path: path(),
                    cause,
                })?);
        }
        open_file(&self.path)?;
        TerrainFile::open_path(&self.path, &options).map_err(|cause| SceneError::Terrain {
            path: path(),
            cause,
        })
    }
}

fn open_file(path: &Path) -> Result<File, SceneError> {
    File::open(path).map_err(|cause| SceneError::Open {
        path: path.to_owned(),
        cause,
    })
}

/// The positions' frame: the trajectory's own, or about the origin stated.
fn frame_of(origin: Option<Geodetic>, positions: &[&Positions]) -> Frame {
    let own = positions.iter().find_map(|p| match p {
        Positions::PerTrace(places) => places.frame.enu().copied().map(Frame::Enu),
        Positions::Trajectory(trajectory) => Some(*trajectory.frame()),
    });
    match (own, origin) {
        (Some(frame @ Frame::Enu(_)), _) => frame,
        (_, Some(origin)) => Frame::Enu(EnuFrame::new(origin)),
        (_, None) => Frame::Local,
    }
}

/// The rectangle widened to lie under the flight.
fn with_flight(mut rectangle: [[f64; 2]; 2], positions: &[&Positions]) -> [[f64; 2]; 2] {
    let mut add = |p: &[f64; 3]| {
        for (side, value) in rectangle.iter_mut().zip(p) {
            side[0] = side[0].min(*value);
            side[1] = side[1].max(*value);
        }
    };
    for p in positions {
        match p {
            Positions::Trajectory(trajectory) => {
                trajectory
                    .fixes()
                    .iter()
                    .for_each(|fix| add(&fix.position_m));
            }
            Positions::PerTrace(places) => places.position_m.iter().for_each(&mut add),
        }
    }
    rectangle
}
