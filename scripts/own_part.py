#!/usr/bin/env python3
"""Follow docs/own_part.md, section "From STEP to an impact": write its files, run its commands, check what comes of them.

Usage: own_part.py [FOLDER] [--fbimpact PROGRAM]; needs Gmsh's Python module (pip install gmsh). Files and commands are taken from the page: blocks
whose first line is a comment with a file's name, and blocks of the shell. The words of a command stand in the page as they are run; `fbimpact` is the
program given, `gmsh` the module, so that no other installation is met.
"""

import argparse
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs/own_part.md"
SECTION = "## From STEP to an impact"
GMSH = "import sys, gmsh; gmsh.initialize(sys.argv, run=True); gmsh.finalize()"


def blocks(page):
    """Kind and lines of the blocks of the section, in order."""
    text = page.split(SECTION + "\n", 1)[1].split("\n## ", 1)[0]
    for kind, body in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield kind, body


def command(words, program):
    """What is run for the words of a line."""
    if words[0] == "gmsh":
        return [sys.executable, "-c", GMSH, *words[1:]]
    if words[0] == "fbimpact":
        return [program, *words[1:]]
    raise SystemExit(f"own_part.py: the page has a command that is not known here: {words[0]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--fbimpact", default="fbimpact")
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    found = 0
    for kind, body in blocks(PAGE.read_text(encoding="utf-8")):
        if kind != "sh":
            name = re.match(r"(?://|#) (\S+)", body).group(1)
            (folder / name).write_text(body, encoding="utf-8")
            print(f"{name} written", flush=True)
            continue
        for line in body.splitlines():
            words = shlex.split(line, comments=True)
            if not words:
                continue
            print("$ " + " ".join(words), flush=True)
            done = subprocess.run(command(words, arguments.fbimpact), cwd=folder, check=False, capture_output=True, text=True)
            print(done.stdout[-600:] + done.stderr[-600:], flush=True)
            if done.returncode:
                raise SystemExit(f"own_part.py: exit code {done.returncode} of: {line}")
            found += 1
    pictures = list(folder.glob("**/*.vtu"))
    if not found or not pictures:
        raise SystemExit("own_part.py: no commands, or no picture")
    print(f"{folder}: {found} commands, {len(pictures)} pictures")


if __name__ == "__main__":
    main()
