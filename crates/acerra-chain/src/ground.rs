//! What the pixels stand on: a plane, the terrain, or the slices of a volume.

use std::fs::File;
use std::path::Path;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::terrain::{Crs, LocalTerrain, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use acerra_imaging::{PlaneGrid, SurfaceGrid, VolumeGrid};
use anyhow::Context;

use super::position::Positions;
use super::read::name_of;
use super::warnings::Warnings;
use crate::campaign::{Campaign, Heights};

/// The pixels' ground.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Columns and rows of the image; at the plane's height, the middle of the terrain's, or the
    /// lowest slice's.
    pub grid: PlaneGrid,
    /// The terrain under the image.
    pub surface: Option<SurfaceGrid>,
    /// The slices of a volume.
    pub volume: Option<VolumeGrid>,
    /// Height of the ground where no terrain tells it.
    level_m: f64,
    /// The terrain under the flight as well, where its file reaches so far.
    wide: Option<LocalTerrain>,
}

/// Positions, and the ground below them.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    /// Where the radar was.
    pub positions: &'a Positions,
    /// What it flew over.
    pub ground: &'a Ground,
}

/// The columns and rows that a campaign asks for.
///
/// # Errors
/// More than memory holds, with the bytes it would need.
pub fn grid_of(campaign: &Campaign) -> anyhow::Result<PlaneGrid> {
    let image = &campaign.image;
    PlaneGrid::from_ranges(image.x_m, image.y_m, image.base_z_m(), image.pixel_m).context("[image]")
}

/// The slices that a campaign asks for, where it asks for a volume.
///
/// # Errors
/// Heights that make no volume.
pub fn volume_of(campaign: &Campaign, base: PlaneGrid) -> anyhow::Result<Option<VolumeGrid>> {
    let Some(Heights::Range([from, to])) = campaign.image.z_m else {
        return Ok(None);
    };
    let step_m = campaign.image.pixel_z_m.unwrap_or(campaign.image.pixel_m);
    let steps = ((to - from) / step_m + 1e-6).floor();
    anyhow::ensure!(
        steps < 1e7,
        "[image] z_m: {steps:.0} slices of {step_m} m are more than ten million"
    );
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked to be a moderate number, not negative"
    )]
    let slices = steps as usize + 1;
    VolumeGrid::new(base, step_m, slices)
        .map(Some)
        .context("[image] z_m")
}

impl Ground {
    /// Finds the ground: the plane or volume of the campaign, or its terrain in the frame of the
    /// positions.
    ///
    /// # Errors
    /// Terrain that cannot be read, or does not reach under the whole image; the message names the
    /// file and the place.
    pub fn find(
        campaign: &Campaign,
        positions: &[&Positions],
        warnings: &mut Warnings,
    ) -> anyhow::Result<Self> {
        let grid = grid_of(campaign)?;
        let Some(path) = &campaign.image.terrain else {
            return Ok(Self {
                grid,
                surface: None,
                volume: volume_of(campaign, grid)?,
                level_m: campaign.image.ground_z_m(),
                wide: None,
            });
        };
        let frame = frame_of(campaign, positions);
        let open = || open(campaign, path);
        let file = open().with_context(|| path.display().to_string())?;
        if let Some(vertical) = file.vertical()
            && campaign.image.geoid_height_m == 0.0
            && vertical != "the ellipsoid"
        {
            warnings.add(format!(
                "{}: heights count from {vertical}; state [image] geoid_height_m, or they are \
                 taken as heights above the ellipsoid",
                name_of(path)
            ));
        }
        let near = [
            [grid.x0_m, grid.x_m(grid.nx - 1)],
            [grid.y0_m, grid.y_m(grid.ny - 1)],
        ];
        let terrain = file
            .in_frame(&frame, near[0], near[1])
            .with_context(|| format!("{} under the image", path.display()))?;
        let surface = SurfaceGrid::from_fn(grid, |x_m, y_m| {
            terrain
                .height_m(x_m, y_m)
                .with_context(|| format!("{} under the image", path.display()))
        })?;
        let surface_middle_m = surface.base().z_m;
        let far = with_flight(near, positions);
        let wide = open().and_then(|file| Ok(file.in_frame(&frame, far[0], far[1])?));
        if wide.is_err() {
            warnings.add(format!(
                "{} does not reach under the whole flight: heights above ground are those above \
                 the image's nearest edge there",
                name_of(path)
            ));
        }
        Ok(Self {
            grid: *surface.base(),
            surface: Some(surface),
            volume: None,
            level_m: surface_middle_m,
            wide: wide.ok(),
        })
    }

    /// Height of the ground at (x, y), m: of the plane, of the terrain, or what the campaign says of
    /// a volume.
    #[must_use]
    pub fn below_m(&self, x_m: f64, y_m: f64) -> f64 {
        let wide = self.wide.as_ref();
        match (&self.surface, wide.map(|w| w.height_m(x_m, y_m))) {
            (Some(_), Some(Ok(z_m))) => z_m,
            (Some(surface), _) => surface.height_m(x_m, y_m),
            (None, _) => self.level_m,
        }
    }

    /// Least and greatest height, m.
    #[must_use]
    pub fn span_m(&self) -> [f64; 2] {
        match (&self.surface, &self.volume) {
            (Some(surface), _) => surface.span_m(),
            (None, Some(volume)) => [self.grid.z_m, volume.slice(volume.nz - 1).z_m],
            (None, None) => [self.grid.z_m; 2],
        }
    }

    /// A height for what takes only one, m.
    #[must_use]
    pub fn middle_m(&self) -> f64 {
        let [low, high] = self.span_m();
        0.5 * (low + high)
    }

    /// What the pixels stand on, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let [low, high] = self.span_m();
        if let Some(volume) = &self.volume {
            return format!(
                "in a volume of {} slices from z = {} m by {} m",
                volume.nz, volume.base.z_m, volume.step_m
            );
        }
        match &self.surface {
            Some(_) => {
                // A little below zero is no "-0.00".
                let [low, high] = [low, high].map(|z| (z * 100.0).round() / 100.0 + 0.0);
                format!("on the terrain, z = {low:.2} to {high:.2} m")
            }
            None => format!("at z = {low} m"),
        }
    }
}

fn open(campaign: &Campaign, path: &Path) -> anyhow::Result<TerrainFile<File>> {
    let mut options = TerrainOptions::default().with_offset_m(campaign.image.geoid_height_m);
    if let Some(crs) = &campaign.image.terrain_crs {
        options = options.with_crs(Crs::parse(crs).context("[image] terrain_crs")?);
    }
    Ok(TerrainFile::open(File::open(path)?, &options)?)
}

/// The positions' frame: the trajectory's own, or about the origin that the campaign states.
fn frame_of(campaign: &Campaign, positions: &[&Positions]) -> Frame {
    let own = positions.iter().find_map(|p| match p {
        Positions::Trajectory(trajectory) => Some(*trajectory.frame()),
        Positions::PerTrace(_) => None,
    });
    let stated = || {
        let [latitude, longitude, height_m] = campaign.trajectory.origin_deg_m?;
        let origin = Geodetic::from_degrees(latitude, longitude, height_m);
        Some(Frame::Enu(EnuFrame::new(origin)))
    };
    match own {
        Some(frame @ Frame::Enu(_)) => frame,
        _ => stated().unwrap_or(Frame::Local),
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
