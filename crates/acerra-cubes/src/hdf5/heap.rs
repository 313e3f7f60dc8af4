//! The global heap: texts and lists of any length (File Format Specification 3.0, III.E).

/// Bytes that a collection takes at least.
const LEAST_BYTES: usize = 4096;
/// Objects of a collection at most: they are numbered with 16 bits.
const MOST_OBJECTS: usize = 60_000;

/// Reference to an object in the heap: number of the collection, index of the object in the collection, length
/// of the object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    collection: usize,
    object: u32,
    length: u32,
}

/// Objects, which come into the file after everything that refers to them is known.
#[derive(Debug, Default)]
pub(super) struct Heap {
    collections: Vec<Vec<Vec<u8>>>,
}

impl Heap {
    /// Puts an object of `length` elements in.
    pub(super) fn hold(&mut self, bytes: Vec<u8>, length: u32) -> Held {
        if self
            .collections
            .last()
            .is_none_or(|last| last.len() >= MOST_OBJECTS)
        {
            self.collections.push(Vec::new());
        }
        let collection = self.collections.len() - 1;
        let objects = &mut self.collections[collection];
        objects.push(bytes);
        Held {
            collection,
            // Numbers begin at one.
            object: u32::try_from(objects.len()).unwrap_or(u32::MAX),
            length,
        }
    }

    /// Replaces the content by one of equal length.
    pub(super) fn replace(&mut self, held: Held, bytes: Vec<u8>) {
        self.collections[held.collection][held.object as usize - 1] = bytes;
    }

    /// Bytes of every collection.
    pub(super) fn sizes(&self) -> Vec<usize> {
        self.collections
            .iter()
            .map(|c| collection_bytes(c))
            .collect()
    }

    /// The collections as encoded in the file.
    pub(super) fn encoded(&self) -> Vec<Vec<u8>> {
        self.collections.iter().map(|c| encoded(c)).collect()
    }
}

impl Held {
    /// Pointer that an attribute stores instead of the object, given the addresses of the `collections`.
    pub(super) fn pointer(self, collections: &[u64]) -> Vec<u8> {
        let mut out = self.length.to_le_bytes().to_vec();
        out.extend(collections[self.collection].to_le_bytes());
        out.extend(self.object.to_le_bytes());
        out
    }
}

fn padded(bytes: usize) -> usize {
    bytes.div_ceil(8) * 8
}

fn collection_bytes(objects: &[Vec<u8>]) -> usize {
    let held: usize = objects.iter().map(|o| 16 + padded(o.len())).sum();
    // Header before, header of the free space after.
    (16 + held + 16).max(LEAST_BYTES)
}

fn encoded(objects: &[Vec<u8>]) -> Vec<u8> {
    let size = collection_bytes(objects);
    let mut out = Vec::with_capacity(size);
    out.extend(b"GCOL\x01\0\0\0");
    out.extend((size as u64).to_le_bytes());
    for (index, object) in (1_u16..).zip(objects) {
        out.extend(index.to_le_bytes());
        // One reference, and four bytes reserved.
        out.extend([1, 0, 0, 0, 0, 0]);
        out.extend((object.len() as u64).to_le_bytes());
        out.extend(object);
        out.resize(padded(out.len()), 0);
    }
    // Object 0 is the free space, its header included.
    let free = size - out.len();
    out.extend([0; 8]);
    out.extend((free as u64).to_le_bytes());
    out.resize(size, 0);
    out
}
