#!/usr/bin/env python3
"""Time two builds of the program in turns on the same scenario files: rows for docs/performance.md, which claims nothing without one.

Usage: compare_speed.py OLD NEW SCENARIO… [--pairs 3] [--set KEY=VALUE]… [--command run|modes|report]; prints a Markdown table. Take a quiet machine.
With --page, in place of scenarios, the rows of that page are made and put into it.

Each pair runs OLD, then NEW, nothing kept from earlier runs. Medians; behind them the range of the ratios of the pairs. `report` draws the result that the
same program has made of the scenario, which is not timed.
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time


PAGE = pathlib.Path("docs/performance.md")
MARKS = ("<!-- rows by scripts/compare_speed.py --page -->", "<!-- end of the rows -->")
# Commands of the page: what is run, of which file, with which changes.
ROWS = [
    ("run", "sphere_on_plane.toml", []),
    ("run", "rod_on_plane.toml", []),
    ("run", "sphere_rod_sphere.toml", []),
    ("run", "rotating_disc.toml", []),
    ("run", "spinning_beam.toml", []),
    ("run", "flexible_pendulum.toml", []),
    ("modes", "cylinder_modes.toml", []),
    ("run", "floor_100.toml", []),
    ("run", "floor_300.toml", []),
    ("run", "floor_1000.toml", []),
    ("run", "free_3000.toml", []),
    ("run", "box_200.toml", []),
    ("run", "double_pendulum.toml", ["simulation.end_time=0.17"]),
    ("report", "double_pendulum.toml", ["simulation.end_time=0.17"]),
]


def balls(kind, n):
    """Steel balls of 10 mm: above a floor that they meet by Hertz' law, free of each other, or at random in a box with contacts between all."""
    ball = 'model = "rigid"\nmaterial = "steel"\n'
    plane = 'model = "rigid"\ngeometry = { shape = "plane" }\n'
    if kind == "box":
        between = 'arrangement = "random", from = ["-44 mm", "-44 mm", "5.1 mm"], to = ["44 mm", "44 mm", "80 mm"], distance = "10.1 mm"'
        walls = {"floor": "", "left": 'position = ["-50 mm", 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n', "right": 'position = ["50 mm", 0.0, 0.0]\nnormal = [-1.0, 0.0, 0.0]\n'}
        return (
            "[simulation]\nend_time = 3e-3\ngravity = [0.0, 0.0, -9.81]\n"
            f'[bodies.ball]\n{ball}geometry = {{ shape = "sphere", radius = "5 mm" }}\nvelocity = [0.0, 0.0, -0.5]\ncopies = {{ count = {n}, {between} }}\n'
            + "".join(f"[bodies.wall-{name}]\n{plane}{more}" for name, more in walls.items())
            + "".join(f'[contacts.{t}]\ncontact_body = "ball-*"\ntarget_body = "{t}-*"\nmodel = "hertz"\n' for t in ("ball", "wall"))
        )
    way = "velocity = [0, 0, -0.1]\n" if kind == "floor" else ""
    one = f'{ball}geometry = {{ shape = "sphere", radius = 0.01 }}\n{way}'
    text = "[simulation]\nend_time = 1e-3\ngravity = [0, 0, -9.81]\n" + "".join(f"[bodies.b{i}]\n{one}position = [{0.05 * i}, 0, 0.01]\n" for i in range(n))
    if kind == "floor":
        text += f"[bodies.floor]\n{plane}" + "".join(f'[contacts.c{i}]\ncontact_body = "b{i}"\ntarget_body = "floor"\nmodel = "hertz"\n' for i in range(n))
    return text


def file_of(name, folder):
    """The scenario of a row of the page: a shipped one, or one of many balls, which is written."""
    shipped = pathlib.Path("scenarios") / name
    if shipped.exists():
        return shipped
    kind, n = name.removesuffix(".toml").split("_")
    (folder / name).write_text(balls(kind, int(n)))
    return folder / name


def version(program):
    """Commit of a program."""
    told = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout
    return next(line.split()[1] for line in told.splitlines() if line.startswith("commit"))


def measured(words, folder):
    """Wall seconds, seconds of processor and peak memory [MiB] of a command."""
    began = time.monotonic()
    with open(folder / "log", "wb") as log:
        child = subprocess.Popen([str(word) for word in words], stdout=log, stderr=log)
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))} ended with {child.returncode}:\n{(folder / 'log').read_text()[-2000:]}")
    return time.monotonic() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def words(program, command, scenario, sets, folder):
    """The command to be timed, after what it needs has been made."""
    options = [word for value in sets for word in ("--set", value)]
    result, run = folder / "result.h5", [program, "run", scenario, "--force", "--no-cache", "-o", folder / "result.h5", *options]
    if command == "run":
        return run
    if command == "modes":
        return [program, "modes", scenario, "--no-cache", *options]
    measured(run, folder)
    return [program, "report", result, "--force", "-o", folder / "report.html"]


def row(arguments, command, scenario, sets, folder):
    """A row of the table: medians of both programs, and the ratios."""
    pairs = []
    for _ in range(arguments.pairs):
        pairs.append([measured(words(program, command, scenario, sets, folder), folder) for program in (arguments.old, arguments.new)])
    ratios = [[new[k] / old[k] for old, new in pairs] for k in range(3)]
    middle = lambda which, k: statistics.median(pair[which][k] for pair in pairs)
    cell = lambda k, digits: f"{middle(0, k):.{digits}f} | {middle(1, k):.{digits}f}"
    spread = lambda k: f"{statistics.median(ratios[k]):.2f} ({min(ratios[k]):.2f} to {max(ratios[k]):.2f})"
    name = " ".join([f"`{command} {scenario.name}`", *(f"`{value}`" for value in sets)])
    return f"| {name} | {arguments.pairs} | {cell(0, 2)} | {spread(0)} | {cell(1, 2)} | {spread(1)} | {cell(2, 0)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("scenarios", type=pathlib.Path, nargs="*", metavar="SCENARIO")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--command", choices=("run", "modes", "report"), default="run")
    arguments = parser.parse_args()
    arguments.old, arguments.new = arguments.old.resolve(), arguments.new.resolve()
    table = ["| command | pairs | old, wall [s] | new | ratio | old, processor [s] | new | ratio | old, memory [MiB] | new |", "|---|---|---|---|---|---|---|---|---|---|"]
    print("\n".join(table), flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        given = [(arguments.command, scenario, arguments.set) for scenario in arguments.scenarios]
        of_page = [(command, file_of(scenario, folder), sets) for command, scenario, sets in ROWS]
        for command, scenario, sets in of_page if arguments.page else given:
            table.append(row(arguments, command, scenario, sets, folder))
            print(table[-1], flush=True)
    if arguments.page:
        before, _, rest = PAGE.read_text().partition(MARKS[0])
        _, _, after = rest.partition(MARKS[1])
        told = f"Old: {version(arguments.old)}, new: {version(arguments.new)}, load of the machine at the end {os.getloadavg()[2]:.1f} on {os.cpu_count()} processors."
        PAGE.write_text(f"{before}{MARKS[0]}\n{told}\n\n" + "\n".join(table) + f"\n{MARKS[1]}{after}")


main()
