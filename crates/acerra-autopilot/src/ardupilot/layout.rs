//! Formats of the records, as the log itself defines them (ArduPilot, `AP_Logger/LogStructure.h`).
//!
//! A record is the mark A3 95, the number of its type and the fields of its type, little-endian and
//! packed. Records of type 128, `FMT`, define the types: number, length, name, one character a field,
//! and the fields' names.

use crate::bytes::array;

/// What a record begins with.
pub const MARK: [u8; 2] = [0xa3, 0x95];
/// Type of the records that define types.
pub const FMT_TYPE: u8 = 128;
/// Length of such a record.
pub const FMT_LENGTH: usize = 89;
/// Mark and type (bytes).
pub const HEADER: usize = 3;

/// A type of record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Name of the type: `GPS`, `ATT` …
    pub name: String,
    /// Length of a record including its mark (bytes).
    pub length: usize,
    fields: Vec<Field>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Field {
    name: String,
    code: u8,
    at: usize,
}

impl Layout {
    /// The type that a record `FMT` defines, and its number. The error describes the fault.
    pub fn of(record: &[u8]) -> Result<(u8, Self), String> {
        let number = record.get(3).copied().unwrap_or_default();
        let length = usize::from(record.get(4).copied().unwrap_or_default());
        let name = text(record, 5, 4);
        let codes = text(record, 9, 16);
        let names = text(record, 25, 64);
        let mut at = HEADER;
        let mut fields = Vec::new();
        for (code, field) in codes.bytes().zip(names.split(',')) {
            let size = size_of(code).ok_or_else(|| {
                format!("a field {field} of {name} with the unknown code {code:#04x}")
            })?;
            fields.push(Field {
                name: field.trim().to_owned(),
                code,
                at,
            });
            at += size;
        }
        // Codes beyond the names still take their room.
        let rest = codes.bytes().skip(fields.len());
        at += rest.filter_map(size_of).sum::<usize>();
        if at != length {
            return Err(format!(
                "{name} with fields of {at} bytes and a length of {length}"
            ));
        }
        Ok((
            number,
            Self {
                name,
                length,
                fields,
            },
        ))
    }

    /// The first of `names` that the record has, in the unit of its field: degrees for latitudes and
    /// longitudes, hundredths undone.
    pub fn number(&self, record: &[u8], names: &[&str]) -> Option<f64> {
        let of = |name: &&str| self.fields.iter().find(|f| f.name == **name);
        value(record, names.iter().find_map(of)?)
    }

    /// The text of a field.
    pub fn text(&self, record: &[u8], name: &str) -> Option<String> {
        let field = self.fields.iter().find(|f| f.name == name)?;
        let length = match field.code {
            b'n' => 4,
            b'N' => 16,
            b'Z' => 64,
            _ => return None,
        };
        Some(text(record, field.at, length))
    }

    /// A whole number, exactly.
    pub fn integer(&self, record: &[u8], name: &str) -> Option<i64> {
        let field = self.fields.iter().find(|f| f.name == name)?;
        integer(record, field)
    }
}

fn text(record: &[u8], at: usize, length: usize) -> String {
    let bytes = record.get(at..at + length).unwrap_or_default();
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// Bytes of a field.
const fn size_of(code: u8) -> Option<usize> {
    Some(match code {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'f' | b'n' | b'e' | b'E' | b'L' => 4,
        b'd' | b'q' | b'Q' => 8,
        b'N' => 16,
        b'a' | b'Z' => 64,
        _ => return None,
    })
}

fn integer(record: &[u8], field: &Field) -> Option<i64> {
    let at = field.at;
    Some(match field.code {
        b'b' => i8::from_le_bytes(array(record, at)?).into(),
        b'B' | b'M' => u8::from_le_bytes(array(record, at)?).into(),
        b'h' | b'c' => i16::from_le_bytes(array(record, at)?).into(),
        b'H' | b'C' => u16::from_le_bytes(array(record, at)?).into(),
        b'i' | b'e' | b'L' => i32::from_le_bytes(array(record, at)?).into(),
        b'I' | b'E' => u32::from_le_bytes(array(record, at)?).into(),
        b'q' => i64::from_le_bytes(array(record, at)?),
        b'Q' => u64::from_le_bytes(array(record, at)?).try_into().ok()?,
        _ => return None,
    })
}

fn value(record: &[u8], field: &Field) -> Option<f64> {
    match field.code {
        b'f' => Some(f32::from_le_bytes(array(record, field.at)?).into()),
        b'd' => Some(f64::from_le_bytes(array(record, field.at)?)),
        b'c' | b'C' | b'e' | b'E' => Some(integer(record, field)? as f64 / 100.0),
        b'L' => Some(integer(record, field)? as f64 / 1e7),
        _ => Some(integer(record, field)? as f64),
    }
}
