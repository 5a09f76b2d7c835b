//! Which points are asked for.

use std::str::FromStr;

use adaptive::model::RunModel;
use adaptive::simulation::ObservedPoint;

use crate::error::{AppError, CommandFault};
use crate::scenario::FileBody;
use crate::scenario::body_places::GivenPlace;

/// Coordinates of a point in the components of a body's model, as given: `X,Y,Z`, `X,Y` or `R,Z` \[m\].
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

/// A point that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum WantedPoint {
    /// By coordinates.
    At(Coordinates),
    /// By the name of a marker.
    Marker(String),
}

impl WantedPoint {
    /// What tables call it.
    pub fn label(&self) -> String {
        match self {
            Self::At(at) => at.text.split(',').map(str::trim).collect::<Vec<_>>().join(" "),
            Self::Marker(name) => name.clone(),
        }
    }

    fn fault(&self, reason: impl ToString) -> AppError {
        let (option, given) = match self {
            Self::At(at) => ("--point", at.text.clone()),
            Self::Marker(name) => ("--marker", name.clone()),
        };
        CommandFault::Place { option, given, reason: reason.to_string() }.into()
    }

    /// The point on body `number` of `model`, which `body` has the places of, with strain and stress if the body has any there.
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
            Self::At(Coordinates { values, .. }) => {
                let n = form.data.motion.n_components();
                if values.len() != n {
                    return Err(self.fault(format!("points of body \"{}\" have {n} coordinates", body.name)));
                }
                GivenPlace::Point(std::array::from_fn(|c| values.get(c).copied().unwrap_or(0.0)))
            }
        };
        let place = body.places.observed(&given).map_err(|e| self.fault(e))?;
        let point = form.point(&place).map_err(|e| self.fault(e))?;
        // What has no elements or is an area has a motion alone.
        let gauge =
            if form.has_gauge(&place) { Some(form.gauge(&place).map_err(|e| self.fault(e))?) } else { None };
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
        for text in ["", "1", "1,2,3,4", "a,b", "1,nan", "1,inf", "1;2"] {
            assert!(text.parse::<Coordinates>().is_err(), "{text}");
        }
    }
}
