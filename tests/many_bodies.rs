//! Scenarios of thousands of bodies and contacts, and files that are mostly nothing, are read in seconds.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

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
