//! `fbimpact export-body --nurbs`: the exact shape of a body as splines for another program.

use iga_core::files::{write_gismo, write_mfem};
use result_files::file::output::Kind;
use result_files::file::whole_file;

use crate::cli::SplineFormat;
use crate::commands::scenario_file;
use crate::commands::{BodyExport, body_index, gate_of, no_full_model, print};
use crate::error::AppError;
use crate::scenario::Override;

/// Stands in a remark below the first line.
const MARK: &str = "splines written by fbimpact";
/// Splines in either format.
const SPLINES: Kind = Kind::marked("a file of splines that fbimpact wrote", MARK);

/// Writes the patches of the body's shape in `format`, in the components of its model, lengths in
/// units of `unit` \[m\].
///
/// # Errors
/// [`AppError::Command`] for a body that there is not and for a body without a shape, [`AppError::Io`] for the file, also if it is one that the
/// scenario reads.
pub fn export_splines(
    export: &BodyExport<'_>,
    (format, unit): (SplineFormat, f64),
    overrides: &[Override],
) -> Result<(), AppError> {
    let scenario = scenario_file::read(export.scenario, overrides)?;
    gate_of(&scenario, export.force).check(export.output, SPLINES)?;
    let index = body_index(export.body, scenario.bodies.iter().map(|b| &b.name))?;
    let Some((shape, _)) = scenario.bodies[index].places.shape() else {
        return Err(no_full_model(export.body, "a plane, from a file of another kind, or without a shape"));
    };
    let (text, remark) = match format {
        SplineFormat::Gismo => (write_gismo(&shape.patches, unit), format!("<!-- {MARK} -->")),
        SplineFormat::Mfem => (write_mfem(&shape.patches, unit), format!("# {MARK}")),
    };
    let text = text.replacen('\n', &format!("\n{remark}\n"), 1);
    whole_file::write(export.output, text.as_bytes())?;
    let (n, points) = (shape.patches.len(), shape.patches.iter().map(|p| p.n_functions()).sum::<usize>());
    print(&format!("{}: {}, {n} patches, {points} control points\n", export.output.display(), export.body))
}
