//! No command writes over what it reads, nor over a file that is not this program's own without `--force`: all commands with an output, by
//! all kinds of files that may stand there.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::support::ended;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What `$` stands for where a command reads it.
const SCENARIO: &str = "block.toml";

/// Commands, the file that each writes and is looked at, the kind of that file, and an input that must stay.
const COMMANDS: [(&[&str], &str, &str, &str); 17] = [
    (&["run", SCENARIO, "-o", "out.h5"], "out.h5", "result", SCENARIO),
    (&["thin", "r.h5", "-o", "out.h5"], "out.h5", "result", "r.h5"),
    (&["collect", "r.h5", "-o", "out.csv"], "out.csv", "csv", "r.h5"),
    (&["collect", "r.h5", "-o", "out.h5"], "out.h5", "table", "r.h5"),
    (&["collect", "results", "-o", "out.h5"], "out.h5", "table", "results/a.h5"),
    (&["report", "r.h5", "--no-3d", "-o", "out.html"], "out.html", "page", "r.h5"),
    (&["plot", "r.h5", "--figure", "energies"], "r_energies.svg", "svg", "r.h5"),
    (&["plot", "r.h5", "--figure", "energies", "--png"], "r_energies.png", "png", "r.h5"),
    (&["plot", "r.h5", "--figure", "energies", "--pdf"], "r_energies.pdf", "pdf", "r.h5"),
    (&["export", "ball.toml", "--vtk", "."], "ball.vtm", "vtk", "ball.toml"),
    (&["export", "ball.toml", "--vtk", "."], "ball/show.py", "script", "push.csv"),
    (&["export-body", "ball.toml", "--body", "ball", "-o", "out.h5"], "out.h5", "body", "ball.toml"),
    (
        &["export-body", "ball.toml", "--body", "ball", "--nurbs", "mfem", "-o", "out.mesh"],
        "out.mesh",
        "mesh",
        "push.csv",
    ),
    (
        &["export-body", "ball.toml", "--body", "ball", "--nurbs", "gismo", "-o", "out.xml"],
        "out.xml",
        "xml",
        "push.csv",
    ),
    (
        &[
            "import-body",
            "--stiffness",
            "bar.sti",
            "--mass",
            "bar.mas",
            "--nodes",
            "bar.inp",
            "--dof-map",
            "bar.dof",
            "--units",
            "mm",
            "-o",
            "out.h5",
        ],
        "out.h5",
        "body",
        "bar.sti",
    ),
    (&["mesh-size", "m.toml", "-o", "out.geo"], "out.geo", "geo", "m.msh"),
    (&["man", "--all", "."], "fbimpact-run.1", "man", ""),
];

fn program(at: &Path, arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    let (code, _, err) = ended(command.args(arguments).current_dir(at).env("FBIMPACT_CACHE", "off"));
    (code.expect("no signal"), err)
}

/// A folder with what the commands read, and a file of others.
fn inputs() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let block = "[simulation]\nend_time = 1e-3\n[bodies.block]\nmodel = \"rigid\"\nmass = 0.5\ninertia = [1e-4, 1e-4, 1e-4]\n\
                 [loads.push]\nbody = \"block\"\npoint = [0.0, 0.0, 0.0]\nforce_x = { kind = \"table\", file = \"push.csv\" }\n";
    fs::write(at.join(SCENARIO), block).expect("written");
    let ball = "[bodies.ball]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\nvelocity = [0.0, 0.0, -0.1]\n\
                geometry = { shape = \"sphere\", radius = 0.01 }\n";
    fs::write(at.join("ball.toml"), format!("{block}{ball}")).expect("written");
    fs::write(at.join("push.csv"), "t,F\n0,0\n1,10\n").expect("written");
    for name in ["bar.sti", "bar.mas", "bar.dof", "bar.inp"] {
        fs::copy(Path::new(ROOT).join("tests/matrix_parts").join(name), at.join(name)).expect("copied");
    }
    fs::create_dir_all(at.join("results")).expect("made");
    fs::create_dir_all(at.join("ball")).expect("made");
    fs::create_dir_all(at.join("kinds")).expect("made");
    for arguments in [&["run", SCENARIO, "-o", "r.h5"][..], &["new", "m", "--template", "mesh"]] {
        let (code, err) = program(at, arguments);
        assert_eq!(code, 0, "{err}");
    }
    fs::copy(at.join("r.h5"), at.join("results/a.h5")).expect("copied");
    fs::write(at.join("kinds/text"), "# precious notes of fbimpact\n").expect("written");
    folder
}

/// The same, and one file of each kind in `kinds`.
fn folder() -> TempDir {
    let folder = inputs();
    let at = folder.path();
    fs::write(at.join("kinds/empty"), "").expect("written");
    drop(hdf5::File::create(at.join("kinds/hdf5")).expect("created"));
    for (arguments, output, kind, _) in COMMANDS {
        // Another command may have written it.
        let _ = fs::remove_file(at.join(output));
        let (code, err) = program(at, arguments);
        assert_eq!(code, 0, "{arguments:?}: {err}");
        fs::copy(at.join(output), at.join("kinds").join(kind)).expect("copied");
    }
    folder
}

#[test]
fn no_command_replaces_a_text_of_others_nor_what_it_reads() {
    let folder = inputs();
    let at = folder.path();
    let precious = at.join("kinds/text");
    for (arguments, output, _, input) in COMMANDS {
        fs::copy(&precious, at.join(output)).expect("copied");
        let (code, err) = program(at, arguments);
        assert!(code == 6 && err.contains("--force"), "{arguments:?}: {code} {err}");
        assert_eq!(fs::read(at.join(output)).expect("there"), fs::read(&precious).expect("there"));
        fs::remove_file(at.join(output)).expect("removed");
        if !input.is_empty() {
            inputs_stay(at, (&[arguments, &["--force"]].concat(), output), input);
        }
    }
}

#[ignore = "second tier: 10 s of processor, some hundred calls of the program"]
#[test]
fn no_command_replaces_a_file_of_others_without_force_in_any_state() {
    let folder = folder();
    let at = folder.path();
    let kinds: Vec<_> =
        fs::read_dir(at.join("kinds")).expect("readable").map(|e| e.expect("readable").path()).collect();
    for (arguments, output, own, _) in COMMANDS {
        let target = at.join(output);
        let forced = [arguments, &["--force"]].concat();
        for path in &kinds {
            let kind = path.file_name().and_then(|name| name.to_str()).expect("UTF-8");
            // A figure is a figure whatever its format, and so are splines.
            let formats: [&[&str]; 2] = [&["svg", "png", "pdf"], &["mesh", "xml"]];
            let is_own = kind == own || formats.iter().any(|f| f.contains(&kind) && f.contains(&own));
            fs::remove_file(&target).expect("removed");
            fs::copy(path, &target).expect("copied");
            let (code, err) = program(at, arguments);
            let is_kept = fs::read(&target).expect("there") == fs::read(path).expect("there");
            if is_own {
                assert_eq!(code, 0, "{arguments:?} {kind}: {err}");
                continue;
            }
            assert!(code == 6 && is_kept && err.contains("--force"), "{arguments:?} {kind}: {code} {err}");
            assert!(err.contains(output.rsplit('/').next().expect("a name")), "{arguments:?}: {err}");
        }
        // Behind a link as well; with force the link is replaced, or followed by a run, never by names that are made on the way.
        let precious = at.join("kinds/text");
        let text = fs::read(&precious).expect("there");
        fs::remove_file(&target).expect("removed");
        symlink(&precious, &target).expect("linked");
        let (code, err) = program(at, arguments);
        assert!(
            code == 6 && err.contains("--force") && fs::read(&precious).expect("there") == text,
            "{arguments:?}: {err}"
        );
        fs::remove_file(&target).expect("removed");
        fs::copy(&precious, &target).expect("copied");
        let (code, err) = program(at, &forced);
        assert!(code == 0 && fs::read(&target).expect("there") != text, "{arguments:?}: {err}");
        // A pipe is none of a kind, with force neither.
        fs::remove_file(&target).expect("removed");
        assert!(Command::new("mkfifo").arg(&target).status().expect("mkfifo").success());
        let (code, err) = program(at, &forced);
        assert!(code == 6 && err.contains("device or pipe"), "{arguments:?}: {err}");
        fs::remove_file(&target).expect("removed");
        assert_eq!(program(at, arguments).0, 0, "{arguments:?}");
    }
}

/// The input as output by its own name, by a link and by a hard link.
fn inputs_stay(at: &Path, (forced, output): (&[&str], &str), input: &str) {
    let (source, target) = (at.join(input), at.join(output));
    let before = fs::read(&source).expect("there");
    let link = |hard: bool| if hard { fs::hard_link(&source, &target) } else { symlink(&source, &target) };
    for hard in [false, true] {
        link(hard).expect("linked");
        let (code, err) = program(at, forced);
        assert!(code == 6 && err.contains("name another output"), "{forced:?} {input}: {code} {err}");
        fs::remove_file(&target).expect("removed");
    }
    assert_eq!(fs::read(&source).expect("there"), before, "{forced:?}");
}

#[test]
fn what_others_have_beside_a_result_stays() {
    let folder = inputs();
    let at = folder.path();
    drop(hdf5::File::create(at.join("kinds/hdf5")).expect("created"));
    let run = ["run", SCENARIO, "-o", "out.h5"];
    let text = "precious";
    fs::write(at.join("precious"), text).expect("written");
    let (part, restart) = (at.join("out.h5.part"), at.join("out.h5.restart"));
    // Files of others: refused, replaced with force.
    for (beside, words) in [(&part, "not of a run"), (&restart, "no restart file")] {
        for kind in ["text", "hdf5"] {
            fs::copy(at.join("kinds").join(kind), beside).expect("copied");
            let (code, err) = program(at, &run);
            assert!(code == 6 && err.contains(words) && err.contains("--force"), "{kind}: {err}");
            assert_eq!(
                fs::read(beside).expect("there"),
                fs::read(at.join("kinds").join(kind)).expect("there")
            );
            let (code, err) = program(at, &[&run[..], &["--force"]].concat());
            assert!(code == 0 && !beside.exists() && at.join("out.h5").exists(), "{kind}: {err}");
        }
    }
    // Links: not followed, with force neither.
    for beside in [&part, &restart] {
        for target in ["precious", "nowhere"] {
            symlink(at.join(target), beside).expect("linked");
            for force in [&[][..], &["--force"]] {
                let (code, err) = program(at, &[&run[..], force].concat());
                assert!(code == 6 && err.contains("is a link"), "{target}: {err}");
            }
            fs::remove_file(beside).expect("removed");
        }
    }
    fs::copy(at.join("r.h5"), at.join("other.h5")).expect("copied");
    fs::hard_link(at.join("other.h5"), &part).expect("linked");
    let (code, err) = program(at, &run);
    assert!(code == 6 && err.contains("another name as well"), "{err}");
    assert_eq!(fs::read(at.join("other.h5")).expect("there"), fs::read(at.join("r.h5")).expect("there"));
    fs::remove_file(&part).expect("removed");
    assert!(!at.join("nowhere").exists() && fs::read_to_string(at.join("precious")).expect("there") == text);
    assert_eq!(program(at, &run).0, 0);
    assert!(!part.exists() && !restart.exists());
}
