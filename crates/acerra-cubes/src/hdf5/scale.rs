//! Attributes of a dimension scale.

use super::datatype;
use super::object::Messages;

/// Attributes of a dimension scale.
#[derive(Debug)]
pub(super) struct Scale {
    /// Value of the scale's NAME attribute.
    pub name: String,
    /// Number of its dimension.
    pub number: usize,
    /// Addresses of the arrays attached to it, and their dimensions.
    pub attached: Vec<(u64, usize)>,
}

impl Scale {
    pub(super) fn describe(&self, messages: &mut Messages) {
        messages.fixed_text("CLASS", "DIMENSION_SCALE");
        messages.fixed_text("NAME", &self.name);
        let number = i32::try_from(self.number).unwrap_or(i32::MAX);
        let whole = datatype::whole32();
        messages.attribute("_Netcdf4Dimid", &whole, &[], &number.to_le_bytes());
        if self.attached.is_empty() {
            return;
        }
        let mut bytes = Vec::new();
        for (address, place) in &self.attached {
            bytes.extend(address.to_le_bytes());
            bytes.extend(i32::try_from(*place).unwrap_or(i32::MAX).to_le_bytes());
            bytes.extend([0; 4]);
        }
        let shape = [self.attached.len()];
        messages.attribute("REFERENCE_LIST", &datatype::attached(), &shape, &bytes);
    }
}
