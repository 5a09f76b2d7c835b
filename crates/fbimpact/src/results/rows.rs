//! Rows of tables from what a run reports, and places of fine models from rows.

use adaptive::record::{
    EventRecord, ImpactRecord, MOST_TOUCHES, PhaseRecord, TargetPlace, TouchedPart, TransferRecord,
    TrialRecord, ZoneSite, ZoneSize,
};
use hdf5::Result;
use result_files::dataset::unicode;
use result_files::tables::{EventRow, ImpactRow, PhaseRow, TransferRow, TrialRow};

/// The row of a phase.
///
/// # Errors
/// That of a text that HDF5 cannot hold, as in all functions here.
pub fn phase(r: &PhaseRecord) -> Result<PhaseRow> {
    Ok(PhaseRow {
        kind: unicode(r.kind.identifier())?,
        start: r.start,
        end: r.end,
        steps: r.steps,
        rejected: r.rejected,
        evaluations: r.evaluations,
        wall_time: r.wall_time,
    })
}

/// The row of an impact of the contact `contact`.
///
/// # Errors
/// As [`phase`].
pub fn impact(r: &ImpactRecord, contact: &str) -> Result<ImpactRow> {
    Ok(ImpactRow {
        contact: unicode(contact)?,
        start: r.start,
        end: r.end,
        peak_force: r.peak_force,
        peak_time: r.peak_time,
        impulse: r.impulse,
        approach_velocity: r.approach_velocity,
        separation_velocity: r.separation_velocity,
        restitution: r.restitution,
        peak_force_uncertainty: r.band.peak_force,
        peak_time_uncertainty: r.band.peak_time,
        duration_uncertainty: r.band.duration,
        impulse_uncertainty: r.band.impulse,
        separation_velocity_uncertainty: r.band.separation_velocity,
        restitution_uncertainty: r.band.restitution,
        uncertainty: unicode(&r.band.note(contact))?,
    })
}

/// The row of an event of the contact `contact`.
///
/// # Errors
/// As [`phase`].
pub fn event(r: &EventRecord, contact: &str) -> Result<EventRow> {
    Ok(EventRow {
        time: r.time,
        contact: unicode(contact)?,
        kind: unicode(r.kind.identifier())?,
        normal_force: r.normal_force,
    })
}

/// The row of a trial.
///
/// # Errors
/// As [`phase`].
pub fn trial(r: &TrialRecord) -> Result<TrialRow> {
    Ok(TrialRow {
        impact: r.impact,
        number: r.number,
        start: r.start,
        stop: r.stop,
        penalty_start: r.penalty_start,
        penalty_end: r.penalty_end,
        interval_widths: r.interval_widths,
        utilisation: r.utilisation,
        elements: r.elements,
        dofs: r.dofs,
        interface_dofs: r.interface_dofs,
        steps: r.steps,
        rejected: r.rejected,
        peak_force: r.peak_force,
        outcome: unicode(r.outcome.identifier())?,
        reason: unicode(&r.reason)?,
        wall_time: r.wall_time,
        cpu_time: r.cpu_time,
    })
}

/// The row of a change of the model at the contact `contact`.
///
/// # Errors
/// As [`phase`].
pub fn transfer(r: &TransferRecord, contact: &str) -> Result<TransferRow> {
    let met = r.met();
    Ok(TransferRow {
        time: r.time,
        direction: unicode(r.direction.identifier())?,
        contact: unicode(contact)?,
        energy_before: r.energy_before,
        energy_after: r.energy_after,
        momentum_change: r.momentum_change,
        face: r.site.map_or(-1, |s| s.face as i32),
        centre: r.site.map_or([0.0; 3], |s| s.centre),
        target_face: r.target_site.map_or(-1, |s| s.face as i32),
        target_centre: r.target_site.map_or([0.0; 3], |s| s.centre),
        interval_widths: r.site.map_or([0.0; 2], |s| s.size.in_result()),
        finer: r.site.map_or(0.0, |s| s.size.finer()),
        edge_face: met.map_or(-1, |m| m.face as i32),
        edge_place: met.map_or([0.0; 3], |m| m.xi),
        edge_normal: met.map_or([0.0; 3], |m| m.normal),
        edge_along: met.map_or([0.0; 6], |m| std::array::from_fn(|k| m.along[k / 3][k % 3])),
        edge_spread: met.map_or(0.0, |m| m.spread),
        edge_outward: met.map_or([0.0; 3], |m| m.outward),
        part: part_in_result(r.site),
        target_part: part_in_result(r.target_site),
        others: others_in_result(r.site),
        target_others: others_in_result(r.target_site),
        across: r.site.map_or([0.0; 3], |s| s.across),
        target_across: r.target_site.map_or([0.0; 3], |s| s.across),
        offset: r.offset,
    })
}

/// Where the fine models of the contact body and of the target lie, as far as any came. Columns
/// that a result of an earlier version does not have are zero: no model has an interval without
/// width. Those of the whole surface are infinite.
pub fn sites(row: &TransferRow) -> [Option<ZoneSite>; 2] {
    let size = ZoneSize::of_result(row.interval_widths, row.finer);
    let own = (row.face, row.centre, met(row), row.part, (&row.others, row.across));
    let target =
        (row.target_face, row.target_centre, None, row.target_part, (&row.target_others, row.target_across));
    // A target whose flat face touches has its whole surface, whatever the interval about that face.
    let of_target = part_of_result(row.part).and(Some(ZoneSize::Whole));
    [(own, size), (target, size.map(|size| of_target.unwrap_or(size)))].map(|(zone, size)| {
        let (face, centre, meets, part, (others, across)) = zone;
        let face = u32::try_from(face).ok()?;
        let size = size.filter(|_| centre.iter().all(|u| u.is_finite()))?;
        Some(ZoneSite {
            face,
            centre,
            size,
            meets,
            part: part_of_result(part),
            others: others_of_result(others),
            across: if across.iter().all(|x| x.is_finite()) { across } else { [0.0; 3] },
        })
    })
}

/// Further places of a zone, as results have them: for each the number of the face from 1 on and the parameters.
fn others_in_result(site: Option<ZoneSite>) -> [f64; 4 * OTHERS] {
    let others = site.map_or([None; OTHERS], |site| site.others);
    std::array::from_fn(|k| match others[k / 4] {
        Some((face, xi)) => [f64::from(face) + 1.0, xi[0], xi[1], xi[2]][k % 4],
        None => 0.0,
    })
}

/// The places of [`others_in_result`]; none of zeros and of numbers that are none.
fn others_of_result(others: &[f64; 4 * OTHERS]) -> [Option<(u32, [f64; 3])>; OTHERS] {
    std::array::from_fn(|k| {
        let [face, u, v, w] = std::array::from_fn(|c| others[4 * k + c]);
        let is_place = face >= 1.0 && [face, u, v, w].iter().all(|value| value.is_finite());
        is_place.then_some((face as u32 - 1, [u, v, w]))
    })
}

/// Places of a zone at most beside the first one.
const OTHERS: usize = MOST_TOUCHES - 1;

/// The part of a surface that a zone is, as results have it.
fn part_in_result(site: Option<ZoneSite>) -> [f64; 8] {
    let Some(TouchedPart { origin: [a, b, c], outward: [x, y, z], depth, radius }) =
        site.and_then(|s| s.part)
    else {
        return [0.0; 8];
    };
    [a, b, c, x, y, z, depth, radius]
}

/// The part of [`part_in_result`]; none of zeros and of numbers that are none.
fn part_of_result([a, b, c, x, y, z, depth, radius]: [f64; 8]) -> Option<TouchedPart> {
    let part = TouchedPart { origin: [a, b, c], outward: [x, y, z], depth, radius };
    (depth > 0.0 && [a, b, c, x, y, z, radius].iter().all(|v| v.is_finite())).then_some(part)
}

/// What the contact body meets of an edge or a corner of the target; none without a normal.
fn met(row: &TransferRow) -> Option<TargetPlace> {
    let (face, xi, normal) = (u32::try_from(row.edge_face).ok()?, row.edge_place, row.edge_normal);
    let is_place = xi.iter().chain(&row.edge_along).chain(&row.edge_outward).all(|u| u.is_finite())
        && normal.iter().any(|n| n.abs() > 0.0);
    let along = std::array::from_fn(|k| std::array::from_fn(|c| row.edge_along[3 * k + c]));
    let spread = row.edge_spread.max(0.0);
    is_place.then_some(TargetPlace { face, xi, normal, along, spread, outward: row.edge_outward })
}

#[cfg(test)]
mod tests {
    use adaptive::record::TrialOutcome;
    use adaptive::record::warning::{Warning, WarningKind};
    use result_files::stored::warnings;
    use result_files::tables::ACCEPTED;

    #[test]
    fn an_accepted_trial_is_called_as_readers_expect() {
        assert_eq!(TrialOutcome::Accepted.identifier(), ACCEPTED);
    }

    #[test]
    fn the_line_of_a_warning_is_taken_apart_as_it_was_put_together() {
        let warning = Warning {
            kind: WarningKind::NeverClosed,
            subject: "contact \"c\"".into(),
            message: "it is open; by 1 m".into(),
            remedy: "wait".into(),
            ..Warning::default()
        };
        let line = warning.line();
        assert_eq!(warnings::identifier(&line), "never-closed");
        let parts = warnings::json(&line);
        let text = |key: &str| parts[key].as_str().map(str::to_owned);
        assert_eq!(text("identifier").as_deref(), Some("never-closed"));
        assert_eq!(text("subject").as_deref(), Some("contact \"c\""));
        assert_eq!(text("message").as_deref(), Some("it is open; by 1 m"));
        assert_eq!(text("remedy").as_deref(), Some("wait"));
    }
}
