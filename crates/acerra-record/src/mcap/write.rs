//! Writing an MCAP file: chunks of messages, and at the end a summary of them.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::read::{MAGIC, kind};
use super::topics::Topic;

/// Bytes of messages after which a chunk is written.
const CHUNK_BYTES: usize = 1 << 20;

/// Place of a chunk, and its span of time.
struct ChunkPlace {
    start_ns: u64,
    end_ns: u64,
    offset: u64,
    bytes: u64,
    index_bytes: u64,
    indices: BTreeMap<u16, u64>,
    size: u64,
}

/// Writes messages of topics known from the beginning.
pub struct McapWriter<W> {
    out: W,
    written: u64,
    topics: Vec<Topic>,
    counts: Vec<u64>,
    chunk: Vec<u8>,
    /// Times and places of the chunk's messages, by topic.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
    span_ns: Option<[u64; 2]>,
    chunks: Vec<ChunkPlace>,
}

fn text(value: &str) -> Vec<u8> {
    let mut out = (value.len() as u32).to_le_bytes().to_vec();
    out.extend(value.as_bytes());
    out
}

fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut out = vec![kind];
    out.extend((content.len() as u64).to_le_bytes());
    out.extend(content);
    out
}

/// Schemas and channels: topic `k` has schema `k + 1` and channel `k + 1`.
fn definitions(topics: &[Topic]) -> Vec<u8> {
    let mut out = Vec::new();
    for (id, topic) in (1_u16..).zip(topics) {
        let mut schema = id.to_le_bytes().to_vec();
        for part in [topic.schema, "ros2msg", topic.definition] {
            schema.extend(text(part));
        }
        out.extend(record(kind::SCHEMA, &schema));
        let mut channel = [id.to_le_bytes(), id.to_le_bytes()].concat();
        channel.extend(text(topic.name));
        channel.extend(text("cdr"));
        channel.extend(0_u32.to_le_bytes());
        out.extend(record(kind::CHANNEL, &channel));
    }
    out
}

impl<W: Write> McapWriter<W> {
    /// Begins a file; `library` names the program.
    ///
    /// # Errors
    /// If the output fails.
    pub fn new(out: W, library: &str, topics: &[Topic]) -> io::Result<Self> {
        let mut writer = Self {
            out,
            written: 0,
            topics: topics.to_vec(),
            counts: vec![0; topics.len()],
            chunk: Vec::new(),
            index: BTreeMap::new(),
            span_ns: None,
            chunks: Vec::new(),
        };
        writer.put(&MAGIC)?;
        let header = [text("ros2"), text(library)].concat();
        writer.put(&record(kind::HEADER, &header))?;
        writer.put(&definitions(topics))?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.written += bytes.len() as u64;
        Ok(())
    }

    /// Adds a message of the topic with an index; one without such a topic is not written.
    ///
    /// # Errors
    /// If the output fails.
    pub fn message(&mut self, topic: usize, log_ns: u64, content: &[u8]) -> io::Result<()> {
        let Some(count) = self.counts.get_mut(topic) else {
            return Ok(());
        };
        let (id, sequence) = (topic as u16 + 1, *count as u32);
        *count += 1;
        let place = self.chunk.len() as u64;
        self.index.entry(id).or_default().push((log_ns, place));
        let [start_ns, end_ns] = self.span_ns.unwrap_or([log_ns; 2]);
        self.span_ns = Some([start_ns.min(log_ns), end_ns.max(log_ns)]);
        let mut message = id.to_le_bytes().to_vec();
        message.extend(sequence.to_le_bytes());
        message.extend(log_ns.to_le_bytes());
        message.extend(log_ns.to_le_bytes());
        message.extend(content);
        self.chunk.extend(record(kind::MESSAGE, &message));
        if self.chunk.len() >= CHUNK_BYTES {
            self.end_chunk()?;
        }
        Ok(())
    }

    fn end_chunk(&mut self) -> io::Result<()> {
        let Some([start_ns, end_ns]) = self.span_ns.take() else {
            return Ok(());
        };
        let records = std::mem::take(&mut self.chunk);
        let size = records.len() as u64;
        let mut content = [start_ns, end_ns, size].map(u64::to_le_bytes).concat();
        content.extend(crc32fast::hash(&records).to_le_bytes());
        content.extend(text(""));
        content.extend(size.to_le_bytes());
        content.extend(records);
        let offset = self.written;
        self.put(&record(kind::CHUNK, &content))?;
        let bytes = self.written - offset;
        let mut indices = BTreeMap::new();
        for (id, messages) in std::mem::take(&mut self.index) {
            indices.insert(id, self.written);
            let mut content = id.to_le_bytes().to_vec();
            content.extend((16 * messages.len() as u32).to_le_bytes());
            for (log_ns, place) in messages {
                content.extend(log_ns.to_le_bytes());
                content.extend(place.to_le_bytes());
            }
            self.put(&record(kind::MESSAGE_INDEX, &content))?;
        }
        self.chunks.push(ChunkPlace {
            start_ns,
            end_ns,
            offset,
            bytes,
            index_bytes: self.written - offset - bytes,
            indices,
            size,
        });
        Ok(())
    }

    /// Ends the file; returns the output.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.end_chunk()?;
        self.put(&record(kind::DATA_END, &[0; 4]))?;
        let summary_start = self.written;
        let definitions = definitions(&self.topics);
        self.put(&definitions)?;
        let statistics = self.statistics();
        self.put(&record(kind::STATISTICS, &statistics))?;
        for chunk in std::mem::take(&mut self.chunks) {
            self.put(&record(kind::CHUNK_INDEX, &chunk.index()))?;
        }
        let mut footer = summary_start.to_le_bytes().to_vec();
        // No offsets of groups in the summary, and no checksum of the summary.
        footer.extend([0; 12]);
        self.put(&record(kind::FOOTER, &footer))?;
        self.put(&MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn statistics(&self) -> Vec<u8> {
        let topics = self.topics.len();
        let mut content = self.counts.iter().sum::<u64>().to_le_bytes().to_vec();
        content.extend((topics as u16).to_le_bytes());
        content.extend((topics as u32).to_le_bytes());
        // Attachments and metadata.
        content.extend([0; 8]);
        content.extend((self.chunks.len() as u32).to_le_bytes());
        let start_ns = self.chunks.iter().map(|chunk| chunk.start_ns).min();
        let end_ns = self.chunks.iter().map(|chunk| chunk.end_ns).max();
        content.extend(start_ns.unwrap_or(0).to_le_bytes());
        content.extend(end_ns.unwrap_or(0).to_le_bytes());
        content.extend((10 * topics as u32).to_le_bytes());
        for (id, count) in (1_u16..).zip(&self.counts) {
            content.extend(id.to_le_bytes());
            content.extend(count.to_le_bytes());
        }
        content
    }
}

impl ChunkPlace {
    fn index(&self) -> Vec<u8> {
        let head = [self.start_ns, self.end_ns, self.offset, self.bytes];
        let mut content = head.map(u64::to_le_bytes).concat();
        content.extend((10 * self.indices.len() as u32).to_le_bytes());
        for (id, offset) in &self.indices {
            content.extend(id.to_le_bytes());
            content.extend(offset.to_le_bytes());
        }
        content.extend(self.index_bytes.to_le_bytes());
        content.extend(text(""));
        content.extend([self.size, self.size].map(u64::to_le_bytes).concat());
        content
    }
}
