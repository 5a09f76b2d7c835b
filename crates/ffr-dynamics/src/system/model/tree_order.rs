//! Order of bodies in a tree of joints: parents before their children.

use crate::error::DynamicsError;

/// What carries a body: index of the body that carries its joint, or `None` on ground.
pub type Parent = Option<usize>;

/// Bodies in an order in which every parent comes before its children.
///
/// # Errors
/// [`DynamicsError::JointCycle`] with the bodies and joints on the way around.
pub fn order_from_ground(
    parents: &[Parent],
    body_name: impl Fn(usize) -> String,
    joint_name: impl Fn(usize) -> String,
) -> Result<Vec<usize>, DynamicsError> {
    let mut order: Vec<usize> = Vec::with_capacity(parents.len());
    let mut is_placed = vec![false; parents.len()];
    loop {
        let before = order.len();
        for (i, parent) in parents.iter().enumerate() {
            if !is_placed[i] && parent.is_none_or(|p| is_placed[p]) {
                is_placed[i] = true;
                order.push(i);
            }
        }
        if order.len() == parents.len() {
            return Ok(order);
        }
        if order.len() == before {
            break;
        }
    }
    // From any body left over, going up as often as there are bodies ends on a cycle.
    let up = |i: usize| parents[i].unwrap_or(i);
    let left = is_placed.iter().position(|placed| !placed).unwrap_or(0);
    let start = (0..parents.len()).fold(left, |i, _| up(i));
    let mut path = format!("\"{}\"", body_name(start));
    let mut body = start;
    loop {
        path += &format!(" -> joint \"{}\" -> \"{}\"", joint_name(body), body_name(up(body)));
        body = up(body);
        if body == start {
            return Err(DynamicsError::JointCycle { path });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(parents: &[Parent]) -> Result<Vec<usize>, DynamicsError> {
        order_from_ground(parents, |i| format!("b{i}"), |i| format!("j{i}"))
    }

    #[test]
    fn parents_come_before_children() {
        let parents = [Some(2), None, Some(1), Some(1), None];
        let order = order(&parents).unwrap();
        let place = |b: usize| order.iter().position(|i| *i == b).unwrap();
        for (i, parent) in parents.iter().enumerate() {
            assert!(parent.is_none_or(|p| place(p) < place(i)));
        }
    }

    #[test]
    fn cycle_is_named() {
        let error = order(&[None, Some(2), Some(3), Some(2)]).unwrap_err();
        assert!(error.to_string().contains("\"b3\" -> joint \"j3\" -> \"b2\" -> joint \"j2\" -> \"b3\""));
    }
}
