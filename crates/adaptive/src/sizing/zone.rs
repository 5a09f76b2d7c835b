//! Fine elements where a body meets a plane, for contacts that keep one model for the whole run and
//! say nothing of it.

use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Model;
use nalgebra::Vector3;

use super::ChosenZone;
use super::extent::extent;
use super::impact_time::{Impact, Scene};
use crate::body::fine::refined::ELEMENTS;
use crate::spec::{ContactSpec, IntervalSpec, RefinementSpec, RunSpec, SurfaceLaw};
use crate::surface::SurfacePlace;
use crate::touch::first::FirstTouches;
use crate::touch::hertz::{HertzLaw, LocalSurface, across_line, hertz_impact, interval_width, line_impact};
use crate::touch::tolerances::FACING;

/// Growth of elements outside a zone.
const RATIO: f64 = 1.5;
/// Part of a body's size below which coordinates of a place count as zero.
const ROUND_OFF: f64 = 1e-14;

/// The zones that contacts need on body `index` and nobody has given.
pub(super) fn zones(touches: &FirstTouches<'_>, index: usize) -> Vec<ChosenZone> {
    let spec = touches.spec;
    let is_refined = spec.bodies[index].elastic().is_some_and(|e| !e.discretisation.refine.is_empty());
    let contacts = spec.contacts.iter().filter(|_| !is_refined);
    contacts.filter_map(|contact| zone(touches, contact, index)).collect()
}

/// The zone that `contact` needs on body `index`.
fn zone(touches: &FirstTouches<'_>, contact: &ContactSpec, index: usize) -> Option<ChosenZone> {
    let law = contact.law.surface()?;
    if !keeps_its_model(touches.spec, contact, law) {
        return None;
    }
    let (touch, sites) = (touches.of(contact)?, touches.at_start(contact)?.ok()?);
    let scene = Scene::at(touches, Some(&touch));
    let site = sites.on(contact, index).next()?;
    let elastic = scene.spec.bodies[index].elastic()?;
    let touch = predicted(&scene, contact)?;
    let from_axis = elastic.model == Model::Axisymmetric;
    let width = interval_width(touch.half_width, IntervalSpec::default().target_utilisation, from_axis);
    // A place on an axis or at an end is found but for round-off.
    let round_off = ROUND_OFF * scene.size(index);
    let centre = site.point.map(|x| if x.abs() < round_off { 0.0 } else { x });
    let refinement =
        RefinementSpec { centre, width, elements: law.interval.elements_or(ELEMENTS), ratio: RATIO };
    let reason = format!("zone of contact \"{}\" for a force of {:.3e} N", contact.name, touch.force);
    Some(ChosenZone { refinement, reason })
}

/// Whether a contact of surfaces has one model for the whole run, with a zone that is refined
/// beforehand: with a mesh, and with a plane where the zone is part of the modes.
fn keeps_its_model(spec: &RunSpec, contact: &ContactSpec, law: &SurfaceLaw) -> bool {
    let has_mesh = contact.bodies().any(|body| spec.bodies[body].kind.brings_mesh());
    let is_part_of_modes = law.treatment.is_vibrating() && contact.target.body().is_none();
    let keeps = law.treatment.interface_modes().is_some() && (has_mesh || is_part_of_modes);
    keeps && law.interval.width.is_none()
}

/// The first touch of a contact as Hertz's theory and the motions at the start have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedZone {
    /// Half extent of the contact at the peak force \[m\].
    pub half_width: f64,
    /// Full width of the zone that it needs \[m\].
    pub width: f64,
    /// Peak force \[N\].
    pub force: f64,
    /// Approach of the bodies under it; infinite where Hertz's theory of points does not apply
    /// \[m\].
    pub approach: f64,
    /// Its places on the contact body and on the target.
    pub sites: [Option<SurfacePlace>; 2],
}

/// The zone of the first touch of `contact`; `None` where Hertz's theory has no answer.
pub fn predicted_zone(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Option<PredictedZone> {
    let touch = touches.of(contact)?;
    let Extent { half_width, force, approach } = predicted(&Scene::at(touches, Some(&touch)), contact)?;
    let sites = touch.sites;
    let width = interval_width(half_width, IntervalSpec::default().target_utilisation, false);
    Some(PredictedZone {
        half_width,
        width,
        force,
        approach,
        sites: [Some(sites.contact_body), sites.target],
    })
}

/// The line along which the bodies of a contact touch first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine {
    /// Half width of the contact at the peak force \[m\].
    pub half_width: f64,
    /// Full width of the zone that it needs \[m\].
    pub width: f64,
    /// Unit vector across the line, in space.
    pub across: Vector3<f64>,
    /// From the target to the contact body, in space.
    pub normal: Vector3<f64>,
}

/// The line of the first touch of `contact` between spatial bodies; `None` if they touch otherwise,
/// or nothing is known of it.
pub fn predicted_line(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Option<PredictedLine> {
    if touches.spec.bodies[contact.body].kind.motion() != RigidMotion::Spatial {
        return None;
    }
    let touch = touches.of(contact)?;
    let scene = Scene::at(touches, Some(&touch));
    let Impact { meeting, speed, inverse_mass, .. } = scene.impact(contact);
    let (surfaces, size) = (meeting.surfaces?, scene.size(contact.body));
    let (curvature, across) = across_line(&surfaces, size).filter(|_| meeting.miss <= FACING)?;
    let along = meeting.normal.cross(&across).try_normalize(0.0)?;
    let length = contact
        .bodies()
        .map(|body| extent(scene.spec, scene.poses, body, &along))
        .fold(f64::INFINITY, f64::min);
    let compliance = surfaces[0].compliance + surfaces[1].compliance;
    let (half_width, _) = line_impact(curvature, compliance, inverse_mass * length, speed, size)?;
    let width = interval_width(half_width, IntervalSpec::default().target_utilisation, false);
    Some(PredictedLine { half_width, width, across, normal: meeting.normal })
}

/// Half extent and force of a contact.
struct Extent {
    half_width: f64,
    force: f64,
    approach: f64,
}

fn predicted(scene: &Scene<'_>, contact: &ContactSpec) -> Option<Extent> {
    let impact = scene.impact(contact);
    match scene.thickness(contact.body) {
        Some(thickness) => {
            let (half_width, force) = line_contact(&impact, thickness, scene.size(contact.body))?;
            Some(Extent { half_width, force, approach: f64::INFINITY })
        }
        None => point_contact(&impact),
    }
}

/// Half extent and force of a contact at a point: under Hertz's peak force, or the one that waves
/// allow if that is smaller.
fn point_contact(impact: &Impact) -> Option<Extent> {
    let surfaces = impact.meeting.surfaces.as_ref()?;
    let hertz = hertz_impact(surfaces, impact.inverse_mass, impact.speed)?;
    let waves = if impact.mobility > 0.0 { impact.speed / impact.mobility } else { f64::INFINITY };
    let force = hertz.peak_force.min(waves);
    let law = HertzLaw::new(surfaces)?;
    let half_width = law.at_force(force).semi_axes[0];
    Some(Extent { half_width, force, approach: law.at_force(force).approach })
}

fn line_contact(impact: &Impact, thickness: f64, size: f64) -> Option<(f64, f64)> {
    let surfaces = impact.meeting.surfaces.as_ref()?;
    let curvature = surfaces.iter().map(LocalSurface::in_plane).sum();
    let compliance = surfaces.iter().map(|s| s.compliance).sum();
    let (half, force) =
        line_impact(curvature, compliance, impact.inverse_mass * thickness, impact.speed, size)?;
    Some((half, force * thickness))
}
