//! TIFF files that tests make.
#![allow(dead_code)] // Each test program uses a part.

/// A little-endian TIFF of one image, from its tags.
pub struct Tiff {
    pub entries: Vec<(u16, u16, u32, Vec<u8>)>,
    pub chunks: Vec<Vec<u8>>,
    pub tiled: bool,
}

impl Tiff {
    pub fn new(columns: u32, rows: u32, bits: u16, format: u16) -> Self {
        let mut tiff = Self {
            entries: Vec::new(),
            chunks: Vec::new(),
            tiled: false,
        };
        tiff.long(256, columns);
        tiff.long(257, rows);
        tiff.short(258, &[bits]);
        tiff.short(259, &[1]);
        tiff.short(262, &[1]);
        tiff.short(277, &[1]);
        tiff.short(339, &[format]);
        tiff
    }
    pub fn short(&mut self, tag: u16, v: &[u16]) {
        let bytes = v.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entries.push((tag, 3, v.len() as u32, bytes));
    }
    pub fn long(&mut self, tag: u16, v: u32) {
        self.entries.push((tag, 4, 1, v.to_le_bytes().to_vec()));
    }
    pub fn double(&mut self, tag: u16, v: &[f64]) {
        let bytes = v.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entries.push((tag, 12, v.len() as u32, bytes));
    }
    pub fn text(&mut self, tag: u16, v: &str) {
        let bytes: Vec<u8> = v.bytes().chain([0]).collect();
        self.entries.push((tag, 2, bytes.len() as u32, bytes));
    }
    /// Cuts `value(column, row)` into strips of so many rows.
    pub fn strips(&mut self, size: [u32; 2], rows: u32, value: impl Fn(u32, u32) -> Vec<u8>) {
        self.long(278, rows);
        for first in (0..size[1]).step_by(rows as usize) {
            let lines = first..(first + rows).min(size[1]);
            let cells = lines.flat_map(|j| (0..size[0]).map(move |i| (i, j)));
            self.chunks
                .push(cells.flat_map(|(i, j)| value(i, j)).collect());
        }
    }
    /// Cuts it into tiles, zeros beyond the edge.
    pub fn tiles(&mut self, size: [u32; 2], side: u32, value: impl Fn(u32, u32) -> Vec<u8>) {
        self.tiled = true;
        self.long(322, side);
        self.long(323, side);
        let width = value(0, 0).len();
        for j0 in (0..size[1]).step_by(side as usize) {
            for i0 in (0..size[0]).step_by(side as usize) {
                let cells = (j0..j0 + side).flat_map(|j| (i0..i0 + side).map(move |i| (i, j)));
                let at = |(i, j): (u32, u32)| {
                    if i < size[0] && j < size[1] {
                        value(i, j)
                    } else {
                        vec![0; width]
                    }
                };
                self.chunks.push(cells.flat_map(at).collect());
            }
        }
    }
    pub fn bytes(self) -> Vec<u8> {
        let mut out = b"II*\0\0\0\0\0".to_vec();
        self.append(&mut out, 4);
        out
    }
    /// With a second image behind.
    pub fn bytes_with(self, second: Self) -> Vec<u8> {
        let mut out = b"II*\0\0\0\0\0".to_vec();
        let next = self.append(&mut out, 4);
        second.append(&mut out, next);
        out
    }
    /// Appends content and directory, whose offset goes to `link`; gives the place of the next link.
    fn append(mut self, out: &mut Vec<u8>, link: usize) -> usize {
        let mut offsets = Vec::new();
        let mut counts = Vec::new();
        for chunk in &self.chunks {
            offsets.extend((out.len() as u32).to_le_bytes());
            counts.extend((chunk.len() as u32).to_le_bytes());
            out.extend(chunk);
        }
        let n = self.chunks.len() as u32;
        let (o, c) = if self.tiled { (324, 325) } else { (273, 279) };
        self.entries.push((o, 4, n, offsets));
        self.entries.push((c, 4, n, counts));
        // A tag that was set twice keeps the last.
        let mut entries = std::collections::BTreeMap::new();
        for (tag, kind, count, bytes) in self.entries {
            entries.insert(tag, (kind, count, bytes));
        }
        let mut directory = (entries.len() as u16).to_le_bytes().to_vec();
        for (tag, (kind, count, bytes)) in entries {
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend(count.to_le_bytes());
            if bytes.len() <= 4 {
                directory.extend(&bytes);
                directory.resize(directory.len() + 4 - bytes.len(), 0);
            } else {
                directory.extend((out.len() as u32).to_le_bytes());
                out.extend(bytes);
            }
        }
        let at = out.len() as u32;
        out[link..link + 4].copy_from_slice(&at.to_le_bytes());
        out.extend(directory);
        out.extend([0; 4]);
        out.len() - 4
    }
}

/// GeoKeys of a projected (1) or geographic (2) system.
pub fn keys(model: u16, raster: u16, crs: u16) -> Vec<u16> {
    let key = if model == 1 { 3072 } else { 2048 };
    vec![
        1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, raster, key, 0, 1, crs,
    ]
}
