#!/usr/bin/env python3
"""Stop runs by signals at random moments and resume them; run with random limits of addresses. What a batch system does to jobs.

Usage: check_jobs.py PROGRAM [--signals N] [--limits N] [--seed SEED]

Of N runs of three scenarios each is sent one of seven signals at a random moment, is resumed, perhaps several times, until it is complete, and must equal a
run that was left alone to the last bit. N runs under `ulimit -v` between 0.2 and 4 GB are complete, or end with an exit code and a message that says what
limits them; never by a signal and never by a panic. Exit code 1 if one does otherwise.
"""

import argparse
import collections
import os
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Joints and impacts of rigid bodies, an impact that is refined, one with friction: seconds each.
SCENARIOS = ["rigid_double_pendulums", "sphere_on_plane", "oblique_discs"]
SIGNALS = ["INT", "TERM", "HUP", "USR1", "USR2", "XCPU", "KILL"]
EXACT = """rtol = 0.0
atol = 0.0
[datasets]
"**" = { rtol = 0.0, atol = 0.0, scale = "own", steps = false }
[features]
"**" = { rtol = 0.0, atol = 0.0 }
"""
# Messages of runs that got too little.
SHORT = ["memory", "threads cannot be started"]
INTERRUPTED = 130


def start(program, arguments, folder, limit=None):
    def within():
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    environment = dict(os.environ, FBIMPACT_CACHE="off")
    return subprocess.Popen(
        [program, *arguments], cwd=folder, env=environment, preexec_fn=within, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def run(program, arguments, folder, limit=None):
    process = start(program, arguments, folder, limit)
    _, err = process.communicate()
    return process.returncode, err


def arguments_of(name, output, threads=1):
    return ["run", "-q", "--force", "--threads", str(threads), str(ROOT / f"scenarios/{name}.toml"), "-o", output]


def signalled(program, folder, name, kind, moment):
    """Runs `name`, which is sent the signal `kind` after `moment` seconds, to its end; whether it was stopped, and a fault if there is one."""
    process = start(program, arguments_of(name, "a.h5"), folder)
    begin = time.monotonic()
    # Before there is a first state nothing can be resumed.
    while process.poll() is None and not (folder / "a.h5.restart").exists():
        time.sleep(0.002)
    time.sleep(max(0.0, moment - (time.monotonic() - begin)))
    process.send_signal(getattr(signal, f"SIG{kind}"))
    _, err = process.communicate()
    code = process.returncode
    if code == 0:
        return False, None
    expected = -signal.SIGKILL if kind == "KILL" else INTERRUPTED
    if code != expected:
        return True, f"ended with {code}: {err}"
    # What has no state yet promises no resumption and leaves nothing; it begins anew.
    promises = kind == "KILL" or "--resume" in err
    is_there = any((folder / f"a.h5{end}").exists() for end in ("", ".part"))
    if not is_there and (kind == "KILL" or not promises):
        code, err = run(program, arguments_of(name, "a.h5"), folder)
        return True, None if code == 0 else f"beginning anew ended with {code}: {err}"
    code, err_after = run(program, ["run", "-q", "--threads", "1", "--resume", "a.h5"], folder)
    return True, None if code == 0 else f"resuming ended with {code}: {err_after} after {err}"


def check_signals(program, folder, count, draw):
    (folder / "exact.toml").write_text(EXACT)
    faults, stopped, lasts = 0, collections.Counter(), {}
    for name in SCENARIOS:
        begin = time.monotonic()
        code, err = run(program, arguments_of(name, f"{name}.h5"), folder)
        lasts[name] = time.monotonic() - begin
        if code != 0:
            sys.exit(f"{name}: ended with {code}: {err}")
    for number in range(count):
        name, kind = SCENARIOS[number % len(SCENARIOS)], SIGNALS[number % len(SIGNALS)]
        is_stopped, fault = signalled(program, folder, name, kind, draw.uniform(0.0, 0.8 * lasts[name]))
        stopped[kind] += is_stopped
        if fault is None:
            code, _ = run(program, ["compare", "a.h5", f"{name}.h5", "--tolerances", "exact.toml"], folder)
            fault = None if code == 0 else f"differs from the run that was left alone ({code})"
        if fault:
            print(f"signals: {name}, {kind}: {fault}")
            faults += 1
        for file in folder.glob("a.h5*"):
            file.unlink()
    print(f"signals: {count} runs, stopped by {dict(stopped)}, {faults} faults")
    return faults


def check_limits(program, folder, count, draw):
    faults, complete, codes = 0, 0, collections.Counter()
    for number in range(count):
        name, limit = SCENARIOS[number % len(SCENARIOS)], int(10 ** draw.uniform(8.301, 9.602))
        arguments = arguments_of(name, "b.h5", draw.randint(1, 8))
        code, err = run(program, arguments, folder, limit)
        codes[code] += 1
        if code == 0:
            complete += 1
        elif code not in (4, 5, 6) or "panicked" in err or not any(word in err for word in SHORT):
            print(f"limits: {name} within {limit / 1e9:.3f} GB: ended with {code}: {err}")
            faults += 1
        for file in folder.glob("b.h5*"):
            file.unlink()
    print(f"limits: {count} runs, {complete} complete, exit codes {dict(codes)}, {faults} faults")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--signals", type=int, default=50)
    parser.add_argument("--limits", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    draw, program = random.Random(arguments.seed), str(arguments.program.resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        faults = check_signals(program, folder, arguments.signals, draw)
        faults += check_limits(program, folder, arguments.limits, draw)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
