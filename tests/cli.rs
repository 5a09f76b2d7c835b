//! The command line: exit codes, what goes to which stream, help.

use std::path::PathBuf;

use assert_cmd::Command;

fn fbimpact() -> Command {
    Command::new(env!("CARGO_BIN_EXE_fbimpact"))
}

fn scenario(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)
}

fn output(arguments: &[&str]) -> (i32, String, String) {
    let output = fbimpact().args(arguments).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

#[test]
fn help_lists_commands_and_exit_codes() {
    let (code, out, _) = output(&["--help"]);
    assert_eq!(code, 0);
    let words = [
        "run",
        "check",
        "modes",
        "info",
        "compare",
        "thin",
        "plot",
        "report",
        "export",
        "schema",
        "reference",
        "130",
        "invalid scenario",
    ];
    for word in words {
        assert!(out.contains(word), "{word} is in the help");
    }
}

#[test]
fn long_version_names_commit_compiler_and_target() {
    let (code, out, _) = output(&["--version"]);
    assert_eq!(code, 0);
    for word in ["commit:", "compiler: rustc", "target:"] {
        assert!(out.contains(word), "{word} is in {out}");
    }
}

#[test]
fn wrong_command_line_exits_with_2() {
    for arguments in [
        &["fly"][..],
        &["run"],
        &["run", "a.toml", "--set", "no-equals-sign"],
        &["run", "a.toml", "--threads", "-1"],
        &["run", "a.toml", "-q", "-v"],
        &["run", "a.toml", "--log-format", "xml"],
        &[],
    ] {
        let (code, out, err) = output(arguments);
        assert_eq!(code, 2, "{arguments:?}: {err}");
        assert!(out.is_empty() && !err.is_empty(), "{arguments:?}");
    }
}

#[test]
fn shipped_scenarios_pass_the_check_in_silence_on_standard_output() {
    for name in ["sphere_on_plane.toml", "rod_on_plane.toml"] {
        let path = scenario(name);
        let (code, out, err) = output(&["check", path.to_str().expect("UTF-8")]);
        assert_eq!((code, out.as_str()), (0, ""), "{err}");
        assert!(err.contains("valid"), "{err}");
    }
}

#[test]
fn check_tells_the_cost_of_bodies_and_of_the_fine_models_to_come() {
    let path = scenario("sphere_rod_sphere.toml");
    let path = path.to_str().expect("UTF-8");
    let (code, out, err) = output(&["check", "--cost", "--json", path]);
    assert_eq!(code, 0, "{err}");
    let report: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let models = report[path]["models"].as_array().expect("a list").clone();
    let (_, modes, _) = output(&["modes", "--json", path]);
    let modes: serde_json::Value = serde_json::from_str(&modes).expect("JSON");
    assert_eq!(modes["bodies"][0]["points"]["top"], serde_json::json!([0.0, 0.01]), "of the ball, r and z");
    let own: Vec<_> = models.iter().filter(|m| m["contact"].is_null()).collect();
    for (body, model) in modes["bodies"].as_array().expect("a list").iter().zip(&own) {
        assert_eq!((&body["name"], &body["freedoms"]), (&model["body"], &model["dofs"]));
    }
    let fine: Vec<_> = models.iter().filter(|m| !m["contact"].is_null()).collect();
    // Two contacts of two bodies each.
    assert_eq!((own.len(), fine.len()), (3, 4), "{out}");
    for model in fine {
        assert!(model["interface"].as_f64() > Some(0.0) && model["memory"].as_f64() > Some(0.0), "{model}");
    }
    let (code, out, _) = output(&["check", "--cost", path]);
    assert!(code == 0 && out.contains("dofs") && out.contains("result: up to"), "{out}");
}

#[test]
fn a_scenario_whose_contact_a_run_would_refuse_is_not_called_valid_and_refused_once() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("overlap.toml");
    let ball = |name: &str, z: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"solid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 0.01 }}\nposition = [0.0, 0.0, {z}]\n"
        )
    };
    let contact = "[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n";
    let text = format!("[simulation]\nend_time = 1e-3\n{}{}{contact}", ball("a", 0.0), ball("b", 0.015));
    std::fs::write(&path, text).expect("written");
    for more in [&[][..], &["--cost"]] {
        let (code, out, err) = output(&[&["check", path.to_str().expect("UTF-8")], more].concat());
        assert_eq!((code, out.as_str()), (4, ""), "{err}");
        assert!(err.contains("refused, 2 bodies") && !err.contains("valid"), "{err}");
        assert!(err.contains("overlap.toml: model cannot be built"), "{err}");
        assert_eq!(err.matches("the bodies overlap").count(), 1, "{err}");
    }
}

/// A model that cannot be built and a run that fails are those of a scenario, whose name stands before what it was.
#[test]
fn errors_of_runs_name_the_scenario() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = scenario("sphere_on_plane.toml");
    for (set, code, said) in [
        ("bodies.ball.velocity=[0.0,0.0,-2.0]", 5, "sphere_on_plane.toml: run failed: contact \"impact\""),
        ("bodies.ball.position=[0.0,0.0,0.005]", 4, "sphere_on_plane.toml: model cannot be built: "),
    ] {
        let run = fbimpact().current_dir(folder.path()).arg("run").arg(&path).args(["--set", set]).output();
        let run = run.expect("the program starts");
        let err = String::from_utf8(run.stderr).expect("UTF-8");
        assert!(run.status.code() == Some(code) && err.contains(said), "{set}: {err}");
    }
}

#[test]
fn a_run_keeps_to_the_memory_that_it_is_given() {
    let path = scenario("rod_on_plane.toml");
    let directory = tempfile::tempdir().expect("a temporary directory");
    let result = directory.path().join("out.h5");
    let run = |memory: &str| {
        let result = result.to_str().expect("UTF-8");
        output(&["run", path.to_str().expect("UTF-8"), "-o", result, "--no-cache", "--memory", memory])
    };
    // The program itself takes more than a megabyte.
    let (code, _, err) = run("0.001");
    assert!(code == 4 && (err.contains("GB that are free") || err.contains("memory ends")), "{code} {err}");
    assert!(!result.exists());
    assert_eq!(run("-1").0, 2, "no amount of memory");
}

#[test]
fn check_reports_faults_of_all_files_and_exits_with_3() {
    let sphere = scenario("sphere_on_plane.toml");
    let rod = scenario("rod_on_plane.toml");
    let files = [sphere.to_str().expect("UTF-8"), rod.to_str().expect("UTF-8")];
    let set = ["--set", "simulation.end_time=-1", "--set", "simulation.gravty=1"];
    let (code, out, err) = output(&[&["check"], &files[..], &set].concat());
    assert_eq!(code, 3);
    assert!(out.is_empty());
    assert_eq!(err.matches("simulation.end_time = -1: must be a number > 0").count(), 2, "{err}");
    assert_eq!(err.matches("did you mean \"gravity\"?").count(), 2, "{err}");
}

/// Numbers of other units are no fault, for some material might be meant; they are told, with what to write.
#[test]
fn check_tells_materials_and_sizes_that_look_like_other_units() {
    let rod = scenario("rod_on_plane.toml");
    let check = |set: &[&str]| {
        let set: Vec<&str> = set.iter().flat_map(|s| ["--set", s]).collect();
        let (code, _, err) = output(&[&["check", rod.to_str().expect("UTF-8")], &set[..]].concat());
        assert_eq!(code, 0, "{err}");
        err
    };
    let tonnes =
        check(&["materials.aluminium.youngs_modulus=72800.0", "materials.aluminium.density=2.789e-9"]);
    for part in ["tonne, mm, s", "youngs_modulus = 7.2800e10", "density = 2.7890e3"] {
        assert!(tonnes.contains(part), "{tonnes}");
    }
    assert!(check(&["materials.aluminium.youngs_modulus=72.8"]).contains("GPa beside kg/m³"));
    for file in std::fs::read_dir(scenario("")).expect("a folder").map(|f| f.expect("an entry").path()) {
        if file.extension().is_some_and(|e| e == "toml") {
            let (code, _, err) = output(&["check", file.to_str().expect("UTF-8")]);
            assert!(code == 0 && !err.contains("no solid has") && !err.contains("m large"), "{err}");
        }
    }
}

#[test]
fn fault_in_a_file_shows_file_line_key_value_and_range() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("bad.toml");
    let text = std::fs::read_to_string(scenario("sphere_on_plane.toml")).expect("readable");
    std::fs::write(&path, text.replace("density = 2789.0", "density = -2789.0")).expect("written");
    let (code, _, err) = output(&["check", path.to_str().expect("UTF-8")]);
    assert_eq!(code, 3);
    let line = text.lines().position(|l| l.starts_with("density")).expect("there") + 1;
    let expected = format!("bad.toml:{line}:11: materials.aluminium.density = -2789.0: must be a number > 0");
    assert!(err.contains(&expected), "{err}");
    assert!(err.contains("kg/m³") && err.contains("^^^^^^^"), "{err}");
}

#[test]
fn missing_files_exit_with_6() {
    for arguments in
        [["run", "no-such-file.toml"], ["check", "no-such-file.toml"], ["info", "no-such-file.h5"]]
    {
        let (code, out, err) = output(&arguments);
        assert_eq!(code, 6, "{err}");
        assert!(out.is_empty() && err.contains("no-such-file"), "{err}");
    }
}

#[test]
fn unwritable_output_is_refused_before_the_run() {
    let path = scenario("sphere_on_plane.toml");
    let (code, _, err) = output(&["run", path.to_str().expect("UTF-8"), "-o", "/no/such/place/out.h5"]);
    assert_eq!(code, 6);
    assert!(err.contains("does not exist"), "{err}");
    let (code, _, err) =
        output(&["run", path.to_str().expect("UTF-8"), "-o", path.to_str().expect("UTF-8"), "--force"]);
    assert_eq!(code, 6);
    assert!(err.contains("is the scenario itself"), "{err}");
}

#[test]
fn info_refuses_what_is_no_result() {
    let path = scenario("sphere_on_plane.toml");
    let (code, _, err) = output(&["info", path.to_str().expect("UTF-8")]);
    assert_eq!(code, 6);
    assert!(err.contains("is a scenario and no result"), "{err}");
    let (code, _, err) = output(&["info", env!("CARGO_BIN_EXE_fbimpact")]);
    assert_eq!(code, 6);
    assert!(err.contains("of another format"), "{err}");
}

#[test]
fn unknown_body_of_modes_exits_with_2() {
    let path = scenario("sphere_on_plane.toml");
    let (code, _, err) = output(&["modes", path.to_str().expect("UTF-8"), "--body", "bal"]);
    assert_eq!(code, 2);
    assert!(err.contains("ball"), "{err}");
}

#[test]
fn exported_bodies_can_be_read_again() {
    let path = scenario("sphere_on_plane.toml");
    for (i, more) in [&[][..], &["--full"][..]].into_iter().enumerate() {
        let file = std::env::temp_dir().join(format!("fbimpact-export-{}-{i}.h5", std::process::id()));
        let target = file.to_str().expect("UTF-8");
        let set = ["--set", "bodies.ball.discretisation.refine=[]"];
        let arguments =
            [&["export-body", path.to_str().expect("UTF-8"), "--body", "ball", "-o", target], &set[..], more];
        let (code, out, err) = output(&arguments.concat());
        let read = fbimpact::interchange::body_file::read(&file);
        std::fs::remove_file(&file).ok();
        assert_eq!(code, 0, "{err}");
        assert!(out.contains("ball"), "{out}");
        match read.expect("a body file") {
            fbimpact::interchange::body_file::BodyFile::Reduced(body) => {
                assert!(i == 0 && !body.frequencies().is_empty())
            }
            fbimpact::interchange::body_file::BodyFile::Full(body) => {
                assert!(i == 1 && body.body().name == "ball")
            }
        }
    }
}

/// A ball whose net has a pole and singular meridians, on which named points of its shape lie.
#[test]
fn points_on_singular_lines_of_a_ball_are_exported() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let (scenario, file) = (folder.path().join("ball.toml"), folder.path().join("ball.h5"));
    let text = "[simulation]\nend_time = 1.0\n[bodies.ball]\nmaterial = \"steel\"\n\
                geometry = { shape = \"sphere\", radius = 0.01, net = \"spindle\" }\n\
                discretisation = { degree = 3, elements = [2, 2, 4] }\nreduction = { modes = 6 }\n";
    std::fs::write(&scenario, text).expect("written");
    for more in [&[][..], &["--full"][..]] {
        let paths = [&scenario, &file].map(|p| p.to_str().expect("UTF-8"));
        let arguments = ["export-body", paths[0], "--body", "ball", "-o", paths[1]];
        let (code, _, err) = output(&[&arguments[..], more].concat());
        assert_eq!(code, 0, "{more:?}: {err}");
        let points = match fbimpact::interchange::body_file::read(&file).expect("a body file") {
            fbimpact::interchange::body_file::BodyFile::Reduced(body) => body.to_parts().points.len(),
            fbimpact::interchange::body_file::BodyFile::Full(body) => body.points().len(),
        };
        // Centre, top and bottom, and four around: "back" lies on a singular line.
        assert_eq!(points, 7, "{more:?}");
    }
}

#[test]
fn schema_is_json() {
    let (code, out, _) = output(&["schema"]);
    assert_eq!(code, 0);
    serde_json::from_str::<serde_json::Value>(&out).expect("JSON");
}

#[test]
fn completions_and_manual_page_are_printed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let (code, out, _) = output(&["completions", shell]);
        assert!(code == 0 && out.contains("fbimpact"), "{shell}");
    }
    let (code, out, _) = output(&["man"]);
    assert!(code == 0 && out.starts_with(".ie"), "{}", &out[..20]);
    let (code, out, _) = output(&["man", "cache", "info"]);
    assert!(
        code == 0 && out.contains("fbimpact\\-cache\\-info") && out.contains("\\-\\-cache\\-dir"),
        "{out}"
    );
    let (code, _, err) = output(&["man", "cache", "fly"]);
    assert!(
        code == 2 && err.contains("man cache fly: no such command") && err.contains("cache info"),
        "{err}"
    );
    let folder = tempfile::tempdir().expect("a temporary directory");
    let (code, out, err) = output(&["man", "--all", folder.path().to_str().expect("UTF-8")]);
    let pages = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert!(code == 0 && pages == out.lines().count() && out.contains("fbimpact-cache-info.1"), "{out}{err}");
}

/// What bash offers after some words, in a folder with files of several kinds.
#[cfg(unix)]
#[test]
fn completions_of_bash_offer_files_by_their_ending() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    for name in ["a.toml", "b c.toml", "a.h5", "notes.txt"] {
        std::fs::write(folder.path().join(name), "").expect("written");
    }
    std::fs::create_dir(folder.path().join("sub")).expect("made");
    let (_, script, _) = output(&["completions", "bash"]);
    let offered = |words: &[&str]| {
        let words: Vec<String> = words.iter().map(|w| format!("'{w}'")).collect();
        let ask = format!(
            "{script}\nCOMP_WORDS=(fbimpact {}); COMP_CWORD={}; _fbimpact_by_ending fbimpact \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\" 2>/dev/null; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            words.join(" "),
            words.len()
        );
        let run = std::process::Command::new("bash").args(["-c", &ask]).current_dir(folder.path()).output();
        let run = run.expect("bash starts");
        let mut lines: Vec<String> = String::from_utf8_lossy(&run.stdout)
            .lines()
            .map(str::to_owned)
            .filter(|l| !l.is_empty())
            .collect();
        lines.sort();
        lines
    };
    assert_eq!(offered(&["run", ""]), ["a.toml", "b c.toml", "sub"]);
    assert_eq!(offered(&["run", "a.toml", "-o", ""]), ["a.h5", "sub"]);
    assert_eq!(offered(&["-q", "info", "a"]), ["a.h5"]);
    assert_eq!(offered(&["plot", "a.h5", "-o", ""]), ["sub"]);
    assert_eq!(offered(&["export", "a"]), ["a.h5", "a.toml"]);
    let options = offered(&["run", "--th"]);
    assert_eq!(options, ["--threads"]);
    assert!(offered(&["inf"]).contains(&"info".to_owned()));
}

#[test]
fn help_has_groups_examples_and_exit_codes_once() {
    let (_, out, _) = output(&["--help"]);
    for word in ["Simulate:", "Look at results:", "Exit codes:"] {
        assert_eq!(out.matches(word).count(), 1, "{word}: {out}");
    }
    let (code, out, _) = output(&["run", "--help"]);
    assert!(code == 0 && out.contains("Examples:\n  # ") && !out.contains("Exit codes"), "{out}");
}

#[test]
fn a_scenario_on_standard_input_is_checked() {
    let text = std::fs::read_to_string(scenario("sphere_on_plane.toml")).expect("readable");
    let (right, wrong) = (text.clone(), text.replace("density = 2789.0", "density = -1.0"));
    let run = |text: String| fbimpact().args(["check", "-"]).write_stdin(text).output().expect("it starts");
    let found = run(right);
    let err = String::from_utf8(found.stderr).expect("UTF-8");
    assert!(found.status.success() && err.contains("standard input: valid, 2 bodies"), "{err}");
    let found = run(wrong);
    let err = String::from_utf8(found.stderr).expect("UTF-8");
    assert!(found.status.code() == Some(3) && err.contains("standard input:"), "{err}");
}

#[test]
fn words_of_other_programs_are_understood_and_what_is_meant_comes_before_what_is_known() {
    let path = scenario("sphere_on_plane.toml");
    for (set, said) in [
        ("contacts.impact.restitution=0.8", "unknown key: restitution is a result"),
        (
            "bodies.ball.geometry.diameter=0.1",
            "half of the diameter is given, did you mean \"radius\"? Known here",
        ),
        (
            "contacts.impact.master=\"ball\"",
            "the master is the target, did you mean \"target_body\"? Known here",
        ),
        (
            "contacts.impact.slave=\"ball\"",
            "carries the contact points, did you mean \"contact_body\"? Known",
        ),
        ("materials.aluminium.E=1e9", "unknown key, did you mean \"youngs_modulus\"? Known here are"),
        (
            "bodies.ball.diameter=0.1",
            "half of the diameter is given; radius stands in the geometry of a body, known",
        ),
        (
            "simulation.master=\"ball\"",
            "the master is the target; target_body stands in [contacts.NAME], known",
        ),
        ("bodies.ball.dt=1", "max_step stands in [simulation.impact] or [simulation.free], known"),
        ("bodies.ball.velocty=1", "unknown key, did you mean \"velocity\"? Known here are"),
        ("bodies.ball.xyzzy=1", "unknown key, known here are"),
    ] {
        let (code, _, err) = output(&["check", path.to_str().expect("UTF-8"), "--set", set]);
        assert!(code == 3 && err.contains(said), "{set}: {err}");
    }
}

/// Nothing is coloured, whatever stands in the environment.
#[test]
fn the_log_has_no_colours() {
    let path = scenario("sphere_on_plane.toml");
    for (variable, value) in [("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")] {
        let run = fbimpact().args(["check", path.to_str().expect("UTF-8")]).env(variable, value).output();
        let err = run.expect("the program starts").stderr;
        assert!(!err.is_empty() && !err.contains(&0x1b), "{variable}");
    }
}

#[test]
fn log_in_json_is_one_object_a_line() {
    let path = scenario("sphere_on_plane.toml");
    let (code, _, err) = output(&["check", path.to_str().expect("UTF-8"), "--log-format", "json"]);
    assert_eq!(code, 0);
    for line in err.lines() {
        let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
        assert!(value["message"].is_string());
    }
    let (_, _, quiet) = output(&["check", path.to_str().expect("UTF-8"), "-q"]);
    assert!(quiet.is_empty(), "{quiet}");
}
