//! What the quasistatic displacement of contact zones adds to the motion of observed points (docs/theory.md Eqs. A.33, A.34).
//!
//! The residual flexibility is symmetric: one static problem for each direction of a point gives the displacement of the point by
//! the forces at all interface unknowns. With these rows at hand an instant costs one dot product.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::ResidualFlexibility;
use nalgebra::Vector3;

use contact_qs::points::DofLookup;

use crate::adaptive_contact::FineContact;
use crate::elastic_body::Discretised;
use crate::error::AdaptiveError;
use crate::record::PointSample;
use crate::simulation::{ObservedPoint, System};

/// Steps shorter than this part of the one before tell no velocity: round-off of the solver over a short time.
const SHORTEST_STEP: f64 = 0.05;

/// Displacement of an observed point by forces at the unknowns of an interface.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCompliance {
    /// Number of the point among those observed.
    pub point: usize,
    /// Index of the body.
    pub body: usize,
    /// Displacement in the body's frame by a unit of each force [m/N].
    pub rows: Vec<Vector3<f64>>,
}

/// Functions that are not zero at a point, with their values.
pub type Functions = Vec<(u32, f64)>;

/// Displacements of points, which `functions` belong to, by unit forces at the interface of `residual`: a row an unknown of the
/// interface, the components of one point after those of the other [m/N].
pub fn point_rows(
    functions: &[Functions],
    lookup: &DofLookup,
    motion: RigidMotion,
    residual: &ResidualFlexibility,
) -> Mat<f64> {
    let (n, interface) = (motion.n_components(), residual.interface());
    if functions.is_empty() {
        return Mat::zeros(interface.len(), 0);
    }
    let mut x = Mat::zeros(residual.n_unknowns(), n * functions.len());
    for (k, functions) in functions.iter().enumerate() {
        for c in 0..n {
            for &(node, value) in functions {
                if let Some(unknown) = lookup.number(node, c) {
                    x[(unknown, n * k + c)] += value;
                }
            }
        }
    }
    residual.apply(x.as_mut());
    Mat::from_fn(interface.len(), x.ncols(), |b, j| x[(interface[b], j)])
}

/// The rows of [`point_rows`] for `points`, which lie on `body`.
pub fn compliances(
    points: &[usize],
    body: usize,
    motion: RigidMotion,
    rows: &Mat<f64>,
) -> Vec<PointCompliance> {
    let n = motion.n_components();
    let row = |k: usize, b: usize| {
        let mut u = Vector3::zeros();
        (0..n).for_each(|c| u[motion.direction(c)] = rows[(b, n * k + c)]);
        u
    };
    let of = |(k, &point): (usize, &usize)| {
        let rows = (0..rows.nrows()).map(|b| row(k, b)).collect();
        PointCompliance { point, body, rows }
    };
    points.iter().enumerate().map(of).collect()
}

/// The points of `all` on `body`: their numbers, and their places in the components of a model with the motions `motion`.
pub fn points_on(all: &[ObservedPoint], body: usize, motion: RigidMotion) -> (Vec<usize>, Vec<[f64; 3]>) {
    let place = |p: &ObservedPoint| {
        let mut place = [0.0; 3];
        (0..motion.n_components()).for_each(|c| place[c] = p.point.position[motion.direction(c)]);
        place
    };
    let on_body = all.iter().enumerate().filter(|(_, p)| p.body == body);
    on_body.map(|(i, p)| (i, place(p))).unzip()
}

/// Compliances of the points of `all` on `body`, whose interface has the flexibility `residual` for the whole run.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if a point is not in the body.
pub fn of_body(
    all: &[ObservedPoint],
    body: usize,
    model: &Discretised<'_>,
    residual: &ResidualFlexibility,
) -> Result<Vec<PointCompliance>, AdaptiveError> {
    let motion = model.assembled.motion;
    let (points, places) = points_on(all, body, motion);
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let functions = |place: &[f64; 3]| {
        let (e, xi) = model.locate(place)?;
        Ok(model.functions_at(e, &xi))
    };
    let functions: Vec<Functions> = places.iter().map(functions).collect::<Result<_, AdaptiveError>>()?;
    Ok(compliances(&points, body, motion, &point_rows(&functions, model.lookup, motion, residual)))
}

/// Dents of the observed points, with what tells their velocities.
#[derive(Debug, Clone, Default)]
pub struct Dents {
    /// Compliances at interfaces that bodies have for the whole run.
    lasting: Vec<PointCompliance>,
    /// Present displacements in the frames of the bodies \[m\].
    now: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    /// The two instants before, the later one first.
    earlier: [Instant; 2],
    n_earlier: usize,
    forces: Vec<f64>,
}

/// Displacements at a time.
#[derive(Debug, Clone, Default)]
struct Instant {
    time: f64,
    displacements: Vec<Vector3<f64>>,
}

impl Dents {
    /// Dents of points with the compliances `lasting` at interfaces that bodies have for the whole run.
    pub fn new(lasting: Vec<PointCompliance>) -> Self {
        Self { lasting, ..Self::default() }
    }

    /// Begins at time `t` without dents, as impact phases do: their contacts are open or just touch.
    pub fn begin(&mut self, t: f64, n_points: usize) {
        self.now.clear();
        self.now.resize(n_points, Vector3::zeros());
        self.velocities.clone_from(&self.now);
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.now);
        self.n_earlier = 1;
    }

    /// Goes on from the present dents, as after a change of the model at time `t`.
    pub fn go_on_from_present(&mut self, t: f64) {
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.now);
        self.n_earlier = 1;
    }

    /// Takes the forces of the last evaluation, at time `t`, of `system` with the models `fine` of its refined contacts.
    /// `loads_interface` tells of each contact whether it acts on a lasting interface.
    pub fn take(
        &mut self,
        t: f64,
        system: &System,
        fine: &[Option<FineContact>],
        loads_interface: impl Fn(usize) -> bool,
    ) {
        self.now.fill(Vector3::zeros());
        for (i, force) in system.forces().iter().enumerate() {
            let contact = &force.contact;
            if contact.report().n_active == 0 {
                continue;
            }
            let refined = fine.get(i).and_then(Option::as_ref).map_or(&[][..], |f| &f.points);
            let lasting = self.lasting.iter().filter(|p| loads_interface(i) && force.acts_on(p.body));
            let mut loaded = None;
            for p in refined.iter().chain(lasting) {
                if loaded != Some((p.body, p.rows.len())) {
                    self.forces.resize(p.rows.len(), 0.0);
                    contact.interface_force(p.body, &mut self.forces);
                    loaded = Some((p.body, p.rows.len()));
                }
                let dent = p.rows.iter().zip(&self.forces).fold(Vector3::zeros(), |u, (row, f)| u + row * *f);
                self.now[p.point] += dent;
            }
        }
        self.differentiate(t);
    }

    /// Velocities from the parabola through the present and the two instants before, from the chord if there is one.
    fn differentiate(&mut self, t: f64) {
        let [last, before] = &self.earlier;
        let step = t - last.time;
        let known = if self.n_earlier > 1 { last.time - before.time } else { 0.0 };
        if self.n_earlier == 0 || step <= SHORTEST_STEP * known {
            return;
        }
        for (i, velocity) in self.velocities.iter_mut().enumerate() {
            let chord = (self.now[i] - last.displacements[i]) / step;
            let turn = if known > 0.0 {
                let earlier = (last.displacements[i] - before.displacements[i]) / known;
                (chord - earlier) * (step / (step + known))
            } else {
                Vector3::zeros()
            };
            *velocity = chord + turn;
        }
        self.earlier.swap(0, 1);
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.now);
        self.n_earlier = (self.n_earlier + 1).min(2);
    }

    /// Adds the dents of `points` to what is recorded of them; the bodies are as `system` was evaluated last.
    pub fn add_to(&self, samples: &mut [PointSample], points: &[ObservedPoint], system: &System) {
        let states = system.last_evaluation().0;
        for ((sample, point), (u, rate)) in
            samples.iter_mut().zip(points).zip(self.now.iter().zip(&self.velocities))
        {
            let state = &states[point.body];
            let moved = state.rotation * u;
            let rate = state.rotation * (state.angular_velocity.cross(u) + rate);
            sample.position = (Vector3::from(sample.position) + moved).into();
            sample.velocity = (Vector3::from(sample.velocity) + rate).into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(times: &[f64], u: impl Fn(f64) -> f64) -> f64 {
        let mut dents = Dents::default();
        dents.begin(times[0], 1);
        dents.earlier[0].displacements[0].x = u(times[0]);
        for &t in &times[1..] {
            dents.now[0].x = u(t);
            dents.differentiate(t);
        }
        dents.velocities[0].x
    }

    #[test]
    fn velocity_of_a_parabola_is_exact_with_any_steps() {
        let found = after(&[0.0, 0.3, 0.45, 1.0], |t| 2.0 * t * t - t + 3.0);
        assert!((found - 3.0).abs() < 1e-14, "{found}"); // round-off
    }

    #[test]
    fn velocity_converges_with_the_square_of_the_step() {
        let error = |n: usize| {
            let times: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
            (after(&times, f64::sin) - 1.0_f64.cos()).abs()
        };
        let rate = (error(20) / error(40)).log2();
        assert!((rate - 2.0).abs() < 0.1, "{rate}"); // next term: a step of 1/20
    }

    #[test]
    fn a_tiny_step_does_not_make_velocity_of_noise() {
        let found = after(&[0.0, 1.0, 2.0, 2.0 + 1e-9], |t| if t > 2.0 { 2.1 } else { t });
        assert!((found - 1.0).abs() < 1e-15, "{found}");
    }
}
