//! Reasons why phase history data cannot be written or read.

use std::io;

/// Reason why phase history data cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Nothing to write.
    #[error("expected one channel or more, found none")]
    NoChannel,
    /// Two channels of one name.
    #[error("channel {name:?}: expected different names, found this one twice")]
    SameName {
        /// The name.
        name: String,
    },
    /// Too few pulses or frequencies for a phase history.
    #[error("channel {name:?}: expected at least two {what}, found {found}")]
    TooFew {
        /// The channel.
        name: String,
        /// Kind of the shortage.
        what: &'static str,
        /// Number present.
        found: usize,
    },
    /// Arrays that do not belong together.
    #[error("channel {name:?}: expected {expected} {what}, found {found}")]
    Length {
        /// The channel.
        name: String,
        /// Content of the array.
        what: &'static str,
        /// Values it should hold.
        expected: usize,
        /// Values it holds.
        found: usize,
    },
    /// A number that is not finite.
    #[error("channel {name:?}: {what} {index} is not a finite number")]
    NotFinite {
        /// The channel.
        name: String,
        /// Content of the array.
        what: &'static str,
        /// Index of the value.
        index: usize,
    },
    /// Times that do not rise.
    #[error(
        "channel {name:?}: expected rising times, found {time_s} s of pulse {pulse} behind its forerunner's"
    )]
    Time {
        /// The channel.
        name: String,
        /// The pulse.
        pulse: usize,
        /// Its time (s).
        time_s: f64,
    },
    /// No pulse has a reference geometry.
    #[error(
        "channel {name:?}: expected a platform that moves and is not straight above the middle of \
         the scene, found none: CPHD has no reference geometry for a platform at rest"
    )]
    AtRest {
        /// The channel.
        name: String,
    },
    /// A scene without pixels.
    #[error("scene: expected pixels of positive size, found {nx} × {ny} of {pixel_m} m")]
    Scene {
        /// Pixels to the east.
        nx: usize,
        /// Pixels to the north.
        ny: usize,
        /// Side of a pixel (m).
        pixel_m: f64,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Reason why phase history data cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Not a CPHD file of version 1.
    #[error("expected CPHD/1.x in the first line, found {found:?}")]
    Version {
        /// The first line.
        found: String,
    },
    /// The header is broken.
    #[error("header, byte {byte}: expected {expected}, found {found:?}")]
    Header {
        /// Offset at which the line begins.
        byte: u64,
        /// Content expected.
        expected: String,
        /// Content found.
        found: String,
    },
    /// A block that does not lie in the file.
    #[error("{what}: expected {size} bytes from byte {offset} on in a file of {file} bytes")]
    Outside {
        /// The block.
        what: String,
        /// Where it begins.
        offset: u64,
        /// How long it is.
        size: u64,
        /// Bytes of the file.
        file: u64,
    },
    /// The XML block is no XML.
    #[error("XML block: {0}")]
    Xml(#[from] roxmltree::Error),
    /// The XML block is no text.
    #[error("XML block: expected UTF-8, found another byte at {byte} of the block")]
    Encoding {
        /// Offset within the block.
        byte: usize,
    },
    /// An element of the XML block is absent or holds something else than it should.
    #[error("XML, {path}: expected {expected}, found {found}")]
    Element {
        /// The element.
        path: String,
        /// Content expected.
        expected: String,
        /// Content found.
        found: String,
    },
    /// Data of a kind that cannot be used.
    #[error("{what}: expected {expected}, found {found}")]
    Unsupported {
        /// Name of the property.
        what: &'static str,
        /// Values that can be used.
        expected: &'static str,
        /// Content found.
        found: String,
    },
    /// A channel that is not there.
    #[error("channel {wanted:?}: expected one of {present}")]
    NoChannel {
        /// The name asked for.
        wanted: String,
        /// The names there are.
        present: String,
    },
    /// More values than the caller takes.
    #[error("channel {channel:?}: expected at most {limit} values, found {found}")]
    TooLarge {
        /// The channel.
        channel: String,
        /// The most that is taken.
        limit: usize,
        /// Number present.
        found: u64,
    },
    /// A parameter of a pulse that cannot be.
    #[error(
        "channel {channel:?}, vector {vector}: {parameter}: expected {expected}, found {found}"
    )]
    Parameter {
        /// The channel.
        channel: String,
        /// The pulse.
        vector: usize,
        /// The parameter.
        parameter: &'static str,
        /// Content expected.
        expected: &'static str,
        /// Content found.
        found: String,
    },
    /// A value that is no number.
    #[error("channel {channel:?}, vector {vector}: sample {sample} is not a finite number")]
    Sample {
        /// The channel.
        channel: String,
        /// The pulse.
        vector: usize,
        /// The sample.
        sample: usize,
    },
    /// No pulse with a signal.
    #[error("channel {channel:?}: expected vectors with a signal, found none")]
    Empty {
        /// The channel.
        channel: String,
    },
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
}
