//! How figures look: sizes, font, colours, dashes.
//!
//! Colours are those of Okabe and Ito (2008), which people with any kind of colour vision can tell
//! apart; dashes differ as well, so that black-and-white prints work. Lengths are in units of a
//! tenth of a pixel of 1/96 inch: the drawing library counts in integers.

use plotters::style::RGBColor;

/// Units a pixel.
pub const UNITS: u32 = 10;
/// Width of a figure unless another is asked for \[mm\]: the text width of a page.
pub const WIDTH: f64 = 190.0;
/// Pixels a millimetre.
const PIXELS: f64 = 720.0 / 190.0;
/// Height of a panel that stands alone \[px\].
pub const PANEL_HEIGHT: u32 = 300;
/// Height of one of several panels \[px\].
pub const SMALL_PANEL_HEIGHT: u32 = 195;
/// Pixels of the PNG a pixel of the drawing: 240 dots an inch.
pub const PNG_SCALE: f32 = 2.5;
/// Family as written to the drawing; the first is embedded.
pub const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
/// The embedded font, see `assets/DejaVuSans.LICENSE`.
pub const FONT_DATA: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");
/// Factor by which the drawing library divides sizes of text in its output.
pub const TEXT_FACTOR: f64 = 1.24;
/// Text at axes and in legends \[px\]: 9 points.
pub const TEXT: f64 = 12.0;
/// Title \[px\].
pub const TITLE: f64 = 14.0;
/// Width of curves \[px\].
pub const LINE: f64 = 1.6;
/// Text and axes; differs from every colour of a curve.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Grid.
pub const GRID: RGBColor = RGBColor(0xD0, 0xD0, 0xD0);
/// Impact phases.
pub const IMPACT: RGBColor = RGBColor(0xE0, 0xE0, 0xE1);
/// Free phases.
pub const FREE: RGBColor = RGBColor(0xF5, 0xF5, 0xF6);
/// Limits.
pub const LIMIT: RGBColor = RGBColor(0x77, 0x77, 0x78);

/// Colour of a curve and its dashes \[px\]; none: solid.
pub struct Style {
    /// Colour.
    pub colour: RGBColor,
    /// Lengths of dashes and gaps by turns.
    pub dashes: &'static [f64],
}

/// Styles of curves.
pub const STYLES: [Style; 8] = [
    Style { colour: RGBColor(0x00, 0x72, 0xB2), dashes: &[] },
    Style { colour: RGBColor(0xD5, 0x5E, 0x00), dashes: &[7.0, 3.0] },
    Style { colour: RGBColor(0x00, 0x9E, 0x73), dashes: &[9.0, 2.5, 1.8, 2.5] },
    Style { colour: RGBColor(0xCC, 0x79, 0xA7), dashes: &[2.0, 2.2] },
    Style { colour: RGBColor(0xE6, 0x9F, 0x00), dashes: &[13.0, 3.0] },
    Style { colour: RGBColor(0x56, 0xB4, 0xE9), dashes: &[7.0, 2.0, 1.8, 2.0, 1.8, 2.0] },
    Style { colour: RGBColor(0x00, 0x00, 0x00), dashes: &[4.0, 4.0] },
    Style { colour: RGBColor(0x8C, 0x50, 0x2A), dashes: &[12.0, 2.5, 4.0, 2.5] },
];

/// What a figure is drawn on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Page {
    /// Width of the figure \[mm\].
    pub width: f64,
    /// Whether it has its title.
    pub has_title: bool,
}

impl Default for Page {
    fn default() -> Self {
        Self { width: WIDTH, has_title: true }
    }
}

impl Page {
    /// Width in units.
    pub fn units(self) -> i32 {
        units(self.width * PIXELS)
    }
}

/// A light shade of `colour`, which is none of a curve: what lies between the bounds of one that
/// rings.
pub fn tint(RGBColor(r, g, b): RGBColor) -> RGBColor {
    let light = |c: u8| 255 - (255 - c) / 3;
    RGBColor(light(r), light(g), light(b))
}

/// Style number `i`; they come again after the last.
pub fn style(i: usize) -> &'static Style {
    &STYLES[i % STYLES.len()]
}

/// `px` pixels in units.
pub fn units(px: f64) -> i32 {
    (px * f64::from(UNITS)).round() as i32
}

/// Writes the dashes of the styles into a drawing: the library draws solid lines only, and every
/// style has its own colour.
pub fn with_dashes(svg: &str) -> String {
    let mut out = svg.to_owned();
    for style in STYLES.iter().chain([&Style { colour: LIMIT, dashes: &[3.0, 3.0] }]) {
        let RGBColor(r, g, b) = style.colour;
        let stroke = format!("fill=\"none\" opacity=\"1\" stroke=\"#{r:02X}{g:02X}{b:02X}\"");
        let mut dashed = format!("{stroke} stroke-linejoin=\"round\"");
        if !style.dashes.is_empty() {
            let lengths: Vec<String> = style.dashes.iter().map(|d| units(*d).to_string()).collect();
            dashed += &format!(" stroke-dasharray=\"{}\"", lengths.join(" "));
        }
        out = out.replace(&stroke, &dashed);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_style_has_its_own_colour_and_dashes() {
        for (i, a) in STYLES.iter().enumerate() {
            for b in &STYLES[..i] {
                assert_ne!(a.colour, b.colour);
                assert_ne!(a.dashes, b.dashes);
            }
            // Others would get the dashes of a curve.
            assert!(![INK, GRID, IMPACT, FREE, LIMIT].contains(&a.colour));
        }
    }

    #[test]
    fn curves_get_their_dashes() {
        let drawn = "<polyline fill=\"none\" opacity=\"1\" stroke=\"#D55E00\" stroke-width=\"16\" points=\"0,0 1,1\"/>";
        assert!(with_dashes(drawn).contains("stroke-dasharray=\"70 30\""));
        let solid = with_dashes(&drawn.replace("D55E00", "0072B2"));
        assert!(!solid.contains("dasharray") && solid.contains("linejoin"));
    }
}
