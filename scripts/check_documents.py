#!/usr/bin/env python3
"""Checks what the pages say: links lead somewhere, the book has every page, figures are shown, pages that the program writes are
those of the program, equations that are cited stand in the theory, claims that tests cite are in the table, the commands, scenarios and Python of some pages work and say what stands there.

Usage: scripts/check_documents.py [PROGRAM]
"""

import importlib.util
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
BEGIN, END = "<!-- begin: fbimpact reference {} -->\n", "<!-- end -->"
LARGEST_GALLERY = 1_000_000  # bytes

faults = []


def check(is_right, message):
    if not is_right:
        faults.append(message)


def name(path):
    return str(path.relative_to(ROOT))


def links(page):
    """Relative targets of the links outside of code blocks."""
    prose, is_fenced = [], False
    for line in page.splitlines():
        if line.lstrip().startswith("```"):
            is_fenced = not is_fenced
        elif not is_fenced:
            prose.append(line)
    targets = [t.strip() for t in re.findall(r"\]\(([^)]*)\)", "\n".join(prose))]
    skipped = ("://", "$", "\\", " ")
    return [t for t in targets if not t.startswith("mailto:") and not any(s in t for s in skipped)]


def anchors(page):
    """Headings as GitHub and mdbook name them."""
    headings = [line.lstrip("#").strip() for line in page.splitlines() if line.startswith("#")]
    kept = ["".join(c for c in h if c.isalnum() or c in " -_") for h in headings]
    return {"".join(c.lower() if c.isascii() else c for c in h).replace(" ", "-") for h in kept}


def check_links():
    pages = [ROOT / f for f in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")]
    n = 0
    for file in pages + sorted(DOCS.rglob("*.md")):
        for link in links(file.read_text()):
            path, _, anchor = link.partition("#")
            target = file.parent / path if path else file
            check(target.exists(), f"{name(file)}: {link} leads nowhere")
            if anchor and target.suffix == ".md" and target.exists():
                check(anchor in anchors(target.read_text()), f"{name(file)}: {link} names no heading")
            n += 1
    check(n > 50, f"only {n} links are found")


def check_book():
    listed = sorted(os.path.normpath(DOCS / link) for link in links((DOCS / "SUMMARY.md").read_text()))
    there = sorted(str(p) for p in DOCS.rglob("*.md") if p.name != "SUMMARY.md")
    for page in set(listed) ^ set(there):
        check(False, f"docs/SUMMARY.md: {page} is not listed, or not there")
    check(len(listed) == len(set(listed)), "docs/SUMMARY.md lists a page twice")
    decided = set(links((DOCS / "decisions/README.md").read_text()))
    for page in sorted((DOCS / "decisions").glob("0*.md")):
        check(page.name in decided, f"docs/decisions/README.md does not list {page.name}")


def check_gallery():
    shown = links((DOCS / "gallery.md").read_text())
    files = sorted((DOCS / "gallery").iterdir())
    for file in files:
        check(f"gallery/{file.name}" in shown, f"docs/gallery.md does not show {file.name}")
    size = sum(f.stat().st_size for f in files)
    check(size < LARGEST_GALLERY, f"docs/gallery takes {size} bytes, at most {LARGEST_GALLERY} are kept")


def check_claims():
    """Tests cite claims of docs/verification.md by number: every number is in the table, and every claim has a test."""
    table = re.search(r"## Claims\n(.*?)\n## ", (DOCS / "verification.md").read_text(), re.S)
    known = set(re.findall(r"^\| (\d+) \|", table[1], re.M)) if table else set()
    cited = set()
    for file in [*ROOT.glob("tests/**/*.rs"), *ROOT.glob("crates/*/tests/**/*.rs")]:
        for number in re.findall(r"claim (\d+) of docs/verification\.md", file.read_text(), re.I):
            check(number in known, f"{name(file)}: there is no claim {number} in docs/verification.md")
            cited.add(number)
    check(known == cited, f"docs/verification.md: no test cites the claims {sorted(known - cited)}")


# A number of the theory: of an equation, or of a section where "section" stands before it. EN 1991-1-1 has a table A.4, too.
NUMBER = re.compile(r"(?<![\w.\\])(?<!table )([A-Z]\.\d{1,3}[a-z]?)(?!\w|\.\d)")
SECTIONS = re.compile(rf"(?:^## |\b[Ss]ections?\s+(?://[/!]\s*)?){NUMBER.pattern}(?:(?:,| and| to)\s+(?://[/!]\s*)?{NUMBER.pattern})*", re.M)
GIVEN = re.compile(r"\\tag\{([^}]*)\}|\*\*\(([A-Z]\.\d+\w?)\)\*\*|\*\*([A-Z]\.\d+\w?)(?=[ .*:])")


def given_numbers():
    """Numbers of equations and of sections that the pages of the theory give: on each of them all from one on, in this order."""
    equations, sections = set(), set()
    for page in sorted((DOCS / "theory").glob("*.md")):
        text = page.read_text()
        part = text[2]
        found = ["".join(match) for match in GIVEN.findall(text)], re.findall(r"^## (\S+)", text, re.M)
        for numbers, kind, known in zip(found, ("equation", "section"), (equations, sections)):
            for n, number in enumerate(numbers, 1):
                check(number == f"{part}.{n}", f"{name(page)}: {kind} {number} stands where {part}.{n} is expected")
            check(not known & set(numbers), f"{name(page)}: part {part} is on two pages")
            known.update(numbers)
    return equations, sections


def check_theory():
    """Equations and sections of the theory are cited by numbers that it has."""
    equations, sections = given_numbers()
    parts = {number[0] for number in equations}
    pages = [*ROOT.glob("*.md"), *ROOT.glob("crates/*/*.md"), *DOCS.rglob("*.md")]
    sources = [f for folder in ("crates", "tests") for f in (ROOT / folder).rglob("*.rs")] + [*(ROOT / "scripts").rglob("*.py")]
    n = 0
    for file in pages + sources:
        text = file.read_text()
        of_sections = {i for span in SECTIONS.finditer(text) for i in range(*span.span())}
        for match in NUMBER.finditer(text):
            if match[1][0] not in parts:
                continue
            is_section = match.start() in of_sections
            known, kind = (sections, "section") if is_section else (equations, "equation")
            check(match[1] in known, f"{name(file)}: the theory has no {kind} {match[1]}")
            n += 1
    check(n > 1000, f"only {n} citations of the theory are found")


def check_written(program):
    def printed(*arguments):
        return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout

    for file, arguments in [("scenario.md", ["reference"]), ("scenario.schema.json", ["schema"])]:
        command = " ".join(["fbimpact", *arguments])
        check((DOCS / file).read_text() == printed(*arguments), f"docs/{file} is old: write `{command}` to it")
    for page in ("results", "expressions"):
        _, _, rest = (DOCS / f"{page}.md").read_text().partition(BEGIN.format(page))
        remedy = f"put the output of `fbimpact reference {page}` between its marks"
        check(rest.partition(END)[0] == printed("reference", page), f"docs/{page}.md is old: {remedy}")
    tolerances = (ROOT / "crates/result-files/src/compare/defaults.toml").read_text()
    check(tolerances in (DOCS / "compare.md").read_text(), "docs/compare.md has not the tolerances of the program")


def without_numbers(line):
    """Words with digits replaced, so that times and rounding do not count."""
    has_digit = lambda w: any(c.isascii() and c.isdigit() for c in w)
    return " ".join("#" if has_digit(w) and "/" not in w else w for w in line.split())


# Pages whose commands are run, and how many there are at least.
RUN = {"../README.md": 5, "warnings.md": 1, "line_contact.md": 1, "friction.md": 1, "rattle.md": 1, "tutorial.md": 12, "histories.md": 2, "expressions.md": 1, "modelling.md": 4, "cookbook.md": 13, "examples.md": 6}
# Pages whose Python is run, one block after the other, and how many there are at least; what it needs.
RUN_PYTHON = {"../README.md": 1, "python.md": 7, "cookbook.md": 3}
NEEDED = ("h5py", "matplotlib", "numpy", "tomli_w", "xarray")
# Pages all of whose scenarios are files: their first line is a comment with the name.
FILES = {"modelling.md", "cookbook.md", "examples.md", "line_contact.md", "friction.md", "rattle.md"}
NAME = re.compile(r"# ([\w-]+\.toml)(, changed| goes on)?")


def environment_of(program):
    path = f"{program.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    own = {"PATH": path, "RUNNER": "xargs", "JOBS": "2", "PYTHONPATH": str(ROOT / "scripts/python"), "MPLBACKEND": "Agg"}
    return {**os.environ, **own, "FBIMPACT": str(program)}


class Python:
    """An interpreter that runs blocks one after the other: each sees what those before it have made."""

    DRIVER = """
import contextlib, io, json, sys, traceback
names = {"__name__": "__main__"}
for line in sys.stdin:
    said, is_right = io.StringIO(), True
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            exec(json.loads(line), names)
        except BaseException:
            traceback.print_exc()
            is_right = False
    print(json.dumps([is_right, said.getvalue()]), flush=True)
"""

    def __init__(self, folder, environment):
        command = [sys.executable, "-W", "ignore", "-c", self.DRIVER]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, cwd=folder, env=environment, **pipes)

    def run(self, block):
        self.process.stdin.write(json.dumps(block) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def write_scenario(name, block, folder):
    """A scenario of a page becomes a file; one that goes on is added to what is there."""
    match = NAME.match(block)
    if match is None:
        check(name not in FILES, f"docs/{name}: the first line of a scenario must be its name, such as # ball.toml:\n{block}")
        return
    with open(folder / match[1], "a" if match[2] == " goes on" else "w") as file:
        file.write(block)


def check_commands(program, name):
    """Commands of a page end well and say what stands below them, but for numbers; so does its Python, where there is what it needs."""
    page = (DOCS / name).read_text()
    missing = [module for module in NEEDED if importlib.util.find_spec(module) is None]
    counts, said = {"sh": 0, "python": 0}, ""
    with tempfile.TemporaryDirectory() as folder:
        for link in ("scenarios", "scripts"):
            os.symlink(ROOT / link, pathlib.Path(folder, link))
        environment, python = environment_of(program), None
        for language, block in re.findall(r"^```(\w*)\n(.*?)^```", page, re.M | re.S):
            command = None
            if language == "toml":
                write_scenario(name, block, pathlib.Path(folder))
            elif language == "sh":
                command = ["sh", "-euc", f"exec 2>&1\n{block}"]
            elif language == "python" and name in RUN_PYTHON:
                counts["python"] += 1
                if missing:
                    said = None
                    continue
                python = python or Python(folder, environment)
                is_right, said = python.run(block)
                check(is_right, f"docs/{name}: this fails:\n{block}{said}")
            elif language == "text" and said is not None:
                lines = {without_numbers(line) for line in said.splitlines()}
                for line in block.splitlines():
                    is_there = line == "..." or without_numbers(line) in lines
                    check(is_there, f"docs/{name}: this is not said: {line}\nbut: {said}")
            if command is not None:
                run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
                said = run.stdout
                check(run.returncode == 0, f"docs/{name}: this ends with {run.returncode}:\n{block}{said}{run.stderr}")
                counts["sh"] += language == "sh"
        if python is not None:
            python.end()
    for language, least in (("sh", RUN.get(name, 0)), ("python", RUN_PYTHON.get(name, 0))):
        check(counts[language] >= least, f"docs/{name} has only {counts[language]} blocks of {language}")
    if counts["python"] and missing:
        print(f"docs/{name}: its Python is not run, {', '.join(missing)} not installed")


def main():
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/fbimpact").resolve()
    check_links()
    check_book()
    check_gallery()
    check_theory()
    check_claims()
    check_written(program)
    for page in dict.fromkeys([*RUN, *RUN_PYTHON]):
        check_commands(program, page)
    for fault in faults:
        print(fault, file=sys.stderr)
    if faults:
        sys.exit(1)
    print("documents: links, book, gallery, theory, claims, written pages and commands are right")


main()
