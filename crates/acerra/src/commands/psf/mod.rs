//! `acerra psf`: the point spread function of a flight, before or after flying it.

mod args;
mod blur;
mod output;
mod scene;
mod targets;

use std::io::Write;

use acerra_chain::focus::memory::available_memory_bytes;
use acerra_imaging::Control;
use acerra_imaging::psf::{Analysis, psf_image, retrieve};
use anyhow::{bail, ensure};

pub use args::Args;

/// Bytes that a pixel takes while the image is made and drawn: the value and its level.
const PIXEL_BYTES: u128 = 12;

/// Refuses an image that memory cannot hold.
fn fits_memory(scene: &scene::Scene) -> anyhow::Result<()> {
    let needed = PIXEL_BYTES * scene.grid.len() as u128;
    if let Some(available) = available_memory_bytes() {
        ensure!(
            needed <= u128::from(available),
            "the image needs {needed} bytes of memory, {available} bytes are available: choose a \
             larger --pixel-m or a smaller --half-width-m"
        );
    }
    Ok(())
}

/// Runs the command.
///
/// # Errors
/// Impossible geometry or sampling, a file that cannot be read, an output directory that cannot
/// be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let scene = scene::Scene::of(args)?;
    if args.output.is_some() || args.targets.is_some() {
        fits_memory(&scene)?;
    }
    for note in &scene.notes {
        crate::terminal::note(note);
    }
    if args.targets.is_some() {
        if args.blur.asked() {
            bail!("the sensitivity to positioning errors is that of one target, not of --targets");
        }
        let image = psf_image(
            &scene.spread,
            &scene.target_m,
            scene.grid,
            Control::default(),
        )?;
        let found = retrieve(&scene.spread, &scene.target_m, &image, scene.grid)?;
        if let Some(directory) = &args.output {
            output::write_targets(directory, &scene, &image, &found)?;
        }
        return targets::answer(args.json, scene.grid.z_m, &found, out);
    }
    let found = Analysis::of(&scene.spread, scene.target_m[0], scene.grid.z_m)?;
    if found.expected_m.is_none() {
        crate::terminal::note(&format!(
            "the image plane lies too far below the target to show it (Eq. 14): the figures below describe \
             the residue at ({:.3}, {:.3}) m",
            found.peak_m[0], found.peak_m[1]
        ));
    }
    let answer = output::Answer::of(&found, blur::analyse(&args.blur, &scene)?);
    if let Some(directory) = &args.output {
        let image = psf_image(
            &scene.spread,
            &scene.target_m,
            scene.grid,
            Control::default(),
        )?;
        output::write_single(directory, &scene, &image, &found, &answer)?;
    }
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &answer)?;
        writeln!(out)?;
    } else {
        out.write_all(output::text(&found).as_bytes())?;
        if let Some(blur) = &answer.sensitivity {
            out.write_all(blur::text(blur).as_bytes())?;
        }
    }
    Ok(())
}
