//! `fbimpact new`: a commented scenario to start from.

use std::path::{Path, PathBuf};

use result_files::file::whole_file;
use result_files::words::shown::{for_shell, shown};

use super::part;
use crate::cli::{PartArguments, SectionModel, Template};
use crate::commands::print;
use crate::error::{AppError, CommandFault};
use crate::scenario::written::schema;
use crate::studies::orientations::Ground;

/// The schema that the scenario names in its first line.
const SCHEMA: &str = "fbimpact.schema.json";
/// What the scenario of a mesh takes: the part of the shipped example.
const MESH: &str = include_str!("../../../../../scenarios/connecting_rod.msh");

impl Template {
    /// The scenario, with `NAME` for its name.
    fn text(self) -> &'static str {
        match self {
            Self::Drop => include_str!("../../templates/drop.toml"),
            Self::Hammer => include_str!("../../templates/hammer.toml"),
            Self::Pendulum => include_str!("../../templates/pendulum.toml"),
            Self::Mesh => include_str!("../../templates/mesh.toml"),
            Self::Chain => include_str!("../../templates/chain.toml"),
        }
    }

    /// The ending and the contents of a file that the scenario reads.
    fn companion(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Mesh => Some(("msh", MESH)),
            Self::Drop | Self::Hammer | Self::Pendulum | Self::Chain => None,
        }
    }
}

/// Writes `<name>.toml`, the template or that of the part in `mesh`, what it reads, and, next to it, the schema for editors if there is none
/// yet. Nothing is written if one of the first two exists.
///
/// # Errors
/// [`AppError::Io`] if a file exists and `force` is not set, or if it cannot be written.
pub fn new(
    name: &Path,
    (template, mesh, part): (Template, Option<(&Path, Option<SectionModel>)>, &PartArguments),
    force: bool,
) -> Result<(), AppError> {
    if let Some((file, section)) = mesh {
        return of_part(name, (file, part, section), force);
    }
    let (path, stem) = named_file(name)?;
    let companion = template.companion().map(|(ending, text)| (path.with_extension(ending), text));
    let files: Vec<&Path> =
        std::iter::once(path.as_path()).chain(companion.iter().map(|(p, _)| p.as_path())).collect();
    refuse_existing(&files, force)?;
    whole_file::write(&path, named(template.text(), &stem).as_bytes())?;
    if let Some((companion, text)) = &companion {
        whole_file::write(companion, text.as_bytes())?;
    }
    write_schema(&path, force)?;
    if let Some((companion, _)) = &companion {
        tracing::info!("{} written, the mesh of its part", companion.display());
    }
    tracing::info!("{} written, next: fbimpact run {}", path.display(), for_shell(&path));
    Ok(())
}

/// Writes `<name>.toml`, in which the part of `file` falls on a floor, and, of a shape, its mesh; prints what the part is.
///
/// # Errors
/// As [`new`], and those of [`part::scenario`].
fn of_part(
    name: &Path,
    (file, arguments, section): (&Path, &PartArguments, Option<SectionModel>),
    force: bool,
) -> Result<(), AppError> {
    let (path, stem) = named_file(name)?;
    let companions = part::companions(file, &path);
    refuse_existing(
        &std::iter::once(&path).chain(&companions).map(PathBuf::as_path).collect::<Vec<_>>(),
        force,
    )?;
    let wanted = part::Wanted { arguments, section, is_assembly: true, ground: &Ground::Rigid };
    let made = part::scenario(file, &wanted, &path, &format!("{stem} on a rigid floor"))?;
    whole_file::write(&path, made.text.as_bytes())?;
    write_schema(&path, force)?;
    print(&part::description(&made))?;
    tracing::info!("{} written, next: fbimpact check {}", path.display(), for_shell(&path));
    Ok(())
}

/// The scenario file `name`, with its ending, and its name without.
fn named_file(name: &Path) -> Result<(PathBuf, String), AppError> {
    let path = match name.extension() {
        Some(end) if end == "toml" => name.to_owned(),
        _ => {
            let mut name = name.as_os_str().to_owned();
            name.push(".toml");
            PathBuf::from(name)
        }
    };
    match path.file_stem().map(|s| s.to_string_lossy().into_owned()) {
        Some(stem) => Ok((path, stem)),
        None => Err(CommandFault::request(format!("{}: is no name for a file", name.display())).into()),
    }
}

fn refuse_existing(files: &[&Path], force: bool) -> Result<(), AppError> {
    match files.iter().find(|file| !force && file.exists()) {
        Some(there) => Err(AppError::io(*there, "exists, choose another name or add --force")),
        None => Ok(()),
    }
}

/// Writes the schema beside a scenario if there is none yet.
fn write_schema(scenario: &Path, force: bool) -> Result<(), AppError> {
    let path = scenario.with_file_name(SCHEMA);
    if force || !path.exists() {
        return Ok(whole_file::write(&path, schema::text().as_bytes())?);
    }
    tracing::debug!("{} is there already", path.display());
    Ok(())
}

/// A template with the name of its scenario, quoted in the commands of its remarks.
fn named(text: &str, stem: &str) -> String {
    let mesh = toml::Value::String(format!("{stem}.msh")).to_string();
    let text = text.replace("\"NAME.msh\"", &mesh);
    let stem = shown(&stem.replace(['\n', '\t'], " ")).into_owned();
    let in_commands = [".toml", ".h5"].iter().fold(text, |text, ending| {
        let name = format!("{stem}{ending}");
        text.replace(&format!(" NAME{ending}"), &format!(" {}", for_shell(Path::new(&name))))
    });
    in_commands.replace("NAME", &stem)
}
