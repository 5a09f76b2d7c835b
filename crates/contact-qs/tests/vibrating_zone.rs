//! Contacts whose zones vibrate, against the same contacts with those modes among the bodies' coordinates.

use crate::pair_support::{N_MODES, forces, random_bodies, random_pair};
use contact_qs::quasistatic::Method;
use contact_qs::{ActiveContact, VibratingContact, ZoneVibration};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, Motion};

const N_LOW: usize = 1;
const N_ZONE: usize = N_MODES - N_LOW;
const MOTIONS: [RigidMotion; 3] = [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial];

fn zone(body: usize) -> ZoneVibration {
    let omega = vec![3.0 + body as f64, 7.0];
    ZoneVibration { body, n_low: N_LOW, mass: 2.0, damping: vec![0.5, 14.0], omega }
}

/// The motions without the modes of the zones, and those: coordinates of both zones, then their rates.
fn split(bodies: &[BodyState], zones: [usize; 2]) -> (Vec<BodyState>, Vec<f64>) {
    let mut internal: Vec<f64> = zones.iter().flat_map(|b| bodies[*b].elastic[N_LOW..].to_vec()).collect();
    internal.extend(zones.iter().flat_map(|b| bodies[*b].elastic_rates[N_LOW..].to_vec()));
    let low = bodies.iter().map(|b| BodyState {
        elastic: b.elastic[..N_LOW].to_vec(),
        elastic_rates: b.elastic_rates[..N_LOW].to_vec(),
        ..b.clone()
    });
    (low.collect(), internal)
}

#[test]
fn forces_are_those_of_the_same_contact_with_all_modes_in_the_bodies() {
    for motion in MOTIONS {
        let plain = random_pair(motion, [false; 2], 1e10, Method::ActiveSet, 3);
        let mut bodies = random_bodies(&plain, motion, 2e-3, 3);
        for (i, body) in bodies.iter_mut().enumerate() {
            body.elastic_rates.iter_mut().enumerate().for_each(|(j, v)| *v = 0.1 + (i + 3 * j) as f64);
        }
        let mut plain = Active::new(plain);
        let pair = random_pair(motion, [false; 2], 1e10, Method::ActiveSet, 3);
        let zones = [2, 0];
        let vibrating = VibratingContact::new(pair, zones.map(zone).to_vec(), 3).unwrap();
        let mut vibrating = Active::new(vibrating);
        assert_eq!(vibrating.n_coordinates(), 2 * N_ZONE);
        let (low, internal) = split(&bodies, zones);
        let seen = Motion { time: 0.0, bodies: &low, internal: &internal };
        let (mut expected, mut found) = (forces(3, N_MODES), forces(3, N_LOW));
        plain.evaluate(Motion::new(0.0, &bodies), &mut expected).unwrap();
        vibrating.evaluate(seen, &mut found).unwrap();
        assert!(plain.report().normal_force > 0.0);
        let rates = vibrating.accelerations().to_vec();
        // The same operations on the same numbers: all bits.
        for (a, b) in expected.iter().zip(&found) {
            assert_eq!(
                (a.force, a.torque_in_body, &a.elastic[..N_LOW]),
                (b.force, b.torque_in_body, &b.elastic[..])
            );
        }
        assert_eq!(
            plain.meeting(Motion::new(0.0, &bodies)).gap.to_bits(),
            vibrating.meeting(seen).gap.to_bits()
        );
        assert_eq!(plain.meeting(Motion::new(0.0, &bodies)).normal, vibrating.meeting(seen).normal);
        let (mut elastic, mut kinetic, mut lost) = (0.0, 0.0, 0.0);
        for (k, body) in zones.into_iter().enumerate() {
            let zone = zone(body);
            for j in 0..N_ZONE {
                let (q, v) = (internal[N_ZONE * k + j], internal[2 * N_ZONE + N_ZONE * k + j]);
                let load = expected[body].elastic[N_LOW + j];
                let exact = load - zone.damping[j] * v - zone.omega[j].powi(2) * q;
                let found = rates[N_ZONE * k + j];
                assert!((found - exact).abs() <= 1e-14 * load.abs().max(1.0), "{found} {exact}"); // round-off
                elastic += 0.5 * (zone.omega[j] * q).powi(2);
                kinetic += 0.5 * v * v;
                lost += zone.damping[j] * v * v;
            }
        }
        let (energies, contact) = (vibrating.energies(), plain.energies());
        assert_eq!(energies.penalty.to_bits(), contact.penalty.to_bits());
        assert!((energies.elastic_high / elastic - 1.0).abs() < 1e-14);
        assert!((energies.kinetic / kinetic - 1.0).abs() < 1e-14);
        assert!((energies.dissipated_power / lost - 1.0).abs() < 1e-14);
        // Twice the energy over the mass, its root.
        let speed = vibrating.coordinate_speed(&internal);
        assert!((speed * speed / (2.0 * (elastic + kinetic) / 2.0) - 1.0).abs() < 1e-14, "{speed}");
    }
}

#[test]
fn zones_that_do_not_belong_to_the_contact_are_refused() {
    let pair = || random_pair(RigidMotion::Spatial, [false; 2], 1e10, Method::ActiveSet, 3);
    let refusal = |zone: ZoneVibration, n: usize| match VibratingContact::new(pair(), vec![zone], n) {
        Err(error) => error.to_string(),
        _ => panic!("a contact"),
    };
    assert!(refusal(zone(1), 3).contains("body 1 takes no part"));
    assert!(refusal(zone(2), 2).contains("2 of 2"));
    assert!(refusal(zone(2), 3).contains("a body of the contact has no vibrating zone"));
    assert!(
        refusal(ZoneVibration { damping: vec![1.0], ..zone(2) }, 3)
            .contains("damping coefficients of a contact zone: 1, must be 2")
    );
}
