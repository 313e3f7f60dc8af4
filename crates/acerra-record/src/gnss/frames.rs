//! UBX frames in a receiver's bytes as they come.

use acerra_gnss::ubx::frame::{Frame, Piece, pieces};

/// Finds frames in bytes that come in chunks, with the time at which each one's first byte was there.
#[derive(Debug, Default)]
pub struct FrameFinder {
    held: Vec<u8>,
    /// Chunks of the buffer: offset of the first byte, host time (s).
    chunks: Vec<(usize, f64)>,
}

impl FrameFinder {
    /// Takes bytes that came at `host_s`, and hands every frame that is whole by now to `found`.
    pub fn take(&mut self, bytes: &[u8], host_s: f64, mut found: impl FnMut(&Frame<'_>, f64)) {
        self.chunks.push((self.held.len(), host_s));
        self.held.extend_from_slice(bytes);
        let mut through = 0;
        for piece in pieces(&self.held) {
            match piece {
                Piece::Frame(frame) => {
                    through = frame.offset + frame.payload.len() + 8;
                    let chunk = self.chunks.partition_point(|(at, _)| *at <= frame.offset);
                    let came_s = self.chunks[..chunk].last().map_or(host_s, |c| c.1);
                    found(&frame, came_s);
                }
                Piece::Outside { offset, bytes } => through = offset + bytes,
                Piece::BadChecksum { .. } => {}
                Piece::CutOff { .. } => break,
            }
        }
        self.drop_front(through);
    }

    fn drop_front(&mut self, bytes: usize) {
        self.held.drain(..bytes.min(self.held.len()));
        let first = self.chunks.partition_point(|(at, _)| *at <= bytes);
        // The chunk that the first byte left over lies in.
        self.chunks.drain(..first.saturating_sub(1));
        for (at, _) in &mut self.chunks {
            *at = at.saturating_sub(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_gnss::ubx::frame::encode;

    #[test]
    fn frames_cut_anywhere_are_found_with_the_time_of_their_first_byte() {
        let frames = [encode(2, 0x15, &[7; 40]), encode(0x0D, 3, &[1; 28])].map(Option::unwrap);
        let log = [b"$GNGGA\r\n".as_slice(), &frames[0], &frames[1]].concat();
        let begins = [8, 8 + frames[0].len()];
        for size in 1..log.len() {
            let mut finder = FrameFinder::default();
            let mut found = Vec::new();
            for (k, chunk) in log.chunks(size).enumerate() {
                finder.take(chunk, k as f64, |frame, host_s| {
                    found.push((frame.id, host_s));
                });
            }
            let expected = begins.map(|at| (at / size) as f64);
            assert_eq!(found, [(0x15, expected[0]), (3, expected[1])], "{size}");
        }
    }
}
