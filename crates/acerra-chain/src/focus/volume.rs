//! Volumes: slice after slice goes to the sink; the maximum along each axis is kept.

use acerra_imaging::{
    Complex32, PlanOptions, Pulses, SurfaceGrid, VolumeGrid, VolumeRun,
    image_volume_planned_once as image_slices,
};

use crate::control::Control;
use crate::focus::plan::{ImageError, contributions};
use crate::focus::sink::{ImageSink, SinkError, StackArray, StackHeader, StackKind};
use crate::focus::space::projections_bytes;
use crate::scene::pixels::Pixels;

/// A volume seen from three sides: the greatest amplitude along the other axis.
#[derive(Clone, Debug)]
pub struct Projections {
    /// Maximum as seen from above, `[ny, nx]`: moduli without phase.
    pub above: Vec<Complex32>,
    /// Maximum as seen from the south, `[nz, nx]`.
    pub front: Vec<f32>,
    /// Maximum as seen from the west, `[nz, ny]`.
    pub side: Vec<f32>,
    /// The slices.
    pub volume: VolumeGrid,
}

/// The part of a volume that is kept in memory.
pub(crate) struct ImagedVolume {
    /// The value of greatest modulus along z.
    pub image: Vec<Complex32>,
    /// Columns and rows, with the heights of the image's values.
    pub pixels: Pixels,
    pub projections: Projections,
    pub run: VolumeRun,
    /// Bytes of the tables and of the maximum projections.
    pub bytes: u128,
}

/// Maximum along each axis of the slices so far.
struct Maxima {
    volume: VolumeGrid,
    image: Vec<Complex32>,
    above_base_m: Vec<f32>,
    front: Vec<f32>,
    side: Vec<f32>,
}

/// Images every slice into the sink, and keeps the maximum along each axis.
///
/// # Errors
/// Data that cannot be imaged, a sink that is full.
pub(crate) fn image_volume(
    pulses: Pulses<'_>,
    volume: VolumeGrid,
    options: &PlanOptions,
    sink: &mut dyn ImageSink,
    control: &Control<'_>,
) -> Result<ImagedVolume, ImageError> {
    let per_slice = contributions(volume.base.len(), &(0..pulses.len()));
    control.start("focus", per_slice * volume.nz as u64);
    sink.begin(&StackHeader {
        kind: StackKind::Volume,
        grid: volume.base,
        count: volume.nz,
    })?;
    let mut maxima = Maxima::new(volume);
    let cancel = control.operation();
    let run = image_slices(&volume, pulses, options, cancel, |k, _, slice| {
        maxima.add(k, slice);
        control.at(per_slice * (k as u64 + 1));
        Ok::<(), ImageError>(sink.put(slice)?)
    })?;
    sink.finish(vec![heights_of(&volume)])?;
    control.finish();
    let kept = projections_bytes(&volume) + 4 * volume.base.len() as u128;
    let (image, pixels, projections) = maxima.into_parts()?;
    Ok(ImagedVolume {
        image,
        pixels,
        projections,
        bytes: run.memory_bytes + kept,
        run,
    })
}

/// Assembles a volume imaged in groups of whole slices: passes it to the sink slice after slice, and projects
/// it along three axes.
///
/// # Errors
/// A missing group, a failure of the sink.
pub(crate) fn assemble_volume<G: AsRef<[Complex32]>>(
    volume: VolumeGrid,
    groups: impl Iterator<Item = Result<G, SinkError>>,
    sink: &mut dyn ImageSink,
) -> Result<(Vec<Complex32>, Pixels, Projections), ImageError> {
    sink.begin(&StackHeader {
        kind: StackKind::Volume,
        grid: volume.base,
        count: volume.nz,
    })?;
    let mut maxima = Maxima::new(volume);
    let mut k = 0;
    for group in groups {
        for slice in group?.as_ref().chunks(volume.base.len()) {
            maxima.add(k, slice);
            sink.put(slice)?;
            k += 1;
        }
    }
    sink.finish(vec![heights_of(&volume)])?;
    maxima.into_parts()
}

fn heights_of(volume: &VolumeGrid) -> StackArray {
    StackArray {
        name: "z_m",
        shape: vec![volume.nz],
        values: (0..volume.nz).map(|k| volume.slice(k).z_m).collect(),
    }
}

impl Maxima {
    fn new(volume: VolumeGrid) -> Self {
        let base = volume.base;
        Self {
            image: vec![Complex32::default(); base.len()],
            above_base_m: vec![0.0; base.len()],
            front: vec![0.0; volume.nz * base.nx],
            side: vec![0.0; volume.nz * base.ny],
            volume,
        }
    }

    /// Adds slice `k`; sides collect powers until they are complete.
    fn add(&mut self, k: usize, slice: &[Complex32]) {
        let (nx, ny) = (self.volume.base.nx, self.volume.base.ny);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            reason = "heights in a picture"
        )]
        let above_base_m = (k as f64 * self.volume.step_m) as f32;
        for (at, v) in slice.iter().enumerate() {
            let power = v.norm_sqr();
            if power > self.image[at].norm_sqr() {
                self.image[at] = *v;
                self.above_base_m[at] = above_base_m;
            }
            let (i, j) = (k * nx + at % nx, k * ny + at / nx);
            self.front[i] = self.front[i].max(power);
            self.side[j] = self.side[j].max(power);
        }
    }

    fn into_parts(self) -> Result<(Vec<Complex32>, Pixels, Projections), ImageError> {
        let Self {
            volume,
            image,
            above_base_m,
            mut front,
            mut side,
        } = self;
        let grid = volume.base;
        front
            .iter_mut()
            .chain(&mut side)
            .for_each(|p| *p = p.sqrt());
        let mut heights = above_base_m.iter();
        let surface = SurfaceGrid::from_fn(grid, |_, _| {
            let above_m = heights.next().copied().unwrap_or(0.0);
            Ok::<_, ImageError>(grid.z_m + f64::from(above_m))
        })?;
        drop(above_base_m);
        let above = image
            .iter()
            .map(|v| Complex32::new(v.norm(), 0.0))
            .collect();
        let pixels = Pixels {
            grid,
            surface: Some(surface.into()),
            volume: Some(volume),
        };
        let projections = Projections {
            above,
            front,
            side,
            volume,
        };
        Ok((image, pixels, projections))
    }
}
