//! The XML block of a file (CPHD 1.1.0, sections 4 to 11).

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;

use crate::markup::Markup;
use crate::model::{Channel, PhaseHistory, Scene};
use crate::vectors::{PARAMETERS, Vectors, WORDS};

/// Namespace of the version written.
const NAMESPACE: &str = "http://api.nsgreg.nga.mil/schema/cphd/1.1.0";
/// Collection start of data whose time is not known.
const UNKNOWN_START: &str = "1970-01-01T00:00:00Z";
/// Classification in header and XML.
pub(crate) const CLASSIFICATION: &str = "UNCLASSIFIED";
/// Release in header and XML.
pub(crate) const RELEASE: &str = "UNRESTRICTED";
/// Parameter of the product that holds the origin of the local frame: latitude and longitude
/// (degrees), ellipsoidal height (m).
pub(crate) const ORIGIN: &str = "LOCAL_FRAME_ORIGIN_DEG_M";

/// Content of a file to write.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Document<'a> {
    pub history: &'a PhaseHistory<'a>,
    pub scene: &'a Scene,
    /// The vectors of each channel.
    pub vectors: &'a [Vectors],
    /// East, north, up about the reference point of the image area.
    pub image_frame: &'a EnuFrame,
    /// Instant from which the file's times count; a whole second.
    pub start: Option<GpsTime>,
}

impl Document<'_> {
    /// The XML block.
    pub fn text(&self) -> String {
        let mut xml = Markup::default();
        let namespace = [("xmlns", NAMESPACE.to_owned())];
        xml.within_with("CPHD", &namespace, |xml| {
            self.collection(xml);
            self.global(xml);
            self.scene_coordinates(xml);
            self.data(xml);
            self.channels(xml);
            parameters(xml);
            self.dwell(xml);
            self.reference_geometry(xml);
            self.product(xml);
        });
        xml.into_text()
    }

    fn collection(&self, xml: &mut Markup) {
        let about = &self.history.description;
        let named = |name: &str| match name {
            "" => "unknown".to_owned(),
            name => name.to_owned(),
        };
        xml.within("CollectionID", |xml| {
            xml.value("CollectorName", named(&about.collector));
            xml.value("CoreName", named(&about.name));
            xml.value("CollectType", "MONOSTATIC");
            xml.within("RadarMode", |xml| xml.value("ModeType", "STRIPMAP"));
            xml.value("Classification", CLASSIFICATION);
            xml.value("ReleaseInfo", RELEASE);
        });
    }

    fn global(&self, xml: &mut Markup) {
        let [first_s, last_s] = span(self.vectors.iter().map(Vectors::transmit_s));
        let channels = self.history.channels.iter();
        let [low_hz, high_hz] =
            span(channels.map(|c| [c.frequency.first_hz, c.frequency.last_hz()]));
        let [early_s, late_s] = span(self.vectors.iter().map(Vectors::toa_s));
        xml.within("Global", |xml| {
            xml.value("DomainType", "FX");
            xml.value("SGN", "-1");
            xml.within("Timeline", |xml| {
                xml.value("CollectionStart", utc_text(self.start));
                xml.value("TxTime1", first_s);
                xml.value("TxTime2", last_s);
            });
            xml.within("FxBand", |xml| {
                xml.value("FxMin", low_hz);
                xml.value("FxMax", high_hz);
            });
            xml.within("TOASwath", |xml| {
                xml.value("TOAMin", early_s);
                xml.value("TOAMax", late_s);
            });
        });
    }

    fn scene_coordinates(&self, xml: &mut Markup) {
        let frame = self.image_frame;
        let scene = self.scene;
        let [half_x_m, half_y_m] = [scene.nx, scene.ny].map(|n| 0.5 * n as f64 * scene.pixel_m);
        let corner = |x_m: f64, y_m: f64| frame.geodetic_from_enu([x_m, y_m, 0.0]);
        // South-west, north-west, north-east, south-east: clockwise seen from above.
        let corners = [
            corner(-half_x_m, -half_y_m),
            corner(-half_x_m, half_y_m),
            corner(half_x_m, half_y_m),
            corner(half_x_m, -half_y_m),
        ];
        xml.within("SceneCoordinates", |xml| {
            xml.value("EarthModel", "WGS_84");
            xml.within("IARP", |xml| {
                xml.xyz("ECF", frame.origin_in_ecef_m());
                xml.within("LLH", |xml| {
                    latitude_longitude(xml, frame.origin());
                    xml.value("HAE", frame.origin().height_m);
                });
            });
            xml.within("ReferenceSurface", |xml| {
                xml.within("Planar", |xml| {
                    xml.xyz("uIAX", frame.ecef_vector_from_enu([1.0, 0.0, 0.0]));
                    xml.xyz("uIAY", frame.ecef_vector_from_enu([0.0, 1.0, 0.0]));
                });
            });
            xml.within("ImageArea", |xml| {
                xy(xml, "X1Y1", [-half_x_m, -half_y_m]);
                xy(xml, "X2Y2", [half_x_m, half_y_m]);
            });
            xml.within("ImageAreaCornerPoints", |xml| {
                for (k, place) in corners.iter().enumerate() {
                    let index = [("index", (k + 1).to_string())];
                    xml.within_with("IACP", &index, |xml| latitude_longitude(xml, place));
                }
            });
            self.image_grid(xml);
        });
    }

    /// Lines follow one another to the east, the samples of a line to the north.
    fn image_grid(&self, xml: &mut Markup) {
        let scene = self.scene;
        let middle = |n: usize| 0.5 * n as f64 - 0.5;
        xml.within("ImageGrid", |xml| {
            xml.within("IARPLocation", |xml| {
                xml.value("Line", middle(scene.nx));
                xml.value("Sample", middle(scene.ny));
            });
            xml.within("IAXExtent", |xml| {
                xml.value("LineSpacing", scene.pixel_m);
                xml.value("FirstLine", 0);
                xml.value("NumLines", scene.nx);
            });
            xml.within("IAYExtent", |xml| {
                xml.value("SampleSpacing", scene.pixel_m);
                xml.value("FirstSample", 0);
                xml.value("NumSamples", scene.ny);
            });
        });
    }

    fn data(&self, xml: &mut Markup) {
        xml.within("Data", |xml| {
            xml.value("SignalArrayFormat", "CF8");
            xml.value("NumBytesPVP", 8 * WORDS);
            xml.value("NumCPHDChannels", self.history.channels.len());
            let (mut signal_offset, mut vector_offset) = (0, 0);
            for channel in &self.history.channels {
                let (vectors, samples) = (channel.time_s.len(), channel.frequency.count);
                xml.within("Channel", |xml| {
                    xml.value("Identifier", &channel.name);
                    xml.value("NumVectors", vectors);
                    xml.value("NumSamples", samples);
                    xml.value("SignalArrayByteOffset", signal_offset);
                    xml.value("PVPArrayByteOffset", vector_offset);
                });
                signal_offset += 8 * vectors * samples;
                vector_offset += 8 * WORDS * vectors;
            }
            xml.value("NumSupportArrays", 0);
        });
    }

    fn channels(&self, xml: &mut Markup) {
        let channels = &self.history.channels;
        let toa_s = self.vectors[0].toa_s();
        let has_this_swath = |v: &Vectors| v.is_toa_fixed() && v.toa_s() == toa_s;
        let is_toa_fixed = self.vectors.iter().all(has_this_swath);
        let band = |channel: &Channel<'_>| {
            let frequency = channel.frequency;
            [frequency.first_hz, frequency.last_hz()]
        };
        let is_band_fixed = channels.iter().all(|c| band(c) == band(&channels[0]));
        xml.within("Channel", |xml| {
            xml.value("RefChId", &channels[0].name);
            xml.value("FXFixedCPHD", is_band_fixed);
            xml.value("TOAFixedCPHD", is_toa_fixed);
            xml.value("SRPFixedCPHD", true);
            for (channel, vectors) in channels.iter().zip(self.vectors) {
                let band = channel.frequency;
                let [early_s, late_s] = vectors.toa_s();
                xml.within("Parameters", |xml| {
                    xml.value("Identifier", &channel.name);
                    xml.value("RefVectorIndex", vectors.reference);
                    xml.value("FXFixed", true);
                    xml.value("TOAFixed", vectors.is_toa_fixed());
                    xml.value("SRPFixed", true);
                    xml.value("SignalNormal", true);
                    xml.within("Polarization", |xml| {
                        xml.value("TxPol", "UNSPECIFIED");
                        xml.value("RcvPol", "UNSPECIFIED");
                    });
                    xml.value("FxC", 0.5 * (band.first_hz + band.last_hz()));
                    xml.value("FxBW", band.last_hz() - band.first_hz);
                    xml.value("TOASaved", late_s - early_s);
                    xml.within("DwellTimes", |xml| {
                        xml.value("CODId", &channel.name);
                        xml.value("DwellId", &channel.name);
                    });
                });
            }
        });
    }

    /// Every point of the image is seen by every pulse.
    fn dwell(&self, xml: &mut Markup) {
        let channels = || self.history.channels.iter().zip(self.vectors);
        xml.within("Dwell", |xml| {
            xml.value("NumCODTimes", self.vectors.len());
            for (channel, vectors) in channels() {
                let [first_s, last_s] = vectors.reference_time_s();
                xml.within("CODTime", |xml| {
                    xml.value("Identifier", &channel.name);
                    constant(xml, "CODTimePoly", 0.5 * (first_s + last_s));
                });
            }
            xml.value("NumDwellTimes", self.vectors.len());
            for (channel, vectors) in channels() {
                let [first_s, last_s] = vectors.reference_time_s();
                xml.within("DwellTime", |xml| {
                    xml.value("Identifier", &channel.name);
                    constant(xml, "DwellTimePoly", last_s - first_s);
                });
            }
        });
    }

    fn reference_geometry(&self, xml: &mut Markup) {
        let vectors = &self.vectors[0];
        let vector = &vectors.all[vectors.reference];
        let geometry = &vectors.geometry;
        let [first_s, last_s] = vectors.reference_time_s();
        let middle_of = |[a, b]: [[f64; 3]; 2]| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        xml.within("ReferenceGeometry", |xml| {
            xml.within("SRP", |xml| {
                xml.xyz("ECF", vectors.srp_m);
                xml.xyz("IAC", [0.0; 3]);
            });
            xml.value("ReferenceTime", 0.5 * (vector.time_s[0] + vector.time_s[1]));
            xml.value("SRPCODTime", 0.5 * (first_s + last_s));
            xml.value("SRPDwellTime", last_s - first_s);
            xml.within("Monostatic", |xml| {
                xml.xyz("ARPPos", middle_of(vector.position_m));
                xml.xyz("ARPVel", vector.velocity_m_s);
                xml.value("SideOfTrack", if geometry.looks_left { "L" } else { "R" });
                xml.value("SlantRange", geometry.slant_range_m);
                xml.value("GroundRange", geometry.ground_range_m);
                xml.value("DopplerConeAngle", geometry.doppler_cone_deg);
                xml.value("GrazeAngle", geometry.graze_deg);
                xml.value("IncidenceAngle", 90.0 - geometry.graze_deg);
                xml.value("AzimuthAngle", geometry.azimuth_deg);
                xml.value("TwistAngle", geometry.twist_deg);
                xml.value("SlopeAngle", geometry.slope_deg);
                xml.value("LayoverAngle", geometry.layover_deg);
            });
        });
    }

    fn product(&self, xml: &mut Markup) {
        let origin = self.history.frame.origin();
        let origin = format!(
            "{} {} {}",
            origin.latitude_deg(),
            origin.longitude_deg(),
            origin.height_m
        );
        let items = &self.history.description.items;
        // Data that were read bring the origin of the frame that they were written from.
        let items = items.iter().filter(|(name, _)| name != ORIGIN);
        let items = items.map(|(name, value)| (name.as_str(), value));
        xml.within("ProductInfo", |xml| {
            for (name, value) in items.chain([(ORIGIN, &origin)]) {
                xml.value_with("Parameter", &[("name", name.to_owned())], value);
            }
        });
    }
}

fn parameters(xml: &mut Markup) {
    xml.within("PVP", |xml| {
        let mut offset = 0;
        for (name, words, format) in PARAMETERS {
            xml.within(name, |xml| {
                xml.value("Offset", offset);
                xml.value("Size", words);
                xml.value("Format", format);
            });
            offset += words;
        }
    });
}

/// A polynomial of order zero in both coordinates of the image area.
fn constant(xml: &mut Markup, name: &str, value: f64) {
    let both = |of: [&'static str; 2]| of.map(|attribute| (attribute, "0".to_owned()));
    xml.within_with(name, &both(["order1", "order2"]), |xml| {
        xml.value_with("Coef", &both(["exponent1", "exponent2"]), value);
    });
}

fn latitude_longitude(xml: &mut Markup, place: &Geodetic) {
    xml.value("Lat", place.latitude_deg());
    xml.value("Lon", place.longitude_deg());
}

fn xy(xml: &mut Markup, name: &str, [x, y]: [f64; 2]) {
    xml.within(name, |xml| {
        xml.value("X", x);
        xml.value("Y", y);
    });
}

/// Least and greatest of several extents.
fn span(extents: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    extents.fold([f64::INFINITY, f64::NEG_INFINITY], |all, one| {
        [all[0].min(one[0]), all[1].max(one[1])]
    })
}

/// `yyyy-mm-ddThh:mm:ssZ` of a whole second.
fn utc_text(start: Option<GpsTime>) -> String {
    start.map_or_else(
        || UNKNOWN_START.to_owned(),
        |start| {
            let utc = start.to_utc();
            format!(
                "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second
            )
        },
    )
}
