//! Values in the file: in one piece, or in chunks that a B-tree lists (File Format Specification 3.0,
//! III.A.1).

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use super::object::{Messages, NOWHERE, length32};
use super::out::Out;
use crate::cut::{Cut, Stored, unravelled};

/// Values of a chunk along each dimension at most.
const CHUNK_SIDE: usize = 512;
/// Values of a chunk of an array of one dimension at most.
const CHUNK_LINE: usize = 1 << 16;
/// Arrays of fewer values are not compressed.
const LEAST_COMPRESSED: usize = 1024;
/// Level of compression.
const DEFLATE_LEVEL: u32 = 4;
/// Chunks compressed side by side before they are written.
const BATCH: usize = 32;
/// Entries of a node of the tree at most: twice the library's default.
const NODE_ENTRIES: usize = 64;

/// Storage of the values of an array.
#[derive(Clone, Debug)]
pub(super) enum Place {
    Contiguous {
        address: u64,
        bytes: u64,
    },
    Chunked {
        tree: u64,
        chunk: Vec<usize>,
        value_bytes: u32,
    },
}

impl Place {
    /// Values that nobody has written.
    pub(super) const fn nowhere(bytes: u64) -> Self {
        Self::Contiguous {
            address: NOWHERE,
            bytes,
        }
    }

    /// Writes the place of an object's values to its header.
    pub(super) fn describe(&self, messages: &mut Messages) {
        match self {
            Self::Contiguous { address, bytes } => messages.contiguous(*address, *bytes),
            Self::Chunked {
                tree,
                chunk,
                value_bytes,
            } => messages.chunked(*tree, chunk, *value_bytes, DEFLATE_LEVEL),
        }
    }
}

/// Writes the values of an array.
pub(super) fn write_values<T: Stored>(
    out: &mut Out<impl Write>,
    values: &[T],
    shape: &[usize],
) -> io::Result<Place> {
    if values.len() < LEAST_COMPRESSED {
        let mut bytes = Vec::new();
        values.iter().for_each(|value| value.put(&mut bytes));
        if bytes.is_empty() {
            return Ok(Place::nowhere(0));
        }
        return Ok(Place::Contiguous {
            address: out.put(&bytes)?,
            bytes: bytes.len() as u64,
        });
    }
    let most = if shape.len() == 1 {
        CHUNK_LINE
    } else {
        CHUNK_SIDE
    };
    let chunk: Vec<usize> = shape.iter().map(|n| (*n).clamp(1, most)).collect();
    let mut chunks = Chunks::new(chunk, size_of::<T>());
    chunks.write(out, values, shape, &[])?;
    chunks.finish(out)
}

/// An array being written chunk by chunk.
#[derive(Debug)]
pub(super) struct Chunks {
    chunk: Vec<usize>,
    value_bytes: usize,
    entries: Vec<Entry>,
}

impl Chunks {
    pub(super) const fn new(chunk: Vec<usize>, value_bytes: usize) -> Self {
        Self {
            chunk,
            value_bytes,
            entries: Vec::new(),
        }
    }

    /// An array of images that are written one by one.
    pub(super) fn of_images([rows, columns]: [usize; 2], value_bytes: usize) -> Self {
        let side = |n: usize| n.clamp(1, CHUNK_SIDE);
        Self::new(vec![1, side(rows), side(columns)], value_bytes)
    }

    /// Writes `values` of this shape at the indices `before` of the array's slower dimensions, along which
    /// chunks hold one value each.
    pub(super) fn write<T: Stored>(
        &mut self,
        out: &mut Out<impl Write>,
        values: &[T],
        shape: &[usize],
        before: &[usize],
    ) -> io::Result<()> {
        let cut = Cut {
            shape,
            chunk: &self.chunk[before.len()..],
        };
        let counts = cut.counts();
        let count: usize = counts.iter().product();
        for first in (0..count).step_by(BATCH) {
            let numbers = first..(first + BATCH).min(count);
            let batch: Vec<_> = numbers
                .into_par_iter()
                .map(|k| {
                    let index = unravelled(k, &counts);
                    let bytes = deflated(&shuffled(&cut.bytes(values, &index), size_of::<T>()))?;
                    Ok(([before, &index].concat(), bytes))
                })
                .collect::<io::Result<_>>()?;
            for (index, bytes) in batch {
                let child = out.put(&bytes)?;
                self.entries.push(Entry {
                    key: Key::of(&index, &self.chunk, bytes.len()),
                    child,
                });
            }
        }
        Ok(())
    }

    /// Lists the chunks: the array is complete.
    pub(super) fn finish(self, out: &mut Out<impl Write>) -> io::Result<Place> {
        let Some(last) = self.entries.last() else {
            return Ok(Place::nowhere(0));
        };
        let end = last.key.beyond(&self.chunk);
        Ok(Place::Chunked {
            tree: write_tree(out, self.entries, &end)?,
            chunk: self.chunk,
            value_bytes: length32(self.value_bytes),
        })
    }
}

/// Bytes in the order of their significance: the first of every value, then the second, …
fn shuffled(bytes: &[u8], value_bytes: usize) -> Vec<u8> {
    (0..value_bytes)
        .flat_map(|k| bytes.iter().skip(k).step_by(value_bytes).copied())
        .collect()
}

fn deflated(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::new(DEFLATE_LEVEL));
    zlib.write_all(bytes)?;
    zlib.finish()
}

/// Size of a chunk in the file, and the indices of its first value.
#[derive(Clone, Debug)]
struct Key {
    bytes: u32,
    offset: Vec<u64>,
}

impl Key {
    fn of(index: &[usize], chunk: &[usize], bytes: usize) -> Self {
        let offset = index.iter().zip(chunk).map(|(k, n)| (k * n) as u64);
        Self {
            bytes: length32(bytes),
            offset: offset.collect(),
        }
    }

    /// The key after that of the last chunk: one chunk further in every dimension.
    fn beyond(&self, chunk: &[usize]) -> Self {
        let offset = self.offset.iter().zip(chunk).map(|(o, n)| o + *n as u64);
        Self {
            bytes: 0,
            offset: offset.collect(),
        }
    }

    fn put(&self, out: &mut Vec<u8>) {
        out.extend(self.bytes.to_le_bytes());
        // No filter was left out.
        out.extend([0; 4]);
        for offset in &self.offset {
            out.extend(offset.to_le_bytes());
        }
        // Of the bytes of a value, which count as a dimension more.
        out.extend([0; 8]);
    }

    fn size(&self) -> usize {
        8 + 8 * (self.offset.len() + 1)
    }
}

/// A child of a node, and its first key.
#[derive(Clone, Debug)]
struct Entry {
    key: Key,
    child: u64,
}

/// Writes the nodes of a tree, level by level, and returns the address of its root.
fn write_tree(out: &mut Out<impl Write>, mut entries: Vec<Entry>, last: &Key) -> io::Result<u64> {
    let mut level = 0;
    loop {
        let nodes: Vec<&[Entry]> = entries.chunks(NODE_ENTRIES).collect();
        let node_bytes = 24 + NODE_ENTRIES * 8 + (NODE_ENTRIES + 1) * last.size();
        out.align()?;
        let first = out.position();
        let at = |k: usize| first + (k * node_bytes) as u64;
        let mut above = Vec::with_capacity(nodes.len());
        for (k, node) in nodes.iter().enumerate() {
            let next = nodes.get(k + 1);
            let end = next.map_or(last, |next| &next[0].key);
            let before = if k == 0 { NOWHERE } else { at(k - 1) };
            let after = next.map_or(NOWHERE, |_| at(k + 1));
            let mut bytes = b"TREE\x01".to_vec();
            bytes.push(level);
            bytes.extend(u16::try_from(node.len()).unwrap_or(u16::MAX).to_le_bytes());
            bytes.extend(before.to_le_bytes());
            bytes.extend(after.to_le_bytes());
            for entry in *node {
                entry.key.put(&mut bytes);
                bytes.extend(entry.child.to_le_bytes());
            }
            end.put(&mut bytes);
            bytes.resize(node_bytes, 0);
            above.push(Entry {
                key: node[0].key.clone(),
                child: out.put(&bytes)?,
            });
        }
        if let [root] = above.as_slice() {
            return Ok(root.child);
        }
        entries = above;
        level += 1;
    }
}
