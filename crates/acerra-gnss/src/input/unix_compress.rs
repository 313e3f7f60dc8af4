//! UNIX `compress` (.Z): Lempel–Ziv–Welch with codes of growing width.

use std::io::{self, Read};

const FIRST_BITS: u32 = 9;
const MAX_BITS: u32 = 16;
/// Flag in the header: the code 256 empties the table.
const BLOCK_MODE: u8 = 0x80;
const CLEAR: usize = 256;

/// Decompresses a `.Z` stream.
///
/// The format is that of `compress` 4.0: two magic bytes `1F 9D`, a byte with the greatest code width (9 to
/// 16) and the block mode flag, then codes from the lowest bit up. Codes are written in groups of eight:
/// where the width grows or the table is emptied, the rest of a group is skipped.
///
/// Reading fails with [`io::ErrorKind::InvalidData`] where the stream cannot be one, and with
/// [`io::ErrorKind::UnexpectedEof`] where it ends within a code.
///
/// ```
/// use std::io::Read;
/// use acerra_gnss::input::UnixCompressed;
/// // "aaa": the code of "a", then 257, "aa".
/// let stream = [0x1F, 0x9D, 0x90, 0x61, 0x02, 0x02];
/// let mut text = String::new();
/// UnixCompressed::new(&stream[..]).read_to_string(&mut text)?;
/// assert_eq!(text, "aaa");
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct UnixCompressed<R> {
    inner: R,
    state: Option<State>,
    /// Decoded bytes not returned yet, the next one last.
    ready: Vec<u8>,
    /// Error behind the bytes last returned.
    failure: Option<io::Error>,
}

#[derive(Debug)]
struct State {
    max_bits: u32,
    block_mode: bool,
    bits: u32,
    /// Prefix code and last byte of each string from 256 on.
    table: Vec<(u16, u8)>,
    previous: Option<usize>,
    /// First byte of the string last decoded.
    first: u8,
    group: Group,
}

/// Eight codes of one width, which take as many bytes as the width has bits.
#[derive(Debug, Default)]
struct Group {
    bytes: Vec<u8>,
    at_bit: usize,
}

impl<R: Read> UnixCompressed<R> {
    /// Decompresses the stream `inner`.
    pub fn new(inner: R) -> Self {
        Self {
            inner,
            state: None,
            ready: Vec::new(),
            failure: None,
        }
    }

    /// Decodes the next string; false at the end.
    fn advance(&mut self) -> io::Result<bool> {
        let state = match &mut self.state {
            Some(state) => state,
            empty => empty.insert(State::header(&mut self.inner)?),
        };
        loop {
            let Some(code) = state.code(&mut self.inner)? else {
                return Ok(false);
            };
            if code == CLEAR && state.block_mode {
                state.clear();
                continue;
            }
            state.string(code, &mut self.ready)?;
            return Ok(true);
        }
    }
}

impl<R: Read> Read for UnixCompressed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let mut given = 0;
        while given < buffer.len() {
            if let Some(byte) = self.ready.pop() {
                buffer[given] = byte;
                given += 1;
            } else {
                match self.advance() {
                    Ok(true) => {}
                    Ok(false) => break,
                    // Decoded bytes are returned first.
                    Err(error) if given > 0 => {
                        self.failure = Some(error);
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(given)
    }
}

impl State {
    fn header(inner: &mut impl Read) -> io::Result<Self> {
        let mut header = [0; 3];
        inner.read_exact(&mut header)?;
        let [0x1F, 0x9D, flags] = header else {
            return Err(invalid("no compress header (1F 9D)"));
        };
        let max_bits = u32::from(flags & 0x1F);
        if !(FIRST_BITS..=MAX_BITS).contains(&max_bits) {
            return Err(invalid("a greatest code width other than 9 to 16 bits"));
        }
        let block_mode = flags & BLOCK_MODE != 0;
        Ok(Self {
            max_bits,
            block_mode,
            bits: FIRST_BITS,
            table: if block_mode { vec![(0, 0)] } else { Vec::new() },
            previous: None,
            first: 0,
            group: Group::default(),
        })
    }

    /// The first code not in the table.
    fn next_code(&self) -> usize {
        256 + self.table.len()
    }

    /// The next code; `None` at the end.
    fn code(&mut self, inner: &mut impl Read) -> io::Result<Option<usize>> {
        if self.next_code() > (1 << self.bits) - 1 && self.bits < self.max_bits {
            self.bits += 1;
            self.group = Group::default();
        }
        let width = self.bits as usize;
        if self.group.at_bit + width > 8 * self.group.bytes.len() {
            // At most the seven bits that fill the last byte may be left over at the end.
            let left = 8 * self.group.bytes.len() - self.group.at_bit;
            self.group = Group::default();
            inner
                .by_ref()
                .take(width as u64)
                .read_to_end(&mut self.group.bytes)?;
            if self.group.bytes.is_empty() && left < 8 {
                return Ok(None);
            }
            if 8 * self.group.bytes.len() < width {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
        }
        let mut code = 0;
        for i in 0..width {
            let at = self.group.at_bit + i;
            code |= usize::from(self.group.bytes[at / 8] >> (at % 8) & 1) << i;
        }
        self.group.at_bit += width;
        Ok(Some(code))
    }

    fn clear(&mut self) {
        self.table.truncate(1);
        self.bits = FIRST_BITS;
        self.previous = None;
        self.group = Group::default();
    }

    /// Puts the string of a code into `out`, last byte first, and the new string into the table.
    fn string(&mut self, code: usize, out: &mut Vec<u8>) -> io::Result<()> {
        let Some(previous) = self.previous else {
            let byte = u8::try_from(code).map_err(|_| invalid("a first code beyond 255"))?;
            out.push(byte);
            (self.previous, self.first) = (Some(code), byte);
            return Ok(());
        };
        let mut at = code;
        match code.cmp(&self.next_code()) {
            std::cmp::Ordering::Less => {}
            // The string about to be added: the last string and its first byte.
            std::cmp::Ordering::Equal => {
                out.push(self.first);
                at = previous;
            }
            std::cmp::Ordering::Greater => return Err(invalid("a code that is not in the table")),
        }
        while at >= 256 {
            let (prefix, byte) = self.table[at - 256];
            out.push(byte);
            at = usize::from(prefix);
        }
        self.first = at as u8;
        out.push(self.first);
        if self.next_code() < 1 << self.max_bits {
            self.table.push((previous as u16, self.first));
        }
        self.previous = Some(code);
        Ok(())
    }
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(
        io::ErrorKind::InvalidData,
        format!("not a compress (.Z) stream: {what}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(stream: &[u8]) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        UnixCompressed::new(stream).read_to_end(&mut out)?;
        Ok(out)
    }

    /// A stream of 9-bit codes in whole groups.
    fn stream(codes: &[usize]) -> Vec<u8> {
        let mut out = vec![0x1F, 0x9D, 0x90];
        for group in codes.chunks(8) {
            let mut bytes = vec![0_u8; (9 * group.len()).div_ceil(8)];
            for (i, code) in group.iter().enumerate() {
                for bit in (0..9).filter(|bit| code >> bit & 1 == 1) {
                    bytes[(9 * i + bit) / 8] |= 1 << ((9 * i + bit) % 8);
                }
            }
            out.extend(bytes);
        }
        out
    }

    #[test]
    fn strings_and_the_one_being_made() {
        let codes = [b'a', b'b'].map(usize::from);
        // a b ab aba (being made)
        let text = decoded(&stream(&[codes[0], codes[1], 257, 259])).unwrap();
        assert_eq!(text, b"abababa");
    }

    #[test]
    fn the_table_is_emptied_and_the_rest_of_the_group_passed_over() {
        let mut codes = vec![usize::from(b'x'), 257, 256, 0, 0, 0, 0, 0];
        codes.extend([usize::from(b'y'), 257]);
        assert_eq!(decoded(&stream(&codes)).unwrap(), b"xxxyyy");
    }

    #[test]
    fn what_is_no_stream_is_refused() {
        for (bad, kind) in [
            (vec![0x1F, 0x9D], io::ErrorKind::UnexpectedEof),
            (vec![0x1F, 0x9D, 0x88], io::ErrorKind::InvalidData),
            (vec![0x1F, 0x8B, 0x90], io::ErrorKind::InvalidData),
            (stream(&[300]), io::ErrorKind::InvalidData),
            (stream(&[65, 259]), io::ErrorKind::InvalidData),
            (stream(&[65])[..4].to_vec(), io::ErrorKind::UnexpectedEof),
        ] {
            assert_eq!(decoded(&bad).unwrap_err().kind(), kind, "{bad:x?}");
        }
        assert_eq!(decoded(&[0x1F, 0x9D, 0x90]).unwrap(), b"");
    }
}
