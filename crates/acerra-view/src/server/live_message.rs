//! Messages to a page of a live image: tiles and traces as bytes, other data as JSON.
//!
//! Numbers are little-endian. Tiles: `1, 0, tiles u16, sequence u32, base_db f32, maximum_db f32`, then each
//! tile `x u32, y u32, columns u16, rows u16` and its levels. Traces: `2, 0, traces u16, first u32, bins u16,
//! 0 u16`, then the levels of each. A round of messages ends with the JSON.

use acerra_live::board::{BINS, Board, Shown, ShownTrace};
use serde_json::{Value, json};

/// Data that a page has received.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sent {
    /// State of the picture.
    pub sequence: u64,
    next_trace: u64,
    places: usize,
    thinned: u64,
}

/// A round of messages.
#[derive(Debug)]
pub struct Round {
    /// Tiles and traces.
    pub bytes: Vec<Vec<u8>>,
    /// The rest.
    pub text: String,
}

impl Sent {
    /// New data on the board since the last round.
    pub fn round(&mut self, board: &Board) -> Round {
        let shown = board.shown();
        let mut bytes = Vec::new();
        if let Some(picture) = &shown.picture
            && picture.sequence > self.sequence
        {
            bytes.push(tiles(picture, self.sequence));
            self.sequence = picture.sequence;
        }
        let new = board.traces_from(self.next_trace);
        if let Some(last) = new.last() {
            self.next_trace = last.number + 1;
            bytes.push(traces(&new));
        }
        let text = self.json(&shown).to_string();
        Round { bytes, text }
    }

    fn json(&mut self, shown: &Shown) -> Value {
        if self.thinned != shown.thinned || self.places > shown.track.len() {
            (self.thinned, self.places) = (shown.thinned, 0);
        }
        let from = std::mem::replace(&mut self.places, shown.track.len());
        let places: Vec<Value> = shown.track[from..]
            .iter()
            .map(|place| json!([place.position_m, place.status]))
            .collect();
        let grid = shown.picture.as_ref().map(|picture| {
            let grid = picture.grid;
            json!({
                "x0_m": grid.x0_m,
                "y0_m": grid.y0_m,
                "z_m": grid.z_m,
                "pixel_m": grid.pixel_m,
                "nx": grid.nx,
                "ny": grid.ny,
            })
        });
        json!({
            "sequence": self.sequence,
            "grid": grid,
            "origin_deg_m": shown.origin_deg_m,
            "status": shown.status,
            "track": { "from": from, "places": places },
            "trace_axis_ns": shown.trace_axis_ns,
            "final": shown.last,
            "can_stop": shown.can_stop,
        })
    }
}

fn tiles(picture: &acerra_live::picture::Picture, seen: u64) -> Vec<u8> {
    let mut out = vec![1, 0, 0, 0];
    out.extend((picture.sequence as u32).to_le_bytes());
    out.extend(picture.base_db.to_le_bytes());
    out.extend(picture.maximum_db.to_le_bytes());
    let mut count = 0_u16;
    for tile in picture.tiles_since(seen) {
        for place in tile.at {
            out.extend((place as u32).to_le_bytes());
        }
        for side in tile.size {
            out.extend((side as u16).to_le_bytes());
        }
        out.extend(&tile.levels);
        count += 1;
    }
    out[2..4].copy_from_slice(&count.to_le_bytes());
    out
}

fn traces(traces: &[ShownTrace]) -> Vec<u8> {
    let mut out = vec![2, 0];
    out.extend((traces.len() as u16).to_le_bytes());
    let first = traces.first().map_or(0, |trace| trace.number);
    out.extend((first as u32).to_le_bytes());
    out.extend((BINS as u16).to_le_bytes());
    out.extend([0, 0]);
    for trace in traces {
        out.extend(&trace.levels);
    }
    out
}
