//! Tests that distinguish a message from damage: its kind, its length by definition, and the bytes after it.

use std::collections::HashMap;

use crate::bytes::array;

/// Length and type of a message (bytes).
pub const MESSAGE_HEADER: usize = 3;
/// A message that marks where reading may begin again.
const SYNC: [u8; 11] = [8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// Where the flags are: behind the file's header.
const FLAGS_AT: u64 = 16;
/// Sound messages one behind the other from which on a damaged log is read again: chance makes no such row.
const ROW: usize = 4;
/// Bytes of a text within which a definition's name must end.
const NAME: usize = 80;
/// Bytes that hold such a row, whatever its messages' lengths.
pub const SHOWN: usize = ROW * (MESSAGE_HEADER + (1 << 16));

/// Lengths of the subscribed topics' messages.
#[derive(Debug, Clone, Default)]
pub struct Framing {
    /// Fewest and most bytes behind the number of the subscription.
    lengths: HashMap<u16, [usize; 2]>,
}

impl Framing {
    /// Notes a subscription and the lengths of its messages.
    pub fn subscribe(&mut self, id: u16, lengths: [usize; 2]) {
        self.lengths.insert(id, lengths);
    }

    /// Whether a message may begin with these bytes, five or all that are left. Kinds of message that are not known may
    /// come, and kinds that check themselves are seen to be sound only once they are whole.
    pub fn may_begin(&self, start: &[u8]) -> bool {
        let [low, high, kind, ..] = *start else {
            return false;
        };
        let content = usize::from(u16::from_le_bytes([low, high]));
        let is_known = match (kind, array(start, MESSAGE_HEADER)) {
            (b'D', Some(id)) => {
                let lengths = self.lengths.get(&u16::from_le_bytes(id));
                lengths.is_some_and(|[_, most]| content <= most + 2)
            }
            _ => true,
        };
        content > 0 && kind.is_ascii_alphabetic() && is_known
    }

    /// Whether a whole message is valid by its content; none for kinds without such a test, which the
    /// following bytes decide. `offset` is its place in the file.
    pub fn checks(&self, message: &[u8], offset: u64) -> Option<bool> {
        match message[2] {
            b'D' => Some(true),
            b'B' => Some(offset == FLAGS_AT),
            b'L' => Some(matches!(message.get(3), Some(b'0'..=b'7'))),
            b'F' | b'A' | b'I' | b'P' | b'M' | b'Q' | b'O' | b'S' => {
                Some(self.length_of_sound(message).is_some())
            }
            _ => None,
        }
    }

    /// Whether a row of sound messages begins here, or a mark of synchronisation. `start` has [`SHOWN`] bytes, or all
    /// that are left.
    pub fn is_sound(&self, start: &[u8]) -> bool {
        if start.starts_with(&SYNC) {
            return true;
        }
        let mut rest = start;
        // Topics that the row itself subscribes.
        let mut new: Vec<&[u8]> = Vec::new();
        for _ in 0..ROW {
            let data_of = |id: &[u8]| {
                rest.get(2..5)
                    .is_some_and(|b| b[0] == b'D' && b[1..] == *id)
            };
            let whole = || {
                let length = MESSAGE_HEADER + usize::from(u16::from_le_bytes(array(rest, 0)?));
                (length <= rest.len()).then_some(length)
            };
            let is_new = new.iter().copied().any(data_of);
            let Some(length) = (if is_new {
                whole()
            } else {
                self.length_of_sound(rest)
            }) else {
                return false;
            };
            if rest[2] == b'A' {
                new.push(&rest[MESSAGE_HEADER + 1..][..2]);
            }
            rest = &rest[length..];
            if rest.is_empty() {
                break;
            }
        }
        true
    }

    /// Length of the whole message, of a known kind and as its kind asks for, that begins here.
    fn length_of_sound(&self, start: &[u8]) -> Option<usize> {
        let content = usize::from(u16::from_le_bytes(array(start, 0)?));
        let content = start.get(MESSAGE_HEADER..MESSAGE_HEADER + content)?;
        let is_sound = match start[2] {
            b'D' => {
                let lengths = self.lengths.get(&u16::from_le_bytes(array(content, 0)?))?;
                (lengths[0]..=lengths[1]).contains(&(content.len() - 2))
            }
            b'O' => content.len() == 2,
            b'S' => start.starts_with(&SYNC),
            b'L' => content.len() > 9 && matches!(content[0], b'0'..=b'7'),
            b'A' => content.len() > 3 && is_name(&content[3..]),
            b'F' => content[..content.len().min(NAME)].contains(&b':') && is_name(content),
            b'I' | b'P' => is_keyed(content),
            b'M' | b'Q' => is_keyed(content.get(1..)?),
            _ => false,
        };
        is_sound.then_some(MESSAGE_HEADER + content.len())
    }
}

/// Whether a content has its key's length, the key (`type name`), and a value.
fn is_keyed(content: &[u8]) -> bool {
    let Some((&length, rest)) = content.split_first() else {
        return false;
    };
    let key = rest.get(..usize::from(length)).unwrap_or_default();
    key.contains(&b' ') && is_name(key) && rest.len() > key.len()
}

/// Whether bytes begin with a name; only the first ones are read, so that the work per byte of the log is
/// bounded.
fn is_name(bytes: &[u8]) -> bool {
    let seen = &bytes[..bytes.len().min(NAME)];
    !seen.is_empty() && seen.iter().all(|b| matches!(b, b' '..=b'~'))
}
