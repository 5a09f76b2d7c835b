//! Which points are asked for.

use std::str::FromStr;

use adaptive::model::RunModel;
use adaptive::state::simulation::ObservedPoint;

use crate::error::{AppError, CommandFault, PlaceFault};
use crate::scenario::FileBody;
use crate::scenario::body_places::GivenPlace;

/// Coordinates of a point in the components of a body's model, as given: `X,Y,Z`, `X,Y` or `R,Z`
/// \[m\].
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    values: Vec<f64>,
    text: String,
}

impl FromStr for Coordinates {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let values: Result<Vec<f64>, _> = text.split(',').map(|x| x.trim().parse::<f64>()).collect();
        match values {
            Ok(values) if (2..=3).contains(&values.len()) && values.iter().all(|x| x.is_finite()) => {
                Ok(Self { values, text: text.to_owned() })
            }
            _ => Err("wanted are the coordinates in metres, in the components of the body's model: X,Y,Z, X,Y or R,Z".into()),
        }
    }
}

/// Points at equal distances along a straight line, ends included, as given: `X,Y,Z:X,Y,Z:N`.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    ends: [Coordinates; 2],
    n: usize,
}

/// What `--line` wants.
const LINE_WORDS: &str = "wanted is FROM:TO:N, two points in metres, in the components of the body's model, and the number of points, as in 0,0.01:0.5,0.01:11";
/// Points of a line at most.
const MOST: usize = 100_000;

impl FromStr for Line {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let &[from, to, n] = parts.as_slice() else { return Err(LINE_WORDS.into()) };
        let ends: [Coordinates; 2] = [from.parse()?, to.parse()?];
        let n = n.trim().parse().ok().filter(|n| (2..=MOST).contains(n)).ok_or(LINE_WORDS)?;
        if ends[0].values.len() != ends[1].values.len() {
            return Err(LINE_WORDS.into());
        }
        Ok(Self { ends, n })
    }
}

impl Line {
    /// Its points.
    pub fn points(&self) -> impl Iterator<Item = Coordinates> {
        let [from, to] = &self.ends;
        (0..self.n).map(move |k| {
            let share = k as f64 / (self.n - 1) as f64;
            let values: Vec<f64> =
                from.values.iter().zip(&to.values).map(|(a, b)| a * (1.0 - share) + b * share).collect();
            let text = values.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            Coordinates { values, text }
        })
    }
}

/// A point that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum WantedPoint {
    /// By coordinates.
    At(Coordinates),
    /// On a line that is asked for.
    On(Coordinates),
    /// By the name of a marker.
    Marker(String),
}

impl WantedPoint {
    /// What tables call it.
    pub fn label(&self) -> String {
        match self {
            Self::At(at) | Self::On(at) => at.text.split(',').map(str::trim).collect::<Vec<_>>().join(" "),
            Self::Marker(name) => name.clone(),
        }
    }

    fn fault(&self, fault: impl Into<PlaceFault>) -> AppError {
        let (option, given) = match self {
            Self::At(at) => ("--point", at.text.clone()),
            Self::On(at) => ("--line", at.text.clone()),
            Self::Marker(name) => ("--marker", name.clone()),
        };
        CommandFault::Place { option, given, fault: Box::new(fault.into()) }.into()
    }

    /// The point on body `number` of `model`, which `body` has the places of, with strain and
    /// stress if the body has any there.
    ///
    /// # Errors
    /// [`AppError::Command`] if there is no such place.
    pub fn observed(
        &self,
        body: &FileBody,
        (number, model): (usize, &RunModel),
    ) -> Result<ObservedPoint, AppError> {
        let form = &model.bodies[number];
        let given = match self {
            Self::Marker(name) => GivenPlace::Marker(name.clone()),
            Self::At(Coordinates { values, .. }) | Self::On(Coordinates { values, .. }) => {
                let n = form.data.motion.n_components();
                if values.len() != n {
                    return Err(self.fault(PlaceFault::Coordinates { body: body.name.clone(), expected: n }));
                }
                GivenPlace::Point(std::array::from_fn(|c| values.get(c).copied().unwrap_or(0.0)))
            }
        };
        let place = body.places.observed(&given).map_err(|e| self.fault(e))?;
        let point = form.point(&place).map_err(|e| self.fault(Box::new(e)))?;
        // What has no elements or is an area has a motion alone.
        let gauge = if form.has_gauge(&place) {
            Some(form.gauge(&place).map_err(|e| self.fault(Box::new(e)))?)
        } else {
            None
        };
        Ok(ObservedPoint { body: number, point, gauge })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_two_or_three_numbers() {
        let point: Coordinates = "0, 1e-3,-2".parse().expect("a point");
        assert_eq!(point.values, [0.0, 1e-3, -2.0]);
        assert_eq!(WantedPoint::At(point).label(), "0 1e-3 -2");
        let line: Line = "0,1:1,0:5".parse().expect("a line");
        let labels: Vec<String> = line.points().map(|at| WantedPoint::At(at).label()).collect();
        assert_eq!(labels, ["0 1", "0.25 0.75", "0.5 0.5", "0.75 0.25", "1 0"]);
        for text in ["0,1:1,0", "0,1:1,0,0:3", "0,1:1,0:1", "0,1:1,0:x", "0:1:3"] {
            assert!(text.parse::<Line>().is_err(), "{text}");
        }
        for text in ["", "1", "1,2,3,4", "a,b", "1,nan", "1,inf", "1;2"] {
            assert!(text.parse::<Coordinates>().is_err(), "{text}");
        }
    }
}
