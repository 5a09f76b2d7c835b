//! Contact zones on the sides of a mesh.

use std::collections::HashSet;
use std::sync::Arc;

use contact_qs::zone::points::{PressureMean, SurfacePoint};
use fe_mesh::SideKind;
use fe_mesh::element::shape::Functions;
use fe_mesh::fault::MeshFault;
use fe_mesh::surface::SurfaceSide;
use nalgebra::Vector3;

use super::{ContactZone, ZoneExtent, ZoneRegion};
use crate::surface::{MeshSurface, SurfacePlace};

/// The linear functions of the corners of `side` at the parameters `xi`, with the numbers of their
/// nodes.
fn hats(side: &SurfaceSide, xi: &[f64; 2]) -> Vec<(u32, f64)> {
    let kind = SideKind::linear(side.n_edges());
    let mut functions = Functions::default();
    kind.functions(xi, &mut functions);
    side.nodes.iter().copied().zip(functions.values).collect()
}

/// All unknowns of the nodes of the sides `chosen`, and of `further` ones, rising.
pub(super) fn unknowns_of(
    surface: &MeshSurface,
    chosen: &[u32],
    further: impl Iterator<Item = u32>,
) -> Vec<usize> {
    let on_sides = chosen.iter().flat_map(|&i| surface.sides()[i as usize].nodes.iter().copied());
    let mut nodes: Vec<u32> = on_sides.chain(further).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.iter().flat_map(|&n| surface.unknowns_at(n)).collect()
}

impl ContactZone {
    /// The zone of the sides of `surface` that are smoothly connected with the one at `place` and
    /// come within `reach` of it, with a ring of sides around: their Gauss points with areas and
    /// functions, and all unknowns of their nodes. On its rim are the points of the ring where the
    /// surface goes on beyond.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn about(surface: &MeshSurface, place: &SurfacePlace, reach: f64) -> Result<Self, MeshFault> {
        let centre = Vector3::from(place.point);
        let width = (2.0 * reach).min(surface.mesh().size());
        let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).norm() <= reach;
        Self::within(surface, &[place.face], is_near, |_| true, [width, 0.0])
    }

    /// The zone of the sides that are smoothly connected with the one at `place` and come within
    /// `reach` of the plane across the unit vector `across` through it, as far as the surface goes
    /// along that.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn along_line(
        surface: &MeshSurface,
        place: &SurfacePlace,
        across: &Vector3<f64>,
        reach: f64,
    ) -> Result<Self, MeshFault> {
        let centre = Vector3::from(place.point);
        let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).dot(across).abs() <= reach;
        Self::within(surface, &[place.face], is_near, |_| true, [2.0 * reach, 0.0])
    }

    /// The zone of the sides that are smoothly connected with a side of `first` and have a point of
    /// which `is_near`, among those that may take part: with all of their nodes `is_free`.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn within(
        surface: &MeshSurface,
        first: &[u32],
        is_near: impl Fn(&[f64; 3]) -> bool,
        is_free: impl Fn(u32) -> bool,
        widths: [f64; 2],
    ) -> Result<Self, MeshFault> {
        let all = surface.sides();
        let may_be = |i: usize| all[i].nodes.iter().all(|&n| is_free(n));
        let is_chosen = |i: usize| may_be(i) && surface.places_on(i).iter().any(&is_near);
        let chosen = first.iter().flat_map(|side| surface.smooth_part(*side as usize, is_chosen));
        let mut sides = surface.with_ring(&chosen.collect::<Vec<_>>());
        sides.retain(|&i| may_be(i as usize));
        let inside: HashSet<u32> = sides.iter().copied().collect();
        let model = surface.mesh().model();
        let (mut points, mut parameters) = (Vec::new(), Vec::new());
        for &i in &sides {
            surface.check_side(i as usize)?;
            let side = &all[i as usize];
            let beyond = side.neighbours.iter().flatten();
            let on_rim = beyond.copied().any(|n| n.is_smooth && !inside.contains(&n.side));
            for point in side.kind.contact_rule() {
                let at = surface.at(i as usize, &point.xi);
                points.push(SurfacePoint {
                    position: at.position,
                    area: point.weight * Vector3::from(at.area).norm() * model.measure(&at.position),
                    functions: side.nodes.iter().copied().zip(at.functions.values).collect(),
                    on_rim,
                    pressure: PressureMean::Hats(hats(side, &point.xi)),
                    facing: None,
                });
                parameters.push([point.xi[0], point.xi[1], 0.0]);
            }
        }
        Ok(Self {
            unknowns: unknowns_of(surface, &sides, std::iter::empty()),
            points,
            parameters,
            faces: Vec::new(),
            widths,
            region: ZoneRegion::Pieces(Arc::new(surface.pieces_of(&sides))),
            extent: ZoneExtent::Part,
            meeting: Vec::new(),
            left_out: Vec::new(),
        })
    }
}

/// The largest extent along the unit vector `across` of the sides that are smoothly connected with
/// the one at `place` and come within `reach` of the plane across it through the place \[m\].
pub fn longest_across(surface: &MeshSurface, place: &SurfacePlace, across: &Vector3<f64>, reach: f64) -> f64 {
    let centre = Vector3::from(place.point);
    let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).dot(across).abs() <= reach;
    let is_chosen = |i: usize| i == place.face as usize || surface.places_on(i).iter().any(is_near);
    let extent = |i: &u32| {
        let heights = surface.sides()[*i as usize].nodes.iter();
        let heights = heights.map(|&n| Vector3::from(surface.mesh().nodes()[n as usize]).dot(across));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (f64::min(a, h), f64::max(b, h)));
        high - low
    };
    surface.smooth_part(place.face as usize, is_chosen).iter().map(extent).fold(0.0, f64::max)
}
