//! Layout of a file from its XML block: kind of data, location of each parameter and signal.

use std::fmt::Display;
use std::str::FromStr;

use acerra_geo::geodesy::{EnuFrame, Geodetic, geodetic_from_ecef};
use acerra_geo::time::{Calendar, GpsTime};
use roxmltree::{Document, Node, ParsingOptions};

use crate::document::ORIGIN;
use crate::error::ReadError;
use crate::header::SIGNATURE;
use crate::model::Description;

/// Elements of the XML block that are read at most.
const MAX_NODES: u32 = 1 << 20;
/// Distance from the centre of the Earth of places on the Earth (m).
const ON_EARTH_M: std::ops::Range<f64> = 6.2e6..6.6e6;

/// What to read of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// The channel; by default the file's reference channel.
    pub channel: Option<String>,
    /// Samples held at most.
    pub max_samples: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            channel: None,
            max_samples: 1 << 29,
        }
    }
}

impl ReadOptions {
    /// These limits for the channel of this name.
    #[must_use]
    pub fn with_channel(mut self, channel: impl Into<String>) -> Self {
        self.channel = Some(channel.into());
        self
    }

    /// These limits with another number of samples held.
    #[must_use]
    pub const fn with_max_samples(mut self, max_samples: usize) -> Self {
        self.max_samples = max_samples;
        self
    }
}

/// Whether a file begins with the signature of CPHD version 1.
#[must_use]
pub fn is_cphd(head: &[u8]) -> bool {
    head.starts_with(SIGNATURE)
}

/// Storage format of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleFormat {
    /// Two signed bytes.
    Ci2,
    /// Two signed 16-bit integers.
    Ci4,
    /// Two single-precision numbers.
    Cf8,
}

impl SampleFormat {
    pub const fn bytes(self) -> u64 {
        match self {
            Self::Ci2 => 2,
            Self::Ci4 => 4,
            Self::Cf8 => 8,
        }
    }
}

/// Byte offsets of the parameters within a vector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameters {
    pub bytes: usize,
    pub transmit_time: usize,
    pub transmit_place: usize,
    pub receive_place: usize,
    pub reference_point: usize,
    pub amplitude: Option<usize>,
    pub band: [usize; 2],
    pub swath: [usize; 2],
    pub first_sample: usize,
    pub sample_step: usize,
    pub signal: Option<usize>,
}

/// A channel as the XML block describes it.
#[derive(Clone, Debug)]
pub(crate) struct ChannelLayout {
    pub name: String,
    pub vectors: u64,
    pub samples: u64,
    pub signal_offset: u64,
    pub vector_offset: u64,
}

/// Content of the XML block.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Whether the phase of a later echo rises with frequency.
    pub is_conjugate: bool,
    pub start: Option<GpsTime>,
    /// The frame of the positions to be: about the origin stated by Acerra, or the reference point of
    /// the image area.
    pub frame: EnuFrame,
    pub format: SampleFormat,
    pub parameters: Parameters,
    pub channels: Vec<ChannelLayout>,
    pub reference_channel: String,
    pub description: Description,
}

impl Layout {
    /// Reads the XML block.
    ///
    /// # Errors
    /// Text that is no XML, elements that are absent or broken, data of a kind that cannot be used.
    pub fn parse(text: &str) -> Result<Self, ReadError> {
        let options = ParsingOptions {
            nodes_limit: MAX_NODES,
            ..ParsingOptions::default()
        };
        let document = Document::parse_with_options(text, options)?;
        let root = Element {
            node: document.root_element(),
            path: document.root_element().tag_name().name().to_owned(),
        };
        supported(&root)?;
        let data = root.child("Data")?;
        let sign: i32 = root.child("Global")?.value("SGN")?;
        let scene = root.child("SceneCoordinates")?;
        let description = description(&root)?;
        let parameters = parameters(&root.child("PVP")?, &data)?;
        Ok(Self {
            is_conjugate: sign > 0,
            start: start(&root)?,
            frame: frame(&scene, &description)?,
            format: sample_format(&data)?,
            parameters,
            channels: channels(&data)?,
            reference_channel: root.child("Channel")?.text("RefChId")?,
            description,
        })
    }
}

/// Refuses unsupported properties.
fn supported(root: &Element<'_, '_>) -> Result<(), ReadError> {
    let refuse = |what, expected, found: &str| {
        Err(ReadError::Unsupported {
            what,
            expected,
            found: found.to_owned(),
        })
    };
    let domain = root.child("Global")?.text("DomainType")?;
    if domain != "FX" {
        return refuse("Global/DomainType", "FX, spectra", &domain);
    }
    let collection = root.child("CollectionID")?.text("CollectType")?;
    if collection != "MONOSTATIC" {
        return refuse("CollectionID/CollectType", "MONOSTATIC", &collection);
    }
    let sign = root.child("Global")?.text("SGN")?;
    if !["+1", "1", "-1"].contains(&sign.as_str()) {
        return refuse("Global/SGN", "+1 or -1", &sign);
    }
    match root.child("Data")?.optional("SignalCompressionID") {
        Some(method) => refuse(
            "Data/SignalCompressionID",
            "signals that are not compressed",
            method.node.text().unwrap_or_default(),
        ),
        None => Ok(()),
    }
}

fn sample_format(data: &Element<'_, '_>) -> Result<SampleFormat, ReadError> {
    let name = data.text("SignalArrayFormat")?;
    match name.as_str() {
        "CI2" => Ok(SampleFormat::Ci2),
        "CI4" => Ok(SampleFormat::Ci4),
        "CF8" => Ok(SampleFormat::Cf8),
        _ => Err(ReadError::Unsupported {
            what: "Data/SignalArrayFormat",
            expected: "CI2, CI4 or CF8",
            found: name,
        }),
    }
}

fn channels(data: &Element<'_, '_>) -> Result<Vec<ChannelLayout>, ReadError> {
    let channels = data.children("Channel").map(|channel| {
        Ok(ChannelLayout {
            name: channel.text("Identifier")?,
            vectors: channel.value("NumVectors")?,
            samples: channel.value("NumSamples")?,
            signal_offset: channel.value("SignalArrayByteOffset")?,
            vector_offset: channel.value("PVPArrayByteOffset")?,
        })
    });
    channels.collect()
}

fn parameters(pvp: &Element<'_, '_>, data: &Element<'_, '_>) -> Result<Parameters, ReadError> {
    let bytes: usize = data.value("NumBytesPVP")?;
    let place = |parameter: &Element<'_, '_>, format: &str| {
        let found = parameter.text("Format")?;
        let words = if format.starts_with('X') { 3 } else { 1 };
        let offset: usize = parameter.value("Offset")?;
        let end = offset.checked_add(words).and_then(|end| end.checked_mul(8));
        if found == format && end.is_some_and(|end| end <= bytes) {
            return Ok(8 * offset);
        }
        Err(parameter.wrong(
            format!("format {format} within the {bytes} bytes of a vector"),
            format!("format {found} at word {offset}"),
        ))
    };
    let of = |name: &str, format: &str| place(&pvp.child(name)?, format);
    let if_there = |name: &str, format: &str| {
        let parameter = pvp.optional(name);
        parameter.map(|p| place(&p, format)).transpose()
    };
    const XYZ: &str = "X=F8;Y=F8;Z=F8;";
    Ok(Parameters {
        bytes,
        transmit_time: of("TxTime", "F8")?,
        transmit_place: of("TxPos", XYZ)?,
        receive_place: of("RcvPos", XYZ)?,
        reference_point: of("SRPPos", XYZ)?,
        amplitude: if_there("AmpSF", "F8")?,
        band: [of("FX1", "F8")?, of("FX2", "F8")?],
        swath: [of("TOA1", "F8")?, of("TOA2", "F8")?],
        first_sample: of("SC0", "F8")?,
        sample_step: of("SCSS", "F8")?,
        signal: if_there("SIGNAL", "I8")?,
    })
}

fn description(root: &Element<'_, '_>) -> Result<Description, ReadError> {
    let collection = root.child("CollectionID")?;
    let product = root.optional("ProductInfo");
    let parameters = product
        .iter()
        .flat_map(|product| product.children("Parameter"));
    let items = parameters.map(|parameter| {
        let name = parameter.node.attribute("name").unwrap_or_default();
        let value = parameter.node.text().unwrap_or_default();
        (name.to_owned(), value.to_owned())
    });
    Ok(Description {
        name: collection.text("CoreName")?,
        collector: collection.text("CollectorName")?,
        items: items.collect(),
    })
}

/// Local frame about the origin of Acerra's frame where the file states the origin, else about the reference
/// point of the image area.
fn frame(scene: &Element<'_, '_>, description: &Description) -> Result<EnuFrame, ReadError> {
    let stated = description.items.iter().find(|(name, _)| name == ORIGIN);
    let numbers = stated.and_then(|(_, value)| {
        let parsed: Result<Vec<f64>, _> = value.split_whitespace().map(str::parse).collect();
        parsed.ok()
    });
    if let Some([latitude, longitude, height]) = numbers.as_deref()
        && latitude.abs() <= 90.0
        && longitude.abs() <= 360.0
        && height.abs() < 1e5
    {
        let origin = Geodetic::from_degrees(*latitude, *longitude, *height);
        return Ok(EnuFrame::new(origin));
    }
    let point = scene.child("IARP")?.child("ECF")?;
    let axes = [point.value("X")?, point.value("Y")?, point.value("Z")?];
    if !is_on_earth(axes) {
        return Err(point.wrong("a place on the Earth".to_owned(), format!("{axes:?}")));
    }
    Ok(EnuFrame::new(geodetic_from_ecef(axes)))
}

/// Whether Earth-centred, Earth-fixed coordinates are near the Earth's surface.
pub(crate) fn is_on_earth(pos_in_ecef_m: [f64; 3]) -> bool {
    let squares: f64 = pos_in_ecef_m.iter().map(|v| v * v).sum();
    ON_EARTH_M.contains(&squares.sqrt())
}

/// The instant from which times count; none before GPS time began.
fn start(root: &Element<'_, '_>) -> Result<Option<GpsTime>, ReadError> {
    let timeline = root.child("Global")?.child("Timeline")?;
    let text = timeline.text("CollectionStart")?;
    let calendar = calendar(&text).ok_or_else(|| {
        timeline.wrong(
            "CollectionStart as yyyy-mm-ddThh:mm:ss.sssZ".to_owned(),
            text.clone(),
        )
    })?;
    let time = GpsTime::from_utc(&calendar).ok();
    Ok(time.filter(|time| time.seconds() >= 0))
}

/// A date and clock reading in UTC.
fn calendar(text: &str) -> Option<Calendar> {
    let (date, clock) = text.split_once('T')?;
    let clock = clock.strip_suffix('Z').unwrap_or(clock);
    let mut date = date.splitn(3, '-');
    let mut clock = clock.splitn(3, ':');
    Calendar::new(
        date.next()?.parse().ok()?,
        date.next()?.parse().ok()?,
        date.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
    )
    .ok()
}

/// An element with its path, for messages. Namespaces are ignored: they differ between versions.
struct Element<'a, 'input> {
    node: Node<'a, 'input>,
    path: String,
}

impl<'a, 'input> Element<'a, 'input> {
    fn children(&self, name: &str) -> impl Iterator<Item = Self> {
        let path = format!("{}/{name}", self.path);
        let children = self.node.children();
        children
            .filter(move |node| node.tag_name().name() == name)
            .map(move |node| Element {
                node,
                path: path.clone(),
            })
    }

    fn optional(&self, name: &str) -> Option<Self> {
        self.children(name).next()
    }

    fn child(&self, name: &str) -> Result<Self, ReadError> {
        self.optional(name)
            .ok_or_else(|| self.wrong(format!("element {name}"), "none".to_owned()))
    }

    fn text(&self, name: &str) -> Result<String, ReadError> {
        let text = self.child(name)?.node.text().unwrap_or_default();
        Ok(text.trim().to_owned())
    }

    fn value<T: FromStr<Err: Display>>(&self, name: &str) -> Result<T, ReadError> {
        let text = self.text(name)?;
        text.parse()
            .map_err(|error: T::Err| self.wrong(format!("a number in {name} ({error})"), text))
    }

    fn wrong(&self, expected: String, found: String) -> ReadError {
        ReadError::Element {
            path: self.path.clone(),
            expected,
            found,
        }
    }
}
