//! Sizes in messages: lengths, numbers of bytes, and pixels that fit.

/// A length (m) to the millimetre, for messages.
pub(super) fn millimetres(length_m: f64) -> f64 {
    (1e3 * length_m).round() / 1e3
}

/// A number of bytes in the decimal unit that leaves one to three digits before the point.
#[must_use]
pub fn bytes_text(bytes: u128) -> String {
    const UNITS: [&str; 5] = ["kB", "MB", "GB", "TB", "PB"];
    let mut value = bytes as f64;
    let mut name = "bytes";
    for unit in UNITS {
        if value < 999.5 {
            break;
        }
        value /= 1e3;
        name = unit;
    }
    match name {
        "bytes" => format!("{bytes} bytes"),
        _ if value < 99.95 => format!("{value:.1} {name}"),
        _ => format!("{value:.0} {name}"),
    }
}

/// Side of a pixel (m), rounded up to two digits, with which pixels that need `bytes` need half of `limit_bytes` at
/// most.
#[must_use]
pub fn fitting_pixel_m(pixel_m: f64, bytes: u128, limit_bytes: u128) -> f64 {
    let least_m = pixel_m * (2.0 * bytes as f64 / limit_bytes.max(1) as f64).sqrt();
    let digit = 10f64.powf(least_m.log10().floor() - 1.0);
    let rounded = (least_m / digit).ceil() * digit;
    // The shortest decimal of two digits.
    format!("{rounded:.1e}").parse().unwrap_or(rounded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_said_in_the_unit_that_suits() {
        for (bytes, said) in [
            (12, "12 bytes"),
            (1_500, "1.5 kB"),
            (82_000_000, "82.0 MB"),
            (68_719_476_736, "68.7 GB"),
            (128_000_064_000_008, "128 TB"),
            (u128::from(u64::MAX) * 1_000, "18446744 PB"),
        ] {
            assert_eq!(bytes_text(bytes), said);
        }
    }

    #[test]
    fn pixels_that_are_suggested_fit() {
        let limit_bytes = 68_719_476_736;
        for side_m in [40.0_f64, 4e4, 1e7] {
            for pixel_m in [1e-7, 1e-5, 0.01] {
                let needed = |pixel_m: f64| (8.0 * (side_m / pixel_m).powi(2)) as u128;
                if needed(pixel_m) <= limit_bytes {
                    continue;
                }
                let fits_m = fitting_pixel_m(pixel_m, needed(pixel_m), limit_bytes);
                assert!(
                    needed(fits_m) <= limit_bytes,
                    "{side_m} {pixel_m}: {fits_m}"
                );
                // As fine as possible, rounded to two digits.
                assert!(
                    4 * needed(fits_m) > limit_bytes,
                    "{side_m} {pixel_m}: {fits_m}"
                );
                assert!(
                    format!("{fits_m:e}").split('e').next().unwrap().len() <= 3,
                    "{fits_m:e}"
                );
            }
        }
    }
}
