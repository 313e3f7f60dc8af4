//! Image file directories of TIFF 6.0 and BigTIFF: tags with their values, and their lengths.

/// The value of a tag.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Ascii(String),
    Short(Vec<u16>),
    Long(Vec<u32>),
    Long8(Vec<u64>),
    Double(Vec<f64>),
}

impl Value {
    fn kind(&self) -> u16 {
        match self {
            Self::Ascii(_) => 2,
            Self::Short(_) => 3,
            Self::Long(_) => 4,
            Self::Double(_) => 12,
            Self::Long8(_) => 16,
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Ascii(text) => text.len() + 1,
            Self::Short(v) => v.len(),
            Self::Long(v) => v.len(),
            Self::Long8(v) => v.len(),
            Self::Double(v) => v.len(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Ascii(text) => text.bytes().chain([0]).collect(),
            Self::Short(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Long(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Long8(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::Double(v) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        }
    }
}

/// Classic TIFF up to 4 GiB, BigTIFF beyond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variant {
    Classic,
    Big,
}

impl Variant {
    /// Bytes of the file's header.
    pub fn header_bytes(self) -> u64 {
        match self {
            Self::Classic => 8,
            Self::Big => 16,
        }
    }

    /// The file's header, the first directory right behind it.
    pub fn header(self) -> Vec<u8> {
        let mut bytes = b"II".to_vec();
        match self {
            Self::Classic => {
                bytes.extend(42_u16.to_le_bytes());
                bytes.extend(8_u32.to_le_bytes());
            }
            Self::Big => {
                bytes.extend(43_u16.to_le_bytes());
                bytes.extend(8_u16.to_le_bytes());
                bytes.extend(0_u16.to_le_bytes());
                bytes.extend(16_u64.to_le_bytes());
            }
        }
        bytes
    }

    /// Bytes that a tag's value may take within the directory itself.
    fn inline_bytes(self) -> usize {
        match self {
            Self::Classic => 4,
            Self::Big => 8,
        }
    }

    fn number(self, value: u64) -> Vec<u8> {
        match self {
            Self::Classic => (value as u32).to_le_bytes().to_vec(),
            Self::Big => value.to_le_bytes().to_vec(),
        }
    }

    /// Offsets of tiles as a value of this variant.
    pub fn offsets(self, offsets: &[u64]) -> Value {
        match self {
            Self::Classic => Value::Long(offsets.iter().map(|o| *o as u32).collect()),
            Self::Big => Value::Long8(offsets.to_vec()),
        }
    }
}

/// Tags of one image, by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Directory {
    tags: Vec<(u16, Value)>,
}

impl Directory {
    pub fn set(&mut self, tag: u16, value: Value) {
        let place = self.tags.partition_point(|(other, _)| *other < tag);
        match self.tags.get_mut(place) {
            Some((other, old)) if *other == tag => *old = value,
            _ => self.tags.insert(place, (tag, value)),
        }
    }

    /// Bytes of the directory with all its values.
    pub fn len(&self, variant: Variant) -> u64 {
        self.encode(variant, 0, 0).len() as u64
    }

    /// Encodes the directory for the file offset `at`, followed by a directory at offset `next` (0: none).
    pub fn encode(&self, variant: Variant, at: u64, next: u64) -> Vec<u8> {
        let (count, entry) = match variant {
            Variant::Classic => ((self.tags.len() as u16).to_le_bytes().to_vec(), 12),
            Variant::Big => ((self.tags.len() as u64).to_le_bytes().to_vec(), 20),
        };
        let fixed = count.len() + entry * self.tags.len() + variant.inline_bytes();
        let mut head = count;
        let mut behind: Vec<u8> = Vec::new();
        for (tag, value) in &self.tags {
            head.extend(tag.to_le_bytes());
            head.extend(value.kind().to_le_bytes());
            head.extend(variant.number(value.count() as u64));
            let mut bytes = value.bytes();
            if bytes.len() <= variant.inline_bytes() {
                bytes.resize(variant.inline_bytes(), 0);
                head.extend(bytes);
            } else {
                // Values start at even offsets, as TIFF 6.0 asks.
                let start = at + (fixed + behind.len()) as u64;
                head.extend(variant.number(start));
                behind.extend(bytes);
                behind.resize(behind.len().next_multiple_of(8), 0);
            }
        }
        head.extend(variant.number(next));
        head.extend(behind);
        head.resize(head.len().next_multiple_of(2), 0);
        head
    }
}
