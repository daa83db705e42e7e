//! Figures of a stage's record for people: three significant digits and a unit.

use serde_json::Value;

/// Endings of names, and the units that they stand for.
const UNITS: [(&str, &str); 13] = [
    ("_um_per_n", "µm/N"),
    ("_ue_per_n", "µε/N"),
    ("_kg_m3", "kg/m³"),
    ("_per_s", "/s"),
    ("_mm", "mm"),
    ("_um", "µm"),
    ("_ue", "µε"),
    ("_nm", "N m"),
    ("_pct", "%"),
    ("_pa", "Pa"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_n", "N"),
];

/// A name in words and its value with its unit, as they are printed in a list.
pub(super) fn figure(name: &str, value: &Value) -> (String, String) {
    let of = |(ending, unit): &(&str, &'static str)| Some((name.strip_suffix(ending)?, *unit));
    let unit = UNITS.iter().find_map(of).filter(|_| value.is_f64());
    let stem = unit.map_or(name, |(stem, _)| stem);
    let number = match value {
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(whole), _) => whole.to_string(),
            (None, Some(real)) => three_digits(real),
            (None, None) => number.to_string(),
        },
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let shown = unit.map_or(number.clone(), |(_, unit)| format!("{number} {unit}"));
    (stem.strip_prefix("n_").unwrap_or(stem).replace('_', " "), shown)
}

/// A number of three significant digits, with an exponent where zeros would stand for digits.
fn three_digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = 2 - size.log10().floor() as i32;
    let text = format!("{value:.*}", digits.max(0) as usize);
    // 9.996 is 10.0, not 10.00
    let n_digits = text.chars().filter(char::is_ascii_digit).collect::<String>();
    match n_digits.trim_start_matches('0').len() {
        4.. if digits > 0 => format!("{value:.*}", digits as usize - 1),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    #[test]
    fn figures_have_their_units() {
        let shown = |name: &str, value: Value| {
            let (name, value) = figure(name, &value);
            format!("{name}: {value}")
        };
        assert_eq!(shown("condition", json!(16_322_603.406_523_317)), "condition: 1.63e7");
        assert_eq!(shown("elapsed_s", json!(12.345)), "elapsed: 12.3 s");
        assert_eq!(shown("n_fe_nodes", json!(48_213)), "fe nodes: 48213");
        assert_eq!(shown("largest_ue_per_n", json!(0.012_34)), "largest: 0.0123 µε/N");
        assert_eq!(shown("median_self_um_per_n", json!(12.64)), "median self: 12.6 µm/N");
        assert_eq!(shown("loss", json!(0.0)), "loss: 0");
        assert_eq!(shown("kind", json!("lattice")), "kind: lattice");
    }

    proptest! {
        #[test]
        fn three_digits_are_within_half_of_the_last(value in prop_oneof![-1e7..1e7f64, -1.0..1.0f64]) {
            let read: f64 = three_digits(value).parse().unwrap();
            prop_assert!((read - value).abs() <= 5.01e-3 * value.abs(), "{} {value}", three_digits(value));
        }
    }
}
