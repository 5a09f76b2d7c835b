//! Axes in which coordinates of nodes stand: `*SYSTEM`, and the kind of coordinates of `*NODE`.

use super::super::text::{expected, real, refuse};
use super::card::Card;
use crate::element::jacobian::{cross, dot, minus, norm};
use crate::fault::MeshError;

/// Share of the length of an axis by which it may lean out of a plane: digits of a file.
const LEANING: f64 = 1e-6;

/// The axes of the nodes that are read.
#[derive(Debug, Default)]
pub struct Axes {
    /// Line of the card whose data are read.
    line: usize,
    /// Data of the last `*SYSTEM`, as far as there are any: an origin, a point on the first axis,
    /// one on the side of the second.
    given: Vec<[Option<f64>; 3]>,
    /// Origin and axes that follow from it; none once there are new data.
    frame: Option<([f64; 3], [[f64; 3]; 3])>,
    /// Whether coordinates are a radius, an angle in degrees and a height.
    is_cylindrical: bool,
}

impl Axes {
    /// A `*SYSTEM`: without data the axes of the file.
    pub fn begin(&mut self, line: usize) {
        (self.line, self.frame) = (line, None);
        self.given.clear();
    }

    /// A line of data of `*SYSTEM`.
    pub fn data(&mut self, line: usize, text: &str) -> Result<(), MeshError> {
        let mut values = Vec::new();
        for field in text.split(',').map(str::trim) {
            values.push(match (field, real(field)) {
                ("", _) => None,
                (_, Some(x)) if x.is_finite() => Some(x),
                _ => return expected(line, "a coordinate", field),
            });
        }
        for part in values.chunks(3) {
            let mut point = [None; 3];
            point[..part.len()].copy_from_slice(part);
            // Empty fields at the end of a line are no point.
            if self.given.is_empty() || point.iter().any(Option::is_some) {
                self.given.push(point);
            }
        }
        self.frame = None;
        Ok(())
    }

    /// A `*NODE`: what its coordinates are.
    pub fn of_nodes(&mut self, card: &Card) -> Result<(), MeshError> {
        let system = card.get("SYSTEM").unwrap_or("R").to_ascii_uppercase();
        self.is_cylindrical = match system.as_str() {
            "" | "R" => false,
            "C" => true,
            _ => {
                let what = format!("*NODE, SYSTEM={system}");
                return refuse(card.line, &what, "write rectangular (R) or cylindrical (C) coordinates");
            }
        };
        Ok(())
    }

    /// The place of a node with the coordinates `x`.
    pub fn place(&mut self, line: usize, x: [f64; 3]) -> Result<[f64; 3], MeshError> {
        let x = if self.is_cylindrical {
            let (sine, cosine) = x[1].to_radians().sin_cos();
            [x[0] * cosine, x[0] * sine, x[2]]
        } else {
            x
        };
        if self.given.is_empty() {
            return Ok(x);
        }
        let (origin, axes) = match self.frame {
            Some(frame) => frame,
            None => self.frame(line)?,
        };
        self.frame = Some((origin, axes));
        Ok(std::array::from_fn(|c| origin[c] + (0..3).map(|a| x[a] * axes[a][c]).sum::<f64>()))
    }

    /// Origin and axes of the last `*SYSTEM`.
    fn frame(&self, line: usize) -> Result<([f64; 3], [[f64; 3]; 3]), MeshError> {
        let point = |i: usize| self.given.get(i).map(|p| p.map(|x| x.unwrap_or(0.0)));
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let Some(origin) = point(0) else { return Ok(([0.0; 3], [x, y, z])) };
        let Some(on_first) = point(1) else { return Ok((origin, [x, y, z])) };
        let along = minus(&on_first, &origin);
        let line = if self.line > 0 { self.line } else { line };
        let refuse = |what: &str, remedy| refuse(line, &format!("a *SYSTEM {what}"), remedy);
        if norm(&along) == 0.0 {
            return refuse("without a direction", "give a second point away from the first one");
        }
        let first = along.map(|c| c / norm(&along));
        let up = match point(2) {
            Some(beside) => cross(&first, &minus(&beside, &origin)),
            None if first[2].abs() <= LEANING => cross(&first, &cross(&z, &first)),
            None => {
                let remedy = "give a third point, which lies on the side of the second axis";
                return refuse("of two points that does not turn about z", remedy);
            }
        };
        if norm(&up) == 0.0 {
            return refuse("whose points lie on a line", "give a third point beside the first axis");
        }
        let third = up.map(|c| c / norm(&up));
        Ok((origin, [first, cross(&third, &first), third]))
    }
}

/// How an instance of a part is moved: first along a vector, then turned about an axis.
#[derive(Debug, Clone, Default)]
pub struct Movement {
    along: [f64; 3],
    /// Two points on the axis, and the angle in degrees.
    turn: Option<[f64; 7]>,
    lines: usize,
}

impl Movement {
    /// A line of data of `*INSTANCE`.
    pub fn data(&mut self, line: usize, text: &str) -> Result<(), MeshError> {
        let mut values = [0.0; 7];
        for (value, field) in values.iter_mut().zip(text.split(',').map(str::trim)) {
            match real(field).or(field.is_empty().then_some(0.0)) {
                Some(x) if x.is_finite() => *value = x,
                _ => return expected(line, "a coordinate or an angle of an *INSTANCE", field),
            }
        }
        self.lines += 1;
        match self.lines {
            1 => self.along.copy_from_slice(&values[..3]),
            2 => {
                let [a, b] = [0, 3].map(|i| [values[i], values[i + 1], values[i + 2]]);
                if values[6] != 0.0 && norm(&minus(&b, &a)) == 0.0 {
                    return refuse(line, "an axis of two points that coincide", "give points that differ");
                }
                self.turn = (values[6] != 0.0).then_some(values);
            }
            _ => return refuse(line, "a third line of an *INSTANCE", "give a translation and a rotation"),
        }
        Ok(())
    }

    /// Moves points.
    pub fn apply(&self, points: &mut [[f64; 3]]) {
        for point in points {
            (0..3).for_each(|d| point[d] += self.along[d]);
            let Some([ax, ay, az, bx, by, bz, angle]) = self.turn else { continue };
            let (from, axis) = ([ax, ay, az], [bx - ax, by - ay, bz - az]);
            let axis = axis.map(|c| c / norm(&axis));
            let (sine, cosine) = angle.to_radians().sin_cos();
            // Rodrigues: v cos φ + (a × v) sin φ + a (a · v) (1 - cos φ).
            let arm = minus(point, &from);
            let (side, height) = (cross(&axis, &arm), dot(&axis, &arm) * (1.0 - cosine));
            *point = std::array::from_fn(|d| from[d] + arm[d] * cosine + side[d] * sine + axis[d] * height);
        }
    }
}
