//! Scenarios of thousands of bodies and contacts, and files that are mostly nothing, are read in seconds.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use result_files::stored::stages::STAGES;
use result_files::stored::{Kind, Stored};
use result_files::tables::ImpactRow;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
/// Far more than is needed on a busy machine (2 s), far less than each of these took (minutes).
const SECONDS: Duration = Duration::from_secs(30);

fn rigid_balls(n: usize) -> String {
    let mut text = "[simulation]\nend_time = 1e-6\n".to_owned();
    for i in 0..n {
        let _ = write!(
            text,
            "[bodies.a{i}]\nmodel = \"rigid\"\nmaterial = \"steel\"\nposition = [{}, 0, 0]\n\
             geometry = {{ shape = \"sphere\", radius = 0.01 }}\n",
            0.03 * i as f64
        );
    }
    text
}

/// Adds contacts by Hertz' law between each of `n` bodies and so many of those that follow it.
fn add_contacts(text: &mut String, n: usize, each: usize) {
    for k in 0..each * n {
        let (own, other) = (k % n, (k % n + 1 + k / n) % n);
        let _ = write!(
            text,
            "[contacts.c{k}]\ncontact_body = \"a{own}\"\ntarget_body = \"a{other}\"\nmodel = \"hertz\"\n"
        );
    }
}

fn checked(text: &str) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    checked_in(folder.path(), text)
}

fn checked_in(folder: &Path, text: &str) -> (Option<i32>, String) {
    std::fs::write(folder.join("s.toml"), text).expect("written");
    let begin = Instant::now();
    let output = Command::new(PROGRAM).args(["check", "s.toml"]).current_dir(folder).output();
    let output = output.expect("it starts");
    assert!(begin.elapsed() < SECONDS, "{} s", begin.elapsed().as_secs());
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

#[test]
fn equal_rigid_balls_are_measured_once() {
    let (code, err) = checked(&rigid_balls(5_000));
    assert!(code == Some(0) && err.contains("5000 bodies"), "{err}");
}

#[test]
fn motion_in_shared_datasets_reads_as_in_groups_of_each_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/rigid_double_pendulums.toml");
    let flexible = scenario.with_file_name("sphere_on_plane.toml");
    let run = |arguments: &[&str]| {
        let ended =
            Command::new(PROGRAM).args(arguments).current_dir(folder.path()).output().expect("it starts");
        assert!(ended.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).expect("UTF-8")
    };
    let pictures: &[&[&str]] = &[
        &["plot", "--force", "-o", "figures"],
        &["report", "-q", "--force", "-o", "page.html"],
        &["export", "-q", "--force", "--vtk", "moving"],
    ];
    let points: &[&[&str]] = &[&["probe", "-q", "--json", "--body", "ball", "--point", "0,0"]];
    for (scenario, end, body, commands) in
        [(&scenario, "5e-3", "left_rod", pictures), (&flexible, "2e-5", "ball", points)]
    {
        let scenario = scenario.to_str().expect("UTF-8");
        for (arrays, output) in [("false", "q1.h5"), ("true", "q2.h5")] {
            let set = [format!("simulation.end_time={end}"), format!("output.arrays={arrays}")];
            run(&["run", scenario, "-q", "--force", "-o", output, "--set", &set[0], "--set", &set[1]]);
        }
        let [own, all] =
            ["q1.h5", "q2.h5"].map(|name| Stored::open(&folder.path().join(name)).expect("readable"));
        assert!(all.file().link_exists("arrays/bodies/position") && !own.file().link_exists("arrays"));
        assert!(all.entries.keys().eq(own.entries.keys()));
        for (name, entry) in own.entries.iter().filter(|(name, _)| !name.starts_with("timings/")) {
            assert_eq!(
                (&entry.shape, &entry.unit, entry.kind),
                (&all.entries[name].shape, &all.entries[name].unit, all.entries[name].kind)
            );
            assert!(
                entry.kind == Kind::Other
                    || own.values(name).expect("there") == all.values(name).expect("there"),
                "{name}"
            );
        }
        all.check().expect("whole");
        run(&["compare", "q2.h5", "q1.h5", "--rtol", "1e-14"]);
        let [own, all] = ["q1.h5", "q2.h5"].map(|name| {
            run(&["thin", name, "--force", "-o", "small.h5"]);
            run(&["compare", name, "small.h5"]);
            let told = commands.iter().map(|command| run(&[*command, &[name]].concat()));
            let told = told.collect::<String>().replace(name.trim_end_matches(".h5"), "");
            let info: serde_json::Value =
                serde_json::from_str(&run(&["info", name, "--json"])).expect("JSON");
            let metric = run(&["metric", name, &format!("max(bodies.\"{body}\".velocity)")]);
            (info["bodies"].clone(), told, metric)
        });
        assert_eq!(own, all);
    }
}

#[test]
fn bodies_of_many_contacts_are_found_by_name() {
    let n = 2_000;
    let mut text = rigid_balls(n);
    add_contacts(&mut text, n, 30);
    let (code, err) = checked(&text);
    assert!(code == Some(0) && err.contains("60000 contacts"), "{err}");
}

#[test]
fn surfaces_of_equal_bodies_are_prepared_once() {
    let n = 200;
    let mut text =
        rigid_balls(n).replace("\"sphere\", radius = 0.01", "\"ellipsoid\", semi_axes = [0.01, 0.01, 0.012]");
    add_contacts(&mut text, n, 10);
    let (code, err) = checked(&text);
    assert!(code == Some(0) && err.contains("2000 contacts"), "{err}");
}

#[cfg(target_os = "linux")]
#[test]
fn empty_lines_and_comments_take_no_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = rigid_balls(1);
    for filling in ["\n", "# nothing\n", "  \r\n"] {
        let n = 10_000_000 / filling.len();
        std::fs::write(folder.path().join("s.toml"), filling.repeat(n) + &text + &filling.repeat(n))
            .expect("written");
        // 20 MB of text, of which the parser would make a gigabyte; the program itself takes some 100 MB of addresses.
        let script = "ulimit -v 400000 && exec \"$0\" check s.toml";
        let output = Command::new("sh").args(["-c", script, PROGRAM]).current_dir(folder.path()).output();
        let output = output.expect("a shell");
        let err = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.status.code() == Some(0) && err.contains("1 bodies"), "{filling:?}: {err}");
    }
}

#[test]
fn thousands_of_attributes_of_a_tag_are_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let attributes: String = (0..200_000).map(|i| format!(" attribute_of_no_meaning_{i}=\"1\"")).collect();
    std::fs::write(folder.path().join("a.xml"), format!("<xml{attributes}/>")).expect("written");
    let text =
        rigid_balls(1).replace("\"sphere\", radius = 0.01", "\"nurbs\", file = \"a.xml\", units = \"mm\"");
    let (code, err) = checked_in(folder.path(), &text);
    assert!(code == Some(3) && err.contains("more than 100 attributes"), "{err}");
}

/// Runs `text` and gives the peak force of its first impact and the file.
fn peak_of_run(folder: &Path, text: &str) -> (f64, hdf5::File) {
    std::fs::write(folder.join("s.toml"), text).expect("written");
    let output = Command::new(PROGRAM).args(["run", "s.toml", "-q"]).current_dir(folder).output();
    let output = output.expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let file = result_files::file::hdf5_integrity::open(&folder.join("s.h5")).expect("a result");
    let impacts = file.dataset("impacts").and_then(|table| table.read_raw::<ImpactRow>()).expect("impacts");
    assert_eq!(impacts.len(), 1);
    (impacts[0].peak_force, file)
}

/// The sum of the rows of `/timings` \[s\]; that of models kept between runs is part of others.
fn told(file: &hdf5::File) -> f64 {
    let seconds = |stage| file.dataset(&format!("timings/{stage}")).and_then(|row| row.read_scalar::<f64>());
    STAGES.into_iter().map(|stage| seconds(stage).expect("a row")).sum()
}

#[test]
fn rows_of_the_timings_are_the_time_of_the_process() {
    // A thousand bodies, whose scenario, start and file take longer than their steps.
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("s.toml"), rigid_balls(1000)).expect("written");
    let seconds_of = |arguments: &[&str]| {
        let begin = Instant::now();
        let output = Command::new(PROGRAM).args(arguments).current_dir(folder.path()).output();
        assert!(output.expect("it starts").status.success());
        begin.elapsed().as_secs_f64()
    };
    // What no row can have is the start and the end of the process, as of one that does nothing (ten of them), and the closing of the
    // file, whose size at a tenth of a disk's speed, 100 MB/s, is some hundredths of a second. Where other processes take turns, one of
    // three runs is to show that.
    let mut seen = Vec::new();
    let is_told = (0..3).any(|_| {
        let nothing = seconds_of(&["--version"]);
        let all = seconds_of(&["run", "s.toml", "-q", "--force"]);
        let file = result_files::file::hdf5_integrity::open(&folder.path().join("s.h5")).expect("a result");
        let sum = told(&file);
        seen.push((sum, all, nothing));
        assert!(sum <= all, "{seen:?}");
        all - sum <= 10.0 * nothing + file.size() as f64 / 1e7
    });
    assert!(is_told, "rows, the whole, a process that does nothing: {seen:?} s");
}

#[test]
fn contacts_of_bodies_far_apart_take_no_time_and_no_space() {
    // The first of 30 balls, with contacts between all of them, flies into the second: 435 contacts, one of which is near
    // a touch. Each look at one of the others placed all bodies, and the list of scales grew with the square of the datasets.
    let scenario = |n: usize| {
        let mut text = rigid_balls(n).replace("end_time = 1e-6", "end_time = 1e-4");
        for i in 0..n {
            let old = format!("position = [{}, 0, 0]\n", 0.03 * i as f64);
            let way = if i == 0 { "velocity = [1, 0, 0]\n" } else { "" };
            let place = if i < 2 { 0.02001 * i as f64 } else { 0.03 * i as f64 };
            text = text.replacen(&old, &format!("position = [{place}, 0, 0]\n{way}"), 1);
            for k in 0..i {
                let _ = write!(
                    text,
                    "[contacts.c{k}-{i}]\ncontact_body = \"a{k}\"\ntarget_body = \"a{i}\"\nmodel = \"hertz\"\n"
                );
            }
        }
        text
    };
    let folders = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    let (alone, _) = peak_of_run(folders[0].path(), &scenario(2));
    let begin = Instant::now();
    let (among, file) = peak_of_run(folders[1].path(), &scenario(30));
    let elapsed = begin.elapsed();
    assert!(elapsed < SECONDS, "{} s", elapsed.as_secs());
    let sum = told(&file);
    assert!((0.5..=1.0).contains(&(sum / elapsed.as_secs_f64())), "{sum} s of {elapsed:?}");
    // Steps are those of another norm, to the same relative error of 1e-6 or so.
    assert!((among / alone - 1.0).abs() < 1e-5, "{among} {alone}");
    // What is zero throughout is left out and reads as zeros.
    let still = file.dataset("contacts/c7-20/normal_force").expect("a dataset");
    assert_eq!((still.num_chunks(), still.size()), (Some(0), file.dataset("time").expect("times").size()));
    assert!(still.read_raw::<f64>().expect("numbers").iter().all(|force| *force == 0.0));
    // 435 contacts and 30 bodies have 5,800 datasets, 14 MB when they had chunks of 256 rows.
    assert!(file.size() < 20_000_000, "{}", file.size());
}

#[test]
fn flexible_bodies_far_apart_cost_an_impact_nothing() {
    // The first of 14 balls on an axis, with contacts between all of them, flies into the second. In each step of the impact the
    // other 90 contacts were searched, those with fine models asked all of them for their coordinates, and each kept buffers.
    let scenario = |n: usize| {
        let mut text = "[simulation]\nend_time = 1e-4\n".to_owned();
        for i in 0..n {
            let (z, speed) =
                (if i < 2 { 0.02001 * i as f64 } else { 0.03 * i as f64 }, if i == 0 { 1 } else { 0 });
            let _ = write!(
                text,
                "[bodies.a{i}]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\nposition = [0, 0, {z}]\nvelocity = [0, 0, {speed}]\n\
                 geometry = {{ shape = \"sphere\", radius = 0.01 }}\n"
            );
            for k in 0..i {
                let _ =
                    write!(text, "[contacts.c{k}-{i}]\ncontact_body = \"a{k}\"\ntarget_body = \"a{i}\"\n");
            }
        }
        text
    };
    let folders = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    let (alone, _) = peak_of_run(folders[0].path(), &scenario(2));
    let begin = Instant::now();
    let (among, file) = peak_of_run(folders[1].path(), &scenario(14));
    assert!(begin.elapsed() < SECONDS, "{} s", begin.elapsed().as_secs());
    // As among rigid balls.
    assert!((among / alone - 1.0).abs() < 1e-5, "{among} {alone}");
    // Eight times as many bodies and ninety times as many contacts: twice the time of the two bodies' impact for all there is but
    // for what grows with the bodies, models and states.
    let search = file.dataset("timings/search").and_then(|row| row.read_scalar::<f64>()).expect("a row");
    assert!(search < 0.5, "{search} s");
}
