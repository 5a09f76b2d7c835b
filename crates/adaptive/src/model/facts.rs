//! What is asked of a contact beside its force, answered once for every law.

use std::f64::consts::PI;

use contact_qs::Sphere;
use iga_core::elasticity::Material;

use super::BodyModel;
use crate::error::AdaptiveError;
use crate::impact::AdaptiveContact;
use crate::spec::{ContactSpec, HertzPartner, HertzSphere, LocalField, RunSpec, Target};
use crate::touch::hertz::contact_modulus;
use crate::touch::wave::wave_speed;
use crate::uncertainty::zone::ZoneEstimate;

/// The parts of a contact that do not change in a run.
pub struct ContactFacts {
    /// Name.
    pub name: String,
    /// Index of the contact body.
    pub body: usize,
    /// Widths of the contact interval \[m\]; zero where there is none.
    pub widths: [f64; 2],
    /// Size of the contact body, by Hertz's law of the smaller one \[m\].
    pub size: f64,
    /// Approach of the bodies from which on it is none: half of that size by Hertz's law, the radius
    /// of spheres \[m\].
    pub deepest: f64,
    /// What the contact body meets.
    pub target: Target,
    /// Overlap at the start that is allowed \[m\].
    pub allowed_overlap: f64,
    /// Growth of its force per closing speed [s/m].
    pub damping: f64,
    /// Whether it has friction.
    pub has_friction: bool,
    /// The sphere that meets another one, or a plane, by Hertz's law; none of other surfaces.
    pub spheres: Option<(Sphere, Target<Sphere>)>,
    /// A flexible body whose surface meets another by Hertz's law: its modes yield at the touch,
    /// too.
    pub flexible_under_hertz: Option<usize>,
    /// Speed of waves in the slower of the materials that meet; infinite between rigid ones [m/s].
    pub wave_speed: f64,
    /// Time that a wave takes to run to and fro through the flexible body that is crossed soonest;
    /// infinite of none \[s\].
    pub round_trip: f64,
    /// Modulus `E*` of the materials that meet; infinite between rigid ones \[Pa\].
    pub modulus: f64,
    /// Yield strength of the weaker material that it presses; infinite where none is known \[Pa\].
    pub yield_strength: f64,
    /// What displacement, strain and stress of the bodies hold of its forces.
    pub local_field: LocalField,
    /// How the yield at its touch is known.
    pub zone: ZoneEstimate,
    /// Whether its forces act on the interfaces that its bodies were reduced for: quasistatic ones
    /// with one model for the whole run.
    pub loads_interface: bool,
    /// What refines it when its bodies touch; none of a contact that has one model for the whole
    /// run.
    pub refinement: Option<AdaptiveContact>,
}

impl ContactFacts {
    /// What the law of `contact` and its `bodies` tell; `zone_width`: of the zone on the contact body, if it has
    /// one from the start \[m\]; `size` as [`ContactFacts::size`].
    ///
    /// # Errors
    /// [`AdaptiveError`] if the centre of a sphere is no place of its body.
    pub fn new(
        run: &RunSpec,
        contact: &ContactSpec,
        bodies: &[BodyModel],
        size: f64,
        zone_width: Option<f64>,
    ) -> Result<Self, AdaptiveError> {
        let hertz = contact.law.hertz();
        let spheres = spheres(contact, bodies)?;
        let materials = || contact.bodies().filter_map(|body| Some((body, material(&bodies[body])?)));
        let round_trip = |(body, material): (usize, &Material)| {
            Some(2.0 * bodies[body].flexible()?.body.size() / material.bar_speed())
        };
        let has_modes = |body: &usize| bodies[*body].data.n_modes() > 0;
        let partner = |side: usize| hertz.map(|law| if side == 0 { &law.contact } else { &law.target });
        let waves = contact.bodies().enumerate();
        let waves = waves.map(|(side, body)| slowest_wave(run, bodies, body, partner(side)));
        let local_field = contact.law.local_field();
        Ok(Self {
            name: contact.name.clone(),
            body: contact.body,
            widths: [zone_width.unwrap_or(0.0), 0.0],
            size,
            deepest: if hertz.is_some() { 0.5 * size } else { size },
            target: contact.target,
            allowed_overlap: contact.initial_overlap,
            damping: contact.damping,
            has_friction: contact.law.has_friction(),
            flexible_under_hertz: (hertz.is_some() && spheres.is_none())
                .then(|| contact.bodies().find(has_modes))
                .flatten(),
            spheres,
            wave_speed: waves.fold(f64::INFINITY, f64::min),
            round_trip: materials().filter_map(round_trip).fold(f64::INFINITY, f64::min),
            modulus: modulus(contact, bodies),
            yield_strength: hertz.map_or_else(
                || {
                    let of_bodies = contact.bodies().map(|body| run.bodies[body].kind.yield_strength());
                    of_bodies.fold(f64::INFINITY, f64::min)
                },
                |law| law.yield_strength,
            ),
            local_field,
            zone: ZoneEstimate::of(&contact.law),
            loads_interface: local_field == LocalField::Static && zone_width.is_some(),
            refinement: None,
        })
    }
}

/// The material with the slowest waves of a flexible body.
fn material(body: &BodyModel) -> Option<&Material> {
    body.flexible().and_then(|flexible| flexible.body.slowest_material())
}

/// The spheres of a contact by Hertz's law; none of other surfaces.
///
/// # Errors
/// [`AdaptiveError`] if a centre is no place of its body.
pub fn spheres(
    contact: &ContactSpec,
    bodies: &[BodyModel],
) -> Result<Option<(Sphere, Target<Sphere>)>, AdaptiveError> {
    let (Some(law), Some((own, other))) = (contact.law.hertz(), contact.spheres()) else { return Ok(None) };
    let sphere = |(body, sphere): (usize, &HertzSphere), solid| -> Result<Sphere, AdaptiveError> {
        Ok(Sphere { body, centre: bodies[body].point(&sphere.centre)?, radius: sphere.radius, solid })
    };
    let [own_solid, solid] = law.solids();
    Ok(Some((sphere((contact.body, own), own_solid)?, other.try_map(|other| sphere(other, solid))?)))
}

/// Largest density of a solid, that of osmium: a body that would be denser is more than its shape,
/// or the sphere of Hertz's law, of which its volume is taken [kg/m³].
const DENSEST: f64 = 2.26e4;

/// Speed of waves in body `index`: those of its material, or of the one that Hertz's law has for it,
/// the `partner`; infinite of a rigid one [m/s].
fn slowest_wave(run: &RunSpec, bodies: &[BodyModel], index: usize, partner: Option<&HertzPartner>) -> f64 {
    let of_material = material(&bodies[index]).map(Material::bar_speed);
    let of_partner = |partner: &HertzPartner| {
        let of_shape = run.bodies[index].kind.rigid().and_then(|rigid| rigid.density);
        let of_sphere =
            |sphere: &HertzSphere| bodies[index].data.mass / (4.0 / 3.0 * PI * sphere.radius.powi(3));
        let density = of_shape.or_else(|| partner.sphere.as_ref().map(of_sphere));
        Some(wave_speed(partner.solid.young, density?.min(DENSEST)))
    };
    of_material.or_else(|| of_partner(partner?)).unwrap_or(f64::INFINITY)
}

/// Modulus `E*` of the two materials that meet \[Pa\].
fn modulus(contact: &ContactSpec, bodies: &[BodyModel]) -> f64 {
    let of_body = |body: usize| {
        material(&bodies[body]).map_or((f64::INFINITY, 0.0), |m| (m.youngs_modulus(), m.poissons_ratio()))
    };
    match contact.law.hertz() {
        Some(law) => contact_modulus(&law.solids().map(|solid| (solid.young, solid.poisson))),
        None => contact_modulus(&contact.bodies().map(of_body).collect::<Vec<_>>()),
    }
}
