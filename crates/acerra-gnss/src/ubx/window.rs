//! UBX checksums of any stretch of a log in a few steps, independent of the stretch's length.
//!
//! A log may be made so that a frame of 16 kB seems to begin at every sixth byte. The sums of the bytes of a
//! block, and of the bytes times their place, are kept for all prefixes of the block; a checksum follows from
//! the differences of two prefixes.

/// Longest plausible payload; a larger length field is noise.
pub const MAX_PAYLOAD_BYTES: usize = 16_376;

/// Bytes of a block whose sums are kept.
const BLOCK_BYTES: usize = 1 << 17;
/// Longest stretch: class, identifier, length and payload.
const LONGEST_BYTES: usize = MAX_PAYLOAD_BYTES + 4;

/// Sums of a block of a log, modulo 256.
#[derive(Debug, Clone, Default)]
pub(super) struct SumWindow {
    /// Offset of the block.
    first: usize,
    /// Prefix sums over the first k bytes: the sum of the bytes, and the sum of each byte times its place.
    sums: Vec<[u8; 2]>,
    /// Bytes that were summed.
    steps: u64,
}

impl SumWindow {
    /// The checksum of `log[from..to]`; `None` beyond the log or for a stretch longer than a frame.
    pub fn checksum(&mut self, log: &[u8], from: usize, to: usize) -> Option<[u8; 2]> {
        to.checked_sub(from).filter(|l| *l <= LONGEST_BYTES)?;
        log.get(from..to)?;
        if self.sums.is_empty() || from < self.first || to - self.first >= self.sums.len() {
            self.fill(log, from);
        }
        let (start, end) = (from - self.first, to - self.first);
        let ([a, b], [c, d]) = (self.sums[start], self.sums[end]);
        let sum = c.wrapping_sub(a);
        // A byte counts once for itself and once for each following byte.
        let weighted = (end as u8)
            .wrapping_mul(sum)
            .wrapping_sub(d.wrapping_sub(b));
        Some([sum, weighted])
    }

    fn fill(&mut self, log: &[u8], first: usize) {
        let end = log.len().min(first + BLOCK_BYTES + LONGEST_BYTES);
        self.first = first;
        self.sums.clear();
        let mut sums = [0_u8; 2];
        self.sums.push(sums);
        for (place, &byte) in log[first..end].iter().enumerate() {
            sums[0] = sums[0].wrapping_add(byte);
            sums[1] = sums[1].wrapping_add((place as u8).wrapping_mul(byte));
            self.sums.push(sums);
        }
        self.steps += (end - first) as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::super::frame::checksum;
    use super::*;

    #[test]
    fn stretches_have_the_checksum_of_their_bytes() {
        let log: Vec<u8> = (0..400_000_u32)
            .map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8)
            .collect();
        let mut window = SumWindow::default();
        for (from, length) in [
            (0, 0),
            (0, 16_380),
            (7, 3),
            (131_000, 1000),
            (390_000, 9_999),
            (5, 77),
        ] {
            let found = window.checksum(&log, from, from + length);
            assert_eq!(
                found,
                Some(checksum(&log[from..from + length])),
                "{from} {length}"
            );
        }
        assert_eq!(window.checksum(&log, 399_999, 400_001), None);
    }

    #[test]
    fn the_work_is_in_proportion_to_the_log() {
        let log: Vec<u8> = [0xB5, 0x62, 2, 0x15, 0xF8, 0x3F]
            .into_iter()
            .cycle()
            .take(1 << 20)
            .collect();
        let mut window = SumWindow::default();
        for from in (0..log.len() - LONGEST_BYTES).step_by(6) {
            window.checksum(&log, from, from + LONGEST_BYTES);
        }
        assert!(window.steps < 2 * log.len() as u64, "{}", window.steps);
    }
}
