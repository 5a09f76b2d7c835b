//! Width of a contact interval from its utilisation (\[A\] Algorithm 2, Fig. 4, Eq. (9); theory
//! section A.1).
//!
//! An impact that was simulated tells which elements of its interval were in contact. From that
//! follows whether the fine model may be accepted and how wide the next interval should be. Knows
//! neither splines nor time.

/// The kind of an end of a contact interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IntervalEnd {
    /// More surface: contact there means that the interval is too small.
    #[default]
    Open,
    /// The axis of an axisymmetric body, or another end at which the surface goes on by symmetry:
    /// no edge.
    Axis,
    /// The end of the face: the interval cannot grow there.
    FaceEnd,
    /// An end of a straight line that lies in the interval from edge to edge of the body: all that
    /// can touch along it is watched, so that contact there is no sign of an interval too small.
    LineEnd,
}

/// The rows of elements by which the use of an interval is judged.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalGrid {
    /// Widths, one per direction along the surface; the second is zero for curves \[m\].
    pub widths: [f64; 2],
    /// The kinds of the ends, one entry per direction.
    pub ends: Vec<[IntervalEnd; 2]>,
    /// Rows per direction; 1 in directions that the surface does not have.
    pub n_elements: [usize; 2],
}

impl IntervalGrid {
    /// Whether one of the `rows` lies at an end where the surface goes on.
    pub fn is_at_open_end(&self, rows: [usize; 2]) -> bool {
        self.ends.iter().enumerate().any(|(d, ends)| {
            let at = [rows[d] == 0, rows[d] + 1 == self.n_elements[d]];
            (0..2).any(|side| at[side] && ends[side] == IntervalEnd::Open)
        })
    }

    /// The same for contact that may reach edges of the body.
    #[must_use]
    pub fn up_to_edges(mut self) -> Self {
        for end in self.ends.iter_mut().flatten().filter(|end| **end == IntervalEnd::FaceEnd) {
            *end = IntervalEnd::LineEnd;
        }
        self
    }

    /// That of the whole surface of a body of the size `size` \[m\].
    pub fn of_whole(size: f64) -> Self {
        Self { widths: [size, 0.0], ends: Vec::new(), n_elements: [1; 2] }
    }
}

/// Share of an interval's elements that shall touch (\[A\] section 4.2).
pub const TARGET_UTILISATION: f64 = 0.7;

/// Share of an interval below which it is too wide, if it shall be used to the share `target`: 0.5
/// for [`TARGET_UTILISATION`] (\[A\] section 4.3).
pub fn least_utilisation(target: f64) -> f64 {
    0.5 * target / TARGET_UTILISATION
}

/// Share of the elements at one instant, over the share of an interval that is to be used, below
/// which contact that moves along the interval asks for more of them. Of discs that spin, 3 rows of
/// 16 at one instant made the peak force 4 % too large, 7 rows changed it by 0.1 to 0.4 %.
const FEWEST: f64 = 0.7;
/// Most times as many elements as intervals of a contact have, for contact that moves along: of
/// one direction, and in both of a surface, whose unknowns they raise by the square.
const FINEST: [f64; 2] = [16.0, 2.0];

/// Rows beyond which those of an interval count no more: of as many as a scenario may ask for, 512 say, contact at one instant
/// needs no larger number than of some more than are usual.
const MOST_ROWS: f64 = 24.0;

/// Share of the rows of an interval that were in contact at one instant, of which there were `at_once` among `n_elements` where it
/// had `finer` times as many as usual.
pub fn share_at_once(at_once: usize, n_elements: usize, finer: f64) -> f64 {
    at_once as f64 / (n_elements as f64 / finer).min(MOST_ROWS)
}

/// So many times as many elements as `usual`.
pub fn finer_elements(usual: usize, finer: f64) -> usize {
    (usual as f64 * finer).round() as usize
}

/// How many times as many elements than usual an interval of `n_directions` should have had where
/// it had `finer` times as many and `resolution` of the usual number were in contact at one instant
/// at most, so that the share `target` would have been (theory section A.1).
pub fn finer_by(finer: f64, resolution: f64, target: f64, n_directions: usize) -> f64 {
    let most = FINEST[n_directions.clamp(1, 2) - 1];
    (finer * target / resolution).clamp(1.0, most)
}

/// Share of the elements that an interval of the contact has, which is to be used to the share
/// `minimum`, below which too few of them touch at one instant (theory section A.1).
pub fn fewest_at_once(minimum: f64) -> f64 {
    FEWEST * minimum
}

/// Settings of the search for the width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntervalSettings {
    /// Utilisation that widths aim at.
    pub target: f64,
    /// Utilisation below which the model is not acceptable.
    pub minimum: f64,
    /// Largest change of the width in one trial, as a share of it.
    pub max_change: f64,
}

impl Default for IntervalSettings {
    /// The values of \[A\] section 4.2: 70 %, 50 %, 50 %.
    fn default() -> Self {
        let target = TARGET_UTILISATION;
        Self { target, minimum: least_utilisation(target), max_change: 0.5 }
    }
}

/// Which elements of an interval were in contact during an impact, one or two directions.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFlags {
    counts: [usize; 2],
    flags: Vec<bool>,
}

impl ContactFlags {
    /// No contact in an interval of `counts` elements per direction; 1 in a direction that the face
    /// does not have.
    pub fn new(counts: [usize; 2]) -> Self {
        Self { counts, flags: vec![false; counts[0] * counts[1]] }
    }

    /// Notes contact in element `index`; elements outside the interval are ignored.
    pub fn mark(&mut self, index: [usize; 2]) {
        if index[0] < self.counts[0] && index[1] < self.counts[1] {
            self.flags[index[0] + self.counts[0] * index[1]] = true;
        }
    }

    /// Forgets all contact.
    pub fn clear(&mut self) {
        self.flags.fill(false);
    }

    /// Whether any element was in contact.
    pub fn is_any(&self) -> bool {
        self.flags.contains(&true)
    }

    /// Flags of direction `d`: whether any element of each row across it was in contact. Rows
    /// between others in contact count as well: a row may hold no contact point.
    pub fn along(&self, d: usize) -> Vec<bool> {
        let touched = self.flags.iter().enumerate().filter(|&(_, &flag)| flag);
        let rows = touched.map(|(i, _)| [i % self.counts[0], i / self.counts[0]][d]);
        let (mut first, mut last) = (self.counts[d], 0);
        for row in rows {
            (first, last) = (first.min(row), last.max(row));
        }
        (0..self.counts[d]).map(|row| first <= row && row <= last).collect()
    }
}

/// One direction of an interval after an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionUse<'a> {
    /// Whether each element of the interval was in contact.
    pub contact: &'a [bool],
    /// Width of the interval, in any measure \[m\].
    pub width: f64,
    /// The kinds of its lower and upper end.
    pub ends: [IntervalEnd; 2],
}

/// The verdict of Algorithm 2 on one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// An edge element was in contact, the interval is too small: not acceptable (lines 1–3).
    EdgeTouched,
    /// Contact reached the end of the face, at which the interval cannot grow: not acceptable.
    FaceEndReached,
    /// Utilisation below the minimum: not acceptable (lines 4–6).
    UnderUtilised,
    /// Acceptable, narrower next time (lines 7–9).
    BelowTarget,
    /// Acceptable, wider next time or unchanged (lines 10–12).
    AtOrAboveTarget,
}

impl Verdict {
    /// Whether the model may be accepted as far as this direction goes.
    pub fn is_acceptable(self) -> bool {
        matches!(self, Self::BelowTarget | Self::AtOrAboveTarget)
    }
}

/// Answer of Algorithm 2 for one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionAssessment {
    /// Contact elements over interval elements.
    pub utilisation: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// Width for the next model, in the measure of the input \[m\].
    pub width: f64,
}

/// Answer of Algorithm 2 for an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalAssessment {
    /// One entry per direction.
    pub directions: Vec<DirectionAssessment>,
}

impl IntervalAssessment {
    /// Whether the model is acceptable, so that the penalty factor may be adjusted.
    pub fn is_acceptable(&self) -> bool {
        self.directions.iter().all(|d| d.verdict.is_acceptable())
    }

    /// Whether contact reached an end of the face, so that no interval can hold it.
    pub fn is_at_face_end(&self) -> bool {
        self.directions.iter().any(|d| d.verdict == Verdict::FaceEndReached)
    }

    /// Whether contact reached an end of the interval at which the surface goes on.
    pub fn touches_edge(&self) -> bool {
        self.directions.iter().any(|d| d.verdict == Verdict::EdgeTouched)
    }

    /// Widths of the next model; of one direction twice \[m\].
    pub fn widths(&self) -> [f64; 2] {
        let width = |d: usize| self.directions.get(d).or(self.directions.first()).map_or(0.0, |d| d.width);
        [width(0), width(1)]
    }
}

/// Algorithm 2: whether a model is acceptable and the widths of the next one (theory Eqs. A.1,
/// A.2).
///
/// Utilisations are considered direction by direction. Once an edge element was in contact
/// anywhere, the trial may have ended before the others were used: directions are widened in
/// proportion to their use, none is narrowed. An interval without elements counts as not used.
pub fn assess(directions: &[DirectionUse<'_>], settings: &IntervalSettings) -> IntervalAssessment {
    let touched = directions.iter().any(|d| edge(d) == Some(IntervalEnd::Open));
    let assess_one = |d: &DirectionUse<'_>| {
        let n_contact = d.contact.iter().filter(|&&c| c).count();
        let utilisation = if d.contact.is_empty() { 0.0 } else { n_contact as f64 / d.contact.len() as f64 };
        let verdict = match edge(d) {
            Some(IntervalEnd::Open) => Verdict::EdgeTouched,
            Some(_) => Verdict::FaceEndReached,
            None if utilisation < settings.minimum => Verdict::UnderUtilised,
            None if utilisation < settings.target => Verdict::BelowTarget,
            None => Verdict::AtOrAboveTarget,
        };
        let (least, most) = (1.0 - settings.max_change, 1.0 + settings.max_change);
        let factor = match verdict {
            Verdict::EdgeTouched => most,
            _ if touched => (most * utilisation).max(1.0),
            _ => (utilisation / settings.target).clamp(least, most),
        };
        // From edge to edge of the body there is nothing to widen.
        let factor = match d.ends {
            [IntervalEnd::LineEnd, IntervalEnd::LineEnd] => factor.min(1.0),
            _ => factor,
        };
        DirectionAssessment { utilisation, verdict, width: d.width * factor }
    };
    IntervalAssessment { directions: directions.iter().map(assess_one).collect() }
}

/// The end whose edge element was in contact, an open one first; the axis has no edge element.
fn edge(d: &DirectionUse<'_>) -> Option<IntervalEnd> {
    let in_contact = [d.contact.first(), d.contact.last()].map(|flag| flag.is_some_and(|&f| f));
    let touched = |kind| (0..2).any(|i| in_contact[i] && d.ends[i] == kind);
    [IntervalEnd::Open, IntervalEnd::FaceEnd].into_iter().find(|&kind| touched(kind))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const OPEN: [IntervalEnd; 2] = [IntervalEnd::Open; 2];
    const FROM_AXIS: [IntervalEnd; 2] = [IntervalEnd::Axis, IntervalEnd::Open];

    fn flags(range: std::ops::Range<usize>) -> Vec<bool> {
        (0..16).map(|i| range.contains(&i)).collect()
    }

    fn one(contact: &[bool], ends: [IntervalEnd; 2]) -> DirectionAssessment {
        let direction = DirectionUse { contact, width: 2.0, ends };
        assess(&[direction], &IntervalSettings::default()).directions[0]
    }

    #[test]
    fn contact_that_moves_asks_for_rows_and_not_for_a_share_of_many() {
        // 6 of the usual 16 rows at once, and of twice as many; 12 of 512 that the scenario asks for are as good as of 24.
        for (at_once, n_elements, finer, share) in
            [(6, 16, 1.0, 0.375), (6, 32, 2.0, 0.375), (12, 512, 1.0, 0.5), (3, 512, 1.0, 0.125)]
        {
            let found = share_at_once(at_once, n_elements, finer);
            assert!((found - share).abs() < 1e-15, "{at_once} of {n_elements}: {found}");
        }
    }

    #[test]
    fn contact_of_an_edge_element_widens_by_half() {
        let found = one(&flags(0..9), OPEN);
        assert_eq!(found.verdict, Verdict::EdgeTouched);
        assert_relative_eq!(found.width, 3.0);
        assert!(!found.verdict.is_acceptable());
    }

    #[test]
    fn the_axis_is_no_edge_and_the_printed_utilisation_comes_out() {
        // \[A\] section 5: 10/16 = 62.5 % is acceptable, 6/16 = 37.5 % is not.
        let (good, small) = (one(&flags(0..10), FROM_AXIS), one(&flags(0..6), FROM_AXIS));
        assert_relative_eq!(good.utilisation, 0.625);
        assert_eq!(good.verdict, Verdict::BelowTarget);
        assert_relative_eq!(good.width, 2.0 * 0.625 / 0.7, epsilon = 1e-15);
        assert_eq!(small.verdict, Verdict::UnderUtilised);
        assert_relative_eq!(small.width, 2.0 * 0.375 / 0.7, epsilon = 1e-15);
    }

    #[test]
    fn above_the_target_the_model_is_accepted_and_widened() {
        let found = one(&flags(0..14), FROM_AXIS);
        assert_eq!(found.verdict, Verdict::AtOrAboveTarget);
        assert_relative_eq!(found.width, 2.0 * 0.875 / 0.7, epsilon = 1e-15);
        assert_eq!(one(&flags(0..16), FROM_AXIS).verdict, Verdict::EdgeTouched);
    }

    #[test]
    fn widths_change_by_half_at_most() {
        assert_relative_eq!(one(&flags(0..1), FROM_AXIS).width, 1.0);
        assert_relative_eq!(one(&[false; 16], OPEN).width, 1.0);
        assert_relative_eq!(one(&[], OPEN).width, 1.0);
    }

    #[test]
    fn an_end_of_the_face_is_named() {
        let found = one(&flags(10..16), [IntervalEnd::Open, IntervalEnd::FaceEnd]);
        assert_eq!(found.verdict, Verdict::FaceEndReached);
        // An open end that is touched too can still grow: that comes first.
        assert_eq!(
            one(&flags(0..16), [IntervalEnd::Open, IntervalEnd::FaceEnd]).verdict,
            Verdict::EdgeTouched
        );
    }

    #[test]
    fn a_line_from_edge_to_edge_has_no_end_and_cannot_grow() {
        let found = one(&flags(0..16), [IntervalEnd::LineEnd; 2]);
        assert_eq!(found.verdict, Verdict::AtOrAboveTarget);
        assert_relative_eq!(found.width, 2.0);
        // Used in part it is narrowed like any other.
        assert_eq!(one(&flags(4..8), [IntervalEnd::LineEnd; 2]).verdict, Verdict::UnderUtilised);
    }

    #[test]
    fn two_directions_are_judged_one_by_one() {
        let mut grid = ContactFlags::new([16, 16]);
        for i in 2..13 {
            for j in 6..10 {
                grid.mark([i, j]);
            }
        }
        grid.mark([99, 0]);
        let (u, v) = (grid.along(0), grid.along(1));
        let uses = [&u, &v].map(|c| DirectionUse { contact: c, width: 1.0, ends: OPEN });
        let found = assess(&uses, &IntervalSettings::default());
        assert_relative_eq!(found.directions[0].utilisation, 11.0 / 16.0);
        assert_relative_eq!(found.directions[1].utilisation, 4.0 / 16.0);
        assert_eq!(found.directions[0].verdict, Verdict::BelowTarget);
        assert_eq!(found.directions[1].verdict, Verdict::UnderUtilised);
        assert!(!found.is_acceptable());
    }

    #[test]
    fn an_edge_widens_the_other_direction_as_far_as_that_is_used() {
        for (used, factor) in [(7..8, 1.0), (5..9, 1.0), (1..15, 1.3125)] {
            let (u, v) = (flags(0..5), flags(used));
            let uses = [&u, &v].map(|c| DirectionUse { contact: c, width: 1.0, ends: OPEN });
            let found = assess(&uses, &IntervalSettings::default());
            assert_relative_eq!(found.directions[0].width, 1.5);
            assert_relative_eq!(found.directions[1].width, factor);
            assert!(!found.is_acceptable() && !found.is_at_face_end());
        }
    }

    #[test]
    fn trials_of_an_elongated_contact_settle_whichever_width_is_wrong() {
        // Contact of the half extents 1 and 0.1 that a trial ends at the first edge element, having
        // grown in proportion till then.
        for wrong in [[0.3, 1.0], [1.0, 0.3], [0.3, 3.0], [4.0, 0.4], [0.5, 0.5], [3.0, 3.0]] {
            let (mut widths, mut trials) = ([wrong[0] * 2.0 / 0.7, wrong[1] * 0.2 / 0.7], 0);
            loop {
                let edge = [1.0, 0.1].map(|a| 2.0 * a);
                let growth = (0..2).map(|d| widths[d] * (15.0 / 16.0) / edge[d]).fold(1.0, f64::min);
                let row = |d: usize| -> Vec<bool> {
                    let middle = |i: i32| (f64::from(i) - 7.5).abs() - 0.5;
                    (0..16).map(|i| middle(i) * widths[d] / 16.0 < growth * 0.5 * edge[d]).collect()
                };
                let rows = [row(0), row(1)];
                let uses = [0, 1].map(|d| DirectionUse { contact: &rows[d], width: widths[d], ends: OPEN });
                let found = assess(&uses, &IntervalSettings::default());
                if found.is_acceptable() {
                    break;
                }
                (widths, trials) = ([0, 1].map(|d| found.directions[d].width), trials + 1);
                assert!(trials < 6, "a factor of four takes four steps of one half, and one back: {wrong:?}");
            }
        }
    }

    #[test]
    fn repeated_trials_settle_on_the_target() {
        // Contact of fixed radius 1 on an interval from the axis: the width must end near 1/0.7.
        let (mut width, mut trials) = (10.0, 0);
        let settings = IntervalSettings::default();
        loop {
            let contact: Vec<bool> = (0..16).map(|i| (i as f64 + 0.5) * width / 16.0 < 1.0).collect();
            let found = assess(&[DirectionUse { contact: &contact, width, ends: FROM_AXIS }], &settings);
            if found.is_acceptable() {
                assert!((0.5..0.9).contains(&found.directions[0].utilisation));
                break;
            }
            (width, trials) = (found.directions[0].width, trials + 1);
            assert!(trials < 6, "halving from 10 to below 2 takes three trials");
        }
    }
}
