#!/usr/bin/env python3
"""Compare the levels of `accuracy` on shipped scenarios (docs/accuracy.md): time, peak force, and how far each level is from the finest.

Usage: accuracy.py [--fbimpact PROGRAM] [--threads N] [SCENARIO.toml…]

Runs each scenario with "fast", "normal" and "fine", models built anew, and prints the rows of the table. Time is processor time of the whole run,
choice of meshes and modes included. Impacts are compared by their number: the largest change of a peak force, of a duration and of an impulse, as shares of
those of "fine".
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
LEVELS = ("fast", "normal", "fine")
# Scenarios with changes; the pendulums until the end of their first impact.
SCENARIOS = {
    "sphere_on_plane": [],
    "rod_on_plane": [],
    "flat_rods": [],
    "oblique_discs": [],
    "sphere_rod_sphere": [],
    "double_pendulum": ["simulation.stop_after_impacts=1"],
    "rigid_double_pendulums": ["simulation.stop_after_impacts=1"],
    "benchmarks/chung_ooi_2_aluminium": [],
    "benchmarks/newtons_cradle": [],
    "benchmarks/zener_plate": [],
    "benchmarks/chung_ooi_1_limestone": [],
    "benchmarks/chung_ooi_4_alumina": [],
    "benchmarks/chung_ooi_5_steel": [],
    "benchmarks/chung_ooi_6_aluminium": [],
    "benchmarks/chung_ooi_7_spinning": [],
    "benchmarks/chung_ooi_8_two_spheres": [],
    "benchmarks/metal_bar": [],
    "benchmarks/vm265": [],
    "benchmarks/bouncing_bar": [],
    "benchmarks/sdnl111": [],
}


def measure(program, scenario, sets, threads, out):
    """Impacts of a run with keys set, none if it has failed, and its processor time in s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "run", str(scenario), "-qq", "--no-cache", "--force", "--threads", str(threads), "-o", str(out)]
    command += [word for change in sets for word in ("--set", change)]
    status = subprocess.run(command, check=False).returncode
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if status != 0:
        return None, seconds
    told = subprocess.run([program, "info", "--json", str(out)], check=True, capture_output=True, text=True)
    return json.loads(told.stdout)["impacts"], seconds


def change(impacts, of, value):
    """Largest change of `value` as a share of that in `of`."""
    pairs = zip(impacts, of)
    return max(abs(value(a) / value(b) - 1) for a, b in pairs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fbimpact", default=str(ROOT / "target/release/fbimpact"))
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("scenarios", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    shipped = {ROOT / "scenarios" / f"{name}.toml": sets for name, sets in SCENARIOS.items()}
    scenarios = {path.resolve(): shipped.get(path.resolve(), []) for path in arguments.scenarios or shipped}
    print("| scenario | accuracy | processor time | impacts | first peak | peak | duration | impulse |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scenario, sets in scenarios.items():
            out = pathlib.Path(folder) / "out.h5"
            runs = {level: [f"accuracy={level}", *sets] for level in LEVELS}
            found = {level: measure(arguments.fbimpact, scenario, run, arguments.threads, out) for level, run in runs.items()}
            fine = found["fine"][0]
            for level, (impacts, seconds) in found.items():
                cells = [scenario.stem, level, f"{seconds:.3g} s"]
                if not impacts:
                    cells += ["failed" if impacts is None else "0", *[""] * 4]
                else:
                    cells += [str(len(impacts)), f"{impacts[0]['peak_force']:.6g} N"]
                    values = (lambda i: i["peak_force"], lambda i: i["end"] - i["start"], lambda i: i["impulse"])
                    is_same = fine is not None and len(impacts) == len(fine)
                    cells += [f"{100 * change(impacts, fine, v):.2g} %" if is_same and level != "fine" else "" for v in values]
                print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
