//! A drawing with its text laid out: what pixels and PDF are made from.

pub mod pdf;
pub mod raster;

use std::sync::{Arc, LazyLock};

use resvg::usvg::{self, fontdb};

use super::PlotError;
use super::theme::FONT_DATA;
use crate::file::output::Kind;

/// A figure in any format, by the words that each has in a place of its own.
pub const FIGURE: Kind = Kind::marked("a figure that fbimpact drew", MARK);
const MARK: &str = "drawn by fbimpact";

/// The drawing with a remark below its first line, by which it is known again.
pub fn marked(svg: &str) -> String {
    svg.replacen('\n', &format!("\n<!-- {MARK} -->\n"), 1)
}

/// The embedded font alone: system fonts would make pictures depend on the machine.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(FONT_DATA.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// The drawing `svg` with its text laid out.
///
/// # Errors
/// [`PlotError::Convert`] if it is no SVG.
fn tree(svg: &str) -> Result<usvg::Tree, PlotError> {
    let options = usvg::Options { fontdb: FONTS.clone(), ..usvg::Options::default() };
    usvg::Tree::from_str(svg, &options).map_err(|e| PlotError::Convert(e.to_string()))
}
