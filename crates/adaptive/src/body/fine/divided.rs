//! The fine model of a body of finite elements: its mesh, divided about the place of a touch
//! (docs/theory.md section C.10).

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::zone::points::DofLookup;
use faer::{Mat, MatRef};
use fe_mesh::fault::MeshFault;
use fe_mesh::refined::RefinedMesh;
use fe_mesh::{Mesh, MeshSpace};
use ffr_dynamics::body::{AssembledBody, Dof};
use iga_core::SplineError;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{ElementMaterials, MaterialField, Model};
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::space::Space;
use nalgebra::Vector3;
use tracing::debug;

use crate::adaptivity::interval::{IntervalEnd, IntervalGrid};
use crate::adaptivity::subdivision::SubdivisionError;
use crate::body::field::Field;
use crate::body::fine::refined::{gigabytes, most_gigabytes};
use crate::body::mesh::{MeshedBody, assembled, no_such_place, points_of};
use crate::body::zone::ContactZone;
use crate::error::AdaptiveError;
use crate::spec::body::dofs_of;
use crate::store::{Bytes, meshed_definition};
use crate::surface::smooth_fit::SmoothFit;
use crate::surface::{MeshSurface, Surface, SurfacePlace};

mod footprint;

use footprint::Footprint;
pub use footprint::{LINEAR, QUADRATIC, TETRAHEDRA, WantedZone};

/// Rows of a direction in which contact is counted, whatever the elements are.
const ROWS: usize = 16;
/// Pieces of elements at most, so that counting them ends; memory ends before.
const MOST: usize = 300_000;

/// A divided mesh with its zone.
pub struct FineElements {
    body: Arc<MeshedBody>,
    wanted: WantedZone,
    refined: RefinedMesh,
    /// Displacements of the free nodes.
    space: MeshSpace,
    /// Materials of its elements.
    pub materials: ElementMaterials,
    surface: Arc<MeshSurface>,
    /// Those of the places of the zone.
    footprints: Vec<Footprint>,
    /// The surfaces through the nodes there, where they are smooth.
    smooth: Vec<Option<SmoothFit>>,
    dofs: Vec<Dof>,
    lookup: DofLookup,
}

impl FineElements {
    /// Divides the mesh of `body` about a zone.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] or [`AdaptiveError::Subdivision`] if that would take too many pieces, [`AdaptiveError::Contact`] where the surface has no curvature,
    /// [`AdaptiveError::Unsupported`] if a rigid part of the body would be divided.
    pub fn build(body: &Arc<MeshedBody>, wanted: WantedZone) -> Result<Self, AdaptiveError> {
        let (name, spec) = (body.name.as_str(), &body.spec);
        let fail = |source: MeshFault| AdaptiveError::Mesh { body: name.to_owned(), source };
        let nothing = || {
            let source = ContactError::Empty { width: wanted.widths[0] };
            AdaptiveError::Contact { contact: name.to_owned(), source }
        };
        let coarse = &body.surface;
        let footprints = wanted.footprints(coarse).ok_or_else(nothing)?;
        let elements = wanted.elements(coarse);
        let (refined, finest) = wanted.divided(coarse, &footprints, MOST).map_err(fail)?;
        let n_free = refined.n_free();
        let elements_now = refined.mesh().elements().len();
        debug!(body = name, finest, widths = ?wanted.widths, elements = elements_now, nodes = n_free, "fine model");
        let surface = MeshSurface::of(refined.mesh());
        let fit = |(site, of): (_, &Footprint)| {
            SmoothFit::new(coarse, (site, &of.shape), of.reach(), |x| of.contains(x))
        };
        let smooth: Vec<Option<SmoothFit>> = wanted.sites.iter().zip(&footprints).map(fit).collect();
        let dofs = dofs_of(spec.mesh.model(), refined.free_nodes());
        let fine = Self {
            body: Arc::clone(body),
            wanted,
            space: MeshSpace::divided(&refined, spec.mass_rule),
            materials: body.materials.of_parts(refined.parents()),
            lookup: DofLookup::new(&dofs),
            dofs,
            refined,
            surface,
            footprints,
            smooth,
        };
        fine.check_rigid_parts()?;
        fine.check_size(finest, elements)?;
        Ok(fine)
    }

    /// Refuses what no memory holds, with elements of the size `element`, so many of them `across`.
    fn check_size(&self, element: f64, across: usize) -> Result<(), AdaptiveError> {
        let (unknowns, interface) = (self.n_unknowns() as f64, self.contact_zone()?.unknowns.len() as f64);
        let gigabytes = gigabytes(self.space.dimension(), unknowns, interface);
        let most = most_gigabytes();
        if gigabytes <= most {
            return Ok(());
        }
        let width = 2.0 * self.footprints.iter().map(Footprint::reach).fold(0.0, f64::max);
        let source =
            SubdivisionError::TooLarge { width, across, element, unknowns, interface, gigabytes, most };
        Err(AdaptiveError::Subdivision { body: self.body.name.clone(), source })
    }

    /// Refuses divided elements at nodes of rigid parts, which are held by the functions of the
    /// mesh before.
    fn check_rigid_parts(&self) -> Result<(), AdaptiveError> {
        if self.body.spec.flexible.rigid_areas.is_empty() {
            return Ok(());
        }
        let mut count = vec![0u32; self.body.spec.mesh.elements().len()];
        self.refined.parents().iter().for_each(|&p| count[p as usize] += 1);
        let mut is_divided = vec![false; self.body.spec.mesh.nodes().len()];
        for (element, _) in self.body.spec.mesh.elements().iter().zip(&count).filter(|(_, n)| **n > 1) {
            element.nodes.iter().for_each(|&n| is_divided[n as usize] = true);
        }
        let held = self.body.rigid_nodes()?;
        if held.iter().any(|&n| is_divided[n as usize]) {
            return Err(AdaptiveError::unsupported_body(
                &self.body.name,
                "a contact zone reaches the elements of a part that a joint or load \
             holds with coupling = \"rigid\"; choose coupling = \"average\" or a smaller part"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Widths of the zone; the second is zero of a curve \[m\].
    fn widths(&self) -> [f64; 2] {
        let [along, across] = self.wanted.widths;
        [along, if self.n_directions() == 1 { 0.0 } else { across }]
    }

    /// Whether it begins at the axis of symmetry wherever it lies.
    fn is_from_axis(&self) -> bool {
        self.footprints.iter().all(|of| of.from_axis)
    }

    /// Number of directions of its surface.
    fn n_directions(&self) -> usize {
        self.space.dimension() - 1
    }

    /// Contact points and interface.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] for a side without area, [`AdaptiveError::Contact`] if there is no point.
    pub fn contact_zone(&self) -> Result<ContactZone, AdaptiveError> {
        let widths = self.widths();
        let empty = || {
            let source = ContactError::Empty { width: widths[0] };
            AdaptiveError::Contact { contact: self.body.name.clone(), source }
        };
        let first = |of: &Footprint| Some(self.surface.nearest(of.centre.as_ref())?.place.face);
        let first: Option<Vec<u32>> = self.footprints.iter().map(first).collect();
        let n_free = self.refined.n_free();
        let is_near = |x: &[f64; 3]| self.footprints.iter().any(|of| of.contains(x));
        let is_free = |n: u32| (n as usize) < n_free;
        let first = first.ok_or_else(empty)?;
        let zone = ContactZone::within(&self.surface, &first, is_near, is_free, widths);
        let mut zone = zone.map_err(|source| AdaptiveError::Mesh { body: self.body.name.clone(), source })?;
        if zone.points.is_empty() {
            return Err(empty());
        }
        match &self.smooth[..] {
            [fit] => fit.iter().for_each(|fit| smooth(&mut zone, fit)),
            _ => self.smooth_each(&mut zone),
        }
        Ok(zone)
    }

    /// Puts points and sides of `zone` on the surface through the nodes about the nearest of several places, which is as far
    /// outside there as the sides are in its middle (theory Eq. A.42).
    fn smooth_each(&self, zone: &mut ContactZone) {
        let height = |of: &Footprint, x: &[f64; 3]| (Vector3::from(*x) - of.centre).dot(&of.shape.normal);
        let outmost = |k: usize| {
            let (of, fit) = (&self.footprints[k], self.smooth[k].as_ref()?);
            let own = zone.points.iter().map(|p| &p.position).filter(|x| self.nearest(x) == k);
            let outmost = own.map(|x| height(of, fit.onto(x).as_ref())).reduce(f64::max);
            let is_convex = of.shape.curvatures[..of.n_directions].iter().all(|k| *k >= 0.0);
            Some((fit, outmost.filter(|_| is_convex).unwrap_or_else(|| fit.above(of.centre.as_ref()))))
        };
        let fits: Vec<_> = (0..self.smooth.len()).map(outmost).collect();
        zone.move_to(|x| match fits[self.nearest(x)] {
            Some((fit, outmost)) => (fit.onto(x) - outmost * fit.normal()).into(),
            None => *x,
        });
    }

    /// The one of its places that `x` is nearest to.
    fn nearest(&self, x: &[f64; 3]) -> usize {
        let distances = self.footprints.iter().map(|of| of.distance(x)).enumerate();
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k)
    }

    /// How far the zone may be moved outwards from smooth surfaces on which it lies, any way at one place, none at several \[m\]; none if it lies on
    /// the sides as they are.
    pub fn most_outwards(&self) -> Option<f64> {
        let is_smooth = self.smooth.iter().any(Option::is_some);
        is_smooth.then_some(if self.smooth.len() == 1 { f64::INFINITY } else { 0.0 })
    }

    /// Moves `zone` by `offset` \[m\] along the normals of its smooth surfaces.
    pub fn move_out(&self, zone: &mut ContactZone, offset: f64) {
        zone.move_to(|x| match &self.smooth[self.nearest(x)] {
            Some(fit) => (Vector3::from(*x) + offset * fit.normal()).into(),
            None => *x,
        });
    }

    /// The rows by which the use of the zone is judged.
    pub fn rows(&self) -> IntervalGrid {
        let first = if self.is_from_axis() { IntervalEnd::Axis } else { IntervalEnd::Open };
        let ends =
            |d: usize| if self.is_line()[d] { [IntervalEnd::LineEnd; 2] } else { [first, IntervalEnd::Open] };
        let ends = (0..self.n_directions()).map(ends).collect();
        IntervalGrid { widths: self.widths(), ends, n_elements: self.n_rows() }
    }

    /// Directions in which the zone reaches from one edge of the part to the other.
    fn is_line(&self) -> [bool; 2] {
        self.wanted.is_line(&self.body.surface)
    }

    /// Rows per direction: one along a line, all of which is watched.
    fn n_rows(&self) -> [usize; 2] {
        let is_line = self.is_line();
        [0, 1].map(|d| if d >= self.n_directions() || is_line[d] { 1 } else { ROWS })
    }

    /// The rows in which the points of `zone` lie about the nearest place, the outermost ones for those beyond it
    /// and on the rim.
    pub fn rows_of(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        let from_axis = self.is_from_axis();
        let n = self.n_rows();
        let row = |x: f64, half: f64, n: usize| {
            let share = if from_axis { x.abs() / half } else { 0.5 * (x / half + 1.0) };
            ((share * n as f64).max(0.0) as usize).min(n - 1)
        };
        let rows = |x: &[f64; 3]| {
            let of = &self.footprints[self.nearest(x)];
            let along = of.along(x);
            [0, 1].map(|d| row(along[d], of.half[d], n[d]))
        };
        let rim = [if from_axis { ROWS - 1 } else { 0 }, 0];
        // Beyond the rim nothing is watched: contact there asks for a wider zone, on whichever side
        // it is.
        zone.points.iter().map(|p| if p.on_rim { rim } else { rows(&p.position) }).collect()
    }

    /// Stiffness and mass of the free nodes.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if there are too many entries or an element is folded; those of [`MeshedBody::held`].
    pub fn assembled(&self) -> Result<AssembledBody, AdaptiveError> {
        let mut assembled = assembled(&self.body.name, &self.space, &self.materials)?;
        assembled.stiffness = self.body.held(assembled.stiffness)?;
        Ok(assembled)
    }

    /// Displacements of the mesh before (n_before x k) on the free nodes: the same fields (theory
    /// Eq. A.12).
    pub fn prolonged(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        let mut fine = Mat::zeros(self.n_unknowns(), shapes.ncols());
        let mut functions = (usize::MAX, Vec::new());
        for (row, dof) in self.dofs.iter().enumerate() {
            let (node, c) = (dof.node as usize, dof.component as usize);
            if functions.0 != node {
                functions = (node, self.refined.functions_before(&self.body.spec.mesh, node));
            }
            for j in 0..shapes.ncols() {
                let value = |(n, w): &(u32, f64)| Some(w * shapes[(self.body.lookup.number(*n, c)?, j)]);
                fine[(row, j)] = functions.1.iter().filter_map(value).sum();
            }
        }
        fine
    }

    /// The divided mesh.
    pub fn divided(&self) -> &Arc<Mesh> {
        self.refined.mesh()
    }

    /// What its matrices are made from.
    pub fn zone_definition(&self) -> Bytes {
        let mut key = Bytes(meshed_definition(&self.body.spec));
        let WantedZone { sites, widths, elements, across } = &self.wanted;
        sites.iter().for_each(|SurfacePlace { face, xi, point }| {
            key.add(&(face, xi, point, widths, elements, across))
        });
        key
    }
}

impl Field for FineElements {
    fn name(&self) -> &str {
        &self.body.name
    }

    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn model(&self) -> &Model {
        self.body.spec.mesh.model()
    }

    fn materials(&self) -> &dyn MaterialField {
        &self.materials
    }

    fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    fn lookup(&self) -> &DofLookup {
        &self.lookup
    }

    fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        let found = self.divided().locate(place);
        found.map_err(|source| AdaptiveError::Mesh { body: self.body.name.clone(), source })
    }

    fn points_of(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
        points_of(self, self.divided(), extent)
    }

    fn named_place(&self, marker: &str) -> Result<[f64; 3], AdaptiveError> {
        Err(no_such_place(self, self.divided(), marker))
    }

    fn unit_states(&self, e: usize, xi: &[f64; 3]) -> Result<Vec<(u32, Vec<PointState>)>, SplineError> {
        self.space.unit_states(&self.materials, e, xi)
    }

    /// With the nodes that follow others.
    fn drawn_values(&self, u: &[f64]) -> Vec<f64> {
        let (n, n_components) = (self.divided().nodes().len(), self.space.dimension());
        let mut all = self.control_values(u);
        all.resize(n_components * n, 0.0);
        for node in self.refined.n_free()..n {
            for &(free, weight) in self.refined.followed(node as u32) {
                for c in 0..n_components {
                    all[n_components * node + c] += weight * all[n_components * free as usize + c];
                }
            }
        }
        all
    }
}

/// Puts points and sides of `zone` on the surface `fit`, so far inside that none of it stands out
/// of where they were (theory Eq. C.75).
fn smooth(zone: &mut ContactZone, fit: &SmoothFit) {
    let places = zone.points.iter().map(|p| p.position).chain(zone.nodes().into_iter().map(|(_, x)| x));
    let outmost = places.map(|x| fit.above(&x)).fold(f64::NEG_INFINITY, f64::max);
    zone.move_to(|x| (fit.onto(x) - outmost * fit.normal()).into());
}
