//! Friction of a surface pair: tangents, slips, history of every point.
//!
//! The slip of a point is the path of its projection over the material of the target, from the
//! place where it stuck last (docs/theory.md Eqs. F.20 to F.22). It does not change when both
//! bodies move together, and forces along the tangents that belong to it keep both momenta and do
//! no work but on the slip. References stay within a step as in a plane contact
//! (docs/decisions/0005-friction.md).

use iga_core::nurbs::jet::{cross, difference, dot, norm};

use super::contact_jacobian::ContactJacobian;
use super::projection::{Displaced, Functions, Projection};
use super::relative_pose::RelativePose;
use crate::law::Friction;
use crate::quasistatic::PointState;
use crate::quasistatic::stick_slip::StickSlip;

/// What alternations leave of the error, so that a pass of projection and solution, which reduces it to a fiftieth to a third, is not held up
/// by them.
const PASS_GAIN: f64 = 0.003;
/// Evaluations within a step that its work of sliding is summed up over: as many as the explicit method has.
const NOTED: usize = 6;
/// Ratio of a way to all that was slid before it up to which the bound is a parabola over both: 1.7 at steady speed, between stages of the
/// explicit method; after less than that slips are what solutions err by.
const ALIKE: f64 = 4.0;
/// Loosest tolerance of the alternations between normal and friction forces, in units of the
/// tolerance of the gaps.
const FIRST_ALTERNATION_TOLERANCE: f64 = 1e2;

/// Stick reference of a point.
#[derive(Debug, Clone, Copy, Default)]
struct StickReference {
    /// Place of the projection when the references were last updated.
    point: [f64; 3],
    /// Tangents there, orthonormal but for gap over radius of curvature.
    tangents: [[f64; 3]; 2],
    /// Stretch of the tangential springs then \[m\].
    stretch: [f64; 2],
    is_set: bool,
    /// Whether `point` is a vector on the plane of a meeting point.
    is_on_plane: bool,
    /// Whether it was set since the references were last updated, by the first projection of the
    /// point.
    is_new: bool,
}

impl StickReference {
    /// Stands at `point`, with unstretched springs, unless it stands somewhere of that kind.
    fn stand(&mut self, point: [f64; 3], is_on_plane: bool, tangents: impl FnOnce() -> [[f64; 3]; 2]) {
        if !self.is_set || self.is_on_plane != is_on_plane {
            let (tangents, stretch) = (tangents(), [0.0; 2]);
            *self = Self { point, tangents, stretch, is_set: true, is_on_plane, is_new: true };
        }
    }
}

/// Friction of one pair. Components are ordered `n_t * point + component`.
pub(super) struct PairFriction {
    pub n_t: usize,
    pub stick_slip: StickSlip,
    /// Slips at the last projection \[m\].
    pub slips: Vec<f64>,
    /// Slips without quasistatic displacement, and the quasistatic displacements along the tangents
    /// that the solver counted with \[m\].
    pub free_slips: Vec<f64>,
    pub deflections: Vec<f64>,
    saved_deflections: Vec<f64>,
    /// Deepest penetration without quasistatic displacement in the last solution \[m\].
    pub depth: f64,
    saved_depth: f64,
    /// Change of the friction forces at which the last alternations between normal and friction
    /// forces have ended, as a share of the largest.
    pub alternation_tolerance: f64,
    references: Vec<StickReference>,
    /// Places on the target that the points stand over, which slips are measured by.
    places: Vec<[f64; 3]>,
    /// Tangents at the places of the last projection that make the tangents in use there
    /// orthonormal; they become those of the next references.
    next_tangents: Vec<[[f64; 3]; 2]>,
    /// Nodes of the target when the references were last updated.
    nodes: Vec<[f64; 3]>,
    has_nodes: bool,
    /// Whether there is an evaluation to take references from.
    pub is_evaluated: bool,
    /// Bounds of the points when the references were last updated \[N\].
    start_bounds: Vec<f64>,
    /// Times of the evaluations since then \[s\], and how far each point had slid and its bound, evaluation after evaluation [m, N].
    times: Vec<f64>,
    ways: Vec<[f64; 2]>,
}

impl PairFriction {
    pub fn new(
        law: Friction,
        (n_points, n_components): (usize, usize),
        n_nodes: usize,
        has_compliance: bool,
    ) -> Self {
        let n_t = n_components - 1;
        let n = n_t * n_points;
        Self {
            n_t,
            stick_slip: StickSlip::new(law, n_points, n_t, has_compliance),
            slips: vec![0.0; n],
            free_slips: vec![0.0; n],
            deflections: vec![0.0; n],
            saved_deflections: vec![0.0; n],
            depth: 0.0,
            saved_depth: 0.0,
            alternation_tolerance: 0.0,
            references: vec![StickReference::default(); n_points],
            places: vec![[0.0; 3]; n_points],
            next_tangents: vec![[[0.0; 3]; 2]; n_points],
            nodes: vec![[0.0; 3]; n_nodes],
            has_nodes: false,
            is_evaluated: false,
            start_bounds: vec![0.0; n_points],
            times: Vec::with_capacity(NOTED),
            ways: vec![[0.0; 2]; NOTED * n_points],
        }
    }

    /// To be called before the slips of a projection are set, with the nodes of the target at
    /// present.
    pub fn begin(&mut self, nodes: &[[f64; 3]]) {
        if !self.has_nodes {
            self.nodes.copy_from_slice(nodes);
            self.has_nodes = true;
        }
    }

    /// Tangents and slip of point `i`, at `point`, projected to `found` at gap `gap` (Eqs. F.20 to F.23).
    /// `functions` are those of the place found.
    pub fn set_slip(
        &mut self,
        i: usize,
        displaced: Displaced<'_>,
        (found, point, gap): (&Projection, &[f64; 3], f64),
        functions: &Functions,
        relative: &RelativePose,
        jacobian: &mut ContactJacobian,
    ) {
        let n_t = self.n_t;
        if found.is_beyond {
            self.clear_slip(i);
            return;
        }
        let jet = displaced.jet_of(found.element, functions);
        let before = Displaced { nodes: &self.nodes, ..displaced }.jet_of(found.element, functions);
        let duals = duals(&jet.tangents, n_t);
        let bend = |a: usize, b: usize| dot(&found.normal, &jet.second[if a == b { a } else { 2 }]);
        // Tangents of the surface through the point: that of the target moved along its normals by
        // the gap.
        let mut shifted = jet.tangents;
        for (a, tangent) in shifted.iter_mut().enumerate().take(n_t) {
            for (b, dual) in duals.iter().enumerate().take(n_t) {
                let factor = gap * bend(a, b);
                tangent.iter_mut().zip(dual).for_each(|(t, d)| *t -= factor * d);
            }
        }
        let moved = shifted;
        let shifted = self::duals(&moved, n_t);
        let aside = displaced.beside_end(found, point, gap);
        let here = [0, 1, 2].map(|c| before.point[c] + aside[c]);
        let reference = &mut self.references[i];
        reference.stand(here, false, || orthonormal(&jet.tangents, n_t));
        let path = difference(&here, &reference.point);
        self.places[i] = [0, 1, 2].map(|c| found.point[c] + aside[c]);
        for a in 0..n_t {
            let k = n_t * i + a;
            let unit = &reference.tangents[a];
            self.slips[k] = reference.stretch[a] + dot(unit, &path);
            let mut tangent = [0.0; 3];
            for (slope, dual) in before.tangents.iter().zip(&shifted).take(n_t) {
                let factor = dot(unit, slope);
                tangent.iter_mut().zip(dual).for_each(|(t, d)| *t += factor * d);
            }
            jacobian.tangents_in_target[k] = tangent;
            jacobian.tangents_in_body[k] = relative.inverse_transform_vector(&tangent);
            let normal_coupling = &mut jacobian.normal_coupling[k * jacobian.width..(k + 1) * jacobian.width];
            normal_coupling.fill(0.0);
            for (b, dual) in duals.iter().enumerate().take(n_t) {
                let factor = -gap * dot(&tangent, dual);
                normal_coupling
                    .iter_mut()
                    .zip(functions.slopes(b))
                    .for_each(|(l, slope)| *l += factor * slope);
            }
        }
        let mut tangents = [[0.0; 3]; 2];
        tangents[..n_t].copy_from_slice(&jacobian.tangents_in_target[n_t * i..n_t * (i + 1)]);
        let length = force_length(&tangents[..n_t], self.force(i));
        self.stick_slip.set_length(i, length);
        for (next, unit) in self.next_tangents[i].iter_mut().zip(orthonormal(&tangents, n_t)).take(n_t) {
            let components = [0, 1].map(|b| if b < n_t { dot(&unit, &moved[b]) } else { 0.0 });
            *next = combination(&duals, &components[..n_t]);
        }
    }

    /// Tangents and slip of point `i` on the plane of a meeting point, which `found` lies on: its
    /// way over the plane.
    pub fn set_slip_on_plane(
        &mut self,
        i: usize,
        found: &Projection,
        relative: &RelativePose,
        jacobian: &mut ContactJacobian,
    ) {
        let n_t = self.n_t;
        let tangents = across(&found.normal, n_t);
        let reference = &mut self.references[i];
        reference.stand(found.point, true, || tangents);
        let path = difference(&found.point, &reference.point);
        for (a, tangent) in tangents.iter().enumerate().take(n_t) {
            let k = n_t * i + a;
            self.slips[k] = reference.stretch[a] + dot(tangent, &path);
            jacobian.tangents_in_target[k] = *tangent;
            jacobian.tangents_in_body[k] = relative.inverse_transform_vector(tangent);
            jacobian.normal_coupling[k * jacobian.width..(k + 1) * jacobian.width].fill(0.0);
        }
        self.stick_slip.set_length(i, 1.0);
        self.next_tangents[i] = tangents;
    }

    /// Takes the directions of the slips as those of the forces, which is right where points do not
    /// act on each other.
    pub fn point_along_slips(&mut self, jacobian: &ContactJacobian) {
        let n_t = self.n_t;
        for i in 0..self.references.len() {
            let points = n_t * i..n_t * (i + 1);
            let length = force_length(&jacobian.tangents_in_target[points.clone()], &self.slips[points]);
            // Points never projected have no tangents.
            self.stick_slip.set_length(i, if length > 0.0 { length } else { 1.0 });
        }
    }

    /// Sets the slip of point `i` to zero, as the point is far away.
    pub fn clear_slip(&mut self, i: usize) {
        self.slips[self.n_t * i..self.n_t * (i + 1)].fill(0.0);
    }

    /// Sets the tangential forces, and the displacements under forces, to zero.
    pub fn clear_forces(&mut self) {
        self.stick_slip.clear_forces();
        self.deflections.fill(0.0);
    }

    /// Tangential forces of point `i`.
    pub fn force(&self, i: usize) -> &[f64] {
        &self.stick_slip.forces()[self.n_t * i..self.n_t * (i + 1)]
    }

    /// Tolerance of the alternations between normal and friction forces in the next solution: no
    /// smaller than the error that the pass leaves anyway. `tolerance`: tolerance of the gaps, as a
    /// share of `depth`.
    pub fn alternation_tolerance_for(
        &self,
        tolerance: f64,
        gaps: &[f64],
        springs: &[f64],
        forces: &[f64],
        depth: f64,
    ) -> f64 {
        let mut residual = 0.0_f64;
        for (i, (gap, force)) in
            gaps.iter().zip(forces).enumerate().filter(|(_, (g, f))| **f > 0.0 || **g < 0.0)
        {
            residual = residual.max((gap + springs[i] * force).abs());
            for k in self.n_t * i..self.n_t * (i + 1) {
                let expected =
                    self.stick_slip.increments()[k] - self.stick_slip.spring(i) * self.stick_slip.forces()[k];
                residual = residual.max((self.slips[k] - expected).abs());
            }
        }
        // Alternations reach 1e-12. The directions of points that are about to stop converge
        // slowly: they are not asked for more than the gaps.
        (PASS_GAIN * residual / depth).min(FIRST_ALTERNATION_TOLERANCE * tolerance).max(tolerance).max(1e-12)
    }

    /// Number of sliding points among those with normal forces `forces`.
    pub fn n_sliding(&self, forces: &[f64]) -> usize {
        (0..forces.len()).filter(|i| self.is_sliding(*i, forces)).count()
    }

    fn is_sliding(&self, i: usize, forces: &[f64]) -> bool {
        forces[i] > 0.0 && self.stick_slip.states()[i] == PointState::Slip
    }

    /// Slip increment `k` since the references were last updated; of points without normal forces
    /// the whole slip.
    fn increment(&self, k: usize, forces: &[f64]) -> f64 {
        if forces[k / self.n_t] > 0.0 { self.stick_slip.increments()[k] } else { self.slips[k] }
    }

    /// Largest component of the friction force of point `i`.
    fn bound(&self, i: usize, forces: &[f64]) -> f64 {
        if forces[i] > 0.0 { self.stick_slip.bounds()[i] } else { 0.0 }
    }

    /// How far point `i` has slid since the references were last updated \[m\].
    fn slid(&self, i: usize, forces: &[f64]) -> f64 {
        (self.n_t * i..self.n_t * (i + 1)).map(|k| self.increment(k, forces)).fold(0.0, f64::hypot)
    }

    /// Notes how far the points have slid, and their bounds, in an evaluation at the time `t`; what was noted at that time and later is
    /// of another attempt.
    pub fn note_way(&mut self, t: f64, forces: &[f64]) {
        let (n, kept) = (forces.len(), self.times.iter().take_while(|noted| **noted < t).count());
        self.times.truncate(kept.min(NOTED - 1));
        let at = n * self.times.len();
        self.times.push(t);
        for i in 0..n {
            self.ways[at + i] = [self.slid(i, forces), self.bound(i, forces)];
        }
    }

    /// Work of sliding since the references were last updated, up to the last evaluation noted (Eq. F.25) \[J\].
    pub fn sliding_work(&self) -> f64 {
        let n = self.start_bounds.len();
        let mut work = 0.0;
        for (i, start) in self.start_bounds.iter().enumerate() {
            let slides_on = *start > 0.0 && self.stick_slip.slid_before(i);
            let mut before = [0.0, *start];
            for k in 0..self.times.len() {
                let now = self.ways[n * k + i];
                // A point that is loaded or left on the way.
                let share = if before[1] > 0.0 && now[1] > 0.0 { 0.5 } else { 1.0 / 3.0 };
                let way = now[0] - before[0];
                work += share * (before[1] + now[1]) * way;
                // The parabola through the start, where the point slid already and slides on.
                if slides_on && way > 0.0 && way < ALIKE * before[0] && now[1] > 0.0 && before[1] > 0.0 {
                    let bend = (now[1] - before[1]) / way - (before[1] - start) / before[0];
                    work -= way.powi(3) * bend / (6.0 * now[0]);
                }
                before = now;
            }
        }
        work
    }

    /// Takes the references of the points from the last evaluation: the springs of sticking points
    /// keep their stretch, those of sliding points get the stretch that belongs to their force
    /// (Eq. F.8).
    pub fn update_references(
        &mut self,
        forces: &[f64],
        nodes: &[[f64; 3]],
        jacobian: &ContactJacobian,
        projections: &[Projection],
        is_projected: &[bool],
    ) {
        let n_t = self.n_t;
        for (i, reference) in self.references.iter_mut().enumerate() {
            reference.is_set = is_projected[i] && !projections[i].is_beyond;
            reference.is_on_plane = projections[i].is_on_plane;
            reference.is_new = false;
            let state = self.stick_slip.states()[i];
            for a in 0..n_t {
                let k = n_t * i + a;
                reference.stretch[a] = match state {
                    _ if forces[i] <= 0.0 => 0.0,
                    PointState::Stick => self.slips[k],
                    _ => self.slips[k] - self.stick_slip.increments()[k],
                };
            }
            if reference.is_set {
                reference.point = if reference.is_on_plane { projections[i].point } else { self.places[i] };
                let mut tangents = [[0.0; 3]; 2];
                tangents[..n_t].copy_from_slice(&jacobian.tangents_in_target[n_t * i..n_t * (i + 1)]);
                let units = orthonormal(&tangents, n_t);
                reference.tangents = self.next_tangents[i];
                let spring = self.stick_slip.spring(i);
                if forces[i] > 0.0 && spring > 0.0 {
                    // The force stays the same vector; its components along the new tangents
                    // differ, since the surface has been strained since the references were last
                    // updated.
                    let components = &self.stick_slip.forces()[n_t * i..n_t * (i + 1)];
                    let force = combination(&tangents, components);
                    for (stretch, unit) in reference.stretch.iter_mut().zip(&units).take(n_t) {
                        *stretch = -spring * dot(&force, unit);
                    }
                }
            }
        }
        // The next tangents are orthonormal.
        for (bound, force) in self.start_bounds.iter_mut().zip(forces) {
            *bound = self.stick_slip.largest(force.max(0.0));
        }
        self.times.clear();
        self.nodes.copy_from_slice(nodes);
        self.has_nodes = true;
        self.is_evaluated = false;
    }

    /// Friction forces of the points in the frame of the target, in the model's components \[N\].
    pub fn vectors(&self, jacobian: &ContactJacobian) -> Vec<[f64; 3]> {
        let tangents = jacobian.tangents_in_target.chunks_exact(self.n_t);
        let forces = self.stick_slip.forces().chunks_exact(self.n_t);
        tangents.zip(forces).map(|(tangents, force)| combination(tangents, force)).collect()
    }

    /// The friction forces are those `wanted` from now on, in the frame of the target; none: the springs stretch so that they stay as
    /// they are (Eq. A.41).
    pub fn prescribe(&mut self, wanted: Option<&[[f64; 3]]>, jacobian: &ContactJacobian) {
        let n_t = self.n_t;
        let on_tangents = |(tangents, wanted): (&[[f64; 3]], &[f64; 3])| {
            let mut both = [[0.0; 3]; 2];
            both[..n_t].copy_from_slice(tangents);
            // Points that were never projected have no tangents, and no force.
            let duals = duals(&both, n_t);
            duals.map(|dual| Some(dot(&dual, wanted)).filter(|c| c.is_finite()).unwrap_or(0.0))
        };
        let components = |wanted: &[[f64; 3]]| {
            let points = jacobian.tangents_in_target.chunks_exact(n_t).zip(wanted).map(on_tangents);
            points.flat_map(|pair| pair.into_iter().take(n_t)).collect()
        };
        let is_over = wanted.is_none();
        let shifts = self.stick_slip.prescribe(wanted.map(components));
        for (k, shift) in shifts.into_iter().enumerate().filter(|_| is_over) {
            self.references[k / n_t].stretch[k % n_t] += shift;
        }
    }

    pub fn save(&mut self) {
        self.saved_depth = self.depth;
        self.saved_deflections.copy_from_slice(&self.deflections);
        self.stick_slip.save();
    }

    pub fn restore(&mut self) {
        self.depth = self.saved_depth;
        self.deflections.copy_from_slice(&self.saved_deflections);
        self.times.clear();
        self.is_evaluated = false;
        for reference in &mut self.references {
            reference.is_set &= !reference.is_new;
        }
        self.stick_slip.restore();
    }
}

/// `Σ_a c_a v_a`.
fn combination(vectors: &[[f64; 3]], components: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (vector, component) in vectors.iter().zip(components) {
        sum.iter_mut().zip(vector).for_each(|(s, v)| *s += component * v);
    }
    sum
}

/// Size of the friction force along `tangents` per size of its components, in the direction of
/// `components`; the mean over all directions if these are zero (Eq. F.24).
fn force_length(tangents: &[[f64; 3]], components: &[f64]) -> f64 {
    let size = components.iter().map(|c| c * c).sum::<f64>().sqrt();
    match tangents {
        [only] => norm(only),
        _ if size > 0.0 => norm(&combination(tangents, components)) / size,
        [first, second, ..] => {
            let along = dot(first, second);
            (dot(first, first) * dot(second, second) - along * along).max(0.0).powf(0.25)
        }
        [] => 1.0,
    }
}

/// Vectors in the plane of the first `n` of `vectors` with `u_a · v_b = δ_ab`.
fn duals(vectors: &[[f64; 3]; 2], n: usize) -> [[f64; 3]; 2] {
    let [u, v] = vectors;
    if n == 1 {
        let square = dot(u, u);
        return [u.map(|x| x / square), [0.0; 3]];
    }
    let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
    let determinant = uu * vv - uv * uv;
    let combine = |p: f64, q: f64| [0, 1, 2].map(|c| (p * u[c] + q * v[c]) / determinant);
    [combine(vv, -uv), combine(-uv, uu)]
}

/// Orthonormal vectors across `normal`: one in the plane of the first two components, or two of
/// space.
fn across(normal: &[f64; 3], n: usize) -> [[f64; 3]; 2] {
    if n == 1 {
        return [[normal[1], -normal[0], 0.0], [0.0; 3]];
    }
    let least = (0..3).fold(0, |least, c| if normal[c].abs() < normal[least].abs() { c } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let first = cross(normal, &axis);
    orthonormal(&[first, cross(normal, &first)], 2)
}

/// Orthonormal vectors in the plane of the first `n` of `vectors`, the first along the first.
fn orthonormal(vectors: &[[f64; 3]; 2], n: usize) -> [[f64; 3]; 2] {
    let unit = |v: [f64; 3]| {
        let length = norm(&v);
        v.map(|x| x / length)
    };
    let first = unit(vectors[0]);
    if n == 1 {
        return [first, [0.0; 3]];
    }
    let along = dot(&vectors[1], &first);
    [first, unit([0, 1, 2].map(|c| vectors[1][c] - along * first[c]))]
}

#[cfg(test)]
mod tests {
    use super::*;

    const COEFFICIENT: f64 = 0.5;
    /// Compliance of the tangential springs [m/N].
    const SPRING: f64 = 1e-3;

    /// Work of sliding of points that slide under the normal forces `start` when a step begins, and have slid by the ways `noted`, each
    /// under its forces, at the evaluations of the step \[J\].
    fn work(start: &[f64], noted: &[(f64, Vec<f64>)]) -> f64 {
        let mut friction = PairFriction::new(Friction::new(COEFFICIENT), (start.len(), 2), 0, false);
        friction.stick_slip.set_springs(&vec![SPRING; start.len()]);
        let slide = |friction: &mut PairFriction, way: f64, forces: &[f64]| {
            friction.slips = forces.iter().map(|f| way + SPRING * COEFFICIENT * f).collect();
            friction.stick_slip.solve_points(&friction.slips, forces).expect("finite slips");
        };
        slide(&mut friction, 1.0, start);
        friction.stick_slip.save();
        friction.start_bounds = start.iter().map(|force| friction.stick_slip.largest(*force)).collect();
        for (k, (way, forces)) in noted.iter().enumerate() {
            slide(&mut friction, *way, forces);
            friction.note_way(k as f64, forces);
        }
        friction.sliding_work()
    }

    #[test]
    fn forces_that_are_quadratic_in_the_way_do_their_work_from_the_first_stage_on() {
        let force = |w: f64| 2.0 + 3.0 * w - 4.0 * w * w;
        // Stages of the explicit method.
        let ways = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
        let noted = ways.map(|way| (way, vec![force(way)]));
        let exact = |w: f64| 2.0 * w + 1.5 * w * w - 4.0 / 3.0 * w.powi(3);
        // One chord up to the first stage, parabolas then.
        let wanted = COEFFICIENT * (0.1 * (force(0.0) + force(0.2)) + exact(1.0) - exact(0.2));
        assert!((work(&[force(0.0)], &noted) / wanted - 1.0).abs() < 1e-12);
    }

    #[test]
    fn points_that_are_loaded_or_left_on_the_way_do_their_work_in_the_mean() {
        // Points that are met at any share of a way of one, under forces that grow evenly from there on: half of the force times the way under it.
        let forces: Vec<f64> = (0..100).map(|i| (f64::from(i) + 0.5) / 100.0).collect();
        let wanted: f64 = forces.iter().map(|share| COEFFICIENT * 0.5 * share * share).sum();
        let none = vec![0.0; forces.len()];
        // The middles of a hundred shares miss the mean of their squares by 1 / (4 · 100²).
        for (start, end) in [(&none, &forces), (&forces, &none)] {
            assert!((work(start, &[(1.0, end.clone())]) / wanted - 1.0).abs() < 3e-5);
        }
    }
}
