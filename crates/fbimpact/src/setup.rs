//! From a validated scenario to the specification of a run: exact shapes, materials, places, contact pairs.

use adaptive::spec::{
    BodyKind, BodySpec, ContactLaw, ContactSpec, DampingSpec, DiscretisationSpec, ElasticSpec, FrameSpec,
    InitialMotion, IntervalSpec, PenaltySearch, PhaseSettings, Place as PlaceSpec, PointRule, PointSpec,
    ReductionSpec, RefinementSpec, RunSettings, RunSpec, StressInstant, StressSpec, SurfaceLaw, Target,
    Treatment,
};
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use iga_core::SplineError;
use iga_core::elasticity::{Material, Model};
use iga_core::knots::KnotVector;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{Patch, Shape};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::error::AppError;
use crate::scenario::model as scenario;
use crate::scenario::{Scenario, model::Place};

/// Bodies of the scenario that move, and where each body of the file stands among them.
struct Bodies {
    specs: Vec<BodySpec>,
    index: Vec<Option<usize>>,
}

/// The specification of the run that `scenario` describes.
///
/// # Errors
/// [`AppError::Model`] naming the body or contact that cannot be built.
pub fn run_spec(scenario: &Scenario) -> Result<RunSpec, AppError> {
    let mut bodies = Bodies { specs: Vec::new(), index: Vec::new() };
    for body in &scenario.bodies {
        let elastic = elastic_body(body)?;
        bodies.index.push(elastic.is_some().then_some(bodies.specs.len()));
        bodies.specs.extend(elastic);
    }
    let contacts = scenario.contacts.iter().map(|c| contact(c, scenario, &bodies));
    let contacts = contacts.collect::<Result<_, AppError>>()?;
    let points = scenario.output.points.iter().map(|p| {
        let (body, elastic) = bodies.flexible(p.body, &format!("output.points.{}", p.name))?;
        let place = PlaceSpec::Point(place(&elastic.shape, &p.at)?);
        Ok(PointSpec { name: p.name.clone(), body, place })
    });
    let points = points.collect::<Result<_, AppError>>()?;
    let stress = scenario.output.stress.iter().map(|s| {
        let (body, elastic) = bodies.flexible(s.body, &format!("output.stress.{}", s.name))?;
        let shape = &elastic.shape;
        Ok(StressSpec {
            name: s.name.clone(),
            body,
            ends: [place(shape, &s.from)?, place(shape, &s.to)?],
            samples: s.samples,
            at: match s.at {
                scenario::StressTime::PeakForce => StressInstant::PeakForce,
                scenario::StressTime::Time(t) => StressInstant::Time(t),
            },
        })
    });
    let stress = stress.collect::<Result<_, AppError>>()?;
    Ok(RunSpec {
        joints: Vec::new(),
        loops: Vec::new(),
        loads: Vec::new(),
        contacts,
        points,
        stress,
        settings: settings(scenario),
        bodies: bodies.specs,
    })
}

impl Bodies {
    /// Number among the moving bodies of body `index` of the file, which must be flexible.
    fn flexible(&self, index: usize, subject: &str) -> Result<(usize, &ElasticSpec), AppError> {
        let number = self.index[index];
        let elastic = number.and_then(|n| Some((n, self.specs[n].elastic()?)));
        elastic.ok_or_else(|| AppError::Model(format!("{subject}: the body is rigid, name a flexible one")))
    }
}

fn settings(scenario: &Scenario) -> RunSettings {
    let simulation = &scenario.simulation;
    let phase = |i: &scenario::Integration| PhaseSettings {
        method: ffr_dynamics::integration::Method::DormandPrince,
        max_step: i.max_step.unwrap_or(f64::INFINITY),
        tolerance: i.rtol,
        velocity_floor: i.velocity_floor,
    };
    RunSettings {
        end_time: simulation.end_time,
        gravity: Vector3::from(simulation.gravity),
        static_start: false,
        free: phase(&simulation.free),
        impact: phase(&simulation.impact),
        quiet_time: simulation.quiet_time,
        free_interval: scenario.output.free_interval,
    }
}

fn elastic_body(body: &scenario::Body) -> Result<Option<BodySpec>, AppError> {
    let scenario::BodyKind::Elastic(elastic) = &body.kind else { return Ok(None) };
    let fail = |source: SplineError| AppError::Model(format!("body \"{}\": {source}", body.name));
    let shape = shape(elastic).map_err(fail)?;
    let m = &elastic.material;
    let material = Material::new(m.youngs_modulus, m.poissons_ratio, m.density).map_err(fail)?;
    let mesh = &elastic.discretisation;
    let refine = mesh.refine.iter().map(|r| {
        Ok(RefinementSpec {
            centre: place(&shape, &r.at)?,
            width: r.width,
            elements: r.elements,
            ratio: r.ratio,
        })
    });
    let discretisation = DiscretisationSpec {
        degrees: raised(&mesh.degree, &shape),
        elements: mesh.elements.clone(),
        knots: mesh.knots.clone(),
        refine: refine.collect::<Result<_, AppError>>()?,
    };
    let [w, x, y, z] = body.orientation;
    let motion = InitialMotion {
        position: Vector3::from(body.position),
        rotation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        velocity: Vector3::from(body.velocity),
        angular_velocity: Vector3::from(body.angular_velocity),
    };
    let reduction = match elastic.reduction {
        scenario::Reduction::Modal { modes } => ReductionSpec::Modal { modes },
        scenario::Reduction::CraigBampton { modes, fixed_interface_modes } => {
            ReductionSpec::CraigBampton { modes, fixed_interface_modes }
        }
        scenario::Reduction::All => ReductionSpec::All,
    };
    let damping = elastic
        .damping
        .map_or(DampingSpec::None, |d| DampingSpec::Rayleigh { frequencies: d.frequencies, ratio: d.ratio });
    let model = match elastic.model {
        scenario::ElasticModel::Solid => Model::Solid,
        scenario::ElasticModel::Axisymmetric => Model::Axisymmetric,
        scenario::ElasticModel::PlaneStrain { thickness } => Model::PlaneStrain { thickness },
        scenario::ElasticModel::PlaneStress { thickness } => Model::PlaneStress { thickness },
    };
    let elastic = ElasticSpec {
        shape,
        model,
        material,
        discretisation,
        reduction,
        damping,
        frame: FrameSpec::Buckens,
        geometric_stiffening: false,
    };
    Ok(Some(BodySpec { name: body.name.clone(), kind: BodyKind::Elastic(Box::new(elastic)), motion }))
}

/// The exact shape of a body.
fn shape(elastic: &scenario::ElasticBody) -> Result<Shape, SplineError> {
    use scenario::Geometry;
    let is_axisymmetric = elastic.model == scenario::ElasticModel::Axisymmetric;
    match &elastic.geometry {
        Geometry::Sphere { radius, .. } if is_axisymmetric => axisymmetric::sphere(*radius),
        Geometry::Sphere { radius, net } => {
            let degree = elastic.discretisation.degree.iter().min().copied().unwrap_or(0);
            sphere::sphere(*radius, net.map_or(SphereNet::for_degree(degree), sphere_net))
        }
        Geometry::Rod { radius, length } => axisymmetric::rod(*radius, *length),
        Geometry::RodSphericalEnd { radius, length } => axisymmetric::rod_spherical_end(*radius, *length),
        Geometry::Cylinder { radius, length } => solid::cylinder(*radius, *length),
        Geometry::HollowCylinder { inner_radius, outer_radius, length } if is_axisymmetric => {
            axisymmetric::hollow_cylinder(*inner_radius, *outer_radius, *length)
        }
        Geometry::HollowCylinder { inner_radius, outer_radius, length } => {
            solid::hollow_cylinder(*inner_radius, *outer_radius, *length)
        }
        Geometry::Box { size } => solid::cuboid(*size),
        Geometry::Rectangle { size } => plane::rectangle(size[0], size[1]),
        Geometry::Disc { radius } => plane::disc(*radius),
        Geometry::Nurbs(net) => {
            let knots = net.degrees.iter().zip(&net.knots).map(|(&p, k)| KnotVector::new(p, k.clone()));
            let knots = knots.collect::<Result<Vec<_>, _>>()?;
            let patch = Patch::new(knots, net.control_points.clone(), net.weights.clone())?;
            let shape = Shape::from_patches(vec![patch])?;
            shape.check_orientation()?;
            Ok(shape)
        }
    }
}

/// The wanted degrees, raised to those of the exact geometry where they are lower.
fn raised(degrees: &[usize], shape: &Shape) -> Vec<usize> {
    let own = |d: usize| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap_or(1);
    degrees.iter().enumerate().map(|(d, &p)| p.max(own(d))).collect()
}

fn sphere_net(net: scenario::SphereNet) -> SphereNet {
    match net {
        scenario::SphereNet::Cube => SphereNet::Cube,
        scenario::SphereNet::Spindle => SphereNet::Spindle,
        scenario::SphereNet::Shells => SphereNet::Shells,
    }
}

/// A place on a body in the model's components.
fn place(shape: &Shape, at: &Place) -> Result<[f64; 3], AppError> {
    match at {
        Place::Point(point) => Ok(*point),
        Place::Marker(name) => shape.markers.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = shape.markers.keys().map(String::as_str).collect();
            AppError::Model(format!("the shape has no marker \"{name}\", it has {}", known.join(", ")))
        }),
    }
}

fn contact(
    contact: &scenario::Contact,
    scenario: &Scenario,
    bodies: &Bodies,
) -> Result<ContactSpec, AppError> {
    let subject = format!("contacts.{}", contact.name);
    let target = &scenario.bodies[contact.target_body];
    let scenario::BodyKind::RigidPlane { normal } = target.kind else {
        let reason =
            "contact between two flexible bodies is not supported yet, choose a rigid plane as target_body";
        return Err(AppError::Model(format!("{subject}: {reason}")));
    };
    let law = SurfaceLaw {
        treatment: match contact.model {
            scenario::ContactModel::Quasistatic => Treatment::Quasistatic,
            scenario::ContactModel::Dynamic => Treatment::Dynamic,
        },
        penalty: Some(match contact.constraint {
            scenario::Constraint::Penalty { value } => value,
            scenario::Constraint::Exact => f64::INFINITY,
        }),
        search: PenaltySearch::Fixed,
        points: match contact.points {
            scenario::ContactPoints::Greville => PointRule::Greville,
            scenario::ContactPoints::Gauss => PointRule::Gauss,
        },
        method: match contact.solver {
            scenario::ContactSolver::ActiveSet => Method::ActiveSet,
            scenario::ContactSolver::Broyden => Method::Broyden(BroydenSettings::default()),
        },
        friction: None,
        interval: IntervalSpec {
            width: contact.interval.width,
            elements: contact.interval.elements,
            ..IntervalSpec::default()
        },
    };
    Ok(ContactSpec {
        name: contact.name.clone(),
        body: bodies.flexible(contact.contact_body, &subject)?.0,
        target: Target::Plane { point: Vector3::from(target.position), normal: Vector3::from(normal) },
        law: ContactLaw::Surface(law),
    })
}
