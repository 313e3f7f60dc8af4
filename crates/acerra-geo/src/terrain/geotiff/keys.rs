//! GeoKeys: coordinates, units and vertical reference.

use std::io::{Read, Seek};

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use super::super::{Crs, TerrainError};
use super::values::{FOOT_M, US_SURVEY_FOOT_M, unit_of_code_m};
use crate::epsg::EpsgCrs;

/// The GeoKey directory: key, and its value where that is a short number.
pub(super) struct GeoKeys(Vec<[u16; 4]>);

/// GeoKey "user-defined".
const USER_DEFINED: u16 = 32767;

impl GeoKeys {
    pub fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, TerrainError> {
        let broken = |source| TerrainError::Tiff {
            at: "GeoKeyDirectory".to_owned(),
            source,
        };
        let Some(value) = decoder.find_tag(Tag::GeoKeyDirectoryTag).map_err(broken)? else {
            return Ok(Self(Vec::new()));
        };
        let numbers = value.into_u16_vec().map_err(broken)?;
        let keys = numbers
            .chunks_exact(4)
            .skip(1)
            .map(|k| [k[0], k[1], k[2], k[3]]);
        Ok(Self(keys.collect()))
    }

    /// The short number of a key.
    fn short(&self, key: u16) -> Option<u16> {
        let found = self.0.iter().find(|k| k[0] == key && k[1] == 0);
        found.map(|k| k[3])
    }

    pub fn pixel_is_point(&self) -> bool {
        self.short(1025) == Some(2)
    }

    pub fn crs(&self) -> Result<Option<Crs>, TerrainError> {
        let known = |code: Option<u16>| match code {
            None | Some(USER_DEFINED | 0) => Ok(None),
            Some(code) => Crs::from_epsg(u32::from(code)).map(Some),
        };
        match self.short(1024) {
            Some(1) => {
                let crs = known(self.short(3072))?;
                self.check_unit(crs)?;
                Ok(crs)
            }
            Some(2) => {
                if let Some(code) = self.short(2054).filter(|c| ![9102, 9122].contains(c)) {
                    return Err(TerrainError::Tag {
                        at: "GeogAngularUnits",
                        expected: "degrees (9102)",
                        found: format!("unit code {code}"),
                    });
                }
                known(self.short(2048))
            }
            Some(found @ 3) => Err(TerrainError::Tag {
                at: "GTModelType",
                expected: "projected (1) or geographic (2) coordinates",
                found: format!("{found}"),
            }),
            _ => Ok(None),
        }
    }

    /// Refuses a unit of length that differs from the system's.
    fn check_unit(&self, crs: Option<Crs>) -> Result<(), TerrainError> {
        let own_m = match crs {
            Some(Crs::Epsg(code)) => EpsgCrs::from_epsg(code.into())?.unit_m(),
            _ => Some(1.0),
        };
        let Some(code) = self.short(3076).filter(|c| *c != USER_DEFINED) else {
            return Ok(());
        };
        let same = |m: f64| own_m.is_some_and(|own| (m / own - 1.0).abs() < 1e-9);
        if unit_of_code_m(code).is_some_and(same) {
            return Ok(());
        }
        Err(TerrainError::Tag {
            at: "ProjLinearUnits",
            expected: "the unit of the coordinate system, metres (9001) for most",
            found: format!("unit code {code}"),
        })
    }

    /// Vertical datum of the heights, in words.
    ///
    /// # Errors
    /// A vertical reference that counts downwards.
    pub fn vertical(&self) -> Result<Option<String>, TerrainError> {
        let Some(code) = self.vertical_code() else {
            return Ok(None);
        };
        if DEPTHS.contains(&code) {
            return Err(TerrainError::Tag {
                at: "Vertical (GeoKey 4096)",
                expected: "heights, upwards",
                found: format!("depths, EPSG code {code} (negate them: gdal_calc.py --calc=-A)"),
            });
        }
        Ok(Some(match code {
            5030 | 4979 | 4326 => "the ellipsoid".to_owned(),
            5773 => "the geoid EGM96".to_owned(),
            3855 => "the geoid EGM2008".to_owned(),
            other => format!("a surface of EPSG code {other}"),
        }))
    }

    /// The unit of heights (m), where a key names it.
    ///
    /// # Errors
    /// A code that is not known.
    pub fn vertical_unit_m(&self) -> Result<Option<f64>, TerrainError> {
        let stated = match self.short(4099) {
            None | Some(USER_DEFINED | 0) => None,
            Some(code) => Some(unit_of_code_m(code).ok_or_else(|| TerrainError::Tag {
                at: "VerticalUnits (GeoKey 4099)",
                expected: "metres (9001), feet (9002) or US survey feet (9003)",
                found: format!("unit code {code}"),
            })?),
        };
        // The reference alone names its unit too.
        Ok(stated.or(match self.vertical_code() {
            Some(8228 | 8050) => Some(FOOT_M),
            Some(5702 | 6360 | 8052) => Some(US_SURVEY_FOOT_M),
            _ => None,
        }))
    }

    fn vertical_code(&self) -> Option<u16> {
        self.short(4096).filter(|c| ![0, USER_DEFINED].contains(c))
    }
}

/// Vertical references of the EPSG registry that count downwards.
const DEPTHS: [u16; 13] = [
    5336, 5612, 5706, 5715, 5831, 5861, 5862, 6357, 6358, 6359, 8051, 8053, 9471,
];
