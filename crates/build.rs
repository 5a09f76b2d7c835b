//! Records where a build comes from: commit, compiler and target, for `--version` and the result files.

use std::process::Command;

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let out = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(out.stdout).ok()?.trim().to_owned();
    (out.status.success() && !text.is_empty()).then_some(text)
}

fn main() {
    let unknown = || "unknown".to_owned();
    let commit = output("git", &["describe", "--always", "--dirty"]).unwrap_or_else(unknown);
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let compiler = output(&rustc, &["--version"]).unwrap_or_else(unknown);
    println!("cargo:rustc-env=FBIMPACT_COMMIT={commit}");
    println!("cargo:rustc-env=FBIMPACT_COMPILER={compiler}");
    println!("cargo:rustc-env=FBIMPACT_TARGET={}", std::env::var("TARGET").unwrap_or_else(|_| unknown()));
    // HEAD changes with the branch, its log with every commit; where they are, git knows: not below `.git` in a linked work tree.
    let of_git = ["HEAD", "logs/HEAD"].map(|file| output("git", &["rev-parse", "--git-path", file]));
    // Sources that differ from the commit make the build dirty; without any path cargo would look at the whole package.
    let sources = ["Cargo.toml", "crates"].map(str::to_owned);
    for path in of_git.into_iter().flatten().chain(sources) {
        if std::path::Path::new(&path).exists() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}
