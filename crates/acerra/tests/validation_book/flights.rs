//! The demonstration's flights, flown once, and other ways to process their logs.

use std::path::PathBuf;
use std::sync::OnceLock;

use acerra::demo::{Flown, TRACKS, Track, fly};
use acerra_chain::Journal;
use acerra_chain::campaign::{Campaign, Contradictions};
use acerra_chain::{Control, MemorySink};
use acerra_products::{NamedCampaign, Outcome, process};

pub struct Flight {
    pub track: Track,
    pub flown: Flown,
    pub folder: PathBuf,
}

/// Both tracks of the demonstration, recorded as the paper's are: from one end of the track to the other.
pub fn flights() -> &'static [Flight; 2] {
    static FLIGHTS: OnceLock<(tempfile::TempDir, [Flight; 2])> = OnceLock::new();
    let fly = || {
        let here = tempfile::tempdir().unwrap();
        let flights = TRACKS.map(|track| {
            let folder = here.path().join(track.name);
            let scene = track.on_track().unwrap();
            let flown = fly(scene, &folder, &mut Journal::default()).unwrap();
            Flight {
                track,
                flown,
                folder,
            }
        });
        (here, flights)
    };
    &FLIGHTS.get_or_init(fly).1
}

impl Flight {
    /// Processes the logs as `change` has the campaign file say.
    pub fn processed(&self, change: impl FnOnce(&mut Campaign)) -> Outcome {
        let text = std::fs::read_to_string(self.folder.join("campaign.toml")).unwrap();
        let mut campaign = Campaign::parse(&text).unwrap().resolved_in(&self.folder);
        // The book shows what contradicts as well.
        campaign.checks.contradictions = Contradictions::Warn;
        change(&mut campaign);
        process(
            NamedCampaign {
                name: self.track.name.to_owned(),
                campaign,
            },
            &mut MemorySink::default(),
            &mut Journal::default(),
            &Control::default(),
        )
        .unwrap()
    }
}
