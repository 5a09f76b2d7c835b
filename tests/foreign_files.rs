//! Files of strangers: they make the program load no code and read no other file, never wait, and reach no terminal raw.

use crate::support;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
/// Code, standard output and standard error of a command that must end.
fn fbimpact(at: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(at).env("HDF5_PLUGIN_PATH", at);
    support::ended(&mut command)
}

/// A small result `ok.h5` in `folder`.
fn result(folder: &Path) {
    support::simulate(folder, "rigid_double_pendulums.toml", "ok.h5", &["simulation.end_time=0.02"]);
}

#[cfg(target_os = "linux")]
#[test]
fn filter_that_nobody_knows_loads_no_plug_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let planted = "#include <stdio.h>\n__attribute__((constructor)) static void run(void) {\n\
        FILE *f = fopen(\"planted\", \"w\");\nif (f) fclose(f);\n}\n";
    std::fs::write(at.join("plug.c"), planted).expect("written");
    let compiler =
        Command::new("cc").args(["-shared", "-fPIC", "-o", "libplug.so", "plug.c"]).current_dir(at).status();
    assert!(compiler.expect("a C compiler, as the build needs").success());
    result(at);
    // The number of the filter of a chunked dataset becomes one that nobody has: deflate (1) is stored as a message of the header.
    // The oldest headers: they have no checksum that would tell.
    let oldest = hdf5::File::with_options().with_fapl(|p| p.libver_earliest()).open_rw(at.join("ok.h5"));
    let file = oldest.expect("writable");
    file.unlink("energies/total").expect("removed");
    let values = vec![0.0; 100];
    file.new_dataset_builder()
        .with_data(&values)
        .chunk(50)
        .deflate(1)
        .create("energies/total")
        .expect("created");
    file.close().expect("closed");
    let mut bytes = std::fs::read(at.join("ok.h5")).expect("readable");
    // The number of a filter stands before the length of its name, flags, number of values and the name.
    let name = b"deflate\0";
    let places: Vec<usize> =
        (8..bytes.len() - name.len()).filter(|&i| bytes[i..].starts_with(name)).map(|i| i - 8).collect();
    assert!(!places.is_empty(), "a filter");
    for place in places {
        bytes[place..place + 2].copy_from_slice(&32_000_u16.to_le_bytes());
    }
    std::fs::write(at.join("ok.h5"), bytes).expect("written");
    for arguments in
        [&["info", "ok.h5"][..], &["compare", "ok.h5", "ok.h5"], &["plot", "ok.h5", "-o", "figures"]]
    {
        let (code, _, err) = fbimpact(at, arguments);
        assert!(!at.join("planted").exists(), "{arguments:?} ran a planted constructor");
        assert!(matches!(code, Some(0 | 6)), "{arguments:?}: {err}");
    }
}

/// Names the file for [`links_of_another_process`].
const LINKED: &str = "FBIMPACT_TEST_LINKED";

/// Not a test of its own: the program's reader, which other tests of this process call, switches such links off for good.
#[test]
#[ignore = "part of another test"]
fn links_of_another_process() {
    let Some(path) = std::env::var_os(LINKED) else { return };
    let file = hdf5::File::open_rw(path).expect("writable");
    file.link_external("ok.h5", "energies/total", "energies/total").expect("linked");
    file.close().expect("closed");
}

#[test]
fn links_raw_storage_and_virtual_datasets_in_other_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    result(at);
    let change = |name: &str, change: &dyn Fn(&hdf5::File)| {
        std::fs::copy(at.join("ok.h5"), at.join(name)).expect("copied");
        let file = hdf5::File::open_rw(at.join(name)).expect("writable");
        file.unlink("energies/total").expect("removed");
        change(&file);
        file.close().expect("closed");
    };
    let n = hdf5::File::open(at.join("ok.h5")).and_then(|f| f.dataset("time")).expect("times").size();
    std::fs::write(at.join("raw"), vec![0; 8 * n]).expect("written");
    change("link.h5", &|_| {});
    let link = std::env::current_exe().and_then(|program| {
        let name = "foreign_files::links_of_another_process";
        Command::new(program).args([name, "--exact", "--ignored"]).env(LINKED, at.join("link.h5")).output()
    });
    assert!(link.expect("the tests start").status.success(), "linked");
    change("raw.h5", &|file| {
        let new = file.new_dataset::<f64>().shape(n).external("raw", 0, 8 * n);
        new.create("energies/total").expect("created");
    });
    change("virtual.h5", &|file| {
        let new = file.new_dataset::<f64>().shape(n).virtual_map("ok.h5", "energies/total", n, .., n, ..);
        new.create("energies/total").expect("created");
    });
    for (name, reason) in [
        ("link.h5", "/energies/total is a link into another file, which is not followed"),
        ("raw.h5", "/energies/total lies in other files, which are not read"),
        ("virtual.h5", "/energies/total lies in other files, which are not read"),
    ] {
        for arguments in [&["info", name][..], &["compare", name, "ok.h5"], &["plot", name, "-o", "figures"]]
        {
            let (code, _, err) = fbimpact(at, arguments);
            // A dataset that is not read is a difference.
            let is_difference = arguments[0] == "compare" && code == Some(1);
            assert!(
                is_difference || code == Some(6) && err.contains(reason),
                "{arguments:?}: {code:?} {err}"
            );
        }
    }
}

#[test]
fn groups_that_lead_in_circles_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    result(at);
    for link in [hdf5::Group::link_hard, hdf5::Group::link_soft] {
        std::fs::copy(at.join("ok.h5"), at.join("bad.h5")).expect("copied");
        let file = hdf5::File::open_rw(at.join("bad.h5")).expect("writable");
        link(&file, "/", "energies/again").expect("linked");
        file.close().expect("closed");
        for arguments in [
            &["metric", "bad.h5", "1"][..],
            &["compare", "ok.h5", "bad.h5"],
            &["thin", "bad.h5", "-o", "t.h5"],
        ] {
            let (code, _, err) = fbimpact(at, arguments);
            let reason = "/energies/again is another name of a group of this file, take it out";
            assert!(code == Some(6) && err.contains(reason), "{arguments:?}: {code:?} {err}");
        }
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_at_once_by_every_reader() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::create_dir(at.join("folder")).expect("created");
    assert!(Command::new("mkfifo").arg(at.join("pipe")).status().expect("mkfifo").success());
    std::os::unix::fs::symlink("/dev/zero", at.join("zero")).expect("linked");
    result(at);
    let body = |file: &str| {
        format!(
            "[simulation]\nend_time = 1e-3\n[bodies.a]\nmodel = \"imported\"\nfile = \"{file}\"\n\
             initial_pose = {{ position = [0, 0, 0] }}\n"
        )
    };
    let curve = |file: &str| {
        format!(
            "[simulation]\nend_time = 1e-3\n[bodies.a]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
             [loads.l]\nbody = \"a\"\npoint = [0, 0, 0]\nforce = [{{ file = \"{file}\" }}, 0, 0]\n"
        )
    };
    for name in ["folder", "pipe", "zero"] {
        let what = if name == "folder" {
            "it is a folder, name a file"
        } else {
            "it is a pipe or device, name a file"
        };
        std::fs::write(at.join("body.toml"), body(name)).expect("written");
        std::fs::write(at.join("curve.toml"), curve(name)).expect("written");
        let commands: [(&[&str], i32); 11] = [
            (&["check", name], 6),
            (&["run", name], 6),
            (&["info", name], 6),
            (&["compare", name, "ok.h5"], 6),
            (&["compare", "ok.h5", "ok.h5", "--tolerances", name], 6),
            (&["plot", name, "-o", "figures"], 6),
            (&["export", name, "--vtk", "vtk"], 6),
            (&["thin", name, "-o", "thin.h5"], 6),
            (&["metric", name, "x = 1"], 6),
            (&["check", "body.toml"], 3),
            (&["check", "curve.toml"], 3),
        ];
        for (arguments, expected) in commands {
            let (code, _, err) = fbimpact(at, arguments);
            assert_eq!(code, Some(expected), "{arguments:?}: {err}");
            assert!(arguments[1] == "curve.toml" || err.contains(what), "{arguments:?}: {err}");
        }
    }
}

#[test]
fn control_characters_of_a_title_and_of_keys_are_shown_and_long_ones_shortened() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let scenario = |title: &str| {
        format!(
            "title = \"{title}\"\n[simulation]\nend_time = 1e-6\n[bodies.a]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1, 1, 1]\n"
        )
    };
    let is_raw = |text: &str| text.chars().any(|c| c.is_control() && c != '\n' || c == '\u{202e}');
    std::fs::write(at.join("s.toml"), scenario(r"\u001b[31mred\u001b[0m\u009b1m\u202e")).expect("written");
    let (code, out, err) = fbimpact(at, &["run", "s.toml"]);
    assert!(code == Some(0) && !is_raw(&out) && !is_raw(&err), "{err}");
    let (_, out, _) = fbimpact(at, &["info", "s.h5"]);
    assert!(!is_raw(&out), "{out}");
    assert!(out.contains(r"\u001b[31mred\u001b[0m\u009b1m\u202e"), "shown once: {out}");
    let (_, out, _) = fbimpact(at, &["info", "s.h5", "--json"]);
    assert!(!is_raw(&out), "{out}");

    std::fs::write(at.join("long.toml"), scenario(&"x".repeat(100_000))).expect("written");
    assert_eq!(fbimpact(at, &["run", "-q", "long.toml"]).0, Some(0));
    let (_, out, _) = fbimpact(at, &["info", "long.h5"]);
    assert!(out.len() < 10_000 && out.contains("… (100000 characters)"), "{}", out.len());

    let bad = scenario("t") + "[bodies.\"\\u001b[31m\"]\nmodel = \"rig\\u001bid\"\n\"a\\u009bb\" = 1\n";
    std::fs::write(at.join("bad.toml"), bad).expect("written");
    for arguments in [&["check", "bad.toml"][..], &["run", "bad.toml"], &["check", "no\u{1b}[31m.toml"]] {
        let (code, out, err) = fbimpact(at, arguments);
        assert!(matches!(code, Some(3 | 6)) && !is_raw(&out) && !is_raw(&err), "{err}");
    }
}
