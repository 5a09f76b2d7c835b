//! Displacement, strain and stress at observed points by the forces on an interface (docs/theory.md
//! Eqs. Q.5, Q.8).

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::ResidualFlexibility;
use iga_core::elasticity::kinematics::PointState;
use nalgebra::Vector3;

use crate::body::field::Field;
use crate::body::gauge::{self, Gauge};
use crate::error::AdaptiveError;
use crate::state::simulation::ObservedPoint;
use crate::store::Bytes;

/// Displacement of an observed point by forces at the unknowns of an interface.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCompliance {
    /// Number of the point among those observed.
    pub point: usize,
    /// Index of the body.
    pub body: usize,
    /// Displacement in the body's frame by a unit of each force [m/N].
    pub rows: Vec<Vector3<f64>>,
    /// Strain and stress by a unit of each force; empty where they are not observed.
    pub states: Vec<PointState>,
}

/// An observed place of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedPlace {
    /// The point, in the components of the body's model \[m\].
    pub place: [f64; 3],
    /// Whether strain and stress are observed, too.
    pub has_gauge: bool,
}

/// Adds to the `key` of a compliance the `unknowns` of its interface and the places that it belongs
/// to.
pub fn add_places(key: &mut Bytes, unknowns: &[usize], places: &[ObservedPlace]) {
    let points: Vec<[f64; 3]> = places.iter().map(|place| place.place).collect();
    key.add(&(unknowns, points));
    let gauges: Vec<bool> = places.iter().map(|place| place.has_gauge).collect();
    // Without gauges the key is that of models stored before there were any.
    if gauges.contains(&true) {
        key.add(&gauges);
    }
}

/// Displacement, strain and stress at an observed place as linear functions of the unknowns of a
/// field.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlaceFunctions {
    /// Its displacement.
    pub functions: Vec<(u32, f64)>,
    /// Strain and stress, if they are observed.
    pub gauge: Option<Gauge>,
}

impl PlaceFunctions {
    /// The functions of `place` on the unknowns of `field`.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn new(place: &ObservedPlace, field: &dyn Field) -> Result<Self, AdaptiveError> {
        let gauge = if place.has_gauge { Some(field.gauge_at(&place.place)?) } else { None };
        Ok(Self { functions: field.functions_at(&place.place)?, gauge })
    }

    /// Columns of it in [`point_rows`].
    fn n_columns(&self, n_components: usize) -> usize {
        n_components + if self.gauge.is_some() { gauge::N_NUMBERS } else { 0 }
    }
}

/// Number of columns of [`point_rows`] for `places` of a body with so many components of
/// displacement.
pub fn n_columns(places: &[ObservedPlace], n_components: usize) -> usize {
    let of = |place: &ObservedPlace| n_components + if place.has_gauge { gauge::N_NUMBERS } else { 0 };
    places.iter().map(of).sum()
}

/// What places of `field`, which `places` belong to, show of unit forces at the interface of
/// `residual`: a row per unknown of the interface, the components of the displacement [m/N] of a
/// place and, with a gauge, the numbers of its state after those of the place before.
pub fn point_rows(places: &[PlaceFunctions], field: &dyn Field, residual: &ResidualFlexibility) -> Mat<f64> {
    let (n, lookup, interface) = (field.motion().n_components(), field.lookup(), residual.interface());
    let n_columns = places.iter().map(|place| place.n_columns(n)).sum();
    if n_columns == 0 {
        return Mat::zeros(interface.len(), 0);
    }
    let mut x = Mat::zeros(residual.n_unknowns(), n_columns);
    let mut first = 0;
    for place in places {
        for c in 0..n {
            for &(node, value) in &place.functions {
                if let Some(unknown) = lookup.number(node, c) {
                    x[(unknown, first + c)] += value;
                }
            }
        }
        if let Some(gauge) = &place.gauge {
            gauge.add_weights(lookup, x.as_mut().subcols_mut(first + n, gauge::N_NUMBERS));
        }
        first += place.n_columns(n);
    }
    residual.apply(x.as_mut());
    Mat::from_fn(interface.len(), x.ncols(), |b, j| x[(interface[b], j)])
}

/// The rows of [`point_rows`] for `points`, which lie on `body` at `places`.
pub fn compliances(
    points: &[usize],
    places: &[ObservedPlace],
    body: usize,
    motion: RigidMotion,
    rows: &Mat<f64>,
) -> Vec<PointCompliance> {
    let n = motion.n_components();
    let mut first = 0;
    let mut all = Vec::with_capacity(points.len());
    for (&point, place) in points.iter().zip(places) {
        let row = |b: usize| {
            let mut u = Vector3::zeros();
            (0..n).for_each(|c| u[motion.direction(c)] = rows[(b, first + c)]);
            u
        };
        let state = |b: usize| gauge::state(rows, b, first + n);
        let states = if place.has_gauge { (0..rows.nrows()).map(state).collect() } else { Vec::new() };
        all.push(PointCompliance { point, body, rows: (0..rows.nrows()).map(row).collect(), states });
        first += n_columns(std::slice::from_ref(place), n);
    }
    all
}

/// The points of `all` on `body`: their numbers, and their places in the components of a model with
/// the motions `motion`.
pub fn points_on(
    all: &[ObservedPoint],
    body: usize,
    motion: RigidMotion,
) -> (Vec<usize>, Vec<ObservedPlace>) {
    let place = |p: &ObservedPoint| ObservedPlace {
        place: motion.components(p.point.position.as_ref()),
        has_gauge: p.gauge.is_some(),
    };
    let on_body = all.iter().enumerate().filter(|(_, p)| p.body == body);
    on_body.map(|(i, p)| (i, place(p))).unzip()
}

/// Compliances of the points of `all` on a body, its number and field given, of which an interface
/// has the flexibility `residual`.
///
/// # Errors
/// [`AdaptiveError`] if a point is not in the body.
pub fn of_body(
    all: &[ObservedPoint],
    (body, field): (usize, &dyn Field),
    residual: &ResidualFlexibility,
) -> Result<Vec<PointCompliance>, AdaptiveError> {
    let motion = field.motion();
    let (points, places) = points_on(all, body, motion);
    let shown = places.iter().map(|place| PlaceFunctions::new(place, field));
    let shown: Vec<PlaceFunctions> = shown.collect::<Result<_, AdaptiveError>>()?;
    Ok(compliances(&points, &places, body, motion, &point_rows(&shown, field, residual)))
}
