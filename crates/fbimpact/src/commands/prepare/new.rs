//! `fbimpact new`: a commented scenario to start from.

use std::path::{Path, PathBuf};

use result_files::file::whole_file;
use result_files::words::shown::{for_shell, shown};

use crate::cli::Template;
use crate::error::{AppError, CommandFault};
use crate::scenario::written::schema;

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

/// Writes `<name>.toml`, what it reads, and, next to it, the schema for editors if there is none
/// yet. Nothing is written if one of the first two exists.
///
/// # Errors
/// [`AppError::Io`] if a file exists and `force` is not set, or if it cannot be written.
pub fn new(name: &Path, template: Template, force: bool) -> Result<(), AppError> {
    let path = match name.extension() {
        Some(end) if end == "toml" => name.to_owned(),
        _ => {
            let mut name = name.as_os_str().to_owned();
            name.push(".toml");
            PathBuf::from(name)
        }
    };
    let Some(stem) = path.file_stem().map(|s| s.to_string_lossy().into_owned()) else {
        return Err(CommandFault::request(format!("{}: is no name for a file", name.display())).into());
    };
    let companion = template.companion().map(|(ending, text)| (path.with_extension(ending), text));
    let files: Vec<&Path> =
        std::iter::once(path.as_path()).chain(companion.iter().map(|(p, _)| p.as_path())).collect();
    if !force && let Some(there) = files.iter().find(|f| f.exists()) {
        return Err(AppError::io(there, "exists, choose another name or add --force"));
    }
    whole_file::write(&path, named(template.text(), &stem).as_bytes())?;
    if let Some((companion, text)) = &companion {
        whole_file::write(companion, text.as_bytes())?;
    }
    let schema_path = path.with_file_name(SCHEMA);
    if force || !schema_path.exists() {
        whole_file::write(&schema_path, schema::text().as_bytes())?;
    } else {
        tracing::debug!("{} is there already", schema_path.display());
    }
    if let Some((companion, _)) = &companion {
        tracing::info!("{} written, the mesh of its part", companion.display());
    }
    tracing::info!("{} written, next: fbimpact run {}", path.display(), for_shell(&path));
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
