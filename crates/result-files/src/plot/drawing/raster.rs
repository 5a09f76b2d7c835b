//! From a drawing to pixels.

use resvg::tiny_skia::{Color, Pixmap, Transform};

use super::{MARK, tree};
use crate::plot::PlotError;
use crate::plot::theme::PNG_SCALE;

/// The PNG of a drawing, on white.
///
/// # Errors
/// [`PlotError::Convert`] if the drawing is too large for memory.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let tree = tree(svg)?;
    let size = tree.size();
    let pixels = |length: f32| (PNG_SCALE * length).ceil() as u32;
    let mut picture = Pixmap::new(pixels(size.width()), pixels(size.height()))
        .ok_or_else(|| PlotError::Convert("the picture is too large".into()))?;
    picture.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut picture.as_mut());
    let png = picture.encode_png().map_err(|e| PlotError::Convert(e.to_string()))?;
    let (header, rest) = png.split_at(HEADER.min(png.len()));
    Ok([header, &remark("Software", MARK), rest].concat())
}

/// Bytes of the signature and of the first chunk of a PNG.
const HEADER: usize = 8 + 25;

/// A chunk of text.
fn remark(key: &str, text: &str) -> Vec<u8> {
    let chunk = format!("tEXt{key}\0{text}").into_bytes();
    let length = (chunk.len() - 4) as u32;
    [&length.to_be_bytes()[..], &chunk, &checksum(&chunk).to_be_bytes()].concat()
}

/// CRC-32, as PNG has it.
fn checksum(bytes: &[u8]) -> u32 {
    let shifted = |c: u32| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(!0, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), |c, _| shifted(c)))
}

#[cfg(test)]
mod tests {
    use resvg::usvg;

    use super::*;
    use crate::plot::figure::{Axis, Curve, Dot, Entry, Figure, Panel, Shade, Sign, entries};
    use crate::plot::render;
    use crate::plot::theme::Page;

    fn figure(n_panels: usize, columns: usize) -> Figure {
        let x: Vec<f64> = (0..300).map(|i| 1e-6 * f64::from(i)).collect();
        let curve = |style| Curve {
            style,
            x: x.clone(),
            y: x.iter().map(|t| -4.2e7 * t).collect(),
            ..Curve::default()
        };
        let panel = Panel {
            title: "a panel".into(),
            x: Axis { range: Some((0.0, 299e-6)), ..Axis::new("time", "s") },
            y: Axis::new("normal force", "N"),
            curves: (0..8).map(curve).collect(),
            bands: vec![(0.0, 1e-4, Shade::Impact)],
            limits: vec![-5e3],
            ..Panel::default()
        };
        let labels: Vec<String> = (0..8).map(|i| format!("{i}_{}", "long_name_".repeat(5))).collect();
        let mut legend = entries(labels.iter().map(String::as_str));
        legend.push(Entry { sign: Sign::Shade(Shade::Impact), label: "impact phase".into() });
        legend.push(Entry { sign: Sign::Ring, label: "repeated".into() });
        Figure {
            name: "example".into(),
            title: "A title that is about as long as titles of scenarios are, with a subject".into(),
            columns,
            panels: vec![panel; n_panels],
            legend,
        }
    }

    #[test]
    fn pictures_with_a_remark_can_be_read() {
        // The check value of CRC-32.
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
        let svg = render::svg(&figure(1, 1), Page::default()).expect("a drawing");
        let png = png(&svg).expect("a picture");
        assert!(Pixmap::decode_png(&png).is_ok() && png.windows(MARK.len()).any(|w| w == MARK.as_bytes()));
    }

    #[test]
    fn nothing_is_drawn_outside_the_figure() {
        for (n_panels, columns) in [(1, 1), (5, 1), (6, 2)] {
            let svg = render::svg(&figure(n_panels, columns), Page::default()).expect("a drawing");
            let tree = tree(&svg).expect("an SVG");
            let (page, drawn) = (tree.size(), tree.root().abs_stroke_bounding_box());
            // The background ends at the last unit, a tenth of a pixel.
            assert!(drawn.left() >= -0.1 && drawn.top() >= -0.1, "{drawn:?}");
            assert!(
                drawn.right() <= page.width() + 0.1 && drawn.bottom() <= page.height() + 0.1,
                "{drawn:?}"
            );
        }
    }

    /// Centres of the dots of a map, by its drawing in units of a tenth of a pixel.
    fn centres(svg: &str) -> Vec<(i32, i32)> {
        let value = |line: &str, key: &str| -> i32 {
            let after = line.split(&format!(" {key}=\"")).nth(1).expect("the key");
            after.split('"').next().expect("a value").parse().expect("a number")
        };
        svg.lines().filter(|l| l.starts_with("<circle")).map(|l| (value(l, "cx"), value(l, "cy"))).collect()
    }

    #[test]
    fn maps_are_to_scale_and_inside_the_figure() {
        let dot = |x: f64, y: f64, value: f64| Dot { x, y, radius: 2e-5, value };
        let axis = |words: &str, middle: f64| Axis {
            range: Some((middle - 2e-4, middle + 2e-4)),
            ..Axis::new(words, "m")
        };
        let map = Panel {
            x: axis("x", 1e-3),
            y: axis("y", 0.0),
            dots: vec![dot(1e-3, 0.0, 1e9), dot(1.1e-3, 0.0, 2e9), dot(1e-3, 1e-4, 3e9)],
            colours: Some(Axis { range: Some((0.0, 3e9)), ..Axis::new("pressure", "Pa") }),
            ..Panel::default()
        };
        let map =
            Figure { title: "a map".into(), columns: 2, panels: vec![map.clone(), map], ..Figure::default() };
        for width in [190.0, 85.0] {
            let svg = render::svg(&map, Page { width, has_title: true }).expect("a drawing");
            // The lowest value is drawn first.
            let [a, right, up, ..] = centres(&svg)[..] else { panic!("six dots") };
            let (dx, dy) = (right.0 - a.0, a.1 - up.1);
            // Places are rounded to a unit.
            assert!(
                dx > 300 && (dx - dy).abs() <= 2 && right.1 == a.1 && up.0 == a.0,
                "{a:?} {right:?} {up:?}"
            );
            let tree = tree(&svg).expect("an SVG");
            let (page, drawn) = (tree.size(), tree.root().abs_stroke_bounding_box());
            assert!(
                drawn.right() <= page.width() + 0.1 && drawn.bottom() <= page.height() + 0.1,
                "{drawn:?}"
            );
        }
    }

    #[test]
    fn text_is_drawn_with_the_embedded_font() {
        let svg = render::svg(&figure(1, 1), Page::default()).expect("a drawing");
        let words = svg.matches("<text").count();
        fn texts(group: &usvg::Group) -> usize {
            let of = |node: &usvg::Node| match node {
                usvg::Node::Group(group) => texts(group),
                usvg::Node::Text(text) => usize::from(text.abs_bounding_box().width() > 0.0),
                _ => 0,
            };
            group.children().iter().map(of).sum()
        }
        assert!(words > 20);
        assert_eq!(texts(tree(&svg).expect("an SVG").root()), words);
    }
}
