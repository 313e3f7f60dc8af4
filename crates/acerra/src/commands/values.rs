//! Values of options: parsed, checked, and refused with the reason.

/// A finite number.
///
/// # Errors
/// Text that is none.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a finite number".to_owned()),
    }
}

/// A number above zero.
///
/// # Errors
/// Text that is none.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err("expected a number above 0".to_owned())
        }
    })
}

/// A number that is not negative.
///
/// # Errors
/// Text that is none.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| {
        if value >= 0.0 {
            Ok(value)
        } else {
            Err("expected a number not below 0".to_owned())
        }
    })
}

/// A number of a range.
///
/// # Errors
/// Text that is none, or a number outside it.
pub fn number_in(text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    let (least, most) = (range.start(), range.end());
    if range.contains(&value) {
        Ok(value)
    } else {
        Err(format!("expected {least} to {most}"))
    }
}

/// A share, from none to all.
///
/// # Errors
/// Text that is none.
pub fn share(text: &str) -> Result<f64, String> {
    number_in(text, 0.0..=1.0)
}

/// A band `A:B` in GHz, as (A, B) in Hz.
///
/// # Errors
/// Text that is none, or a band without width: it would have no range resolution.
pub fn band_ghz(text: &str) -> Result<(f64, f64), String> {
    let expected = "expected two frequencies in GHz as LOW:HIGH, such as 3.1:4.8";
    let (low, high) = text.split_once(':').ok_or(expected)?;
    let (low, high) = (positive(low), positive(high));
    let (Ok(low), Ok(high)) = (low, high) else {
        return Err(expected.to_owned());
    };
    if low >= high {
        return Err(format!(
            "the band must have a width (no bandwidth, no range resolution): {high} GHz is not \
             above {low} GHz"
        ));
    }
    Ok((low * 1e9, high * 1e9))
}

/// A point `X,Y,Z` in metres.
///
/// # Errors
/// Text that is none.
pub fn point_m(text: &str) -> Result<[f64; 3], String> {
    let values: Vec<f64> = text
        .split(',')
        .map_while(|part| number(part).ok())
        .collect();
    match (values[..].try_into(), text.split(',').count()) {
        (Ok(point), 3) => Ok(point),
        _ => Err("expected three numbers in metres as X,Y,Z".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_or_refused() {
        assert_eq!(band_ghz("3.1:4.8"), Ok((3.1e9, 4.8e9)));
        assert!(band_ghz("4:4").unwrap_err().contains("no bandwidth"));
        assert!(band_ghz("4.8:3.1").is_err() && band_ghz("3.1").is_err());
        assert!(band_ghz("-1:2").is_err() && band_ghz("1:inf").is_err());
        assert_eq!(point_m("1, -2,0.5"), Ok([1.0, -2.0, 0.5]));
        assert!(
            point_m("1,2").is_err() && point_m("1,2,3,4").is_err() && point_m("1,2,x").is_err()
        );
        assert!(positive("0").is_err() && positive("nan").is_err());
        assert_eq!(not_negative("0"), Ok(0.0));
    }
}
