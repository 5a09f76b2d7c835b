//! Meshes as spaces of displacements, behind the trait that splines stand behind as well.

use std::sync::Arc;

use iga_core::elasticity::{ElementMaterials, Material, Model};
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::{Cell, Element, GridBasis, Integrand, Rows, Space};

use crate::element::kind::{ElementKind, Form};
use crate::element::rules::{MassRule, RulePoint};
use crate::element::shape::Functions;
use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::refined::RefinedMesh;

/// The displacements of a mesh: functions of its nodes, of a divided one those of its free nodes
/// (theory Eq. C.71).
///
/// All elements are plain displacement elements with the rules of [`crate::element::rules`]: hex8 and
/// quad4 have neither a mean dilatation nor incompatible modes.
pub struct MeshSpace {
    mesh: Arc<Mesh>,
    rows: Arc<Rows>,
    /// Number of nodes with a function, which come first.
    n_free: usize,
    tables: Vec<KindTables>,
}

/// Functions of one kind at the points of its rules.
struct KindTables {
    kind: ElementKind,
    stiffness: GridBasis,
    mass: GridBasis,
}

impl KindTables {
    fn new(kind: ElementKind, model: &Model, rule: MassRule) -> Self {
        let stiffness = table(kind, &kind.stiffness_points(model));
        Self { kind, stiffness, mass: table(kind, &kind.mass_points(rule)) }
    }
}

fn table(kind: ElementKind, rule: &[RulePoint<3>]) -> GridBasis {
    let mut table = GridBasis::default();
    let mut point = PointBasis::default();
    for (q, RulePoint { xi, weight }) in rule.iter().enumerate() {
        evaluate(kind, xi, 1, &mut point);
        table.set_point(q, rule.len(), &point);
        table.parameters.push(*xi);
        table.weights.push(*weight);
    }
    table
}

fn evaluate(kind: ElementKind, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
    let mut functions =
        Functions { values: std::mem::take(&mut out.values), slopes: std::mem::take(&mut out.first) };
    kind.functions(xi, &mut functions);
    (out.values, out.first) = (functions.values, functions.slopes);
    out.second.clear();
    if n_derivatives == 0 {
        out.first.clear();
    }
}

impl MeshSpace {
    /// The functions of all nodes of `mesh`; masses are integrated by `rule`.
    pub fn new(mesh: impl Into<Arc<Mesh>>, rule: MassRule) -> Self {
        let mesh = mesh.into();
        let n_free = mesh.nodes().len();
        Self::with_rows(mesh, Arc::new(Rows::none()), n_free, rule)
    }

    /// The functions of the free nodes of a divided mesh.
    pub fn divided(refined: &RefinedMesh, rule: MassRule) -> Self {
        Self::with_rows(Arc::clone(refined.mesh()), Arc::clone(refined.rows()), refined.n_free(), rule)
    }

    fn with_rows(mesh: Arc<Mesh>, rows: Arc<Rows>, n_free: usize, rule: MassRule) -> Self {
        let there = |kind: &ElementKind| mesh.elements().iter().any(|e| e.kind == *kind);
        let kinds = ElementKind::ALL.into_iter().filter(there);
        let tables = kinds.map(|kind| KindTables::new(kind, mesh.model(), rule)).collect();
        Self { mesh, rows, n_free, tables }
    }

    /// The mesh with all its nodes.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    fn tables(&self, e: usize) -> Option<&KindTables> {
        let kind = self.mesh.elements().get(e).kind;
        self.tables.iter().find(|t| t.kind == kind)
    }
}

impl Space for MeshSpace {
    fn dimension(&self) -> usize {
        self.mesh.model().dimension()
    }

    fn n_functions(&self) -> usize {
        self.n_free
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.mesh.nodes()[..self.n_free]
    }

    fn anchors(&self) -> Vec<[f64; 3]> {
        self.control_points().to_vec()
    }

    fn n_elements(&self) -> usize {
        self.mesh.elements().len()
    }

    fn element(&self, e: usize) -> Element {
        let solid = [1.0; 3];
        let plane = [1.0, 1.0, 0.0];
        let (cell, lower, upper) = match self.mesh.elements().get(e).kind.form() {
            Form::Tetrahedron => (Cell::Tetrahedron, [0.0; 3], solid),
            Form::Hexahedron => (Cell::Box, [-1.0; 3], solid),
            Form::Wedge => (Cell::Wedge, [0.0, 0.0, -1.0], solid),
            Form::Pyramid => (Cell::Pyramid, [-1.0, -1.0, 0.0], solid),
            // The base of a wedge.
            Form::Triangle => (Cell::Wedge, [0.0; 3], plane),
            Form::Quadrilateral => (Cell::Box, [-1.0, -1.0, 0.0], plane),
        };
        Element { patch: 0, cell, lower, upper }
    }

    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.clear();
        let is_plain = self.rows.is_plain(e);
        out.extend_from_slice(if is_plain {
            self.mesh.elements().get(e).nodes
        } else {
            self.rows.functions(e)
        });
    }

    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        evaluate(self.mesh.elements().get(e).kind, xi, n_derivatives, out);
        if !self.rows.is_plain(e) {
            out.combine(&self.rows, e);
        }
    }

    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis) {
        let Some(tables) = self.tables(e) else { return };
        out.copy_from(if integrand == Integrand::Mass { &tables.mass } else { &tables.stiffness });
        if !self.rows.is_plain(e) {
            out.combine(&self.rows, e);
        }
    }

    fn has_one_rule(&self, e: usize) -> bool {
        self.tables(e).is_none_or(|t| t.stiffness.parameters == t.mass.parameters)
    }
}

impl Mesh {
    /// A material for each of the groups of elements `groups`, which share no element, and `rest`
    /// for those in none of them; without it they leave none out.
    ///
    /// # Errors
    /// As [`Mesh::by_group`].
    pub fn materials(
        &self,
        groups: &[(&str, Material)],
        rest: Option<Material>,
    ) -> Result<ElementMaterials, MeshFault> {
        let names: Vec<&str> = groups.iter().map(|(name, _)| *name).collect();
        let of_element = self.by_group(&names, rest.is_some())?;
        Ok(ElementMaterials::new(groups.iter().map(|(_, m)| *m).chain(rest).collect(), of_element))
    }
}
