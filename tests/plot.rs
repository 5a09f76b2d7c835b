//! `fbimpact plot` from the outside: files, formats, notes and errors.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::support::{fbimpact, simulate};
use tempfile::TempDir;

/// Results that all tests read.
struct Results {
    _folder: TempDir,
    ball: PathBuf,
    slow: PathBuf,
    pair: PathBuf,
    pendulum: PathBuf,
}

static RESULTS: LazyLock<Results> = LazyLock::new(|| {
    let folder = TempDir::new().expect("a folder");
    let at = folder.path();
    Results {
        ball: simulate(at, "sphere_on_plane.toml", "ball.h5", &[]),
        slow: simulate(at, "sphere_on_plane.toml", "slow.h5", &["bodies.ball.velocity=[0,0,-0.05]"]),
        // Springs so soft that another trial follows.
        pair: simulate(
            at,
            "sphere_rod_sphere.toml",
            "pair.h5",
            &["simulation.end_time=1.8e-4", "contacts.first.penalty.initial=3e16"],
        ),
        pendulum: simulate(at, "flexible_pendulum.toml", "pendulum.h5", &["simulation.end_time=0.01"]),
        _folder: folder,
    }
});

/// Draws and returns the folder and the names of what was written.
fn plot(files: &[&Path], options: &[&str]) -> (TempDir, Vec<String>, String) {
    let folder = TempDir::new().expect("a folder");
    let target = folder.path().join("new/folder");
    let texts: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    let target = target.display().to_string();
    let mut arguments = vec!["plot", "-o", &target];
    arguments.extend(texts.iter().map(String::as_str));
    arguments.extend(options);
    let (code, out, err) = fbimpact(&arguments);
    assert_eq!(code, 0, "{err}");
    let name = |line: &str| {
        assert!(Path::new(line).is_file(), "{line} is written");
        Path::new(line).file_name().expect("a name").to_string_lossy().into_owned()
    };
    (folder, out.lines().map(name).collect(), err)
}

fn read(folder: &TempDir, name: &str) -> String {
    std::fs::read_to_string(folder.path().join("new/folder").join(name)).expect("a drawing")
}

#[test]
fn one_result_gives_every_figure_that_it_has_data_for() {
    let (folder, files, err) = plot(&[&RESULTS.pair], &[]);
    let expected = ["energies", "forces", "impact_1", "tries", "point_right_end", "pressure_first"];
    assert_eq!(files, expected.map(|name| format!("pair_{name}.svg")), "{err}");
    let forces = read(&folder, "pair_forces.svg");
    for words in ["normal force [N]", "time [µs]", "impact phase", "free phase", "first", "second"] {
        assert!(forces.contains(words), "{words} is in the figure");
    }
    // The two contacts: one solid, one dashed.
    assert!(forces.contains("#0072B2") && forces.contains("stroke-dasharray=\"70 30\""));
    let trials = read(&folder, "pair_tries.svg");
    for words in
        ["interval used [%]", "penalty factor [N/m³]", "interval width [µm]", "1.1", "accepted", "repeated"]
    {
        assert!(trials.contains(words), "{words} is in the figure");
    }
    let point = read(&folder, "pair_point_right_end.svg");
    assert!(
        point.contains("displacement z [")
            && point.contains("velocity z [")
            && !point.contains("dasharray=\"70")
    );
    let pressure = read(&folder, "pair_pressure_first.svg");
    assert!(pressure.contains("contact pressure [MPa]") && pressure.contains("radius [µm]"));
}

#[test]
fn several_results_are_drawn_into_the_same_figures() {
    let (folder, files, _) =
        plot(&[&RESULTS.ball, &RESULTS.slow], &["--figure", "impacts", "--figure", "energies"]);
    assert_eq!(files, ["comparison_impact_1.svg", "comparison_energies.svg"]);
    let impact = read(&folder, &files[0]);
    assert!(
        impact.contains("ball")
            && impact.contains("slow")
            && impact.contains("time since first contact [µs]")
    );
    assert!(read(&folder, &files[1]).contains("change of the total energy"));
}

#[test]
fn png_has_the_pixels_of_a_page_width() {
    let (folder, files, _) = plot(&[&RESULTS.ball], &["--png", "--svg", "--figure", "forces"]);
    assert_eq!(files, ["ball_forces.svg", "ball_forces.png"]);
    let bytes = std::fs::read(folder.path().join("new/folder/ball_forces.png")).expect("a picture");
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let width = u32::from_be_bytes(bytes[16..20].try_into().expect("four bytes"));
    assert_eq!(width, 1800);
    // An empty picture of this size compresses to some 10 kB.
    assert!(bytes.len() > 20_000, "{} bytes", bytes.len());
}

/// Every kind of figure that these results have, twice: the same bytes, and no word of the converter.
#[test]
fn every_figure_is_a_pdf_of_its_size() {
    for result in [&RESULTS.pair, &RESULTS.ball, &RESULTS.pendulum] {
        let (folder, files, err) = plot(&[result], &["--pdf"]);
        assert!(!files.is_empty() && files.iter().all(|name| name.ends_with(".pdf")), "{files:?}");
        assert!(err.lines().all(|line| line.contains("no figure of")), "{err}");
        let (again, _, _) = plot(&[result], &["--pdf"]);
        for name in &files {
            let bytes = |of: &TempDir| std::fs::read(of.path().join("new/folder").join(name)).expect("a PDF");
            let whole = bytes(&folder);
            assert!(whole.starts_with(b"%PDF-1.4\n") && whole.ends_with(b"\n%%EOF\n"), "{name}");
            // 190 mm are 720 pixels of 0.75 points.
            assert!(whole.windows(19).any(|w| w == b"/MediaBox [0 0 540 "), "{name}");
            assert_eq!(whole, bytes(&again), "{name}");
        }
    }
}

#[test]
fn one_trial_an_impact_makes_no_figure_of_trials() {
    let (_, files, err) = plot(&[&RESULTS.ball], &["--figure", "tries"]);
    assert!(files.is_empty() && err.contains("every impact took one trial"), "{err}");
    assert!(err.contains("WARN"), "it was asked for: {err}");
    let (_, _, err) = plot(&[&RESULTS.ball], &[]);
    assert!(!err.contains("WARN"), "nobody asked for it: {err}");
}

#[test]
fn figures_without_data_are_left_out_with_a_note() {
    let (folder, files, err) = plot(&[&RESULTS.pendulum], &[]);
    assert!(files.contains(&"pendulum_energies.svg".to_owned()));
    assert!(files.contains(&"pendulum_joint_hinge.svg".to_owned()), "{files:?}");
    let hinge = read(&folder, "pendulum_joint_hinge.svg");
    // A rod that starts horizontally: force along x and z, no moment about the free hinge y, none about the others by symmetry.
    assert!(hinge.contains("force [") && hinge.contains("reaction of joint hinge"), "{hinge}");
    assert!(!hinge.contains("moment ["), "round-off is not drawn");
    assert!(
        !files.iter().any(|f| f.contains("impact") || f.contains("forces") || f.contains("tries")),
        "{files:?}"
    );
    assert!(err.contains("no figure of impacts: there are no impacts"), "{err}");
    assert!(err.contains("the scenario has no contacts"), "{err}");
}

#[test]
fn files_that_cannot_be_read_or_written_exit_with_6() {
    let folder = TempDir::new().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("text.h5"), "no HDF5").expect("a file");
    let whole = std::fs::read(&RESULTS.ball).expect("a result");
    std::fs::write(path("half.h5"), &whole[..whole.len() / 2]).expect("a file");
    std::fs::write(path("taken"), "a file where the folder should be").expect("a file");
    let ball = RESULTS.ball.display().to_string();
    for arguments in [
        vec!["plot".to_owned(), path("missing.h5")],
        vec!["plot".to_owned(), path("text.h5")],
        vec!["plot".to_owned(), path("half.h5")],
        vec!["plot".to_owned(), ball.clone(), path("text.h5"), "-o".to_owned(), path("never")],
        vec!["plot".to_owned(), ball, "-o".to_owned(), path("taken")],
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (code, out, err) = fbimpact(&arguments);
        assert_eq!(code, 6, "{arguments:?}: {err}");
        assert!(out.is_empty() && err.contains(folder.path().to_str().expect("UTF-8")), "{err}");
    }
    assert!(!folder.path().join("never").exists(), "nothing is written before all files are read");
}

#[test]
fn unknown_figures_and_too_many_files_exit_with_2() {
    let ball = RESULTS.ball.display().to_string();
    let (code, _, err) = fbimpact(&["plot", &ball, "--figure", "stresses"]);
    assert!(code == 2 && err.contains("energies") && err.contains("tries"), "{err}");
    let mut arguments = vec!["plot"];
    arguments.extend([ball.as_str(); 9]);
    let (code, _, err) = fbimpact(&arguments);
    assert!(code == 2 && err.contains("at most 8"), "{err}");
    assert_eq!(fbimpact(&["plot"]).0, 2);
}

#[test]
fn width_title_and_span_of_time_are_as_asked_for() {
    let options = ["--figure", "energies", "--width", "95", "--no-title", "--from", "2e-5", "--to", "4e-5"];
    let (folder, files, err) = plot(&[&RESULTS.ball], &options);
    assert_eq!(files, ["ball_energies.svg"], "{err}");
    let narrow = read(&folder, "ball_energies.svg");
    assert!(narrow.contains("width=\"360\""), "half of the 720 pixels of 190 mm");
    let (folder, _, _) = plot(&[&RESULTS.ball], &["--figure", "energies"]);
    let wide = read(&folder, "ball_energies.svg");
    assert!(wide.contains("width=\"720\"") && wide.contains(": energies") && !narrow.contains(": energies"));
    // A span in which no impact begins has no figure of one.
    let (_, files, err) = plot(&[&RESULTS.ball], &["--figure", "impacts", "--from", "2e-5"]);
    assert!(files.is_empty() && err.contains("there are no impacts"), "{err}");
    let ball = RESULTS.ball.display().to_string();
    for (options, words) in [
        (["--from", "1", "--to", "2"], "no stored state between them"),
        (["--width", "20", "--to", "1"], "from 60 to 1000 mm"),
    ] {
        let (code, _, err) = fbimpact(&[&["plot", &ball, "-o", "/nowhere"], &options[..]].concat());
        assert!(code == 2 && err.contains(words), "{code} {err}");
    }
}

#[test]
fn lines_of_stress_are_drawn_over_their_distance() {
    let (folder, files, _) = plot(&[&RESULTS.ball], &["--figure", "stress"]);
    assert_eq!(files, ["ball_line_axis.svg"]);
    let drawn = read(&folder, "ball_line_axis.svg");
    for words in ["stress along axis at", "von Mises", "stress [MPa]", "distance [", "\nzz\n", "\ntt\n"] {
        assert!(drawn.contains(words), "{words}");
    }
    let (folder, files, _) = plot(&[&RESULTS.ball, &RESULTS.slow], &["--figure", "stress"]);
    assert_eq!(files, ["comparison_line_axis.svg"]);
    let both = read(&folder, "comparison_line_axis.svg");
    assert!(
        both.contains("stress von Mises [MPa]") && both.contains("\nball\n") && both.contains("\nslow\n")
    );
    let (_, _, err) = plot(&[&RESULTS.pair], &["--figure", "stress"]);
    assert!(err.contains("no figure of stress: the scenario asks for no lines"), "{err}");
}

#[test]
fn curves_that_coincide_are_seen_in_the_gaps_of_each_other() {
    let files: [&Path; 2] = [&RESULTS.ball, &RESULTS.ball];
    let (folder, _, _) = plot(&files, &["--figure", "forces"]);
    let drawn = read(&folder, "comparison_forces.svg");
    // The solid curve lies below the one with dashes; in the legend they come first.
    let last = |colour: &str| drawn.rfind(&format!("stroke=\"{colour}\"")).expect("a curve");
    assert!(last("#0072B2") < last("#D55E00"));
}

#[test]
fn legends_show_values_that_differ() {
    let files: [&Path; 2] = [&RESULTS.ball, &RESULTS.slow];
    let (folder, _, _) = plot(&files, &["--figure", "impacts", "--labels", "values"]);
    let drawn = read(&folder, "comparison_impact_1.svg");
    assert!(drawn.contains("\nvelocity = [0, 0, -0.1]\n") && drawn.contains("\nvelocity = [0, 0, -0.05]\n"));
    assert!(!drawn.contains("\nslow\n"));
}

/// Place, size and words of a text of a drawing.
struct Text {
    at: [f64; 2],
    size: f64,
    is_centred: bool,
    words: String,
}

/// The texts of a drawing that lie flat.
fn texts(drawn: &str) -> Vec<Text> {
    let pieces = drawn.split("<text ").skip(1).filter(|piece| !piece.contains("rotate"));
    let of = |piece: &str| {
        let number = |name: &str| {
            let (_, rest) = piece
                .split_once(&format!(" {name}=\""))
                .or_else(|| piece.split_once(&format!("{name}=\"")))?;
            rest.split('"').next()?.parse::<f64>().ok()
        };
        let words = piece.split_once('>')?.1.split("</text>").next()?.trim().to_owned();
        let is_centred = piece.contains("text-anchor=\"middle\"");
        Some(Text { at: [number("x")?, number("y")?], size: number("font-size")?, is_centred, words })
    };
    pieces.filter_map(of).collect()
}

/// In a column and on a page of a journal: labels of axes stand apart, and a figure of one pair of axes is wider than tall.
#[test]
fn narrow_figures_have_labels_that_stand_apart_and_are_wider_than_tall() {
    for width in ["85", "170"] {
        for result in [&RESULTS.pair, &RESULTS.ball, &RESULTS.pendulum] {
            let (folder, files, _) = plot(&[result], &["--no-title", "--width", width]);
            assert!(!files.is_empty());
            for name in &files {
                let drawn = read(&folder, name);
                let all = texts(&drawn);
                assert!(all.len() > 8, "{name}: {} texts", all.len());
                // Digits of the font are 0.636 of its size wide.
                let half = |t: &Text| 0.5 * 0.636 * t.size * t.words.chars().count() as f64;
                let labels =
                    all.iter().filter(|t| t.is_centred && t.words.chars().any(|c| c.is_ascii_digit()));
                let labels: Vec<&Text> = labels.collect();
                for (i, a) in labels.iter().enumerate() {
                    for b in labels[..i].iter().filter(|b| (b.at[1] - a.at[1]).abs() < 0.5 * a.size) {
                        let gap = (a.at[0] - b.at[0]).abs() - half(a) - half(b);
                        assert!(gap > 0.0, "{name} at {width} mm: {} and {} touch", b.words, a.words);
                    }
                }
                let number = |key: &str| {
                    let (_, rest) = drawn.split_once(&format!(" {key}=\"")).expect("a size");
                    rest.split('"').next().and_then(|n| n.parse::<f64>().ok()).expect("a number")
                };
                let is_single = name.contains("impact") || name.contains("_forces");
                assert!(
                    !is_single || number("height") < 0.85 * number("width"),
                    "{name} at {width} mm is tall"
                );
            }
        }
    }
}
