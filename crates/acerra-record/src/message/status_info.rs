//! Identity and state of the radio: GET_STATUSINFO.

use super::fields::Fields;
use super::status_code::StatusCode;

/// GET_STATUSINFO_CONFIRM: versions, serial number, temperature.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatusInfo {
    /// Major version of the MRM software.
    pub mrm_major: u8,
    /// Minor version of the MRM software.
    pub mrm_minor: u8,
    /// Build of the MRM software.
    pub mrm_build: u16,
    /// Major version of the radio's kernel.
    pub kernel_major: u8,
    /// Minor version of the radio's kernel.
    pub kernel_minor: u8,
    /// Build of the radio's kernel.
    pub kernel_build: u16,
    /// Version of the gate array's design.
    pub fpga_version: u8,
    /// Year of the gate array's design.
    pub fpga_year: u8,
    /// Month of the gate array's design.
    pub fpga_month: u8,
    /// Day of the gate array's design.
    pub fpga_day: u8,
    /// Serial number.
    pub serial_number: u32,
    /// Revision of the board.
    pub board_revision: u8,
    /// Result of the self-test at power-on; 0 is passed.
    pub power_on_bit_test: u8,
    /// Type of board: 1 P400, 2 P410, and later models.
    pub board_type: u8,
    /// Transmitter fitted, as the radio codes it.
    pub transmitter_configuration: u8,
    /// Temperature of the board in quarters of a degree Celsius.
    pub temperature_quarter_c: i32,
    /// Version of the whole package, ASCII padded by NUL.
    pub package_version: [u8; 32],
    /// Whether the request was carried out.
    pub status: StatusCode,
}

impl StatusInfo {
    /// Temperature of the board, degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self) -> f64 {
        f64::from(self.temperature_quarter_c) / 4.0
    }

    /// Version of the whole package as text, without characters that are not printable ASCII.
    #[must_use]
    pub fn package(&self) -> String {
        self.package_version
            .iter()
            .take_while(|b| **b != 0)
            .filter(|b| b.is_ascii_graphic() || **b == b' ')
            .map(|b| char::from(*b))
            .collect()
    }

    /// Name of the model, where its type is known.
    #[must_use]
    pub fn model(&self) -> String {
        match self.board_type {
            1 => "P400".to_owned(),
            2 => "P410".to_owned(),
            other => format!("board type {other}"),
        }
    }

    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            mrm_major: fields.u8(),
            mrm_minor: fields.u8(),
            mrm_build: fields.u16(),
            kernel_major: fields.u8(),
            kernel_minor: fields.u8(),
            kernel_build: fields.u16(),
            fpga_version: fields.u8(),
            fpga_year: fields.u8(),
            fpga_month: fields.u8(),
            fpga_day: fields.u8(),
            serial_number: fields.u32(),
            board_revision: fields.u8(),
            power_on_bit_test: fields.u8(),
            board_type: fields.u8(),
            transmitter_configuration: fields.u8(),
            temperature_quarter_c: fields.i32(),
            package_version: fields.array(),
            status: StatusCode::from_code(fields.u32()),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&[self.mrm_major, self.mrm_minor]);
        out.extend_from_slice(&self.mrm_build.to_be_bytes());
        out.extend_from_slice(&[self.kernel_major, self.kernel_minor]);
        out.extend_from_slice(&self.kernel_build.to_be_bytes());
        out.extend_from_slice(&[self.fpga_version, self.fpga_year]);
        out.extend_from_slice(&[self.fpga_month, self.fpga_day]);
        out.extend_from_slice(&self.serial_number.to_be_bytes());
        out.extend_from_slice(&[self.board_revision, self.power_on_bit_test]);
        out.extend_from_slice(&[self.board_type, self.transmitter_configuration]);
        out.extend_from_slice(&self.temperature_quarter_c.to_be_bytes());
        out.extend_from_slice(&self.package_version);
        out.extend_from_slice(&self.status.code().to_be_bytes());
    }
}
