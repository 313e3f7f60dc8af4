//! `acerra simulate`: writes the logs that instruments would have written.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::simulated::write_campaign;
use acerra_products::staging::Staging;
use acerra_simulate::scene::Scene;

/// Simulate a campaign: radar and GNSS logs of a flight over a scene, and its campaign file.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The scene file (TOML).
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Directory for the logs.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Seed of everything random, instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// A scene that cannot be read or cannot be, or a directory that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let at = || format!("{}", args.scene.display());
    let text = std::fs::read_to_string(&args.scene).with_context(at)?;
    let folder = args.scene.parent().unwrap_or_else(|| Path::new(""));
    let mut scene = Scene::parse(&text).with_context(at)?.resolved_in(folder);
    if let Some(seed) = args.seed {
        scene.seed = seed;
    }
    let staging = Staging::new(&args.output)?;
    let simulated = write_campaign(&scene, &staging).with_context(at)?;
    staging.publish()?;
    writeln!(
        out,
        "{} scans, {} messages lost, {} GNSS epochs; process with: acerra focus {}",
        simulated.scans,
        simulated.lost_messages,
        simulated.gnss_epochs,
        args.output.join("campaign.toml").display()
    )?;
    Ok(())
}
