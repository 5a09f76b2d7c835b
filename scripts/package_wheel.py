#!/usr/bin/env python3
"""Makes one wheel of the program and the Python package: `pip install` of it gives `fbimpact` the command and `fbimpact` the module.

Usage: scripts/package_wheel.py [FOLDER] [--program PROGRAM]; the wheel goes to FOLDER (target/wheels). Without PROGRAM the program is
built with cargo, profile "dist". The same file is the build backend (PEP 517) of `pip install .`, which takes PROGRAM from the environment
variable FBIMPACT_PROGRAM. A build leaves nothing among the sources: cargo works in CARGO_TARGET_DIR or in a folder that is removed.

The tag of the wheel says which C library the program needs at least: it is read from the program.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
NAME = "fbimpact"
LICENCES = ["LICENSE", "LICENSE-MIT", "LICENSE-APACHE", "licenses/*", "crates/result-files/assets/*LICENSE", "crates/fbimpact/assets/report/*LICENSE"]
# Libraries that every Linux with the C library of GNU has (PEP 600, manylinux); a program that needs others fits this machine alone.
ALLOWED = re.compile(r"(ld-linux[\w-]*|libc|libm|libdl|libpthread|librt|libgcc_s)\.so\.\d+$")
# Of members of the archives, so that the same program gives the same wheel.
STAMP = (1980, 1, 1, 0, 0, 0)


class Elf:
    """What a program of 64 bits, little endian, needs to start."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        start, size, n = struct.unpack_from("<Q", data, 40)[0], *struct.unpack_from("<HH", data, 58)
        # Of each section: type, place, length, linked section, entries.
        heads = [struct.unpack_from("<IIQQQQII", data, start + i * size) for i in range(n)]
        self.sections = [(head[1], head[4], head[5], head[6], head[7]) for head in heads]

    @staticmethod
    def is_read(data: bytes) -> bool:
        return data[:6] == b"\x7fELF\x02\x01"

    def text(self, section: int, at: int) -> str:
        begin = self.sections[section][1] + at
        return self.data[begin : self.data.index(b"\0", begin)].decode()

    def libraries(self) -> list[str]:
        """Shared libraries (DT_NEEDED)."""
        found = []
        for kind, place, length, linked, _ in self.sections:
            if kind == 6:
                entries = (struct.unpack_from("<QQ", self.data, at) for at in range(place, place + length, 16))
                found += [self.text(linked, value) for tag, value in entries if tag == 1]
        return found

    def versions(self) -> list[str]:
        """Versions of symbols that they must have (SHT_GNU_verneed), such as "GLIBC_2.17"."""
        found = []
        for kind, at, _, linked, n in self.sections:
            for _ in range(n if kind == 0x6FFFFFFE else 0):
                auxiliaries, first, following = struct.unpack_from("<HxxxxII", self.data, at + 2)
                aux = at + first
                for _ in range(auxiliaries):
                    name, step = struct.unpack_from("<II", self.data, aux + 8)
                    found.append(self.text(linked, name))
                    aux += step
                at += following
        return found


def platform_tag(program: bytes) -> str:
    """Where the program runs: on Linux what its C library must be at least."""
    own = re.sub(r"[-.]", "_", sysconfig.get_platform())
    if not Elf.is_read(program):
        return own
    elf = Elf(program)
    foreign = [name for name in elf.libraries() if not ALLOWED.match(name)]
    glibc = [tuple(map(int, v.removeprefix("GLIBC_").split("."))) for v in elf.versions() if re.match(r"GLIBC_[\d.]+$", v)]
    if foreign or not glibc:
        print(f"{NAME}: the wheel is for this machine alone: {', '.join(foreign) or 'no C library of GNU'}", file=sys.stderr)
        return own
    major, minor = max(glibc)[:2]
    return f"manylinux_{major}_{minor}_{own.removeprefix('linux_')}"


def manifest() -> dict:
    return tomllib.loads((ROOT / "Cargo.toml").read_text())


def metadata() -> str:
    """METADATA: that of the Python package, with the version of the program."""
    project = tomllib.loads((ROOT / "scripts/python/pyproject.toml").read_text())["project"]
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {NAME}",
        f"Version: {manifest()['workspace']['package']['version']}",
        f"Summary: {manifest()['package']['description']}",
        "License-Expression: MIT OR Apache-2.0",
        *(f"License-File: {name}" for name, _ in licences()),
        f"Requires-Python: {project['requires-python']}",
        *(f"Requires-Dist: {name}" for name in project["dependencies"]),
    ]
    for extra, names in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f'Requires-Dist: {name}; extra == "{extra}"' for name in names)]
    readme = (ROOT / "README.md").read_text()
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", readme])


def licences() -> list[tuple[str, bytes]]:
    """Texts of the licences of all that is in the wheel, by the path from the top."""
    files = sorted(file for pattern in LICENCES for file in ROOT.glob(pattern))
    return [(file.relative_to(ROOT).as_posix(), file.read_bytes()) for file in files]


def build_program(folder: pathlib.Path) -> pathlib.Path:
    """Builds the program with cargo below `folder`."""
    if shutil.which("cargo") is None:
        sys.exit(f"{NAME}: building needs Rust {manifest()['workspace']['package']['rust-version']} or later (https://rustup.rs) and a C compiler")
    command = ["cargo", "build", "--locked", "--profile", "dist", "--bin", NAME, "--target-dir", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, stdout=sys.stderr)
    return folder / "dist" / (NAME + (".exe" if os.name == "nt" else ""))


def without_symbols(program: pathlib.Path) -> bytes:
    """The program as it is shipped: names for debuggers take most of a build of profile "release"."""
    if shutil.which("strip") is None or not Elf.is_read(program.read_bytes()):
        return program.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder, NAME)
        shutil.copy(program, copy)
        subprocess.run(["strip", "--strip-unneeded", copy], check=True)
        return copy.read_bytes()


def write(folder: pathlib.Path, program: pathlib.Path) -> str:
    """Writes the wheel; returns the name of its file."""
    content = without_symbols(program)
    version, tag = manifest()["workspace"]["package"]["version"], f"py3-none-{platform_tag(content)}"
    info = f"{NAME}-{version}.dist-info"
    package = ROOT / "scripts/python" / NAME
    members = [(f"{NAME}/{file.name}", file.read_bytes()) for file in sorted(package.iterdir()) if file.suffix in (".py", ".typed")]
    script = f"{NAME}-{version}.data/scripts/{NAME}{'.exe' if os.name == 'nt' else ''}"
    members.append((script, content))
    members += [(f"{info}/licenses/{name}", text) for name, text in licences()]
    wheel = f"Wheel-Version: 1.0\nGenerator: {NAME}\nRoot-Is-Purelib: false\nTag: {tag}\n"
    members += [(f"{info}/METADATA", metadata().encode()), (f"{info}/WHEEL", wheel.encode())]
    record = "".join(f"{name},sha256={digest(data)},{len(data)}\n" for name, data in members) + f"{info}/RECORD,,\n"
    members.append((f"{info}/RECORD", record.encode()))
    folder.mkdir(parents=True, exist_ok=True)
    name = f"{NAME}-{version}-{tag}.whl"
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        path = pathlib.Path(scratch, name)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for member, data in members:
                head = zipfile.ZipInfo(member, STAMP)
                head.compress_type = zipfile.ZIP_DEFLATED
                head.external_attr = (0o100755 if member == script else 0o100644) << 16
                archive.writestr(head, data)
        path.replace(folder / name)
    return name


def digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


# The hooks of PEP 517.


def get_requires_for_build_wheel(config_settings=None) -> list[str]:
    """HDF5 is compiled with cmake; where there is none, pip brings it."""
    return [] if os.environ.get("FBIMPACT_PROGRAM") or shutil.which("cmake") else ["cmake>=3.26,<5"]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None) -> str:
    folder, given = pathlib.Path(wheel_directory), os.environ.get("FBIMPACT_PROGRAM")
    if given:
        return write(folder, pathlib.Path(given))
    if target := os.environ.get("CARGO_TARGET_DIR"):
        return write(folder, build_program(ROOT / target))
    with tempfile.TemporaryDirectory(prefix="fbimpact-build-") as target:
        return write(folder, build_program(pathlib.Path(target)))


def build_sdist(sdist_directory, config_settings=None) -> str:
    """All that is tracked by git."""
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    stem = f"{NAME}-{manifest()['workspace']['package']['version']}"
    with tarfile.open(pathlib.Path(sdist_directory, f"{stem}.tar.gz"), "w:gz") as archive:
        for name in sorted(filter(None, tracked.split("\0"))):
            archive.add(ROOT / name, f"{stem}/{name}", recursive=False)
        head = tarfile.TarInfo(f"{stem}/PKG-INFO")
        text = metadata().encode()
        head.size = len(text)
        archive.addfile(head, io.BytesIO(text))
    return f"{stem}.tar.gz"


def main() -> None:
    arguments = sys.argv[1:]
    if "--program" in arguments:
        at = arguments.index("--program")
        os.environ["FBIMPACT_PROGRAM"] = arguments[at + 1]
        del arguments[at : at + 2]
    folder = pathlib.Path(arguments[0] if arguments else ROOT / "target/wheels").resolve()
    print(folder / build_wheel(folder))


if __name__ == "__main__":
    main()
