//! `acerra man`: manual pages.

use std::io::Write;
use std::path::PathBuf;

use acerra_products::staging::Staging;
use anyhow::Context;
use clap_mangen::Man;

/// Print a manual page, or write all of them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra man focus | man -l -
  acerra man -o ~/.local/share/man/man1")]
pub struct Args {
    /// The command whose page is printed; the overview by default.
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    command: Option<String>,
    /// Write the pages of all commands there: acerra.1, acerra-focus.1, …
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Writes manual pages of `overview`, the whole command line: one to `out`, or all to a directory.
///
/// # Errors
/// The name of a command that does not exist, a directory that cannot be written.
pub fn run(args: &Args, overview: clap::Command, out: &mut dyn Write) -> anyhow::Result<()> {
    let pages = pages(overview)?;
    if let Some(directory) = &args.output {
        let staging = Staging::new(directory)?;
        for (name, page) in &pages {
            staging.write(&format!("{name}.1"), page)?;
        }
        return staging.publish();
    }
    let name = match &args.command {
        Some(command) => format!("acerra-{command}"),
        None => "acerra".to_owned(),
    };
    let (_, page) = pages
        .iter()
        .find(|(page, _)| *page == name)
        .with_context(|| {
            let known: Vec<&str> = pages
                .iter()
                .filter_map(|(page, _)| page.strip_prefix("acerra-"))
                .collect();
            format!(
                "{}: no such command; expected one of {}",
                args.command.as_deref().unwrap_or_default(),
                known.join(", ")
            )
        })?;
    out.write_all(page)?;
    Ok(())
}

/// The pages of the overview and of each of its commands, by name.
fn pages(mut overview: clap::Command) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    // Gives each command its whole name.
    overview.build();
    let commands: Vec<clap::Command> = overview.get_subcommands().cloned().collect();
    std::iter::once(overview)
        .chain(commands)
        .map(|command| {
            let name = command
                .get_display_name()
                .unwrap_or(command.get_name())
                .to_owned();
            let mut page = Vec::new();
            Man::new(command).render(&mut page)?;
            Ok((name, page))
        })
        .collect()
}
