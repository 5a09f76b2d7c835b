#!/usr/bin/env python3
"""Compare the contact models on one set of impacts (docs/benchmarks.md): peak force, what is given back, what is lost, steps and processor time.

Usage: contact_models.py [--fbimpact PROGRAM] [--only CASE] [--model MODEL]

Each case is a scenario of the repository with one contact zone for all models, so that they differ in the model alone. Prints the rows of the
table; runs take one thread. Processor time is that of the impact's trial, without models and meshes, which `run` keeps in `tries`.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Keys of the contact by model; `penalty` stands for the case's factor. Hertz's law has neither zone nor points.
MODELS = {
    "all modes dynamic": ("dynamic", {"penalty": True}),
    "zone damped": ("damped", {"penalty": True}),
    "quasistatic, Algorithm 1": ("quasistatic", {"penalty": True, "solver": "broyden"}),
    "quasistatic, compliance": ("quasistatic", {"penalty": True}),
    "massless boundary": ("massless", {}),
    "Hertz": ("hertz", {}),
}

# Scenario, contact, keys changed, contact's interval, penalty factor [N/m3], peak force known [N] and its source.
CASES = {
    "ball on a plane": {
        "scenario": "scenarios/sphere_on_plane.toml",
        "contact": "impact",
        "bodies": ("ball", "floor"),
        "set": ['bodies.ball.discretisation.refine=[{marker="bottom",width=0.24e-3,elements=8}]', "simulation.end_time=0.9e-4"],
        "drop": ["output.stress"],
        "penalty": "3e17",
        "known": 52.08,
    },
    "rod on a plane": {
        "scenario": "scenarios/rod_on_plane.toml",
        "contact": "impact",
        "bodies": ("rod", "floor"),
        "set": ['bodies.rod.discretisation.refine=[{marker="start",width=0.72e-3,elements=8}]', "simulation.end_time=6e-4"],
        "drop": [],
        "penalty": "3e17",
        "known": 1341.0,
    },
    "ball on a plate": {
        "scenario": "scenarios/benchmarks/zener_plate.toml",
        "contact": "blow",
        "bodies": ("ball", "plate"),
        "set": [],
        "drop": [],
        "interval": "{width=0.32e-3,elements=8}",
        "penalty": "3e17",
        "known": 376.5,
    },
}

VALUES = {
    "peak": "impacts[0].peak_force",
    "duration": "impacts[0].end - impacts[0].start",
    "restitution": "impacts[0].restitution",
    "lost": "energies.dissipated[-1] / energies.total[0]",
    "ledger": "max(abs(energies.total / energies.total[0] - 1))",
    "steps": "tries[0].steps",
    "time": "tries[0].cpu_time",
}
# Hertz's law has no trials: its impact is the phase.
PHASE = {"steps": "phases[0].steps", "time": "phases[0].wall_time"}


def without_contact(text, contact):
    """The scenario without the table of its contact and what hangs on stress lines."""
    kept, skipping = [], False
    for line in text.splitlines():
        if line.startswith("["):
            skipping = line.startswith((f"[contacts.{contact}]", "[output.stress"))
        if not skipping:
            kept.append(line)
    return "\n".join(kept) + "\n"


def scenario(case, name, keys):
    text = without_contact((ROOT / case["scenario"]).read_text(), case["contact"])
    lines = [f'[contacts.{case["contact"]}]', f'contact_body = "{case["bodies"][0]}"', f'target_body = "{case["bodies"][1]}"', f'model = "{name}"']
    if keys.get("penalty"):
        lines.append(f'penalty = {{ initial = {case["penalty"]}, search = "fixed" }}')
    if "solver" in keys:
        lines.append(f'solver = "{keys["solver"]}"')
    if "interval" in case and name != "hertz":
        lines.append(f'interval = {case["interval"]}')
    return text + "\n".join(lines) + "\n"


def measure(program, folder, case, model):
    name, keys = MODELS[model]
    path, out = folder / "case.toml", folder / "case.h5"
    path.write_text(scenario(case, name, keys))
    out.unlink(missing_ok=True)
    sets = [word for change in case["set"] for word in ("--set", change)]
    command = [program, "run", str(path), "-q", "--threads", "1", "-o", str(out), *sets]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    def values(expressions):
        words = [f"{key}={expression}" for key, expression in expressions.items()]
        found = subprocess.run([program, "metric", str(out), *words], check=True, capture_output=True, text=True)
        return {key: entry["value"] for key, entry in json.loads(found.stdout).items()}

    try:
        return values(VALUES)
    except subprocess.CalledProcessError:
        return values({**VALUES, **PHASE})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fbimpact", default=str(ROOT / "target/release/fbimpact"))
    parser.add_argument("--only", choices=CASES, help="one case")
    parser.add_argument("--model", choices=MODELS, help="one model")
    arguments = parser.parse_args()
    print("| impact | model | peak force | off by | duration | given back | lost | ledger | steps | processor time |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for title, case in CASES.items():
            for model in MODELS:
                if arguments.only not in (None, title) or arguments.model not in (None, model):
                    continue
                v = measure(arguments.fbimpact, pathlib.Path(name), case, model)
                off = 100 * (v["peak"] / case["known"] - 1)
                row = [
                    title, model, f"{v['peak']:.5g} N", f"{off:+.2f} %", f"{1e6 * v['duration']:.2f} µs", f"{100 * v['restitution'] ** 2:.2f} %",
                    f"{100 * v['lost']:.2f} %", f"{v['ledger']:.0e}", f"{v['steps']:.0f}", f"{v['time']:.3g} s",
                ]
                print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
