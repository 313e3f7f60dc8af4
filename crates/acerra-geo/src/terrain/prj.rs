//! Coordinate reference systems in well-known text, in `.prj` files next to rasters.

use super::{Crs, TerrainError};

/// Longest text that is read.
pub(super) const MAX_BYTES: u64 = 1 << 20;

impl Crs {
    /// From well-known text: by its EPSG code, else by the name that Esri's programs give UTM zones and
    /// WGS84.
    ///
    /// # Errors
    /// Text that names no system, or an unsupported one.
    ///
    /// ```
    /// use acerra_geo::terrain::Crs;
    /// let esri = r#"PROJCS["WGS_1984_UTM_Zone_33N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984"]]]"#;
    /// assert_eq!(Crs::from_wkt(esri)?, Crs::Utm { zone: 33, south: false });
    /// # Ok::<(), acerra_geo::terrain::TerrainError>(())
    /// ```
    pub fn from_wkt(text: &str) -> Result<Self, TerrainError> {
        let text = text.trim_start_matches('\u{feff}').trim();
        let unknown = || TerrainError::Crs {
            expected: "well-known text of a system with its EPSG code, of a UTM zone or of WGS84, or the \
                       code in the settings (crs)",
            found: format!("{:?}", text.chars().take(60).collect::<String>()),
        };
        let (_, rest) = text.split_once(['[', '(']).ok_or_else(unknown)?;
        if let Some(code) = own_code(rest) {
            return Self::from_epsg(code);
        }
        let name = rest.split('"').nth(1).ok_or_else(unknown)?;
        Self::from_name(name).ok_or_else(unknown)
    }

    /// By names such as `WGS_1984_UTM_Zone_33N`, `ETRS89 / UTM zone 32N` and `GCS_WGS_1984`.
    fn from_name(name: &str) -> Option<Self> {
        let plain: String = name
            .chars()
            .filter(|c| c.is_ascii_alphanumeric())
            .map(|c| c.to_ascii_uppercase())
            .collect();
        if ["GCSWGS1984", "WGS84", "WGS1984", "GCSETRS1989", "ETRS89"].contains(&plain.as_str()) {
            return Some(Self::Geographic);
        }
        let (datum, zone) = plain.split_once("UTMZONE")?;
        if !["WGS1984", "WGS84", "ETRS1989", "ETRS89"].contains(&datum) {
            return None;
        }
        let south = zone.ends_with('S');
        let zone = zone.strip_suffix(['N', 'S'])?.parse().ok()?;
        (1..=60)
            .contains(&zone)
            .then_some(Self::Utm { zone, south })
    }
}

/// The EPSG code of the outermost system: its own `AUTHORITY` or `ID`, not that of a part.
fn own_code(inside: &str) -> Option<u32> {
    let mut depth = 0i32;
    let mut quoted = false;
    for (at, c) in inside.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '[' | '(' if !quoted => depth += 1,
            ']' | ')' if !quoted => depth -= 1,
            _ => {}
        }
        if depth < 0 {
            break;
        }
        let here = &inside[at..];
        if depth == 0 && !quoted && (here.starts_with("AUTHORITY") || here.starts_with("ID")) {
            let (_, values) = here.split_once(['[', '('])?;
            let (values, _) = values.split_once([']', ')'])?;
            let (authority, code) = values.split_once(',')?;
            let word = |w: &str| w.trim().trim_matches('"').to_owned();
            return word(authority)
                .eq_ignore_ascii_case("EPSG")
                .then(|| word(code).parse().ok())?;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_own_code_counts_not_its_parts() {
        let gdal = r#"PROJCS["WGS 84 / UTM zone 33N (x, [y])",GEOGCS["WGS 84",DATUM["WGS_1984",
            AUTHORITY["EPSG","6326"]],AUTHORITY["EPSG","4326"]],UNIT["metre",1],
            AUTHORITY["EPSG","32633"]]"#;
        let utm = |zone, south| Crs::Utm { zone, south };
        assert_eq!(Crs::from_wkt(gdal).unwrap(), utm(33, false));
        let wkt2 = r#"GEOGCRS["RDN2008",DATUM["x",ID["EPSG",1132]],ID["EPSG",6706]]"#;
        assert_eq!(Crs::from_wkt(wkt2).unwrap(), Crs::Epsg(6706));
        let esri = r#"PROJCS["ETRS_1989_UTM_Zone_32N",GEOGCS["GCS_ETRS_1989"]]"#;
        assert_eq!(Crs::from_wkt(esri).unwrap(), utm(32, false));
        let south = r#"PROJCS["WGS_1984_UTM_Zone_19S",GEOGCS["GCS_WGS_1984"]]"#;
        assert_eq!(Crs::from_wkt(south).unwrap(), utm(19, true));
        let degrees = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984"]]"#;
        assert_eq!(Crs::from_wkt(degrees).unwrap(), Crs::Geographic);
        for other in [
            "",
            "Projection UTM\nZone 33\n",
            r#"PROJCS["NAD_1927_UTM_Zone_11N"]"#,
            r#"LOCAL_CS["mine"]"#,
            "PROJCS[",
        ] {
            let message = Crs::from_wkt(other).unwrap_err().to_string();
            assert!(message.contains("EPSG code"), "{message}");
        }
    }
}
