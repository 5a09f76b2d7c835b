//! Projection along continuous normals over the pieces of a surface (docs/theory.md Eq. C.53).

use iga_core::nurbs::jet::{cross, difference, dot};

use crate::piecewise::{PieceEdge, across};

/// Steps from piece to piece before a projection is given up: a few dozen pieces across a zone, and
/// Newton's steps on the last.
const MAX_STEPS: usize = 80;
/// Change of the parameters at which a projection has converged; errors go with its square.
const CONVERGED: f64 = 1e-11;
/// Parameters that lie outside of a piece by no more than this count as inside, so that points on
/// an edge stay where they are.
pub(in crate::surface_pair) const SLACK: f64 = 1e-9;
/// Longest step \[pieces\]: polynomials tell nothing far beyond their piece.
const LONGEST: f64 = 1.0;

/// Surface and continuous normal at one place.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NormalJet {
    pub point: [f64; 3],
    pub tangents: [[f64; 3]; 2],
    /// The normal, not of unit length, and its derivatives.
    pub normal: [f64; 3],
    pub slopes: [[f64; 3]; 2],
}

/// Where a projection ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    pub piece: u32,
    pub xi: [f64; 2],
    /// Whether the point lies beyond the end of the surface.
    pub is_beyond: bool,
}

/// The place from which the normal leads to `point`: `y(ξ) + γ n(ξ) = x`, by Newton's method from
/// `start`. `jet` evaluates a piece, `neighbours` are those of each, which a foot goes on to when
/// it leaves a piece by more than `slack`. None if it does not converge.
pub(super) fn foot(
    (mut piece, start): (u32, [f64; 2]),
    point: &[f64; 3],
    mut jet: impl FnMut(u32, [f64; 2]) -> NormalJet,
    (neighbours, slack): (&[[Option<PieceEdge>; 4]], f64),
) -> Option<Foot> {
    let mut xi = start;
    for _ in 0..MAX_STEPS {
        let step = newton(&jet(piece, xi), point)?;
        let length = step[0].abs().max(step[1].abs());
        // Asked this way round, a NaN ends it.
        if !length.is_finite() {
            return None;
        }
        let factor = (LONGEST / length).min(1.0);
        let next = [xi[0] + factor * step[0], xi[1] + factor * step[1]];
        match first_crossing(&xi, &next, slack) {
            None => {
                xi = next;
                if length < CONVERGED {
                    return Some(Foot { piece, xi, is_beyond: false });
                }
            }
            Some((edge, u)) => match neighbours[piece as usize][edge] {
                Some(other) => {
                    piece = other.piece;
                    xi = across(other.edge as usize, u.clamp(0.0, 1.0));
                }
                None => {
                    let held = next.map(|x| x.clamp(0.0, 1.0));
                    let moved = (held[0] - xi[0]).abs().max((held[1] - xi[1]).abs());
                    xi = held;
                    if moved < CONVERGED {
                        return Some(Foot { piece, xi, is_beyond: true });
                    }
                }
            },
        }
    }
    None
}

/// Newton's step of the parameters (Eq. C.53); none where the map is singular. The height `γ`
/// follows from the place: it is found anew in each step.
fn newton(at: &NormalJet, point: &[f64; 3]) -> Option<[f64; 2]> {
    let rest = difference(point, &at.point);
    let square = dot(&at.normal, &at.normal);
    let height = dot(&rest, &at.normal) / square;
    let column =
        |a: usize| -> [f64; 3] { std::array::from_fn(|d| at.tangents[a][d] + height * at.slopes[a][d]) };
    let (u, v, n) = (column(0), column(1), at.normal);
    let residual: [f64; 3] = std::array::from_fn(|d| rest[d] - height * n[d]);
    let determinant = dot(&u, &cross(&v, &n));
    // Beyond centres of curvature the map turns inside out.
    (determinant > 0.0)
        .then(|| [dot(&residual, &cross(&v, &n)) / determinant, dot(&u, &cross(&residual, &n)) / determinant])
}

/// The edge of the unit square that the way from `from` to `to` crosses first, and where along it;
/// none if it ends inside.
fn first_crossing(from: &[f64; 2], to: &[f64; 2], slack: f64) -> Option<(usize, f64)> {
    let mut first: Option<(f64, usize)> = None;
    for (edge, a, end) in [(0, 1, 0.0), (1, 0, 1.0), (2, 1, 1.0), (3, 0, 0.0)] {
        let beyond = if end > 0.5 { to[a] - end } else { end - to[a] };
        if beyond <= slack {
            continue;
        }
        let share = ((end - from[a]) / (to[a] - from[a])).clamp(0.0, 1.0);
        if first.is_none_or(|(least, _)| share < least) {
            first = Some((share, edge));
        }
    }
    let (share, edge) = first?;
    let at: [f64; 2] = std::array::from_fn(|a| from[a] + share * (to[a] - from[a]));
    let u = match edge {
        0 => at[0],
        1 => at[1],
        2 => 1.0 - at[0],
        _ => 1.0 - at[1],
    };
    Some((edge, u))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pieces side by side in x, `z = -x²/2` over `0 < x < 2`, whose normals lean by 2 % more
    /// than the surface does.
    fn jet(piece: u32, [s, t]: [f64; 2]) -> NormalJet {
        let x = f64::from(piece) + s;
        NormalJet {
            point: [x, t, -0.5 * x * x],
            tangents: [[1.0, 0.0, -x], [0.0, 1.0, 0.0]],
            normal: [1.02 * x, 0.0, 1.0],
            slopes: [[1.02, 0.0, 0.0], [0.0; 3]],
        }
    }

    /// Edge 1 of the first meets edge 3 of the second.
    const NEIGHBOURS: [[Option<PieceEdge>; 4]; 2] = [
        [None, Some(PieceEdge { piece: 1, edge: 3 }), None, None],
        [None, None, None, Some(PieceEdge { piece: 0, edge: 1 })],
    ];

    fn above(piece: u32, xi: [f64; 2], height: f64) -> [f64; 3] {
        let at = jet(piece, xi);
        std::array::from_fn(|d| at.point[d] + height * at.normal[d])
    }

    #[test]
    fn a_projection_ends_where_the_normal_leads_to_the_point_from_either_piece() {
        for (piece, xi, height) in [(0, [0.3, 0.6], 0.2), (1, [0.7, 0.1], -0.05), (1, [1e-7, 0.5], 0.01)] {
            for start in [(0, [0.5, 0.5]), (1, [0.9, 0.9])] {
                let found =
                    foot(start, &above(piece, xi, height), jet, (&NEIGHBOURS, SLACK)).expect("a foot");
                assert_eq!((found.piece, found.is_beyond), (piece, false));
                let away = (found.xi[0] - xi[0]).abs().max((found.xi[1] - xi[1]).abs());
                // Newton's last step and round-off of a product of three vectors.
                assert!(away < 1e-13, "{away:e}");
            }
        }
    }

    #[test]
    fn points_over_an_edge_stay_on_the_piece_where_they_were() {
        // From a place on the edge, as of the last evaluation: round-off sends no point to the
        // other side.
        for start in [(0, [1.0, 0.5]), (1, [0.0, 0.5])] {
            let found = foot(start, &above(0, [1.0, 0.4], 0.1), jet, (&NEIGHBOURS, SLACK));
            assert_eq!(found.map(|f| f.piece), Some(start.0));
        }
    }

    #[test]
    fn points_beyond_the_end_are_told_and_held_there() {
        let point = above(1, [1.2, 0.4], 0.1);
        let found = foot((0, [0.9, 0.2]), &point, jet, (&NEIGHBOURS, SLACK)).expect("an end");
        assert!(found.is_beyond && found.piece == 1 && found.xi[0] >= 1.0, "{found:?}");
        // From further away the point lies beyond the centre of curvature, where no projection is
        // known.
        assert_eq!(foot((0, [0.2, 0.2]), &point, jet, (&NEIGHBOURS, SLACK)), None);
    }

    #[test]
    fn steps_are_the_derivatives_of_the_foot() {
        let (xi, height, h) = ([0.3, 0.6], 0.2, 1e-5);
        let point = above(0, xi, height);
        for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.5, 0.8]] {
            let moved = |h: f64| -> [f64; 3] { std::array::from_fn(|d| point[d] + h * direction[d]) };
            let place = |h: f64| foot((0, xi), &moved(h), jet, (&NEIGHBOURS, SLACK)).expect("a foot").xi;
            let step = newton(&jet(0, xi), &moved(h)).expect("a step");
            let (after, before) = (place(h), place(-h));
            for a in 0..2 {
                let slope = (after[a] - before[a]) / (2.0 * h);
                // The step is right to its square, h times a second derivative of order one.
                assert!((step[a] / h - slope).abs() < 10.0 * h, "{a}: {} {slope}", step[a] / h);
            }
        }
    }
}
