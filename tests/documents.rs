//! What the pages say holds: their links lead somewhere, the book has them all, the commands of the tutorial work and say what stands
//! there, the tables of the result reference are those of the program.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All Markdown pages under `folder`.
fn pages(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("readable") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            pages(&path, out);
        } else if path.extension().is_some_and(|e| e == "md") {
            out.push(path);
        }
    }
}

/// Text without code, where brackets are no links.
fn prose(page: &str) -> String {
    let mut fenced = false;
    let lines = page.lines().filter(|line| {
        let is_fence = line.trim_start().starts_with("```");
        fenced ^= is_fence;
        !fenced && !is_fence
    });
    // Links may stand inside of a pair of backticks only as `[..](..)` does: not at all.
    lines.collect::<Vec<_>>().join("\n")
}

fn links(page: &str) -> Vec<String> {
    let prose = prose(page);
    let ends = prose.match_indices("](").map(|(i, _)| &prose[i + 2..]);
    let targets = ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target.trim().to_owned()));
    targets
        .filter(|t| !t.contains("://") && !t.starts_with("mailto:") && !t.contains(['$', '\\', ' ']))
        .collect()
}

/// Headings as GitHub and mdbook name them.
fn anchors(page: &str) -> Vec<String> {
    let headings = page.lines().filter(|l| l.starts_with('#')).map(|l| l.trim_start_matches('#').trim());
    let name = |h: &str| {
        let kept = h.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
    };
    headings.map(name).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let mut files: Vec<PathBuf> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|f| root().join(f)).to_vec();
    pages(&root().join("docs"), &mut files);
    let mut n = 0;
    for file in files {
        let page = text(&file);
        for link in links(&page) {
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target =
                if path.is_empty() { file.clone() } else { file.parent().expect("a folder").join(path) };
            assert!(target.exists(), "{}: {link}", file.display());
            if !anchor.is_empty() && target.extension().is_some_and(|e| e == "md") {
                assert!(anchors(&text(&target)).iter().any(|a| a == anchor), "{}: {link}", file.display());
            }
            n += 1;
        }
    }
    assert!(n > 50, "links are found: {n}");
}

#[test]
fn book_has_every_page_once() {
    let docs = root().join("docs");
    let mut listed: Vec<PathBuf> =
        links(&text(&docs.join("SUMMARY.md"))).iter().map(|l| docs.join(l)).collect();
    let mut there = Vec::new();
    pages(&docs, &mut there);
    there.retain(|p| !p.ends_with("SUMMARY.md"));
    listed.sort();
    there.sort();
    assert_eq!(listed, there);
}

#[test]
fn figures_of_the_gallery_are_small_and_shown() {
    let page = text(&root().join("docs/gallery.md"));
    let shown = links(&page);
    let mut bytes = 0;
    for entry in std::fs::read_dir(root().join("docs/gallery")).expect("readable") {
        let path = entry.expect("readable").path();
        bytes += std::fs::metadata(&path).expect("there").len();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(shown.contains(&format!("gallery/{name}")), "{name} is shown");
    }
    assert!(bytes < 1_000_000, "{bytes} bytes");
}

#[test]
fn tables_of_the_result_reference_are_those_of_the_program() {
    let output = Command::new(PROGRAM).args(["reference", "results"]).output().expect("the program starts");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    let page = text(&root().join("docs/results.md"));
    let begin = "<!-- begin: fbimpact reference results -->\n";
    let part = page.split_once(begin).and_then(|(_, rest)| rest.split_once("<!-- end -->")).expect("marks").0;
    assert!(
        part == printed,
        "docs/results.md is old: put the output of `fbimpact reference results` between its marks"
    );
}

#[test]
fn every_dataset_of_a_result_is_in_the_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("all.h5");
    let scenario = root().join("scenarios/rigid_double_pendulums.toml");
    let disc = root().join("scenarios/sphere_on_plane.toml");
    let stress = "output.stress.line={body=\"ball\",from=\"bottom\",to=\"top\"}";
    let page = text(&root().join("docs/results.md"));
    for (scenario, set) in [(scenario, "simulation.end_time=0.01"), (disc, stress)] {
        let mut command = Command::new(PROGRAM);
        command.args(["run", "-q", "--set", set, "--force", "-o"]).arg(&path).arg(&scenario);
        assert!(command.status().expect("the program starts").success());
        let mut names = Vec::new();
        let file = hdf5::File::open(&path).expect("readable");
        list(&file, "", &mut names);
        assert!(names.len() > 30);
        for name in names {
            let mut parts: Vec<&str> = name.split('/').collect();
            if matches!(parts[1], "bodies" | "joints" | "contacts" | "pressure" | "points" | "stress") {
                parts[2] = "NAME";
            }
            let last = parts[parts.len() - 1];
            let (path, group) = (parts.join("/"), parts[..parts.len() - 1].join("/"));
            let is_there = page.contains(&format!("`{path}`"))
                || page.lines().any(|l| l.contains(&format!("`{group}/{{")) && l.contains(last));
            assert!(is_there, "{path}");
        }
        for name in file.attr_names().expect("readable") {
            assert!(page.contains(&format!("| `{name}` |")), "attribute {name}");
        }
    }
}

fn list(group: &hdf5::Group, at: &str, names: &mut Vec<String>) {
    for name in group.member_names().expect("readable") {
        let path = format!("{at}/{name}");
        match group.group(&name) {
            Ok(child) => list(&child, &path, names),
            Err(_) => names.push(path),
        }
    }
}

/// Words with numbers in them replaced by `#`, so that times and rounding do not count.
fn without_numbers(line: &str) -> String {
    let words = line.split_whitespace();
    words
        .map(|w| if w.chars().any(|c| c.is_ascii_digit()) && !w.contains('/') { "#" } else { w })
        .collect::<Vec<_>>()
        .join(" ")
}

/// Blocks of the languages `sh` and `text`, in order.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut out: Vec<(String, String)> = Vec::new();
    let mut open = false;
    for line in page.lines() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(language) => {
                open = true;
                out.push((language.to_owned(), String::new()));
            }
            None if open => {
                let block = &mut out.last_mut().expect("an open block").1;
                block.push_str(line);
                block.push('\n');
            }
            None => {}
        }
    }
    out
}

#[test]
fn commands_of_the_tutorial_work_and_say_what_stands_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for name in ["scenarios", "scripts"] {
        std::os::unix::fs::symlink(root().join(name), at.join(name)).expect("linked");
    }
    let programs = Path::new(PROGRAM).parent().expect("a folder").display().to_string();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap_or_default());
    let page = text(&root().join("docs/tutorial.md"));
    let (mut said, mut n) = (String::new(), 0);
    for (language, block) in blocks(&page) {
        if language == "sh" {
            let mut command = Command::new("sh");
            command.args(["-euc", &format!("exec 2>&1\n{block}")]).current_dir(at);
            command.env("PATH", &path).env("RUNNER", "xargs").env("JOBS", "2");
            let output = command.output().expect("a shell");
            said = String::from_utf8(output.stdout).expect("UTF-8");
            assert!(output.status.success(), "{block}{said}");
            n += 1;
        } else if language == "text" {
            let lines: Vec<String> = said.lines().map(without_numbers).collect();
            for wanted in block.lines().filter(|l| *l != "...") {
                assert!(lines.contains(&without_numbers(wanted)), "{wanted}\nis not in\n{said}");
            }
        }
    }
    assert!(n >= 12, "the tutorial has commands: {n}");
}
