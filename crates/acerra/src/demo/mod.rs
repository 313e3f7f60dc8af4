//! The paper's campaign (§4): two reflectors, flown over twice, simulated to the last byte of its logs and
//! processed by the ordinary chain without access to the truth.

mod flown;
mod page;

use std::path::Path;

use anyhow::Context;

use crate::interrupt::cancel_flag;
use crate::progress::Bar;
use crate::simulated::write_campaign;
use acerra_chain::{Control, Journal};
use acerra_products::run_campaign;
use acerra_products::staging::Staging;
use acerra_simulate::demo::{TRACK_1, TRACK_2};
use acerra_simulate::scene::{OffsetTold, Record, Scene};
pub use flown::{Flown, Found, largest_envelope, rms_m};
pub use page::demonstration_page;

/// A track of the campaign, with the paper's results.
#[derive(Clone, Copy, Debug)]
pub struct Track {
    /// Its folder.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Its scene file.
    pub scene: &'static str,
    /// Measured by the paper (Table 4), both targets, along the track (m).
    pub paper_along_m: [f64; 2],
    /// Resolution across the track (m).
    pub paper_across_m: [f64; 2],
    /// Theory for a straight track at the mean height (Table 4), along the track (m).
    pub theory_along_m: f64,
    /// Resolution across the track (m).
    pub theory_across_m: f64,
    /// Largest standard deviations of the paper's positions (Table 3): x, y, z (m).
    pub paper_sigma_m: [f64; 3],
}

/// Track 1 over the reflectors, Track 2 to their side.
pub const TRACKS: [Track; 2] = [
    Track {
        name: "track-1",
        title: "Track 1: over the reflectors, 4 m high",
        scene: TRACK_1,
        paper_along_m: [0.05, 0.04],
        paper_across_m: [1.15, 0.99],
        theory_along_m: 0.02,
        theory_across_m: 0.85,
        paper_sigma_m: [0.043, 0.046, 0.094],
    },
    Track {
        name: "track-2",
        title: "Track 2: 2 m to the side of the reflectors, 10 m high",
        scene: TRACK_2,
        paper_along_m: [0.07, 0.09],
        paper_across_m: [0.51, 0.50],
        theory_along_m: 0.03,
        theory_across_m: 0.41,
        paper_sigma_m: [0.006, 0.008, 0.015],
    },
];

impl Track {
    /// Its scene.
    ///
    /// # Errors
    /// None, for the embedded scenes.
    pub fn scene(&self) -> anyhow::Result<Scene> {
        Scene::parse(self.scene).context(self.name)
    }

    /// Its scene with a radar log of the track alone, as the paper's, and the offset between the clocks stated,
    /// as the paper's controller keeps it.
    ///
    /// # Errors
    /// None, for the embedded scenes.
    pub fn on_track(&self) -> anyhow::Result<Scene> {
        Ok(Scene {
            record: Record::Track,
            time_offset: OffsetTold::Exact,
            ..self.scene()?
        })
    }

    /// Writes the track's logs into `folder`, processes them into `folder/products`, and returns
    /// both with the truth.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn fly(&self, folder: &Path, journal: &mut Journal) -> anyhow::Result<Flown> {
        fly(self.scene().context(self.name)?, folder, journal).context(self.name)
    }
}

/// Writes the logs of `scene` into `folder` and processes them into `folder/products`.
///
/// # Errors
/// A scene that cannot be, a folder that cannot be written, a campaign that cannot be processed.
pub fn fly(scene: Scene, folder: &Path, journal: &mut Journal) -> anyhow::Result<Flown> {
    let staging = Staging::new(folder)?;
    let simulated = write_campaign(&scene, &staging)?;
    staging.publish()?;
    let products = folder.join("products");
    let bar = Bar::following(&mut journal.stages);
    let control = Control::default()
        .reporting_to(&*bar)
        .cancelled_by(cancel_flag());
    let outcome = run_campaign(&folder.join("campaign.toml"), &products, journal, &control);
    bar.clear();
    Flown::new(scene, simulated, outcome?)
}
