//! Messages against the protocol's facts, byte by byte, and any bytes at all.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_radar::mrm::{MessageType, RadarConfig, SAMPLES_PER_MESSAGE, SCAN_MESSAGE_BYTES};
use acerra_record::link::Deframer;
use acerra_record::message::{
    ControlRequest, DecodeError, FilterConfig, Message, ModeConfirm, Packet, StatusCode,
};
use proptest::prelude::*;

/// Bytes from hexadecimal digits; blanks divide fields.
fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u32> = text.chars().filter_map(|c| c.to_digit(16)).collect();
    digits.chunks(2).map(|d| (16 * d[0] + d[1]) as u8).collect()
}

fn agrees(bytes: &str, id: u16, message: Message) {
    let (bytes, packet) = (hex(bytes), Packet { id, message });
    assert_eq!(packet.encode(), bytes, "{packet:?}");
    assert_eq!(Packet::decode(&bytes), Ok(packet));
}

#[test]
fn requests_and_confirms_stand_as_the_protocol_has_them() {
    let config = RadarConfig {
        node_id: 0x0102_0304,
        scan_start_ps: 16_670,
        scan_stop_ps: 86_982,
        scan_resolution_bins: 32,
        integration_index: 11,
        segment_samples: [1, 2, 3, 4],
        segment_integration: [5, 6, 7, 8],
        antenna_mode: 2,
        transmit_gain: 63,
        code_channel: 10,
        persist: 1,
    };
    let body = "01020304 0000411E 000153C6 0020 000B 0001 0002 0003 0004 05060708 02 3F 0A 01";
    agrees(
        &format!("1001 0007 {body}"),
        7,
        Message::SetConfigRequest(config),
    );
    let confirm = acerra_record::message::ConfigConfirm {
        config,
        timestamp_ms: 0x1122_3344,
        status: StatusCode::Success,
    };
    agrees(
        &format!("1102 0008 {body} 11223344 00000000"),
        8,
        Message::GetConfigConfirm(confirm),
    );
    agrees("1002 FFFF", 0xFFFF, Message::GetConfigRequest);
    agrees(
        "1101 0007 00000003",
        7,
        Message::SetConfigConfirm(StatusCode::UnsupportedValue),
    );
    agrees(
        "1003 0001 FFFF 0000 00002710",
        1,
        Message::ControlRequest(ControlRequest::continuous(10_000)),
    );
    agrees(
        "1003 0002 0000 0000 00000000",
        2,
        Message::ControlRequest(ControlRequest::STOP),
    );
    agrees(
        "1103 0001 00000002",
        1,
        Message::ControlConfirm(StatusCode::WrongMode),
    );
    agrees(
        "1006 0003 0001 00 00",
        3,
        Message::SetFilterConfigRequest(FilterConfig::RAW_ONLY),
    );
    agrees(
        "1106 0003 00000001",
        3,
        Message::SetFilterConfigConfirm(StatusCode::Failure),
    );
    agrees("1007 0004", 4, Message::GetFilterConfigRequest);
    agrees("F001 0005", 5, Message::GetStatusInfoRequest);
    agrees("F002 0006", 6, Message::RebootRequest);
    agrees("F102 0006", 6, Message::RebootConfirm);
    agrees("F003 0009 00000001", 9, Message::SetOpmodeRequest(1));
    let mode = ModeConfirm {
        mode: 1,
        status: StatusCode::Other(0x0900_0000),
    };
    agrees(
        "F103 0009 00000001 09000000",
        9,
        Message::SetOpmodeConfirm(mode),
    );
    agrees("F005 000A 00000004", 10, Message::SetSleepmodeRequest(4));
    agrees(
        "F105 000A 00000001 09000000",
        10,
        Message::SetSleepmodeConfirm(mode),
    );
}

#[test]
fn a_filter_confirm_has_mask_index_and_status() {
    let bytes = hex("1107 0004 0009 02 00 00000000");
    let packet = Packet::decode(&bytes).unwrap();
    let Message::GetFilterConfigConfirm(confirm) = &packet.message else {
        panic!("{packet:?}");
    };
    assert_eq!(
        confirm.filter.filter_mask,
        FilterConfig::RAW | FilterConfig::DETECTION_LIST
    );
    assert_eq!(confirm.filter.motion_filter_index, 2);
    assert_eq!(packet.encode(), bytes);
}

#[test]
fn a_status_says_versions_and_temperature() {
    let mut bytes =
        hex("F101 0005 01 02 0304 05 06 0708 09 0A 0B 0C 0D0E0F10 41 00 02 01 FFFFFFF6");
    bytes.extend_from_slice(b"3.2\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
    bytes.extend_from_slice(&[0; 4]);
    let packet = Packet::decode(&bytes).unwrap();
    let Message::GetStatusInfoConfirm(info) = &packet.message else {
        panic!("{packet:?}");
    };
    assert_eq!(
        (info.mrm_major, info.mrm_minor, info.mrm_build),
        (1, 2, 0x0304)
    );
    assert_eq!(info.serial_number, 0x0D0E_0F10);
    assert_eq!(info.temperature_c(), -2.5);
    assert_eq!(
        (info.package(), info.model()),
        ("3.2".into(), "P410".into())
    );
    assert_eq!(packet.encode(), bytes);
}

#[test]
fn a_scan_message_keeps_its_unused_places() {
    let mut bytes = hex(
        "F201 1234 00000064 0000AFC8 00000001 00000002 00000003 00000004 0000411E 000153C6 0020 \
         01 03 02 01 0066 00000480 0003 0004",
    );
    assert_eq!(bytes.len(), 52);
    for i in 0..350_i32 {
        bytes.extend_from_slice(&(i - 200).to_be_bytes());
    }
    assert_eq!(bytes.len(), SCAN_MESSAGE_BYTES);
    let packet = Packet::decode(&bytes).unwrap();
    let Message::ScanInfo(scan) = &packet.message else {
        panic!("{packet:?}");
    };
    assert_eq!((packet.id, scan.header.timestamp_ms), (0x1234, 45_000));
    assert_eq!(scan.samples().len(), 102);
    assert_eq!(scan.slots[SAMPLES_PER_MESSAGE - 1], 149);
    assert_eq!(packet.encode(), bytes);
}

#[test]
fn what_is_no_message_is_refused_with_expected_and_found() {
    let text = |bytes: &[u8]| Packet::decode(bytes).unwrap_err().to_string();
    assert_eq!(
        text(&[0xF0]),
        "expected a message of 4 bytes at least, found 1"
    );
    assert_eq!(
        text(&[0x12, 0x34, 0, 0]),
        "expected a message type of the MRM interface, found 0x1234"
    );
    assert_eq!(
        text(&[0xF0, 0x03, 0, 0]),
        "SET_OPMODE_REQUEST: expected 8 bytes, found 4"
    );
    let mut scan = vec![0; SCAN_MESSAGE_BYTES];
    scan[..2].copy_from_slice(&[0xF2, 0x01]);
    assert!(matches!(Packet::decode(&scan), Err(DecodeError::Scan(_))));
}

fn kinds() -> impl Strategy<Value = MessageType> {
    (0..MessageType::ALL.len()).prop_map(|i| MessageType::ALL[i])
}

proptest! {
    #[test]
    fn any_bytes_of_a_messages_length_survive_the_round_trip(
        (kind, mut bytes) in kinds().prop_flat_map(|kind| {
            (Just(kind), prop::collection::vec(any::<u8>(), kind.bytes()))
        })
    ) {
        bytes[..2].copy_from_slice(&kind.code().to_be_bytes());
        match Packet::decode(&bytes) {
            Ok(packet) => prop_assert_eq!(packet.encode(), bytes),
            Err(error) => prop_assert!(matches!(error, DecodeError::Scan(_)), "{}", error),
        }
    }

    #[test]
    fn any_bytes_are_decoded_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..1600)) {
        if let Ok(packet) = Packet::decode(&bytes) {
            prop_assert_eq!(packet.encode(), bytes.clone());
        }
        let mut deframer = Deframer::default();
        deframer.push(&bytes);
        let bodies: usize = std::iter::from_fn(|| deframer.next_body()).map(|b| b.len() + 4).sum();
        prop_assert!(bodies as u64 + deframer.skipped_bytes() <= bytes.len() as u64);
    }
}
