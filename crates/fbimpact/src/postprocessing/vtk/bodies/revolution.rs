//! Revolving a section about the body's z axis: rational quadratic arcs, exact in both cell kinds.

/// One node of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcNode {
    /// Factors that take a radial component to x and y.
    pub direction: [f64; 2],
    /// Weight.
    pub weight: f64,
    /// Angle of the sample that belongs to the node \[rad\].
    pub angle: f64,
}

impl ArcNode {
    /// No revolution: the section in the x-z plane.
    pub const SECTION: Self = Self { direction: [1.0, 0.0], weight: 1.0, angle: 0.0 };

    fn on_circle(angle: f64) -> Self {
        Self { direction: [angle.cos(), angle.sin()], weight: 1.0, angle }
    }
}

/// Arcs of at most a quarter turn that revolve a section by `degrees`, three control nodes each.
///
/// They run backwards, from the x axis towards −y: so the cells of a positively oriented
/// section become positively oriented.
pub fn arcs(degrees: f64) -> Vec<Vec<ArcNode>> {
    let total = degrees.to_radians();
    let n = (degrees / 90.0 - 1e-9).ceil().max(1.0) as usize;
    let step = -total / n as f64;
    let arc = |i: usize| {
        let (from, middle) = (i as f64 * step, (i as f64 + 0.5) * step);
        let weight = (0.5 * step).cos();
        // The control point lies outside the circle, where the end tangents meet.
        let control =
            ArcNode { direction: [middle.cos() / weight, middle.sin() / weight], weight, angle: middle };
        vec![ArcNode::on_circle(from), control, ArcNode::on_circle(from + step)]
    };
    (0..n).map(arc).collect()
}

/// The same with `cells` linear cells an arc: all nodes on the circle.
pub fn polygon(degrees: f64, cells: usize) -> Vec<Vec<ArcNode>> {
    let split = |arc: Vec<ArcNode>| {
        let (from, to) = (arc[0].angle, arc[2].angle);
        let node = |i: usize| ArcNode::on_circle(from + (to - from) * i as f64 / cells as f64);
        (0..=cells).map(node).collect()
    };
    arcs(degrees).into_iter().map(split).collect()
}

/// `points` nodes a quarter turn, or part of one, in the middles of equal sectors.
pub fn rings(degrees: f64, points: usize) -> Vec<ArcNode> {
    let middles = |arc: Vec<ArcNode>| {
        let (from, to) = (arc[0].angle, arc[2].angle);
        (0..points).map(move |i| ArcNode::on_circle(from + (to - from) * (i as f64 + 0.5) / points as f64))
    };
    arcs(degrees).into_iter().flat_map(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_lie_on_the_circle() {
        for degrees in [360.0, 270.0, 90.0, 17.0] {
            for arc in arcs(degrees) {
                for t in [0.0, 0.2, 0.5, 0.9] {
                    let b = [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
                    let w: f64 = arc.iter().zip(b).map(|(n, b)| n.weight * b).sum();
                    let at = |c: usize| {
                        arc.iter().zip(b).map(|(n, b)| n.weight * b * n.direction[c]).sum::<f64>() / w
                    };
                    assert!((at(0).hypot(at(1)) - 1.0).abs() < 1e-15);
                }
            }
        }
        assert_eq!(arcs(360.0).len(), 4);
    }
}
