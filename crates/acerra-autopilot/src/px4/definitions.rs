//! Formats of the messages, as the log itself defines them: `name:type field;type[n] field;…`.

use std::collections::HashMap;

use crate::bytes::array;

/// Types within types within types: deeper is no log of PX4.
const DEEPEST: usize = 8;
/// Longest message (bytes): its length has 16 bits.
const LONGEST: usize = 1 << 16;

/// The formats of a log, by the name of the message.
#[derive(Debug, Clone, Default)]
pub struct Definitions {
    formats: HashMap<String, Vec<Declared>>,
}

#[derive(Debug, Clone)]
struct Declared {
    kind: String,
    count: usize,
    name: String,
}

/// Offsets of the fields of a message.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    fields: HashMap<String, (Number, usize)>,
}

/// A number of a fixed length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "int8_t" => Self::I8,
            "uint8_t" | "bool" | "char" => Self::U8,
            "int16_t" => Self::I16,
            "uint16_t" => Self::U16,
            "int32_t" => Self::I32,
            "uint32_t" => Self::U32,
            "int64_t" => Self::I64,
            "uint64_t" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

impl Definitions {
    /// Adds the text of a definition. The error describes its fault.
    pub fn add(&mut self, text: &str) -> Result<(), String> {
        let (name, fields) = text
            .split_once(':')
            .ok_or_else(|| format!("'{}' without a colon", text.escape_debug()))?;
        let declared = fields.split(';').filter(|f| !f.trim().is_empty());
        let declared: Option<Vec<Declared>> = declared.map(declared_of).collect();
        let declared =
            declared.ok_or_else(|| format!("fields of {name} that are not 'type name' each"))?;
        self.formats.insert(name.to_owned(), declared);
        Ok(())
    }

    /// Places of the fields of the message `name`, without nested types. The error names a missing field.
    pub fn fields_of(&self, name: &str) -> Result<Fields, String> {
        let declared = self
            .formats
            .get(name)
            .ok_or_else(|| format!("{name} without a definition"))?;
        let mut fields = Fields::default();
        let mut at = 0;
        for field in declared {
            let size = match Number::named(&field.kind) {
                Some(number) => {
                    for k in 0..field.count.min(4) {
                        let indexed = match field.count {
                            1 => field.name.clone(),
                            _ => format!("{}[{k}]", field.name),
                        };
                        fields
                            .fields
                            .insert(indexed, (number, at + k * number.size()));
                    }
                    number.size()
                }
                None => self.size_of(&field.kind, 1)?,
            };
            at = room(at, size, field.count)?;
        }
        Ok(fields)
    }

    /// Fewest and most bytes of the message `name`: padding at its end need not be written. All lengths where its
    /// definition is not known.
    pub fn lengths_of(&self, name: &str) -> [usize; 2] {
        let declared = self.formats.get(name).map_or(&[][..], Vec::as_slice);
        let mut lengths = [0; 2];
        for field in declared {
            let size = self.size_of(&field.kind, 1);
            let Ok(most) = size.and_then(|size| room(lengths[1], size, field.count)) else {
                return [0, LONGEST];
            };
            lengths[1] = most;
            if !field.name.starts_with("_padding") {
                lengths[0] = most;
            }
        }
        if lengths[1] == 0 {
            [0, LONGEST]
        } else {
            lengths
        }
    }

    fn size_of(&self, kind: &str, depth: usize) -> Result<usize, String> {
        if let Some(number) = Number::named(kind) {
            return Ok(number.size());
        }
        let declared = self
            .formats
            .get(kind)
            .filter(|_| depth < DEEPEST)
            .ok_or_else(|| format!("the type {kind}, which has no definition"))?;
        let mut size = 0;
        for field in declared {
            size = room(size, self.size_of(&field.kind, depth + 1)?, field.count)?;
        }
        Ok(size)
    }
}

/// Bytes up to the end of `count` fields of `size` bytes behind `at`.
fn room(at: usize, size: usize, count: usize) -> Result<usize, String> {
    let end = size.checked_mul(count).and_then(|all| all.checked_add(at));
    end.filter(|end| *end <= LONGEST)
        .ok_or_else(|| "fields longer than a message can be".to_owned())
}

fn declared_of(text: &str) -> Option<Declared> {
    let (kind, name) = text.trim().split_once(' ')?;
    let (kind, count) = match kind.split_once('[') {
        None => (kind, 1),
        Some((kind, count)) => (kind, count.strip_suffix(']')?.parse().ok()?),
    };
    Some(Declared {
        kind: kind.to_owned(),
        count,
        name: name.trim().to_owned(),
    })
}

impl Fields {
    /// A number of the message; none where it has no such field or ends before it.
    pub fn number(&self, message: &[u8], name: &str) -> Option<f64> {
        let (number, at) = *self.fields.get(name)?;
        let value = match number {
            Number::F32 => f32::from_le_bytes(array(message, at)?).into(),
            Number::F64 => f64::from_le_bytes(array(message, at)?),
            _ => self.integer(message, name)? as f64,
        };
        value.is_finite().then_some(value)
    }

    /// A whole number of the message, exactly.
    pub fn integer(&self, message: &[u8], name: &str) -> Option<i64> {
        let (number, at) = *self.fields.get(name)?;
        Some(match number {
            Number::I8 => i8::from_le_bytes(array(message, at)?).into(),
            Number::U8 => u8::from_le_bytes(array(message, at)?).into(),
            Number::I16 => i16::from_le_bytes(array(message, at)?).into(),
            Number::U16 => u16::from_le_bytes(array(message, at)?).into(),
            Number::I32 => i32::from_le_bytes(array(message, at)?).into(),
            Number::U32 => u32::from_le_bytes(array(message, at)?).into(),
            Number::I64 => i64::from_le_bytes(array(message, at)?),
            Number::U64 => u64::from_le_bytes(array(message, at)?).try_into().ok()?,
            Number::F32 | Number::F64 => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_behind_arrays_and_nested_types_are_found() {
        let mut definitions = Definitions::default();
        definitions
            .add("inner:uint8_t a;float[3] b;uint8_t[3] _padding0;")
            .unwrap();
        definitions
            .add("outer:uint64_t timestamp;inner[2] in;float[4] q;double lat;")
            .unwrap();
        let fields = definitions.fields_of("outer").unwrap();
        let mut message = vec![0; 8 + 32 + 8];
        message.extend(2.5_f32.to_le_bytes());
        message.extend([0; 4]);
        message.extend((-7.25_f64).to_le_bytes());
        assert_eq!(fields.number(&message, "q[2]"), Some(2.5));
        assert_eq!(fields.number(&message, "lat"), Some(-7.25));
        assert_eq!(fields.number(&message[..50], "lat"), None);
        assert_eq!(fields.integer(&message, "timestamp"), Some(0));
        assert_eq!(definitions.lengths_of("inner"), [13, 16]);
        assert_eq!(definitions.lengths_of("outer"), [64, 64]);
        assert_eq!(definitions.lengths_of("unknown"), [0, LONGEST]);
    }

    #[test]
    fn circles_gaps_and_giants_are_refused() {
        let mut definitions = Definitions::default();
        definitions.add("a:b one;").unwrap();
        definitions.add("b:a one;").unwrap();
        assert!(definitions.fields_of("a").is_err());
        assert!(definitions.fields_of("c").is_err());
        definitions.add("d:uint64_t[99999999999] x;").unwrap();
        assert!(definitions.fields_of("d").is_err());
        assert!(definitions.add("no colon").is_err());
        assert!(definitions.add("e:nospace;").is_err());
    }
}
