//! Arrays cut into chunks of equal shape.

use num_complex::Complex32;

/// A value as stored in a chunk.
pub(crate) trait Stored: Copy + Sync {
    /// Fill value of a chunk beyond the edge of its array.
    const FILL: Self;
    /// Appends its bytes, the least significant first.
    fn put(self, bytes: &mut Vec<u8>);
}

impl Stored for f32 {
    const FILL: Self = Self::NAN;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for f64 {
    const FILL: Self = Self::NAN;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for i32 {
    const FILL: Self = 0;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for Complex32 {
    const FILL: Self = Self::new(f32::NAN, f32::NAN);
    fn put(self, bytes: &mut Vec<u8>) {
        self.re.put(bytes);
        self.im.put(bytes);
    }
}

/// Division of an array into chunks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut<'a> {
    pub shape: &'a [usize],
    pub chunk: &'a [usize],
}

impl Cut<'_> {
    /// Chunks along each dimension.
    pub fn counts(self) -> Vec<usize> {
        self.shape
            .iter()
            .zip(self.chunk)
            .map(|(n, c)| n.div_ceil(*c))
            .collect()
    }

    /// The bytes of the chunk at `index`, filled up beyond the array's edges.
    pub fn bytes<T: Stored>(self, values: &[T], index: &[usize]) -> Vec<u8> {
        let length: usize = self.chunk.iter().product();
        let mut bytes = Vec::with_capacity(length * size_of::<T>());
        let Some((row, outer)) = self.chunk.split_last() else {
            values.iter().for_each(|value| value.put(&mut bytes));
            return bytes;
        };
        let last = self.chunk.len() - 1;
        let columns = self.shape[last];
        let first = index[last] * row;
        let within = columns.saturating_sub(first).min(*row);
        for k in 0..outer.iter().product() {
            let mut inside = true;
            let mut start = 0;
            for (axis, offset) in unravelled(k, outer).iter().enumerate() {
                let place = index[axis] * self.chunk[axis] + offset;
                inside &= place < self.shape[axis];
                start = start * self.shape[axis] + place;
            }
            let kept = if inside { within } else { 0 };
            let from = start * columns + first;
            let line = if inside {
                &values[from..from + kept]
            } else {
                &[]
            };
            line.iter().for_each(|value| value.put(&mut bytes));
            (kept..*row).for_each(|_| T::FILL.put(&mut bytes));
        }
        bytes
    }
}

/// The indices of element `k`, counted row by row, of an array of these lengths.
pub(crate) fn unravelled(mut k: usize, lengths: &[usize]) -> Vec<usize> {
    let mut index = vec![0; lengths.len()];
    for (place, n) in index.iter_mut().zip(lengths).rev() {
        *place = k % n;
        k /= n;
    }
    index
}
