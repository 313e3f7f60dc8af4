//! Expanding compact RINEX epoch by epoch.

use std::collections::{HashMap, VecDeque};

use super::difference::{Arc, fixed_point, patch_text};
use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};

/// Columns in the lines of one version.
#[derive(Debug, Clone, Copy)]
struct Layout {
    version: u8,
    /// First character of an initialised epoch line.
    start: u8,
    flag: usize,
    count: usize,
    satellites: usize,
    clock_decimals: usize,
}

const VERSION_1: Layout = Layout {
    version: 1,
    start: b'&',
    flag: 28,
    count: 29,
    satellites: 32,
    clock_decimals: 9,
};
const VERSION_3: Layout = Layout {
    version: 3,
    start: b'>',
    flag: 31,
    count: 32,
    satellites: 41,
    clock_decimals: 12,
};

#[derive(Debug, Clone, Default)]
struct SatelliteState {
    arcs: Vec<Option<Arc>>,
    flags: Vec<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Header,
    Epochs,
    /// No data can be decoded until the next initialised epoch line.
    Resynchronise,
}

/// The RINEX lines of a Hatanaka-compressed file, as a [`LineSource`].
///
/// Damage is contained: a broken difference makes the value absent until the arc of the value starts again; a
/// broken epoch line drops epochs until the next initialised one; an incomplete last epoch is dropped. All
/// are counted in the report.
#[derive(Debug)]
pub struct CrinexLines<S> {
    source: S,
    layout: Layout,
    stage: Stage,
    /// Observation types by system letter (version 1: under a blank).
    types: HashMap<u8, usize>,
    declaring: u8,
    epoch: Vec<u8>,
    clock: Option<Arc>,
    satellites: HashMap<[u8; 3], SatelliteState>,
    ready: VecDeque<(u64, Vec<u8>)>,
    current: (u64, Vec<u8>),
    report: ReadReport,
}

impl<S: LineSource> CrinexLines<S> {
    /// Reads the two lines that make a file compact RINEX; the RINEX header follows as lines.
    ///
    /// # Errors
    /// [`ReadError::Format`] where the lines are not those of compact RINEX, [`ReadError::Unsupported`] for a
    /// version other than 1 and 3.
    pub fn new(mut source: S) -> Result<Self, ReadError> {
        if !source.advance()? {
            return Err(ReadError::Empty);
        }
        let line = source.line();
        if !line
            .get(60..)
            .is_some_and(|label| label.starts_with(b"CRINEX VERS"))
        {
            return Err(ReadError::format(
                source.number(),
                "CRINEX VERS   / TYPE",
                line,
            ));
        }
        let layout = match line[..20].trim_ascii() {
            [b'1', b'.', ..] => VERSION_1,
            [b'3', b'.', ..] => VERSION_3,
            other => {
                return Err(ReadError::Unsupported {
                    line: source.number(),
                    what: format!("compact RINEX version {}", String::from_utf8_lossy(other)),
                });
            }
        };
        if !source.advance()? || !source.line().windows(11).any(|w| w == b"CRINEX PROG") {
            let line = source.line().to_vec();
            return Err(ReadError::format(
                source.number(),
                "CRINEX PROG / DATE",
                &line,
            ));
        }
        Ok(Self {
            source,
            layout,
            stage: Stage::Header,
            types: HashMap::new(),
            declaring: b' ',
            epoch: Vec::new(),
            clock: None,
            satellites: HashMap::new(),
            ready: VecDeque::new(),
            current: (0, Vec::new()),
            report: ReadReport::default(),
        })
    }

    /// Version of the compact format, 1 or 3.
    pub fn version(&self) -> u8 {
        self.layout.version
    }

    fn place(&self) -> Place {
        Place::Line(self.source.number())
    }

    /// Takes the number of observation types from a header line.
    fn note_types(&mut self, line: &[u8]) {
        let Some(label) = line.get(60..) else { return };
        if label.starts_with(b"# / TYPES OF OBSERV") {
            if let Some(n) = number(&line[..6]) {
                self.types.insert(b' ', n);
            }
        } else if label.starts_with(b"SYS / # / OBS TYPES") {
            if line[0] != b' ' {
                self.declaring = line[0];
            }
            if let Some(n) = number(&line[3..6]) {
                self.types.insert(self.declaring, n);
            }
        }
    }

    fn header_line(&mut self) {
        let line = self.source.line().to_vec();
        self.note_types(&line);
        if line
            .get(60..)
            .is_some_and(|label| label.starts_with(b"END OF HEADER"))
        {
            self.stage = Stage::Epochs;
        }
        self.ready.push_back((self.source.number(), line));
    }

    /// Decodes one epoch that starts at the current line of the source.
    fn decode_epoch(&mut self) -> Result<(), ReadError> {
        let line = self.source.line();
        let fresh = line.first() == Some(&self.layout.start);
        if fresh {
            self.epoch.clear();
            self.epoch.extend_from_slice(line);
            if self.layout.version == 1 {
                self.epoch[0] = b' ';
            }
            self.satellites.clear();
            self.clock = None;
            self.stage = Stage::Epochs;
        } else if self.stage == Stage::Resynchronise {
            self.report
                .drop_one(DropReason::BrokenDifference, self.place());
            return Ok(());
        } else {
            let line = line.to_vec();
            patch_text(&mut self.epoch, &line);
        }
        let flag = self.epoch.get(self.layout.flag).copied().unwrap_or(b' ');
        let Some(count) = self
            .epoch
            .get(self.layout.count..self.layout.count + 3)
            .and_then(number)
        else {
            self.report
                .drop_one(DropReason::UnreadableEpoch, self.place());
            self.stage = Stage::Resynchronise;
            return Ok(());
        };
        if matches!(flag, b'2'..=b'6') {
            return self.event(count);
        }
        self.observations(count)
    }

    /// An event: its lines are uncompressed, and the next epoch restarts every arc.
    fn event(&mut self, count: usize) -> Result<(), ReadError> {
        let mut lines = vec![(self.source.number(), self.epoch.trim_ascii_end().to_vec())];
        for _ in 0..count {
            if !self.source.advance()? {
                self.report.drop_one(DropReason::CutOff, self.place());
                return Ok(());
            }
            let line = self.source.line().to_vec();
            self.note_types(&line);
            lines.push((self.source.number(), line));
        }
        self.ready.extend(lines);
        self.stage = Stage::Resynchronise;
        Ok(())
    }

    fn observations(&mut self, count: usize) -> Result<(), ReadError> {
        let first = self.layout.satellites;
        let mut names: Vec<[u8; 3]> = Vec::new();
        for i in 0..count {
            match self.epoch.get(first + 3 * i..first + 3 * i + 3) {
                Some(&[a, b, c]) => names.push([a, b, c]),
                _ => {
                    self.report
                        .drop_one(DropReason::UnreadableEpoch, self.place());
                    self.stage = Stage::Resynchronise;
                    return Ok(());
                }
            }
        }
        let epoch_number = self.source.number();
        if !self.source.advance()? {
            self.report.drop_one(DropReason::CutOff, self.place());
            return Ok(());
        }
        let clock_field = self.source.line().trim_ascii();
        self.clock = if clock_field.is_empty() {
            None
        } else {
            let next = Arc::step(self.clock, clock_field);
            if next.is_none() {
                self.report
                    .drop_one(DropReason::BrokenDifference, self.place());
            }
            next
        };
        let mut decoded: Vec<(u64, [u8; 3], Vec<u8>)> = Vec::with_capacity(names.len());
        let mut states = HashMap::with_capacity(names.len());
        for &name in &names {
            if !self.source.advance()? || !self.source.terminated() && self.cut_inside() {
                self.report.drop_one(DropReason::CutOff, self.place());
                return Ok(());
            }
            let system = if self.layout.version == 1 {
                b' '
            } else {
                name[0]
            };
            let Some(&types) = self.types.get(&system) else {
                self.report.drop_one(
                    DropReason::UnknownSatellite(String::from_utf8_lossy(&name).into_owned()),
                    self.place(),
                );
                continue;
            };
            let mut state = self.satellites.remove(&name).unwrap_or_default();
            let fields = decode_fields(
                &mut state,
                types,
                self.layout.version,
                self.source.line(),
                |_| {
                    self.report.drop_one(
                        DropReason::BrokenDifference,
                        Place::Line(self.source.number()),
                    );
                },
            );
            decoded.push((self.source.number(), name, fields));
            states.insert(name, state);
        }
        self.satellites = states;
        self.emit(epoch_number, &decoded);
        Ok(())
    }

    /// Whether an unterminated last line may be only a part of the line. Compact lines carry no
    /// widths, so any line without its line feed could have lost digits.
    fn cut_inside(&self) -> bool {
        !self.source.line().is_empty()
    }

    /// Queues the RINEX lines of one epoch.
    fn emit(&mut self, number: u64, decoded: &[(u64, [u8; 3], Vec<u8>)]) {
        let clock = self.clock.and_then(|arc| {
            fixed_point(
                arc.value(),
                self.layout.clock_decimals,
                self.layout.clock_decimals + 3,
            )
        });
        let head = self.layout.count;
        let mut line = self.epoch[..head].to_vec();
        line.extend_from_slice(format!("{:3}", decoded.len()).as_bytes());
        if self.layout.version == 3 {
            if let Some(clock) = clock {
                line.resize(41, b' ');
                line.extend_from_slice(clock.as_bytes());
            }
            self.ready.push_back((number, line));
            for (number, name, fields) in decoded {
                let mut line = name.to_vec();
                line.extend_from_slice(fields);
                self.ready
                    .push_back((*number, line.trim_ascii_end().to_vec()));
            }
            return;
        }
        for (i, chunk) in decoded.chunks(12).enumerate() {
            if i > 0 {
                line = vec![b' '; 32];
            }
            for (_, name, _) in chunk {
                line.extend_from_slice(name);
            }
            if let (0, Some(clock)) = (i, &clock) {
                line.resize(68, b' ');
                line.extend_from_slice(clock.as_bytes());
            }
            self.ready.push_back((number, std::mem::take(&mut line)));
        }
        if decoded.is_empty() {
            self.ready.push_back((number, line));
        }
        for (number, _, fields) in decoded {
            // Five values of 16 characters to a line; at least one line even without types.
            let mut rows = fields.chunks(80).peekable();
            if rows.peek().is_none() {
                self.ready.push_back((*number, Vec::new()));
            }
            for row in rows {
                self.ready
                    .push_back((*number, row.trim_ascii_end().to_vec()));
            }
        }
    }
}

/// Decodes one satellite's line into 16 characters for each of `types` values.
fn decode_fields(
    state: &mut SatelliteState,
    types: usize,
    version: u8,
    line: &[u8],
    mut broken: impl FnMut(usize),
) -> Vec<u8> {
    state.arcs.resize(types, None);
    let mut rest = line;
    let mut texts = Vec::with_capacity(types);
    for i in 0..types {
        let end = rest.iter().position(|&b| b == b' ');
        let field = &rest[..end.unwrap_or(rest.len())];
        rest = end.map_or(&[], |end| &rest[end + 1..]);
        if field.is_empty() {
            state.arcs[i] = None;
            texts.push(None);
            continue;
        }
        state.arcs[i] = Arc::step(state.arcs[i], field);
        let text = state.arcs[i].and_then(|arc| fixed_point(arc.value(), 3, 14));
        if text.is_none() {
            state.arcs[i] = None;
            broken(i);
        }
        texts.push(text);
    }
    patch_text(&mut state.flags, rest);
    state.flags.resize(2 * types, b' ');
    if version == 1 {
        // Version 1 has no flags without a value, and does not record that flags disappear.
        for (i, _) in texts.iter().enumerate().filter(|(_, t)| t.is_none()) {
            state.flags[2 * i..2 * i + 2].fill(b' ');
        }
    }
    let mut out = Vec::with_capacity(16 * types);
    for (i, text) in texts.iter().enumerate() {
        match text {
            Some(text) => out.extend_from_slice(text.as_bytes()),
            None => out.extend_from_slice(&[b' '; 14]),
        }
        out.extend_from_slice(&state.flags[2 * i..2 * i + 2]);
    }
    out
}

fn number(field: &[u8]) -> Option<usize> {
    std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()
}

impl<S: LineSource> LineSource for CrinexLines<S> {
    fn advance(&mut self) -> Result<bool, ReadError> {
        loop {
            if let Some(next) = self.ready.pop_front() {
                self.current = next;
                return Ok(true);
            }
            if !self.source.advance()? {
                return Ok(false);
            }
            match self.stage {
                Stage::Header => self.header_line(),
                // Blank lines between epochs (some editors leave one at the end) are ignored.
                Stage::Resynchronise if self.source.line().trim_ascii().is_empty() => {}
                _ => self.decode_epoch()?,
            }
        }
    }

    fn line(&self) -> &[u8] {
        &self.current.1
    }

    fn number(&self) -> u64 {
        self.current.0
    }

    fn terminated(&self) -> bool {
        true
    }

    fn take_report(&mut self) -> ReadReport {
        let mut report = std::mem::take(&mut self.report);
        report.absorb(self.source.take_report());
        report
    }
}
