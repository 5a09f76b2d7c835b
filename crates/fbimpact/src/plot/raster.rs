//! From a drawing to pixels.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use super::PlotError;
use super::theme::{FONT_DATA, PNG_SCALE};

/// The embedded font alone: system fonts would make pictures depend on the machine.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(FONT_DATA.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// A drawing with its text laid out.
///
/// # Errors
/// [`PlotError::Raster`] if it is no SVG.
fn tree(svg: &str) -> Result<usvg::Tree, PlotError> {
    let options = usvg::Options { fontdb: FONTS.clone(), ..usvg::Options::default() };
    usvg::Tree::from_str(svg, &options).map_err(|e| PlotError::Raster(e.to_string()))
}

/// The PNG of a drawing, on white.
///
/// # Errors
/// [`PlotError::Raster`] if the drawing is too large for memory.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let tree = tree(svg)?;
    let size = tree.size();
    let pixels = |length: f32| (PNG_SCALE * length).ceil() as u32;
    let mut picture = Pixmap::new(pixels(size.width()), pixels(size.height()))
        .ok_or_else(|| PlotError::Raster("the picture is too large".into()))?;
    picture.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut picture.as_mut());
    picture.encode_png().map_err(|e| PlotError::Raster(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::figure::{Axis, Curve, Entry, Figure, Panel, Shade, Sign, entries};
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
