//! Coefficients of implicit Runge-Kutta methods whose stages share one iteration matrix
//! (docs/theory.md Eq. T.13, T.14, T.18, T.19).

/// Most stages of a method.
pub(super) const MAX_STAGES: usize = 6;

/// An L-stable method with an explicit first stage and the same weight `d` of the implicit rate in
/// all others, whose last stage is the step's end.
#[derive(Debug)]
pub(in crate::integration) struct Tableau {
    /// Times of the stages, as shares of the step.
    pub nodes: &'static [f64],
    /// Weights of earlier rates, a row per stage from the second on.
    pub weights: &'static [&'static [f64]],
    /// Weight of the implicit rate.
    pub diagonal: f64,
    /// Weights of the solution minus those of the embedded one.
    pub error: &'static [f64],
    /// Power of the step with which the error estimate grows.
    pub order: f64,
    /// Time that the continuous extension passes through, as a share of the step.
    pub middle: f64,
    /// Its value there: weights of the states of the stages from the second to the last but one.
    pub middle_weights: &'static [f64],
}

/// End of the trapezoidal part of TR-BDF2, with which both parts have the same iteration matrix
/// (Bank et al. 1985).
const GAMMA: f64 = 2.0 - std::f64::consts::SQRT_2;
/// Weight of the implicit rate in both stages (Hosea & Shampine 1996).
const D: f64 = 0.5 * GAMMA;
/// Weight of the two earlier rates in the last stage (same source).
const W: f64 = 0.25 * std::f64::consts::SQRT_2;

/// A step of the trapezoidal rule and one of the second backward difference formula, order two,
/// with an embedded one of order three (Bank et al. 1985; Hosea & Shampine 1996; the method behind
/// *ode23tb*).
pub(in crate::integration) static TR_BDF2: Tableau = Tableau {
    nodes: &[0.0, GAMMA, 1.0],
    weights: &[&[D], &[W, W]],
    diagonal: D,
    error: &[(4.0 * W - 1.0) / 3.0, -1.0 / 3.0, 2.0 * D / 3.0],
    order: 3.0,
    middle: GAMMA,
    middle_weights: &[1.0],
};

/// ESDIRK4(3)6L\[2\]SA, the implicit half of ARK4(3)6L\[2\]SA: order four, stages of order two,
/// embedded order three (Kennedy & Carpenter, *Appl. Numer. Math.* 44 (2003), 139-181).
pub(in crate::integration) static ESDIRK4: Tableau = Tableau {
    nodes: &[0.0, 0.5, 83.0 / 250.0, 31.0 / 50.0, 17.0 / 20.0, 1.0],
    weights: &[
        &[0.25],
        &[8611.0 / 62500.0, -1743.0 / 31250.0],
        &[5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0],
        &[
            15267082809.0 / 155376265600.0,
            -71443401.0 / 120774400.0,
            730878875.0 / 902184768.0,
            2285395.0 / 8070912.0,
        ],
        &[82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0],
    ],
    diagonal: 0.25,
    error: &[
        82889.0 / 524892.0 - 4586570599.0 / 29645900160.0,
        0.0,
        15625.0 / 83664.0 - 178811875.0 / 945068544.0,
        69875.0 / 102672.0 - 814220225.0 / 1159782912.0,
        -2260.0 / 8211.0 + 3700637.0 / 11593932.0,
        0.25 - 61727.0 / 225920.0,
    ],
    order: 4.0,
    middle: 0.5,
    middle_weights: &MIDDLE_OF_ESDIRK4,
};

/// Stages have order two only; this combination is exact for cubics, and stays bounded for
/// unresolved modes as the stages do (Eq. T.19).
const MIDDLE_OF_ESDIRK4: [f64; 4] =
    [-0.146_949_006_930_379_18, 0.322_902_310_509_678_8, 1.018_125_024_267_909, -0.194_078_327_847_208_7];

impl Tableau {
    /// Number of stages.
    pub fn n_stages(&self) -> usize {
        self.nodes.len()
    }

    /// Weights of all rates in stage `i`, the implicit one included.
    #[cfg(test)]
    fn row(&self, i: usize) -> Vec<f64> {
        let mut row = vec![0.0; self.n_stages()];
        if i > 0 {
            row[..i].copy_from_slice(self.weights[i - 1]);
            row[i] = self.diagonal;
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of fractions of some ten digits.
    const ROUND_OFF: f64 = 1e-14;

    fn methods() -> [(&'static Tableau, usize); 2] {
        [(&TR_BDF2, 2), (&ESDIRK4, 4)]
    }

    /// Left and right sides of the conditions up to order four (Butcher; Hairer, Nørsett & Wanner
    /// I, II.2), with their orders.
    fn conditions(t: &Tableau, b: &[f64]) -> Vec<(usize, f64, f64)> {
        let n = t.n_stages();
        let rows: Vec<Vec<f64>> = (0..n).map(|i| t.row(i)).collect();
        let c = t.nodes;
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        let apply = |v: &[f64]| rows.iter().map(|r| dot(r, v)).collect::<Vec<f64>>();
        let power = |k: i32| c.iter().map(|c| c.powi(k)).collect::<Vec<f64>>();
        let times = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).collect::<Vec<f64>>();
        let ac = apply(&power(1));
        vec![
            (1, b.iter().sum(), 1.0),
            (2, dot(b, c), 1.0 / 2.0),
            (3, dot(b, &power(2)), 1.0 / 3.0),
            (3, dot(b, &ac), 1.0 / 6.0),
            (4, dot(b, &power(3)), 1.0 / 4.0),
            (4, dot(b, &times(c, &ac)), 1.0 / 8.0),
            (4, dot(b, &apply(&power(2))), 1.0 / 12.0),
            (4, dot(b, &apply(&ac)), 1.0 / 24.0),
        ]
    }

    #[test]
    fn rows_sum_to_the_nodes_and_stages_have_order_two() {
        for (t, _) in methods() {
            for i in 0..t.n_stages() {
                let row = t.row(i);
                let sum: f64 = row.iter().sum();
                assert!((sum - t.nodes[i]).abs() < ROUND_OFF, "stage {i}: {sum} {}", t.nodes[i]);
                let moment: f64 = row.iter().zip(t.nodes).map(|(a, c)| a * c).sum();
                assert!((moment - 0.5 * t.nodes[i].powi(2)).abs() < ROUND_OFF, "stage {i}: {moment}");
            }
        }
    }

    #[test]
    fn order_conditions_hold() {
        for (t, order) in methods() {
            let b = t.row(t.n_stages() - 1);
            let embedded: Vec<f64> = b.iter().zip(t.error).map(|(b, e)| b - e).collect();
            for (weights, order) in [(b, order), (embedded, 3)] {
                for (of, left, right) in conditions(t, &weights) {
                    let holds = (left - right).abs() < ROUND_OFF;
                    assert!(holds || of > order, "order {order}: {of} {left} {right}");
                }
            }
        }
    }

    #[test]
    fn continuous_extensions_pass_through_what_the_stages_say_to_their_order() {
        for (t, order) in methods() {
            // State of a stage where the solution is the power m of time: m times the weighted
            // powers m - 1.
            let stage = |i: usize, m: i32| {
                let row = t.row(i);
                f64::from(m) * row.iter().zip(t.nodes).map(|(a, c)| a * c.powi(m - 1)).sum::<f64>()
            };
            assert!((t.middle_weights.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF);
            for m in 1..=if order == 4 { 3 } else { 2 } {
                let sum: f64 = t.middle_weights.iter().enumerate().map(|(i, w)| w * stage(i + 1, m)).sum();
                assert!((sum - t.middle.powi(m)).abs() < ROUND_OFF, "power {m}: {sum}");
            }
        }
    }

    #[test]
    fn stiff_components_are_damped_and_none_grows() {
        for (t, order) in methods() {
            // Amplification of y' = i w y over a step of size 1, by the stages.
            let amplification = |w: f64| {
                let mut rates: Vec<nalgebra::Complex<f64>> = Vec::new();
                let mut state = nalgebra::Complex::new(1.0, 0.0);
                let i_w = nalgebra::Complex::new(0.0, w);
                for i in 0..t.n_stages() {
                    let base: nalgebra::Complex<f64> = if i == 0 {
                        nalgebra::Complex::new(1.0, 0.0)
                    } else {
                        t.weights[i - 1]
                            .iter()
                            .zip(&rates)
                            .map(|(a, k)| k * *a)
                            .sum::<nalgebra::Complex<f64>>()
                            + 1.0
                    };
                    let rate = if i == 0 { i_w } else { i_w * base / (1.0 - i_w * t.diagonal) };
                    state = if i == 0 { base } else { base + rate * t.diagonal };
                    rates.push(rate);
                }
                state.norm()
            };
            assert!(
                (1..2000).all(|k| amplification(0.01 * f64::from(k)) < 1.0 + 1e-14),
                "A-stable on the axis"
            );
            assert!(amplification(1e6) < 1e-5, "L-stable");
            // Damping is of the order after the method's own, rounded up to even.
            let loss = |w: f64| 1.0 - amplification(w);
            let rate = (loss(0.4) / loss(0.2)).log2();
            let expected = f64::from(order as u32 + 2);
            assert!((rate - expected).abs() < 0.3, "{rate} {expected}");
        }
    }
}
