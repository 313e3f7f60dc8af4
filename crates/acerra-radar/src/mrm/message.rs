//! The messages of the MRM interface: types, names, lengths.

use super::header::SCAN_MESSAGE_BYTES;

/// First two bytes of the prefix that USB and serial links put before each message; the message's
/// length follows as a `u16`.
pub const SERIAL_PREFIX: [u8; 2] = [0xA5, 0xA5];

macro_rules! messages {
    ($($name:ident = $code:literal, $text:literal, $bytes:expr;)*) => {
        /// Types of MRM messages.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum MessageType {
            $(#[doc = concat!("`", $text, "`")] $name,)*
        }

        impl MessageType {
            /// Every type.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// From the message's first field.
            #[must_use]
            pub fn from_code(code: u16) -> Option<Self> {
                match code { $($code => Some(Self::$name),)* _ => None }
            }

            /// The message's first field.
            #[must_use]
            pub fn code(self) -> u16 {
                match self { $(Self::$name => $code),* }
            }

            /// Name in the protocol.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text),* }
            }

            /// Length of the whole message (type and id included), bytes.
            #[must_use]
            pub const fn bytes(self) -> usize {
                match self { $(Self::$name => $bytes),* }
            }
        }
    };
}

messages! {
    SetConfigRequest = 0x1001, "SET_CONFIG_REQUEST", 36;
    SetConfigConfirm = 0x1101, "SET_CONFIG_CONFIRM", 8;
    GetConfigRequest = 0x1002, "GET_CONFIG_REQUEST", 4;
    GetConfigConfirm = 0x1102, "GET_CONFIG_CONFIRM", 44;
    ControlRequest = 0x1003, "CONTROL_REQUEST", 12;
    ControlConfirm = 0x1103, "CONTROL_CONFIRM", 8;
    SetFilterConfigRequest = 0x1006, "SET_FILTER_CONFIG_REQUEST", 8;
    SetFilterConfigConfirm = 0x1106, "SET_FILTER_CONFIG_CONFIRM", 8;
    GetFilterConfigRequest = 0x1007, "GET_FILTER_CONFIG_REQUEST", 4;
    GetFilterConfigConfirm = 0x1107, "GET_FILTER_CONFIG_CONFIRM", 12;
    DetectionListInfo = 0x1201, "DETECTION_LIST_INFO", 1408;
    GetStatusInfoRequest = 0xF001, "GET_STATUSINFO_REQUEST", 4;
    GetStatusInfoConfirm = 0xF101, "GET_STATUSINFO_CONFIRM", 64;
    RebootRequest = 0xF002, "REBOOT_REQUEST", 4;
    RebootConfirm = 0xF102, "REBOOT_CONFIRM", 4;
    SetOpmodeRequest = 0xF003, "SET_OPMODE_REQUEST", 8;
    SetOpmodeConfirm = 0xF103, "SET_OPMODE_CONFIRM", 12;
    SetSleepmodeRequest = 0xF005, "SET_SLEEPMODE_REQUEST", 8;
    SetSleepmodeConfirm = 0xF105, "SET_SLEEPMODE_CONFIRM", 12;
    ScanInfo = 0xF201, "SCAN_INFO", SCAN_MESSAGE_BYTES;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_round_trip() {
        for &kind in MessageType::ALL {
            assert_eq!(MessageType::from_code(kind.code()), Some(kind));
            assert!(kind.bytes() >= 4);
        }
        assert_eq!(MessageType::from_code(0x01F2), None);
    }
}
