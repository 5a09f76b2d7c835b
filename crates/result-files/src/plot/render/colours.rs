//! Colours of values: the map "viridis" of matplotlib (public domain), which is read by all kinds
//! of colour vision and in grey prints.

use plotters::style::RGBColor;

/// Equally spaced colours from the lowest value to the highest.
const STOPS: [[u8; 3]; 11] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x25, 0x76],
    [0x41, 0x44, 0x87],
    [0x35, 0x5F, 0x8D],
    [0x2A, 0x78, 0x8E],
    [0x21, 0x91, 0x8C],
    [0x22, 0xA8, 0x84],
    [0x44, 0xBF, 0x70],
    [0x7A, 0xD1, 0x51],
    [0xBD, 0xDF, 0x26],
    [0xFD, 0xE7, 0x25],
];

/// The colour of `part` of the range, from 0 to 1.
pub fn colour(part: f64) -> RGBColor {
    let steps = (STOPS.len() - 1) as f64;
    let at = if part.is_finite() { part.clamp(0.0, 1.0) * steps } else { 0.0 };
    let below = (at.floor() as usize).min(STOPS.len() - 2);
    let share = at - below as f64;
    let mix = |c: usize| {
        let (a, b) = (f64::from(STOPS[below][c]), f64::from(STOPS[below + 1][c]));
        (a + share * (b - a)).round() as u8
    };
    RGBColor(mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_prints_rise_with_the_value() {
        let luminance = |part: f64| {
            let RGBColor(r, g, b) = colour(part);
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        for k in 0..50 {
            assert!(luminance(0.02 * f64::from(k + 1)) > luminance(0.02 * f64::from(k)), "{k}");
        }
        assert_eq!((colour(-1.0), colour(2.0)), (colour(0.0), colour(1.0)));
    }
}
