//! What is published: complete metadata of all crates, permissive licences of all that is linked.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Licences that ask for no more than to be named; the list of `deny.toml` and what stands in its place in some manifests.
const PERMISSIVE: [&str; 11] = [
    "MIT",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "Unlicense",
    "Unicode-3.0",
    "0BSD",
    "LLVM-exception",
    "CC0-1.0",
];

/// `cargo metadata` for the machine that the test runs on, from what is downloaded.
fn metadata() -> Value {
    let target = fbimpact_target();
    let mut command = Command::new(env!("CARGO"));
    command.args([
        "metadata",
        "--format-version",
        "1",
        "--offline",
        "--locked",
        "--filter-platform",
        &target,
    ]);
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn fbimpact_target() -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_fbimpact")).arg("--version").output().expect("the program starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let line = text.lines().find_map(|l| l.strip_prefix("target:")).expect("a target");
    line.trim().to_owned()
}

/// Whether a choice among the licences of an SPDX expression is permissive.
fn is_permissive(expression: &str) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let (value, rest) = alternatives(&words);
    value && rest.is_empty()
}

fn alternatives<'a>(words: &'a [&'a str]) -> (bool, &'a [&'a str]) {
    let (mut value, mut rest) = conjunction(words);
    while let Some((&"OR", after)) = rest.split_first() {
        let (other, next) = conjunction(after);
        (value, rest) = (value || other, next);
    }
    (value, rest)
}

fn conjunction<'a>(words: &'a [&'a str]) -> (bool, &'a [&'a str]) {
    let (mut value, mut rest) = licence(words);
    while let Some((&("AND" | "WITH"), after)) = rest.split_first() {
        let (other, next) = licence(after);
        (value, rest) = (value && other, next);
    }
    (value, rest)
}

fn licence<'a>(words: &'a [&'a str]) -> (bool, &'a [&'a str]) {
    match words.split_first() {
        Some((&"(", after)) => {
            let (value, rest) = alternatives(after);
            (value, rest.get(1..).unwrap_or_default())
        }
        Some((name, rest)) => (PERMISSIVE.contains(name), rest),
        None => (false, words),
    }
}

#[test]
fn expressions_are_read_as_spdx_does() {
    for good in
        ["MIT", "MIT/Apache-2.0", "(MIT OR GPL-3.0) AND Unicode-3.0", "Apache-2.0 WITH LLVM-exception OR MIT"]
    {
        assert!(is_permissive(good), "{good}");
    }
    for bad in ["GPL-3.0", "MIT AND GPL-3.0", "", "(MIT OR Apache-2.0) AND LGPL-2.1"] {
        assert!(!is_permissive(bad), "{bad}");
    }
}

#[test]
fn all_that_is_linked_has_a_permissive_licence() {
    let metadata = metadata();
    let packages = metadata["packages"].as_array().expect("a list");
    let nodes = metadata["resolve"]["nodes"].as_array().expect("a list");
    assert!(nodes.len() > 100, "{}", nodes.len());
    for node in nodes {
        let package = packages.iter().find(|p| p["id"] == node["id"]).expect("a package");
        let name = package["name"].as_str().expect("a name");
        // It names a file: the BSD licence of the HDF5 Group (deny.toml).
        let is_hdf5 = name == "hdf5-metno-src";
        assert!(
            is_hdf5 || package["license"].as_str().is_some_and(is_permissive),
            "{name}: {}",
            package["license"]
        );
    }
}

#[test]
fn every_crate_says_what_it_is() {
    let metadata = metadata();
    let members = metadata["workspace_members"].as_array().expect("a list");
    let packages = metadata["packages"].as_array().expect("a list");
    let own: Vec<&Value> = packages.iter().filter(|p| members.contains(&p["id"])).collect();
    assert_eq!(own.len(), 5);
    for package in own {
        let name = &package["name"];
        for key in ["description", "license", "readme", "rust_version"] {
            assert!(package[key].as_str().is_some_and(|v| !v.is_empty()), "{name}: {key}");
        }
        for key in ["keywords", "categories"] {
            let n = package[key].as_array().map_or(0, Vec::len);
            assert!((1..=5).contains(&n), "{name}: {key}");
        }
        let folder =
            Path::new(package["manifest_path"].as_str().expect("a path")).parent().expect("a folder");
        for file in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(folder.join(file).is_file(), "{name}: {file}");
        }
        // A path alone cannot be published.
        for dependency in package["dependencies"].as_array().expect("a list") {
            assert_ne!(dependency["req"], "*", "{name}: {}", dependency["name"]);
        }
    }
}
