//! `acerra simulate`: writes the logs that instruments would have written.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::settings_files::SettingsFile;
use crate::simulated::write_campaign;
use crate::terminal::{Verbosity, verbosity};
use acerra_products::staging::Staging;
use acerra_simulate::scene::Scene;

/// Simulate a campaign: radar and GNSS logs of a flight over a scene, and its campaign file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra simulate --example > scene.toml
  acerra simulate scene.toml -o flight && acerra focus flight/campaign.toml")]
pub struct Args {
    /// The scene file (TOML).
    #[arg(value_name = "SCENE.toml", required_unless_present = "example")]
    pub(crate) scene: Option<PathBuf>,
    /// Directory for the logs.
    #[arg(short, long, value_name = "DIR", required_unless_present = "example")]
    output: Option<PathBuf>,
    /// Print a commented scene file with every key, to begin with.
    #[arg(long, conflicts_with_all = ["scene", "output", "seed"])]
    example: bool,
    /// Seed of everything random, instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// A scene that cannot be read or cannot be, or a directory that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let (Some(file), Some(output)) = (&args.scene, &args.output) else {
        write!(out, "{}", SettingsFile::Scene.example())?;
        return Ok(());
    };
    let at = || format!("{}", file.display());
    let text = std::fs::read_to_string(file).with_context(at)?;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let mut scene = Scene::parse(&text).with_context(at)?.resolved_in(folder);
    if let Some(seed) = args.seed {
        scene.seed = seed;
    }
    let mut staging = Staging::new(output)?;
    staging.supersede(older_logs(output, &scene));
    let simulated = write_campaign(&scene, &staging).with_context(at)?;
    staging.publish()?;
    if verbosity() == Verbosity::Quiet {
        return Ok(());
    }
    writeln!(
        out,
        "{} scans, {} messages lost, {} GNSS epochs; process with: acerra focus {}",
        simulated.scans,
        simulated.lost_messages,
        simulated.gnss_epochs,
        output.join("campaign.toml").display()
    )?;
    Ok(())
}

/// The logs of an older simulation in a directory, recognised by its truth file: the newer scene may have
/// other instruments. Files that the newer scene itself reads stay.
fn older_logs(directory: &Path, scene: &Scene) -> Vec<String> {
    if !directory.join("truth.json").is_file() {
        return Vec::new();
    }
    let logs = [
        "rover.obs",
        "base.obs",
        "rover.ubx",
        "base.ubx",
        "broadcast.nav",
        "trajectory.csv",
    ];
    let given = scene.trajectory.as_ref().map(|t| &t.file);
    let navigation = scene.gnss.as_ref().and_then(|g| g.navigation.as_ref());
    let inputs: Vec<PathBuf> = [given, navigation]
        .into_iter()
        .flatten()
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    let is_input = |name: &str| {
        let place = directory.join(name).canonicalize();
        place.is_ok_and(|place| inputs.contains(&place))
    };
    logs.into_iter()
        .filter(|name| !is_input(name))
        .map(str::to_owned)
        .collect()
}
