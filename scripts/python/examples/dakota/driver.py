#!/usr/bin/env python3
"""One evaluation for Dakota: driver.py PARAMETERS RESULTS.

Names of the variables are keys of the scenario `$FBIMPACT_SCENARIO`. Needs Python and the program (`$FBIMPACT`, or `fbimpact` on the path) alone.
"""

import json
import os
import subprocess
import sys

METRICS = {"peak": "max(impacts.peak_force)"}  # response: expression


def parameters(path: str) -> dict[str, str]:
    """Variables of Dakota's parameters file: lines of a value and a name, as many as the first line says."""
    with open(path) as file:
        lines = [line.split() for line in file if line.strip()]
    n = int(lines[0][0])
    return {name: value for value, name in (line[:2] for line in lines[1 : 1 + n])}


def main() -> None:
    given, answer = sys.argv[1:3]
    program = os.environ.get("FBIMPACT", "fbimpact")
    scenario = os.environ.get("FBIMPACT_SCENARIO", "scenarios/sphere_on_plane.toml")
    changes = [word for key, value in parameters(given).items() for word in ("--set", f"{key}={value}")]
    run = [program, "run", "-q", scenario, "-o", f"{answer}.h5", "--force", "--threads", "1", *changes]
    expressions = [f"{name}={text}" for name, text in METRICS.items()]
    try:
        subprocess.run(run, check=True)
        said = subprocess.run([program, "metric", f"{answer}.h5", *expressions], check=True, capture_output=True, text=True)
        found = json.loads(said.stdout)
        lines = [f"{found[name]['value']!r} {name}\n" for name in METRICS]
    except subprocess.CalledProcessError:
        lines = ["FAIL\n"]  # Dakota's word for an evaluation that has no result
    with open(answer, "w") as file:
        file.writelines(lines)


main()
