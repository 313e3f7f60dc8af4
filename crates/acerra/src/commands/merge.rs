//! `acerra merge`: the tiles of a run put together.

use std::io::Write;
use std::path::PathBuf;

use acerra_products::{Wanted, merge_tiles};

use super::focus::Order;

/// Put the tiles of `acerra focus --tiles` together: check that all are there, measure the image and
/// write the products.
///
/// The tiles are removed at the end. Whatever is missing or of another campaign is named, and everything
/// stays as it was.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra focus flight.toml --tiles 1/2
  acerra focus flight.toml --tiles 2/2
  acerra merge flight.toml")]
pub struct Args {
    /// The campaign file (TOML) whose tiles were made.
    #[arg(value_name = "CAMPAIGN.toml")]
    pub(crate) campaign: PathBuf,
    /// Directory of the tiles and for the products [default: CAMPAIGN-products next to the campaign file].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// The tiles were made with --autofocus.
    #[arg(long)]
    autofocus: bool,
    /// Print run.json on standard output instead of a summary.
    #[arg(long)]
    json: bool,
    /// Print how the tiles were planned.
    #[arg(long)]
    explain: bool,
}

/// Runs the command.
///
/// # Errors
/// Tiles that are missing or of another run, and whatever the chain cannot do.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let order = Order {
        campaign: &args.campaign,
        output: args.output.as_deref(),
        autofocus: args.autofocus,
        wanted: Wanted::All,
        json: args.json,
        explain: args.explain,
    };
    order.run(merge_tiles, out)
}
