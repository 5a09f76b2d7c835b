//! A curve that rings faster than a picture can show, as its bounds: drawn as a line it is a blot, and dashes say nothing.

/// A point of a curve.
type Point = (f64, f64);

/// Turns of a curve in a pixel from which it rings: more are seen as a blot.
const TURNS: usize = 3;
/// Pixels that ring on end; fewer are a few swings or a jump.
const LEAST: usize = 6;

/// A part of a curve.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// Drawn as a line.
    Line(Vec<Point>),
    /// Drawn as the band between its lower and its upper bound.
    Band {
        /// Lower bound.
        low: Vec<Point>,
        /// Upper bound.
        high: Vec<Point>,
    },
}

/// Points of one pixel.
struct Pixel {
    /// Number from the left.
    number: usize,
    points: std::ops::Range<usize>,
    is_ringing: bool,
}

/// The parts of `curve`, a pixel being `width` wide. A curve whose abscissa falls somewhere is one line.
pub fn pieces(curve: &[Point], width: f64) -> Vec<Piece> {
    let rises = curve.windows(2).all(|w| w[0].0 <= w[1].0);
    let [first, .., _] = curve else { return vec![Piece::Line(curve.to_vec())] };
    if !rises || width.is_nan() || width <= 0.0 {
        return vec![Piece::Line(curve.to_vec())];
    }
    let pixels = pixels(curve, first.0, width);
    let mut found: Vec<Piece> = Vec::new();
    let mut line: Vec<Point> = Vec::new();
    for run in pixels.chunk_by(|a, b| a.is_ringing && b.is_ringing && b.number == a.number + 1) {
        if run.len() < LEAST {
            line.extend(run.iter().flat_map(|pixel| &curve[pixel.points.clone()]));
            continue;
        }
        let bound = |pick: fn(f64, f64) -> f64| -> Vec<Point> {
            let of = |pixel: &Pixel| {
                let points = &curve[pixel.points.clone()];
                let x = 0.5 * (points[0].0 + points[points.len() - 1].0);
                (x, points.iter().map(|p| p.1).fold(points[0].1, pick))
            };
            run.iter().map(of).collect()
        };
        let (low, high) = (bound(f64::min), bound(f64::max));
        if !line.is_empty() {
            found.push(Piece::Line(std::mem::take(&mut line)));
        }
        found.push(Piece::Band { low, high });
    }
    if !line.is_empty() {
        found.push(Piece::Line(line));
    }
    found
}

fn pixels(curve: &[Point], from: f64, width: f64) -> Vec<Pixel> {
    let number = |p: &Point| ((p.0 - from) / width) as usize;
    let mut start = 0;
    let mut pixels = Vec::new();
    for points in curve.chunk_by(|a, b| number(a) == number(b)) {
        let end = start + points.len();
        let steps = points.windows(2).map(|w| w[1].1 - w[0].1).filter(|step| *step != 0.0);
        let steps: Vec<f64> = steps.collect();
        let turns = steps.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
        pixels.push(Pixel { number: number(&points[0]), points: start..end, is_ringing: turns >= TURNS });
        start = end;
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(periods: f64) -> Vec<Point> {
        let n = 20_000;
        (0..n)
            .map(|i| f64::from(i) / f64::from(n))
            .map(|x| (x, x * (std::f64::consts::TAU * periods * x).sin()))
            .collect()
    }

    #[test]
    fn what_a_picture_shows_stays_a_line() {
        for periods in [1.0, 50.0] {
            let curve = curve(periods);
            assert_eq!(pieces(&curve, 1e-2), [Piece::Line(curve.clone())]);
        }
        let back = [(1.0, 0.0), (0.0, 1.0), (1.0, 2.0)];
        assert_eq!(pieces(&back, 1e-2), [Piece::Line(back.to_vec())]);
        assert_eq!(pieces(&back[..1], 1e-2), [Piece::Line(back[..1].to_vec())]);
    }

    #[test]
    fn what_rings_in_every_pixel_is_a_band_between_its_bounds() {
        let found = pieces(&curve(1000.0), 1e-2);
        let [Piece::Band { low, high }] = &found[..] else { panic!("{} pieces", found.len()) };
        assert_eq!((low.len(), high.len()), (100, 100));
        // Ten periods a pixel reach the amplitude at its middle to half a pixel.
        assert!(low.iter().zip(high).all(|(l, h)| (h.1 - h.0).abs() < 1e-2 && (l.1 + l.0).abs() < 1e-2));
    }

    #[test]
    fn a_band_is_between_lines() {
        let rest = |x: f64| (x, 0.0);
        let ringing = curve(1000.0).into_iter().map(|(x, y)| (1.0 + x, y));
        let all: Vec<Point> = (0..100)
            .map(|i| rest(f64::from(i) / 100.0))
            .chain(ringing)
            .chain([rest(2.5), rest(3.0)])
            .collect();
        let found = pieces(&all, 1e-2);
        assert!(
            matches!(&found[..], [Piece::Line(_), Piece::Band { .. }, Piece::Line(_)]),
            "{}",
            found.len()
        );
    }
}
