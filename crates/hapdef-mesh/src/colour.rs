//! Colours for numbers.

/// 33 even steps, ends included, through the 256-entry colour map `viridis` by Nathaniel J. Smith,
/// Stéfan van der Walt and Eric Firing (matplotlib 1.5, 2015, `_cm_listed.py`, CC0), as 8-bit sRGB:
/// perceptually uniform, and readable by the colour-blind and in grey.
const VIRIDIS: [[u8; 3]; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 54, 129],
    [66, 64, 134],
    [63, 73, 137],
    [59, 82, 139],
    [55, 90, 141],
    [51, 99, 141],
    [47, 106, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 129, 142],
    [35, 137, 142],
    [33, 144, 140],
    [31, 152, 139],
    [31, 159, 136],
    [33, 166, 133],
    [40, 174, 128],
    [49, 181, 123],
    [62, 188, 116],
    [76, 194, 108],
    [93, 201, 99],
    [110, 206, 88],
    [130, 211, 76],
    [150, 216, 63],
    [171, 220, 50],
    [192, 223, 36],
    [213, 226, 26],
    [234, 229, 26],
    [253, 231, 37],
];

/// The colour of `t` on the map `viridis`, 8-bit sRGB: dark violet at 0, yellow at 1, linear
/// between 33 fixed colours (within 2 of the original's 256). Below 0 and above 1 the end colours;
/// NaN is mid-grey, which the map does not contain.
#[must_use]
pub fn viridis(t: f64) -> [u8; 3] {
    if t.is_nan() {
        return [128; 3];
    }
    let place = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let part = place - below as f64;
    std::array::from_fn(|i| {
        let [low, high] = [below, below + 1].map(|k| f64::from(VIRIDIS[k][i]));
        (low + part * (high - low)).round() as u8
    })
}

/// An 8-bit sRGB colour as linear intensities in 0..=1: IEC 61966-2-1:1999, the inverse transfer
/// function.
#[must_use]
pub fn linear_from_srgb(colour: [u8; 3]) -> [f64; 3] {
    colour.map(|byte| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries 0, 64, 128, 192 and 255 of matplotlib 3.11's table.
    #[test]
    fn agrees_with_matplotlib() {
        for (entry, expected) in [
            (0, [68, 1, 84]),
            (64, [59, 82, 139]),
            (128, [33, 145, 140]),
            (192, [94, 201, 98]),
            (255, [253, 231, 37]),
        ] {
            let found = viridis(f64::from(entry) / 255.0);
            for i in 0..3 {
                assert!(found[i].abs_diff(expected[i]) <= 2, "{entry}: {found:?} {expected:?}");
            }
        }
    }

    /// CIE L* of a grey-free sRGB colour (D65): equal steps of t are equal steps of lightness.
    #[test]
    fn lightness_rises_evenly() {
        let lightness = |t: f64| {
            let [r, g, b] = linear_from_srgb(viridis(t));
            116.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt() - 16.0
        };
        let (low, high) = (lightness(0.0), lightness(1.0));
        for step in 0..=20 {
            let t = f64::from(step) / 20.0;
            let even = low + t * (high - low);
            assert!((lightness(t) - even).abs() < 2.0, "t {t}: {} {even}", lightness(t));
        }
    }

    #[test]
    fn outside_and_nan() {
        assert_eq!(viridis(-3.0), viridis(0.0));
        assert_eq!(viridis(f64::INFINITY), [253, 231, 37]);
        assert_eq!(viridis(f64::NAN), [128; 3]);
    }
}
