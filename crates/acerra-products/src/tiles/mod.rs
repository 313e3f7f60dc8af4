//! Runs in parts: each process makes some tiles of the image; another puts them together.
//!
//! ```text
//! campaign file ─┬─make_tiles(1/N)──►┐
//!                ├─ …                ├─ DIR/tiles.zarr ──merge_tiles──► products in DIR
//!                └─make_tiles(N/N)──►┘
//! ```
//!
//! Every process prepares the same spectra, so that no process waits for another; samples of the spectra are
//! stored with each tile, and `merge_tiles` compares them with its own. A tile appears whole or not at all,
//! and an existing tile is not made again: after any failure the same commands continue.

mod probe;
mod share;
mod store;

use std::fs;

use acerra_chain::focus::tiles::{TilePlan, assemble, check_request};
use acerra_chain::{Control, ImageRequest, Journal, MemorySink, Pixels, Prepared};
use anyhow::Context;

use crate::names::of_older_run;
use crate::outcome::Outcome;
use crate::process::Ready;
use crate::run::{RunRequest, delivered, open, record_inputs};
use crate::space::check_space;
use crate::stack_npz::NpzSink;
use crate::staging::Staging;

use probe::Probe;
pub use share::Share;
use store::{TileStore, identity};

/// Result of a share of the tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TilesMade {
    /// Tiles that this process made.
    pub made: usize,
    /// Tiles of its share that were there.
    pub held: usize,
    /// Tiles of the image that are not there yet, of all shares.
    pub missing: usize,
    /// Tiles of the image.
    pub all: usize,
}

/// Prepares a campaign and makes its share of the image's tiles, into `tiles.zarr` of the directory.
///
/// # Errors
/// As [`run_campaign`](crate::run_campaign); a method, looks or a directory that tiles do not fit.
pub fn make_tiles(
    request: RunRequest<'_>,
    share: Share,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<TilesMade> {
    let campaign = open(request)?;
    let inputs = journal.stage("read", |_| record_inputs(request.file, &campaign.campaign))?;
    let identity = identity(&campaign.campaign, &inputs);
    let ready = Ready::of(campaign, journal, control)?;
    check_request(&ready.request)?;
    let store = TileStore::make(request.directory, &ready.request.pixels, identity)?;
    let tiling = store.tiling();
    let probe = Probe::of(&ready.prepared);
    let mut made = 0;
    let mine: Vec<usize> = share.of(tiling.count()).collect();
    for &k in &mine {
        if store.holds(k) {
            continue;
        }
        let (values, plan) = journal.stage("focus", |warnings| {
            warnings.extend(ready.prepared.doubts(&ready.request));
            let pixels = tiling.part(&ready.request.pixels, k)?;
            image_tile(&ready.prepared, &ready.request, pixels, control)
        })?;
        store.put(k, &values, &plan, &probe)?;
        made += 1;
    }
    Ok(TilesMade {
        made,
        held: mine.len() - made,
        missing: store.missing().count(),
        all: tiling.count(),
    })
}

/// The values of a tile, and the record of its plan.
fn image_tile(
    prepared: &Prepared,
    request: &ImageRequest,
    pixels: Pixels,
    control: &Control<'_>,
) -> anyhow::Result<(Vec<acerra_imaging::Complex32>, TilePlan)> {
    let part = ImageRequest {
        pixels,
        ..request.clone()
    };
    let mut slices = MemorySink::default();
    let focused = prepared.image(&part, &mut slices, control)?;
    let plan = TilePlan {
        plan: focused.plan,
        promised_bytes: focused.promised_bytes,
        checked_error: focused.checked_error,
    };
    // A volume's values are those of its slices; its image is their projection.
    let values = match slices.stacks.into_iter().next() {
        Some(stack) => stack.images.concat(),
        None => focused.image,
    };
    Ok((values, plan))
}

/// Puts the tiles in a directory together, measures the image and writes the products there; the tiles
/// are then removed.
///
/// # Errors
/// As [`run_campaign`](crate::run_campaign); tiles that are missing or of another run. The directory
/// is then left as it was.
pub fn merge_tiles(
    request: RunRequest<'_>,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<Outcome> {
    let directory = request.directory;
    let campaign = open(request)?;
    check_space(&campaign.campaign, directory)?;
    let inputs = journal.stage("read", |_| record_inputs(request.file, &campaign.campaign))?;
    let identity = identity(&campaign.campaign, &inputs);
    // Before anything is prepared: the grid may need it, the other run's name does not.
    TileStore::check(directory, &identity)?;
    let ready = Ready::of(campaign, journal, control)?;
    check_request(&ready.request)?;
    let store = TileStore::open(directory, &ready.request.pixels, &identity)?;
    store.ensure_complete()?;
    let mut staging = Staging::new(directory)?;
    staging.supersede(of_older_run(directory));
    let mut sink = NpzSink::new(&staging.folder());
    let focused = journal.stage("focus", |warnings| {
        warnings.extend(ready.prepared.doubts(&ready.request));
        let plans = store.plans(&Probe::of(&ready.prepared))?;
        let tile = |k| store.tile(k);
        anyhow::Ok(assemble(&ready.request, &plans, tile, &mut sink)?)
    })?;
    let mut outcome = ready.measured(focused, journal, control)?;
    outcome.inputs = inputs;
    let outcome = delivered(outcome, staging, request.wanted, journal)?;
    let place = store.folder();
    fs::remove_dir_all(place).with_context(|| format!("{}: cannot remove", place.display()))?;
    Ok(outcome)
}
