//! Meaning of a raster's numbers: scale, offset and unit, by GDAL's metadata and by GeoKeys.

use super::super::TerrainError;

/// The international foot (m).
pub(super) const FOOT_M: f64 = 0.3048;
/// The foot of the United States' surveys (m).
pub(super) const US_SURVEY_FOOT_M: f64 = 1200.0 / 3937.0;

/// Heights from stored numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Values {
    scale: f64,
    offset: f64,
    unit_m: f64,
}

impl Values {
    /// The height of a stored number (m).
    pub fn height_m(self, stored: f64) -> f64 {
        stored.mul_add(self.scale, self.offset) * self.unit_m
    }

    /// From the XML text of GDAL's tag 42112 and the unit of heights by the GeoKeys (m).
    ///
    /// # Errors
    /// XML that is broken, a scale that is no number or 0, a unit that is not known, two units that differ.
    pub fn read(metadata: Option<&str>, by_keys: Option<f64>) -> Result<Self, TerrainError> {
        let mut values = Self {
            scale: 1.0,
            offset: 0.0,
            unit_m: 1.0,
        };
        let mut unit = None;
        for (role, text) in items(metadata)? {
            match role.as_str() {
                "scale" => values.scale = number("scale of GDAL_METADATA", &text)?,
                "offset" => values.offset = number("offset of GDAL_METADATA", &text)?,
                "unittype" => unit = unit_of_name_m(&text)?,
                _ => {}
            }
        }
        if values.scale == 0.0 {
            return Err(TerrainError::Tag {
                at: "scale of GDAL_METADATA",
                expected: "a number other than 0",
                found: "0".to_owned(),
            });
        }
        if let (Some(tag), Some(key)) = (unit, by_keys)
            && (tag / key - 1.0).abs() > 1e-9
        {
            return Err(TerrainError::Tag {
                at: "unit of heights",
                expected: "one unit in GDAL_METADATA and in the GeoKeys",
                found: format!("units of {tag} m and {key} m"),
            });
        }
        values.unit_m = unit.or(by_keys).unwrap_or(1.0);
        Ok(values)
    }
}

/// Purpose of the whole grid by GDAL's metadata, in the words of PROJ's grids.
pub(super) fn grid_type(metadata: Option<&str>) -> Result<Option<String>, TerrainError> {
    let found = parsed(metadata)?.and_then(|xml| {
        let node = xml
            .descendants()
            .find(|n| n.has_tag_name("Item") && n.attribute("name") == Some("TYPE"))?;
        Some(node.text()?.trim().to_owned())
    });
    Ok(found)
}

/// Role and text of the items of the first band.
fn items(metadata: Option<&str>) -> Result<Vec<(String, String)>, TerrainError> {
    let Some(xml) = parsed(metadata)? else {
        return Ok(Vec::new());
    };
    let first_band = xml.descendants().filter(|n| {
        n.has_tag_name("Item") && n.attribute("sample").is_none_or(|s| s.trim() == "0")
    });
    let items = first_band.filter_map(|n| {
        let role = n.attribute("role")?.to_ascii_lowercase();
        Some((role, n.text().unwrap_or_default().trim().to_owned()))
    });
    Ok(items.collect())
}

fn parsed(metadata: Option<&str>) -> Result<Option<roxmltree::Document<'_>>, TerrainError> {
    let text = metadata.map(|t| t.trim_end_matches('\0').trim());
    let Some(text) = text.filter(|t| !t.is_empty()) else {
        return Ok(None);
    };
    let broken = |e: roxmltree::Error| TerrainError::Tag {
        at: "GDAL_METADATA",
        expected: "XML with the scale, offset and unit of the heights",
        found: e.to_string(),
    };
    roxmltree::Document::parse(text).map(Some).map_err(broken)
}

fn number(at: &'static str, text: &str) -> Result<f64, TerrainError> {
    let value = text.parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| TerrainError::Tag {
        at,
        expected: "a finite number",
        found: format!("{text:?}"),
    })
}

/// A unit by the names that GDAL and its drivers write; none for an empty one.
fn unit_of_name_m(name: &str) -> Result<Option<f64>, TerrainError> {
    let plain = name.trim().to_ascii_lowercase().replace(['_', '-'], " ");
    Ok(Some(match plain.as_str() {
        "" => return Ok(None),
        "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "dm" | "decimetre" | "decimeter" => 0.1,
        "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => 1e-2,
        "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => 1e-3,
        "km" | "kilometre" | "kilometer" => 1e3,
        "ft" | "foot" | "feet" | "international foot" | "foot (international)" => FOOT_M,
        "us ft" | "ftus" | "sft" | "us survey foot" | "us survey feet" | "u.s. survey foot"
        | "foot us" | "survey foot" | "us foot" => US_SURVEY_FOOT_M,
        _ => {
            return Err(TerrainError::Tag {
                at: "unit of GDAL_METADATA",
                expected: "m, dm, cm, mm, km, ft or US survey foot",
                found: format!("{name:?}"),
            });
        }
    }))
}

/// A unit of length by its EPSG code.
pub(super) fn unit_of_code_m(code: u16) -> Option<f64> {
    Some(match code {
        9001 => 1.0,
        9002 => FOOT_M,
        9003 => US_SURVEY_FOOT_M,
        1025 => 1e-3,
        1033 => 1e-2,
        9036 => 1e3,
        _ => return None,
    })
}
