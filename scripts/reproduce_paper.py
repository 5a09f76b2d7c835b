"""Runs the examples of the two papers and writes docs/reproduction.md; see reproduce_paper.sh."""

import json
import os
import pathlib
import resource
import shlex
import subprocess
import sys

PROGRAM = shlex.split(os.environ.get("FBIMPACT", "cargo run --locked --release --quiet --"))
PAGE = pathlib.Path("docs/reproduction.md")
FIGURES = pathlib.Path("docs/reproduction")

FIRST, SECOND = "contacts.first", "contacts.second"

# What [A] simulates after the third impact, as far as 1 s, is motion without contact.
THREE_IMPACTS = "simulation.end_time=0.8345"


def given(model, first, second, width="2.97e-4"):
    """Settings of the sphere-rod-sphere contacts without adaptivity, with the printed penalty factors."""
    for contact, penalty in ((FIRST, first), (SECOND, second)):
        yield f'{contact}.model="{model}"'
        yield f"{contact}.penalty.initial={penalty}"
        yield f'{contact}.penalty.search="fixed"'
        if width:
            yield f"{contact}.interval.width={width}"


def printed_search(*contacts):
    """The search of the penalty factor as printed: Algorithm 1, from 1e15 N/m³, until an error.

    It lowers the factor in the running impact, which takes the energy that is in the springs: 1e-3 of all, where a run is allowed 1e-3.
    """
    yield "simulation.energy_tolerance=1e-2"
    for contact in contacts:
        yield f'{contact}.solver="broyden"'
        yield f"{contact}.penalty.initial=1e15"
        yield f'{contact}.penalty.search="until-error"'


# Name, scenario, settings, whether it takes many minutes.
RUNS = [
    ("sphere", "sphere_on_plane", [], False),
    ("rod", "rod_on_plane", [], False),
    ("disc", "rotating_disc", [], False),
    ("chain_adaptive", "sphere_rod_sphere", [], False),
    ("chain_printed", "sphere_rod_sphere", list(printed_search(FIRST, SECOND)), False),
    ("chain_quasistatic", "sphere_rod_sphere", list(given("quasistatic", 5e16, 1e17)), False),
    (
        "chain_damped",
        "sphere_rod_sphere",
        [*given("damped", 3.154e16, 3.154e16), f"{FIRST}.interval.elements=16", f"{SECOND}.interval.elements=16"],
        True,
    ),
    ("pendulum_hertz", "double_pendulum/hertz", [], False),
    ("pendulum_adaptive", "double_pendulum", [THREE_IMPACTS], False),
    ("pendulum_quasistatic", "double_pendulum/quasistatic", [], False),
    ("pendulum_damped", "double_pendulum/damped", [], True),
    ("pendulum_coarse_1e15", "double_pendulum/coarse_1e15", [], False),
    ("pendulum_coarse_1e18", "double_pendulum/coarse_1e18", [], False),
    (
        "pendulum_printed",
        "double_pendulum",
        ["simulation.end_time=0.17", "contacts.balls.interval.elements=8", *printed_search("contacts.balls")],
        True,
    ),
]


def processor_time():
    """Seconds that processes ended so far have taken of processors."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(folder, name, scenario, settings):
    """Runs a scenario unless its result is there; returns what `info` says, or None."""
    result = folder / f"{name}.h5"
    if not result.exists():
        sets = [part for s in settings for part in ("--set", s)]
        command = [*PROGRAM, "run", f"scenarios/{scenario}.toml", "-q", "--no-cache", "-o", str(result), *sets]
        print(f"{name}: {shlex.join(command)}", flush=True)
        start = processor_time()
        code = subprocess.run(command, check=False).returncode
        (folder / f"{name}.seconds").write_text(f"{processor_time() - start:.2f}\n")
        if code == 130:
            sys.exit(code)
        if code != 0:
            print(f"{name}: failed with exit code {code}", file=sys.stderr)
    if not result.exists():
        return None
    out = subprocess.run([*PROGRAM, "info", "--json", str(result)], check=True, capture_output=True)
    info = json.loads(out.stdout)
    seconds = folder / f"{name}.seconds"
    info["seconds"] = float(seconds.read_text()) if seconds.exists() else None
    return info


def number(value, digits=4):
    return "–" if value is None else f"{value:.{digits}g}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def impacts(info):
    return [] if info is None else info["impacts"]


def peaks(info):
    return ", ".join(f"{number(i['peak_force'], 5)} N" for i in impacts(info)) or "not run"


def times(info):
    spans = [f"{1e6 * i['start']:.2f} – {1e6 * i['end']:.2f} µs" for i in impacts(info)]
    return ", ".join(spans) or "–"


def seconds(info):
    return "–" if info is None or info["seconds"] is None else f"{info['seconds']:.1f} s"


def search_end(info, contact):
    """Penalty factor and number of trials of the first impact of a contact."""
    if info is None:
        return "not run"
    trials = [t for t in info["tries"] if t["outcome"] == "accepted"]
    return ", ".join(number(t['penalty_end'], 2) for t in trials) + f" after {len(info['tries'])} trials"


def tries_table(info):
    rows = []
    for t in [] if info is None else info["tries"]:
        rows.append(
            [
                str(t["impact"]),
                str(t["try"]),
                number(t["penalty_start"], 3),
                number(t["penalty_end"], 3),
                number(t["peak_force"], 6),
                str(t["freedoms"]),
                f"{number(t['wall_time'], 3)} s",
                f"{t['outcome']}: {t['reason']}",
            ]
        )
    head = ["impact", "trial", "penalty at start", "at end", "peak [N]", "degrees of freedom", "time", "outcome"]
    return table(head, rows)


def first(info, key, scale=1.0):
    found = impacts(info)
    return None if not found else scale * found[0][key]


def page(r, study):
    text = [
        "# The papers' examples, computed and printed",
        "",
        "Written by `scripts/reproduce_paper.sh`; computed values are those of the runs named, printed ones those of the papers",
        "([A]: the adaptive method of 2024, [B]: the isogeometric one of 2022). Processor times are of the machine that ran the script, models",
        "not kept from earlier runs; of a trial, time by the clock. Runs of many minutes are not made without `--long`.",
        "",
        "## Sphere on a plane ([B] section 5)",
        "",
        table(
            ["quantity", "printed or closed form", "computed"],
            [
                ["peak force", "51.70 N (Hertz), full FE 52.08 N", peaks(r["sphere"])],
                ["time of the peak", "41.6 µs", f"{number(first(r['sphere'], 'peak_time', 1e6))} µs"],
                ["duration", "83.13 µs (Hertz), full FE 82.7 µs", times(r["sphere"])],
                ["processor time", "", seconds(r["sphere"])],
            ],
        ),
        "## Rod on a plane ([B] section 6)",
        "",
        table(
            ["quantity", "printed or closed form", "computed"],
            [
                ["plateau and peak", "1343 N (wave), full FE 1341 N at 385 µs", peaks(r["rod"])],
                ["contact ends", "full FE 538.5 µs", times(r["rod"])],
                ["processor time", "", seconds(r["rod"])],
            ],
        ),
        "## Rotating disc with friction ([B] section 7)",
        "",
        table(
            ["quantity", "printed or closed form", "computed"],
            [
                ["normal restitution", "1", number(first(r["disc"], "restitution"), 6)],
                ["peak force", "", peaks(r["disc"])],
                ["processor time", "", seconds(r["disc"])],
            ],
        ),
        "Rebound velocities and spin are compared in `docs/verification.md`.",
        "",
        "## Sphere, rod, sphere ([A] section 5)",
        "",
        table(
            ["model", "peaks", "impacts", "penalty factor at the end [N/m³]", "processor time", "[A]"],
            [
                [
                    label,
                    peaks(r[name]),
                    times(r[name]),
                    search_end(r[name], "first"),
                    seconds(r[name]),
                    printed,
                ]
                for label, name, printed in [
                    ("adaptive", "chain_adaptive", "4.5 min; 5e16, 1e17"),
                    ("adaptive, search as printed", "chain_printed", ""),
                    ("quasistatic, printed penalty factors", "chain_quasistatic", "3.1 min"),
                    ("damped, penalty factors of the first trial", "chain_damped", "12.2 min"),
                ]
            ],
        ),
        "Two independent programs give 73.40 N from 0 to 145.4 µs and 10.48 N from 256.2 to 382 µs.",
        "",
        "Trials of the search as printed. It lowers the factor until Algorithm 1 gets through the whole impact, so that its end is a property of",
        "the solver more than of the contact: the peak changes by less than 0.1 % beyond 1e17 N/m³. It ends within a factor of four of the printed",
        "factors. With steps that fail tried again shorter, before an error counts, Algorithm 1 passes higher: 5e17 and 1.2e18 N/m³. The second impact",
        "begins with the ratio of stiffnesses that the first one found.",
        "",
        "",
        tries_table(r["chain_printed"]),
        "![Energies](reproduction/chain_energies.svg)",
        "![Contact forces](reproduction/chain_forces.svg)",
        "",
        "## Two flexible double pendulums ([A] section 6)",
        "",
        table(
            ["model", "peaks", "first impact at", "lasts", "penalty factor at the end [N/m³]", "processor time", "[A]"],
            [
                [
                    label,
                    peaks(r[name]),
                    f"{number(first(r[name], 'start', 1e3), 7)} ms" if impacts(r[name]) else "–",
                    f"{number(1e6 * (impacts(r[name])[0]['end'] - impacts(r[name])[0]['start']))} µs"
                    if impacts(r[name])
                    else "–",
                    search_end(r[name], "balls"),
                    seconds(r[name]),
                    printed,
                ]
                for label, name, printed in [
                    ("hertz, 1 s", "pendulum_hertz", ""),
                    ("adaptive, three impacts", "pendulum_adaptive", "14.6 h (170 ms: 8.1 h); 1e18"),
                    ("quasistatic, 170 ms", "pendulum_quasistatic", "1.3 h"),
                    ("damped, 170 ms", "pendulum_damped", "7.0 h"),
                    ("coarse 1e15, 170 ms", "pendulum_coarse_1e15", "7.4 min"),
                    ("coarse 1e18, 170 ms", "pendulum_coarse_1e18", ""),
                    ("adaptive, 8 elements across, search as printed, 170 ms", "pendulum_printed", "8 trials; 1e18"),
                ]
            ],
        ),
        "Trials of the adaptive model ([A] Table 1: eight trials for the first impact, one for each later one):",
        "",
        tries_table(r["pendulum_adaptive"]),
        *printed_pendulum(r["pendulum_printed"], r["pendulum_adaptive"]),
        *settling(study),
        "![Energies](reproduction/pendulum_energies.svg)",
        "![Contact forces](reproduction/pendulum_forces.svg)",
        "![First impact, all models](reproduction/pendulum_models.svg)",
        "",
    ]
    return "\n".join(text)


def printed_pendulum(info, adaptive):
    """Trials of the search as printed, if it was run."""
    if info is None or adaptive is None:
        return []
    change = 100.0 * (first(info, "peak_force") / first(adaptive, "peak_force") - 1.0)
    return [
        f"Trials of the search as printed, with 8 elements across; its peak is {change:+.2f} % off that of the default search:",
        "",
        tries_table(info),
    ]


def converge(folder, is_long):
    """What `fbimpact converge` says of the double pendulums as far as the third impact; None if it was never run."""
    study = folder / "pendulum.converge"
    if is_long:
        command = [*PROGRAM, "converge", "scenarios/double_pendulum.toml", "--set", THREE_IMPACTS]
        command += ["--tolerance", "0.005", "--jobs", "1", "--json", "-o", str(study)]
        print(f"study: {shlex.join(command)}", flush=True)
        code = subprocess.run(command, check=False, stdout=subprocess.DEVNULL).returncode
        if code == 130:
            sys.exit(code)
    report = study / "converge.json"
    found = json.loads(report.read_text()) if report.exists() else {}
    return found if "variants" in found else None


def settling(study):
    """How far the impacts of the double pendulums depend on the resolution."""
    pages = "How far the impacts depend on the resolution, and why, stands in [Verification](verification.md#how-far-the-three-impacts-have-settled)"
    if study is None:
        return [f"{pages}; `--long` studies it here.", ""]
    rows = []
    for v in study["variants"]:
        changes = [
            " / ".join(
                "–" if i[q]["change"] is None else f"{100.0 * i[q]['change']:+.3f}"
                for q in ("start", "peak_force", "duration", "impulse")
            )
            for i in v["impacts"]
        ]
        rows.append([v["name"], *changes, *["–"] * (3 - len(changes))])
    head = ["variant", *(f"impact {i}: time / peak / duration / impulse" for i in (1, 2, 3))]
    return [
        "`fbimpact converge`, end after the third impact; changes in percent of the run as shipped:",
        "",
        table(head, rows),
        f"> {study['verdict']}",
        "",
        f"{pages}.",
        "",
    ]


def plot(folder, names, figure, target):
    files = [str(folder / f"{n}.h5") for n in names if (folder / f"{n}.h5").exists()]
    if not files:
        return
    scratch = folder / f"plots_{target}"
    command = [*PROGRAM, "plot", *files, "-o", str(scratch), "--svg", "--figure", figure]
    if subprocess.run(command, check=False, capture_output=True).returncode != 0:
        return
    found = sorted(scratch.rglob("*.svg"))
    if found:
        FIGURES.mkdir(exist_ok=True)
        (FIGURES / f"{target}.svg").write_bytes(found[0].read_bytes())


def main():
    arguments = [a for a in sys.argv[1:] if a != "--long"]
    is_long = "--long" in sys.argv[1:]
    if len(arguments) > 1 or any(a.startswith("-") for a in arguments):
        sys.exit("usage: scripts/reproduce_paper.sh [--long] [FOLDER]")
    folder = pathlib.Path(arguments[0] if arguments else "target/reproduction")
    folder.mkdir(parents=True, exist_ok=True)
    results = {}
    for name, scenario, settings, takes_long in RUNS:
        there = (folder / f"{name}.h5").exists()
        results[name] = run(folder, name, scenario, settings) if is_long or there or not takes_long else None
    plot(folder, ["chain_adaptive"], "energies", "chain_energies")
    plot(folder, ["chain_adaptive", "chain_quasistatic"], "forces", "chain_forces")
    plot(folder, ["pendulum_adaptive"], "energies", "pendulum_energies")
    plot(folder, ["pendulum_adaptive", "pendulum_hertz"], "forces", "pendulum_forces")
    models = ["pendulum_hertz", "pendulum_adaptive", "pendulum_quasistatic", "pendulum_damped"]
    models += ["pendulum_coarse_1e15", "pendulum_coarse_1e18"]
    plot(folder, models, "impacts", "pendulum_models")
    PAGE.write_text(page(results, converge(folder, is_long)))
    print(f"{PAGE} written")


if __name__ == "__main__":
    main()
