//! Figure 12: the two flights of the demonstration, over two reflectors and beside them.

use acerra::demo::{TRACKS, Track, fly};
use acerra_chain::Journal;

use crate::scene::{Scene, Target};

/// Both flights on the paper's grid: 18 m × 18 m with pixels of 1 cm.
pub fn scenes() -> Vec<Scene> {
    TRACKS.into_iter().map(scene).collect()
}

/// The flight beside the reflectors, Figure 12b.
pub fn track_2() -> Scene {
    scene(TRACKS[1])
}

fn scene(track: Track) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let logged = track.on_track().unwrap();
    let flown = fly(logged, folder.path(), &mut Journal::default()).unwrap();
    let outcome = flown.outcome;
    let prepared = &outcome.prepared;
    let target = |(k, place_m)| Target {
        name: format!(", reflector {}", k + 1),
        place_m,
    };
    let corners = flown.scene.corner.iter().map(|corner| corner.position_m);
    Scene {
        name: track.title.split(':').next().unwrap().to_owned(),
        spectrum: prepared.spectrum.clone(),
        aligned: prepared.aligned.clone(),
        light_speed_m_s: prepared.scene.light_speed_m_s,
        tracks: prepared.tracks.iter().map(|t| t.range.clone()).collect(),
        held_m: prepared.ranges_held_m(),
        pixels: outcome.focused.pixels.clone(),
        options: outcome.focused.options,
        targets: corners.enumerate().map(target).collect(),
    }
}
