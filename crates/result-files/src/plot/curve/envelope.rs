//! A curve that rings faster than a picture can show, as its bounds: drawn as a line it is a blot,
//! and dashes say nothing.

/// A point of a curve.
type Point = (f64, f64);

/// Turns of a curve in a pixel from which it rings: more are seen as a blot.
const TURNS: usize = 3;
/// Height of a swing in pixels that is seen; of less the curve is a line.
const SEEN: f64 = 2.0;
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

/// The parts of `curve`, a pixel being `width` wide and `height` high: they meet. A curve whose
/// abscissa falls somewhere is one line.
pub fn pieces(curve: &[Point], (width, height): (f64, f64)) -> Vec<Piece> {
    let rises = curve.windows(2).all(|w| w[0].0 <= w[1].0);
    let [first, .., _] = curve else { return vec![Piece::Line(curve.to_vec())] };
    if !rises || width.is_nan() || width <= 0.0 {
        return vec![Piece::Line(curve.to_vec())];
    }
    let pixels = pixels(curve, first.0, (width, height));
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
        // From the first point to the last, where lines before and behind end.
        let ends = [run[0].points.start, run[run.len() - 1].points.end - 1].map(|i| curve[i]);
        let between = |bound: Vec<Point>| [&[ends[0]], &bound[..], &[ends[1]]].concat();
        let (low, high) = (between(bound(f64::min)), between(bound(f64::max)));
        if !line.is_empty() {
            line.push(ends[0]);
            found.push(Piece::Line(std::mem::take(&mut line)));
        }
        found.push(Piece::Band { low, high });
        line.push(ends[1]);
    }
    if line.len() > 1 {
        found.push(Piece::Line(line));
    }
    found
}

fn pixels(curve: &[Point], from: f64, (width, height): (f64, f64)) -> Vec<Pixel> {
    let number = |p: &Point| ((p.0 - from) / width) as usize;
    let mut start = 0;
    let mut pixels = Vec::new();
    for points in curve.chunk_by(|a, b| number(a) == number(b)) {
        let end = start + points.len();
        let steps = points.windows(2).map(|w| w[1].1 - w[0].1).filter(|step| *step != 0.0);
        let steps: Vec<f64> = steps.collect();
        let turns = steps.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.1), b.max(p.1)));
        let is_ringing = turns >= TURNS && high - low > SEEN * height;
        pixels.push(Pixel { number: number(&points[0]), points: start..end, is_ringing });
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
            assert_eq!(pieces(&curve, (1e-2, 1e-3)), [Piece::Line(curve.clone())]);
        }
        let back = [(1.0, 0.0), (0.0, 1.0), (1.0, 2.0)];
        assert_eq!(pieces(&back, (1e-2, 1e-3)), [Piece::Line(back.to_vec())]);
        assert_eq!(pieces(&back[..1], (1e-2, 1e-3)), [Piece::Line(back[..1].to_vec())]);
    }

    #[test]
    fn what_rings_in_every_pixel_is_a_band_between_its_bounds() {
        let found = pieces(&curve(1000.0), (1e-2, 1e-3));
        let [Piece::Band { low, high }] = &found[..] else { panic!("{} pieces", found.len()) };
        assert_eq!((low.len(), high.len()), (102, 102));
        // Ten periods a pixel reach the amplitude at its middle to half a pixel; both bounds begin
        // and end with the curve.
        assert!(
            low.iter()
                .zip(high)
                .skip(1)
                .take(100)
                .all(|(l, h)| (h.1 - h.0).abs() < 1e-2 && (l.1 + l.0).abs() < 1e-2)
        );
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
        let found = pieces(&all, (1e-2, 1e-3));
        let [Piece::Line(before), Piece::Band { low, high }, Piece::Line(behind)] = &found[..] else {
            panic!("{} pieces", found.len())
        };
        // They meet.
        assert!([low[0], high[0]].iter().all(|p| before.last() == Some(p)));
        assert!([low.last(), high.last()].iter().all(|p| *p == behind.first()));
    }

    #[test]
    fn swings_that_nobody_sees_are_a_line() {
        let curve = curve(1000.0);
        assert_eq!(pieces(&curve, (1e-2, 1.0)), [Piece::Line(curve.clone())]);
    }
}
