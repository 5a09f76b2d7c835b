//! Transfer of states between coarse and fine models.

use crate::bodies::{rod, sphere, wanted_at};
use adaptive::body::field_body::FieldBody;
use adaptive::body::fine::refined::{FineBody, FineSettings};
use adaptive::paper::transfer::StateTransfer;
use adaptive::spec::LowModes;
use adaptive::spec::PointRule;
use adaptive::spec::TransferMethod;
use ffr_dynamics::reduction::modal::ReducedBasis;

/// Random numbers in (-1, 1): a linear congruential generator.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Energy `½ (q̇ᵀ q̇ + qᵀ diag(ω²) q)` of mass-orthonormal coordinates \[J\].
fn elastic_energy(basis: &ReducedBasis, q: &[f64], rates: &[f64]) -> f64 {
    let terms = q.iter().zip(rates).zip(&basis.omega);
    0.5 * terms.map(|((q, v), omega)| v * v + (omega * q).powi(2)).sum::<f64>()
}

/// Momenta of the elastic coordinates along the body's rigid modes, `Rᵀ M Φ q̇` with mass-orthonormal `R`: zero in a
/// mean-axis frame [kg^½ m/s].
fn elastic_momenta(basis: &ReducedBasis, rates: &[f64]) -> Vec<f64> {
    let along = basis.rigid.mass_modes.transpose() * &basis.shapes;
    let momentum = |i: usize| rates.iter().enumerate().map(|(j, v)| along[(i, j)] * v).sum();
    (0..along.nrows()).map(momentum).collect()
}

/// Largest error of coarse → fine → coarse, and largest relative energy jump of coarse → fine, over random states in
/// which all modes have the same energy on average.
fn round_trip(is_rod: bool, modes: LowModes, method: TransferMethod) -> (f64, f64) {
    let (body, place) = if is_rod { (rod([3, 60]), [0.0; 3]) } else { (sphere([8, 8]), [0.0, -0.01, 0.0]) };
    let coarse = body.reduce(&Default::default()).unwrap();
    let wanted = [wanted_at(&body, place, 0.3e-3)];
    let fine = FineBody::build(&body, &wanted, &FineSettings::default()).unwrap();
    let zone = fine.zone(0, PointRule::Greville).unwrap();
    let (basis, _) = fine.reduce((&body, &coarse), &zone.unknowns, modes).unwrap();
    let transfer = StateTransfer::new(method, (&body, &coarse.basis), (&fine, &basis)).unwrap();
    let (mut error, mut jump, mut seed) = (0.0f64, 0.0f64, 7);
    for _ in 0..20 {
        let rates: Vec<f64> = coarse.basis.omega.iter().map(|_| random(&mut seed)).collect();
        let q: Vec<f64> = coarse.basis.omega.iter().map(|w| random(&mut seed) / w).collect();
        let (fine_q, fine_rates) = (transfer.fine(&q), transfer.fine(&rates));
        let before = elastic_energy(&coarse.basis, &q, &rates);
        jump = jump.max((elastic_energy(&basis, &fine_q, &fine_rates) / before - 1.0).abs());
        for (a, b) in transfer.coarse(&fine_rates).iter().zip(&rates) {
            error = error.max((a - b).abs());
        }
        // Mean-axis frames: elastic coordinates carry no momentum. Prolonged modes are weighed by the fine model's finer
        // quadrature; their momentum in the equations of motion is that of the coarse data, which stay in force.
        let momenta = [elastic_momenta(&coarse.basis, &rates), elastic_momenta(&basis, &fine_rates)];
        assert!(momenta[0].iter().all(|p| p.abs() < 1e-10), "{momenta:?}");
        assert!(momenta[1].iter().all(|p| p.abs() < 1e-5), "{momenta:?}");
    }
    (error, jump)
}

#[test]
fn prolonged_modes_transfer_without_loss() {
    for is_rod in [false, true] {
        for method in [TransferMethod::MassOrthogonal, TransferMethod::Printed] {
            let (error, jump) = round_trip(is_rod, LowModes::Prolonged, method);
            assert!(error < 1e-10 && jump < 1e-10, "{method:?}: {error:.1e}, {jump:.1e}");
        }
    }
}

#[test]
fn own_modes_of_the_fine_model_lose_what_they_cannot_represent() {
    // Round trip and jump of energy. The coarse modes are good to the coarse model's discretisation error only, which the
    // rod's mesh makes smaller; a projection loses its square, least squares on control values weigh small elements like large
    // ones. Bounds are twice what came out (docs/decisions/0008-modes-of-fine-models.md).
    for (is_rod, method, limits) in [
        (false, TransferMethod::MassOrthogonal, (1e-4, 2e-4)),
        (false, TransferMethod::Printed, (2e-2, 2e-3)),
        (true, TransferMethod::MassOrthogonal, (1e-6, 2e-6)),
        (true, TransferMethod::Printed, (2e-3, 2e-4)),
    ] {
        let (error, jump) = round_trip(is_rod, LowModes::Fine, method);
        assert!(error < limits.0 && jump < limits.1, "{is_rod} {method:?}: {error:.1e}, {jump:.1e}");
        // They do lose it: coordinates return to round-off with prolonged modes alone.
        assert!(error > 1e-9, "{is_rod} {method:?}: {error:.1e}");
    }
}
