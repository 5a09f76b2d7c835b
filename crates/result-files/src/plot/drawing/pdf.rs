//! From a drawing to PDF: paths, filled and stroked; text as outlines of the embedded font
//! (docs/decisions/0047).

use std::fmt::Write;

use miniz_oxide::deflate::compress_to_vec_zlib;
use resvg::tiny_skia::{PathSegment, Point, Transform};
use resvg::usvg::{FillRule, Group, LineCap, LineJoin, Node, Opacity, Paint, Path, Stroke};

use super::{MARK, tree};
use crate::plot::PlotError;

/// Points of print a pixel of 1/96 inch.
const POINTS: f32 = 0.75;
/// Compression of the page, from 1 to 10.
const COMPRESSION: u8 = 8;

/// The PDF of a drawing, one page of its size, with `title` in its properties.
///
/// # Errors
/// [`PlotError::Convert`] if `svg` is no SVG or has what figures do not have: pictures, gradients, transparency.
pub fn pdf(svg: &str, title: &str) -> Result<Vec<u8>, PlotError> {
    let tree = tree(svg)?;
    let (width, height) = (POINTS * tree.size().width(), POINTS * tree.size().height());
    // Coordinates of PDF rise upwards, from the lower left corner, in points.
    let mut page = String::new();
    group(&mut page, tree.root(), Transform::from_row(POINTS, 0.0, 0.0, -POINTS, 0.0, height))?;
    let packed = compress_to_vec_zlib(page.as_bytes(), COMPRESSION);
    let mut file = File::new();
    file.object("<< /Type /Catalog /Pages 2 0 R >>");
    file.object("<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
    file.object(&format!(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Resources << >> /Contents 4 0 R >>",
        number(width),
        number(height)
    ));
    file.stream(&packed);
    file.object(&format!("<< /Title {} /Creator (fbimpact) /Producer ({MARK}) >>", text(title)));
    Ok(file.end())
}

/// A file as it grows: its bytes, and where each object begins.
struct File {
    bytes: Vec<u8>,
    offsets: Vec<usize>,
}

impl File {
    fn new() -> Self {
        // Bytes above 127 in the second line tell programs that the file is not text.
        Self { bytes: b"%PDF-1.4\n%\xE2\xE3\xCF\xD3\n".to_vec(), offsets: Vec::new() }
    }

    fn begin(&mut self) {
        self.offsets.push(self.bytes.len());
        self.bytes.extend(format!("{} 0 obj\n", self.offsets.len()).bytes());
    }

    fn object(&mut self, dictionary: &str) {
        self.begin();
        self.bytes.extend(dictionary.bytes());
        self.bytes.extend(b"\nendobj\n");
    }

    fn stream(&mut self, packed: &[u8]) {
        self.begin();
        let head = format!("<< /Length {} /Filter /FlateDecode >>\nstream\n", packed.len());
        self.bytes.extend(head.bytes());
        self.bytes.extend(packed);
        self.bytes.extend(b"\nendstream\nendobj\n");
    }

    /// The whole file: the table of the objects, of which the first is the catalogue and the last
    /// the properties.
    fn end(mut self) -> Vec<u8> {
        let table = self.bytes.len();
        let n = self.offsets.len() + 1;
        let mut out = format!("xref\n0 {n}\n0000000000 65535 f \n");
        for offset in &self.offsets {
            out += &format!("{offset:010} 00000 n \n");
        }
        out +=
            &format!("trailer\n<< /Size {n} /Root 1 0 R /Info {} 0 R >>\nstartxref\n{table}\n%%EOF\n", n - 1);
        self.bytes.extend(out.bytes());
        self.bytes
    }
}

/// A text as a string of UTF-16.
fn text(words: &str) -> String {
    let mut out = String::from("<FEFF");
    for unit in words.encode_utf16() {
        let _ = write!(out, "{unit:04X}");
    }
    out + ">"
}

/// Draws the group `of` on `page`; `around` is the transformation of the surrounding group to the
/// page.
fn group(page: &mut String, of: &Group, around: Transform) -> Result<(), PlotError> {
    let to_page = around.pre_concat(of.transform());
    let is_plain = of.opacity() == Opacity::ONE
        && of.clip_path().is_none()
        && of.mask().is_none()
        && of.filters().is_empty();
    if !is_plain {
        return Err(unsupported("transparency, clipping or filters"));
    }
    for node in of.children() {
        match node {
            Node::Group(inner) => group(page, inner, to_page)?,
            Node::Path(shape) if shape.is_visible() => path(page, shape, to_page)?,
            Node::Path(_) => {}
            Node::Text(words) => group(page, words.flattened(), to_page)?,
            Node::Image(_) => return Err(unsupported("a picture")),
        }
    }
    Ok(())
}

fn path(page: &mut String, shape: &Path, to_page: Transform) -> Result<(), PlotError> {
    let t = to_page;
    let entries = [t.sx, t.ky, t.kx, t.sy, t.tx, t.ty].map(number).join(" ");
    *page += &format!("q {entries} cm\n");
    if let Some(fill) = shape.fill() {
        *page += &format!("{} rg\n", colour(fill.paint(), fill.opacity())?);
    }
    if let Some(line) = shape.stroke() {
        stroke(page, line)?;
    }
    segments(page, shape);
    *page += match (shape.fill().map(|f| f.rule()), shape.stroke()) {
        (None, None) => "n",
        (None, Some(_)) => "S",
        (Some(FillRule::NonZero), None) => "f",
        (Some(FillRule::EvenOdd), None) => "f*",
        (Some(FillRule::NonZero), Some(_)) => "B",
        (Some(FillRule::EvenOdd), Some(_)) => "B*",
    };
    *page += " Q\n";
    Ok(())
}

fn stroke(page: &mut String, line: &Stroke) -> Result<(), PlotError> {
    let cap = match line.linecap() {
        LineCap::Butt => 0,
        LineCap::Round => 1,
        LineCap::Square => 2,
    };
    let join = match line.linejoin() {
        LineJoin::Miter | LineJoin::MiterClip => 0,
        LineJoin::Round => 1,
        LineJoin::Bevel => 2,
    };
    let dashes = line.dasharray().unwrap_or_default().iter().map(|d| number(*d));
    let dashes = dashes.collect::<Vec<_>>().join(" ");
    *page += &format!(
        "{} RG {} w {cap} J {join} j {} M [{dashes}] {} d\n",
        colour(line.paint(), line.opacity())?,
        number(line.width().get()),
        number(line.miterlimit().get()),
        number(line.dashoffset()),
    );
    Ok(())
}

fn segments(page: &mut String, shape: &Path) {
    let at = |p: Point| format!("{} {}", number(p.x), number(p.y));
    let mut last = Point::default();
    for segment in shape.data().segments() {
        match segment {
            PathSegment::MoveTo(p) => {
                *page += &format!("{} m\n", at(p));
                last = p;
            }
            PathSegment::LineTo(p) => {
                *page += &format!("{} l\n", at(p));
                last = p;
            }
            PathSegment::QuadTo(c, p) => {
                // The same parabola as a cubic curve: two thirds of the way to its control point.
                let near = |end: Point| {
                    Point::from_xy(end.x + 2.0 / 3.0 * (c.x - end.x), end.y + 2.0 / 3.0 * (c.y - end.y))
                };
                *page += &format!("{} {} {} c\n", at(near(last)), at(near(p)), at(p));
                last = p;
            }
            PathSegment::CubicTo(a, b, p) => {
                *page += &format!("{} {} {} c\n", at(a), at(b), at(p));
                last = p;
            }
            PathSegment::Close => *page += "h\n",
        }
    }
}

fn colour(paint: &Paint, opacity: Opacity) -> Result<String, PlotError> {
    match paint {
        Paint::Color(c) if opacity == Opacity::ONE => {
            Ok([c.red, c.green, c.blue].map(|part| number(f32::from(part) / 255.0)).join(" "))
        }
        Paint::Color(_) => Err(unsupported("transparency")),
        _ => Err(unsupported("gradients or patterns")),
    }
}

fn unsupported(what: &str) -> PlotError {
    PlotError::Convert(format!("the drawing has {what}, which are not written to PDF"))
}

/// A number without exponent, which PDF does not know, to seven digits or a millionth.
fn number(value: f32) -> String {
    let decimals = if value.abs() >= 100.0 { 3 } else { 6 };
    let digits = format!("{value:.decimals$}");
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if digits == "-0" { "0".into() } else { digits.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    const DRAWN: &str = "<svg width=\"200\" height=\"100\" viewBox=\"0 0 2000 1000\" xmlns=\"http://www.w3.org/2000/svg\">\
        <rect x=\"0\" y=\"0\" width=\"2000\" height=\"1000\" fill=\"#FFFFFF\" stroke=\"none\"/>\
        <polyline fill=\"none\" opacity=\"1\" stroke=\"#D55E00\" stroke-width=\"16\" stroke-dasharray=\"70 30\" points=\"0,0 2000,1000\"/>\
        <text x=\"100\" y=\"500\" font-size=\"120\" font-family=\"DejaVu Sans\">x⁻¹</text></svg>";

    fn find(bytes: &[u8], what: &[u8]) -> usize {
        bytes.windows(what.len()).position(|w| w == what).expect("is there")
    }

    fn page(file: &[u8]) -> String {
        let (from, to) = (find(file, b"stream\n") + 7, find(file, b"\nendstream"));
        String::from_utf8(decompress_to_vec_zlib(&file[from..to]).expect("zlib")).expect("text")
    }

    #[test]
    fn every_object_is_where_the_table_says() {
        let file = pdf(DRAWN, "a title: ü").expect("a PDF");
        let end = find(&file, b"startxref\n");
        let tail = String::from_utf8_lossy(&file[end..]);
        let table: usize = tail.lines().nth(1).expect("a line").parse().expect("a number");
        assert_eq!(&file[table..table + 5], b"xref\n");
        let rows = String::from_utf8_lossy(&file[table..end]);
        let offsets: Vec<usize> = rows
            .lines()
            .filter(|row| row.ends_with("00000 n "))
            .map(|row| row[..10].parse().expect("a number"))
            .collect();
        assert_eq!(offsets.len(), 5);
        for (k, offset) in offsets.into_iter().enumerate() {
            assert!(file[offset..].starts_with(format!("{} 0 obj\n", k + 1).as_bytes()));
        }
        // 200 x 100 pixels of 1/96 inch; every row of the table has 20 bytes.
        find(&file, b"/MediaBox [0 0 150 75]");
        find(&file, b"/Title <FEFF00610020007400690074006C0065003A002000FC>");
    }

    #[test]
    fn lines_keep_place_width_colour_and_dashes() {
        let page = page(&pdf(DRAWN, "").expect("a PDF"));
        // A unit of the drawing is a tenth of a pixel; the upper left corner is 75 points above the
        // lower one.
        assert!(page.contains("q 0.075 0 0 -0.075 0 75 cm\n0.835294 0.368627 0 RG 16 w 0 J 0 j 4 M [70 30] 0 d\n0 0 m\n2000 1000 l\nS Q"), "{page}");
        assert!(page.contains("1 1 1 rg\n"));
    }

    /// Where outlines begin on the page, in points, of shapes filled in black.
    fn beginnings(page: &str) -> Vec<(f64, f64)> {
        let numbers = |text: &str| -> Vec<f64> { text.split(' ').filter_map(|x| x.parse().ok()).collect() };
        let mut found = Vec::new();
        for part in page.split("q ").filter(|part| part.contains("0 0 0 rg")) {
            let t = numbers(part.split(" cm").next().expect("a transform"));
            for line in part.lines().filter(|line| line.ends_with(" m")) {
                let at = numbers(line);
                found.push((t[0] * at[0] + t[2] * at[1] + t[4], t[1] * at[0] + t[3] * at[1] + t[5]));
            }
        }
        found
    }

    #[test]
    fn words_are_outlines_where_they_stand() {
        let page = page(&pdf(DRAWN, "").expect("a PDF"));
        let found = beginnings(&page);
        // Three glyphs; text of 9 points, with its left end at 7.5 points and its foot half way up
        // the page.
        assert!(found.len() >= 3, "{page}");
        assert!(
            found.iter().all(|(x, y)| (7.5..7.5 + 3.0 * 9.0).contains(x) && (37.5..37.5 + 9.0).contains(y)),
            "{found:?}"
        );
        let first = found.iter().map(|(x, _)| *x).fold(f64::INFINITY, f64::min);
        assert!(first < 7.5 + 9.0, "{found:?}");
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let half = DRAWN.replace("opacity=\"1\"", "opacity=\"0.5\"");
        let error = pdf(&half, "").expect_err("half a line").to_string();
        assert!(error.contains("transparency"), "{error}");
    }

    #[test]
    fn numbers_have_no_exponent() {
        for (value, wanted) in
            [(0.0, "0"), (-1e-9, "0"), (0.075, "0.075"), (1_234.567_8, "1234.568"), (-2.5e-5, "-0.000025")]
        {
            assert_eq!(number(value), wanted);
        }
    }
}
