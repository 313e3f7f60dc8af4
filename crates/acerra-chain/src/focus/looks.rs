//! Looks along the track: a separate image of each look, passed to the sink, and the sum of their powers.

use acerra_imaging::looks::{Look, LookWindow, add_power, looks};
use acerra_imaging::{Complex32, PlanOptions, Pulses};

use crate::choices::LookTaper;
use crate::control::Control;
use crate::focus::plan::{ImageError, contributions, plan_on, run_plan};
use crate::focus::sink::{ImageSink, StackArray, StackHeader, StackKind};
use crate::scene::pixels::Pixels;

/// Looks requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookOptions {
    /// Number of looks.
    pub count: usize,
    /// Part of a look's path that is shared with the next look.
    pub overlap: f64,
    /// Taper of each look.
    pub taper: LookTaper,
}

/// The looks of an image.
#[derive(Clone, Debug)]
pub struct Multilook {
    /// Mean power of the looks, `[ny, nx]`.
    pub power: Vec<f32>,
    /// Numbers of the first and last trace of each look, among those imaged.
    pub traces: Vec<[usize; 2]>,
    /// Bytes of the looks in addition to the image.
    pub bytes: u128,
}

/// Input of an image: echoes, pixels and options.
#[derive(Clone, Copy)]
pub(crate) struct LookInput<'a> {
    pub pulses: Pulses<'a>,
    pub pixels: &'a Pixels,
    pub plan: &'a PlanOptions,
}

/// Images every look into the sink, and sums their powers.
///
/// # Errors
/// More looks than the track has, data that cannot be imaged, a sink that is full.
pub(crate) fn image_looks(
    input: LookInput<'_>,
    options: LookOptions,
    sink: &mut dyn ImageSink,
    control: &Control<'_>,
) -> Result<Multilook, ImageError> {
    let window = match options.taper {
        LookTaper::None => LookWindow::Rectangular,
        LookTaper::Hann => LookWindow::Hann,
    };
    let LookInput {
        pulses,
        pixels,
        plan,
    } = input;
    let parts = looks(pulses.position_m(), options.count, options.overlap, window)
        .map_err(ImageError::Looks)?;
    let grid = pixels.grid;
    let mut power = vec![0_f32; grid.len()];
    let mut image = vec![Complex32::default(); grid.len()];
    let mut table_bytes = 0;
    let total = parts.iter().map(|p| contributions(grid.len(), &p.pulses));
    control.start("looks", total.sum());
    sink.begin(&StackHeader {
        kind: StackKind::Looks,
        grid,
        count: options.count,
    })?;
    let mut before = 0;
    for look in &parts {
        let weight: Vec<f64> = look
            .weight
            .iter()
            .zip(&pulses.weight()[look.pulses.clone()])
            .map(|(window, weight)| window * weight)
            .collect();
        let part = pulses.slice(look.pulses.clone())?.with_weight(&weight)?;
        let plan = plan_on(pixels, part, plan, control)?;
        run_plan(&plan, &mut image, before, control)?;
        before += contributions(grid.len(), &look.pulses);
        table_bytes = table_bytes.max(plan.memory_bytes() - 8 * grid.len() as u128);
        add_power(&mut power, &image)?;
        sink.put(&image)?;
    }
    #[expect(clippy::cast_precision_loss, reason = "a count of looks")]
    power.iter_mut().for_each(|p| *p /= options.count as f32);
    let mut arrays = place_arrays(&parts, pulses.position_m());
    arrays.push(StackArray {
        name: "multilook",
        shape: vec![grid.ny, grid.nx],
        values: power.iter().map(|p| f64::from(*p)).collect(),
    });
    sink.finish(arrays)?;
    control.finish();
    Ok(Multilook {
        power,
        traces: parts
            .iter()
            .map(|look| [look.pulses.start, look.pulses.end - 1])
            .collect(),
        bytes: table_bytes + 24 * grid.len() as u128,
    })
}

/// Traces of each look, and their mean position.
fn place_arrays(looks: &[Look], position_m: &[[f64; 3]]) -> Vec<StackArray> {
    #[expect(clippy::cast_precision_loss, reason = "counts of traces")]
    let ends = |name, end: fn(&Look) -> usize| StackArray {
        name,
        shape: vec![looks.len()],
        values: looks.iter().map(|look| end(look) as f64).collect(),
    };
    #[expect(clippy::cast_precision_loss, reason = "counts of traces")]
    let middle = |look: &Look| {
        let p = &position_m[look.pulses.clone()];
        [0, 1, 2].map(|a| p.iter().map(|p| p[a]).sum::<f64>() / p.len() as f64)
    };
    vec![
        ends("first_trace", |look| look.pulses.start),
        ends("last_trace", |look| look.pulses.end - 1),
        StackArray {
            name: "position_m",
            shape: vec![looks.len(), 3],
            values: looks.iter().flat_map(middle).collect(),
        },
    ]
}
