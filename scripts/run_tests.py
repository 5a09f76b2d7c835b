#!/usr/bin/env python3
"""Builds the tests and runs them, each module in a process of its own, as many at a time as there are cores, those of what changed last first;
measures their time of processor, children included, prints the ten slowest, and refuses what is above the budget of the first tier: so many
seconds a test, and in all.

Usage: scripts/run_tests.py [--ignored] [--no-budget] [NAME…]

NAME: parts of `suite::module::test`, as `adaptive::zones` or `fe_mesh_units::`; without one all tests run. `--ignored` runs the second tier,
one after the other, without a budget. Environment: FBIMPACT_TEST_JOBS (default: the number of cores).
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Seconds of processor of the first tier, on a quiet machine that needs SECOND for `reference`: what changes wait for (CONTRIBUTING.md). Where other
# work shares the caches and threads wait for each other, the same test takes up to SCATTER times as long: only beyond that it is refused, and not
# before it has run again by itself.
OF_A_TEST, OF_ALL, SCATTER = 5.0, 400.0, 4.0
# `reference` on the machine of docs/performance.md, both cores busy.
SECOND = 0.55


def reference():
    """Seconds of processor of a fixed piece of work: how fast this machine is at present, beside what else it does."""
    start = time.thread_time()
    x = 0
    for i in range(6_000_000):
        x = (x * 69069 + i) & 0xFFFFFFFF
    return time.thread_time() - start


def pace():
    """How many times slower this machine is than that of SECOND with all cores busy; never below one, so that no budget shrinks."""
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as pool:
        seconds = list(pool.map(measured, range(os.cpu_count())))
    return max(1.0, sorted(seconds)[len(seconds) // 2] / SECOND)


def measured(_):
    return reference()


def executables():
    """Name and file of every test executable, in the order of the last change of what it tests, newest first."""
    command = ["cargo", "test", "--locked", "--release", "--tests", "--no-run", "--message-format=json-render-diagnostics"]
    build = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if build.returncode:
        sys.exit(build.returncode)
    found = []
    for line in build.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and "test" in message["target"]["kind"]:
            found.append((message["target"]["name"], message["executable"], message["target"]["src_path"]))
    return [entry[:2] for entry in sorted(found, key=lambda entry: -changed(entry[2]))]


def changed(source):
    """Time of the last change in the folder of a source: of its commit, or of its newest file that is not committed."""
    folder = pathlib.Path(source).parent
    git = lambda *words: subprocess.run(["git", *words, "--", folder], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    if git("status", "--porcelain"):
        return time.time()
    return int(git("log", "-1", "--format=%ct") or 0)


def listed(executable, is_second):
    """Names of the tests of an executable in one tier."""
    names = lambda *flags: {
        line.removesuffix(": test")
        for line in subprocess.run([executable, "--list", "--format", "terse", *flags], capture_output=True, text=True, check=True).stdout.splitlines()
        if line.endswith(": test")
    }
    second = names("--ignored")
    return sorted(second if is_second else names() - second)


def processor_time(process):
    """Seconds of processor of a process and of its children that have ended; zero where the system does not tell."""
    try:
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return 0.0


def run(task):
    """Runs the tests of one module, one after the other in one process, for they may share what they look at: seconds of processor, whether
    it passed and what was printed of each."""
    executable, names, is_second = task
    words = [executable, "--test-threads=1", "--exact", *names] + ["--ignored", "--nocapture"] * is_second
    process = subprocess.Popen(words, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    found, before, lines, running = {}, 0.0, [], None
    for line in process.stdout:
        lines.append(line)
        if begun := re.match(r"test (\S+) (?:- should panic )?\.\.\. ", line):
            running = begun[1]
        # What the test and its children print may stand between.
        if running and (end := re.search(r"(?:^|\W)(ok|FAILED)$", line)):
            now = processor_time(process)
            found[running] = (now - before, end[1] == "ok")
            before, running = now, None
    process.wait()
    text = "".join(lines)
    return {name: found.get(name, (0.0, False)) for name in names}, text


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--ignored", action="store_true")
    parser.add_argument("--no-budget", action="store_true")
    parser.add_argument("--times", help="a file for the seconds of every test")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    os.environ.setdefault("FBIMPACT_CACHE", "off")
    tasks = []
    for suite, executable in executables():
        modules = {}
        for name in listed(executable, arguments.ignored):
            if not arguments.names or any(part in f"{suite}::{name}" for part in arguments.names):
                modules.setdefault(name.partition("::")[0], []).append(name)
        tasks += [(suite, (executable, names, arguments.ignored)) for names in modules.values()]
    jobs = 1 if arguments.ignored else int(os.environ.get("FBIMPACT_TEST_JOBS") or os.cpu_count())
    factor = 1.0 if arguments.no_budget or arguments.ignored else SCATTER * pace()
    start, seconds, failed, lock = time.monotonic(), {}, [], threading.Lock()

    def one(task):
        found, text = run(task[1])
        with lock:
            for name, (used, is_right) in found.items():
                name = f"{task[0]}::{name}"
                seconds[name] = used
                if not is_right:
                    failed.append(name)
                    print(f"test {name} ... FAILED")
                elif used > OF_A_TEST or arguments.ignored:
                    print(f"test {name} ... ok, {used:.1f} s")
            if arguments.ignored or not all(is_right for _, is_right in found.values()):
                print(text)
            sys.stdout.flush()

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, tasks))
    for suite, (executable, names, _) in tasks:
        for name in names if factor > 1.0 else ():
            if seconds[f"{suite}::{name}"] > OF_A_TEST * factor and f"{suite}::{name}" not in failed:
                alone = run((executable, [name], False))[0][name][0]
                seconds[f"{suite}::{name}"] = min(alone, seconds[f"{suite}::{name}"])
    slowest = sorted(seconds, key=seconds.get, reverse=True)
    if arguments.times:
        pathlib.Path(arguments.times).write_text("".join(f"{seconds[name]:.2f} {name}\n" for name in slowest))
    total = sum(seconds.values())
    print(f"{time.monotonic() - start:.0f} s, {total:.0f} s of processor, pace {factor:.2f}; the slowest:")
    for name in slowest[:10]:
        print(f"{seconds[name]:8.2f} s  {name}")
    print(f"{len(seconds) - len(failed)} passed, {len(failed)} failed")
    faults = [f"the test {name} failed" for name in failed]
    if not (arguments.no_budget or arguments.ignored):
        faults += [f"{name} takes {s:.1f} s of processor, {OF_A_TEST * factor:.1f} s at most" for name, s in seconds.items() if s > OF_A_TEST * factor]
        if total > OF_ALL * factor:
            faults.append(f"the first tier takes {total:.0f} s of processor, {OF_ALL * factor:.0f} s at most")
        if faults[len(failed):]:
            print("ask a smaller model, or move the test to the second tier (#[ignore]) and leave a small sister here")
    print("\n".join(faults), file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
