#!/usr/bin/env python3
"""Time two builds of the program in turns on the same scenario files: rows for docs/performance.md, which claims nothing without one.

Usage: compare_speed.py OLD NEW SCENARIO… [--pairs 3] [--set KEY=VALUE]… [--command run|modes|report]; prints a Markdown table. Take a quiet machine.

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


def row(arguments, scenario, folder):
    """A row of the table: medians of both programs, and the ratios."""
    pairs = []
    for _ in range(arguments.pairs):
        both = [words(program, arguments.command, scenario, arguments.set, folder) for program in (arguments.old, arguments.new)]
        pairs.append([measured(command, folder) for command in both])
    ratios = [[new[k] / old[k] for old, new in pairs] for k in range(3)]
    middle = lambda which, k: statistics.median(pair[which][k] for pair in pairs)
    cell = lambda k, digits: f"{middle(0, k):.{digits}f} | {middle(1, k):.{digits}f}"
    spread = lambda k: f"{statistics.median(ratios[k]):.2f} ({min(ratios[k]):.2f} to {max(ratios[k]):.2f})"
    name = " ".join([f"`{arguments.command} {scenario.name}`", *(f"`{value}`" for value in arguments.set)])
    return f"| {name} | {arguments.pairs} | {cell(0, 2)} | {spread(0)} | {cell(1, 2)} | {spread(1)} | {cell(2, 0)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("scenarios", type=pathlib.Path, nargs="+", metavar="SCENARIO")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--command", choices=("run", "modes", "report"), default="run")
    arguments = parser.parse_args()
    arguments.old, arguments.new = arguments.old.resolve(), arguments.new.resolve()
    print("| command | pairs | old, wall [s] | new | ratio | old, processor [s] | new | ratio | old, memory [MiB] | new |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scenario in arguments.scenarios:
            print(row(arguments, scenario, pathlib.Path(folder)), flush=True)


main()
