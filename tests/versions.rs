//! Results of other versions, small copies, and files of another kind than a command is for: shown, or refused with what to do instead.

use std::path::Path;
use std::process::Command;

use crate::support::{ended, simulate};

/// Commands that read the result `$`, and whether they build models again from the deformation of bodies, which small copies have not.
const COMMANDS: [(&[&str], bool); 8] = [
    (&["info", "$"], false),
    (&["report", "$", "--no-3d", "-o", "a.html", "--force"], false),
    (&["plot", "$", "-o", "figures", "--figure", "energies", "--force"], false),
    (&["metric", "$", "max(contacts.impact.normal_force)"], false),
    (&["compare", "$", "$"], false),
    (&["thin", "$", "-o", "thin.h5", "--force"], false),
    (&["probe", "$", "--body", "ball", "--point", "0,0"], true),
    (&["export", "$", "--vtk", "vtk", "--force"], true),
];

fn program(at: &Path, arguments: &[&str], file: &str) -> (i32, String) {
    let given = arguments.iter().map(|word| if *word == "$" { file } else { word });
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    let (code, _, err) = ended(command.args(given).current_dir(at));
    (code.expect("no signal"), err)
}

/// A copy of `from` with another attribute `format_version`, or without one.
fn with_version(at: &Path, from: &str, version: Option<u32>) {
    // A file of its own: programs that other tests start meanwhile hold the lock of one that is open as they start.
    let _ = std::fs::remove_file(at.join("changed.h5"));
    std::fs::copy(at.join(from), at.join("changed.h5")).expect("copied");
    let file = hdf5::File::open_rw(at.join("changed.h5")).expect("a result");
    file.delete_attr("format_version").expect("it has one");
    if let Some(version) = version {
        file.new_attr::<u32>()
            .create("format_version")
            .and_then(|a| a.write_scalar(&version))
            .expect("written");
    }
}

#[test]
fn every_command_shows_small_copies_and_earlier_results_and_refuses_later_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulate(at, "sphere_on_plane.toml", "r.h5", &["simulation.end_time=2e-6"]);
    assert_eq!(program(at, &["thin", "$", "-o", "small.h5", "--rows", "20"], "r.h5").0, 0);
    let traces = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/traces");
    for trace in ["flexible_pendulum", "rod_on_plane"] {
        std::fs::copy(traces.join(trace).with_extension("h5"), at.join(trace).with_extension("h5"))
            .expect("copied");
    }
    for (arguments, needs_deformation) in COMMANDS {
        for version in [None, Some(0)].into_iter().filter(|_| !needs_deformation) {
            with_version(at, "r.h5", version);
            let (code, err) = program(at, arguments, "changed.h5");
            assert_eq!(code, 0, "{arguments:?} {version:?}: {err}");
        }
        for version in [3, u32::MAX] {
            with_version(at, "r.h5", Some(version));
            let (code, err) = program(at, arguments, "changed.h5");
            let words =
                format!("has format version {version}, this program reads up to 2: read it with fbimpact ");
            assert!(code == 6 && err.contains(&words), "{arguments:?}: {code} {err}");
        }
        let (code, err) = program(at, arguments, "small.h5");
        if needs_deformation {
            assert!(
                code == 6 && err.contains("is a small copy") && err.contains("made from"),
                "{arguments:?}: {err}"
            );
        } else {
            assert_eq!(code, 0, "{arguments:?}: {err}");
        }
    }
    for (arguments, trace) in
        COMMANDS[1..3].iter().flat_map(|c| ["flexible_pendulum.h5", "rod_on_plane.h5"].map(|t| (c.0, t)))
    {
        let (code, err) = program(at, arguments, trace);
        assert_eq!(code, 0, "{arguments:?} {trace}: {err}");
    }
    // In a table a result of a later version is a row.
    with_version(at, "r.h5", Some(3));
    assert_eq!(program(at, &["collect", "$", "-o", "t.csv"], "changed.h5").0, 0);
    assert!(std::fs::read_to_string(at.join("t.csv")).expect("written").contains("unreadable,,"));
}

#[test]
fn the_right_command_is_named_as_a_shell_needs_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let result = simulate(at, "sphere_on_plane.toml", "my drop.h5", &["simulation.end_time=1e-6"]);
    assert!(result.exists());
    assert_eq!(program(at, &["new", "$"], "my part").0, 0);
    for (arguments, file, words) in [
        (&["run", "$"][..], "my drop.h5", "fbimpact info 'my drop.h5'"),
        (&["check", "$"], "my drop.h5", "fbimpact run --resume 'my drop.h5'"),
        (&["converge", "$"], "my drop.h5", "is HDF5 and no scenario"),
        (&["plot", "$"], "my part.toml", "fbimpact run 'my part.toml'"),
        (&["report", "$"], "my part.toml", "fbimpact run 'my part.toml'"),
        (&["info", "$"], "my part.toml", "fbimpact check 'my part.toml'"),
        (&["metric", "$", "1"], "my part.toml", "is a scenario and no result"),
    ] {
        let (code, err) = program(at, arguments, file);
        assert!(code == 6 && err.contains(words), "{arguments:?}: {code} {err}");
    }
    let text = std::fs::read_to_string(at.join("my part.toml")).expect("there");
    assert!(
        text.contains("#   fbimpact run 'my part.toml' ") && text.contains("fbimpact report 'my part.h5' "),
        "{text}"
    );
    for hostile in ["x;touch RAN;", "o'neill", "a\"b\\c", "-q", "a\nb"] {
        let (code, err) = program(at, &["new", "--template", "mesh", "--", "$"], hostile);
        assert!(code == 0 && err.contains("next: fbimpact run "), "{hostile}: {err}");
        let name = format!("./{hostile}.toml");
        let (code, err) = program(at, &["check", "$"], &name);
        assert_eq!(code, 0, "{hostile}: {err}");
    }
}
