//! `fbimpact report` from the outside: the page, its numbers against `vtk` and `info`, its size, and what a browser makes of it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use adaptive::store::ModelCache;
use fbimpact::postprocessing::replay::states::{Pose, States};
use fbimpact::postprocessing::report::surface::Surface;
use fbimpact::postprocessing::vtk::bodies::Bodies;
use fbimpact::postprocessing::vtk::bodies::assemble::View;
use fbimpact::postprocessing::vtk::bodies::splines::Cells;
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use result_files::tables::TrialRow;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::page::ReportPage;
use crate::support::{fbimpact, simulate};

/// A title that must be shown and not obeyed.
const FOREIGN: &str = "</script><img src=x onerror=alert(1)> & more";

struct Results {
    _folder: TempDir,
    ball: PathBuf,
    pair: PathBuf,
}

static RESULTS: LazyLock<Results> = LazyLock::new(|| {
    let folder = TempDir::new().expect("a folder");
    let at = folder.path();
    let title = format!("title={FOREIGN:?}");
    Results {
        ball: simulate(at, "sphere_on_plane.toml", "ball.h5", &[&title]),
        pair: simulate(at, "sphere_rod_sphere.toml", "pair.h5", &["simulation.end_time=2.5e-4"]),
        _folder: folder,
    }
});

/// Writes the report and returns it with its folder and what was said.
fn report(files: &[&Path], options: &[&str]) -> (TempDir, ReportPage, String) {
    let folder = TempDir::new().expect("a folder");
    let output = folder.path().join("report.html").display().to_string();
    let mut arguments = vec!["report".to_owned(), "-o".to_owned(), output.clone()];
    arguments.extend(files.iter().map(|file| file.display().to_string()));
    arguments.extend(options.iter().map(|&option| option.to_owned()));
    let (code, out, err) = fbimpact(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!((code, out.trim_end()), (0, output.as_str()), "{err}");
    let text = std::fs::read_to_string(&output).expect("a page");
    (folder, ReportPage::new(text), err)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn rotated(pose: &[f64], v: Vector3<f64>) -> Vector3<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(pose[3], pose[4], pose[5], pose[6])) * v
}

/// Number of the stored state at `time`, which came through JSON.
fn stored(states: &States, time: f64) -> usize {
    let is_it = |t: &f64| (t - time).abs() <= 1e-15 * time.abs();
    states.time.iter().position(is_it).expect("a stored state")
}

/// Sum of `shapes` of the field `key` times the coordinates of frame `t`.
fn combined(page: &ReportPage, body: &Value, key: &str, coordinates: &[Vec<f64>], t: usize) -> Vec<f64> {
    let shapes = body["shapes"].as_array().expect("shapes");
    let mut sum = Vec::new();
    for (shape, q) in shapes.iter().zip(coordinates) {
        let values = page.values(&shape[key]);
        sum.resize(values.len(), 0.0);
        sum.iter_mut().zip(&values).for_each(|(s, v)| *s += q[t] * v);
    }
    sum
}

#[test]
fn decoded_motion_is_that_of_vtk_at_every_vertex() {
    for result in [&RESULTS.ball, &RESULTS.pair] {
        let (_folder, page, err) = report(&[result], &[]);
        assert!(!err.contains("left out"), "a plane has no end, and nobody wonders: {err}");
        let states = States::read(result).expect("states");
        let cells = Cells::Linear(1);
        let mut bodies = Bodies::build(&states, &[], cells, (1, &ModelCache::default())).expect("bodies");
        let at_origin = Pose {
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
        };
        let undeformed = View { scale: 0.0, revolve: None };
        let scene = &page.head["scenes"][0];
        let times: Vec<f64> = scene["time"].as_array().expect("times").iter().map(number).collect();
        let count = |i: usize| scene["bodies"][i]["errors"]["von_mises"].as_f64();
        let all: Vec<Surface> = bodies
            .shown
            .iter()
            .map(|shown| {
                let none = vec![0.0; shown.motion.eigenfrequencies.len()];
                let grid =
                    bodies.displaced(shown, &none, &none).grid(&at_origin, undeformed).expect("a grid");
                Surface::new(&grid, scene["bodies"][0]["around"] != 0)
            })
            .collect();
        for (b, surface) in all.iter().enumerate() {
            let body = &scene["bodies"][b];
            assert!(count(b).is_some_and(|e| e < 1e-3), "the error is told: {}", body["errors"]);
            let (coordinates, rates) = (page.lists(&body["coordinates"]), page.lists(&body["rates"]));
            let (x, poses) = (page.values(&body["x"]), page.values(&body["pose"]));
            let largest = |key: &str| number(&body["largest"][key]);
            for t in (0..times.len()).step_by(37) {
                let i = stored(&states, times[t]);
                let drawn = {
                    let shown = &bodies.shown[b];
                    bodies.displaced(shown, shown.motion.elastic(i), shown.motion.rates(i))
                };
                let pose = bodies.shown[b].motion.pose(i);
                let exact = drawn.grid(&pose, View { scale: 1.0, revolve: None }).expect("a grid");
                let wanted = surface.at_vertices(&exact.displacement);
                let points = surface.at_vertices(&exact.points);
                let velocity = surface.at_vertices(&exact.velocity);
                let stress = surface.at_vertices(&exact.stress);
                let u = combined(&page, body, "displacement", &coordinates, t);
                let v = combined(&page, body, "displacement", &rates, t);
                let s = combined(&page, body, "stress", &coordinates, t);
                let frame = &poses[7 * t..7 * t + 7];
                let size = x.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
                for vertex in 0..surface.len() {
                    let of = |values: &[f64]| Vector3::from_column_slice(&values[3 * vertex..3 * vertex + 3]);
                    let displacement = rotated(frame, of(&u));
                    let error = (displacement - Vector3::from(wanted[vertex])).norm();
                    assert!(
                        error <= 1e-3 * largest("displacement"),
                        "displacement {error} of {}",
                        body["name"]
                    );
                    let place = Vector3::from_column_slice(&frame[..3]) + rotated(frame, of(&x) + of(&u));
                    assert!((place - Vector3::from(points[vertex])).norm() < 1e-4 * size, "place");
                    let spin = pose.angular_velocity.cross(&rotated(frame, of(&x) + of(&u)));
                    let error =
                        pose.velocity + spin + rotated(frame, of(&v)) - Vector3::from(velocity[vertex]);
                    assert!(error.norm() <= 1e-3 * largest("speed"), "velocity {error}");
                    let scalar = von_mises(&std::array::from_fn(|c| s[6 * vertex + c]));
                    let error = (scalar - von_mises(&stress[vertex])).abs();
                    assert!(error <= 1e-3 * largest("von_mises"), "stress {error} of {}", body["name"]);
                }
            }
        }
        // Peaks have the stress of the contact zones.
        let stills = scene["bodies"][0]["stills"].as_array().expect("stills");
        let frame = stills[0]["frame"].as_u64().expect("a number") as usize;
        let i = stored(&states, times[frame]);
        let peak =
            bodies.at(states.time[i], i).expect("drawn")[0].grid(&at_origin, undeformed).expect("a grid");
        let most = peak.von_mises.iter().fold(0.0_f64, |most, s| most.max(s[0]));
        assert!((number(&stills[0]["largest"]) - most).abs() <= 1e-9 * most);
    }
}

/// The zones of `ball` are small; a table of trials that says otherwise stands for a solid body.
#[test]
fn large_contact_zones_are_solved_again_if_they_are_asked_for() {
    let folder = TempDir::new().expect("a folder");
    let copy = folder.path().join("large.h5");
    std::fs::copy(&RESULTS.ball, &copy).expect("a copy");
    let file = hdf5::File::open_rw(&copy).expect("a result");
    let mut rows = file.dataset("tries").and_then(|table| table.read_1d::<TrialRow>()).expect("trials");
    rows.iter_mut().for_each(|row| row.dofs = 50_000);
    file.unlink("tries").expect("gone");
    file.new_dataset_builder().with_data(&rows).create("tries").expect("written");
    file.close().expect("closed");
    let stills = |page: &ReportPage| page.head["scenes"][0]["bodies"][0]["stills"].as_array().map(Vec::len);
    let (_folder, page, told) = report(&[&copy], &[]);
    assert_eq!(stills(&page), Some(0));
    for text in [&page.text, &told] {
        let sentence = "the stress of contact zones is left out at 1 of 1 peaks, as their models have up to 50000 unknowns";
        assert!(text.contains(sentence), "{told}");
    }
    let (_folder, page, told) = report(&[&copy], &["--contact-stress"]);
    assert_eq!((stills(&page), told.contains("contact zones")), (Some(1), false), "{told}");
}

#[test]
fn numbers_are_those_of_info() {
    let (_folder, page, _) = report(&[&RESULTS.pair], &["--no-3d"]);
    let (code, out, _) = fbimpact(&["info", "--json", &RESULTS.pair.display().to_string()]);
    let info: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((code, &page.head["results"][0]), (0, &info));
    for impact in info["impacts"].as_array().expect("impacts") {
        for key in ["peak_force", "start", "duration", "impulse"] {
            assert!(page.text.contains(&format!("data-value=\"{}\"", impact[key])), "{key} of {impact}");
        }
    }
    assert!(page.head["scenes"].as_array().is_some_and(Vec::is_empty));
}

#[test]
fn foreign_text_is_shown_and_nothing_outside_is_referred_to() {
    let (_folder, page, _) = report(&[&RESULTS.ball], &[]);
    assert!(
        !page.text.contains("<img") && page.text.contains("&lt;img src=x onerror=alert(1)&gt; &amp; more")
    );
    assert_eq!(page.head["results"][0]["title"], FOREIGN);
    assert!(page.text.contains("default-src 'none'"));
    for mark in ["src=\"", "href=\"", "url(", "@import", "fetch("] {
        assert!(!page.text.contains(mark), "{mark}");
    }
}

#[test]
fn several_results_stand_side_by_side() {
    let (_folder, page, _) = report(&[&RESULTS.ball, &RESULTS.pair], &["--no-3d"]);
    assert_eq!(page.head["labels"], serde_json::json!(["ball", "pair"]));
    assert!(page.text.contains("<h2>ball</h2>") && page.text.contains("<h2>pair</h2>"));
    let charts = page.head["charts"].as_array().expect("charts");
    assert!(
        charts.iter().any(|c| c["name"] == "energies") && page.text.matches("<svg").count() == charts.len()
    );
}

#[test]
fn size_is_kept_by_coarser_motion_which_is_told() {
    let (_folder, full, err) = report(&[&RESULTS.pair], &[]);
    let size = full.text.len() as f64 / 1e6;
    assert!(size < 5.0 && err.is_empty(), "{size} MB: {err}");
    let (_folder, small, err) = report(&[&RESULTS.pair], &["--max-size", &format!("{}", 0.8 * size)]);
    let note = err.trim().trim_start_matches("WARN ").trim();
    assert!(small.text.len() as f64 <= 0.8e6 * size && note.contains("the report were larger than"), "{err}");
    assert!(small.text.contains(note), "{note}");
    let (_folder, none, err) = report(&[&RESULTS.pair], &["--max-size", "0.1"]);
    assert_eq!(none.head["scenes"][0], Value::Null);
    assert!(err.contains("are left out") && err.contains("alone take"), "{err}");
}

#[test]
fn page_goes_to_standard_output_or_whole_into_its_file() {
    let file = RESULTS.ball.display().to_string();
    let (_folder, page, _) = report(&[&RESULTS.ball], &["--no-3d"]);
    let (code, out, _) = fbimpact(&["report", &file, "-o", "-", "--no-3d"]);
    assert_eq!((code, out == page.text), (0, true));
    let missing = fbimpact(&["report", "missing.h5", "-o", "-"]);
    assert_eq!((missing.0, missing.1.as_str()), (6, ""));
    assert_eq!(fbimpact(&["report", &file, "-o", &file]).0, 6, "the result is not written over");
    let (code, _, err) = fbimpact(&["report", &file, "-o", "-", "--bodies", "bell"]);
    assert!(code == 2 && err.contains("the result has ball"), "{err}");
    assert_eq!(fbimpact(&["report", &file, "-o", "-", "--max-size", "0"]).0, 2);
}

/// What a browser makes of the page: its document after the scripts, and its console; none where there is no browser.
fn browsed(page: &Path, options: &[&str]) -> Option<(String, String)> {
    let usual = ["--headless", "--no-sandbox", "--virtual-time-budget=20000", "--enable-logging=stderr"];
    let run = Command::new("chromium")
        .args(usual)
        .args(options)
        .args(["--dump-dom", &format!("file://{}#test", page.display())])
        .output()
        .ok()?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Some((text(&run.stdout), text(&run.stderr)))
}

#[test]
fn browser_draws_what_the_page_holds() {
    let (folder, page, _) = report(&[&RESULTS.pair], &[]);
    let file = folder.path().join("report.html");
    let Some((document, console)) =
        browsed(&file, &["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
    else {
        return;
    };
    assert!(!console.contains("CONSOLE"), "{console}");
    let told = document.split_once("<pre id=\"test\">").expect("scripts ran to their end").1;
    let told: Value = serde_json::from_str(told.split_once("</pre>").expect("an end").0).expect("JSON");
    assert!(told["charts"].as_u64() > Some(5), "{told}");
    let viewer = &told["viewers"][0];
    assert_eq!(viewer["error"], 0);
    assert!(number(&viewer["covered"]) > 0.002, "{}", viewer["covered"]);
    let bodies = page.head["scenes"][0]["bodies"].as_array().expect("bodies");
    for state in viewer["states"].as_array().expect("states") {
        let t = state["frame"].as_u64().expect("a number") as usize;
        for (b, body) in bodies.iter().enumerate() {
            let coordinates = page.lists(&body["coordinates"]);
            let u = combined(&page, body, "displacement", &coordinates, t);
            let longest = u.as_chunks::<3>().0.iter().map(|u| Vector3::from(*u).norm()).fold(0.0, f64::max);
            // The same numbers in two programs.
            assert!((number(&state["displacement"][b]) - longest).abs() <= 1e-9 * longest, "{state}");
        }
    }
    // Without WebGL the page stays whole.
    let (document, console) = browsed(&file, &["--disable-gpu", "--disable-3d-apis"]).expect("a browser");
    assert!(document.contains("(there is no WebGL2)") && !console.contains("Uncaught"), "{console}");
}
