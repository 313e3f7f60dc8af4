//! Messages on a stream of bytes, as USB and serial links carry them: 0xA5A5, the body's length
//! (u16, big-endian), the body.

use acerra_radar::mrm::{MessageType, SERIAL_PREFIX};

use crate::message::MAX_MESSAGE_BYTES;

const PREFIX_BYTES: usize = 4;

/// A message body behind its prefix. `None` for a body longer than any message.
///
/// ```
/// use acerra_record::link::frame_body;
/// assert_eq!(frame_body(&[0xF0, 2, 0, 7]).unwrap(), [0xA5, 0xA5, 0, 4, 0xF0, 2, 0, 7]);
/// ```
#[must_use]
pub fn frame_body(body: &[u8]) -> Option<Vec<u8>> {
    let length = u16::try_from(body.len()).ok()?;
    if body.len() > MAX_MESSAGE_BYTES {
        return None;
    }
    let mut framed = Vec::with_capacity(PREFIX_BYTES + body.len());
    framed.extend_from_slice(&SERIAL_PREFIX);
    framed.extend_from_slice(&length.to_be_bytes());
    framed.extend_from_slice(body);
    Some(framed)
}

/// Cuts message bodies out of a stream of bytes and finds the next one after damage. Buffers at most one
/// message in addition to the bytes of one push.
#[derive(Debug, Default)]
pub struct Deframer {
    buffer: Vec<u8>,
    skipped: u64,
}

impl Deframer {
    /// Takes bytes in as they come.
    pub fn push(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    /// Bytes so far that belong to no message.
    #[must_use]
    pub fn skipped_bytes(&self) -> u64 {
        self.skipped
    }

    /// The next whole body, if there is one. A prefix counts only before a known message type of the right
    /// length: 0xA5A5 occurs among samples by chance.
    pub fn next_body(&mut self) -> Option<Vec<u8>> {
        loop {
            let Some(start) = self.next_prefix() else {
                // The last byte may be half a prefix.
                let keep = usize::from(self.buffer.last() == Some(&SERIAL_PREFIX[0]));
                self.skip(self.buffer.len() - keep);
                return None;
            };
            self.skip(start);
            let head = self.buffer.get(PREFIX_BYTES..PREFIX_BYTES + 2)?;
            let length = usize::from(u16::from_be_bytes([self.buffer[2], self.buffer[3]]));
            let kind = MessageType::from_code(u16::from_be_bytes([head[0], head[1]]));
            if kind.is_none_or(|kind| kind.bytes() != length) {
                self.skip(1);
                continue;
            }
            let end = PREFIX_BYTES + length;
            if self.buffer.len() < end {
                return None;
            }
            let body = self.buffer[PREFIX_BYTES..end].to_vec();
            self.buffer.drain(..end);
            return Some(body);
        }
    }

    fn next_prefix(&self) -> Option<usize> {
        self.buffer.windows(2).position(|w| w == SERIAL_PREFIX)
    }

    fn skip(&mut self, bytes: usize) {
        self.buffer.drain(..bytes);
        self.skipped += bytes as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bodies(deframer: &mut Deframer) -> Vec<Vec<u8>> {
        std::iter::from_fn(|| deframer.next_body()).collect()
    }

    #[test]
    fn bodies_among_noise_come_whole_however_the_bytes_are_cut() {
        let wanted = [vec![0xF0, 2, 0, 7], vec![0x11, 1, 0, 8, 0, 0, 0, 0]];
        let mut stream = vec![0xA5, 0x00, 0xA5, 0xA5, 0xA5, 0xA5, 0, 4, 0x77, 0x77];
        stream.extend(frame_body(&wanted[0]).unwrap());
        stream.extend(b"noise");
        stream.extend(frame_body(&wanted[1]).unwrap());
        for chunk in 1..stream.len() {
            let mut deframer = Deframer::default();
            let mut found = Vec::new();
            for bytes in stream.chunks(chunk) {
                deframer.push(bytes);
                found.extend(bodies(&mut deframer));
            }
            assert_eq!(found, wanted, "in chunks of {chunk}");
            assert_eq!(deframer.skipped_bytes(), 10 + 5);
        }
    }

    #[test]
    fn a_body_that_is_too_long_is_refused() {
        assert_eq!(frame_body(&vec![0; MAX_MESSAGE_BYTES + 1]), None);
    }
}
