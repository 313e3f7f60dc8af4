//! The ground below the flight, and the pixels that stand on it.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::terrain::{Crs, LocalTerrain, TerrainError, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use acerra_imaging::{ImagingError, PlaneGrid, SPEED_OF_LIGHT_M_S, SurfaceGrid, VolumeGrid};

use crate::pixels::Pixels;
use crate::position::Positions;
use crate::read::name_of;
use crate::warnings::Warnings;

/// The image's rectangle and heights, as asked for.
#[derive(Clone, Debug)]
pub struct SceneOptions {
    /// First and last pixel centre to the east (m).
    pub x_m: [f64; 2],
    /// First and last pixel centre to the north (m).
    pub y_m: [f64; 2],
    /// Side of a pixel (m).
    pub pixel_m: f64,
    /// Heights of the pixels.
    pub heights: SceneHeights,
    /// Origin of the frame of positions that state none of their own.
    pub origin: Option<Geodetic>,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Heights of an image's pixels.
#[derive(Clone, Debug)]
pub enum SceneHeights {
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
    /// Those of the terrain.
    Terrain(TerrainSource),
}

/// A terrain raster.
#[derive(Clone, Debug)]
pub struct TerrainSource {
    /// The raster.
    pub path: PathBuf,
    /// Its coordinates where the file does not say: `"local"` or an EPSG code.
    pub crs: Option<String>,
    /// Added to its heights to have heights above the ellipsoid (m).
    pub geoid_height_m: f64,
}

/// Why there are no pixels, or no ground.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A rectangle that makes no grid, or one that cannot be held.
    #[error("[image]: {0}")]
    Grid(ImagingError),
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
        /// What the system says.
        cause: io::Error,
    },
    /// The name of the terrain's coordinates is unknown.
    #[error("{}: [image] terrain_crs: {cause}", path.display())]
    Coordinates {
        /// The raster.
        path: PathBuf,
        /// Why.
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
    /// Heights that make no surface.
    #[error(transparent)]
    Surface(#[from] ImagingError),
}

/// Height of the ground under a flight.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Where no terrain tells it (m).
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

    /// Whether a terrain tells the heights.
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
}

impl Scene {
    /// A horizontal plane that is also the ground, in vacuum.
    #[must_use]
    pub fn plane(grid: PlaneGrid) -> Self {
        Self {
            pixels: Pixels::plane(grid),
            ground: Ground::level(grid.z_m),
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
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
        }
    }

    /// The plane, the volume or the terrain asked for, in the frame of the positions.
    ///
    /// # Errors
    /// Terrain that cannot be read, or does not reach under the whole image; the message names the
    /// file and the place.
    pub fn find(
        options: &SceneOptions,
        positions: &[&Positions],
        warnings: &mut Warnings,
    ) -> Result<Self, SceneError> {
        let grid = options.grid()?;
        let scene = match &options.heights {
            SceneHeights::Plane(_) => Self::plane(grid),
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
        Ok(Self {
            light_speed_m_s: options.light_speed_m_s,
            ..scene
        })
    }
}

impl SceneOptions {
    /// The columns and rows asked for.
    ///
    /// # Errors
    /// More than memory holds, with the bytes it would need.
    pub fn grid(&self) -> Result<PlaneGrid, SceneError> {
        let z_m = match self.heights {
            SceneHeights::Plane(z_m) | SceneHeights::Volume { z_m: [z_m, _], .. } => z_m,
            SceneHeights::Terrain(_) => 0.0,
        };
        PlaneGrid::from_ranges(self.x_m, self.y_m, z_m, self.pixel_m).map_err(SceneError::Grid)
    }

    /// The slices asked for, where a volume is.
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
        let file = self.open()?;
        if let Some(vertical) = file.vertical()
            && self.geoid_height_m == 0.0
            && vertical != "the ellipsoid"
        {
            warnings.add(format!(
                "{}: heights count from {vertical}; state [image] geoid_height_m, or they are \
                 taken as heights above the ellipsoid",
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
        let surface = SurfaceGrid::from_fn(grid, |x_m, y_m| {
            terrain.height_m(x_m, y_m).map_err(under_image)
        })?;
        drop(terrain);
        let [far_x_m, far_y_m] = with_flight(near, positions);
        let wide = self
            .open()
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

    fn open(&self) -> Result<TerrainFile<File>, SceneError> {
        let path = || self.path.clone();
        let mut options = TerrainOptions::default().with_offset_m(self.geoid_height_m);
        if let Some(crs) = &self.crs {
            options =
                options.with_crs(Crs::parse(crs).map_err(|cause| SceneError::Coordinates {
                    path: path(),
                    cause,
                })?);
        }
        let file = open_file(&self.path)?;
        TerrainFile::open(file, &options).map_err(|cause| SceneError::Terrain {
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
        Positions::Trajectory(trajectory) => Some(*trajectory.frame()),
        Positions::PerTrace(_) => None,
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
            Positions::PerTrace(position_m) => position_m.iter().for_each(&mut add),
        }
    }
    rectangle
}
