//! CRC-24Q of any stretch of a log in a few steps, independent of the stretch's length.
//!
//! A hostile log may have the apparent beginning of a message of 1 kB at every third byte. The remainders of
//! all prefixes of a block are kept. As the code is linear, the remainder of a stretch is the remainder of
//! the prefix at its end, less the remainder of the prefix at its beginning shifted by the stretch's length.

use crate::orbits::bits::crc24q_step;

/// Bytes of a block whose remainders are kept.
const BLOCK_BYTES: usize = 1 << 16;
/// Longest stretch: a message with its header.
const LONGEST_BYTES: usize = 1026;
const POLYNOMIAL: u32 = 0x186_4CFB;

/// x^(8 k) modulo the polynomial: the factor on a remainder for k further bytes.
static MOVED: [u32; LONGEST_BYTES + 1] = {
    let mut table = [1; LONGEST_BYTES + 1];
    let mut k = 1;
    while k <= LONGEST_BYTES {
        table[k] = multiplied(table[k - 1], 1 << 8);
        k += 1;
    }
    table
};

/// Remainders of a block of a log.
#[derive(Debug, Clone, Default)]
pub(super) struct CrcWindow {
    /// Offset of the block.
    first: usize,
    /// Remainder of the first k bytes of the block.
    remainder: Vec<u32>,
    /// Bytes that went through the code.
    steps: u64,
}

impl CrcWindow {
    /// The remainder of `log[from..to]`; `None` beyond the log or for a stretch longer than a message.
    pub fn crc(&mut self, log: &[u8], from: usize, to: usize) -> Option<u32> {
        let length = to.checked_sub(from).filter(|l| *l <= LONGEST_BYTES)?;
        log.get(from..to)?;
        if self.remainder.is_empty() || from < self.first || to - self.first >= self.remainder.len()
        {
            self.fill(log, from);
        }
        let (a, b) = (from - self.first, to - self.first);
        let moved = multiplied(self.remainder[a], MOVED[length]);
        Some(self.remainder[b] ^ moved)
    }

    fn fill(&mut self, log: &[u8], first: usize) {
        let end = log.len().min(first + BLOCK_BYTES + LONGEST_BYTES);
        self.first = first;
        self.remainder.clear();
        let mut crc = 0;
        self.remainder.push(crc);
        for &byte in &log[first..end] {
            crc = crc24q_step(crc, byte);
            self.remainder.push(crc);
        }
        self.steps += (end - first) as u64;
    }
}

/// The product of two polynomials of 24 bits, modulo the code's polynomial.
const fn multiplied(a: u32, b: u32) -> u32 {
    let mut product = 0;
    let mut bit = 24;
    while bit > 0 {
        bit -= 1;
        product <<= 1;
        if product & 0x100_0000 != 0 {
            product ^= POLYNOMIAL;
        }
        if b >> bit & 1 != 0 {
            product ^= a;
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbits::bits::crc24q;

    #[test]
    fn stretches_have_the_remainder_of_their_bytes() {
        let log: Vec<u8> = (0..200_000_u32)
            .map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8)
            .collect();
        let mut window = CrcWindow::default();
        for (from, length) in [
            (0, 0),
            (0, 1026),
            (7, 3),
            (65_530, 1000),
            (65_000, 1026),
            (150_000, 999),
            (3, 9),
        ] {
            let found = window.crc(&log, from, from + length);
            assert_eq!(
                found,
                Some(crc24q(&log[from..from + length])),
                "{from} {length}"
            );
        }
        assert_eq!(window.crc(&log, 199_999, 200_001), None);
        assert_eq!(window.crc(&log, 0, 1027), None);
    }

    /// A message of the longest kind seems to begin at every third byte: the work stays in proportion to the log.
    #[test]
    fn the_work_is_in_proportion_to_the_log() {
        let log: Vec<u8> = [0xD3, 0x03, 0xFF]
            .into_iter()
            .cycle()
            .take(1 << 20)
            .collect();
        let mut window = CrcWindow::default();
        for from in (0..log.len() - 1026).step_by(3) {
            window.crc(&log, from, from + 1026);
        }
        assert!(window.steps < 2 * log.len() as u64, "{}", window.steps);
    }
}
