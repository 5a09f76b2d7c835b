#!/usr/bin/env python3
"""Checks what is published: complete metadata of all crates, permissive licences of all that is linked, and of each file of others that the
program carries its origin, version, licence and contents. Where `cargo deny` is installed it looks as well, at security advisories if it can
get them.

Usage: scripts/check_packages.py; needs cargo and what it has downloaded for a build.
"""

import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Licences that ask for no more than to be named; the list of deny.toml and what stands in its place in some manifests.
PERMISSIVE = {
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
}
# It names a file: the BSD licence of the HDF5 Group (deny.toml).
NAMES_A_FILE = {"hdf5-metno-src"}

# Of fonts: free to be embedded and passed on.
FONT_LICENCES = {"Bitstream-Vera"}

faults = []


def check(is_right, message):
    if not is_right:
        faults.append(message)


def is_permissive(expression):
    """Whether a choice among the licences of an SPDX expression is permissive."""
    words = re.findall(r"[()]|[^\s()]+", (expression or "").replace("/", " OR "))
    value = alternatives(words)
    return value and not words


def alternatives(words):
    value = conjunction(words)
    while words and words[0] == "OR":
        words.pop(0)
        value = conjunction(words) or value
    return value


def conjunction(words):
    value = licence(words)
    while words and words[0] in ("AND", "WITH"):
        words.pop(0)
        value = licence(words) and value
    return value


def licence(words):
    if not words:
        return False
    if (word := words.pop(0)) != "(":
        return word in PERMISSIVE
    value = alternatives(words)
    if words:
        words.pop(0)
    return value


def check_expressions():
    """Expressions are read as SPDX does."""
    good = ["MIT", "MIT/Apache-2.0", "(MIT OR GPL-3.0) AND Unicode-3.0", "Apache-2.0 WITH LLVM-exception OR MIT"]
    bad = ["GPL-3.0", "MIT AND GPL-3.0", "", "(MIT OR Apache-2.0) AND LGPL-2.1"]
    check(all(map(is_permissive, good)) and not any(map(is_permissive, bad)), "licences are not read as SPDX does")


def metadata():
    version = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    target = re.search(r"^host: (.*)$", version, re.M)[1]
    command = ["cargo", "metadata", "--format-version", "1", "--offline", "--locked", "--filter-platform", target]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout)


def check_licences(data):
    packages = {p["id"]: p for p in data["packages"]}
    linked = [packages[node["id"]] for node in data["resolve"]["nodes"]]
    check(len(linked) > 100, f"only {len(linked)} packages are found")
    for package in linked:
        is_right = package["name"] in NAMES_A_FILE or is_permissive(package["license"])
        check(is_right, f"{package['name']}: the licence {package['license']} is not known as permissive")


def check_own(data):
    members = set(data["workspace_members"])
    own = [p for p in data["packages"] if p["id"] in members]
    check(len(own) == 8, f"{len(own)} crates of our own, eight are expected")
    for package in own:
        for key in ("description", "license", "readme", "rust_version"):
            check(package[key], f"{package['name']}: {key} is missing")
        for key in ("keywords", "categories"):
            check(1 <= len(package[key]) <= 5, f"{package['name']}: {key} must be one to five")
        folder = pathlib.Path(package["manifest_path"]).parent
        for file in ("README.md", "LICENSE-MIT", "LICENSE-APACHE"):
            check((folder / file).is_file(), f"{package['name']}: {file} is missing")
        for dependency in package["dependencies"]:
            name = f"{package['name']}: {dependency['name']}"
            check(dependency["req"] != "*", f"{name} has a path and no version, it cannot be published")
        command = ["cargo", "package", "--list", "--allow-dirty", "--offline", "--package", package["name"]]
        packed = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout.splitlines()
        for target in package["targets"]:
            source = pathlib.Path(target["src_path"])
            is_packed = source.is_relative_to(folder) and str(source.relative_to(folder)) in packed
            check(is_packed or {"test", "bench", "example"} & set(target["kind"]), f"{package['name']}: {source.name} is not in its package")


def check_vendored():
    """Files that the program carries are its own, or stand in the list of their crate as they are."""
    folders = sorted((ROOT / "crates").glob("*/assets"))
    check(len(folders) == 2, f"{len(folders)} crates carry files, two are expected")
    for folder in folders:
        check_assets(folder)


def check_assets(folder):
    listed = json.loads((folder / "vendored.json").read_text())
    named = set(listed["own"])
    for package in listed["vendored"]:
        for key in ("name", "version", "licence", "source"):
            check(package.get(key), f"{package.get('name')}: {key} is missing in vendored.json")
        is_right = package.get("licence") in PERMISSIVE | FONT_LICENCES
        check(is_right, f"{package.get('name')}: the licence {package.get('licence')} is not known as permissive")
        check(any(f.endswith("LICENSE") for f in package["files"]), f"{package.get('name')}: its licence is not among its files")
        for file, digest in package["files"].items():
            path = folder / file
            found = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "missing"
            check(found == digest, f"{file}: SHA-256 is {found}, vendored.json has {digest}")
        named |= set(package["files"])
    there = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    for file in sorted(there ^ named):
        check(False, f"{file}: is in vendored.json or in the folder of assets, and not in both")


def check_deny():
    """What `deny.toml` forbids; advisories come from a network, or from what was fetched before."""
    if shutil.which("cargo-deny") is None:
        print("packages: cargo-deny is not installed, advisories are not looked at")
        return
    for words, needs_network in ((["licenses", "bans", "sources"], False), (["advisories"], True)):
        done = subprocess.run(["cargo", "deny", "check", *words], cwd=ROOT, capture_output=True, text=True)
        if needs_network and done.returncode != 0 and "failed to fetch" in done.stderr:
            print("packages: the network gives no advisories, they are not looked at")
        else:
            check(done.returncode == 0, f"cargo deny check {' '.join(words)}:\n{done.stderr}")


def main():
    check_expressions()
    check_vendored()
    data = metadata()
    check_licences(data)
    check_own(data)
    check_deny()
    for fault in faults:
        print(fault, file=sys.stderr)
    if faults:
        sys.exit(1)
    print("packages: licences are permissive, metadata are complete")


main()
